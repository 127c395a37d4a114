"""Equations as an FMU steps them: what holds through a step is set apart, to be computed once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from pipeclamp_models.equations import symbols
from pipeclamp_models.equations.replacing import rebuilt, replaced
from pipeclamp_models.law.compose import FAST_SYMBOLS, Composed
from pipeclamp_models.law.law import Equations, Structure

CONDITIONS_FIRST = ("A", "f", "T")
"""Slow signals that every law has, in this order; further conditions follow by name."""

Definition = tuple[sp.Symbol, sp.Expr]


@dataclass(frozen=True, eq=False)
class Stepping:
    """A law without what belongs to the rig, split by how often its parts change.

    Attributes:
        equations: the composed law.
        coefficients: symbol and expression of each, in slow signals and parameters; only those that a step needs.
        held: what a step takes of slow signals and parameters: symbol, and expression in coefficients and parameters.
        stages: symbol and expression of what is computed on the way to the new states, in order; as the updates.
        after: the symbols of the states after a step.
        updates: the states after a step, in fast signals, states and what is held.
        force: N, in fast signals, states after the step and what is held.
        energy: stored, N mm; as the force.
    """

    equations: Composed
    coefficients: tuple[Definition, ...]
    held: tuple[Definition, ...]
    stages: tuple[Definition, ...]
    after: tuple[sp.Symbol, ...]
    updates: tuple[sp.Expr, ...]
    force: sp.Expr
    energy: sp.Expr


def conditions_of(equations: Composed | Equations) -> tuple[str, ...]:
    """Give the names of the slow signals that a law takes: A, f, T, then further conditions by name."""
    further = sorted({str(symbol) for symbol in equations.slow_signals} - set(CONDITIONS_FIRST))
    return (*CONDITIONS_FIRST, *further)


def parameter_symbols(equations: Composed) -> tuple[sp.Symbol, ...]:
    """Give the symbols of the parameters that travel: the law's, then v_r and y_r."""
    return (*(entry.symbol for entry in equations.parameters), symbols.v_r, symbols.y_r)


def stepping(structure: Structure) -> Stepping:
    """Give a structure's equations as they are stepped, reference values put in."""
    equations = structure.equations_without_rig.composed
    # Names of our own begin or end with an underscore, which no effect's symbol does.
    after = {state.symbol: sp.Symbol(f"_{state.symbol}", real=True) for state in equations.states}
    within = [exact(expression) for expression in equations.within_steps]
    results = [replaced(exact(expression), after) for expression in (equations.force, equations.energy)]
    names = [stage.symbol for stage in equations.stages]
    moving = FAST_SYMBOLS | after.keys() | set(after.values()) | set(names)
    held, (*within, force, energy) = held_apart([*within, *results], moving)
    stages = tuple(zip(names, within[: len(names)], strict=True))
    updates = tuple(within[len(names) :])
    needed = set().union(*(expression.free_symbols for _, expression in held))
    coefficients = [
        (entry.symbol, exact(entry.expression)) for entry in equations.coefficients if entry.symbol in needed
    ]
    return Stepping(equations, tuple(coefficients), tuple(held), stages, tuple(after.values()), updates, force, energy)


def exact(expression: sp.Expr) -> sp.Expr:
    """Put in the reference values, without loss; whole numbers stay whole, so that factors of 1 vanish."""
    return replaced(sp.sympify(expression), REFERENCES)


REFERENCES = {
    symbol: sp.Integer(value) if value == int(value) else sp.Float(repr(value), 17)
    for symbol, value in symbols.REFERENCES.items()
}


def held_apart(
    expressions: Sequence[sp.Expr], moving: frozenset[sp.Symbol] | set[sp.Symbol]
) -> tuple[list[Definition], list[sp.Expr]]:
    """Set apart the largest parts without a moving symbol.

    Of what a choice guards (a logarithm where its argument is positive, say) nothing is computed beforehand: it may
    have no value where the choice falls otherwise.

    Returns:
        symbol and expression of each part, and the expressions in these symbols.
    """
    found: dict[sp.Expr, sp.Symbol] = {}

    def held(part: sp.Expr) -> sp.Expr:
        if not part.free_symbols:
            return part
        if part not in found:
            found[part] = part if part.is_Symbol else _like(part, f"held_{len(found)}_")
        return found[part]

    def split(part: sp.Basic, guarded: bool) -> sp.Basic:
        still = not part.free_symbols & moving
        if part.is_Symbol:
            return held(part) if still else part
        if still and not guarded:
            return held(part)
        inside = guarded or isinstance(part, sp.Piecewise)
        arguments = list(part.args)
        if isinstance(part, sp.Add | sp.Mul) and not guarded:
            together = [argument for argument in arguments if not argument.free_symbols & moving]
            if len(together) > 1:
                rest = [argument for argument in arguments if argument.free_symbols & moving]
                return part.func(held(part.func(*together)), *(split(argument, guarded) for argument in rest))
        return rebuilt(part, [split(argument, inside) for argument in arguments]) if arguments else part

    reduced = [split(expression, False) for expression in expressions]
    return [(symbol, part) for part, symbol in found.items()], reduced


def _like(part: sp.Expr, name: str) -> sp.Symbol:
    """Give a symbol of which SymPy knows the sign that it knows of an expression."""
    if part.is_positive:
        return sp.Symbol(name, positive=True)
    return sp.Symbol(name, nonnegative=True) if part.is_nonnegative else sp.Symbol(name, real=True)
