"""Linear algebra on one thread: for small matrices threads only wait for one another."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from threadpoolctl import ThreadpoolController


@contextmanager
def one_thread() -> Iterator[None]:
    """Hold linear algebra to one thread, as a context or as a decorator.

    Fits have tall and thin matrices, pipes small ones: on two busy cores an eigenvalue problem of 100 unknowns took 80
    times as long on two threads as on one. It also makes the last digits independent of the machine's number of cores.
    """
    # Made anew each time, which takes 1 ms: libraries may have been loaded since.
    with ThreadpoolController().limit(limits=1, user_api="blas"):
        yield
