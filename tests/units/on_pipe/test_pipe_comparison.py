"""A coupled model against a measurement of itself errs by nothing, and by what was changed where it was changed."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from cantilever import cantilever, shaken

from pipeclamp.pages.page import render
from pipeclamp.pages.system.pipe import pipe_comparison_sections
from pipeclamp_identification.on_pipe.answer import sines_answer
from pipeclamp_identification.on_pipe.measurement import read_measurement
from pipeclamp_identification.on_pipe.prediction import met_in_sweep
from pipeclamp_identification.on_pipe.sines import PipeComparison, compare_pipe, sine_scatter_of
from pipeclamp_identification.on_pipe.where import highest_peaks, how_much, where_words
from pipeclamp_models.base.errors import UserError
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.harmonics import DOUBTFUL_SHARE

MEASUREMENT = """
name = "test"
[[probes]]
name = "tip"
position_m = 3.0
unit = "m/s2"
[[probes]]
name = "middle"
position_m = 1.5
unit = "mm"
[[responses]]
file = "sines.csv"
"""
FREQUENCIES = np.linspace(6.0, 12.0, 13)
FOLD = np.linspace(6.0, 12.0, 25)


def made(tmp_path: Path, write_law: Callable[..., None]) -> Path:
    """Make a cantilever in a clamp that hardens."""
    write_law(tmp_path / "law.json", {"k10": 4.0, "k30": 4.0, "c0": 0.02, "alpha0": 1.0})
    (tmp_path / "pipe.toml").write_text(cantilever(ratio=0.01, up_to_Hz=100), encoding="utf-8")
    system = shaken(amplitude_mm=1.0, frequency_Hz=9.0, acceleration_m_s2=0.5)
    (tmp_path / "system.toml").write_text(system, encoding="utf-8")
    return tmp_path


def measured(bench: Path, frequencies: np.ndarray, levels: tuple[float, ...], sweep: str = "") -> PipeComparison:
    """Write what the model itself says, and compare it with what stood there before: 1 everywhere."""
    folder = bench / "measured"
    folder.mkdir()
    (folder / "measurement.toml").write_text(MEASUREMENT + sweep, encoding="utf-8")
    head = "frequency_Hz,acceleration_m_s2,tip_real,tip_imag,middle_real,middle_imag\n"
    sines = [(f, level) for level in levels for f in frequencies]
    blank = head + "".join(f"{f},{level},1,0,1,0\n" for f, level in sines)
    (folder / "sines.csv").write_text(blank, encoding="utf-8")
    blank_compared = compared(bench)
    found = blank_compared.prediction.response
    f, level = np.array(sines).T
    tip, middle = found[:, 0] * level, found[:, 1] * level / 1e-3
    table = np.column_stack([f, level, tip.real, tip.imag, middle.real, middle.imag])
    rows = [",".join(map(repr, row)) for row in table.tolist()]
    (folder / "sines.csv").write_text(head + "\n".join(rows) + "\n", encoding="utf-8")
    return blank_compared


def compared(bench: Path) -> PipeComparison:
    return compare_pipe(bench / "system.toml", bench / "measured")


@pytest.fixture(scope="module")
def measured_bench(tmp_path_factory: pytest.TempPathFactory, write_law: Callable[..., None]) -> Path:
    """A bench measured at two levels: not to be changed."""
    folder = made(tmp_path_factory.mktemp("bench"), write_law)
    measured(folder, FREQUENCIES, (0.05, 0.2))
    return folder


@pytest.fixture
def bench(measured_bench: Path, tmp_path: Path) -> Path:
    """The measured bench, to be changed."""
    return shutil.copytree(measured_bench, tmp_path / "bench")


@pytest.fixture(scope="module")
def itself(measured_bench: Path) -> PipeComparison:
    """A measurement of the model itself, compared."""
    return compared(measured_bench)


@pytest.fixture(scope="module")
def folds(
    tmp_path_factory: pytest.TempPathFactory, write_law: Callable[..., None]
) -> dict[str, tuple[Path, PipeComparison]]:
    """Benches that were swept up and down through a fold, and what the model says of each sweep."""
    benches = {way: made(tmp_path_factory.mktemp(way), write_law) for way in ("up", "down")}
    return {way: (bench, measured(bench, FOLD, (0.5,), f'sweep = "{way}"\n')) for way, bench in benches.items()}


def with_tip_turned(comparison: PipeComparison, turn: complex) -> PipeComparison:
    """Give a comparison whose measured response at the tip is turned by a factor."""
    steady = comparison.measurement.steady
    response = steady.response * np.array([turn, 1.0])
    return replace(comparison, measurement=replace(comparison.measurement, steady=replace(steady, response=response)))


def test_a_measurement_of_the_model_itself(itself):
    assert itself.nrmse < 1e-6
    assert itself.noise_nrmse is None
    assert "no scatter is known" in how_much(itself)[0]


def test_a_sensor_that_is_out_of_calibration_errs_in_amplitude_at_its_place(itself):
    found = with_tip_turned(itself, 1.1)
    tip, middle = found.by_probe().parts
    assert tip.nrmse == pytest.approx(0.1 / 1.1)
    assert middle.nrmse == pytest.approx(0.0, abs=1e-6)
    assert found.by_kind().share(found.by_kind().parts[0]) == pytest.approx(1.0)
    assert set(found.region().words) == {"at probe tip", "in amplitude"}


def test_a_delay_errs_in_phase(itself):
    found = with_tip_turned(itself, np.exp(-0.1j))
    assert found.by_kind().share(found.by_kind().parts[1]) > 0.99
    assert any("100% in phase" in words for words in where_words(found))


def test_every_breakdown_adds_up_and_the_report_is_drawn(bench):
    (bench / "pipe.toml").write_text(cantilever(ratio=0.03, up_to_Hz=100), encoding="utf-8")
    found = compared(bench)
    answer = sines_answer(found).to_dict()
    assert answer["nrmse"] > 0.1
    parts = [answer["where"]["kinds"], answer["where"]["probes"], *answer["where"]["conditions"].values()]
    assert set(answer["where"]["conditions"]) == {"frequency_Hz", "acceleration_m_s2"}
    for one in parts:
        assert sum(part["share"] for part in one) == pytest.approx(1.0)
    assert len(answer["sines"]) == 26
    assert any("too low" in words for words in where_words(found))
    page = render("test", "", pipe_comparison_sections(found))
    assert "Response at tip" in page


def test_a_peak_is_held_against_that_of_its_own_mode():
    """Two modes of nearly the same height: measured the upper one is the higher, computed the lower one."""
    frequency = np.linspace(2.0, 14.0, 241)

    def response(*modes):
        return sum(size / np.abs(1 - (frequency / at) ** 2 + 0.1j * frequency / at) for at, size in modes)[:, None]

    comparison = SimpleNamespace(
        compared=np.ones((241, 1), dtype=bool),
        measurement=SimpleNamespace(
            steady=SimpleNamespace(frequency=frequency, drive=np.ones(241), response=response((5.0, 1.0), (12.0, 1.3)))
        ),
        prediction=SimpleNamespace(response=response((5.0, 1.3), (11.4, 1.0))),
    )
    (measured, _), (model, _) = highest_peaks(comparison, np.arange(241), 0)
    assert measured == pytest.approx(12.0, abs=0.1)
    assert model == pytest.approx(11.4, abs=0.1)


def test_repeats_show_scatter(bench):
    file = bench / "measured" / "sines.csv"
    head, *rows = file.read_text(encoding="utf-8").splitlines()
    cells = [[float(cell) for cell in row.split(",")] for row in rows]
    louder = [",".join(map(str, [*row[:2], *(1.02 * value for value in row[2:])])) for row in cells]
    file.write_text("\n".join([head, *rows, *louder]) + "\n", encoding="utf-8")
    found = compared(bench)
    # 0 and 2 % of error, of which the deviation from their mean is scatter
    assert found.noise_nrmse == pytest.approx(0.02 / np.sqrt(2), rel=0.02)
    assert found.nrmse == pytest.approx(0.02 / np.sqrt(2), rel=0.02)
    assert "is scatter, nearly all of it" in where_words(found)[0]


@pytest.mark.parametrize("level", np.exp(0.02 * np.arange(-2.0, 2.01, 0.25)))
def test_repeats_are_repeats_at_any_level(tmp_path, level):
    (tmp_path / "measurement.toml").write_text(MEASUREMENT, encoding="utf-8")
    head = "frequency_Hz,acceleration_m_s2,tip_real,tip_imag,middle_real,middle_imag\n"
    rows = f"9,{level},{level},0,,\n9,{level * 1.001},{level * 1.021},0,{level},0\n9,{level},{level},0,{level},0\n"
    (tmp_path / "sines.csv").write_text(head + rows, encoding="utf-8")
    found = sine_scatter_of(read_measurement(tmp_path))
    assert np.isfinite(found[:, 0]).all()
    assert found[0, 0] == pytest.approx(found[2, 0])
    assert np.isfinite(found[1:, 1]).all()


def test_a_sweep_stays_on_its_branch(folds):
    """The clamp hardens: a sweep up stays on the upper branch, a sweep down on the lower one."""
    (_, up), (_, down) = folds["up"], folds["down"]
    several = up.prediction.branches > 1
    assert several.any()
    assert np.all(several == (down.prediction.branches > 1))
    assert all(any("direction" in words for words in where_words(found)) for found in (up, down))
    upper, lower = (np.abs(found.prediction.clamps[several, 0]) for found in (up, down))
    assert np.all(upper > 1.2 * lower)


def test_a_fold_that_both_ends_lead_round_is_followed_once(folds, monkeypatch):
    """What is found from its upper end is the same way back, and a sweep down takes its motions in that order."""
    bench, down = folds["down"]
    followed, follow = [], SteadySystem.path

    def path(self, first, last):
        followed.append((first, last))
        return follow(self, first, last)

    monkeypatch.setattr(SteadySystem, "path", path)
    again = compared(bench)
    assert followed == [(FOLD[0], FOLD[-1])]
    assert again.prediction.response == pytest.approx(down.prediction.response, rel=1e-6)


def motion(amplitude, *, stable):
    return SimpleNamespace(clamps=np.array([[0.0, amplitude]]), stable=stable)


def test_a_sweep_goes_on_along_the_branch_that_leaves_its_own_where_that_is_unstable():
    """It had been taken to be on the far side of the fold, between sines on this side of it."""
    upper, near, lower = motion(4.39, stable=False), motion(4.25, stable=True), motion(1.76, stable=True)
    assert met_in_sweep([upper, motion(3.4, stable=False), lower], [near]) is near
    assert met_in_sweep([motion(4.4, stable=True), lower], [near]).clamps[0, 1] == 4.4
    assert met_in_sweep([lower], [near]) is lower
    assert met_in_sweep([], [near]) is near


def test_where_a_sweep_meets_nothing_steady_no_motion_far_away_is_compared():
    """It beats about its own motion, or jumps: neither is told."""
    upper, lower = motion(4.39, stable=False), motion(1.76, stable=True)
    assert met_in_sweep([upper, lower], []) is upper
    assert met_in_sweep([upper, lower], [motion(4.2, stable=False)]) is upper
    assert met_in_sweep([upper, lower], [motion(0.9, stable=True)]) is upper


def test_without_a_direction_the_nearest_branch_is_compared(folds):
    bench, _ = folds["down"]
    (bench / "measured" / "measurement.toml").write_text(MEASUREMENT, encoding="utf-8")
    found = compared(bench)
    assert found.nrmse < 1e-6
    assert any("nearest to what was measured" in words for words in where_words(found))


def test_amplitudes_alone_are_compared_as_amplitudes(bench):
    file = bench / "measured" / "sines.csv"
    _, *rows = file.read_text(encoding="utf-8").splitlines()
    cells = [[float(cell) for cell in row.split(",")] for row in rows]
    table = [f"{f},{level},{np.hypot(a, b)},{np.hypot(c, d)}" for f, level, a, b, c, d in cells]
    head = "frequency_Hz,acceleration_m_s2,tip_amplitude,middle_amplitude"
    file.write_text("\n".join([head, *table]) + "\n", encoding="utf-8")
    assert compared(bench).nrmse < 1e-6


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("position_m = 3.0", "position_m = 30.0", "at most the pipe's length_m = 3"),
        ("position_m = 3.0\n", "", "has no position_m"),
    ],
)
def test_a_probe_that_isnt_on_the_pipe(bench, old, new, said):
    file = bench / "measured" / "measurement.toml"
    file.write_text(MEASUREMENT.replace(old, new), encoding="utf-8")
    with pytest.raises(UserError, match=said):
        compared(bench)


@pytest.mark.parametrize(
    ("file", "old", "new", "said"),
    [
        ("pipe.toml", "[damping]", '[excitation]\nkind = "force"\nposition_m = 1.0\n[damping]', "excited by force"),
        ("pipe.toml", "up_to_Hz = 100", "up_to_Hz = 8", "goes up to 12 Hz"),
        ("system.toml", 'file = "pipe.toml"', 'fmu = "pipe.fmu"', "not an FMU"),
    ],
)
def test_a_system_that_the_measurement_doesnt_belong_to(bench, file, old, new, said):
    path = bench / file
    path.write_text(path.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
    with pytest.raises(UserError, match=said):
        compared(bench)


SHOT = """frequency_Hz,acceleration_m_s2,tip_real,tip_imag
10.0,3,-2.7486,0.2484
10.4,3,-2.8426,0.2790
10.8,3,1.5456,0.0793
11.2,3,-3.0457,0.3781
"""
"""Stable motions of a sweep up through a gap's fold, by shooting (the cantilever's own modes, Runge-Kutta, Newton on
the cycle). At 10.8 Hz the upper motion is unstable, and the sweep falls to the lower one."""


def test_what_is_compared_is_stable_in_as_many_harmonics_as_a_gap_asks_for(tmp_path, write_law):
    write_law(tmp_path / "law.json", {"k10": 400.0, "c0": 0.02, "alpha0": 1.0, "g": 1.0}, "power", ("gap",))
    (tmp_path / "pipe.toml").write_text(cantilever(ratio=0.01, up_to_Hz=200, probes={"tip": 3.0}), encoding="utf-8")
    (tmp_path / "system.toml").write_text(shaken(1.0, 9.0, 3.0), encoding="utf-8")
    measured = tmp_path / "measured"
    measured.mkdir()
    text = '[[probes]]\nname = "tip"\nunit = "mm"\n[[responses]]\nfile = "sines.csv"\nsweep = "up"\n'
    (measured / "measurement.toml").write_text(text, encoding="utf-8")
    (measured / "sines.csv").write_text(SHOT, encoding="utf-8")
    enough = compare_pipe(tmp_path / "system.toml", measured)
    assert enough.nrmse < 0.01
    assert np.nanmax(enough.truncated) < DOUBTFUL_SHARE
    assert "truncated" not in "".join(where_words(enough))
    with (tmp_path / "system.toml").open("a", encoding="utf-8") as file:
        file.write("[response]\nfrom_Hz = 9.0\nto_Hz = 12.0\nharmonics = 1\n")
    few = compare_pipe(tmp_path / "system.toml", measured)
    assert few.nrmse > 3 * enough.nrmse
    assert np.nanmax(few.truncated) > 2 * DOUBTFUL_SHARE
    assert "the model's own motion is truncated" in "".join(where_words(few))
