"""Programs whose cycles differ: each cycle a run, without a column that numbers them."""

from __future__ import annotations

import numpy as np
import pytest

import pipeclamp as pc
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.importing.samples.each_cycle import cycle_numbers

STIFFNESS, FRICTION = 800.0, 90.0


def program(turns, step=0.05):
    """A path through turns in equal steps, and the force of a spring with dry friction along it."""
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(turns)))])
    path = np.arange(0.0, way[-1], step)
    y = np.interp(path, way, turns)
    rising = np.interp(path + step / 8, way, turns) > y
    return y, STIFFNESS * y + np.where(rising, FRICTION, -FRICTION)


GROWING = [0.0, *(sign * a for a in (1.0, 1.3, 1.7, 2.3, 3.0) for sign in (1, -1)), 0.0]


@pytest.mark.parametrize("sign", [1, -1])
def test_cycles_begin_where_the_motion_comes_by_its_beginning(sign):
    y, _ = program([sign * a for a in GROWING])
    numbers = cycle_numbers(y)
    assert np.unique(numbers).tolist() == [1, 2, 3, 4, 5]
    begins = np.flatnonzero(np.diff(numbers)) + 1
    assert np.all(np.abs(y[begins]) < 0.06) and np.all(sign * np.diff(y)[begins] > 0)


def test_where_it_has_drifted_off_they_begin_halfway():
    y, _ = program([0.0, 1.0, -1.0, 3.0, 1.5, 5.0, 3.0, 6.0])
    begins = np.flatnonzero(np.diff(cycle_numbers(y))) + 1
    assert y[begins] == pytest.approx([0.0, 3.25], abs=0.06)


def test_a_motion_that_never_comes_back_is_one_cycle():
    assert np.all(cycle_numbers(np.linspace(0, 3, 50)) == 1)


@pytest.mark.parametrize("timed", [True, False])
def test_each_cycle_of_a_program_becomes_a_run(tmp_path, timed):
    y, force = program(GROWING)
    rows = [f"{row / 100},{a:.6f},{b:.4f}" for row, (a, b) in enumerate(zip(y, force, strict=True))]
    (tmp_path / "p.csv").write_text("\n".join(["Time [s],Displacement [mm],Force [N]", *rows]))
    columns = "segment=each-cycle" + ("" if timed else ",time=none")
    pc.import_files(tmp_path / "p.csv", tmp_path / "c", columns=columns, rate=None if timed else "none")
    runs = read_campaign(tmp_path / "c").runs
    # a triangle's fundamental is 8/pi^2 of its peak; laid out over sines, amplitudes are the turns'
    expected = np.array([1.0, 1.3, 1.7, 2.3, 3.0]) * (8 / np.pi**2 if timed else 1.0)
    found = [run.setup.first_cycle for run in runs]
    assert [np.ptp(run.record.displacement_mm) / 2 for run in runs] == pytest.approx(
        [1.0, 1.3, 1.7, 2.3, 3.0], abs=0.05
    )
    assert found == [0, 1, 2, 3, 4]
    tests = pc.read_campaign(tmp_path / "c")
    amplitudes = [run["amplitude_mm"] for run in pc.compare(pc.identify(tests), tests).to_dict()["runs"]]
    assert sorted(amplitudes) == pytest.approx(expected, rel=0.04)


def test_runs_of_few_steady_cycles_name_the_option(tmp_path):
    y, force = program(GROWING)
    rows = [f"{a:.6f},{b:.4f}" for a, b in zip(y, force, strict=True)]
    (tmp_path / "p.csv").write_text("\n".join(["Displacement [mm],Force [N]", *rows]))
    found = pc.import_files(tmp_path / "p.csv", tmp_path / "c", rate="none")
    with pytest.raises(pc.UserError, match="segment=each-cycle"):
        pc.diagnose(pc.identify(found.tests()), found.tests())


def test_a_motion_without_a_cycle_names_no_frequency(tmp_path):
    """ "0.00 of one at 0.0006289 Hz is steady" had been said of a logger's position that wanders down."""
    time = np.arange(60) / 20
    y = 80 - 8 * time + 2.5 * np.sin(9 * time**1.3) + np.cos(31 * time)
    rows = [f"{a:.3f},{b:.4f},{c:.3f}" for a, b, c in zip(time, y, 5 * y, strict=True)]
    (tmp_path / "a.csv").write_text("\n".join(["Time [s],Displacement [mm],Force [N]", *rows]))
    found = pc.import_files(tmp_path / "a.csv", tmp_path / "c").to_dict()
    assert "no part of it follows a sine" in str(found["runs"][0]["done"])
