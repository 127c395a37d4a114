"""What a job's process does: it reads files, calls the rooms below, and writes files whole."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from multiprocessing import connection as waiting
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.one_thread import one_thread_throughout

Result = Mapping[str, Any]


@dataclass(frozen=True)
class JobTask:
    """What a job is to do.

    Attributes:
        kind: name of a function of `pipeclamp.studio.tasks`.
        title: for people.
        command: the shell line that does the same.
        given: the function's arguments.
        law: the law that it is about, if any.
    """

    kind: str
    title: str
    command: str
    given: Mapping[str, Any]
    law: str | None = None


def process_of(task: JobTask, sending: Connection) -> BaseProcess:
    """Give a process for a task, not yet started; it sends what it does, and then what came out."""
    return multiprocessing.get_context("spawn").Process(
        target=_work, args=(task.kind, dict(task.given), sending), name=f"pipeclamp {task.kind}"
    )


def _work(kind: str, given: dict[str, Any], sending: Connection) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the studio's: it ends its jobs
    if hasattr(os, "setpgid"):
        os.setpgid(0, 0)
    threading.Thread(target=_end_with_the_studio, daemon=True).start()
    one_thread_throughout()

    def tell(what: str) -> None:
        sending.send(("says", what))

    try:
        sending.send(("done", _function(kind)(tell, **given)))
    except (UserError, OSError) as error:
        sending.send(("refused", str(error)))
    except Exception as error:
        traceback.print_exc(file=sys.stderr)
        sending.send(("failed", f"a defect of pipeclamp: {type(error).__name__}: {error}"))


def _function(kind: str) -> Callable[..., Result]:
    from pipeclamp.studio import discovering, on_pipe, tasks

    functions: dict[str, Callable[..., Result]] = {
        "identify": tasks.identify, "diagnose": tasks.diagnose, "add": tasks.add,
        "refit": tasks.refit, "climb": tasks.climb,
        "build": tasks.build, "look": tasks.look_into, "import": tasks.import_into,
        "discover": discovering.discover, "respond": on_pipe.respond, "report": tasks.report,
    }  # fmt: skip
    return functions[kind]


def _end_with_the_studio() -> None:
    """Wait for the studio's end, also by a kill, and end with it."""
    parent = multiprocessing.parent_process()
    if parent is None:
        return
    waiting.wait([parent.sentinel])
    end_with_children(os.getpid())
    os._exit(1)


def end_with_children(number: int) -> None:
    """End a job's process, by its number, with those that it started.

    Raises:
        OSError: it has ended, or hasn't made a group of its own yet.
    """
    if hasattr(os, "killpg"):
        os.killpg(number, signal.SIGKILL)
    else:  # Windows has no groups that a process could be made the head of afterwards
        subprocess.run(["taskkill", "/T", "/F", "/PID", str(number)], capture_output=True, check=False)
