"""Tables of results, a row a test: told from records, and made campaigns of metrics."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import pipeclamp as pc
from pipeclamp_identification.importing.raw import Channel, RawTable
from pipeclamp_identification.importing.results.quantities import quantity_of, turned
from pipeclamp_identification.importing.results.recognised import frequency_of_results
from pipeclamp_identification.importing.texts.sniffing import layout_of
from pipeclamp_identification.workflow.reading import read_tests
from pipeclamp_models.base.errors import UsageError, UserError

FREQUENCIES = np.array([0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0])
STORAGE, LOSS = 900 * FREQUENCIES**0.1, 150 * FREQUENCIES**0.2
AMPLITUDE = 0.002


def written(path: Path, names, units, columns) -> Path:
    """A table as an analyser prints it: right-aligned, a row of units, a remark below."""
    rows = [names, units, *([f"{value:.5e}" for value in row] for row in zip(*columns, strict=True))]
    text = "\r\n".join("".join(f"{cell:>14}" for cell in row) for row in rows)
    path.write_text(text + "\r\n£]7[X\r\n", encoding="cp1252")
    return path


def analyser(path: Path, temperature=20.0, scale=1.0) -> Path:
    k = scale * np.hypot(STORAGE, LOSS)
    count = len(FREQUENCIES)
    columns = [
        np.arange(count), np.full(count, temperature), 60.0 * np.arange(count), FREQUENCIES, k * AMPLITUDE,
        np.full(count, 1e3 * AMPLITUDE), np.arctan2(LOSS, STORAGE), np.full(count, -0.05), STORAGE / 50, LOSS / 50,
    ]  # fmt: skip
    names = ["Index", "Ts", "t", "f", "F", "x", "Phase", "F0", "G'", 'G"']
    return written(
        path, names, ["[#]", "[°C]", "[s]", "[Hz]", "[N]", "[µm]", "[rad]", "[N]", "[MPa]", "[MPa]"], columns
    )


def table(channels, length=8):
    return RawTable("", tuple(Channel(name, unit, np.arange(1.0, length + 1)) for name, unit in channels))


@pytest.mark.parametrize(
    ("name", "unit", "quantity"),
    [
        ("K'", "N/mm", "storage_stiffness"), ("K''", "N/mm", "loss_stiffness"), ('K"', "kN/m", "loss_stiffness"),
        ("K*", "N/mm", "dynamic_stiffness"), ("Dyn. Stiffness [lb/in]", "", "dynamic_stiffness"),
        ("Static Stiffness", "N/mm", ""), ("Loss Angle", "deg", "loss_angle"), ("Phase", "°", "loss_angle"),
        ("tan δ", "", "loss_factor"), ("Tan Delta", "-", "loss_factor"), ("Verlustfaktor", "", "loss_factor"),
        ("Frequency", "Hz", "frequency"), ("ω", "rad/s", "frequency"), ("Sample frequency", "Hz", ""),
        ("Displacement Amplitude", "mm", "amplitude"),
        ("DynAmpl", "mm", "amplitude"), ("Mean Displacement", "mm", ""), ("x0", "µm", ""),
        ("E'", "MPa", "storage_stiffness"), ("Supply pressure", "bar", ""), ("Load", "kN", "force_amplitude"),
    ],
)  # fmt: skip
def test_columns_of_results_are_told_by_names_and_units(name, unit, quantity):
    assert quantity_of(Channel(name, unit, np.arange(3.0))) == quantity


def test_amplitudes_and_angular_frequencies_are_turned():
    assert turned("frequency", "rad/s").factor == pytest.approx(1 / (2 * math.pi))
    assert turned("amplitude", "mm", "Dyn. Disp. p-p").factor == 0.5
    assert turned("force_amplitude", "kN", "Force RMS").factor == pytest.approx(1e3 * math.sqrt(2))
    assert turned("dynamic_stiffness", "lb/in").factor == pytest.approx(0.175127, rel=1e-5)


def test_a_record_with_a_frequency_and_a_phase_is_none_of_results():
    time = np.arange(1000) / 200.0
    plain = [("Frequency", "Hz", np.full(1000, 2.0)), ("Phase", "deg", np.full(1000, 9.0)), ("Force", "N", time)]
    channels = [Channel("Time", "s", time), *(Channel(*one) for one in plain)]
    assert frequency_of_results(RawTable("", tuple(channels))) is None
    # nor one whose column of the frequency is that of sampling
    sampled = RawTable("", (channels[0], Channel("Frequency", "Hz", np.full(1000, 200.0)), *channels[2:]))
    assert frequency_of_results(sampled) is None
    slow = RawTable("", (Channel("Time", "s", 60.0 * np.arange(8)), Channel("f", "Hz", FREQUENCIES)))
    assert frequency_of_results(slow).heading == "f [Hz]"


def test_an_analysers_table_becomes_a_campaign_of_metrics(tmp_path):
    """It had been taken for a record, a sample a row: amplitudes over the minutes of a sweep."""
    files = [analyser(tmp_path / "T20.txt"), analyser(tmp_path / "T40.txt", temperature=40.0, scale=0.5)]
    found = pc.import_files(files, tmp_path / "c")
    assert found.written and len(found.to_dict()["runs"]) == 16
    assert "not used: 'Index [#]', 't [s]', 'F0 [N]', \"G' [MPa]\", 'G\" [MPa]'" in " ".join(found.notes)
    view = found.view()
    assert view.lines[0].endswith("c: 16 tests of 2 files, known by stiffness and loss, without a record")
    assert view.lines[-1].startswith("Next: pipeclamp identify") and len(view.tables[1].rows) == 16
    campaign = read_tests(tmp_path / "c").campaign
    run = campaign.runs[3]
    assert (run.frequency_Hz, run.temperature_C, run.amplitude_mm) == (4.0, 20.0, pytest.approx(AMPLITUDE))
    assert run.stiffness == pytest.approx(math.hypot(STORAGE[3], LOSS[3]), rel=1e-4)
    assert run.dissipated_energy_J == pytest.approx(math.pi * LOSS[3] * AMPLITUDE**2 / 1e3, rel=1e-4)
    assert pc.identify(found.tests()).to_dict()


def test_channels_of_a_record_are_refused_of_results(tmp_path):
    with pytest.raises(UsageError, match=r"got time=t \[s\], but each row is a test of its own"):
        pc.import_files(
            analyser(tmp_path / "T20.txt"), tmp_path / "c", columns="time=t [s],displacement=x [µm],force=F [N]"
        )
    assert not (tmp_path / "c").exists()


def test_results_beside_records_are_left_out_by_name(tmp_path):
    from exports import loop

    time, y, force = loop().time, loop().y, loop().force
    rows = ["Time [s],Displacement [mm],Force [N]", *(f"{a},{b},{c}" for a, b, c in zip(time, y, force, strict=True))]
    (tmp_path / "loop.csv").write_text("\n".join(rows) + "\n")
    files = [tmp_path / "loop.csv", analyser(tmp_path / "sweep.txt")]
    with pytest.raises(UserError, match=r"sweep.txt: holds results, a row a test \('f \[Hz\]' from 0.5 to 64\)"):
        pc.import_files(files, tmp_path / "c")
    assert len(pc.import_files(files, tmp_path / "c", skip_unusable=True).to_dict()["runs"]) == 1
    with pytest.raises(UserError, match="holds records of tests, which results don't join"):
        pc.import_files(analyser(tmp_path / "again.txt", scale=2.0), tmp_path / "c")


def test_moduli_need_the_parts_stiffness_for_one_of_them(tmp_path):
    count = len(FREQUENCIES)
    columns = [FREQUENCIES, np.full(count, 2.0), STORAGE / 50, LOSS / 50]
    file = written(tmp_path / "m.txt", ["Freq", "Amplitude", "E'", 'E"'], ["[Hz]", "[µm]", "[MPa]", "[MPa]"], columns)
    with pytest.raises(UserError, match=r"its moduli are the material's") as told:
        pc.import_files(file, tmp_path / "c")
    option = str(told.value).partition("--columns '")[2].rpartition("'")[0].replace("'\"'\"'", "'")
    assert option == "storage_stiffness=E' [MPa] [12.5 N/mm],loss_stiffness=E\" [MPa] [12.5 N/mm]"
    pc.import_files(file, tmp_path / "c", columns=option.replace("12.5", "50"))
    runs = read_tests(tmp_path / "c").campaign.runs
    assert [run.stiffness for run in runs] == pytest.approx(np.hypot(STORAGE, LOSS).tolist(), rel=1e-4)


def test_dynamic_stiffness_and_loss_angle_serve_with_an_amplitude_of_the_name(tmp_path):
    columns = [FREQUENCIES, np.hypot(STORAGE, LOSS), np.degrees(np.arctan2(LOSS, STORAGE))]
    (tmp_path / "A0.5.csv").write_text(
        "Frequency;Dynamic Stiffness;Loss Angle\nHz;N/mm;deg\n"
        + "\n".join(";".join(f"{x:.6f}".replace(".", ",") for x in row) for row in zip(*columns, strict=True))
    )
    with pytest.raises(UserError, match="no column is the amplitude in mm"):
        pc.import_files(tmp_path / "A0.5.csv", tmp_path / "c")
    pc.import_files(tmp_path / "A0.5.csv", tmp_path / "c", pattern="A{amplitude_mm}")
    run = read_tests(tmp_path / "c").campaign.runs[0]
    assert run.amplitude_mm == 0.5 and run.loss_factor == pytest.approx(LOSS[0] / math.hypot(STORAGE[0], LOSS[0]), 1e-4)


def test_rows_that_no_passive_part_shows_are_left_out_and_weak_ones_told(tmp_path):
    phase = np.arctan2(LOSS, STORAGE)
    phase[0], phase[1] = -0.2, 2.0
    force = np.hypot(STORAGE, LOSS) * AMPLITUDE
    x = np.full(8, 1e3 * AMPLITUDE)
    force[2], x[2] = force[2] / 500, x[2] / 500
    names, units = ["f", "F", "x", "Phase"], ["[Hz]", "[N]", "[µm]", "[rad]"]
    file = written(tmp_path / "a.txt", names, units, [FREQUENCIES, force, x, phase])
    told = " ".join(pc.import_files(file, tmp_path / "c").notes)
    assert "1 of 8 rows left out, its storage stiffness isn't above 0: row 4" in told
    assert "1 of 8 rows left out, its loss stiffness isn't above 0, so that it would make energy: row 3" in told
    assert "the force's amplitude of 1 of 6 tests is below 1% of the largest" in told


def test_two_columns_that_may_be_one_quantity_are_asked(tmp_path):
    twice = [("Frequency", "Hz"), ("K'", "N/mm"), ("K''", "N/mm"), ("Amplitude A", "mm"), ("Amplitude B", "mm")]
    rows = [",".join(f"{name} [{unit}]" for name, unit in twice), *(f"{n + 1},9,2,0.1,0.2" for n in range(8))]
    (tmp_path / "a.csv").write_text("\n".join(rows) + "\n")
    with pytest.raises(UserError, match=r'2 columns may be the amplitude.*--columns "amplitude=Amplitude A \[mm\]"'):
        pc.import_files(tmp_path / "a.csv", tmp_path / "c")
    pc.import_files(tmp_path / "a.csv", tmp_path / "c", columns="amplitude=Amplitude B [mm]")
    assert read_tests(tmp_path / "c").campaign.runs[0].amplitude_mm == 0.2


@pytest.mark.parametrize(
    ("text", "names", "units"),
    [
        (
            "T=0;Mw=94.9;chem=PI;\nFreq\t    G'\t        G\"\t        Temp\t    Strain\n"
            "rad/s\t    Pa\t        Pa\t        °C\t        %\n100  3.48E5  70871  -0.0079  0.967\n"
            "68.1  3.33E5  70723  -0.0088  0.964\n46.4  3.17E5  71696  -0.0101  0.962\n",
            ("Freq", "G'", 'G"', "Temp", "Strain"), ("rad/s", "Pa", "Pa", "°C", "%"),
        ),
        (
            "Report;Rig 7\nPreload;-500;N\n\nFreq;DynAmpl p-p;K*;Phase;K';K\";C\nHz;mm;N/mm;deg;N/mm;N/mm;Ns/mm\n"
            "1,0;0,20;310,2;6,10;308,4;32,96;5,246\n5,0;0,20;321,7;6,90;319,4;38,65;1,230\n",
            ("Freq", "DynAmpl p-p", "K*", "Phase", "K'", 'K"', "C"),
            ("Hz", "mm", "N/mm", "deg", "N/mm", "N/mm", "Ns/mm"),
        ),
        ("t,A,D,Y,fs,V,F\n0,1,2,3,4,5,6\n1,1,2,3,4,5,6\n", ("t", "A", "D", "Y", "fs", "V", "F"), ("",) * 7),
    ],
)  # fmt: skip
def test_rows_of_units_of_results_are_told_from_names(text, names, units):
    layout = layout_of(text.splitlines())
    assert (layout.names, layout.units) == (names, units)
