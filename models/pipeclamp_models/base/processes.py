"""Work spread over processes: results come in the order of the jobs, and few of either are held at a time."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

Job = TypeVar("Job")
Result = TypeVar("Result")


MOST_PROCESSES = 8
"""Processes that are begun at once: each holds libraries of its own, some 0.2 GB."""


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
