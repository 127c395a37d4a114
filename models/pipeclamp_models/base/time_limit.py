"""A bound on the time that a computation in Python takes, in whatever thread it runs, on all platforms."""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Iterator
from contextlib import contextmanager


class _OutOfTime(BaseException):
    """Raised inside the computation; no `except Exception` on its way stops it."""


@contextmanager
def time_limit(seconds: float, error: Exception) -> Iterator[None]:
    """Raise an error where what is inside takes longer.

    It is stopped between two steps of the interpreter, so that one long step in another language isn't.

    Args:
        seconds: that it may take.
        error: that is raised then.

    Raises:
        Exception: `error`.
    """
    thread = ctypes.c_ulong(threading.get_ident())
    lock, ended, late, raised = threading.Lock(), False, False, False

    def stop() -> None:
        nonlocal late
        with lock:
            if not ended:
                late = True
                ctypes.pythonapi.PyThreadState_SetAsyncExc(thread, ctypes.py_object(_OutOfTime))

    timer = threading.Timer(seconds, stop)
    timer.daemon = True
    try:
        try:
            timer.start()
            yield
        except _OutOfTime:
            raised = True
            raise
        finally:
            with lock:
                ended = True
            # What is on its way is awaited, not taken back: that alone slows CPython 3.11, and hangs it under a tracer.
            while late and not raised:
                pass
    except _OutOfTime:
        raise error from None
    finally:
        timer.cancel()
