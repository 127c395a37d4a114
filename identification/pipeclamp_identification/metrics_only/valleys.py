"""Fits to metrics from several starts: a sum of squared logs has poor valleys, in which a fit from one start ends."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pipeclamp_identification.fitting.least_squares import Fit, fit
from pipeclamp_identification.metrics_only.evidence import ROUGHLY, MetricJudged, judged_fit
from pipeclamp_identification.metrics_only.observations import MetricObservations
from pipeclamp_models.base.progress import Progress
from pipeclamp_models.law.law import Structure

ANOTHER_VALLEY_SHARE = 0.01
"""Fits whose costs differ by less than this share have ended in one valley, or in two that are as good."""


def fit_to_metrics(
    structure: Structure,
    observations: MetricObservations,
    starts: Sequence[Mapping[str, float]],
    tolerance: float,
    progress: Progress | None = None,
) -> Fit:
    """Fit a law to logs of energies, from each start as it is, and from where a fit to the energies themselves ends.

    Args:
        structure: what is fitted.
        observations: the metrics.
        starts: values to start from, by name; the other parameters start where their effects say.
        tolerance: of the fits.
        progress: is told what is being done.

    Returns:
        The best fit, of equally good ones the first.

    Raises:
        UserError: there are fewer observations than free parameters.
    """
    shares = observations.as_shares()
    best: Fit | None = None
    for start in starts:
        sized = fit(structure, shares, start=start, tolerance=ROUGHLY, progress=progress).law.values
        for begin in (start, sized):
            found = fit(structure, observations, start=begin, tolerance=tolerance, progress=progress)
            if best is None or found.cost < best.cost * (1 - ANOTHER_VALLEY_SHARE):
                best = found
    assert best is not None
    return best


def judge_from_starts(
    effects: tuple[str, ...],
    structure: Structure,
    starts: Sequence[Mapping[str, float]],
    observations: MetricObservations,
    tolerance: float,
) -> MetricJudged:
    """Fit a structure to metrics from several starts and say what speaks against it; see `fit_to_metrics`.

    Args:
        effects: what the structure has beyond the law as it is.
        structure, starts, observations, tolerance: as for `fit_to_metrics`.
    """
    return judged_fit(effects, fit_to_metrics(structure, observations, starts, tolerance), observations)
