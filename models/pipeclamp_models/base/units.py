"""The house's units: mm, N, s, t, K; temperatures on their two scales."""

from __future__ import annotations

CELSIUS = 273.15
"""0 degC in K."""
MASS = "t"


def grows_with_force(unit: str) -> bool:
    """Tell whether a parameter of this unit is in proportion to the force of its term: a force, stiffness or mass."""
    return unit.startswith("N") or unit == MASS
