"""What a verdict can be, and how what it names is meant."""

from __future__ import annotations

from typing import Literal

Verdict = Literal["complete", "missing", "ambiguous", "unknown"]
Kind = Literal["cause", "part"]
"""A cause explains what is missing, and its form fits; a part takes so much of it, and something that acts alike may
stand behind it."""
