"""Running a study: on all cores or a cluster, resumable after a kill, into one Parquet file."""

from __future__ import annotations

import io
import json
import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from itertools import takewhile
from pathlib import Path
from types import FrameType

import joblib

from pipeclamp_models.base.errors import InterruptError, UserError
from pipeclamp_models.base.files import read_text, write_whole
from pipeclamp_models.base.processes import ignore_interrupts
from pipeclamp_models.base.tables import pl
from pipeclamp_system.study.case import Row, evaluate
from pipeclamp_system.study.description import Study

ANEW = "delete it to begin anew"

CasesDone = Callable[[int, int], None]
"""Told how many cases are done, of how many."""


def journal_of(output: Path) -> Path:
    """Give the file that keeps finished cases until all are done."""
    return output.with_name(output.name + ".journal")


def run_study(
    study: Study, output: Path, jobs: int = -1, scheduler: str | None = None, progress: CasesDone | None = None,
    stopping: Callable[[], None] | None = None,
) -> pl.DataFrame:  # fmt: skip
    """Run all cases that a journal beside the output doesn't hold yet, and write the output when all are done.

    Each finished case is written to the journal before the next is counted: after a kill the same call goes on, and
    evaluates only what isn't there. Ctrl-C lets the cases that run come to their end, a second one doesn't.

    Args:
        study: the study.
        output: the Parquet file; a row each case, in their order.
        jobs: processes; -1 for all cores.
        scheduler: address of a Dask scheduler that takes the cases instead.
        progress: told how many cases are done, of how many.
        stopping: told of the first Ctrl-C.

    Returns:
        the table that was written.

    Raises:
        UserError: the journal is another study's, the folder can't be written, or Dask isn't there.
        InterruptError: by Ctrl-C; what is finished is kept.
    """
    tell = progress or (lambda done, count: None)
    count, journal = study.description.count, journal_of(output)
    done = _finished(journal, study)
    tell(len(done), count)
    waiting = ((number, values) for number, values in study.cases() if number not in done)
    with (
        _opened(journal, study, fresh=not done) as stream,
        _backend(scheduler),
        _interrupted(stopping or (lambda: None)) as stop,
    ):
        calls = (joblib.delayed(evaluate)(study, *case) for case in takewhile(lambda case: not stop.is_set(), waiting))
        rows = joblib.Parallel(n_jobs=jobs, return_as="generator_unordered", pre_dispatch="2*n_jobs")(calls)
        try:
            for row in rows:
                stream.write(json.dumps(row) + "\n")
                stream.flush()
                os.fsync(stream.fileno())
                done[row["case"]] = row
                tell(len(done), count)
        except KeyboardInterrupt:
            with suppress(Exception):  # it ends the cases that run, which may object
                rows.close()
    if len(done) < count:
        raise InterruptError(
            f"{len(done)} of {count} cases are kept in {journal}; the same command goes on with the others"
        )
    frame = pl.from_dicts([done[number] for number in sorted(done)], infer_schema_length=None)
    content = io.BytesIO()
    frame.write_parquet(content)
    write_whole(output, content.getvalue())
    journal.unlink(missing_ok=True)  # another process that does the same study may have ended first
    return frame


@contextmanager
def _interrupted(tell: Callable[[], None]) -> Iterator[threading.Event]:
    """Give what the first Ctrl-C sets, and tell of it; a second one interrupts. Only the main thread hears signals."""
    stop = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield stop
        return
    before = signal.getsignal(signal.SIGINT)

    def first(number: int, frame: FrameType | None) -> None:
        signal.signal(signal.SIGINT, before)
        stop.set()
        tell()

    signal.signal(signal.SIGINT, first)
    try:
        yield stop
    finally:
        signal.signal(signal.SIGINT, before)


def _finished(journal: Path, study: Study) -> dict[int, Row]:
    """Read the cases of a journal; a last line that a kill has cut short doesn't count.

    Raises:
        UserError: it is another study's.
    """
    if not journal.exists():
        return {}
    first, *lines = read_text(journal, f"the cases of this study; {ANEW}").split("\n")
    if first != study.fingerprint:
        raise UserError(
            f"{journal}: holds cases of another study, or of files that have changed since; {ANEW}, "
            "or go on with the files that it was begun with"
        )
    try:
        rows = [json.loads(line) for line in lines[:-1]]
        return {int(row["case"]): row for row in rows}
    except (ValueError, LookupError, TypeError, RecursionError) as error:
        raise UserError(f"{journal}: holds what is no case of a study; {ANEW}") from error


@contextmanager
def _opened(journal: Path, study: Study, *, fresh: bool) -> Iterator[io.TextIOWrapper]:
    """Open a journal to go on; what a kill has cut short is taken off."""
    try:
        if fresh:
            journal.write_text(study.fingerprint + "\n", encoding="utf-8", newline="\n")
        else:
            # in its place: what is written anew is lost where a kill or a full disk comes between
            os.truncate(journal, journal.read_bytes().rindex(b"\n") + 1)
        stream = journal.open("a", encoding="utf-8", newline="\n")
    except OSError as error:
        raise UserError(
            f"{journal}: can't write there ({error.strerror}); expected a folder that is writable"
        ) from error
    with stream:
        yield stream


@contextmanager
def _backend(scheduler: str | None) -> Iterator[None]:
    """Use joblib's own processes, or a Dask cluster.

    Raises:
        UserError: Dask isn't installed, or no scheduler answers.
    """
    if scheduler is None:
        with joblib.parallel_config(backend="loky", initializer=ignore_interrupts):
            yield
        return
    try:
        from dask.distributed import Client
    except ImportError as error:
        raise UserError("--dask needs dask.distributed; expected: pip install 'pipeclamp[dask]'") from error
    try:
        client = Client(scheduler)
    except OSError as error:
        raise UserError(f"--dask {scheduler}: no scheduler answers there ({error})") from error
    with client, joblib.parallel_config(backend="dask"):
        yield
