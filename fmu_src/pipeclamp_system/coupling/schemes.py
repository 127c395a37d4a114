"""Coupling schemes by name, and what a participant that can't roll back leaves of them."""

from __future__ import annotations

from pipeclamp_system.coupling.broyden import SolverTolerance
from pipeclamp_system.coupling.implicit import LinearlyImplicit
from pipeclamp_system.coupling.iterated import Iteration
from pipeclamp_system.coupling.march import Advance, Explicit, System
from pipeclamp_system.description.scheme import ROLLS_BACK, Scheme


def advance_of(scheme: Scheme, system: System, tolerance: SolverTolerance, *, locates: bool = True) -> Advance:
    """Give a scheme for a system; the tolerance, and whether it locates steps of force, are for the iterated one."""
    if scheme == "iterated":
        return Iteration(system, tolerance, locates=locates)
    if scheme == "implicit":
        return LinearlyImplicit(system)
    return Explicit(system, sequential=scheme == "sequential")


def best_allowed(scheme: Scheme, can_roll_back: bool) -> Scheme:
    """Give the scheme, or the best one that works without roll-back."""
    return "sequential" if scheme in ROLLS_BACK and not can_roll_back else scheme
