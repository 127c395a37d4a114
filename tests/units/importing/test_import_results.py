"""Tables of results, a row a test: told from records, and made campaigns of metrics."""

from __future__ import annotations

import math
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

import pipeclamp as pc
from pipeclamp_identification.importing.raw import Channel, RawTable
from pipeclamp_identification.importing.results.quantities import quantity_of, turned
from pipeclamp_identification.importing.results.recognised import frequency_of_results, holds_results
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
        ("Equivalent damping ratio [%]", "", "damping_ratio"), ("heq", "", "damping_ratio"),
        ("ξ", "%", "damping_ratio"), ("Damping", "N s/mm", "damping_coefficient"), ("Compression ratio", "", ""),
        ("keff_kN/mm", "", "dynamic_stiffness"), ("Gp_Pa", "", "storage_stiffness"), ("Gpp_Pa", "", "loss_stiffness"),
        ("E_prime", "MPa", "storage_stiffness"), ("G_double_prime", "Pa", "loss_stiffness"), ("Pressure_Pa", "", ""),
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


@pytest.mark.parametrize("unit", ["1/s", "/sec", "1/sec", "s-1", "s^-1", "s⁻¹"])
def test_what_is_counted_in_a_second_is_told_by_the_name(unit):
    for name, factor in {"Angular Frequency": 1 / (2 * math.pi), "w": 1 / (2 * math.pi), "Frequency": 1.0}.items():
        assert quantity_of(Channel(name, unit, np.arange(3.0))) == "frequency"
        assert turned("frequency", unit, name).factor == pytest.approx(factor)
    # a way that is an angle is no frequency
    assert quantity_of(Channel("Angular Displacement", "rad", np.arange(3.0))) != "frequency"


def test_names_without_units_are_asked_for_what_they_name(tmp_path):
    """An angular frequency in rad/s, moduli by the part's stiffness; then what no column holds, by a table."""
    file = tmp_path / "sweep.csv"
    rows = zip(2 * math.pi * FREQUENCIES, STORAGE, LOSS, strict=True)
    file.write_text("Angular Frequency;Storage Modulus;Loss Modulus\n" + "".join(f"{w};{a};{b}\n" for w, a, b in rows))
    with pytest.raises(UserError, match="of which no units are stated") as error:
        pc.import_files([file], tmp_path / "x")
    option = re.search(r'--columns "(.*)"', str(error.value))[1]
    assert "frequency=Angular Frequency [rad/s]" in option and "Loss Modulus [12.5 N/mm]" in option
    with pytest.raises(UserError, match="columns file,amplitude_mm") as error:
        pc.import_files([file], tmp_path / "x", columns=option)
    assert option in str(error.value)  # what was stated is in the option to copy
    (tmp_path / "set.csv").write_text("file,amplitude_mm\nsweep.csv,0.01\n")
    pc.import_files([file], tmp_path / "x", columns=option, conditions=tmp_path / "set.csv")
    tests = read_tests(tmp_path / "x")
    assert tests.campaign.runs[0].frequency_Hz == pytest.approx(FREQUENCIES[0])


def test_an_amplitude_that_is_a_strain_is_asked_for_by_the_parts_size(tmp_path):
    file = tmp_path / "sweep.csv"
    rows = zip(2 * math.pi * FREQUENCIES, STORAGE, LOSS, strict=True)
    file.write_text(
        "Angular frequency;Oscillation displacement;Oscillation strain;K';K''\nrad/s;rad;%;N/mm;N/mm\n"
        + "".join(f"{w};1e-3;0.5;{a};{b}\n" for w, a, b in rows)
    )
    with pytest.raises(UserError, match="how far it moves for 1 of its unit") as error:
        pc.import_files([file], tmp_path / "x")
    option = re.search(r'--columns "(.*)"', str(error.value))[1]
    assert option == "amplitude=Oscillation strain [%] [0.02 mm]"
    pc.import_files([file], tmp_path / "x", columns=option)
    assert "0.01" in (tmp_path / "x" / "runs.csv").read_text(encoding="utf-8")


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
    assert (run.frequency_Hz, run.setup.temperature_C, run.amplitude_mm) == (4.0, 20.0, pytest.approx(AMPLITUDE))
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


@pytest.mark.parametrize("names", [("E'", 'E"'), ("E_stor", "E_loss")])
def test_moduli_need_the_parts_stiffness_for_one_of_them(tmp_path, names):
    count = len(FREQUENCIES)
    columns = [FREQUENCIES, np.full(count, 2.0), STORAGE / 50, LOSS / 50]
    file = written(tmp_path / "m.txt", ["Freq", "Amplitude", *names], ["[Hz]", "[µm]", "[MPa]", "[MPa]"], columns)
    with pytest.raises(UserError, match=r"its moduli are the material's") as told:
        pc.import_files(file, tmp_path / "c")
    _, option = shlex.split(str(told.value).rpartition("\n")[2])
    assert option == f"storage_stiffness={names[0]} [MPa] [12.5 N/mm],loss_stiffness={names[1]} [MPa] [12.5 N/mm]"
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


