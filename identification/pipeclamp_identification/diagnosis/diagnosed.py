"""A law diagnosed on records: the verdict in words, what is left over, and the test to run next."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from pipeclamp_identification.campaign.reading import Campaign
from pipeclamp_identification.comparison.compare import Comparison, compare
from pipeclamp_identification.diagnosis.limits import Limits
from pipeclamp_identification.diagnosis.next_test import NoTest, Proposal, next_test
from pipeclamp_identification.diagnosis.verdict import Diagnosis, Verdict, diagnose
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_models.base.progress import Progress
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import LawFile, structure_of

HEADLINES: dict[Verdict, str] = {
    "complete": "Complete: what is left is scatter.",
    "missing": "Missing: {}.",
    "ambiguous": "One of these is missing, and this data can't tell which: {}.",
    "unknown": "Something is missing, and nothing in the catalogue explains it.",
}


@dataclass(frozen=True)
class Diagnosed:
    """A law diagnosed on records.

    Attributes:
        diagnosis: the verdict and its evidence.
        comparison: the law as it is in its file, held against the tests.
        proposal: the test to run next, where rivals are left and one within the limits tells them apart.
        no_test: why there is none, where rivals are left.
    """

    diagnosis: Diagnosis
    comparison: Comparison
    proposal: Proposal | None
    no_test: str = ""

    @property
    def verdict(self) -> Verdict:
        """The verdict."""
        return self.diagnosis.verdict

    @property
    def effects(self) -> tuple[str, ...]:
        """What is missing, or may be, as `add` takes it; best first."""
        return self.diagnosis.effects

    def headline(self) -> str:
        """Give the verdict in words."""
        return HEADLINES[self.verdict].format(" or ".join(self.effects))

    def words(self) -> tuple[str, ...]:
        """Say why, and what the best law leaves over."""
        return (*self.diagnosis.reasons, *self.left_over())

    def left_over(self) -> tuple[str, ...]:
        """Say what the best law leaves over, beyond scatter."""
        diagnosis = self.diagnosis
        best, leftover = diagnosis.best, diagnosis.leftover
        if self.verdict == "complete":
            return ()
        if diagnosis.is_adequate(best):
            return leftover.lines
        law = f"with {' and '.join(best.effects)}" if best.effects else "as it is"
        left = f"the law {law} leaves {best.lack.share:.0%} of the force noise that follows the conditions"
        return (left, *leftover.words, *leftover.lines)

    def cautions(self) -> tuple[str, ...]:
        """Say what to mind of what was named: nothing, where there are records."""
        return ()


def diagnosed(
    file: LawFile,
    campaign: Campaign,
    loops: Loops | None = None,
    *,
    declared: Iterable[Declaration] = (),
    limits: Limits | None = None,
    jobs: int = 1,
    progress: Progress | None = None,
) -> Diagnosed:
    """Diagnose the law of a parameter file on a campaign, in so many processes; declared effects are candidates too.

    Args:
        file: the law.
        campaign: the tests.
        loops: `loops_of(campaign)`, where they are known already.
        declared: a user's own effects.
        limits: what the rig can do.
        jobs: processes; -1 for as many as there are cores.
        progress: is told what is being done.

    Raises:
        UserError: the data can't serve the law.
    """
    comparison = compare(file, campaign, loops)
    structure = structure_of(file).with_declared(declared)
    diagnosis = diagnose(structure, campaign, comparison.loops, jobs=jobs, progress=progress)
    found = next_test(diagnosis, limits)
    if isinstance(found, NoTest):
        return Diagnosed(diagnosis, comparison, None, found.words)
    return Diagnosed(diagnosis, comparison, found)
