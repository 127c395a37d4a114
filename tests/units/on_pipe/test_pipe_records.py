"""Records of any motion: what the model itself would show errs by nothing, what is changed shows where."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from cantilever import cantilever, shaken

from pipeclamp.pages.page import render, specification_of
from pipeclamp.pages.system import pipe_records
from pipeclamp.pages.system.on_pipe import attributed_sections
from pipeclamp.pages.system.pipe_records import records_sections
from pipeclamp.show.on_pipe import attributed_view
from pipeclamp_identification.attribution.answer import SystemComparisonAnswer
from pipeclamp_identification.attribution.attributed import attributed
from pipeclamp_identification.attribution.compared import Compared, compare_measured
from pipeclamp_identification.attribution.verdict import attribute
from pipeclamp_identification.on_pipe.answer import records_answer
from pipeclamp_identification.on_pipe.records import RecordsComparison, compare_records
from pipeclamp_identification.on_pipe.sines import compare_pipe
from pipeclamp_identification.workflow.systems.next_on_pipe import after_pipe_comparison
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.file import law_of, read_law
from pipeclamp_models.pipe.description import Place, parse_pipe
from pipeclamp_models.pipe.modes import reduce
from pipeclamp_system.transient.monolithic import clamp_equations, solve_monolithic

pipe_text = partial(cantilever, up_to_Hz=50, modes="error = 0.001")
system_text = partial(shaken, amplitude_mm=0.5, frequency_Hz=8.0)
MEASUREMENT = """
[[probes]]
name = "tip"
position_m = 3.0
unit = "mm"
[[probes]]
name = "middle"
position_m = 1.5
unit = "m/s2"
[[records]]
file = "sweep.csv"
"""


@pytest.fixture(scope="module")
def measured_bench(tmp_path_factory: pytest.TempPathFactory, write_law: Callable[..., None]) -> Path:
    """A sweep from 4 to 14 Hz, integrated in time: not to be changed."""
    tmp_path = tmp_path_factory.mktemp("bench")
    write_law(tmp_path / "law.json", {"k10": 8.0, "k30": 1.0, "c0": 2.0, "alpha0": 0.7}, v_r=1.0)
    (tmp_path / "pipe.toml").write_text(pipe_text(ratio=0.03), encoding="utf-8")
    (tmp_path / "system.toml").write_text(system_text(), encoding="utf-8")
    time = np.arange(800) / 400

    def drive(t):
        return np.sin(2 * np.pi * (4.0 * t + 10.0 / 4 * t**2))

    places = (Place(name="tip", position_m=3.0), Place(name="middle", position_m=1.5))
    pipe = reduce(parse_pipe(pipe_text(ratio=0.03)).model_copy(update={"probes": places}))
    equations = clamp_equations(law_of(read_law(tmp_path / "law.json")), 0.5, 8.0, 293.15)
    moved = solve_monolithic(pipe, [equations], lambda t: float(drive(t)), time, 1e-6)
    middle = moved.probe_acceleration[:, 1] + drive(time)
    write(tmp_path, np.column_stack([time, drive(time), 1e3 * moved.probes[:, 0], middle]))
    (tmp_path / "measurement.toml").write_text(MEASUREMENT, encoding="utf-8")
    return tmp_path


@pytest.fixture
def bench(measured_bench: Path, tmp_path: Path) -> Path:
    """The bench in a folder of its own, to be changed."""
    return shutil.copytree(measured_bench, tmp_path / "bench")


def write(folder: Path, rows: np.ndarray, drive: str = "acceleration_m_s2") -> None:
    lines = [f"time_s,{drive},tip,middle", *(",".join(map(repr, row)) for row in rows.tolist())]
    (folder / "sweep.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


def rows(bench: Path) -> np.ndarray:
    return np.loadtxt(bench / "sweep.csv", delimiter=",", skiprows=1)


def compared(bench: Path) -> RecordsComparison:
    return compare_records(bench / "system.toml", bench)


def test_a_record_of_the_model_itself(bench):
    assert compared(bench).nrmse < 2e-3


def test_what_is_drawn_first_is_where_the_model_errs_most(bench, monkeypatch):
    monkeypatch.setattr(pipe_records, "PERIODS", 6)  # of a short record
    table = rows(bench)
    off = (table[:, 0] > 1.7) & (table[:, 0] < 1.85)
    table[off, 3] += 3.0
    write(bench, table)
    found = compared(bench)
    (picture,) = records_sections(found)[1].figures
    begin, end = picture.layout.xaxis.range
    assert begin < 1.7
    assert 1.85 < end <= table[-1, 0]
    assert end - begin < table[-1, 0]
    measured = picture.data[0]
    assert (measured.x[0], measured.x[-1]) == (table[0, 0], table[-1, 0]), "a double click shows all"
    assert np.isin(table[(table[:, 0] >= begin) & (table[:, 0] <= end), 0], measured.x).all()
    assert "data" not in specification_of(picture)["narrow"], "one below the other, it is the same data"


def test_what_is_added_is_found_at_its_probe_and_frequency(bench):
    table = rows(bench)
    table[:, 2] += 0.5 * np.sin(2 * np.pi * 11.0 * table[:, 0])
    write(bench, table)
    found = compared(bench)
    added = 0.5 / np.sqrt(2) / np.sqrt(np.mean(table[:, 2] ** 2))
    assert found.breakdowns()[0].parts[0].nrmse == pytest.approx(added, rel=0.02)
    region = found.region()
    assert region.words[0] == "at probe tip"
    assert region.share > 0.9
    answer = records_answer(found).to_dict()
    for parts in (answer["where"]["probes"], answer["where"]["conditions"]["frequency_Hz"]):
        assert sum(part["share"] for part in parts) == pytest.approx(1.0)
    worst = max(answer["where"]["conditions"]["frequency_Hz"], key=lambda part: part["share"])
    low, high = map(float, worst["part"].split(" to "))
    assert low <= 11.0 <= high
    assert "sweep.csv" in render("test", "", records_sections(found))


def test_a_law_that_follows_its_motion_is_taken_for_the_records_own(bench):
    (bench / "system.toml").write_text(system_text(clamp="solve = true"), encoding="utf-8")
    (amplitude, frequency), = compared(bench).pairs[0].conditions  # fmt: skip
    assert 0.01 < amplitude < 5.0
    assert 4.0 < frequency < 14.0


def test_a_record_of_the_model_itself_is_complete(bench):
    """What is wrong is named from a record in command_line/test_compare_pipe.py."""
    assert attribute(Compared(records=compared(bench))).verdict == "complete"


def test_sines_and_a_record_are_asked_together(bench):
    """What the model itself shows in both is complete; the answer holds both, each part of the report its title."""
    described = MEASUREMENT + '[[responses]]\nfile = "sines.csv"\n'
    (bench / "measurement.toml").write_text(described, encoding="utf-8")
    head = "frequency_Hz,acceleration_m_s2,tip_real,tip_imag,middle_real,middle_imag\n"
    frequencies = np.linspace(5.0, 12.0, 8).tolist()
    blank = "".join(f"{f},1.0,1,0,1,0\n" for f in frequencies)
    (bench / "sines.csv").write_text(head + blank, encoding="utf-8")
    tip, middle = compare_pipe(bench / "system.toml", bench).prediction.response.T
    lines = [
        f"{f},1.0,{1e3 * one.real},{1e3 * one.imag},{two.real},{two.imag}\n"
        for f, one, two in zip(frequencies, tip, middle, strict=True)
    ]
    (bench / "sines.csv").write_text(head + "".join(lines), encoding="utf-8")
    held = compare_measured(bench / "system.toml", bench)
    found = attributed(held, lambda what: None)
    following = after_pipe_comparison(found, "system.toml", "measured", reported=False)
    view = attributed_view(found, following)
    assert view.lines[-1].startswith("Next: pipeclamp ")
    told = view.answer
    answer = told.to_dict()
    assert SystemComparisonAnswer.model_validate(answer) == told
    assert list(answer) == ["nrmse", "noise_nrmse", "probes", "sines", "where", "over_time", "attribution"]
    assert list(answer["sines"][0])[2] == "acceleration_m_s2"
    assert not {"displacement_mm", "force_N"} & set(answer["sines"][0])
    assert answer["attribution"]["verdict"] == "complete"
    assert len(answer["sines"]) == 8
    assert [record["file"] for record in answer["over_time"]["records"]] == ["sweep.csv"]
    titles = [section.title for section in attributed_sections(found, following)]
    assert len(set(titles)) == len(titles)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda bench: write(bench, rows(bench), "displacement_mm"), "differentiated twice"),
        (lambda bench: write(bench, rows(bench)[[*range(20), *range(30, 60)]]), "uneven steps"),
        (lambda bench: write(bench, rows(bench) * [1, 1, 0, 0]), "nothing other than 0"),
        (lambda bench: write(bench, rows(bench)[::-1]), "expected it to ascend"),
    ],
)
def test_a_record_that_cant_serve_is_named(bench, change, said):
    change(bench)
    with pytest.raises(UserError, match=said):
        compared(bench)
