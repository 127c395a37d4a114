"""Ctrl-C within a call of polars is one KeyboardInterrupt; within an FMU's step it waits for its end."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest
from cantilever import cantilever

from pipeclamp_system.cosim.interrupts import held_back
from pipeclamp_system.cosim.run import run_system
from pipeclamp_system.fmus.participant import FmuParticipant

PROGRAM = """
import io, os, signal, threading, time
import numpy as np
from pipeclamp_models.base.tables import pl

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


def test_an_interrupt_within_an_fmu_waits_for_the_steps_end(monkeypatch, tmp_path):
    """A Python FMU that is interrupted itself fails, which was taken for a refused step, or ended the process."""
    step, ended = FmuParticipant.step, []

    def interrupted(self, time, h):
        signal.raise_signal(signal.SIGINT)
        step(self, time, h)
        ended.append(time)

    monkeypatch.setattr(FmuParticipant, "step", interrupted)
    (tmp_path / "pipe.toml").write_text(cantilever(ratio=0.01, up_to_Hz=200.0), encoding="utf-8")
    (tmp_path / "system.toml").write_text(
        '[pipe]\nfile = "pipe.toml"\n[[clamps]]\nat = "clamp1"\nlaw = "emwm2"\ntemperature_C = 20.0\n'
        'amplitude_mm = 0.5\n[excitation]\nkind = "sine"\nacceleration_m_s2 = 1.0\nfrequency_Hz = 5.0\n'
        '[run]\nscheme = "parallel"\nstop_s = 1.0\nstep_s = 1e-4\n',
        encoding="utf-8",
    )
    with pytest.raises(KeyboardInterrupt):
        run_system(tmp_path / "system.toml")
    assert ended == [0.0, 0.0]  # pipe and clamp ended the step
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_an_interrupt_at_the_very_end_is_not_lost():
    with pytest.raises(KeyboardInterrupt), held_back():
        signal.raise_signal(signal.SIGINT)


def test_who_hears_interrupts_hears_them_later():
    """A study's own way to end is not passed over."""
    heard = []
    before = signal.signal(signal.SIGINT, lambda number, _: heard.append(number))
    try:
        with held_back() as let_through:
            signal.raise_signal(signal.SIGINT)
            assert heard == []
            let_through()
            let_through()
            assert heard == [signal.SIGINT]
    finally:
        signal.signal(signal.SIGINT, before)
