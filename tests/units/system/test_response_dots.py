"""Co-simulations on a frequency response: in steps that make them right, or marked."""

from __future__ import annotations

from importlib import resources
from math import pi
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from typer.testing import CliRunner

from pipeclamp.cli.app import app
from pipeclamp.pages.system.cosim import cosim_sections
from pipeclamp.pages.system.response import response_picture
from pipeclamp_system.cosim.building import finished
from pipeclamp_system.cosim.hidden_motion import hidden_share
from pipeclamp_system.cosim.result import write_result
from pipeclamp_system.cosim.run import run_system
from pipeclamp_system.cosim.summary import summary_of
from pipeclamp_system.description.system import read_system
from pipeclamp_system.response import dots as response_dots
from pipeclamp_system.response import run
from pipeclamp_system.response.dots import CLOSE_SHARE, Rest, co_simulated
from pipeclamp_system.response.run import run_response
from pipeclamp_system.response.summary import response_summary

MET = 3.18
"""Hz. 64 steps a cycle come at 203.5 Hz, where the example's second residual mode (205.7 Hz) rings with their corners;
of 32 steps a cycle it meets twice the rate."""

SYSTEM = """
name = "example"
[pipe]
file = "pipe.toml"
[[clamps]]
at = "clamp1"
law = "emwm2"
temperature_C = 20.0
amplitude_mm = 0.2
[excitation]
kind = "sine"
acceleration_m_s2 = 0.1
frequency_Hz = {frequency}
[run]
stop_s = 3.0
step_s = {step}
[response]
from_Hz = 3.17
to_Hz = 3.19
dots = 1
"""


def write_example(folder: Path, step: float, frequency: float = MET) -> Path:
    pipe = resources.files("pipeclamp_identification").joinpath("data", "examples", "pipe.toml")
    text = pipe.read_text(encoding="utf-8").replace("[modes]", "[modes]\nerror = 0.4")  # so few that one rings there
    (folder / "pipe.toml").write_text(text, encoding="utf-8")
    file = folder / "system.toml"
    file.write_text(SYSTEM.format(frequency=frequency, step=step), encoding="utf-8")
    return file


@pytest.mark.parametrize("parts", [8, 20])
def test_the_hidden_share_of_a_sine_is_that_of_straight_forces(parts: int) -> None:
    time = np.linspace(0.0, 3.0, 3 * parts + 1)
    share = hidden_share(time, np.sin(2 * pi * time)[:, None], 2 * pi * np.cos(2 * pi * time)[:, None])
    assert share == pytest.approx((2 * pi / parts) ** 2 / 12, rel=0.1)


def test_motion_that_looks_slow_at_the_points_is_hidden() -> None:
    """A fast sine, sampled once in nearly a cycle, beside a slow one."""
    time = np.arange(0.0, 3.0, 1 / 64)
    slow, fast = 2 * pi, 2 * pi * 65
    still = np.zeros((time.size, 1))
    displacement = (np.sin(slow * time) + 0.1 * np.sin(fast * time))[:, None]
    velocity = (slow * np.cos(slow * time) + 0.1 * fast * np.cos(fast * time))[:, None]
    assert hidden_share(time, displacement, velocity) > 0.5
    assert hidden_share(time, still, still) == 0.0


def test_a_co_simulation_whose_steps_meet_a_mode_is_marked(tmp_path: Path) -> None:
    """Its energy balance is silent: the mode takes next to nothing."""
    step = 1 / (64 * MET)
    met, finer = run_system(write_example(tmp_path, step)), run_system(write_example(tmp_path, step / 2))
    last = slice(-round(1 / (MET * step)) - 1, None)
    off = np.ptp(met.columns["clamp1.s"][last]) / np.ptp(finer.columns["clamp1.s"][::2][last]) - 1
    assert off > 0.05
    assert met.coupling_share < 0.1 * met.trusted_share
    assert not met.trusted
    assert f"NOT TO BE TRUSTED: {met.hidden_share:.2%} of a clamp's motion passes between the steps" in summary_of(met)
    assert all(
        "NOT TO BE TRUSTED" in figure.layout.title.text for part in cosim_sections(met) for figure in part.figures
    )
    write_result(met, tmp_path / "met.csv")
    assert set(pl.read_csv(tmp_path / "met.csv")["trusted [1 yes, 0 no]"]) == {0.0}
    assert finer.trusted
    assert "TRUSTED" not in summary_of(finer)


