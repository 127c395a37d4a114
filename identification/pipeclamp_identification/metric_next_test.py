"""Which test next, where only metrics are kept: the one whose dW and W differ most between rivals."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp.realise.arrays import Array
from pipeclamp.response import Motion, respond, sinusoids
from pipeclamp.symbols import CELSIUS
from pipeclamp_identification.metric_campaign import SAMPLES
from pipeclamp_identification.metric_diagnosis import MetricDiagnosis
from pipeclamp_identification.metric_evidence import MetricJudged
from pipeclamp_identification.metric_observations import MetricObservations, loop_energies, metric_slopes
from pipeclamp_identification.next_test import LEVELS, Limits, reach, temperature_words
from pipeclamp_identification.screen import effect_id

SURELY = 3.0
"""Standard deviations by which rivals should differ for a test to be worth its time."""


@dataclass(frozen=True)
class MetricProposal:
    """A test and what its dW and W would tell.

    Attributes:
        amplitude_mm, frequency_Hz, temperature_C: its conditions; no temperature where that of the tests isn't known.
        separation: expected difference between the rivals' log dW and log W in standard deviations of scatter and
            doubt.
        rivals: names of the two that it separates.
    """

    amplitude_mm: float
    frequency_Hz: float
    temperature_C: float | None
    separation: float
    rivals: tuple[str, str]

    def words(self) -> str:
        """Say what to do."""
        one, other = self.rivals
        test = (
            f"run a sine test at {self.amplitude_mm:.3g} mm, {self.frequency_Hz:.3g} Hz, "
            f"{temperature_words(self.temperature_C)}: dW and W of {one} and {other} then differ by "
            f"{self.separation:.1f} standard deviations"
        )
        return test if self.separation >= SURELY else f"{test}; record its loop, which tells more than dW and W"


def next_metric_test(diagnosis: MetricDiagnosis, limits: Limits | None = None) -> MetricProposal | None:
    """Give the test that separates the two closest rivals of an ambiguous diagnosis best; None where there are none."""
    if diagnosis.verdict != "ambiguous":
        return None
    names = diagnosis.effects[:2]
    rivals = [next(one for one in diagnosis.candidates if effect_id(one.effects[0]) == name) for name in names]
    so_far = diagnosis.observations.motion
    within = reach(so_far, limits)
    grid = np.array(
        list(
            itertools.product(
                np.geomspace(*within.amplitude, LEVELS), np.geomspace(*within.frequency, LEVELS),
                np.unique(np.linspace(*within.temperature, 4)),
            )
        )
    )  # fmt: skip
    separation = _separation(rivals, _motion(grid, diagnosis.observations), diagnosis)
    row = int(np.argmax(separation))
    A, f, T = (float(value) for value in grid[row])
    temperature = None if "T" in so_far.assumed else T
    return MetricProposal(A, f, temperature, float(separation[row]), (names[0], names[1]))


def _motion(grid: Array, tested: MetricObservations) -> Motion:
    """Give sinusoids at (A mm, f Hz, T degC), shape (R, 3); further conditions as in the middle run."""
    motion = sinusoids(grid[:, 0], grid[:, 1], grid[:, 2] + CELSIUS, SAMPLES)
    further = {
        name: np.full((len(grid), 1), float(np.median(values)))
        for name, values in tested.motion.slow.items()
        if name not in motion.slow
    }
    return replace(motion, slow={**motion.slow, **further})


def _separation(rivals: Sequence[MetricJudged], motion: Motion, diagnosis: MetricDiagnosis) -> Array:
    """Give the Mahalanobis distance between two rivals' log dW and log W for each motion, shape (R,)."""
    predicted, covariance = [], np.diag(diagnosis.scatter.share**2)[None]
    for rival in rivals:
        law, equations = rival.result.law, rival.result.equations
        response = respond(equations, law.vector(equations), (law.v_r, law.y_r), motion, derivatives=True)
        energies = np.stack(loop_energies(motion, response.force), axis=1)
        predicted.append(np.log(np.where(energies > 0, energies, np.nan)))
        slopes = metric_slopes(motion, response, rival.result.places)
        covariance = covariance + np.einsum("prm,pq,qrn->rmn", slopes, rival.result.covariance, slopes)
    difference = predicted[0] - predicted[1]
    squared = np.einsum("rm,rm->r", difference, np.linalg.solve(covariance, difference[:, :, None])[:, :, 0])
    return np.asarray(np.sqrt(np.maximum(np.nan_to_num(squared), 0.0)))
