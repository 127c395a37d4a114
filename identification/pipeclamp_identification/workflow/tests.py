"""Tests of whatever kind, records or metrics alone, and what can be done with them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from pipeclamp_identification.diagnosis.named import Naming
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.processes import ALONE, Workers
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.law.law import BASE_LAW, Structure
from pipeclamp_models.law.step import BeforeAfter

if TYPE_CHECKING:
    from pipeclamp_identification.campaign.drive import DrivePlan
    from pipeclamp_identification.campaign.seen import LeftOut
    from pipeclamp_identification.diagnosis.further_test.limits import Limits
    from pipeclamp_identification.fitting.identify import Method
    from pipeclamp_identification.metrics_only.campaign import MetricCampaign
    from pipeclamp_models.law.declaration import Declaration
    from pipeclamp_models.law.file import LawFile, Provenance


class Held(Protocol):
    """A law held against tests."""

    @property
    def nrmse(self) -> float:
        """Error over all runs, as a share."""


class Proposed(Protocol):
    """A test that would tell rivals apart."""

    @property
    def plan(self) -> DrivePlan:
        """What the machine is asked to do."""

    def words(self) -> str:
        """Say what to do."""

    def drive_words(self) -> str:
        """Say what the drive signal asks of the machine."""


class Diagnosed(Naming, Protocol):
    """A diagnosis: which effect a law lacks, or which test would tell."""

    @property
    def values(self) -> Mapping[str, float]:
        """Parameters of the law with what is named first, by name, for its fit to begin at.

        Where nothing is named, those of the law as it is, if it errs less by other values than its own; else empty.
        """

    @property
    def other_parts(self) -> Mapping[str, float]:
        """Effects that take a part too, as `add` takes them, and how much of what what is named first takes."""

    @property
    def calls_for_a_term(self) -> bool:
        """Whether a term beyond the catalogue is worth a search (`discover`)."""

    @property
    def leaves_means_open(self) -> bool:
        """Whether the law as it is leaves mean forces open: its error is without them, for it foretells none."""

    @property
    def proposal(self) -> Proposed | None:
        """The test to run next, where rivals are left and one within the limits tells them apart."""

    @property
    def no_test(self) -> str:
        """Why there is none, where rivals are left."""

    def headline(self) -> str:
        """Give the verdict in words."""

    def words(self) -> Sequence[str]:
        """Say why, and what is left over."""

    def rung(self) -> Sequence[str]:
        """Say what the effect that is named first takes, and what remains with it."""

    def refitted(self, before: float, after: float) -> Sequence[str]:
        """Say where refits show that it takes much less, by the errors on left-out conditions before and after."""

    def cautions(self) -> Sequence[str]:
        """Say what to mind of what was named."""


class Identified(Protocol):
    """A law fitted to tests."""

    @property
    def held(self) -> Held:
        """The law against the tests that it was fitted to."""

    def file(self, *, name: str, provenance: Provenance) -> LawFile:
        """Give its parameter file, by its name and how it comes about."""


@dataclass(frozen=True)
class RefittedLaw:
    """A law refitted with another structure.

    Attributes:
        fitted: the law.
        nrmse: error on the tests, before and after, as a share.
        heldout: error on groups of conditions that were left out, before and after.
        noise_nrmse: the scatter that no law can explain; None where it isn't known.
        few_settings: whether the tests have too few for their left-out ones to tell laws apart.
    """

    fitted: Identified
    nrmse: BeforeAfter
    heldout: BeforeAfter
    noise_nrmse: float | None
    few_settings: bool = False


class Tests(Protocol):
    """The loop tests of one clamp: records, or metrics alone."""

    @property
    def name(self) -> str:
        """The campaign's name."""

    @property
    def notes(self) -> str:
        """What its description says."""

    @property
    def left_out(self) -> Sequence[LeftOut]:
        """Runs that can't be used, and why."""

    @property
    def remarks(self) -> Sequence[str]:
        """What to know of the runs that are used."""

    @property
    def free_runs(self) -> Sequence[str]:
        """Names of the runs of free motion, which only a comparison takes."""

    @property
    def has_loops(self) -> bool:
        """Whether there are others."""

    def of_sines(self) -> Tests:
        """Give the tests without runs of free motion; a remark names them.

        Raises:
            UserError: there are no others.
        """

    def identify(
        self, structure: Structure = BASE_LAW, *, method: Method = "joint", progress: Progress = silent
    ) -> Identified:
        """Fit a law to all runs.

        Args:
            structure: of the law.
            method: "joint", or "surfaces", the paper's route by itself.
            progress: is told what is being done.

        Raises:
            UserError: the tests can't serve the law.
        """

    def per(self, column: str) -> Mapping[str, Tests]:
        """Give the tests of each group of a column of texts (specimen, valve, operator), by the group's name.

        Raises:
            UserError: there is no such column, or it doesn't group the runs.
        """

    def compare(self, file: LawFile) -> Held:
        """Hold a law against the tests.

        Raises:
            UserError: the law needs a condition that the tests don't state.
        """

    def record(self, run: str) -> Mapping[str, Array]:
        """Give the samples of a run's record by channel, in our units.

        Raises:
            UserError: there is no such run, or no record of it.
        """

    def metrics(self) -> MetricCampaign:
        """Give the loops by their metrics alone: what a table in a paper would have kept of them."""

    def refit(self, file: LawFile, structure: Structure, start: Mapping[str, float], progress: Progress) -> RefittedLaw:
        """Refit a law with another structure.

        Args:
            file: the law.
            structure: what is fitted in its place.
            start: values to start from, by name.
            progress: is told what is being done.

        Raises:
            UserError: the tests can't serve the structure.
        """

    def diagnose(
        self,
        file: LawFile,
        *,
        declared: Collection[Declaration] = (),
        limits: Limits | None = None,
        workers: Workers = ALONE,
    ) -> Diagnosed:
        """Find which effect a law lacks, or which test would tell.

        Args:
            file: the law.
            declared: a user's own effects: candidates too.
            limits: what the rig can do, for the next test.
            workers: who does it, and who is told.

        Raises:
            UserError: the tests can't serve the law.
        """

    def superfluous(self, file: LawFile, keep: str, progress: Progress) -> str | None:
        """Give the effect that a law does as well without; None where each is needed, or nothing can tell.

        Args:
            file: the law.
            keep: the effect that was added last, which isn't asked.
            progress: is told what is being done.

        Raises:
            UserError: the tests can't serve the law.
        """

    def without_spare_powers(self, file: LawFile, complete: bool, progress: Progress) -> Structure | None:
        """Give a law without the powers of the amplitude that its memory spares; None where it needs each.

        Args:
            file: the law.
            complete: whether nothing is missing.
            progress: is told what is being done.

        Raises:
            UserError: the tests can't serve the law.
        """

    def simpler_structure(self, file: LawFile, names: Collection[str], workers: Workers) -> Structure | None:
        """Give a law with an effect of fewer parameters, which acts alike and does as well, in the place of one.

        None where none does or can be told.

        Args:
            file: the law.
            names: the effects that are asked.
            workers: who does it, and who is told.

        Raises:
            UserError: the tests can't serve the law.
        """

    def better_structures(self, file: LawFile, names: Collection[str] | None, workers: Workers) -> list[Structure]:
        """Give a law with another effect of a family, or on other bases, where it does better on left-out conditions.

        Best first; empty where none does or can be told.

        Args:
            file: the law.
            names: its effects that are asked; None for all, and its base.
            workers: who does it, and who is told.

        Raises:
            UserError: the tests can't serve the law.
        """
