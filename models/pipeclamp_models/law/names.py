"""The names that a user's expressions may use, and those that they may not take for symbols of their own."""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from pipeclamp_models.equations import symbols
from pipeclamp_models.law.expression import CONSTANTS, FUNCTIONS, WHERE

Signals = Mapping[str, sp.Expr]
FIXED: Signals = {str(symbol): symbol for symbol in (*symbols.REFERENCES, symbols.v_r, symbols.y_r)}
SLOW: Signals = {str(signal.symbol): signal.symbol for signal in symbols.SLOW}
SCALES: Signals = {str(symbol): symbol for symbol in (*symbols.SCALES, *symbols.REFERENCES)}
RESERVED = {
    **{str(signal.symbol): f"is the {signal.meaning}" for signal in (*symbols.FAST, *symbols.SLOW)},
    **dict.fromkeys((*FIXED, *SCALES), "has a meaning already"),
    **dict.fromkeys((*FUNCTIONS, WHERE, *CONSTANTS), "is a word of expressions"),
    "math": "is a word of the FMU's source",
}
