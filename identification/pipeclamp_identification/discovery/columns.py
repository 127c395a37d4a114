"""What each term would add to a law's residuals, one column a start of its parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import sympy as sp

from pipeclamp_identification.diagnosis.problem import Judged, Problem
from pipeclamp_identification.discovery.grammar import Term, linear_symbol
from pipeclamp_identification.discovery.shapes import RATE, STRENGTH
from pipeclamp_identification.fitting.joint.points import linearised
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.progress import Progress
from pipeclamp_models.base.signals import REFERENCES
from pipeclamp_models.equations.effect import Effect
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.law import with_effect
from pipeclamp_models.realise.array_source import ArrayPrinter
from pipeclamp_models.realise.force import LawForce, force_of_law
from pipeclamp_models.realise.motion import Motion
from pipeclamp_models.realise.sizes import data_sizes, number_of

MOST_SETTLING_CYCLES = 12
"""Cycles after which an element is taken for settled: one that slips is after one, one that relaxes slowly is not."""
SETTLED_SHARE = 1e-3
"""Share of its largest state by which it may still change from cycle to cycle."""
PROBE = "found_scaled"


@dataclass(frozen=True)
class TermColumn:
    """A term at one start of its parameters.

    Attributes:
        term: the term.
        values: its parameters, the strength or the rate aside.
        change: what a unit of the strength, or of the rate, adds to the whitened force, shape (R, m).
        signed: whether it may be negative.
    """

    term: Term
    values: Mapping[str, float]
    change: Array
    signed: bool


@dataclass(frozen=True)
class Evaluation:
    """A law on its tests, and what terms add to it.

    Attributes:
        problem: the tests.
        law: the law, fitted to them.
    """

    problem: Problem
    law: Judged

    @property
    def motion(self) -> Motion:
        """The motions, at the few points of the cycle that rough fits take."""
        return self.problem.coarse.motion

    @cached_property
    def law_force(self) -> LawForce:
        """The law's own force at these points."""
        return force_of_law(self.law.result.law, self.motion)

    @cached_property
    def sizes(self) -> Mapping[str, float]:
        """Sizes of the tests, in which starts are stated."""
        return data_sizes(self.motion, self.problem.observations.force_amplitude)

    @cached_property
    def known(self) -> dict[str, Any]:
        """What each symbol of an expression is on the motions."""
        law = self.law.result.law
        numbers = {**{str(name): value for name, value in REFERENCES.items()}, "v_r": law.v_r, "y_r": law.y_r}
        fast = {"y": self.motion.y, "v": self.motion.v, "y_previous": self.motion.y_previous, "h": self.motion.h}
        return {**numbers, **fast, **self.motion.slow}

    @cached_property
    def by_role(self) -> dict[str, Array]:
        """What it does to the whitened force to scale each role's coefficients, (R, m); of roles that the law has."""
        found = {}
        structure, values = self.law.result.law.structure, self.law.result.law.values
        for role in ("stiffness", "damping", "slip"):
            try:
                larger = with_effect(structure.with_declared([_probe(role)]), PROBE)
                step = linearised(larger, self.problem.coarse, {**values, RATE: 0.0})
            except UserError:
                continue
            if RATE in step.free:
                found[role] = -step.jacobian[:, step.free.index(RATE)].reshape(len(self.motion.y), -1)
        return found

    def whitened(self, force: Array) -> Array:
        """Give a force on the motions, N, shape (R, n), as the residuals show it, shape (R, m)."""
        observations = self.problem.coarse
        plain = observations.loops.transformed(force)
        plain[observations.loops.open_means(self.law_force), 0] = 0.0
        white = observations.in_units(plain[None])
        if observations.poolings is not None:
            white = observations.poolings.beside(self.law_force).without(white)
        return np.asarray(white[0])

    def columns(self, term: Term) -> list[TermColumn]:
        """Give a term at each of its starts; none where the law has nothing that it scales."""
        effect = term.effect
        count = max(len(one.starts) for one in effect.parameters)
        starts = [
            {one.name: number_of(one.starts[start % len(one.starts)], self.sizes) for one in effect.parameters}
            for start in range(count)
        ]
        return self.columns_at(term, starts)

    def columns_at(self, term: Term, points: Iterable[Mapping[str, float]]) -> list[TermColumn]:
        """Give a term at values of its parameters, by name; its strength, or rate, is one."""
        effect = term.effect
        linear = linear_symbol(term.family)
        own = [one.name for one in effect.parameters if one.name != linear]
        signed = term.family == "factor" or bool(np.isneginf(effect.parameters[0].lower))
        make = self._scaling(term, effect) if term.family == "factor" else self._force(effect)
        if make is None:
            return []
        found = []
        for point in points:
            values = {name: point[name] for name in own}
            change = make(values)
            if np.all(np.isfinite(change)) and np.any(change):
                found.append(TermColumn(term, values, change, signed))
        return found

    def _scaling(self, term: Term, effect: Effect) -> Callable[[Mapping[str, float]], Array] | None:
        (role, factor), *_ = effect.scales.items()
        direction = self.by_role.get(str(role))
        if direction is None:
            return None
        rate = sp.Symbol(RATE, real=True)
        slope = sp.diff(sp.log(factor), rate).subs(rate, 0)
        function = _function(slope)
        rows = len(self.motion.y)
        return lambda values: direction * np.broadcast_to(function(**self.known, **values), (rows, 1))

    def _force(self, effect: Effect) -> Callable[[Mapping[str, float]], Array]:
        force = _function(effect.force.subs(sp.Symbol(STRENGTH, real=True), 1))

        def change(values: Mapping[str, float]) -> Array:
            states = self._states(effect, values)
            shape = self.motion.y.shape
            return self.whitened(np.broadcast_to(force(**self.known, **values, **states), shape).astype(np.float64))

        return change

    def _states(self, effect: Effect, values: Mapping[str, float]) -> dict[str, Array]:
        """Walk a term's state along the cycle until it is periodic; shape (R, n), none where it has none."""
        if not effect.states:
            return {}
        (state,) = effect.states
        name = str(state.symbol)
        update = _function(state.update)
        moving = {key: value for key, value in self.known.items() if np.ndim(value) == 2 and value.shape[1] > 1}
        still = {
            key: value[:, 0] if np.ndim(value) == 2 else value for key, value in self.known.items() if key not in moving
        }
        now = np.zeros(len(self.motion.y))
        trajectory = np.empty_like(self.motion.y)
        for _ in range(MOST_SETTLING_CYCLES):
            before = now
            for place in range(trajectory.shape[1]):
                here = {key: value[:, place] for key, value in moving.items()}
                now = np.asarray(update(**still, **here, **values, **{name: now}), dtype=np.float64)
                trajectory[:, place] = now
            if np.max(np.abs(now - before)) <= SETTLED_SHARE * np.max(np.abs(trajectory)):
                break
        return {name: trajectory}


