"""Files as other programs lay them out: what they hold is read right, or refused with its remedy."""

from __future__ import annotations

import datetime
import time
from pathlib import Path

import numpy as np
import pytest
from exports import Loop, assert_same_campaign, loop, text

import pipeclamp as pc
from pipeclamp_identification.campaign.records import Record, UnusableRecord
from pipeclamp_identification.importing.channels.mapping import MappedFile, mapped_tables
from pipeclamp_identification.importing.channels.traces import without_wrong_stamps
from pipeclamp_identification.importing.raw import Channel, RawTable
from pipeclamp_identification.importing.reading import SourceFile
from pipeclamp_identification.importing.samples.repair import at_own_rate, evened

RUN = loop(0.5, 2.0, cycles=10)
PLAIN = {"header": "", "decimal": ".", "scales": (1, 1, 1)}


def named(names: str, **options) -> str:
    return text(RUN, names=names, **{**PLAIN, **options})


def grouped(cell: str) -> str:
    return f"{float(cell):,.3f}"


def forces(change, **options) -> str:
    """Give the run with its forces in other words, ten times as large."""
    lines = named("Time [s];Weg [mm];Kraft [N]", scales=(1, 1, 10), **options).splitlines()
    return "\n".join(
        [lines[0], *(f"{';'.join(line.split(';')[:2])};{change(line.split(';')[2])}" for line in lines[1:])]
    )


LABVIEW = (
    "LabVIEW Measurement\t\nSeparator\tTab\nDate\t2024/02/01\n***End_of_Header***\t\n\t\nChannels\t2\t\t\n"
    "Samples\t1000\t1000\t\nX0\t0\t0\t\nDelta_X\t0.005\t0.005\t\n***End_of_Header***\t\t\n"
)
Y_UNITS = LABVIEW.replace("X0", "Y_Unit_Label\tmm\tN\t\nX_Dimension\tTime\tTime\t\nX0")
WAVEMATRIX = "Total Time (s),Position(8800 (0,1):Position) (mm),Load(8800 (0,1):Load) (N)"
LAYOUTS = {
    "a semicolon ends each row": named("Time [s];Weg [mm];Kraft [N]").replace("\n", ";\n"),
    "names with commas in brackets": named(WAVEMATRIX, delimiter=","),
    "decimal commas in quotes": named('"t [s]","y [mm]","F [N]"', delimiter=",", decimal=",", quote='"'),
    "LabVIEW": named("Time [s]\tWeg [mm]\tKraft [N]\tComment", delimiter="\t", header=LABVIEW),
    "LabVIEW's own units": named("X_Value\tWeg\tLoad Cell\tComment", delimiter="\t", header=Y_UNITS),
    "LabVIEW's own units in words": named(
        "X_Value\tWeg\tLoad Cell\tComment", delimiter="\t",
        header=Y_UNITS.replace("mm\tN", "Millimeters\tNewtons"),
    ),
    "names with units above rates and slots": named(
        "Zeit 1 - Standardmessrate [s]\tWeg [mm]\tKraft [N]\n1 - 200 Hz\tSlot 1\tSlot 2", delimiter="\t"
    ),
    "LabVIEW without a time": "".join(
        f"\t{line.partition(chr(9))[2]}\t\n" if line[0].isdigit() else f"{line}\n"
        for line in named("X_Value\tWeg\tLoad Cell\tComment", delimiter="\t", header=Y_UNITS).splitlines()
    ),
    "units behind labels": named("Zeit;Weg;Kraft", header="y-Einheit;mm;N\nx-Einheit;s;s\nx0;0;0\ndx;1;1\nn;9;9\n"),
    "a comment's sign before names and units": named("% Time, Weg, Kraft\n% s, mm, N", delimiter=", "),
    "names of two lines": named('"Time\n(s)";"Weg\n(mm)";"Kraft\n(N)"'),
    "text in the first row": named("Time [s];Weg [mm];Kraft [N]").replace("\n", "\n-0.005;0;OVLD\n", 1),
}  # fmt: skip


