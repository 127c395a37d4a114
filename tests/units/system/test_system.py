"""SYSTEM.toml and its excitation: what is read, what is refused."""

from __future__ import annotations

from math import pi, sin
from pathlib import Path

import numpy as np
import pytest

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.toml_file import parse_table
from pipeclamp_system.description.excitation import excitation_signal
from pipeclamp_system.description.system import ExcitationTable, SystemDescription, read_system

SYSTEM = """
name = "bench"
[pipe]
file = "PIPE.toml"
[[clamps]]
at = "clamp1"
law = "LAW.json"
temperature_C = 20
amplitude_mm = 0.5
[excitation]
kind = "sine"
acceleration_m_s2 = 2.0
frequency_Hz = 9.0
[run]
stop_s = 1.0
step_s = 1e-3
"""


def test_a_system_is_read(tmp_path: Path) -> None:
    file = tmp_path / "SYSTEM.toml"
    file.write_text(SYSTEM, encoding="utf-8")
    system = read_system(file)
    assert system.clamps[0].at == "clamp1"
    assert system.run.scheme == "iterated"
    assert system.run.steps == 1000


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (('file = "PIPE.toml"', ""), ["pipe", "file", "fmu"]),
        (('law = "LAW.json"', 'law = "LAW.json"\nfmu = "x.fmu"'), ["clamps[1]", "either"]),
        (("amplitude_mm = 0.5", ""), ["clamps[1]", "amplitude_mm", "track = true"]),
        (("amplitude_mm = 0.5", 'track = "yes"'), ["clamps[1].track", "got 'yes'; expected true or false"]),
        (("temperature_C = 20", ""), ["clamps[1].temperature_C", "is missing"]),
        (("temperature_C = 20", "temperature_C = -300"), ["clamps[1].temperature_C", "-273.15", "-300"]),
        (("temperature_C", "temperatur_C"), ["clamps[1]", "did you mean 'temperature_C'"]),
        (("frequency_Hz = 9.0", ""), ["excitation", "needs frequency_Hz"]),
        (("acceleration_m_s2 = 2.0", ""), ["excitation", "one amplitude"]),
        (("acceleration_m_s2 = 2.0", "acceleration_m_s2 = 2.0\nforce_N = 1.0"), ["excitation", "one amplitude"]),
        (("frequency_Hz = 9.0", "frequency_Hz = 9.0\nto_Hz = 9.0"), ["excitation", "to_Hz", "'sine'"]),
        (('kind = "sine"', 'kind = "sinus"'), ["excitation.kind", "'sine'", "'sinus'"]),
        (("step_s = 1e-3", "step_s = 2.0"), ["run", "step_s = 2", "stop_s = 1"]),
        (("step_s = 1e-3", "step_s = 1e-9"), ["run", "1000000000 steps", "5000000"]),
        (("step_s = 1e-3", 'step_s = 1e-3\nscheme = "newton"'), ["run.scheme", "'parallel'", "'newton'"]),
        (("step_s = 1e-3", "step_s = 1e-3\nmax_iterations = 1"), ["run.max_iterations", "2"]),
        (("[excitation]", SYSTEM[SYSTEM.index("[[clamps]]") : SYSTEM.index("[exc")] + "[excitation]"), ["there twice"]),
        (('kind = "sine"', 'kind = "record"'), ["excitation", "needs file"]),
    ],
)
def test_a_wrong_system_is_refused_with_its_place(change: tuple[str, str], words: list[str]) -> None:
    with pytest.raises(UserError) as refused:
        parse_table(SYSTEM.replace(*change, 1), SystemDescription, "SYSTEM.toml")
    assert all(word in str(refused.value) for word in words), refused.value


def test_a_law_needs_a_frequency_where_the_excitation_has_no_single_one() -> None:
    swept = SYSTEM.replace('"sine"', '"sweep"').replace("frequency_Hz = 9.0", "from_Hz = 5\nto_Hz = 15")
    swept = swept.replace("from_Hz = 5", "from_Hz = 5.0").replace("to_Hz = 15", "to_Hz = 15.0")
    with pytest.raises(UserError, match=r"clamps\[1\].frequency_Hz is missing"):
        parse_table(swept, SystemDescription, "SYSTEM.toml")
    tracked = parse_table(swept.replace("amplitude_mm = 0.5", "track = true"), SystemDescription, "SYSTEM.toml")
    assert tracked.clamps[0].track


def test_sine() -> None:
    table = ExcitationTable(kind="sine", force_N=3.0, frequency_Hz=7.0)
    signal = excitation_signal(table, "force", 1.0, Path(), "x")
    assert signal(0.013) == pytest.approx(3 * sin(2 * pi * 7 * 0.013))


