"""Tests with records: what can be done with them.

What one of these alone needs (comparison, diagnosis, metrics) is imported where it is asked for: fits start without.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from pipeclamp_identification.campaign.reading import Campaign
from pipeclamp_identification.campaign.seen import LeftOut
from pipeclamp_identification.fitting.heldout import are_few_settings, refitted_nrmse
from pipeclamp_identification.fitting.identify import Identification, Method, fit_structure, identify, law_file
from pipeclamp_identification.fitting.misfit import known_noise, misfits, overall_nrmse
from pipeclamp_identification.fitting.observations import LoopObservations, loop_observations
from pipeclamp_identification.loops.loops import Loops, loops_of
from pipeclamp_identification.workflow.tests import RefittedLaw
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError, did_you_mean
from pipeclamp_models.base.processes import ALONE, Workers
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.base.toml_file import unknown
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import LawFile, Provenance, law_of
from pipeclamp_models.law.law import BASE_LAW, Law, Structure
from pipeclamp_models.law.range import rounded
from pipeclamp_models.law.step import BeforeAfter

if TYPE_CHECKING:
    from pipeclamp_identification.comparison.compare import Comparison
    from pipeclamp_identification.diagnosis.diagnosed import RecordDiagnosed
    from pipeclamp_identification.diagnosis.further_test.limits import Limits
    from pipeclamp_identification.diagnosis.problem import Prepared
    from pipeclamp_identification.diagnosis.revision import RevisedLaw
    from pipeclamp_identification.metrics_only.campaign import MetricCampaign


class KnownLaw(NamedTuple):
    """A law as its file holds it, to find by it what is known of the law."""

    structure: Structure
    values: tuple[tuple[str, float], ...]

    @classmethod
    def of(cls, structure: Structure, values: Mapping[str, float]) -> KnownLaw:
        """Give a law by its parameters' values, rounded as in a file."""
        return cls(structure, tuple((name, rounded(value)) for name, value in sorted(values.items())))


@dataclass(frozen=True)
class FittedToRecords:
    """A law fitted to records."""

    campaign: Campaign
    identification: Identification

    @cached_property
    def held(self) -> Comparison:
        """The law against the records that it was fitted to."""
        from pipeclamp_identification.comparison.compare import Comparison

        found = self.identification
        return Comparison(found.fit.law, self.campaign, found.loops, found.misfits, {})

    def file(self, *, name: str, provenance: Provenance) -> LawFile:
        """Give its parameter file, see `fitting.identify.law_file`."""
        file = law_file(self.identification, self.campaign, name=name, provenance=provenance)
        if not self.campaign.doubts:
            return file
        return file.model_copy(update={"data": file.data.model_copy(update={"warnings": self.campaign.doubts})})


