"""The house's units: mm, N, s, t, K; temperatures on their two scales."""

from __future__ import annotations

import re

CELSIUS = 273.15
"""0 °C in K."""
MASS = "t"
NANOKELVIN_DIGITS = 9
"""Decimals of a temperature; no thermometer has more."""


def celsius_of(kelvin: float) -> float:
    """Give a temperature in °C, without the bits that 273.15 leaves behind: 63.3, no 63.30000000000001."""
    return round(kelvin - CELSIUS, NANOKELVIN_DIGITS)


def grows_with_force(unit: str) -> bool:
    """Tell whether a parameter of this unit is in proportion to the force of its term: a force, stiffness or mass."""
    return unit.startswith("N") or unit == MASS


RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")


def unit_shown(unit: str) -> str:
    """Give a unit as files name it, N/mm3 or degC, as people read it: N/mm³, °C."""
    unit = unit.replace("degC", "°C").replace("degF", "°F")
    return re.sub(r"(?<=[A-Za-z])\^?(\d+)", lambda power: power[1].translate(RAISED), unit)
