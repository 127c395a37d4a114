"""Which test next, where only metrics are kept: the one whose dW and W differ most between rivals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_identification.campaign.drive import DrivePlan
from pipeclamp_identification.diagnosis.further_test.limits import Limits, drivable, limits_words, reach, stated_levels
from pipeclamp_identification.diagnosis.further_test.next_test import (
    LEVELS_OF_A_AND_F,
    LEVELS_OF_T,
    NoTest,
    rate_words,
    temperature_words,
)
from pipeclamp_identification.diagnosis.further_test.outlook import LEAST_DEVIATIONS, PROFILES, SINE
from pipeclamp_identification.loops.energies import loop_energies, metric_slopes
from pipeclamp_identification.metrics_only.campaign import SAMPLES_PER_CYCLE
from pipeclamp_identification.metrics_only.evidence import MetricJudged
from pipeclamp_identification.metrics_only.observations import MetricObservations
from pipeclamp_identification.metrics_only.verdict import MetricDiagnosis
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import Motion, sinusoids

ENOUGH_DEVIATIONS = 3.0
"""Standard deviations by which rivals should differ for dW and W of a test to be worth its time without its loop."""


@dataclass(frozen=True)
class MetricProposal:
    """A test and what its dW and W would tell.

    Attributes:
        amplitude_mm, frequency_Hz, temperature_C: its conditions; no temperature where that of the tests isn't known.
        separation: expected difference between the rivals' log dW and log W in standard deviations of scatter and
            doubt.
        rivals: names of the two that it separates.
        timed: whether the tests' time was measured: else the frequency is but that of one cycle a second.
    """

    amplitude_mm: float
    frequency_Hz: float
    temperature_C: float | None
    separation: float
    rivals: tuple[str, str]
    timed: bool

    @property
    def plan(self) -> DrivePlan:
        """What the machine is asked to do."""
        return DrivePlan(PROFILES[SINE], self.amplitude_mm, self.frequency_Hz)

    def drive_words(self) -> str:
        """Say what the drive signal asks of the machine."""
        return self.plan.words()

    def words(self) -> str:
        """Say what to do."""
        one, other = self.rivals
        test = (
            f"run a sine test at {self.amplitude_mm:.3g} mm{rate_words(self.frequency_Hz, self.timed)}, "
            f"{temperature_words(self.temperature_C)}: dW and W of {one} and {other} then differ by "
            f"{self.separation:.1f} standard deviations"
        )
        return (
            test if self.separation >= ENOUGH_DEVIATIONS else f"{test}; record its loop, which tells more than dW and W"
        )


def next_metric_test(
    diagnosis: MetricDiagnosis, limits: Limits | None = None, *, timed: bool = True
) -> MetricProposal | NoTest | None:
    """Give the sine that separates the two closest rivals of an ambiguous diagnosis best; None where there are none.

    Args:
        diagnosis: the ambiguous one.
        limits: what the rig can do.
        timed: whether the tests' time was measured.
    """
    if diagnosis.verdict != "ambiguous":
        return None
    rivals = diagnosis.found.laws[:2]
    names = [rival.effects[0] for rival in rivals]
    so_far = diagnosis.observations.motion
    within = reach(so_far, limits, timed=timed)
    A, f = drivable(
        PROFILES[SINE],
        np.geomspace(*within.amplitude, LEVELS_OF_A_AND_F),
        np.geomspace(*within.frequency, LEVELS_OF_A_AND_F),
        within,
    )
    T = stated_levels(np.linspace(*within.temperature, LEVELS_OF_T), *within.temperature)
    grid = np.array([(*pair, temperature) for pair in zip(A, f, strict=True) for temperature in T]).reshape(-1, 3)
    who = " and ".join(names)
    if not len(grid):
        return NoTest(f"no sine keeps all of {limits_words(within)}")
    motion = _motion(grid, diagnosis.observations)
    separation, peak = _separation(rivals, motion, diagnosis)
    if np.all(peak > within.force):
        return NoTest(f"no sine keeps all of {limits_words(within)}; it would take F=..{float(peak.min()):.3g}")
    row = int(np.argmax(np.where(peak <= within.force, separation, -1.0)))
    if separation[row] < LEAST_DEVIATIONS:
        return NoTest(
            f"no sine within {limits_words(within)} tells {who} apart by dW and W: they differ by at most "
            f"{separation[row]:.1f} standard deviations, and {LEAST_DEVIATIONS:g} are needed; record loops, which tell "
            "more than dW and W"
        )
    amplitude, frequency, temperature = (float(value) for value in grid[row])
    return MetricProposal(
        amplitude, frequency, None if "T" in so_far.assumed else temperature, float(separation[row]),
        (names[0], names[1]), timed,
    )  # fmt: skip


def _motion(grid: Array, tested: MetricObservations) -> Motion:
    """Give sinusoids at (A mm, f Hz, T degC), shape (R, 3); further conditions as in the middle run."""
    motion = sinusoids(grid[:, 0], grid[:, 1], grid[:, 2] + CELSIUS, SAMPLES_PER_CYCLE)
    further = {
        name: np.full((len(grid), 1), float(np.median(values)))
        for name, values in tested.motion.slow.items()
        if name not in motion.slow
    }
    return replace(motion, slow={**motion.slow, **further})


def _separation(rivals: Sequence[MetricJudged], motion: Motion, diagnosis: MetricDiagnosis) -> tuple[Array, Array]:
    """Give the Mahalanobis distance between two rivals' log dW and log W for each motion, and the largest force, (R,).

    Returns:
        the distances; the largest force that either foretells, N.
    """
    peak = np.zeros(len(motion.y))
    predicted, covariance = [], np.diag(diagnosis.scatter.share**2)[None]
    for rival in rivals:
        law, equations = rival.result.law, rival.result.equations
        law_force = force_of_equations(equations, law.vector(equations), (law.v_r, law.y_r), motion, derivatives=True)
        peak = np.maximum(peak, np.max(np.abs(law_force.force), axis=1))
        energies = np.stack(loop_energies(motion, law_force.force), axis=1)
        predicted.append(np.log(np.where(energies > 0, energies, np.nan)))
        slopes = metric_slopes(motion, law_force, rival.result.places)
        covariance = covariance + np.einsum("prm,pq,qrn->rmn", slopes, rival.result.covariance, slopes)
    difference = predicted[0] - predicted[1]
    squared = np.einsum("rm,rm->r", difference, np.linalg.solve(covariance, difference[:, :, None])[:, :, 0])
    return np.asarray(np.sqrt(np.maximum(np.nan_to_num(squared), 0.0))), peak