def sweep(path: Path, rows, head="Frequency;Amplitude;K';K\"", units="Hz;mm;N/mm;N/mm") -> Path:
    path.write_text("\n".join([head, *([units] if units else []), *(";".join(map(str, row)) for row in rows)]) + "\n")
    return path


def plain(scale=1.0):
    return [(f, 0.5, scale * 900 * f**0.1, scale * 150 * f**0.2) for f in (1, 2, 5, 10, 20, 50)]


def test_later_files_of_results_join_and_known_ones_change_nothing(tmp_path):
    folder = tmp_path / "c"
    pc.import_files(sweep(tmp_path / "one.csv", plain()), folder, name="mount", notes="rubber")
    table = (folder / "runs.csv").read_text()
    # what the user changes stays
    changed = table.replace("run,amplitude_mm", "run,temperature_C,amplitude_mm").replace(",0.5,", ",23,0.5,")
    (folder / "runs.csv").write_text(changed)
    description = (folder / "campaign.toml").read_text()
    (folder / "campaign.toml").write_text(f"# mine\n{description}")
    again = pc.import_files(tmp_path / "one.csv", folder)
    assert not again.written and "nothing to do, 1 file named and there already" in again.view().lines[0]
    assert (folder / "runs.csv").read_text() == changed
    files = [tmp_path / "one.csv", sweep(tmp_path / "two.csv", plain(1.1))]
    found = pc.import_files(files, folder)
    answer = found.to_dict()
    assert found.written and (answer["new_files"], answer["known_files"]) == (["two.csv"], ["one.csv"])
    assert [run["run"] for run in answer["runs"] if run["new"]] == [f"two_{place}" for place in range(1, 7)]
    assert {run["file"] for run in answer["runs"]} == {"one.csv", "two.csv"}
    campaign = read_tests(folder).campaign
    assert (campaign.name, campaign.notes, len(campaign.runs)) == ("mount", "rubber", 12)
    assert [run.setup.temperature_C for run in campaign.runs[::6]] == [23.0, None]
    assert (folder / "campaign.toml").read_text().startswith("# mine\n")
    with pytest.raises(UserError, match="holds a file of this name with other content"):
        pc.import_files(sweep(tmp_path / "two.csv", plain(1.2)), folder)
    copy = tmp_path / "copy.csv"
    copy.write_bytes((tmp_path / "one.csv").read_bytes())
    assert not pc.import_files(copy, folder).written


def test_records_join_no_campaign_of_results(tmp_path):
    pc.import_files(sweep(tmp_path / "one.csv", plain()), tmp_path / "c")
    time = np.arange(400) / 100
    rows = zip(time, np.sin(6 * time), np.sin(6 * time + 0.1), strict=True)
    record = sweep(tmp_path / "record.csv", rows, "Time [s];Displacement [mm];Force [N]", "")
    with pytest.raises(
        UserError, match=r"record.csv: holds no results, a row a test.*another campaign \(-o\) for records"
    ):
        pc.import_files(record, tmp_path / "c")


def test_files_without_results_may_be_left_out_beside_others(tmp_path):
    """A folder of results with one damaged file had been refused, whatever was stated."""
    (tmp_path / "empty.csv").write_text("")
    files = [tmp_path / "empty.csv", sweep(tmp_path / "one.csv", plain()), sweep(tmp_path / "two.csv", plain(1.1))]
    with pytest.raises(UserError, match=r"1 of 3 files can't be used; nothing was written\n  empty.csv: is empty"):
        pc.import_files(files, tmp_path / "c")
    assert not (tmp_path / "c").exists()
    found = pc.import_files(files, tmp_path / "c", skip_unusable=True)
    assert "empty.csv: left out, for it can't be used: is empty" in " ".join(found.notes)
    assert [one["file"] for one in found.to_dict()["left_out_files"]] == ["empty.csv"]
    # known as such, it is in nobody's way when others come
    found = pc.import_files([files[0], sweep(tmp_path / "three.csv", plain(1.2))], tmp_path / "c")
    assert len(read_tests(tmp_path / "c").campaign.runs) == 18
    assert [one["file"] for one in found.to_dict()["left_out_files"]] == ["empty.csv"]


