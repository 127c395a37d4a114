"""What a law leaves over beyond the harmonics that loops keep and that repeats with each cycle: steps and corners.

Evidence is told from the kept harmonics, to which the step of a friction at a reversal adds little in each. What lies
beyond them shows in the samples: what differs between cycles is scatter, what their errors have in common isn't.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_identification.campaign.reading import Campaign, Run
from pipeclamp_identification.comparison.concentration import region
from pipeclamp_identification.comparison.conditions import conditions_of
from pipeclamp_identification.comparison.sums import error_sums
from pipeclamp_identification.diagnosis.evidence import CHANCE_STANDARD_ERRORS
from pipeclamp_identification.fitting.misfit import RunMisfit, misfits
from pipeclamp_identification.loops.loops import HIGHEST_HARMONIC, Loops
from pipeclamp_identification.signals.harmonics import carried_harmonics, cycle_harmonics, evaluate
from pipeclamp_models.base.digits import newtons
from pipeclamp_models.law.law import Law

SHARPER = 0.1
"""Of the velocity within which a law smooths sgn v: where a law with so much of it errs less, the smoothing errs."""


@dataclass(frozen=True)
class BeyondHarmonics:
    """What repeats beyond the kept harmonics.

    Attributes:
        rms: N.
        share: the same as a share of the force noise per sample.
        sure_share: the same, less what scatter may have added to it by chance.
        where: the region of loop and conditions in which most of it lies, in words; empty where none stands out.
    """

    rms: float
    share: float
    sure_share: float
    where: tuple[str, ...]

    def words(self) -> str:
        """Say how large it is, where it sits, and what makes such."""
        where = f", most of it {', '.join(self.where)}" if self.where else ""
        return (
            f"beyond harmonic {HIGHEST_HARMONIC} the law errs by {newtons(self.rms)} that repeat with each cycle "
            f"({self.share:.2g} times the force noise){where}: the loop's steps or corners aren't the law's, as where "
            "friction turns over at a reversal, or a stop is met"
        )


def beyond_harmonics(law: Law, campaign: Campaign, loops: Loops) -> BeyondHarmonics:
    """Tell what a law leaves over beyond the kept harmonics that repeats with each cycle.

    What the smoothing of sgn v makes of it, which keeps a law's numbers finite, is no physics: of the law and the same
    with less smoothing, the one that errs less counts.

    Args:
        law: the law.
        campaign: its runs.
        loops: `loops_of(campaign)`.
    """
    found = [_found(one, campaign, loops) for one in (law, replace(law, v_r=SHARPER * law.v_r))]
    return min(found, key=lambda each: each.share)


def _found(law: Law, campaign: Campaign, loops: Loops) -> BeyondHarmonics:
    rest = tuple(map(_beyond, campaign.runs, misfits(law, campaign, loops)))
    common = [_common_square(run, one) for run, one in zip(campaign.runs, rest, strict=True)]
    square = sum(one for one, _ in common) / len(common)
    chance = CHANCE_STANDARD_ERRORS * math.hypot(*(error for _, error in common)) / len(common)
    noise = float(np.mean(loops.scatter_rms_N**2))
    share, sure_share = (math.sqrt(max(each, 0.0) / noise) for each in (square, square - chance))
    place = region(error_sums(campaign, loops, rest), [one for one in conditions_of(campaign, loops) if one.varies])
    return BeyondHarmonics(math.sqrt(max(square, 0.0)), share, sure_share, place.words if place else ())


def _beyond(run: Run, misfit: RunMisfit) -> RunMisfit:
    """Give a misfit less the error's harmonics in each cycle, those that its sampling carries of the kept ones."""
    phase = run.cycles.phase(run.record)
    bounds = run.cycles.bounds - run.cycles.bounds[0]
    count = min(HIGHEST_HARMONIC, carried_harmonics(phase, bounds))
    harmonics = cycle_harmonics(phase, bounds, [misfit.measured - misfit.computed], count)[0]
    ends = zip(harmonics, bounds[:-1], bounds[1:], strict=True)
    kept = np.concatenate([evaluate(own, phase[first:last]) for own, first, last in ends])
    return replace(misfit, computed=misfit.computed + kept)


def _common_square(run: Run, misfit: RunMisfit) -> tuple[float, float]:
    """Give the mean square of what cycles' errors have in common and its standard error, N2; zero of a single cycle.

    The product of two cycles' errors in the same part of the cycle has the common square for its mean, whatever each
    scatters.
    """
    bounds = run.cycles.bounds - run.cycles.bounds[0]
    cycles = len(bounds) - 1
    parts = int(np.min(np.diff(bounds)))  # a sample of each cycle, nearly
    cycle = np.repeat(np.arange(cycles), np.diff(bounds))
    place = cycle * parts + np.minimum((misfit.phase * (parts / (2 * np.pi))).astype(np.intp), parts - 1)
    samples = np.bincount(place, minlength=cycles * parts).reshape(cycles, parts)
    error = np.bincount(place, misfit.measured - misfit.computed, cycles * parts).reshape(cycles, parts)
    mean = np.divide(error, samples, out=np.zeros_like(error), where=samples > 0)
    shown = np.count_nonzero(samples, axis=0)
    several = shown > 1
    if not several.any():
        return 0.0, 0.0
    total, squares, pairs = (each[several] for each in (np.sum(mean, axis=0), np.sum(mean**2, axis=0), shown))
    products = (total**2 - squares) / (pairs * (pairs - 1))
    scatter = (squares - total**2 / pairs) / (pairs - 1)
    error_square = np.sum(2 * scatter**2 / (pairs * (pairs - 1))) / len(products) ** 2
    return float(np.mean(products)), math.sqrt(float(error_square))
