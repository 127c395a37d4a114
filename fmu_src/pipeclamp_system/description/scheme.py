"""The coupling schemes by name, and what is known of each."""

from __future__ import annotations

from typing import Literal

Scheme = Literal["parallel", "sequential", "implicit", "iterated"]

ORDER: dict[Scheme, int] = {"parallel": 1, "sequential": 1, "implicit": 2, "iterated": 2}
"""By which power of the macro step each scheme's error falls, for a law that is smooth."""

ROLLS_BACK: frozenset[Scheme] = frozenset(("implicit", "iterated"))
"""Schemes that save and restore states, and take the forces as linear over a step."""