@pytest.mark.parametrize("layout", LAYOUTS)
def test_layouts_of_other_programs_are_read(tmp_path, layout):
    (tmp_path / "a.csv").write_text(LAYOUTS[layout])
    pc.import_files(tmp_path / "a.csv", tmp_path / "c")
    assert_same_campaign(tmp_path / "c", [Loop("a", *list(vars(RUN).values())[1:])])


@pytest.mark.parametrize("second", ["mm\tN", "mm\tkN"])
def test_each_of_labviews_segments_states_its_units(tmp_path, second):
    names = "X_Value\tWeg\tLoad Cell\tComment"
    header = Y_UNITS[Y_UNITS.index("Channels") :].replace("mm\tN", second)
    whole = named(names, delimiter="\t", header=Y_UNITS) + "\n" + named(names, delimiter="\t", header=header)
    (tmp_path / "a.lvm").write_text(whole)
    if second == "mm\tN":
        pc.import_files(tmp_path / "a.lvm", tmp_path / "c")
        assert len(pc.read_campaign(tmp_path / "c")) == 2
    else:
        with pytest.raises(pc.UserError, match="has other columns or units from line"):
            pc.import_files(tmp_path / "a.lvm", tmp_path / "c")


@pytest.mark.parametrize(
    ("change", "decimal"),
    [
        (grouped, "."),
        (lambda cell: grouped(cell).replace(",", "'"), "."),
        (lambda cell: grouped(cell).replace(",", "\u202f").replace(".", ","), ","),
        (lambda cell: grouped(cell.replace(",", ".")).translate(str.maketrans(",.", ".,")), ","),
    ],
)
def test_parted_thousands_are_numbers(tmp_path, change, decimal):
    convert = (lambda cell: change(cell.replace(",", "."))) if decimal == "," else change
    (tmp_path / "a.csv").write_text(forces(convert, decimal=decimal), encoding="utf-8")
    pc.import_files(tmp_path / "a.csv", tmp_path / "c")
    (run,) = pc.read_campaign(tmp_path / "c").tests.campaign.runs
    np.testing.assert_allclose(run.record.force_N, 10 * RUN.force, atol=1e-2)


def noon(seconds: float) -> str:
    begun = datetime.datetime(2024, 2, 1, 12, 59, 57) + datetime.timedelta(seconds=seconds)
    return begun.strftime("%I:%M:%S.%f %p")


@pytest.mark.parametrize(
    "stamp",
    [
        lambda seconds: f"{int(59 + seconds // 60):02d}:{seconds % 60:06.3f}",
        lambda seconds: f"09:00:{int(seconds):02d}:{round(seconds % 1 * 1000):03d}",
        noon,
    ],
)
def test_clocks_of_other_programs_are_read(tmp_path, stamp):
    (tmp_path / "a.csv").write_text(named("Datum/Uhrzeit;Weg [mm];Kraft [N]", stamp=stamp))
    pc.import_files(tmp_path / "a.csv", tmp_path / "c")
    assert_same_campaign(tmp_path / "c", [Loop("a", *list(vars(RUN).values())[1:])], t_step=1e-5)


def test_stamps_of_whole_seconds_tell_the_rate_by_the_whole_ones():
    found = evened(Record(np.floor(RUN.time), RUN.y, RUN.force)).record.time_s
    np.testing.assert_allclose(np.diff(found), 1 / 200, rtol=2e-3)
    with pytest.raises(UnusableRecord, match=r"rounded to 2 s.*--rate"):
        evened(Record(np.floor(RUN.time / 2) * 2, RUN.y, RUN.force))


def test_a_time_that_falls_and_a_rate_beside_a_time_are_told(tmp_path):
    lines = named("Time [s];Weg [mm];Kraft [N]").splitlines()
    (tmp_path / "a.csv").write_text("\n".join([lines[0], *lines[:0:-1]]))
    with pytest.raises(pc.UserError, match=r"a\.csv: its time falls in 999 of 999 steps.*--rate"):
        pc.import_files(tmp_path / "a.csv", tmp_path / "c")
    found = pc.import_files(tmp_path / "a.csv", tmp_path / "c", columns="time=none", rate=200.0)
    assert not any("--rate" in note for note in found.notes)
    (tmp_path / "b.csv").write_text("\n".join(lines))
    found = pc.import_files(tmp_path / "b.csv", tmp_path / "d", rate=100.0)
    assert "--rate isn't used where 'Time [s]' is the time; to use it instead: --columns time=none" in found.notes
    with pytest.raises(pc.UserError, match="time=none' without --rate"):
        pc.import_files(tmp_path / "b.csv", tmp_path / "e", columns="time=none")


