"""Jobs: long work, each in a process of its own that can be stopped and that ends with the studio."""

from __future__ import annotations

import asyncio
import itertools
import multiprocessing
import threading
import time
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any

from pipeclamp.studio.work import JobTask, end_with_children, process_of
from pipeclamp_models.base.errors import UserError

MOST_RUNNING = 2
MOST_REMEMBERED = 30
HEARTBEAT_s = 15.0
"""So often something is sent, so that a page that went away is noticed."""


@dataclass
class Job:
    """A piece of work.

    Attributes:
        number: its name.
        project: key of the campaign that it belongs to.
        task: what is done.
        state: running, done, refused (a user's mistake), failed (ours), cancelled.
        stopped: whether it was asked to end.
        says: what is being done, or why it was refused.
        result: what it gave, when done.
    """

    number: int
    project: str
    task: JobTask
    state: str = "running"
    stopped: bool = False
    says: str = "starting"
    result: Mapping[str, Any] = field(default_factory=dict)
    began: float = field(default_factory=time.monotonic)
    ended: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """Give it as the page reads it."""
        return {
            "number": self.number,
            "project": self.project,
            "kind": self.task.kind,
            "title": self.task.title,
            "command": self.task.command,
            "law": self.task.law,
            "state": self.state,
            "says": self.says,
            "seconds": round((self.ended or time.monotonic()) - self.began, 1),
            "result": dict(self.result),
        }


class Jobs:
    """All jobs; what changes is told to whoever listens."""

    def __init__(self) -> None:
        """Begin without any."""
        self._jobs: dict[int, Job] = {}
        self._processes: dict[int, BaseProcess] = {}
        self._numbers = itertools.count(1)
        self._lock = threading.Lock()
        self._listeners: set[tuple[asyncio.AbstractEventLoop, asyncio.Event]] = set()

    def start(
        self,
        project: str,
        task: JobTask,
        when_done: Callable[[Job], None],
        when_over: Callable[[Job | None], None] = lambda _: None,
    ) -> Job:
        """Start a task.

        Args:
            project: key of the campaign that it belongs to.
            task: what to do.
            when_done: is called with a job that has been done, before anybody is told so.
            when_over: is called after it with the job, whatever came of it; with None where it wasn't begun.

        Raises:
            UserError: as many as may run at once are running.
        """
        with self._lock:
            if len(self._processes) >= MOST_RUNNING:
                when_over(None)
                raise UserError(f"{MOST_RUNNING} jobs are running; wait for one, or cancel it")
            job = Job(next(self._numbers), project, task)
            receiving, sending = multiprocessing.get_context("spawn").Pipe(duplex=False)
            process = process_of(task, sending)
            process.start()
            sending.close()
            self._jobs[job.number] = job
            self._processes[job.number] = process
            for old in list(self._jobs)[:-MOST_REMEMBERED]:
                if old not in self._processes:
                    del self._jobs[old]
        threading.Thread(target=self._follow, args=(job, process, receiving, when_done, when_over), daemon=True).start()
        self._tell()
        return job

    def _follow(
        self,
        job: Job,
        process: BaseProcess,
        receiving: Connection,
        when_done: Callable[[Job], None],
        when_over: Callable[[Job | None], None],
    ) -> None:
        state, says = "failed", "the process ended before it was done; was it stopped, or out of memory?"
        result: Mapping[str, Any] = {}
        while state == "failed":
            try:
                what, content = receiving.recv()
            except (EOFError, OSError):
                break
            if what == "says":
                job.says = content
                self._tell()
                continue
            state, says, result = what, content if what != "done" else "done", content if what == "done" else {}
            break
        process.join()
        receiving.close()
        if job.stopped:
            state, says, result = "cancelled", "cancelled; nothing was written", {}
        job.says, job.result, job.ended = says, result, time.monotonic()
        if state == "done":
            try:
                when_done(job)
            except UserError as error:
                state, job.says = "refused", str(error)
        when_over(job)
        with self._lock:
            job.state = state
            del self._processes[job.number]
        self._tell()

    def cancel(self, number: int) -> None:
        """Stop a job where it runs; what it hadn't written whole isn't there."""
        with self._lock:
            process = self._processes.get(number)
            if process is not None:
                self._jobs[number].stopped = True
                _end(process)

    def end(self) -> None:
        """Stop all."""
        for number in list(self._processes):
            self.cancel(number)

    def of(self, project: str) -> list[dict[str, Any]]:
        """Give a campaign's jobs, the newest last."""
        with self._lock:
            return [job.to_dict() for job in self._jobs.values() if job.project == project]

    def running(self, project: str) -> bool:
        """Tell whether any of a campaign's jobs runs."""
        with self._lock:
            return any(self._jobs[number].project == project for number in self._processes)

    def _tell(self) -> None:
        for loop, event in list(self._listeners):
            if not loop.is_closed():
                loop.call_soon_threadsafe(event.set)

    async def followed(self, project: str) -> AsyncIterator[list[dict[str, Any]]]:
        """Give a campaign's jobs, again whenever they change, until none runs."""
        listener = (asyncio.get_running_loop(), asyncio.Event())
        self._listeners.add(listener)
        try:
            while True:
                listener[1].clear()
                running = self.running(project)
                yield self.of(project)
                if not running:
                    return
                try:
                    await asyncio.wait_for(listener[1].wait(), HEARTBEAT_s)
                except TimeoutError:
                    continue
        finally:
            self._listeners.discard(listener)


def _end(process: BaseProcess) -> None:
    """End a process with those that it started."""
    if process.pid is not None:
        with suppress(OSError):
            end_with_children(process.pid)
    process.kill()  # it may not have made a group of its own yet