@lru_cache(maxsize=4096)
def _function(expression: sp.Expr) -> Callable[..., Any]:
    """Give an expression as a function of everything by name."""
    free = sorted(expression.free_symbols, key=str)
    compiled = sp.lambdify(free, expression, modules="numpy", printer=ArrayPrinter)
    names = [str(symbol) for symbol in free]
    return lambda **known: compiled(*(known[name] for name in names))


def _probe(role: str) -> Declaration:
    rate = {"symbol": RATE, "unit": "-", "meaning": "how much the logarithm changes", "start": 0.1, "neutral": 0.0}
    words = f"the law's {role} scaled"
    scale = {"coefficient": role, "factor": f"exp({RATE})"}
    return Declaration.model_validate(
        {"id": PROBE, "title": words, "looks_like": words, "parameters": (rate,), "scales": (scale,)}
    )


def weighed_anew(columns: Sequence[TermColumn], before: Evaluation, after: Evaluation) -> list[TermColumn]:
    """Give columns in the units of another evaluation of the same tests; those that say nothing in them go.

    Args:
        columns: in the units of the first.
        before: the first.
        after: the other.
    """
    if before.problem.factors is not None or after.problem.factors is not None:
        found = (after.columns_at(one.term, [one.values]) for one in columns)
        return [one for each in found for one in each]
    units = after.problem.coarse.whitener @ np.linalg.inv(before.problem.coarse.whitener)
    return [replace(one, change=np.einsum("rij,rj->ri", units, one.change)) for one in columns]


def all_columns(evaluation: Evaluation, terms: Sequence[Term], tell: Progress) -> list[TermColumn]:
    """Give the columns of all terms."""
    found: list[TermColumn] = []
    for place, term in enumerate(terms):
        if place % 50 == 0:
            tell(f"evaluate terms: {place} of {len(terms)}")
        found += evaluation.columns(term)
    return found


def beside_another_law(
    columns: Sequence[TermColumn],
    before: Evaluation,
    after: Evaluation,
    terms: Sequence[Term],
    tell: Progress,
) -> list[TermColumn]:
    """Give the columns of all terms beside another law: what adds a force adds the same, what scales it is evaluated.

    Args:
        columns: beside the first law.
        before: the first law on the tests.
        after: the other law on the same tests, in the same weights.
        terms: all terms.
        tell: is told what is being done.
    """
    if not _adds_the_same(before, after):
        return all_columns(after, terms, tell)
    known: dict[str, list[TermColumn]] = {}
    for column in columns:
        known.setdefault(column.term.declaration.id, []).append(column)
    found = (
        after.columns(term) if term.family == "factor" else known.get(term.declaration.id, []) for term in terms
    )  # fmt: skip
    return [column for each in found for column in each]


def _adds_the_same(before: Evaluation, after: Evaluation) -> bool:
    """Tell whether a force shows alike in the residuals of two laws: by groups' factors and open means it may not."""
    if before.problem is not after.problem or after.problem.factors is not None:
        return False
    one, other = before.law.result.law, after.law.result.law
    loops = after.problem.coarse.loops
    means = np.array_equal(loops.open_means(before.law_force), loops.open_means(after.law_force))
    return means and (one.v_r, one.y_r) == (other.v_r, other.y_r)
