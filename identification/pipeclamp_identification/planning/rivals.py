"""What the diagnosis would make of tests without noise: which effects it would try, and what these leave over.

An effect that bends as its shape changes takes another one's place far from its own typical shape; so rivals are
refitted, from the starts and by the screen of the diagnosis.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.diagnosis.candidates import MOST_FITTED
from pipeclamp_identification.diagnosis.noise import WhitenedObservations
from pipeclamp_identification.diagnosis.problem import CLOSELY, VALLEYS
from pipeclamp_identification.diagnosis.screen import candidate_names
from pipeclamp_identification.diagnosis.thresholds import (
    HALF_LEFT_SHARE,
    LARGER_MEMBER_SQUARES,
    UNEXPLAINED_SHARE,
    WORTH_CLOSELY_SHARE,
    WORTH_FITTING_SHARE,
)
from pipeclamp_identification.fitting.joint.fitted import Fit
from pipeclamp_identification.fitting.joint.points import linearised, starting_points
from pipeclamp_identification.fitting.joint.starts import Linearised
from pipeclamp_identification.fitting.least_squares import fit
from pipeclamp_identification.fitting.observations import LoopObservations
from pipeclamp_identification.fitting.refinement import refined_starts
from pipeclamp_identification.signals.real_harmonics import real_harmonics_of
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.catalogue import effect_id, find_effect
from pipeclamp_models.law.law import Law, with_effect
from pipeclamp_models.realise.force import force_of_law
from pipeclamp_models.realise.motion import Motion


@dataclass(frozen=True)
class TriedCatalogue:
    """What comes of trying the catalogue on tests in which an effect is hidden.

    Attributes:
        found: whether the effect itself is tried and comes back.
        nearest: the effect that is most like it: of the others, or the most promising one.
        others: the fits of other effects that leave less than half (rms) of what is missing, by name, best first.
    """

    found: bool
    nearest: str
    others: tuple[tuple[str, Fit], ...]


@dataclass(frozen=True)
class _Start:
    """An effect at one of its starts beside the base law: the point, and the law linearised there."""

    values: Mapping[str, float]
    step: Linearised


class Trial:
    """Tests of a law without noise, at some conditions, on which the catalogue is tried."""

    def __init__(self, bare: Law, motion: Motion, covariance: Array, count: int) -> None:
        """Prepare every effect at its starts.

        Args:
            bare: the base law.
            motion: R motions.
            covariance: of the harmonics that are measured, N2, shape (R, m, m).
            count: highest harmonic.
        """
        self._bare, self._motion, self._count = bare, motion, count
        self._error = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
        self._whitener = np.linalg.inv(np.linalg.cholesky(covariance))
        plain = self._observed(bare)
        self._starts: dict[str, list[_Start]] = {}
        for name in candidate_names(bare.structure, ()):
            try:
                structure = with_effect(bare.structure, name)
                points = starting_points(structure, plain, bare.values)
                self._starts[name] = [_Start(point, linearised(structure, plain, point)) for point in points]
            except UserError:  # it doesn't fit that base, or follows what isn't varied
                continue
        self._plain = plain.in_units(plain.loops.harmonics[None])

    def of(self, effect: str, law: Law) -> TriedCatalogue:
        """Give what comes of tests of a law with an effect."""
        seen = self._observed(law)
        structure = self._bare.structure
        missing = fit(structure, seen, start=self._bare.values, tolerance=CLOSELY).cost
        shown = (seen.in_units(seen.loops.harmonics[None]) - self._plain).ravel()
        promises = {}
        for name, starts in self._starts.items():
            costs = [
                Linearised(one.step.free, one.step.residual + shown, one.step.jacobian).cost_after_one_step()
                for one in starts
            ]
            order = np.argsort(costs, kind="stable")[:VALLEYS]
            promises[name] = missing - min(costs), [starts[place].values for place in order]
        best_first = sorted(promises, key=lambda name: -promises[name][0])[:MOST_FITTED]
        top = promises[best_first[0]][0]
        found, others = False, list[tuple[str, Fit]]()
        for name in best_first:
            promise, points = promises[name]
            if name != effect and (promise < WORTH_CLOSELY_SHARE * top or effect in find_effect(name).special_cases):
                continue
            tried = with_effect(structure, name)
            # an effect that isn't found may begin in a poor valley; that a rival does hides it from the diagnosis too
            points = points if name == effect else points[:1]
            result = min((fit(tried, seen, start=one, tolerance=CLOSELY) for one in points), key=lambda one: one.cost)
            if name == effect:
                found = promise >= WORTH_FITTING_SHARE * top and result.cost < UNEXPLAINED_SHARE**2 * missing
                continue
            result = self._grown(name, result, seen)
            if result.cost < HALF_LEFT_SHARE**2 * missing:
                others.append((result.law.structure.effects[-1], result))
        others.sort(key=lambda one: one[1].cost)
        promising = next(name for name in best_first if name != effect)
        return TriedCatalogue(found, effect_id(others[0][0]) if others else promising, tuple(others))

    def _grown(self, name: str, smaller: Fit, seen: WhitenedObservations) -> Fit:
        """Give the larger members of an effect where each does clearly better."""
        effect = smaller.law.structure.effect(name)
        if effect.refinement is None or not effect.refinement.at_once:
            return smaller
        structure = with_effect(smaller.law.structure, effect.refinement.name)
        starts = refined_starts(structure, effect, seen, smaller.law.values)
        larger = min((fit(structure, seen, start=one, tolerance=CLOSELY) for one in starts), key=lambda one: one.cost)
        if 2 * (smaller.cost - larger.cost) < LARGER_MEMBER_SQUARES:
            return smaller
        return self._grown(effect.refinement.name, larger, seen)

    def _observed(self, law: Law) -> WhitenedObservations:
        force = force_of_law(law, self._motion).force
        harmonics = LoopObservations(
            self._motion, real_harmonics_of(force, self._count), self._error, np.ptp(force, axis=1) / 2
        )
        return WhitenedObservations(harmonics, self._whitener)
