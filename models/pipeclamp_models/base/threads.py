"""Threads for work on large arrays, in which NumPy and polars let others run; on small ones threads only wait."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Job = TypeVar("Job")
Result = TypeVar("Result")

MOST_THREADS = 4
"""Threads: memory holds what as many work on."""
WORTH_THREADS = 50_000
"""Numbers in an array from which on threads are worth it: on smaller ones they wait for the interpreter, which took 1.1
to 3.6 times the CPU time of one, and hardly less time by the clock (docs/evidence/speed.md)."""


def in_threads(work: Callable[[Job], Result], jobs: Sequence[Job], size: float = WORTH_THREADS) -> list[Result]:
    """Give the result of each job, in order; what isn't begun when one fails, or by Ctrl-C, isn't begun any more.

    Args:
        work: to be done.
        jobs: with each of these.
        size: numbers in the arrays of one, on average; few are worked on one after the other.
    """
    if size < WORTH_THREADS or len(jobs) < 2:
        return [work(job) for job in jobs]
    threads = ThreadPoolExecutor(MOST_THREADS)
    try:
        return list(threads.map(work, jobs))
    finally:
        threads.shutdown(cancel_futures=True)
