"""A law diagnosed on records: the verdict in words, what is left over, and the test to run next."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

from pipeclamp_identification.campaign.reading import Campaign
from pipeclamp_identification.comparison.compare import Comparison, compare
from pipeclamp_identification.diagnosis.foretold import MEASURE_OF_SHARES, explained_share, refitted_share
from pipeclamp_identification.diagnosis.further_test.limits import Limits
from pipeclamp_identification.diagnosis.further_test.next_test import NoTest, Proposal, next_test
from pipeclamp_identification.diagnosis.further_test.run_apart import RunApart, run_apart
from pipeclamp_identification.diagnosis.named import (
    NO_PROOF,
    WITH,
    by_history,
    few_levels_words,
    unproved_of,
    untested_words,
)
from pipeclamp_identification.diagnosis.open_means import means_left_open
from pipeclamp_identification.diagnosis.problem import Prepared
from pipeclamp_identification.diagnosis.thresholds import FEWEST_GROUPS, PROMISED_SHARE, STILL_AS_GOOD
from pipeclamp_identification.diagnosis.verdict import Diagnosis, diagnose
from pipeclamp_identification.fitting.groups import Groups
from pipeclamp_identification.fitting.heldout import count_groups
from pipeclamp_identification.fitting.misfit import misfits, overall_nrmse
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_models.base.digits import newtons
from pipeclamp_models.base.processes import ALONE, Workers
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import LawFile, NamedKind, Verdict, law_of, structure_of
from pipeclamp_models.law.law import Structure

HEADLINES: dict[tuple[Verdict, NamedKind | None], str] = {
    ("complete", None): "Complete: what is left is {}.",
    ("missing", "cause"): "Missing: {}.",
    ("missing", "part"): "Part of what is missing: {}.",
    ("ambiguous", "cause"): "One of these is missing, and this data can't tell which: {}.",
    ("ambiguous", "part"): "One of these takes part of what is missing, and this data can't tell which: {}.",
    ("unknown", None): "Something is missing, and no effect of the catalogue can be named for it.",
}
SINGLE_CYCLES = (
    "each run holds one cycle: the noise meant is that between the samples of a cycle; how cycles scatter isn't known"
)
"""What is to be known of noise where no run shows how cycles scatter."""
COMPLETE_BUT_FOR_FORM = (
    "Complete, but for its form: what is left beside {} is small, and no effect of the catalogue takes most of it."
)
FITS_BUT_NOT_COMPLETE = "The law fits these tests as far as {} lets it, but it can't be called complete."


@dataclass(frozen=True)
class RecordDiagnosed:
    """A law diagnosed on records.

    Attributes:
        diagnosis: the verdict and its evidence.
        comparison: the law as it is in its file, held against the tests.
        limits: what the rig can do.
    """

    diagnosis: Diagnosis
    comparison: Comparison
    limits: Limits | None = None

    @cached_property
    def _next_test(self) -> Proposal | NoTest | None:
        """Sought where it is asked for: a ladder that goes on needs none."""
        return next_test(self.diagnosis, self.limits)

    @property
    def proposal(self) -> Proposal | None:
        """The test to run next, where rivals are left and one within the limits tells them apart."""
        return None if isinstance(self._next_test, NoTest) else self._next_test

    @property
    def no_test(self) -> str:
        """Why there is none, where rivals are left."""
        return self._next_test.words if isinstance(self._next_test, NoTest) else ""

    @property
    def verdict(self) -> Verdict:
        """The verdict."""
        return self.diagnosis.verdict

    @property
    def effects(self) -> tuple[str, ...]:
        """What is missing, or may be, as `add` takes it; best first."""
        return self.diagnosis.effects

    @property
    def kind(self) -> NamedKind | None:
        """How what is named is meant: as the cause, or as a part of what is missing."""
        return self.diagnosis.kind

    @property
    def values(self) -> Mapping[str, float]:
        """Parameters of the law with what is named first, by name; where nothing is, see `Diagnosed.values`."""
        named = self.diagnosis.found.named
        if named is None:
            return {} if self._errs_less is None else self.diagnosis.law.result.law.values
        return named.result.law.values

    @property
    def best_nrmse(self) -> float:
        """Error over all runs of the best law that was found; of the law as it is, by its file's values."""
        as_it_is = self.diagnosis.best is self.diagnosis.law
        return self.comparison.nrmse if as_it_is else overall_nrmse(self.diagnosis.best_misfits)

    @cached_property
    def _errs_less(self) -> float | None:
        """Error of the law as it is with the values by which it was judged; None where that is hardly less."""
        runs = misfits(self.diagnosis.law.result.law, self.comparison.campaign.of_sines(), self.diagnosis.loops)
        error = overall_nrmse(runs)
        return error if error * STILL_AS_GOOD < overall_nrmse(self.comparison.runs) else None

    @property
    def together(self) -> tuple[str, ...]:
        """What is named first, and the effect without which it clearly takes nothing; empty where it does alone."""
        named = self.diagnosis.found.named
        return () if named is None or len(named.effects) < 2 else named.effects

    @property
    def other_parts(self) -> Mapping[str, float]:
        """Effects that take a part too, as `add` takes them, and how much of what what is named first takes.

        Not those against which something speaks: what fits by a shape at its bounds stands for another one.
        """
        diagnosis = self.diagnosis
        most = diagnosis.explained or 1.0
        sound = (each for each in diagnosis.found.others if each.may_be_cause)
        return {each.effects[0]: explained_share(each, diagnosis.law) / most for each in sound}

    @property
    def calls_for_a_term(self) -> bool:
        """Whether a term beyond the catalogue is worth a search: nothing is named for what follows the conditions."""
        diagnosis = self.diagnosis
        if diagnosis.found.unstated is not None or diagnosis.found.bent is not None or self.verdict != "unknown":
            return False
        # what was taken off the records, or left out with them, isn't in what is left
        by_sensors = any(fault.done == "kept" for fault in self.comparison.campaign.faults)
        # what doesn't repeat with each cycle is in the noise, and more than that something else
        lines = diagnosis.leftover.not_periodic and diagnosis.law.lack.sure_share <= 1.0
        elsewhere = by_sensors or lines or diagnosis.is_adequate(diagnosis.law)
        enough = count_groups(diagnosis.problem.loops) >= FEWEST_GROUPS
        apart = self._run_apart is not None and not self._run_apart.at_a_corner
        return enough and not elsewhere and not apart

    @property
    def leaves_means_open(self) -> bool:
        """Whether the law as it is leaves mean forces open, by more than passes for form; see `Diagnosed`."""
        return means_left_open(self.diagnosis.law, self.diagnosis.problem).are_material

    def sensors(self) -> tuple[str, ...]:
        """Say which sensors failed or drift: that goes before any physics."""
        return tuple(fault.words for fault in self.comparison.campaign.faults)

    @cached_property
    def groups(self) -> tuple[Groups, ...]:
        """Groups of runs that differ beside the law as it is described, or can't be told from conditions."""
        return self.diagnosis.problem.groups_beside(self.diagnosis.described.result.law_force)

    def naming_a_part(self, reason: str) -> Self:
        """Give the same with what it names as the cause for a part, for this reason."""
        found = self.diagnosis.found.as_part(reason)
        return replace(self, diagnosis=replace(self.diagnosis, found=found))

    def naming_nothing(self, reason: str) -> Self:
        """Give the same with `unknown` for a verdict: what it named didn't help."""
        found = replace(
            self.diagnosis.found, verdict="unknown", effects=(), kind=None, named=None, others=(), reasons=(reason,)
        )
        return replace(self, diagnosis=replace(self.diagnosis, found=found))

    def headline(self) -> str:
        """Give the verdict in words."""
        adequate = self.diagnosis.is_adequate(self.diagnosis.law)
        if self.verdict == "complete" and not adequate:
            return COMPLETE_BUT_FOR_FORM.format(self._rest)
        if self.verdict == "unknown" and adequate:
            return FITS_BUT_NOT_COMPLETE.format(self._rest)
        named = WITH.join(self.together) or " or ".join(self.effects) or self._rest
        return HEADLINES[self.verdict, self.kind].format(named)

    def words(self) -> tuple[str, ...]:
        """Say why, and what is left over."""
        return (
            *self.reasons(), *self.other_values(), *self.untested(), *self.cautions(), *self.left_over(),
            *self.farthest_off(), *self.few_levels(),
        )  # fmt: skip

    @property
    def knows_scatter(self) -> bool:
        """Whether any run holds cycles that may scatter; otherwise noise is that between the samples of a cycle."""
        return any(self.diagnosis.loops.shows_scatter)

    @property
    def noise_name(self) -> str:
        """Name the noise that shares are of."""
        return "the noise" if self.knows_scatter else "the noise within a cycle"

    @property
    def _rest(self) -> str:
        """Name what no law explains."""
        return "scatter" if self.knows_scatter else "noise within a cycle"

    def reasons(self) -> tuple[str, ...]:
        """Say why the verdict is what it is, and which noise is meant where that isn't scatter."""
        return (*self.diagnosis.reasons, *(() if self.knows_scatter else (SINGLE_CYCLES,)))

    @property
    def _law_stays(self) -> bool:
        return self.verdict in ("complete", "unknown")

    def farthest_off(self) -> tuple[str, ...]:
        """Say where a law that stays as it is is farthest off for the force there."""
        return tuple(filter(None, [self.comparison.farthest_off])) if self._law_stays else ()

    def few_levels(self) -> tuple[str, ...]:
        """Say what a law that stays as it is does unasked between the levels of further conditions."""
        if not self._law_stays:
            return ()
        return few_levels_words(self.diagnosis.law.result.fitted_parameters, self.diagnosis.problem.loops.conditions)

    def other_values(self) -> tuple[str, ...]:
        """Say that the verdict on a law that stays is of other values of its parameters, which do better."""
        if not self._law_stays or self._errs_less is None:
            return ()
        error, own = f"{self._errs_less:.2%}", f"{overall_nrmse(self.comparison.runs):.2%}"
        return (
            f"the verdict is on other values of its parameters, with which the law errs by {error} of the force, "
            f"not {own}: `refit` fits it to these tests, or to these and its own where `join` puts both together",
        )

    def untested(self) -> tuple[str, ...]:
        """Say which condition has one value in all tests: of others no verdict can tell."""
        problem = self.diagnosis.problem
        return untested_words(problem.observations.motion.slow, timed=problem.loops.time_measured)

    def left_over(self) -> tuple[str, ...]:
        """Say what is left over beyond scatter: with what is named first, or else by the best law."""
        diagnosis = self.diagnosis
        described, leftover = diagnosis.described, diagnosis.leftover
        apart = (self._run_apart.words(),) if self._run_apart else ()
        if self.verdict == "complete":
            return apart
        if diagnosis.is_adequate(described):
            return (*apart, *leftover.words_of_lines)
        law = f"with {' and '.join(described.effects)}" if described.effects else "as it is"
        lack = described.lack
        times = f"{lack.share:.2g} times {self.noise_name}"
        left = f"the law {law} leaves {newtons(lack.rms)} that follow the conditions, {times}"
        return (left, *apart, *leftover.words, *leftover.words_of_lines)

    @cached_property
    def _run_apart(self) -> RunApart | None:
        """The run that holds most of what is left over, where one does."""
        return run_apart(self.diagnosis.described, self.diagnosis.problem)

    def rung(self) -> tuple[str, ...]:
        """Say what the effect that is named first takes, and what remains with it."""
        explained = self.diagnosis.explained
        if explained is None:
            return ()
        takes = f"{WITH.join(self.together or self.effects[:1])} takes {explained:.0%} of what was missing"
        named = f"{takes} ({MEASURE_OF_SHARES})"
        return (named, *(self.left_over() or (f"what remains is {self._rest}",))[:1])

    def refitted(self, before: float, after: float) -> tuple[str, ...]:
        """Say where refits show that the effect takes much less than its rung says, which is an estimate.

        Args:
            before: the law's error on left-out conditions, of fits without them, as a share of the force.
            after: the same with the effect.
        """
        explained = self.diagnosis.explained
        takes = refitted_share(self.diagnosis.law, before, after)
        if explained is None or takes >= PROMISED_SHARE * explained:
            return ()
        return (f"refitted without these conditions it takes {takes:.0%} of that: the estimate promised too much",)

    def cautions(self) -> tuple[str, ...]:
        """Say what to mind of what was named."""
        return (NO_PROOF,) if self.kind == "part" else ()


def diagnosed(
    file: LawFile,
    campaign: Campaign,
    loops: Loops | None = None,
    *,
    declared: Collection[Declaration] = (),
    limits: Limits | None = None,
    workers: Workers = ALONE,
    prepared: Callable[[Structure, Mapping[str, float]], Prepared] | None = None,
) -> RecordDiagnosed:
    """Diagnose the law of a parameter file on a campaign; declared effects are candidates too.

    What the law's file knows of its way counts too; see `named.by_history`.

    Args:
        file: the law.
        campaign: the tests.
        loops: `loops_of(campaign)`, where they are known already.
        declared: a user's own effects.
        limits: what the rig can do.
        workers: who does it, and who is told.
        prepared: gives `problem.prepare` of a structure and values to start from, where it may be known already.

    Raises:
        UserError: the data can't serve the law.
    """
    comparison = compare(file, campaign, loops)
    structure = structure_of(file).with_declared(declared)
    diagnosis = diagnose(
        structure, campaign, comparison.loops, start=law_of(file).values, proved=not unproved_of(file),
        workers=workers, prepared=prepared,
    )  # fmt: skip
    return by_history(RecordDiagnosed(diagnosis, comparison, limits), file, campaign.fingerprint, declared)
