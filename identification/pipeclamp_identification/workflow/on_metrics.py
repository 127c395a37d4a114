"""Tests whose loops are known by their metrics alone: what can be done with them.

A diagnosis, and what only it needs, is imported where it is asked for: fits and comparisons start without.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from pipeclamp_identification.campaign.description import UNTIMED
from pipeclamp_identification.campaign.seen import LeftOut
from pipeclamp_identification.diagnosis.further_test.limits import Limits
from pipeclamp_identification.fitting.identify import Method
from pipeclamp_identification.fitting.joint.fitted import Fit
from pipeclamp_identification.fitting.least_squares import FIT_TOLERANCE
from pipeclamp_identification.metrics_only.campaign import SCATTER_BEFOREHAND, MetricCampaign, metric_observations
from pipeclamp_identification.metrics_only.law import (
    MetricComparison,
    compare_metrics,
    identify_metrics,
    metric_law_file,
    rms,
)
from pipeclamp_identification.metrics_only.valleys import fit_to_metrics
from pipeclamp_identification.workflow.tests import RefittedLaw
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.processes import ALONE, Workers
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import LawFile, Provenance, law_of
from pipeclamp_models.law.law import BASE_LAW, Structure
from pipeclamp_models.law.step import BeforeAfter

if TYPE_CHECKING:
    from pipeclamp_identification.metrics_only.diagnosed import MetricDiagnosed


@dataclass(frozen=True)
class FittedToMetrics:
    """A law fitted to metrics."""

    campaign: MetricCampaign
    fit: Fit

    @cached_property
    def held(self) -> MetricComparison:
        """The law against the metrics that it was fitted to."""
        return compare_metrics(self.file(name=self.campaign.name, provenance=Provenance("")), self.campaign)

    def file(self, *, name: str, provenance: Provenance) -> LawFile:
        """Give its parameter file, see `metrics_only.law.metric_law_file`."""
        return metric_law_file(self.fit, self.campaign, name=name, provenance=provenance)


@dataclass(frozen=True)
class MetricTests:
    """Tests known by metrics; errors are rms log ratios of dW and W."""

    campaign: MetricCampaign

    @property
    def name(self) -> str:
        """The campaign's name."""
        return self.campaign.name

    @property
    def notes(self) -> str:
        """What its description says."""
        return self.campaign.notes

    @property
    def left_out(self) -> Sequence[LeftOut]:
        """Runs that can't be used, and why."""
        return self.campaign.left_out

    @property
    def remarks(self) -> Sequence[str]:
        """What to know of the runs that are used: of metrics nothing, but where time was not measured."""
        return () if self.campaign.time_measured else (UNTIMED,)

    @property
    def free_runs(self) -> Sequence[str]:
        """Names of the runs of free motion: none, for metrics are of loops."""
        return ()

    @property
    def has_loops(self) -> bool:
        """Whether there are others: all."""
        return True

    def of_sines(self) -> MetricTests:
        """Give the tests without runs of free motion: as they are."""
        return self

    def identify(
        self, structure: Structure = BASE_LAW, *, method: Method = "joint", progress: Progress = silent
    ) -> FittedToMetrics:
        """Fit a law to all metrics, see `Tests.identify`."""
        if method != "joint":
            raise UserError(f"method {method}: {self.name} holds metrics without records; expected the joint method")
        found = identify_metrics(self.campaign, structure, progress=progress)
        return FittedToMetrics(self.campaign, found)

    def per(self, column: str) -> Mapping[str, MetricTests]:
        """Refuse: a law for each group is fitted to records, see `Tests.per`."""
        raise UserError(f"column {column!r}: these tests are metrics without records; expected records of the loops")

    def compare(self, file: LawFile) -> MetricComparison:
        """Hold a law against the metrics, see `Tests.compare`."""
        return compare_metrics(file, self.campaign)

    def record(self, run: str) -> Mapping[str, Array]:
        """Refuse: there are no records, see `Tests.record`."""
        raise UserError(f"run {run!r}: these tests are metrics without records; expected records of the loops")

    def metrics(self) -> MetricCampaign:
        """Give the metrics, see `Tests.metrics`."""
        return self.campaign

    def refit(self, file: LawFile, structure: Structure, start: Mapping[str, float], progress: Progress) -> RefittedLaw:
        """Refit a law with another structure, see `Tests.refit`; the scatter is the one that was expected."""
        from pipeclamp_identification.metrics_only.evidence import heldout_error

        law = law_of(file)
        observations = metric_observations(self.campaign)
        before = compare_metrics(file, self.campaign).nrmse
        progress("refit")
        result = fit_to_metrics(structure, observations, start, FIT_TOLERANCE, progress)
        progress("error on left-out conditions")
        heldout = BeforeAfter(
            heldout_error(law.structure, observations, law.values),
            heldout_error(structure, observations, result.law.values),
        )
        after = rms(observations.logs(result.law_force.force))
        fitted = FittedToMetrics(self.campaign, result)
        return RefittedLaw(fitted, BeforeAfter(before, after), heldout, SCATTER_BEFOREHAND)

    def diagnose(
        self,
        file: LawFile,
        *,
        declared: Collection[Declaration] = (),
        limits: Limits | None = None,
        workers: Workers = ALONE,
    ) -> MetricDiagnosed:
        """Find which effect a law lacks, see `Tests.diagnose`; so few numbers need one process only."""
        from pipeclamp_identification.metrics_only.diagnosed import metrics_diagnosed

        return metrics_diagnosed(file, self.campaign, declared=declared, limits=limits, workers=workers)

    def superfluous(self, file: LawFile, keep: str, progress: Progress) -> str | None:
        """Two numbers a run are too few to take effects out again by."""
        return None

    def without_spare_powers(self, file: LawFile, complete: bool, progress: Progress) -> Structure | None:
        """Two numbers a run are too few to hold powers by."""
        return None

    def simpler_structure(self, file: LawFile, names: Collection[str], workers: Workers) -> Structure | None:
        """Two numbers a run are too few to exchange an effect by."""
        return None

    def better_structures(self, file: LawFile, names: Collection[str] | None, workers: Workers) -> list[Structure]:
        """Two numbers a run are too few to exchange a base or an effect by."""
        return []
