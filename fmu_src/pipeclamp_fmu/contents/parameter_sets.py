"""A law's parameters where its response is lower or higher, as its file tells how sure they are.

Of all that isn't known (the parameters' covariance, the scatter from run to run, what the form leaves over) the
likeliest combination is taken at which a quantity of the loop in the middle of the range lies at the end of its band: a
step of 1.96 C g / sqrt(g' C g) from the law, with the covariance C and the gradient g of the quantity's logarithm.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.signals import Role
from pipeclamp_models.law.compose import Composed
from pipeclamp_models.law.file import LawFile, law_of
from pipeclamp_models.realise.scalar_law import loaded

END = 1.96
"""Standard deviations from the middle to the end of a band that holds 95 %."""

DIFFERENCE_DEVIATIONS = 0.1
"""Of a standard deviation: the difference that a gradient is taken over."""

SAMPLES_PER_CYCLE = 200
"""Per cycle."""

LOSS, STIFFNESS = "dissipated energy", "stiffness"
ENDS = (
    ("lower_response", LOSS, 1, "the most damping, by which a pipe's peak is lowest"),
    ("upper_response", LOSS, -1, "the least damping, by which a pipe's peak is highest"),
    ("softest", STIFFNESS, -1, "the least stiffness, by which a pipe's peak lies at the lowest frequency"),
    ("stiffest", STIFFNESS, 1, "the most stiffness, by which a pipe's peak lies at the highest frequency"),
)
"""The sets beside the nominal one: name, quantity, which end of its band, what it is."""


@dataclass(frozen=True)
class ParameterSet:
    """Values of the law's coefficients.

    Attributes:
        name: of the set.
        meaning: one phrase.
        values: by the law's names.
        loss: energy that the clamp dissipates in a cycle in the middle of its range, mJ.
        stiffness: its force in phase with the displacement over that, N/mm.
    """

    name: str
    meaning: str
    values: Mapping[str, float]
    loss: float
    stiffness: float


@dataclass(frozen=True)
class ParameterSets:
    """The sets of a law, the nominal one first, and what to mind of them."""

    sets: tuple[ParameterSet, ...]
    cautions: tuple[str, ...]


def parameter_sets(file: LawFile, source: str, values: Mapping[str, float], where: Sequence[float]) -> ParameterSets:
    """Give a law's parameter sets.

    Args:
        file: the law.
        source: its generated source.
        values: of its coefficients, in the order in which the source takes them.
        where: A (mm), f (Hz), T (K) and further conditions of the loop that is looked at.
    """
    unknown, cautions = _unknown(file, values)
    measured = {
        name: _logarithms(source, unknown.at(values, name, DIFFERENCE_DEVIATIONS), where) for name in unknown.names
    }
    opposite = {
        name: _logarithms(source, unknown.at(values, name, -DIFFERENCE_DEVIATIONS), where) for name in unknown.names
    }
    sets = [_made("nominal", "the law as it was identified", source, values, where)]
    for name, quantity, side, meaning in ENDS:
        row = (LOSS, STIFFNESS).index(quantity)
        gradient = np.array(
            [(measured[n][row] - opposite[n][row]) / (2 * DIFFERENCE_DEVIATIONS) for n in unknown.names]
        )
        if not np.all(np.isfinite(gradient)) or not gradient.any():
            continue
        moved = unknown.covariance @ gradient
        steps = side * END * moved / math.sqrt(float(gradient @ moved))
        made = _made(name, meaning, source, unknown.moved(values, steps), where)
        if math.isfinite(made.loss) and math.isfinite(made.stiffness) and made.loss >= 0:
            sets.append(made)
        else:
            cautions = (*cautions, f"{name} is left out: the law has no sound loop there")
    return ParameterSets(tuple(sets), cautions)


@dataclass(frozen=True, eq=False)
class _Unknown:
    """What isn't known of a law, in standard deviations of each: names, sizes, their correlations.

    `scaled` names, for each share of the whole law, the coefficients that grow with it.
    """

    names: tuple[str, ...]
    sizes: Array
    covariance: Array
    scaled: Mapping[str, tuple[str, ...]]

    def at(self, values: Mapping[str, float], name: str, step: float) -> dict[str, float]:
        """Give the coefficients where one of them is off by so many standard deviations."""
        return self.moved(values, np.array([step if entry == name else 0.0 for entry in self.names]))

    def moved(self, values: Mapping[str, float], steps: Array) -> dict[str, float]:
        """Give the coefficients where each is off by so many standard deviations."""
        found = dict(values)
        for name, size, step in zip(self.names, self.sizes.tolist(), steps.tolist(), strict=True):
            if name not in self.scaled:
                found[name] += step * size
        for name, size, step in zip(self.names, self.sizes.tolist(), steps.tolist(), strict=True):
            for entry in self.scaled.get(name, ()):
                found[entry] *= math.exp(step * size)
        return found


def _unknown(file: LawFile, values: Mapping[str, float]) -> tuple[_Unknown, tuple[str, ...]]:
    """Give what isn't known of a law, and what its file doesn't tell or a set can't hold."""
    cautions = []
    told = file.covariance
    places = [place for place, name in enumerate(told.names) if name in values] if told else []
    matrix = np.array(told.matrix)[np.ix_(places, places)] if told and places else np.zeros((0, 0))
    sizes = np.sqrt(np.diag(matrix))
    kept = [place for place, size in enumerate(sizes.tolist()) if size > 0]
    names = [told.names[places[place]] for place in kept] if told else []
    if not names:
        cautions.append("the law's file holds no covariance: its parameters count as exact")
    sizes = sizes[kept]
    covariance = matrix[np.ix_(kept, kept)] / np.outer(sizes, sizes)
    scaled: dict[str, tuple[str, ...]] = {}
    if file.spread is None:
        cautions.append("the law's file doesn't tell what tests scatter about it: the sets are of its parameters alone")
    else:
        runs, form = file.spread.runs, file.spread.form
        shares: tuple[tuple[str, tuple[Role, ...], float], ...] = (
            ("share of the stiffness", ("stiffness",), math.hypot(runs.stiffness, form.stiffness)),
            ("share of the damping", ("damping", "slip"), math.hypot(runs.damping, form.damping)),
        )
        for share, roles, size in shares:
            grow = _growing(law_of(file).structure.equations_without_rig.composed, roles)
            if not grow:
                cautions.append(f"scatter of {size:.2g} in the {share} isn't in the sets: no coefficients scale it")
            elif size > 0:
                scaled[share] = grow
                sizes = np.append(sizes, size)
    count = len(names)
    whole = np.eye(count + len(scaled))
    whole[:count, :count] = covariance
    return _Unknown((*names, *scaled), sizes, whole, scaled), tuple(cautions)


