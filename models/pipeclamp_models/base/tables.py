"""polars, with Ctrl-C left to Python: `from pipeclamp_models.base.tables import pl`.

When it is imported, polars takes the signal. Of an interrupt in one of its calls it then makes two: the second one
comes in the middle of what cleans up after the first.
"""

import signal
import threading

import polars as pl

__all__ = ["pl"]

# Only the main thread may say who hears signals; what a host program set without Python (None) stays its own.
if threading.current_thread() is threading.main_thread() and (before := signal.getsignal(signal.SIGINT)) is not None:
    signal.signal(signal.SIGINT, before)
