"""How what a verdict names is meant."""

from __future__ import annotations

from typing import Literal

Kind = Literal["cause", "part"]
"""A cause explains what is missing, and its form fits; a part takes so much of it, and something that acts alike may
stand behind it."""

NO_PROOF = "a part is no proof: something else that acts alike may stand behind it"
