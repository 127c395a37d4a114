"""Names of what laws depend on and are made of, and the reference values of their ratios."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Literal

from pipeclamp_models.base.units import CELSIUS

REFERENCES: Mapping[str, float] = {"A_0": 1, "f_0": 1, "T_0": 20 + CELSIUS, "v_0": 1, "rho_0": 2.286}
"""Reference values of ratios: 1 mm, 1 Hz, 293.15 K, 1 mm/s, and 2.286 g/cm3 (the paper's EMWM2)."""

Part = Literal["base", "clamp", "rig"]
"""What an effect belongs to: a base law, the clamp itself, or the rig that it was tested on."""
Role = Literal["stiffness", "damping", "slip", "sticking", "relaxation", "series"]
"""What a coefficient does, by which effects may scale it."""

CONDITION = "u_"
"""What the signal of a further column of runs.csv begins with, so that no column's name clashes with another symbol."""
OWN_SIGNALS: Mapping[str, str] = {"density_g_cm3": "rho", "first_cycle": "N"}
"""Columns of runs.csv that have a signal of their own; any other's is `condition_signal`."""


def condition_signal(column: str) -> str:
    """Name the slow signal of a further column of runs.csv."""
    return CONDITION + re.sub(r"\W", "_", column)


def signal_of(column: str) -> str:
    """Name the slow signal of a column of runs.csv beside A, f and T."""
    return OWN_SIGNALS.get(column, condition_signal(column))


def column_of(signal: str) -> str:
    """Name the column of runs.csv that a slow signal is of; A, f and T stay as they are."""
    own = {symbol: column for column, symbol in OWN_SIGNALS.items()}
    return own.get(signal, signal.removeprefix(CONDITION))


def signal_in_range(name: str) -> str:
    """Name the slow signal of a condition that a law's range names: by its signal, a further one by its column."""
    return name if name in ("A", "f", "T", *OWN_SIGNALS.values()) else condition_signal(name)


def size_of(signal: str) -> str:
    """Name the data's scale of a further column's signal: its largest absolute value."""
    return f"{signal}_size"