def _growing(equations: Composed, roles: Sequence[Role]) -> tuple[str, ...]:
    """Give the parameters in proportion to which all coefficients of some roles grow, and nothing else; else none."""
    chosen: set[sp.Symbol] = set()
    parameters = {entry.symbol for entry in equations.parameters}
    of_roles = [entry.expression for entry in equations.coefficients if entry.role in roles]
    for expression in of_roles:
        within = sorted(expression.free_symbols & parameters, key=str)
        by_itself = [{symbol} for symbol in within]
        together = {symbol for symbol in within if not sp.diff(expression, symbol).has(symbol)}
        found = next((each for each in (*by_itself, together) if _proportional(expression, each)), None)
        if found is None:
            return ()
        chosen |= found
    others = [entry.expression for entry in equations.coefficients if entry.role not in roles]
    elsewhere = set().union(*(part.free_symbols for part in (*others, equations.force, *equations.within_steps)))
    if chosen & elsewhere or not all(_proportional(part, chosen & part.free_symbols) for part in of_roles):
        return ()
    return tuple(sorted(map(str, chosen)))


def _proportional(expression: sp.Expr, to: set[sp.Symbol]) -> bool:
    """Tell whether an expression is homogeneous of the first degree in some symbols."""
    slope = sum((sp.diff(expression, symbol) * symbol for symbol in to), sp.Integer(0))
    return bool(to) and sp.simplify(slope - expression) == 0


def _made(name: str, meaning: str, source: str, values: Mapping[str, float], where: Sequence[float]) -> ParameterSet:
    loss, stiffness = _loop(source, values, where)
    return ParameterSet(name, meaning, dict(values), loss, stiffness)


def _logarithms(source: str, values: Mapping[str, float], where: Sequence[float]) -> tuple[float, float]:
    """Give the logarithms of loss and stiffness; NaN where there is none."""
    loss, stiffness = (math.log(value) if value > 0 else math.nan for value in _loop(source, values, where))
    return loss, stiffness


def _loop(source: str, values: Mapping[str, float], where: Sequence[float]) -> tuple[float, float]:
    """Give loss (mJ) and stiffness (N/mm) along the second cycle from rest."""
    law = loaded(source, list(values.values()))
    A, f, *_ = where
    try:
        k = law.coefficients(*where)
        states: Sequence[float] = [start for _, start in law.states]
        loss = in_phase = before = force_before = 0.0
        for n in range(1, 2 * SAMPLES_PER_CYCLE + 1):
            theta = 2 * math.pi * n / SAMPLES_PER_CYCLE
            y, v = A * math.sin(theta), 2 * math.pi * f * A * math.cos(theta)
            force, _, states = law.step(k, states, before, y, v, 1 / (f * SAMPLES_PER_CYCLE))
            if n > SAMPLES_PER_CYCLE:
                loss += (force + force_before) / 2 * (y - before)
                in_phase += 2 / SAMPLES_PER_CYCLE * force * math.sin(theta)
            before, force_before = y, force
    except (ArithmeticError, ValueError):
        return math.nan, math.nan
    return loss, in_phase / A
