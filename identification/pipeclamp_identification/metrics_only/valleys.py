"""Fits to metrics from several starts: a sum of squared logs has poor valleys, in which a fit from one start ends."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pipeclamp_identification.fitting.joint.fitted import Fit
from pipeclamp_identification.fitting.least_squares import fit
from pipeclamp_identification.metrics_only.observations import MetricObservations
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.law.law import Structure

CANDIDATE_TOLERANCE, ROUGH_TOLERANCE = 1e-7, 1e-4
"""Tolerances: of a candidate's fit; of one that serves to choose between starts, or begins where another ended."""
LEFT_OUT_TOLERANCE = 1e-6
"""Of a fit that foretells left-out conditions, as of records. It begins at the fit to all: one that ends roughly hardly
leaves it, and then its error on what was left out is that on what it was fitted to."""

ANOTHER_VALLEY_SHARE = 0.01
"""Fits whose costs differ by less than this share have ended in one valley, or in two that are as good."""


def fit_from_each(
    structure: Structure,
    observations: MetricObservations,
    starts: Sequence[Mapping[str, float]],
    tolerance: float,
    progress: Progress = silent,
) -> Fit:
    """Fit a law to metrics from each of several starts.

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
    first, *others = starts
    best = fit(structure, observations, start=first, tolerance=tolerance, progress=progress)
    for start in others:
        found = fit(structure, observations, start=start, tolerance=tolerance, progress=progress)
        if found.cost < best.cost * (1 - ANOTHER_VALLEY_SHARE):
            best = found
    return best


def sized_by_shares(
    structure: Structure, observations: MetricObservations, start: Mapping[str, float]
) -> Mapping[str, float]:
    """Give a start where a fit to the energies themselves ends, which finds how large each effect is.

    Args:
        structure, observations: as for `fit_from_each`.
        start: values that this fit starts from.
    """
    return fit(structure, observations.as_shares(), start=start, tolerance=ROUGH_TOLERANCE).law.values


def fit_to_metrics(
    structure: Structure,
    observations: MetricObservations,
    start: Mapping[str, float],
    tolerance: float,
    progress: Progress = silent,
) -> Fit:
    """Fit a law to metrics from a start as it is, and as a fit to the energies sizes it; see `fit_from_each`."""
    starts = (start, sized_by_shares(structure, observations, start))
    return fit_from_each(structure, observations, starts, tolerance, progress)