def test_channels_in_rows_are_refused(tmp_path):
    rows = (";".join(f"{value:.4f}" for value in values) for values in (RUN.time, RUN.y, RUN.force))
    (tmp_path / "a.csv").write_text("\n".join(rows))
    with pytest.raises(pc.UserError, match=r"has 1000 columns of 3 numbers: its channels seem to stand in rows"):
        pc.import_files(tmp_path / "a.csv", tmp_path / "c")


@pytest.mark.parametrize(
    ("stem", "guess"), [("A0.5_f2_T20", "A{amplitude_mm}_f{frequency_Hz}_T{temperature_C}"), ("a7", ""), ("f12", "")]
)
def test_a_pattern_is_proposed_where_it_says_what_was_measured(tmp_path, stem, guess):
    (tmp_path / f"{stem}.csv").write_text(named("Time [s];Weg [mm];Kraft [N]"))
    assert pc.import_files(tmp_path / f"{stem}.csv", tmp_path / "c", dry_run=True).to_dict()["pattern"] == guess


def test_a_cell_of_any_length_takes_no_time(tmp_path):
    lines = named("Time [s];Weg [mm];Kraft [N]").splitlines()
    (tmp_path / "a.csv").write_text("\n".join([lines[0], "1" * 100_000 + ";0;0", *lines[1:]]))
    begun = time.process_time()
    pc.import_files(tmp_path / "a.csv", tmp_path / "c", dry_run=True)
    assert time.process_time() - begun < 20


@pytest.mark.parametrize("wrong", [{300: 1.0}, {300: 1e6}, {300: 1.0, 700: 0.0}])
def test_a_single_wrong_stamp_parts_no_run(wrong):
    stamps = RUN.time.copy()
    stamps[list(wrong)] = list(wrong.values())
    expected = RUN.time.copy()
    expected[list(wrong)] = np.nan
    np.testing.assert_array_equal(without_wrong_stamps(stamps), expected)
    anew = np.concatenate([RUN.time, RUN.time])
    assert without_wrong_stamps(anew) is anew


def workbook(path: Path, sheets: dict[str, list[list[object]]]) -> Path:
    xlsxwriter = pytest.importorskip("xlsxwriter")
    with xlsxwriter.Workbook(str(path)) as book:
        clock = book.add_format({"num_format": "hh:mm:ss.000"})
        for name, rows in sheets.items():
            sheet = book.add_worksheet(name)
            for number, row in enumerate(rows):
                for place, cell in enumerate(row):
                    if isinstance(cell, datetime.datetime):
                        sheet.write_datetime(number, place, cell, clock)
                    elif cell is not None:
                        sheet.write(number, place, cell)
    return path


HEAD = ["Time [s]", "Weg [mm]", "Kraft [N]"]
ROWS = [list(row) for row in zip(RUN.time.tolist(), RUN.y.tolist(), RUN.force.tolist(), strict=True)]


def test_a_column_that_is_filled_now_and_then_counts_and_sheets_without_a_test_are_told(tmp_path):
    pytest.importorskip("python_calamine")
    warm = [[*row, 80.0 if number % 50 == 7 else None] for number, row in enumerate(ROWS)]
    warm[0][2] = "OVLD"
    path = workbook(
        tmp_path / "a.xlsx",
        {"D": [[*HEAD, "Temperatur [°C]"], *warm], "Summary": [["No", "Kraft [N]", "Weg [mm]"], [1, 600.0, 0.5]]},
    )
    found = pc.import_files(path, tmp_path / "c")
    (run,) = pc.read_campaign(tmp_path / "c").tests.campaign.runs
    assert run.setup.temperature_C == 80.0
    assert "a.xlsx: left aside, without time, displacement and force: 'Summary'" in found.notes
    assert any("'OVLD' in row 2" in note for note in found.notes)