def test_a_dot_takes_the_step_at_which_it_is_right(tmp_path: Path) -> None:
    """Of 32 and of 64 steps a cycle both err by 15 % and agree with each other within 1 %."""
    file = write_example(tmp_path, 1 / (32 * MET))
    found = run_response(file)
    (dot,) = found.dots
    assert dot.frequency == pytest.approx(MET)
    assert dot.settled
    assert dot.trusted
    assert dot.step == pytest.approx(1 / (128 * MET))
    assert dot.difference < CLOSE_SHARE
    assert "NOT TO BE TRUSTED" not in response_summary(found)


def test_a_dot_off_the_curve_is_confirmed_by_a_finer_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where it stands still, the curve is what differs, and the dot says by how much."""
    monkeypatch.setattr(response_dots, "MOST_CYCLES_RUN", 30)
    file = write_example(tmp_path, 1 / (64 * 2.0), frequency=2.0)
    with finished(read_system(file), tmp_path) as ready:
        right = co_simulated(ready, None, 1.0, 2.0, [], file)
        moved = tuple(1.2 * amplitude for amplitude in right.amplitudes)
        off = co_simulated(ready, None, 1.0, 2.0, [Rest(moved, 0.5, 0.0)], file)
    assert off.step == pytest.approx(right.step / 2)
    assert off.trusted
    assert off.difference == pytest.approx(1 / 6, abs=0.01)


def test_a_dot_that_no_step_makes_right_is_marked_everywhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = []
    monkeypatch.setattr(response_dots, "MOST_HALVINGS", 0)
    monkeypatch.setattr(run, "run_response", lambda *given: found.append(run_response(*given)) or found[0])
    file = write_example(tmp_path, 1 / (64 * MET))
    ran = CliRunner().invoke(
        app, ["response", str(file), "-o", str(tmp_path / "r.csv"), "--report", str(tmp_path / "r.html")]
    )
    assert ran.exit_code == 0
    assert "NOT TO BE TRUSTED: 1 co-simulation" in ran.stderr
    assert "NOT TO BE TRUSTED" not in ran.stdout
    assert "NOT TO BE TRUSTED" in (tmp_path / "r.html").read_text(encoding="utf-8")
    table = pl.read_csv(tmp_path / "r.csv").filter(pl.col("kind") == "co-simulation")
    assert table["trusted"].to_list() == [0.0]
    marked = [trace for trace in response_picture(found[0], 0).data if "not to be trusted" in (trace.name or "")]
    assert len(marked) == 1
    assert marked[0].marker.symbol == "x-thin-open"


def test_what_is_highest_where_the_range_ends_is_no_resonance(tmp_path: Path) -> None:
    """Below the resonance a peak was told at the upper end of the range, as if it were one."""
    file = write_example(tmp_path, 0.005)
    ends = "from_Hz = 3.17\nto_Hz = 3.19\ndots = 1"
    for stated, told in (
        ("from_Hz = 3.17\nto_Hz = 3.3\ndots = 0", True),
        ("from_Hz = 3.2\nto_Hz = 5.5\ndots = 0", False),
    ):
        file.write_text(SYSTEM.format(frequency=MET, step=0.005).replace(ends, stated), encoding="utf-8")
        first = next(line for line in response_summary(run_response(file)).splitlines() if "peak " in line)
        assert ("(where the range ends)" in first) is told, first