@dataclass(frozen=True)
class RecordTests:
    """Tests with records."""

    campaign: Campaign

    @cached_property
    def loops(self) -> Loops:
        """The records of sines as loops, one row a run."""
        return loops_of(self.campaign)

    @cached_property
    def observations(self) -> LoopObservations:
        """The loops' harmonics, as fits take them."""
        return loop_observations(self.loops)

    @cached_property
    def _left_out_errors(self) -> dict[KnownLaw, float]:
        """Errors of laws on left-out conditions: a ladder's next step begins with the law that the last one made."""
        return {}

    @cached_property
    def _prepared(self) -> dict[KnownLaw, Prepared]:
        """The last law that was fitted for a diagnosis, or for asking it again: the other follows."""
        return {}

    @cached_property
    def sines(self) -> Campaign:
        """The campaign without runs of free motion, which all but a comparison leave out.

        Raises:
            UserError: it has no others.
        """
        return self.campaign.of_sines()

    def of_sines(self) -> RecordTests:
        """Give the tests without runs of free motion, see `Tests.of_sines`."""
        return self if self.sines is self.campaign else RecordTests(self.sines)

    @property
    def has_loops(self) -> bool:
        """Whether any run's motion is a sine."""
        return bool(self.campaign.runs)

    @property
    def free_runs(self) -> Sequence[str]:
        """Names of the runs of free motion."""
        return [run.name for run in self.campaign.free]

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
        """What to know of the runs that are used: faults of sensors, contradicted settings, a moving average."""
        return tuple(filter(None, (*self.campaign.remarks, self.campaign.smoothing.words())))

    def identify(
        self, structure: Structure = BASE_LAW, *, method: Method = "joint", progress: Progress = silent
    ) -> FittedToRecords:
        """Fit a law to all records of sines, see `Tests.identify`."""
        found = identify(self.sines, structure, method=method, progress=progress)
        return FittedToRecords(self.sines, found)

    def per(self, column: str) -> Mapping[str, RecordTests]:
        """Give the tests of each group, see `Tests.per`."""
        runs = self.sines.runs
        columns = list(dict.fromkeys(name for run in runs for name, text in run.setup.texts.items() if text))
        if column not in columns:
            raise UserError(
                f"column: got {column!r}; {did_you_mean(column, columns)}expected a column of texts in runs.csv, which "
                f"has {', '.join(columns) or 'none'}"
            )
        groups = sorted({run.setup.texts[column] for run in runs})
        if blank := [run.name for run in runs if not run.setup.texts[column]]:
            raise UserError(f"column {column!r}: blank for run {', '.join(blank[:5])}; fill it in in runs.csv")
        return {
            name: RecordTests(self.sines.of_runs(tuple(run for run in runs if run.setup.texts[column] == name)))
            for name in groups
        }

    def compare(self, file: LawFile) -> Comparison:
        """Hold a law against the records, see `Tests.compare`."""
        from pipeclamp_identification.comparison.compare import compare

        return compare(file, self.campaign, self.loops)

    def record(self, run: str) -> Mapping[str, Array]:
        """Give the samples of a run's record, see `Tests.record`; repaired where that could be."""
        records = {each.name: each.record for each in self.campaign.runs}
        records |= {each.name: each.record for each in self.campaign.free}
        if run not in records:
            raise UserError(unknown(run, list(records), "run"))
        return records[run].channels

    def metrics(self) -> MetricCampaign:
        """Give the loops by their metrics alone, see `Tests.metrics`."""
        from pipeclamp_identification.metrics_only.writing import as_metrics

        return as_metrics(self.sines, self.loops)

    def refit(self, file: LawFile, structure: Structure, start: Mapping[str, float], progress: Progress) -> RefittedLaw:
        """Refit a law with another structure, see `Tests.refit`."""
        law, sines = law_of(file), self.sines
        observations = self.observations
        progress("error of the law as it is")
        before = overall_nrmse(misfits(law, sines, self.loops))
        progress("refit")
        result = fit_structure(structure, self.loops, observations, start=start, progress=progress)
        runs = misfits(result.law, sines, self.loops)
        progress("error on left-out conditions")
        heldout = BeforeAfter(self._left_out_error(law), self._left_out_error(result.law))
        fitted = FittedToRecords(sines, Identification(result, self.loops, observations, runs, "joint"))
        nrmse, few = BeforeAfter(before, overall_nrmse(runs)), are_few_settings(self.loops)
        return RefittedLaw(fitted, nrmse, heldout, known_noise(runs, self.loops), few)

    def _left_out_error(self, law: Law) -> float:
        known = KnownLaw.of(law.structure, law.values)
        if known not in self._left_out_errors:
            self._left_out_errors[known] = refitted_nrmse(law, self.loops, self.observations)
        return self._left_out_errors[known]

    def _prepared_for(self, structure: Structure, values: Mapping[str, float]) -> Prepared:
        from pipeclamp_identification.diagnosis.problem import prepare

        known = KnownLaw.of(structure, values)
        if known not in self._prepared:
            self._prepared.clear()
            self._prepared[known] = prepare(structure, self.loops, values)
        return self._prepared[known]

    def diagnose(
        self,
        file: LawFile,
        *,
        declared: Collection[Declaration] = (),
        limits: Limits | None = None,
        workers: Workers = ALONE,
    ) -> RecordDiagnosed:
        """Find which effect a law lacks, see `Tests.diagnose`."""
        from pipeclamp_identification.diagnosis.diagnosed import diagnosed

        return diagnosed(
            file, self.sines, self.loops, declared=declared, limits=limits, workers=workers,
            prepared=self._prepared_for,
        )  # fmt: skip

    def superfluous(self, file: LawFile, keep: str, progress: Progress) -> str | None:
        """Give the effect that a law does as well without, see `Tests.superfluous`."""
        from pipeclamp_identification.diagnosis.revision import superfluous

        if set(file.effects) <= {keep}:
            return None
        return superfluous(self._asked(file), keep, progress)

    def without_spare_powers(self, file: LawFile, complete: bool, progress: Progress) -> Structure | None:
        """Give a law without the powers of the amplitude that it needn't have, see `Tests.without_spare_powers`."""
        from pipeclamp_identification.diagnosis.revision import without_spare_powers

        return without_spare_powers(self._asked(file), complete, progress)

    def simpler_structure(self, file: LawFile, names: Collection[str], workers: Workers) -> Structure | None:
        """Give a law with a simpler effect in the place of one, see `Tests.simpler_structure`."""
        from pipeclamp_identification.diagnosis.revision import simpler_structure

        return simpler_structure(self._asked(file), names, workers)

    def better_structures(self, file: LawFile, names: Collection[str] | None, workers: Workers) -> list[Structure]:
        """Give a law with one thing exchanged where it does better, see `Tests.better_structures`."""
        from pipeclamp_identification.diagnosis.revision import better_structures

        return better_structures(self._asked(file), names, workers)

    def _asked(self, file: LawFile) -> RevisedLaw:
        from pipeclamp_identification.diagnosis.revision import ask_again

        law = law_of(file)
        return ask_again(law, self.loops, self._prepared_for(law.structure, law.values))