@pytest.mark.parametrize("last", [9.0, 30.0])
def test_a_displacement_s_acceleration_is_its_second_derivative(last: float) -> None:
    table = ExcitationTable(kind="sweep", displacement_mm=2.0, from_Hz=9.0, to_Hz=last)
    signal = excitation_signal(table, "base", 4.0, Path(), "x")

    def displacement(t: float) -> float:
        return 2e-3 * sin(2 * pi * (9.0 * t + (last - 9.0) / 4.0 * t * t / 2))

    for t in (0.0, 0.31, 2.2, 3.9):
        step = 1e-5
        numeric = (displacement(t + step) - 2 * displacement(t) + displacement(t - step)) / step**2
        assert signal(t) == pytest.approx(numeric, rel=1e-4, abs=1e-3)


def test_a_sweep_ends_at_its_last_frequency() -> None:
    signal = excitation_signal(
        ExcitationTable(kind="sweep", force_N=1.0, from_Hz=5.0, to_Hz=20.0), "force", 10.0, Path(), "x"
    )
    t = np.linspace(9.9, 10.0, 100_001)
    values = np.array([signal(float(x)) for x in t])
    crossings = t[1:][np.diff(np.sign(values)) != 0]
    assert 0.5 / np.diff(crossings)[-1] == pytest.approx(20.0, rel=0.01)


def test_a_record_is_linear_between_its_samples(tmp_path: Path) -> None:
    (tmp_path / "base.csv").write_text("time_s,acceleration_m_s2\n0,0\n1,2\n2,-2\n", encoding="utf-8")
    signal = excitation_signal(ExcitationTable(kind="record", file="base.csv"), "base", 2.0, tmp_path, "x")
    assert [signal(t) for t in (0.0, 0.25, 1.0, 1.5, 2.0)] == pytest.approx([0.0, 0.5, 2.0, 0.0, -2.0])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("time_s,force_N\n0,0\n3,1\n", ["no column 'acceleration_m_s2'", "beside time_s, force_N"]),
        ("time_s,acceleration_m_s2\n0,0\n1,1\n", ["0 to 1 s", "stop_s = 2"]),
        ("time_s,acceleration_m_s2\n0,0\n2,1\n1,3\n", ["row 4", "from 2 to 1", "expected it to ascend"]),
        ("time_s,acceleration_m_s2\n0,0\n2,x\n", ["row 3", "'acceleration_m_s2'", "'x'; expected a finite number"]),
        (
            "time_s,acceleration_m_s2\n0,0\n1,nan\n2,0\n",
            ["row 3", "'acceleration_m_s2'", "'nan'; expected"],
        ),
        ("time_s,acceleration_m_s2\n0,0\n2,\n", ["row 3", "'acceleration_m_s2'", "finite number"]),
        ("", ["can't read this file"]),
    ],
)
def test_a_wrong_record_is_refused(tmp_path: Path, text: str, words: list[str]) -> None:
    (tmp_path / "base.csv").write_text(text, encoding="utf-8")
    with pytest.raises(UserError) as refused:
        excitation_signal(ExcitationTable(kind="record", file="base.csv"), "base", 2.0, tmp_path, "x")
    assert all(word in str(refused.value) for word in ["base.csv", *words]), refused.value


def test_a_record_lies_in_a_file_whatever_its_name(tmp_path: Path) -> None:
    (tmp_path / "run [1].csv").write_text("time_s,acceleration_m_s2\n0,0\n2,1\n", encoding="utf-8")
    signal = excitation_signal(ExcitationTable(kind="record", file="run [1].csv"), "base", 2.0, tmp_path, "x")
    assert signal(1.0) == pytest.approx(0.5)
    for name, words in (("none.csv", "no such file"), (".", "is a folder")):
        with pytest.raises(UserError, match=f"{words}.*; expected CSV"):
            excitation_signal(ExcitationTable(kind="record", file=name), "base", 2.0, tmp_path, "x")


@pytest.mark.parametrize(("kind", "expected"), [("force", "force_N"), ("base", "acceleration_m_s2")])
def test_the_excitation_must_be_of_the_pipe_s_kind(kind: str, expected: str) -> None:
    given = {"acceleration_m_s2": 1.0} if kind == "force" else {"force_N": 1.0}
    table = ExcitationTable(kind="sine", frequency_Hz=1.0, **given)
    with pytest.raises(UserError, match=f"excited by {kind}; expected {expected}"):
        excitation_signal(table, kind, 1.0, Path(), "SYSTEM.toml")
