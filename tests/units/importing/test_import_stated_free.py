"""Motions that a table of conditions calls free: they stay whole, whatever sines they hold."""

from __future__ import annotations

import numpy as np
import pytest
from exports import RATE, Loop, text

import pipeclamp as pc


def sweep() -> np.ndarray:
    time = np.arange(20 * RATE) / RATE
    return 0.5 * np.sin(2 * np.pi * (0.5 * time + 0.1 * time**2))


def blocks() -> np.ndarray:
    """Six cycles of each of three amplitudes, which are three runs where nobody calls them one motion."""
    time = np.arange(6 * RATE) / RATE
    return np.concatenate([amplitude * np.sin(2 * np.pi * time) for amplitude in (0.2, 0.4, 0.8)])


@pytest.mark.parametrize("called", ["a.csv", "a"])
@pytest.mark.parametrize("motion", [sweep, blocks])
def test_a_motion_that_is_called_free_stays_whole(tmp_path, motion, called):
    """It had been cut, and refused beside an amplitude that had been measured of it."""
    y = motion()
    run = Loop("a", 0.5, 1.0, 20.0, np.arange(len(y)) / RATE, y, 300 * y)
    (tmp_path / "a.csv").write_text(text(run))
    (tmp_path / "set.csv").write_text(f"file,motion,temperature_C\n{called},free,20\n")
    imported = pc.import_files(tmp_path / "a.csv", tmp_path / "c", conditions=tmp_path / "set.csv")
    (told,) = imported.to_dict()["runs"]
    assert told["amplitude_mm"] is None and "as --conditions states" in " ".join(told["done"])
    (free,) = pc.read_campaign(tmp_path / "c").tests.campaign.free
    assert len(free.record.time_s) == len(y)