@pytest.mark.parametrize("every", [3, 400])
def test_a_last_column_that_is_blank_in_most_rows_counts(tmp_path, every):
    lines = named("Time [s];Weg [mm];Kraft [N];Temperatur [°C]").splitlines()
    rows = [line + (";80" if number % every == every - 1 else ";") for number, line in enumerate(lines[1:])]
    (tmp_path / "a.csv").write_text("\n".join([lines[0], *rows]), encoding="utf-8")
    pc.import_files(tmp_path / "a.csv", tmp_path / "c")
    (run,) = pc.read_campaign(tmp_path / "c").tests.campaign.runs
    assert run.setup.temperature_C == 80.0
    assert len(run.record.time_s) == len(RUN.time)


def test_a_channel_that_was_written_several_times_over_is_taken_once():
    slow = at_own_rate(Record(RUN.time, RUN.y, np.repeat(RUN.force[2::5], 5)[: len(RUN.time) - 2]))
    assert slow.done == ("force_N holds each number for 5 samples: one of them is kept",)
    whole = Record(RUN.time, RUN.y, RUN.force)
    assert at_own_rate(whole).record is whole
    coarse = Record(RUN.time, np.round(RUN.y, 1), np.round(RUN.force, -2))
    assert at_own_rate(coarse).record is coarse


@pytest.mark.parametrize("units", [["s", "mm", "kN"], ["s", "mm", "N"]])
def test_a_sheet_of_blocks_has_one_unit_of_each_column(tmp_path, units):
    pytest.importorskip("python_calamine")
    blocks = [["t", "y", "F"], ["s", "mm", "N"], *ROWS, [], ["Run 2"], ["t", "y", "F"], units, *ROWS]
    path = workbook(tmp_path / "a.xlsx", {"D": blocks})
    if units[2] == "N":
        assert len(pc.import_files(path, tmp_path / "c", dry_run=True).to_frame()) == 2
        return
    with pytest.raises(pc.UserError, match=f"other columns or units from line {len(ROWS) + 6} on"):
        pc.import_files(path, tmp_path / "c", dry_run=True)


def test_runs_that_stand_beside_each_other_become_tables(tmp_path):
    pytest.importorskip("python_calamine")
    other = loop(0.3, 2.0, cycles=8)
    rows = [[*row, None] for row in ROWS]
    for row, cells in zip(rows, zip(other.time, other.y, other.force, strict=True), strict=False):
        row += cells
    pc.import_files(workbook(tmp_path / "a.xlsx", {"D": [[*HEAD, None, *HEAD], *rows]}), tmp_path / "c")
    records = [run.record for run in pc.read_campaign(tmp_path / "c").tests.campaign.runs]
    assert [len(record.time_s) for record in records] == [len(RUN.time), len(other.time)]


def test_titles_above_the_names_name_what_stands_side_by_side(tmp_path):
    """Shimadzu writes a specimen's name above its first column, a spreadsheet joins the cells of that row."""
    cells = [line.split(";") for line in named("").splitlines()[1:]]
    rows = [["A0.5 north", "", "", "A0.5 south", "", ""], ["Time", "Stroke", "Force"] * 2, ["sec", "mm", "N"] * 2]
    rows += [[*row, *row] for row in cells]
    (tmp_path / "a.csv").write_text("\n".join(",".join(f'"{cell}"' for cell in row) for row in rows))
    found = pc.import_files(tmp_path / "a.csv", tmp_path / "c", dry_run=True).to_frame()
    assert found["run"].to_list() == ["a_A0.5_north", "a_A0.5_south"]


def test_a_response_without_name_and_unit_has_those_of_its_number_and_system(tmp_path):
    """Of a file in mm and mN: a system's factors turn SI into its units."""
    pyuff = pytest.importorskip("pyuff")
    file = pyuff.UFF(str(tmp_path / "a.unv"))
    system = {"type": 164, "units_code": 5, "units_description": "mm (milli-newton)", "temp_mode": 2}
    file.write_sets(system | {"length": 1e3, "force": 1e3, "temp": 1.0, "temp_offset": 273.15}, "add")
    for number, values in ((8, RUN.y), (13, RUN.force * 1e3)):
        held = {"type": 58, "func_type": 1, "rsp_node": 1, "rsp_dir": 1, "ref_dir": 1, "ref_node": 1, "data": values}
        held |= {"x": RUN.time, "id1": "NONE", "abscissa_spacing": 1, "ord_data_type": 4, "binary": 0}
        file.write_sets(held | {"ordinate_spec_data_type": number, "orddenom_spec_data_type": 0}, "add")
    pc.import_files(tmp_path / "a.unv", tmp_path / "c")
    assert_same_campaign(tmp_path / "c", [Loop("a", *list(vars(RUN).values())[1:])])


