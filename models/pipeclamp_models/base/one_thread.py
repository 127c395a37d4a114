"""Linear algebra on one thread: for small matrices threads only wait for one another."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

NUMBERS_OF_THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
"""What libraries of linear algebra read when they are loaded."""
_HELD = ContextVar("held", default=False)
"""Whether they are held to one thread already."""


def one_thread_throughout() -> None:
    """Hold linear algebra to one thread in this process, from before it is loaded, and in those that it starts.

    For a process of our own, a command's: it needn't load SciPy only to hold it.
    """
    os.environ.update(dict.fromkeys(NUMBERS_OF_THREADS, "1"))
    _HELD.set("numpy" not in sys.modules)


@contextmanager
def one_thread() -> Iterator[None]:
    """Hold linear algebra to one thread, as a context or as a decorator.

    Fits have tall and thin matrices, pipes small ones: on two busy cores an eigenvalue problem of 100 unknowns took 80
    times as long on two threads as on one. It also makes the last digits independent of the machine's number of cores.
    """
    if _HELD.get():
        yield
        return
    # SciPy has a BLAS of its own: one that is loaded only later would not be held.
    importlib.import_module("scipy.linalg")
    with _controller(len(sys.modules)).limit(limits=1, user_api="blas"):
        before = _HELD.set(True)
        try:
            yield
        finally:
            _HELD.reset(before)


@lru_cache(maxsize=1)
def _controller(modules: int) -> ThreadpoolController:
    """Find what can be held among all loaded libraries, which takes 1 to 8 ms: anew where modules were imported since.

    Args:
        modules: how many are imported: libraries of linear algebra come with them.
    """
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
