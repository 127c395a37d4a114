"""Which effect a law lacks, or which test would tell."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeclamp.api.law import Law, opened
from pipeclamp.api.shown import (
    PathOrName,
    Shown,
    called_from_python,
    declarations_of,
    file_of,
    flag_of,
    frame_of,
    limits_of,
    processes,
)
from pipeclamp.api.tests import Tests, tested
from pipeclamp.show.view import View
from pipeclamp_identification.campaign.drive import write_drive
from pipeclamp_identification.workflow.auto import add_until_settled
from pipeclamp_identification.workflow.climb import Settled
from pipeclamp_identification.workflow.next_command import NEXT_TEST, next_command
from pipeclamp_identification.workflow.tests import Diagnosed
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.base.processes import Workers
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.declaration_files import read_declaration
from pipeclamp_models.law.file import NamedKind

if TYPE_CHECKING:
    from pipeclamp.pages.page import Report
    from pipeclamp_models.base.tables import pl


class Diagnosis(Shown):
    """Which effect a law lacks, or which test would tell.

    Attributes:
        law, tests: what was diagnosed; with `auto` the law that the ladder ended with, which no file holds yet.
        declared: a user's own effects that were candidates too.

    `diagnose` makes one; its example shows what it holds.
    """

    def __init__(
        self, law: Law, tests: Tests, found: Diagnosed, declared: dict[str, Declaration], settled: Settled | None = None
    ) -> None:
        self.law = law
        self.tests = tests
        self._found = found
        self._rungs = settled.words() if settled else []
        self._ladder = settled.ladder if settled else ()
        self._paths = {declaration.id: path for path, declaration in declared.items()}
        self.declared = tuple(declared.values())

    @property
    def verdict(self) -> str:
        """One of complete, missing, ambiguous, unknown."""
        return self._found.verdict

    @property
    def effects(self) -> tuple[str, ...]:
        """What is missing, or may be, as `add` takes it; best first."""
        return self._found.effects

    @property
    def kind(self) -> NamedKind | None:
        """How what is named is meant: as the cause, or as a part of what is missing."""
        return self._found.kind

    @property
    def together(self) -> tuple[str, ...]:
        """What is named first, and the effect without which it clearly takes nothing; empty where it does alone."""
        return tuple(self._found.together)

    @property
    def next_test(self) -> dict[str, Any] | None:
        """The test that would tell rivals apart, as --json gives it; None where there are none."""
        found: dict[str, Any] | None = self.to_dict()["next_test"]
        return found

    @property
    def ladder(self) -> list[dict[str, Any]]:
        """What `auto` did, rung by rung: effect, kind, error on left-out conditions before and after."""
        found: list[dict[str, Any]] = self.to_dict()["ladder"]
        return found

    def save_drive(self, path: PathOrName) -> Path:
        """Write the next test's drive signal, .csv or .parquet, whole or not at all, and give its path.

        Raises:
            UserError: no test is proposed, or it can't be written there.
        """
        if self._found.proposal is None:
            why = self._found.no_test or f"the verdict is {self.verdict!r}"
            raise UserError(f"save_drive: no test is proposed: {why}")
        with called_from_python(drive="save_drive"):
            target = file_of(path)
            write_drive(self._found.proposal.plan.signal(), target)
        return target

    @property
    def next_command(self) -> str:
        """The shell line to run next."""
        return next_command(self._found, self.law.origin, self.tests.origin, self._paths)

    @cached_property
    def _view(self) -> View:
        from pipeclamp.show.diagnosis_views import diagnosis_view

        with one_thread():
            view = diagnosis_view(self._found, self._ladder, self.next_command)
        view = replace(view, lines=[*self._rungs, *view.lines])
        return view if self.law.is_kept else replace(view, lines=[*view.lines, self._from_python()])

    def _from_python(self) -> str:
        """Say how to go on where no file holds the law, which the command reads."""
        then = ""
        if self.verdict == "missing":
            then = "; pc.add(law, answer, tests) does it from here"
        elif self._found.proposal is not None:
            then = f"; answer.save_drive('{NEXT_TEST}.csv') writes the drive signal from here"
        return f"  law.save({self.law.origin!r}) writes the law that it reads{then}"

    def view(self) -> View:
        """Give answer, tables and sentences, as `pipeclamp diagnose` tells them."""
        return self._view

    def page(self) -> Report:
        """Give the page, as `pipeclamp diagnose --report` writes it."""
        from pipeclamp.pages.page import Report
        from pipeclamp.pages.sections import diagnosis_page, diagnosis_title

        sections = diagnosis_page(self.law.file, self._found, self.next_command, self._ladder)
        return Report(*diagnosis_title(self.law.file, self.tests.name), sections)

    def to_frame(self) -> pl.DataFrame:
        """Give a row a candidate, best first: its error on left-out conditions, and the share that it explains."""
        return frame_of(self.to_dict()["candidates"])

    def __repr__(self) -> str:
        """Give law, tests and verdict."""
        effects = f": {', '.join(self.effects)}" if self.effects else ""
        return f"<diagnosis of {self.law.name} on {self.tests.name}: {self.verdict}{effects}>"


@called_from_python()
@one_thread()
def diagnose(
    law: Law | PathOrName,
    tests: Tests | PathOrName,
    *,
    auto: bool = False,
    limits: str = "",
    declared: Iterable[PathOrName] = (),
    jobs: int = 1,
    progress: Progress = silent,
) -> Diagnosis:
    """Find which effect a law lacks, or which test would tell.

    Args:
        law: the law, or its file or bundled name.
        tests: the tests, or their folder or bundled name.
        auto: add what is missing, again and again, while that lowers the error on left-out conditions; `answer.law` is
            the law that this ends with, `answer.ladder` how, and the verdict that of the end.
        limits: what the rig can do, for the next test: "A=0.1..2,f=0.5..20,T=20..300" (mm, Hz, °C).
        declared: declarations of your own effects by path (F.toml): candidates too.
        jobs: processes that share the work where that saves time; -1 for as many as there are cores.
        progress: is told what is being done.

    Raises:
        UserError: the tests can't serve the law.

    >>> from pipeclamp import identify, read_campaign
    >>> tests = read_campaign("clamp_a")
    >>> answer = diagnose(identify(tests), tests)
    >>> answer.verdict, answer.effects
    ('missing', ('damping_temperature',))
    >>> answer.next_command
    'pipeclamp add clamp_a.json damping_temperature clamp_a -o clamp_a_2.json'
    """
    known, tests = opened(law), tested(tests)
    own = {str(path): read_declaration(path) for path in declarations_of(declared)}
    reach = limits_of(limits)
    workers = Workers(processes(jobs), progress)
    if flag_of(auto, "auto"):
        command = f"pc.diagnose({known.name!r}, {tests.name!r}, auto=True)"
        settled = add_until_settled(
            known.file, tests.tests, command=command, declared=[*own.values()], limits=reach, workers=workers
        )
        return Diagnosis(Law(settled.with_diagnosis(tests.name)), tests, settled.found, own, settled)
    return Diagnosis(
        known, tests, tests.tests.diagnose(known.file, declared=own.values(), limits=reach, workers=workers), own
    )