def test_a_folder_of_other_endings_names_one(tmp_path):
    (tmp_path / "a.tra").write_text(named("Time [s];Weg [mm];Kraft [N]"))
    for name in ("photo.png", "setup.docx", ".hidden"):
        (tmp_path / name).write_bytes(b"\x89PNG")
    found = pc.import_files(tmp_path, tmp_path / "c", dry_run=True)
    assert len(found.to_frame()) == 1
    assert found.notes == ("not read, for no known format has such an ending: photo.png, setup.docx",)
    for name in ("photo.png", "setup.docx", ".hidden"):
        (tmp_path / name).unlink()
    (tmp_path / "a.tra").rename(tmp_path / "a.foo")
    with pytest.raises(pc.UserError, match=r"\(but 'a.foo'\); .*or the files themselves named"):
        pc.import_files(tmp_path, tmp_path / "c", dry_run=True)


def test_clocks_in_a_workbook_are_seconds_and_numbers_as_text_are_refused(tmp_path):
    pytest.importorskip("python_calamine")
    begun = datetime.datetime(2024, 2, 1, 9)
    rows = [[begun + datetime.timedelta(seconds=row[0]), *row[1:]] for row in ROWS]
    pc.import_files(workbook(tmp_path / "a.xlsx", {"D": [["Uhrzeit", *HEAD[1:]], *rows]}), tmp_path / "c")
    (run,) = pc.read_campaign(tmp_path / "c").tests.campaign.runs
    assert run.cycles.frequency_Hz == pytest.approx(2.0, rel=1e-3)
    texts = [[f"{cell:.4f}".replace(".", ",") for cell in row] for row in ROWS]
    with pytest.raises(pc.UserError, match=r"holds its numbers as text \('0,0000' in row 2 of sheet 'D'\)"):
        pc.import_files(workbook(tmp_path / "b.xlsx", {"D": [HEAD, *texts]}), tmp_path / "d")


def structures(kind: str) -> dict[str, object]:
    """Give two runs as MATLAB's programs keep them."""
    runs = [RUN, loop(0.3, 2.0, cycles=8)]
    fields = [{"time_s": run.time, "displacement_mm": run.y, "force_N": run.force} for run in runs]
    if kind == "a cell of structures":
        cell = np.empty(2, dtype=object)
        cell[:] = fields
        return {"run": cell}
    if kind == "an array of structures":
        array = np.zeros(2, dtype=[(name, "O") for name in (*fields[0], "T")])
        for place, one in enumerate(fields):
            array[place] = (*one.values(), 20.0)
        return {"run": array}
    channels = np.zeros(2, dtype=[("Name", "O"), ("Unit", "O"), ("Data", "O")])
    found = {}
    for place, run in enumerate(runs):
        channels = channels.copy()
        channels[0], channels[1] = ("Weg", "mm", run.y), ("Kraft", "N", run.force)
        found[f"rec{place}"] = {"X": {"Name": "Time", "Unit": "s", "Data": run.time}, "Y": channels}
    return found


@pytest.mark.parametrize("kind", ["a cell of structures", "an array of structures", "dSPACE"])
def test_structures_of_runs_are_read(tmp_path, kind):
    pytest.importorskip("pymatreader")
    from scipy.io import savemat

    savemat(tmp_path / "a.mat", structures(kind))
    pc.import_files(tmp_path / "a.mat", tmp_path / "c")
    records = [run.record for run in pc.read_campaign(tmp_path / "c").tests.campaign.runs]
    assert [len(record.time_s) for record in records] == [1000, 800]


def quantity(label: str, factor: float = 1.0) -> dict[str, object]:
    return {"quantity": {"label": label, "unit_transformation": {"offset": 0.0, "factor": factor}}}


