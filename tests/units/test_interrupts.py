"""Ctrl-C in the middle of a call of polars is one KeyboardInterrupt."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

PROGRAM = """
import io, os, signal, threading, time
import numpy as np
import polars as pl
from pipeclamp_identification.interrupts import interrupted_once

interrupted_once()
count = 0
table = pl.DataFrame({"a": np.random.default_rng(1).random(3_000_000)})
threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT)).start()
try:
    try:
        for _ in range(100):
            table.write_csv(io.BytesIO())
    except KeyboardInterrupt:
        count += 1
        time.sleep(0.2)
except KeyboardInterrupt:
    count += 1
print(count)
"""


@pytest.mark.skipif(os.name != "posix", reason="interrupts with a signal")
def test_an_interrupt_comes_once():
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    assert done.stdout == "1\n"
