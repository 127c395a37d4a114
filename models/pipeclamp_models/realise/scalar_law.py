"""A law as plain Python, ready to be called as its FMU calls it. SymPy is for equations that weren't met before."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any

from pipeclamp_models.base.kept import kept
from pipeclamp_models.law.law import Law, Structure
from pipeclamp_models.steps.jumps import parts_of_step
from pipeclamp_models.steps.within_step import Step


@dataclass(frozen=True)
class ScalarLaw:
    """A generated law with its values; see `scalar.python_source`.

    Attributes:
        states: name and start of each.
        further: names of the slow signals that `coefficients` takes after A, f, T.
        coefficients: what holds through a step.
        step: force, stored energy and states after a move.
    """

    states: tuple[tuple[str, float], ...]
    further: tuple[str, ...]
    coefficients: Callable[..., Any]
    step: Step


def loaded(source: str, values: Sequence[float]) -> ScalarLaw:
    """Load a law's generated source with values for its parameters, as the FMU does."""
    scope = _executed(source)
    coefficients = partial(scope["coefficients"], tuple(values))
    return ScalarLaw(scope["STATES"], scope["CONDITIONS"], coefficients, scope["step"])


@lru_cache(maxsize=128)
def _executed(source: str) -> Mapping[str, Any]:
    """Give what a source defines: laws that differ in values alone have their functions in common."""
    scope: dict[str, Any] = {"math": math}
    exec(source, scope)
    return scope


def scalar_law(law: Law) -> ScalarLaw:
    """Give a law without what belongs to the rig."""
    return loaded(source_of(law.structure), parameter_values(law))


def source_of(structure: Structure) -> str:
    """Give what `scalar.python_source` writes of a structure, kept from one call to the next."""

    def write() -> str:
        from pipeclamp_models.realise.scalar import python_source

        return python_source(structure)

    return str(kept(f"python {structure.equations_without_rig.key}", write))


def parameter_values(law: Law) -> tuple[float, ...]:
    """Give the values of a law's parameters in the order of `stepping.parameter_symbols`."""
    return (*law.vector(law.structure.equations_without_rig), law.v_r, law.y_r)


def parts_of_law(law: Law, conditions: Mapping[str, float], A: float, f: float) -> int:
    """Give in how many parts an FMU of the law walks its steps: one where the law has no value in its range.

    Args:
        law: the law.
        conditions: the slow signals that it follows, by name, but A and f.
        A: largest amplitude in its range, mm.
        f: frequency, Hz.
    """
    if not law.equations.states:
        return 1
    scalar = scalar_law(law)
    T, *further = (conditions[name] for name in ("T", *scalar.further))
    rest = [start for _, start in scalar.states]
    try:
        return parts_of_step(scalar.step, scalar.coefficients(A, f, T, *further), rest, A, f)
    except (ArithmeticError, ValueError):
        return 1
