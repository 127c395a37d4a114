"""Diagnose and add, again and again, until the law is complete, ambiguous or beyond the catalogue."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from pipeclamp_identification.diagnosis.limits import Limits
from pipeclamp_identification.workflow.change import Addition, add_effect
from pipeclamp_identification.workflow.tests import Diagnosed, Tests, silent
from pipeclamp_models.base.progress import Progress
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import LawFile

MOST_EFFECTS = 8


@dataclass(frozen=True)
class Settled:
    """Where the repetition ended.

    Attributes:
        file: the law.
        found: the last diagnosis.
        additions: what was added on the way.
        cautions: what to mind of each addition.
        in_vain: what the last diagnosis named, where adding it didn't lower the error on left-out conditions.
    """

    file: LawFile
    found: Diagnosed
    additions: tuple[Addition, ...]
    cautions: tuple[tuple[str, ...], ...]
    in_vain: Addition | None = None

    def words(self) -> list[str]:
        """Say what each addition did to the error on left-out conditions, and what to mind of it."""
        words = []
        for one, cautions in zip(self.additions, self.cautions, strict=True):
            before, after = one.heldout
            words += [f"{one.effect}: error on left-out conditions {before:.2%} -> {after:.2%}"]
            words += [f"  {caution}" for caution in cautions]
        if self.in_vain:
            before, after = self.in_vain.heldout
            words.append(
                f"{self.in_vain.effect} was tried and not added: the error on left-out conditions didn't fall "
                f"({before:.2%} -> {after:.2%}); tests at further conditions would tell whether it is real"
            )
        return words


def add_until_settled(
    file: LawFile,
    tests: Tests,
    *,
    command: str,
    declared: Sequence[Declaration] = (),
    limits: Limits | None = None,
    jobs: int = 1,
    progress: Progress = silent,
    most: int = MOST_EFFECTS,
    seen: Callable[[Diagnosed, LawFile], None] = lambda found, file: None,
) -> Settled:
    """Add the missing effect and diagnose again, while one is missing and the error on left-out conditions falls.

    Args:
        file: the law to begin with.
        tests: records, or metrics alone.
        command, declared, limits, jobs, progress: as for `add_effect` and `Tests.diagnose`.
        most: effects that are added at most.
        seen: is given each diagnosis with its law.

    Raises:
        UserError: the data can't serve the law.
    """
    additions: list[Addition] = []
    cautions: list[tuple[str, ...]] = []
    while True:
        found = tests.diagnose(file, declared=declared, limits=limits, jobs=jobs, progress=progress)
        seen(found, file)
        if found.verdict != "missing" or len(additions) == most:
            return Settled(file, found, tuple(additions), tuple(cautions))
        addition = add_effect(
            file, found.effects[0], tests, command=command, date=file.date, declared=declared, progress=progress
        )
        if addition.heldout[1] >= addition.heldout[0]:
            return Settled(file, found, tuple(additions), tuple(cautions), in_vain=addition)
        additions.append(addition)
        cautions.append(tuple(found.cautions()))
        file = addition.after
