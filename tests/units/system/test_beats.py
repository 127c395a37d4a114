"""An amplitude that swings for its tracker alone is told from a transient and from a motion that settles."""

from __future__ import annotations

from math import pi

import numpy as np
import polars as pl
import pytest
from banded import PIPE

from pipeclamp.pages.system.cosim import cosim_sections
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import write_law
from pipeclamp_system.cosim.beating import Beats, Swing, swing_of
from pipeclamp_system.cosim.result import _about_beats, write_result
from pipeclamp_system.cosim.run import run_system
from pipeclamp_system.cosim.summary import summary_of

TIME = np.linspace(0.0, 10.0, 20001)

SYSTEM = """name = "case"
pipe = { file = "pipe.toml" }
clamps = [{ at = "clamp1", law = "law.json", temperature_C = 20.0, track = true, amplitude_mm = 1, frequency_Hz = 14 }]
excitation = { kind = "sine", acceleration_m_s2 = 3.0, frequency_Hz = 14.0 }
run = { stop_s = 5.0, step_s = 0.002 }
"""


def sine(amplitude):
    return amplitude * np.sin(2 * pi * 8.0 * TIME)


def test_a_swing_is_told_from_what_dies_out_and_from_what_settles():
    swinging = swing_of(TIME, sine(1 + 0.3 * np.sin(2 * pi * 1.25 * TIME)), 8.0)
    assert swinging.low == pytest.approx(0.7, abs=0.05)
    assert swinging.high == pytest.approx(1.3, abs=0.05)
    assert swinging.period == pytest.approx(0.8, abs=0.03)
    assert swing_of(TIME, sine(1 + np.exp(-TIME / 2) * np.sin(2 * pi * 1.25 * TIME)), 8.0) is None
    assert swing_of(TIME, sine(1.0), 8.0) is None
    assert swing_of(TIME, sine(1 + 0.05 * TIME), 8.0) is None  # a drift
    slow = swing_of(TIME, sine(1 + 0.3 * np.sin(2 * pi * TIME / 6)), 8.0)  # of more than two fifths of the run
    assert (slow.low, slow.high) == pytest.approx((0.7, 1.3), abs=0.06)
    assert swing_of(TIME, sine(0.0), 8.0) is None
    assert swing_of(TIME[:2001], sine(1 + 0.3 * np.sin(2 * pi * 1.25 * TIME))[:2001], 8.0) is None  # too short to tell


@pytest.mark.parametrize(("steep", "beats"), [(-0.9, True), (-0.3, False)])
def test_a_law_that_hangs_on_its_tracker_is_said_to_beat(tmp_path, steep, beats):
    file = open_law("emwm2")
    values = {"k10": 120.0, "k30": 0.0, "k1_A": steep, "k3_A": 0.0, "c0": 0.5, "alpha0": 1.0, "alpha_f": 0.0}
    entries = {
        name: entry.model_copy(update={"value": values.get(name, entry.value)})
        for name, entry in file.coefficients.items()
    }
    wide = {"A": {"minimum": 0.05, "maximum": 5.0}, "f": {"maximum": 40.0}}
    ranges = {name: entry.model_copy(update=wide.get(name, {})) for name, entry in file.range.items()}
    write_law(file.model_copy(update={"coefficients": entries, "range": ranges}), tmp_path / "law.json")
    (tmp_path / "pipe.toml").write_text(PIPE, encoding="utf-8")
    (tmp_path / "system.toml").write_text(SYSTEM, encoding="utf-8")
    result = run_system(tmp_path / "system.toml")
    assert (result.beats is not None) == beats
    said = summary_of(result)
    assert ("swings between" in said) == beats
    if beats:
        assert result.beats.swing.high > 1.5 * result.beats.swing.low
        assert result.beats.solved
        # A is solved for: with A held where the swing has its mean it would be 1.40 mm.
        assert result.beats.settles_at == pytest.approx(1.505e-3, rel=0.01)
        assert result.beats.held_at == pytest.approx(result.beats.settles_at, rel=0.02)
        (picture,) = (one for section in cosim_sections(result) if section.title == "Beats" for one in section.figures)
        tracked, held = (np.array(curve.y)[-40:] for curve in picture.data)
        assert np.ptp(tracked) > 0.3 * tracked.mean()
        assert held == pytest.approx(1e3 * result.beats.settles_at, rel=0.01)
        assert result.step_error is None
        assert "is still changing" not in said
        write_result(result, tmp_path / "result.csv")
        written = pl.read_csv(tmp_path / "result.csv")
        (settled,) = (name for name in written.columns if name.startswith("settled"))
        assert written[settled].unique().to_list() == [0.0]
        assert any("swings between" in mark for mark in result.marks())
        assert not result.trusted
        assert "solve = true in place of track = true" in said
        assert "use a larger stop_s" not in said


@pytest.mark.parametrize(
    ("beats", "words"),
    [
        (Beats("clamp1", Swing(1e-3, 2e-3, 0.5), 1.5e-3, None), "an amplitude swings too"),
        (Beats("clamp1", Swing(1e-3, 2e-3, 0.5), 1.5e-3, None, failed="it diverges"), "the run fails (it diverges)"),
        (Beats("clamp1", Swing(1e-3, 2e-3, None), 1.5e-3, 1.4e-3), "(not solved) it comes to 1.4 mm"),
    ],
)
def test_a_swing_is_said_whatever_the_held_run_shows(beats, words):
    what, rest = _about_beats(beats)
    assert "swings between 1 and 2 mm" in what
    assert words in rest