def signal(names: object, values: np.ndarray, label: str, factor: float = 1.0) -> dict[str, object]:
    """Give a signal as Simcenter Testlab keeps it."""
    x_values = {"start_value": 0.0, "increment": 0.005, "number_of_values": float(len(values)), **quantity("s")}
    y_values = {"values": values, **quantity(label, factor)}
    return {"x_values": x_values, "y_values": y_values, "function_record": {"name": names}}


def test_structures_call_their_runs_and_state_what_holds_for_them(tmp_path):
    """The runs had been runs(1), runs(2), and of no temperature."""
    pytest.importorskip("pymatreader")
    from scipy.io import savemat

    held = [
        {
            "name": f"A{A}_f2", "temp_C": 40.0 + number, "operator": "Y",
            "time": {"value": one.time, "unit": "s"}, "displacement": {"value": one.y, "unit": "mm"},
            "force": {"value": one.force / 1e3, "unit": "kN"},
        }
        for number, A in enumerate((0.3, 0.8))
        for one in [loop(A, 2.0)]
    ]  # fmt: skip
    savemat(tmp_path / "day.mat", {"runs": np.array(held, dtype=object), "specimen": "B 7"})
    found = pc.import_files(tmp_path / "day.mat", tmp_path / "c")
    assert list(found.to_frame()["run"]) == ["day_A0.3_f2", "day_A0.8_f2"]
    assert list(found.to_frame()["temperature_C"]) == [40.0, 41.0]
    runs = pc.read_campaign(tmp_path / "c").tests.campaign.runs
    assert {run.setup.specimen for run in runs} == {"B 7"}


def test_units_that_programs_keep_beside_the_samples_count(tmp_path):
    """Of catman's and Testlab's files in MATLAB's format; a unit beside a factor is asked for."""
    pytest.importorskip("pymatreader")
    from scipy.io import savemat

    catman: dict[str, object] = {"File_Header": {"NumberOfChannels": "3"}}
    named = {
        "Zeit  1 - Standardmessrate": ("s", RUN.time),
        "Weg": ("um", RUN.y * 1e3),
        "Kraft": ("kN", RUN.force / 1e3),
    }
    for number, (name, (unit, values)) in enumerate(named.items(), 1):
        catman[f"Channel_{number}_Header"] = {"SignalName": name, "Unit": unit, "Comment": ""}
        catman[f"Channel_{number}_Data"] = values[:, None]
    savemat(tmp_path / "a.mat", catman)
    several = np.array(["clamp:+X", "clamp:+Z command"], dtype=object)
    both = np.stack([RUN.y, 0 * RUN.y], axis=1) / 1e3
    for name, factor in (("b", 1.0), ("c", 9.80665)):
        cell = signal("cell:+X", RUN.force[:, None], "N", factor)
        savemat(tmp_path / f"{name}.mat", {"Signal_0": signal(several, both, "m"), "Signal_1": cell})
    pc.import_files([tmp_path / "a.mat", tmp_path / "b.mat"], tmp_path / "c")
    assert_same_campaign(tmp_path / "c", [Loop(name, *list(vars(RUN).values())[1:]) for name in "ab"])
    with pytest.raises(pc.UserError, match=r"force=cell:\+X \[N\]"):
        pc.import_files(tmp_path / "c.mat", tmp_path / "d")


def test_each_channel_behind_its_own_time_goes_by_it(tmp_path):
    """Force is sampled half as often, the temperature twice: rows hold samples of different instants."""
    slow, few = RUN.time[1::2], np.array([0.5, 2.0])
    columns = [RUN.time, RUN.y, slow, RUN.force[1::2], few, np.array([20.0, 30.0])]
    lines = ["Zeit 1;Weg;Zeit 2;Kraft;Zeit 3;T", "s;mm;s;N;s;°C"]
    for row in range(len(RUN.time)):
        lines += [";".join(f"{column[row]:.6f}" if row < len(column) else "" for column in columns)]
    (tmp_path / "a.csv").write_text("\n".join(lines), encoding="utf-8")
    found = pc.import_files(tmp_path / "a.csv", tmp_path / "c")
    assert "a.csv: put on the times of the fastest channel by straight lines: 'Kraft [N]'" in found.notes
    (run,) = pc.read_campaign(tmp_path / "c").tests.campaign.runs
    within = (RUN.time >= slow[0]) & (RUN.time <= slow[-1])
    np.testing.assert_allclose(run.record.displacement_mm, RUN.y[within], atol=1e-6)
    np.testing.assert_allclose(run.record.force_N, np.interp(RUN.time[within], slow, columns[3]), atol=1e-5)
    assert run.setup.temperature_C == pytest.approx(np.mean(np.interp(RUN.time[within], few, [20, 30])), abs=0.01)