def test_nothing_is_written_where_the_columns_arent_confirmed(tmp_path):
    from pipeclamp_identification.importing.request import ImportRequest
    from pipeclamp_identification.importing.stated import Options
    from pipeclamp_identification.importing.whole import import_campaign

    shown = []

    def refused(found):
        shown.extend(name for file in found.files for name in file.columns)
        return False

    file = sweep(tmp_path / "one.csv", plain())
    request = ImportRequest([file], tmp_path / "c", Options(), page=lambda found: "", confirm=refused)
    with pytest.raises(UserError, match="nothing was written: the import wasn't confirmed"):
        import_campaign(request)
    assert shown == ["amplitude", "frequency", "storage_stiffness", "loss_stiffness"]
    assert [path.name for path in tmp_path.iterdir()] == ["one.csv"]


def test_a_page_shows_stiffness_and_loss_angle_over_what_was_varied(tmp_path):
    rows = [
        (f, A, 900 * f**0.1 / A, 150 * f**0.2 / A, T) for T in (20, 60) for A in (0.1, 0.5) for f in (1, 10, 100)
    ]  # fmt: skip
    file = sweep(tmp_path / "a.csv", [*rows, (5, 0.5, 900, -1, 20)], "f;A;K';K\";T", "Hz;mm;N/mm;N/mm;°C")
    found = pc.import_files(file, tmp_path / "c")
    page = (tmp_path / "c" / "import.html").read_text(encoding="utf-8")
    titles = [section.title for section in found.page().sections]
    assert titles == [
        "What was imported", "Against f / Hz", "Against A / mm", "Against T / °C", "All tests", "What was cut",
    ]  # fmt: skip
    assert "A 0.1 mm, T 20 °C" in page and "make energy" in page
    figure = found.page().sections[1].figures[0]
    assert [figure.layout[f"yaxis{n}"].title.text for n in ("", 2, 3)] == ["k' / N/mm", "k'' / N/mm", "δ / °"]
    assert figure.layout.xaxis.type == "log"
    first = figure.data[0]
    assert list(first.x) == [1, 10, 100]
    assert list(first.y) == pytest.approx([900 * f**0.1 / 0.1 for f in (1, 10, 100)], rel=1e-4)
    delta = next(trace for trace in figure.data if trace.yaxis == "y3")
    assert list(delta.y) == pytest.approx([math.degrees(math.atan(f**0.1 / 6)) for f in (1, 10, 100)], rel=1e-4)


def test_results_whose_names_alone_tell_are_asked_their_units(tmp_path):
    """Their frequency had been proposed for the time, and their stiffness for the force, of a record."""
    file = sweep(tmp_path / "a.csv", plain(), "Frequency;Amplitude;Storage stiffness;Loss stiffness", "")
    with pytest.raises(UserError, match="holds results, a row a test, of which no units are stated") as told:
        pc.import_files(file, tmp_path / "c")
    option = str(told.value).partition('--columns "')[2].rstrip('"')
    assert option.startswith("frequency=Frequency [Hz],amplitude=Amplitude [mm],storage_stiffness=")
    pc.import_files(file, tmp_path / "c", columns=option)
    assert len(read_tests(tmp_path / "c").campaign.runs) == 6


@pytest.mark.parametrize(
    ("row", "why"),
    [
        ((1, 0.5, 1e300, 1e299), "below 1e-50 or above 1e\\+50"), ((1, 1e-300, 900, 150), "below 1e-50"),
        (("nan", 0.5, 900, 150), "a number is blank"), ((1, 0.5, "OVLD", 150), "a number is blank"),
        ((1, 0.5, 900, ""), "a number is blank"), ((0, 0.5, 900, 150), "frequency_Hz isn't above 0"),
        ((2, 0.5, 900 * 2**0.1, 150 * 2**0.2), "it has the same numbers as run 'a_2'"),
    ],
)  # fmt: skip
def test_rows_that_no_test_gives_are_left_out_with_their_reason(tmp_path, row, why):
    found = pc.import_files(sweep(tmp_path / "a.csv", [*plain(), row]), tmp_path / "c")
    assert len(read_tests(tmp_path / "c").campaign.runs) == 6
    assert re.search(why, " ".join([*found.notes, *map(str, found.found.left_out)]))
    found.report(tmp_path / "a.html")


def test_specimens_and_temperatures_beside_the_columns_are_taken(tmp_path):
    rows = [(*row, "A7" if place % 2 else "B9") for place, row in enumerate(plain())]
    text = sweep(tmp_path / "a.csv", rows, "Frequency;Amplitude;K';K\";Specimen", "Hz;mm;N/mm;N/mm;").read_text()
    (tmp_path / "a.csv").write_text(f"Test temperature: 23 °C\n\n{text}", encoding="utf-8")
    found = pc.import_files(tmp_path / "a.csv", tmp_path / "c")
    runs = read_tests(tmp_path / "c").campaign.runs
    assert [run.setup.specimen for run in runs] == ["B9", "A7"] * 3
    assert {run.setup.temperature_C for run in runs} == {23.0} and "counts as blank" not in " ".join(found.notes)


