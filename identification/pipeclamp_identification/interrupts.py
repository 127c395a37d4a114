"""Ctrl-C comes once."""

from __future__ import annotations

import signal
import threading


def interrupted_once() -> None:
    """Give the signal of Ctrl-C back to Python, or to whom it belonged, for polars takes it when it is imported.

    Of an interrupt in one of its calls polars makes two: the second one comes in the middle of what cleans up after
    the first. Only the main thread may say who hears signals.
    """
    import polars  # noqa: F401

    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.getsignal(signal.SIGINT))