def test_a_slow_channel_joins_the_one_test_and_stands_still_beyond_its_ends():
    def table(name: str, **channels: np.ndarray) -> RawTable:
        return RawTable(name, tuple(Channel(own, "", values) for own, values in channels.items()))

    test = table("1", time_s=RUN.time, displacement_mm=RUN.y, force_N=RUN.force)
    slow = table("2", time_s=np.array([1.0, 2, 3]), temperature_C=np.array([20.0, 30, 40]))
    found = mapped_tables(SourceFile(Path("a.mf4"), "MDF", (test, slow)), (), None, ask=False)
    assert isinstance(found, MappedFile)
    ((joined, mapped),) = found.tables
    assert joined.length == test.length
    assert [column.ours for column in mapped.columns] == ["time", "displacement", "force", "temperature"]
    assert joined.channels[-1].values[[0, 300, -1]] == pytest.approx([20, 25, 40])
    # an event's few samples don't cut short a test whose channels stand in groups of their own
    parts = [table("1", time_s=RUN.time, displacement_mm=RUN.y), table("2", time_s=RUN.time, force_N=RUN.force)]
    event = table("3", time_s=np.array([0.0, 1.0]), Event=np.array([0.0, 1.0]))
    found = mapped_tables(SourceFile(Path("a.mf4"), "MDF", (*parts, slow, event)), (), None, ask=False)
    assert isinstance(found, MappedFile)
    assert [(one.length, len(one.channels)) for one, _ in found.tables] == [(test.length, 5)]


def tdms_of(path, groups, root=None):
    """Write a TDMS file: groups of channels by name, with the group's properties."""
    nptdms = pytest.importorskip("nptdms")
    with nptdms.TdmsWriter(str(path)) as writer:
        for name, properties, channels in groups:
            held = [
                nptdms.ChannelObject(
                    name, channel, np.asarray(values), properties={"unit_string": unit} if unit else {}
                )
                for channel, unit, values in channels
            ]
            writer.write_segment(
                [nptdms.RootObject(properties=root or {}), nptdms.GroupObject(name, properties), *held]
            )


def test_properties_of_a_tdms_file_state_what_its_records_dont_show(tmp_path):
    runs = [loop(0.5), loop(0.3)]
    groups = [
        (
            f"Run {number}",
            {"Temperatur [K]": 293.15 + number, "Amplitude [mm]": 99.0, "Frequency [Hz]": 2500.0, "Temp": 7.0},
            [("Zeit", "s", run.time), ("Weg", "mm", run.y), ("Kraft", "N", run.force)],
        )
        for number, run in enumerate(runs)
    ]
    tdms_of(tmp_path / "day.tdms", groups, root={"Prüfling Nr": "A-17", "Temperature [°C]": "-9999"})
    found = pc.import_files([tmp_path / "day.tdms"], tmp_path / "campaign")
    assert any("specimen" in note and "temperature_C" in note for note in found.notes)
    read = pc.read_campaign(tmp_path / "campaign").tests.campaign.runs
    assert [(run.setup.specimen, run.setup.temperature_C) for run in read] == [("A-17", 20.0), ("A-17", 21.0)]
    assert [run.amplitude_mm for run in read] == pytest.approx([0.5, 0.3], rel=1e-2)
    # what a pattern states counts more
    pc.import_files([tmp_path / "day.tdms"], tmp_path / "stated", pattern="Run_{specimen}")
    read = pc.read_campaign(tmp_path / "stated").tests.campaign.runs
    assert [run.setup.specimen for run in read] == ["0", "1"]


