"""Laws from loop metrics: fitted to dW and W of all runs at once, and held against them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.fitting.identify import data_source, file_of_fit, refuse_held
from pipeclamp_identification.fitting.joint.fitted import Fit
from pipeclamp_identification.fitting.least_squares import FIT_TOLERANCE
from pipeclamp_identification.metrics_only.campaign import MetricCampaign, metric_observations
from pipeclamp_identification.metrics_only.valleys import fit_to_metrics
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.law.file import OF_METRICS, FitQuality, LawFile, Provenance, RunQuality, law_of
from pipeclamp_models.law.law import BASE_LAW, Structure, find_base
from pipeclamp_models.law.range import intervals_of, outside_range, rounded
from pipeclamp_models.realise.force import force_of_law
from pipeclamp_models.realise.motion import refuse_unknown_conditions


def identify_metrics(campaign: MetricCampaign, structure: Structure = BASE_LAW, *, progress: Progress = silent) -> Fit:
    """Identify a law from the metrics of all runs.

    Args:
        campaign: the metrics.
        structure: of the law.
        progress: is told what is being done.

    Raises:
        UserError: an unknown base or effect, or metrics that can't determine the law.
    """
    if find_base(structure.base).terms == find_base("series").terms:
        raise UserError(
            f"base {structure.base!r}: {campaign.name} holds metrics without records, which can't choose the "
            "orders of a series; expected base power or memory"
        )
    refuse_held(structure)
    return fit_to_metrics(structure, metric_observations(campaign), {}, FIT_TOLERANCE, progress)


def metric_law_file(
    result: Fit,
    campaign: MetricCampaign,
    *,
    name: str,
    provenance: Provenance,
) -> LawFile:
    """Give the parameter file of a law fitted to metrics; arguments as for `identify.law_file`."""
    logs = metric_observations(campaign).logs(result.law_force.force)
    quality = FitQuality(
        method=OF_METRICS,
        nrmse=rounded(rms(logs)),
        runs=tuple(
            RunQuality(run=run.name, nrmse=rounded(rms(row))) for run, row in zip(campaign.runs, logs, strict=True)
        ),
        unsettled=int(np.count_nonzero(result.law_force.unsettled)) or None,
    )
    data = data_source(
        campaign.name, campaign.fingerprint, len(campaign.runs), campaign.left_out,
        time_measured=campaign.time_measured,
    )  # fmt: skip
    return file_of_fit(result, intervals_of(_columns(campaign)), data, quality, name=name, provenance=provenance)


def rms(logs: Array) -> float:
    """Give the root mean square of logs of ratios."""
    return float(np.sqrt(np.mean(logs**2)))


def _columns(campaign: MetricCampaign) -> dict[str, Array]:
    """Give the conditions by the names that a law's range has."""
    motion = metric_observations(campaign).motion
    setups = [run.setup for run in campaign.runs]
    further = {name: np.array([setup.conditions[name] for setup in setups]) for name in campaign.condition_columns}
    known = (name for name in ("A", "f", "T", "rho") if name not in motion.assumed)
    return {**{name: motion.slow[name][:, 0] for name in known}, **further}


@dataclass(frozen=True)
class MetricComparison:
    """A law held against metrics.

    Attributes:
        campaign: the metrics.
        logs: logs of measured over computed dW and W, shape (R, 2).
        outside: runs whose conditions lie outside the range the law was identified in, with what is outside.
    """

    campaign: MetricCampaign
    logs: Array
    outside: dict[str, str]

    @property
    def nrmse(self) -> float:
        """Rms of the logs of all ratios measured/computed: the error as a share."""
        return rms(self.logs)


def compare_metrics(file: LawFile, campaign: MetricCampaign) -> MetricComparison:
    """Hold the law of a parameter file against metrics.

    Raises:
        UserError: the law needs a condition that the campaign doesn't state.
    """
    law = law_of(file)
    observations = metric_observations(campaign)
    refuse_unknown_conditions(sorted(law.equations.slow_signals), observations.motion)
    logs = observations.logs(force_of_law(law, observations.motion).force)
    if not np.all(np.isfinite(logs)):
        run = campaign.runs[int(np.flatnonzero(~np.isfinite(logs).all(axis=1))[0])].name
        raise UserError(
            f"the law gives no finite dW and W above 0 for run {run!r}; expected conditions that are known and near "
            "the law's range"
        )
    return MetricComparison(
        campaign, logs, outside_range(file, [run.name for run in campaign.runs], _columns(campaign))
    )
