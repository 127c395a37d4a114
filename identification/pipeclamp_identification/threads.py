"""Threads of linear algebra: one, for matrices that are tall and thin."""

from __future__ import annotations

from contextlib import AbstractContextManager

from threadpoolctl import ThreadpoolController


def one_thread() -> AbstractContextManager[object]:
    """Hold linear algebra to one thread: its matrices are tall and thin, and threads only wait for one another.

    It also makes the last digits independent of the machine's number of cores.
    """
    limiter: AbstractContextManager[object] = ThreadpoolController().limit(limits=1, user_api="blas")
    return limiter