def test_each_group_of_a_tdms_file_has_its_own_slow_channels(tmp_path):
    runs = [loop(0.5), loop(0.3)]
    nptdms = pytest.importorskip("nptdms")
    with nptdms.TdmsWriter(str(tmp_path / "day.tdms")) as writer:
        for number, run in enumerate(runs):
            slow = np.full(len(run.time) // 20 + 1, 40.0 + number)
            writer.write_segment(
                [
                    nptdms.ChannelObject(
                        f"Run {number}",
                        name,
                        values,
                        {"unit_string": unit, "wf_increment": (20 if name == "PT100" else 1) / 200},
                    )
                    for name, unit, values in [("Weg", "mm", run.y), ("Kraft", "N", run.force), ("PT100", "°C", slow)]
                ]
            )
    found = pc.import_files([tmp_path / "day.tdms"], tmp_path / "campaign")
    assert any("PT100" in note and "straight lines" in note for note in found.notes)
    read = pc.read_campaign(tmp_path / "campaign").tests.campaign.runs
    assert [(run.name, run.setup.temperature_C) for run in read] == [("day_Run_0", 40.0), ("day_Run_1", 41.0)]


def test_attributes_of_hdf5_groups_state_what_their_records_dont_show(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "day.h5", "w") as file:
        file.attrs["Prüftemperatur"] = "23 °C"
        for number, run in enumerate([loop(0.5), loop(0.3)]):
            group = file.create_group(f"run {number}")
            group.attrs.update({"Specimen": "A-17", "rate": 200.0} | ({"temperature_C": -40.0} if number else {}))
            for name, values in (("time_s", run.time), ("Weg_mm", run.y), ("Kraft_N", run.force)):
                group[name] = values
    pc.import_files([tmp_path / "day.h5"], tmp_path / "campaign")
    read = pc.read_campaign(tmp_path / "campaign").tests.campaign.runs
    assert [(run.setup.specimen, run.setup.temperature_C) for run in read] == [("A-17", 23.0), ("A-17", -40.0)]


def test_a_measured_temperature_goes_before_a_propertys_without_a_word(tmp_path):
    run = loop(0.5)
    channels = [("t", "s", run.time), ("Weg", "mm", run.y), ("Kraft", "N", run.force), ("T", "°C", 0 * run.time + 60)]
    tdms_of(tmp_path / "day.tdms", [("Data", {}, channels)], root={"Test temperature (°C)": 20.0})
    found = pc.import_files([tmp_path / "day.tdms"], tmp_path / "campaign")
    assert pc.read_campaign(tmp_path / "campaign").tests.campaign.runs[0].setup.temperature_C == 60.0
    assert not any("own properties" in note for note in found.notes)


def test_what_files_properties_state_alike_is_told_once(tmp_path):
    for number, run in enumerate([loop(0.5), loop(0.3), loop(0.4)]):
        channels = [("Zeit", "s", run.time), ("Weg", "mm", run.y), ("Kraft", "N", run.force)]
        tdms_of(tmp_path / f"{number}.tdms", [("Data", {}, channels)], root={"Specimen": "mount 12"})
    found = pc.import_files([tmp_path], tmp_path / "campaign")
    told = [note for note in found.notes if "specimen" in note]
    assert told == ["0.tdms and 2 more: specimen taken from the file's own properties"]


def test_a_channel_of_texts_in_a_tdms_file_names_its_runs(tmp_path):
    runs = [loop(0.5), loop(0.3)]
    time = np.concatenate([runs[0].time, runs[1].time + runs[0].time[-1] + 1.0])
    texts = np.repeat(["slow", "small"], [len(run.time) for run in runs])
    channels = [
        ("Zeit", "s", time),
        ("Weg", "mm", np.concatenate([run.y for run in runs])),
        ("Kraft", "N", np.concatenate([run.force for run in runs])),
        ("Versuch", "", texts),
    ]
    tdms_of(tmp_path / "day.tdms", [("Data", {}, channels)])
    found = pc.import_files([tmp_path / "day.tdms"], tmp_path / "campaign")
    assert [run["run"] for run in found.to_dict()["runs"]] == ["slow", "small"]
