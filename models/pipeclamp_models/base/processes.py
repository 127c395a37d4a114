"""Work spread over processes: results come in the order of the jobs, and few of either are held at a time."""

from __future__ import annotations

import pickle
import signal
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, partial
from typing import TypeVar, cast

from pipeclamp_models.base.progress import Progress, silent

Job = TypeVar("Job")
Result = TypeVar("Result")


MOST_PROCESSES = 8
"""Processes that are begun at once: each holds libraries of its own, some 0.2 GB."""
BEGINNING_S = 5.0
"""Seconds that others must save to be begun: each loads its libraries first, and writes its own machine code."""


def cores() -> int:
    """Give how many processes this machine has use for."""
    import joblib

    return min(int(joblib.cpu_count()), MOST_PROCESSES)


def spare_cores() -> int:
    """Give how many processes this machine has use for beside the one that goes on answering people."""
    return max(1, cores() - 1)


def ignore_interrupts() -> None:
    """Leave Ctrl-C, which a terminal sends to all processes, to the one that hands out the work."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def spread(work: Callable[[Job], Result], jobs: Iterable[Job], processes: int) -> Iterator[Result]:
    """Give the result of each job, in order; with one process, all is done in this one.

    Args:
        work: a function of a module, which a new process can import.
        jobs: taken up as processes become free.
        processes: how many.
    """
    if processes <= 1:
        yield from map(work, jobs)
        return
    import joblib

    # A process that has grown large is begun anew, with its jobs done; nobody has anything to do about it.
    warnings.filterwarnings("ignore", "A worker stopped while some jobs", UserWarning)
    with joblib.parallel_config(backend="loky", initializer=ignore_interrupts, inner_max_num_threads=1):
        # what is large is sent, and never written to a temporary folder
        parallel = joblib.Parallel(
            n_jobs=processes, return_as="generator", pre_dispatch="3*n_jobs", batch_size=1, max_nbytes=None
        )
        results = parallel(joblib.delayed(work)(job) for job in jobs)
    try:
        yield from results
    finally:
        results.close()


def _sent(work: Callable[[Job], Result]) -> Callable[[Job], Result]:
    """Give work that is packed once, and unpacked once by each process, however much data it holds."""
    return cast("Callable[[Job], Result]", partial(_unpacked_call, pickle.dumps(work)))


def _unpacked_call(packed: bytes, job: Job) -> object:
    return _unpacked(packed)(job)


@lru_cache(maxsize=1)
def _unpacked(packed: bytes) -> Callable[[object], object]:
    work: Callable[[object], object] = pickle.loads(packed)
    return work


@dataclass(eq=False)
class Workers:
    """Who does a long computation.

    Attributes:
        processes: that share it; -1 for as many as there are cores.
        tell: is told what is being done.
    """

    processes: int = 1
    tell: Progress = silent
    _begun: bool = field(default=False, init=False, repr=False)
    """Whether others were begun: they stay for what comes next."""

    def each(self, work: Callable[[Job], Result], jobs: Sequence[Job], words: Callable[[Job], str]) -> list[Result]:
        """Give the result of each job, in order, and tell which is done.

        Args:
            work, jobs: as for `share`.
            words: say what was done in a job.
        """
        found = []
        for job, result in zip(jobs, self.share(work, jobs), strict=True):
            self.tell(words(job))
            found.append(result)
        return found

    def share(self, work: Callable[[Job], Result], jobs: Sequence[Job]) -> Iterator[Result]:
        """Give the result of each job, in order: by this process until what is left is worth others, then by those.

        Args:
            work: a function of a module, which a new process can import, or a part of one.
            jobs: what each is given.
        """
        processes = cores() if self.processes < 0 else self.processes
        spent = 0.0
        for done, job in enumerate(jobs):
            left = len(jobs) - done
            saved = spent / max(done, 1) * left * (1 - 1 / processes)
            if processes > 1 and left > 1 and (self._begun or saved > BEGINNING_S):
                self._begun = True
                # always as many: those of another number would be begun anew
                yield from spread(_sent(work), jobs[done:], processes)
                return
            begin = time.perf_counter()
            result = work(job)
            spent += time.perf_counter() - begin
            yield result


ALONE = Workers()
"""This process, which tells nobody."""
