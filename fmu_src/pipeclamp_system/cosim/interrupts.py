"""Ctrl-C doesn't come in the middle of what it would break."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def held_back() -> Iterator[Callable[[], None]]:
    """Hold Ctrl-C back; give the function that lets it through, to be called where nothing is half done.

    FMUs in Python run in this interpreter: an interrupt within one is a fatal error of its own, taken for a refused
    step, or the end of the process.
    """
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(before):
        yield lambda: None  # none is heard here
        return
    heard: list[int] = []

    def let_through() -> None:
        if heard:
            heard.clear()
            before(signal.SIGINT, None)

    signal.signal(signal.SIGINT, lambda number, _: heard.append(number))
    try:
        yield let_through
    finally:
        signal.signal(signal.SIGINT, before)
    let_through()
