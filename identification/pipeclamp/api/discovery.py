"""A term that a law lacks and no catalogue has."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from pipeclamp.api.law import Law, opened
from pipeclamp.api.shown import PathOrName, Shown, called_from_python, declarations_of, file_of, processes
from pipeclamp.api.tests import Tests, tested
from pipeclamp.show.view import View
from pipeclamp_identification.discovery.proposal import TermProposal, toml_of
from pipeclamp_identification.workflow import discover as workflow
from pipeclamp_identification.workflow.next_command import after_discovery
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import refuse_ending, write_whole
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.base.processes import Workers
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.law.declaration_files import SUFFIX, read_declaration

if TYPE_CHECKING:
    from pipeclamp.pages.page import Report

COMMAND = "pipeclamp.discover"


class Discovery(Shown):
    """A term that was proposed, or why none was.

    Attributes:
        before, tests: the law and the tests.

    `discover` makes one; its example shows what it holds.
    """

    def __init__(self, before: Law, tests: Tests, found: TermProposal) -> None:
        self.before = before
        self.tests = tests
        self._found = found

    @property
    def proposed(self) -> bool:
        """Whether a term is proposed."""
        return self._found.proposed

    @property
    def formula(self) -> str | None:
        """What the best term adds, with its fitted values; None where no term came near."""
        return self._found.formula()

    @property
    def reason(self) -> str:
        """Why nothing is proposed; empty where something is."""
        return self._found.reason

    @property
    def instead(self) -> str | None:
        """Effect of the catalogue that passes what a term is asked where no term does; None where there is none."""
        return self._found.instead or None

    @cached_property
    def law(self) -> Law | None:
        """The law with the term, or with `instead`, which no file holds yet; None where there is neither."""
        return None if self._found.after is None else Law(self._found.after)

    def save(self, path: PathOrName) -> Path:
        """Write the term's declaration, TOML, whole or not at all.

        Raises:
            UserError: nothing is proposed, or it can't be written there.
        """
        if self._found.declaration is None:
            raise UserError(f"nothing is proposed: {self.reason}")
        target = file_of(path)
        refuse_ending(target, SUFFIX, "a declaration")
        write_whole(target, toml_of(self._found.declaration))
        return target

    @cached_property
    def _next(self) -> str:
        return after_discovery(self._found, self.before.origin, self.tests.origin, "effect.toml", None)

    def view(self) -> View:
        """Give what `pipeclamp discover` tells."""
        from pipeclamp.show.discovery import discovery_view

        return discovery_view(self._found, self._next)

    def page(self) -> Report:
        """Give the page, as `pipeclamp discover --report` writes it."""
        from pipeclamp.pages.discovery import discovery_page, discovery_title
        from pipeclamp.pages.page import Report

        files = [self.before.file, *([self._found.after] if self._found.after else [])]
        with one_thread():
            laws = [(file, self.tests.tests.compare(file)) for file in files]
        title = discovery_title(self.before.file, self.tests.name)
        return Report(*title, discovery_page(self._found, laws, self._next))

    def __repr__(self) -> str:
        """Give the tests and what is proposed."""
        return f"<discovery on {self.tests.name}: {self.formula if self.proposed else 'nothing proposed'}>"


@called_from_python()
@one_thread()
def discover(
    law: Law | PathOrName,
    tests: Tests | PathOrName,
    *,
    declared: Iterable[PathOrName] = (),
    jobs: int = 1,
    progress: Progress = silent,
) -> Discovery:
    """Propose a term that no catalogue has, where a law lacks one.

    Springs, dampers, elements that slip or creep, and factors on the law's coefficients are tried; none can create
    energy. What is proposed explains more than chance would at its best, comes back where the conditions are drawn
    again, foretells conditions that were kept back, and betters every effect of the catalogue beyond doubt. Where no
    term passes, an effect of the catalogue may that no diagnosis names: it joins the law as a part.

    Args:
        law: the law, or its file or bundled name.
        tests: records of sines in six groups of A and f or more, or their folder or bundled name.
        declared: declarations of your own effects by path (F.toml): they count as the catalogue's.
        jobs: processes that share the work where that saves time; -1 for as many as there are cores.
        progress: is told what is being done.

    Raises:
        UserError: the tests can't serve the law, or hold no records.

    >>> from pipeclamp import identify, read_campaign
    >>> tests = read_campaign("clamp_a")
    >>> answer = discover(identify(tests), tests)
    >>> answer.proposed, answer.reason
    (False, 'the catalogue has what is missing: damping_temperature; `add` it first')
    """
    known, tests = opened(law), tested(tests)
    declarations = [read_declaration(path) for path in declarations_of(declared)]
    found = workflow.discover(
        known.file, tests.tests, command=COMMAND, declared=declarations, workers=Workers(processes(jobs), progress)
    )
    return Discovery(known, tests, found)
