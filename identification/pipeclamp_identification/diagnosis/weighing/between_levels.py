"""What a law makes of conditions between those tested, told by levels that are left out.

A group of one amplitude and one frequency says little of a law between the levels: the other frequencies show the same
amplitude. So all runs of a level between others are left out, and the law is refitted to the rest. What it then errs
more on that level counts only as far as the rest insists on it: where the law as fitted to all disagrees with the rest
by no more than noise makes of a law of the right form, the rest only left open what the level tells.

What an effect takes may rest on one such level: a resonance between two frequencies can pass through the tests at a
third, whatever they are. Fitted to the others alone it then takes none of that.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from pipeclamp_identification.diagnosis.left_out import WithoutGroups
from pipeclamp_identification.diagnosis.noise import WhitenedObservations
from pipeclamp_identification.diagnosis.problem import CLOSELY, Judged, Problem
from pipeclamp_identification.diagnosis.thresholds import HALF_TAKEN_SHARE, MATERIAL_PART_SHARE, REAL_LACK_CHANCE
from pipeclamp_identification.fitting.joint.fitted import Fit
from pipeclamp_identification.fitting.least_squares import fit
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_identification.signals.chances import squares_of_chance
from pipeclamp_identification.signals.levels import SAME_KELVIN, SAME_SHARE, Level, number_levels
from pipeclamp_models.base.arrays import IntArray
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.law import Law
from pipeclamp_models.realise.force import force_of_law

SHARE_ERROR = 0.01
"""Error of the share of the way between two laws at which the rest of the tests begin to disagree."""


@dataclass(frozen=True)
class LeftOutLevel:
    """What a law errs more on a level when it is refitted without it.

    Attributes:
        condition: of which the level is one.
        level: its set point in words, with its unit.
        rms: N.
        share: the same as a share of the force noise per sample.
    """

    condition: str
    level: str
    rms: float
    share: float


@dataclass(frozen=True)
class InnerLevel:
    """A level between others.

    Attributes:
        condition: of which it is one.
        label: its set point in words, with its unit.
        rows: of the loops.
    """

    condition: str
    label: str
    rows: IntArray


def worst_level(law: Judged, problem: Problem) -> LeftOutLevel | None:
    """Give the level between others that a law foretells worst from the others; None where no level lies between."""
    found = []
    for level in (*_levels_between(problem.loops), *_further_levels_between(problem.loops)):
        there, here = _squares(law, problem, level.rows)
        square = max(there - here, 0.0)
        noise = float(np.mean(problem.loops.scatter_rms_N[level.rows] ** 2))
        rms, share = float(np.sqrt(square)), float(np.sqrt(square / noise))
        found.append(LeftOutLevel(level.condition, level.label, rms, share))
    return max(found, key=lambda each: each.share, default=None)


def rests_on(candidate: Judged, law: Judged, problem: Problem) -> InnerLevel | None:
    """Give the level between others on which most of what a law takes of another rests; None where none bears it.

    It does where the law takes most of its squares there, and, fitted to the other levels, no material part of what
    the other law errs there.

    Args:
        candidate: the law that takes it.
        law: the other.
        problem: the tests.
    """
    gain = np.sum(law.fitted.residual**2 - candidate.fitted.residual**2, axis=1)
    for level in _levels_between(problem.loops):
        if np.sum(gain[level.rows]) <= HALF_TAKEN_SHARE * np.sum(gain):
            continue
        before, after = (_squares(one, problem, level.rows)[0] for one in (law, candidate))
        if after > (1 - MATERIAL_PART_SHARE) * before:
            return level
    return None


def _levels_between(loops: Loops) -> Iterator[InnerLevel]:
    """Give each level of amplitude and frequency but the lowest and the highest."""
    for condition, unit, values in (("A", "mm", loops.amplitude_mm), ("f", "Hz", loops.frequency_Hz)):
        yield from _inner(condition, unit, number_levels(values, relative=SAME_SHARE), fewest=3)


def _further_levels_between(loops: Loops) -> Iterator[InnerLevel]:
    """Give each level of temperature, density and further conditions but the lowest and the highest.

    A bend describes what a further condition does, and takes three levels: without one of four they are left.
    """
    yield from _inner("T", "°C", number_levels(loops.temperature_K - CELSIUS, absolute=SAME_KELVIN), fewest=3)
    yield from _inner("density", "g/cm³", number_levels(loops.density_g_cm3, relative=SAME_SHARE), fewest=3)
    for name, values in loops.conditions.items():
        yield from _inner(name, "", number_levels(values, relative=SAME_SHARE), fewest=4)


def _inner(condition: str, unit: str, levels: Sequence[Level], fewest: int) -> Iterator[InnerLevel]:
    known = [level for level in levels if level.known]
    for level in known[1:-1] if len(known) >= fewest else ():
        yield InnerLevel(condition, f"{level.label} {unit}".strip(), level.rows)


def _squares(judged: Judged, problem: Problem, level: IntArray) -> tuple[float, float]:
    """Give the mean-square error on a level, N2, of the nearest law that the other runs agree with, and of the law.

    Args:
        judged: the law as fitted to all runs.
        problem: the data.
        level: rows of the level.
    """
    others = problem.observations.rows(np.setdiff1d(np.arange(len(problem.loops.run)), level))
    law = judged.result.law
    nearest = _nearest(law, others, _squares_by_chance(judged, problem, level))
    there, here = (_mean_square(one, problem, level, others) for one in (nearest, law))
    return there, here


def _squares_by_chance(judged: Judged, problem: Problem, level: IntArray) -> float:
    """Give the squares by which a law of the right form, fitted to all runs, may disagree with those of other levels.

    It is drawn to what noise makes of the level: each direction of the parameters by the share that the level has in
    what all runs tell of it. Such a weighed sum of squares is nearly a multiple of one with fewer degrees of freedom
    (Satterthwaite 1946). `REAL_LACK_CHANCE` says how rarely it is larger.
    """
    own = np.isin(np.arange(len(problem.loops.run)), level)
    shares = WithoutGroups(judged.result, problem.observations, problem.coarse, judged.fitted).shares(own)
    total, squared = float(np.trace(shares)), float(np.sum(shares * shares.T))
    if squared <= 0.0:
        return 0.0
    return squared / total * float(squares_of_chance(REAL_LACK_CHANCE, total**2 / squared))


def _nearest(law: Law, others: WhitenedObservations, by_chance: float) -> Law:
    """Give the nearest law that runs agree with: the law itself where they do with it, or are too few to be fitted.

    Args:
        law: as fitted to all runs.
        others: the runs.
        by_chance: the squares by which what they agree with may be less likely than what is fitted to them alone.
    """
    try:
        refitted = fit(law.structure, others, start=law.values, tolerance=CLOSELY)
    except UserError:
        return law
    most = _cost(refitted, law, others, 0.0) + by_chance

    def beyond(share: float) -> float:
        return _cost(refitted, law, others, share) - most

    if beyond(1.0) <= 0.0:
        return law
    return _between(refitted, law, float(brentq(beyond, 0.0, 1.0, xtol=SHARE_ERROR)))


def _between(refitted: Fit, law: Law, share: float) -> Law:
    """Give the law at a share of the way from a refit to the law as fitted to all."""
    values = {name: value + share * (law.values[name] - value) for name, value in refitted.law.values.items()}
    return replace(law, values=values)


def _cost(refitted: Fit, law: Law, others: WhitenedObservations, share: float) -> float:
    """Give the squares that a law between a refit and the law leaves of the runs it was refitted to, and of its priors.

    Args:
        refitted: the refit.
        law: as fitted to all.
        others: what it was refitted to.
        share: of the way.
    """
    residual = others.residual(force_of_law(_between(refitted, law, share), others.motion))
    way = np.array([law.values[name] - refitted.law.values[name] for name in refitted.fitted])
    priors = refitted.precision * (refitted.from_priors + share * way) ** 2
    return float(np.sum(residual**2) + np.sum(priors))


def _mean_square(law: Law, problem: Problem, level: IntArray, others: WhitenedObservations) -> float:
    """Give a law's mean-square error on a level, N2; groups have the factors that the others show."""
    left_out = problem.harmonics.rows(level)
    foretold = force_of_law(law, left_out.motion)
    if problem.factors is None:
        return float(np.mean(left_out.mean_squares(foretold)))
    factors = others.factors_beside(force_of_law(law, others.motion))
    explained = problem.factors.rows(level).beside(foretold).force(factors)
    return float(np.mean(left_out.mean_squares(foretold, explained)))