def sheet(path: Path, heading: str, rows) -> Path:
    path.write_text("\n".join([heading, *(",".join(f"{cell:g}" for cell in row) for row in rows)]) + "\n")
    return path


def test_units_behind_an_underscore_tell_results(tmp_path):
    """Read as "dynamic_stiffness_N" in mm, they had made a record of it."""
    rows = [(f, 0.1, 300 * f**0.1, 6.0) for f in FREQUENCIES]
    path = sheet(tmp_path / "mount.csv", "frequency_Hz,amplitude_mm,dynamic_stiffness_kN/m,loss_angle_deg", rows)
    pc.import_files([path], tmp_path / "mount")
    run = read_tests(tmp_path / "mount").campaign.runs[0]
    assert run.stiffness == pytest.approx(rows[0][2], rel=1e-5)
    assert math.degrees(run.loss_angle) == pytest.approx(6.0, rel=1e-5)


def test_a_damping_ratio_is_half_of_what_a_cycle_loses_over_its_secant(tmp_path):
    """dW = 2 pi zeta k X^2, as reports of isolators have it; what no ellipse loses is left out with its reason."""
    rows = [(0.5, 25, 1.3, 15.0), (0.5, 50, 1.05, 12.0), (0.5, 100, 0.9, 60.0)]
    heading = "Frequency [Hz],Amplitude [mm],Effective stiffness [kN/mm],Equivalent damping ratio [%]"
    found = pc.import_files([sheet(tmp_path / "isolator.csv", heading, rows)], tmp_path / "isolator")
    assert "no ellipse has a damping ratio of 0.5 or more" in " ".join(found.notes)
    runs = read_tests(tmp_path / "isolator").campaign.runs
    assert [run.stiffness for run in runs] == pytest.approx([1300, 1050], rel=1e-5)
    assert [run.loss_factor for run in runs] == pytest.approx([0.3, 0.24], rel=1e-5)
    # beside a storage stiffness the loss is of that
    path = sheet(tmp_path / "other.csv", "f Hz,ampl mm,K' N/mm,heq", [(1, 0.1, 900, 0.6), (1, 0.2, 800, 0.1)])
    pc.import_files([path], tmp_path / "other")
    first = read_tests(tmp_path / "other").campaign.runs[0]
    assert first.stiffness == pytest.approx(900 * math.hypot(1, 1.2), rel=1e-5)


def test_a_damping_ratio_that_is_stated_as_a_loss_factor_is_told(tmp_path):
    heading = "Frequency [Hz],Amplitude [mm],Stiffness [kN/mm],Damping ratio [%],Load [kN]"
    path = sheet(tmp_path / "isolator.csv", heading, [(0.5, 25, 1.3, 15.0, 500), (0.5, 50, 1.05, 12.0, 500)])
    found = pc.import_files([path], tmp_path / "isolator", columns="loss_factor=Damping ratio")
    told = " ".join(found.notes)
    assert 'twice that: where it is what it is called, --columns "damping_ratio=Damping ratio [%]"' in told
    assert 'to keep one as a condition: --columns "load_kN=Load [kN]"' in told


def test_a_sweep_of_the_amplitude_needs_no_column_of_its_frequency(tmp_path):
    """Where it is one and the same, a table of conditions states it."""
    assert holds_results(table([("amplitude", "mm"), ("K'", "N/mm"), ("K''", "N/mm")]))
    assert not holds_results(table([("Time", "s"), ("amplitude", "mm"), ("K'", "N/mm"), ("K''", "N/mm")]))
    path = sheet(tmp_path / "sweep.csv", "strain_pct,Gp_Pa,Gpp_Pa", [(1, 900, 150), (5, 800, 160)])
    with pytest.raises(UserError, match="no column is the frequency in Hz"):
        pc.import_files([path], tmp_path / "x")
    (tmp_path / "set.csv").write_text("file,frequency_Hz\nsweep.csv,2\n")
    columns = "amplitude=strain_pct [0.02 mm],storage_stiffness=Gp_Pa [0.1 N/mm],loss_stiffness=Gpp_Pa [0.1 N/mm]"
    pc.import_files([path], tmp_path / "x", columns=columns, conditions=tmp_path / "set.csv")
    runs = read_tests(tmp_path / "x").campaign.runs
    assert [(run.frequency_Hz, run.amplitude_mm) for run in runs] == [(2, 0.02), (2, pytest.approx(0.1))]
