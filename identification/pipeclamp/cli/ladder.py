"""A ladder climbed at the terminal: each rung is told as it is taken, and the best law so far is always on disk."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from pipeclamp.cli.terminal import errors, print_next, put
from pipeclamp_identification.workflow.auto import add_until_settled
from pipeclamp_identification.workflow.so_far import SoFar
from pipeclamp_models.base.errors import InterruptError
from pipeclamp_models.base.files import write_whole
from pipeclamp_models.base.processes import Workers
from pipeclamp_models.base.shell import shell_line
from pipeclamp_models.law.file import LawFile, law_text

if TYPE_CHECKING:
    from pipeclamp_identification.diagnosis.further_test.limits import Limits
    from pipeclamp_identification.workflow.climb import Settled
    from pipeclamp_identification.workflow.tests import Tests
    from pipeclamp_models.law.declaration import Declaration


def climbed(
    file: LawFile, tests: Tests, campaign: Path, output: Path, *, command: str, declared: Sequence[Declaration],
    limits: Limits | None, workers: Workers,
) -> Settled:  # fmt: skip
    """Climb until no step helps.

    Args:
        file: the law to begin with.
        tests: what it is held against.
        campaign: where they are.
        output: the law's file; it holds the best law so far after each rung, and the caller writes it at the end.
        command, declared, limits: as for `add_until_settled`.
        workers: who does it, and who is told, how far the ladder has come too.

    Raises:
        InterruptError: the user stopped it. The best law so far is in `output`, where there is one.
    """
    so_far = SoFar(
        workers.tell,
        keep=lambda law: write_whole(output, law_text(law)),
        say=lambda words: put(words, to=errors()),  # in logs too: it may take minutes
    )
    try:
        return add_until_settled(
            file, tests, command=command, declared=declared, limits=limits,
            workers=replace(workers, tell=so_far.doing), climbed=so_far.come,
        )  # fmt: skip
    except KeyboardInterrupt as stop:
        law = so_far.best
        if law is None:
            raise
        print_next(shell_line("diagnose", str(output), str(campaign), "--auto", str(output)))
        raise InterruptError(
            f"{output} holds the law so far, with {', '.join(law.effects) or 'no effects'}: {so_far.words()}"
        ) from stop
