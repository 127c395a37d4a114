"""Delimited text of any kind: the same ten runs in every dialect are the same campaign."""

from __future__ import annotations

import gzip
import os
from dataclasses import replace

import numpy as np
import polars as pl
import pytest
from exports import assert_same_campaign, loop, ten_runs, text, write_texts

import pipeclamp as pc
from pipeclamp_identification.campaign.description import read_description
from pipeclamp_identification.importing.reading import read_file
from pipeclamp_identification.importing.texts.decoding import decoded


def clock(t: float) -> str:
    """Give a stamp that passes midnight after five seconds."""
    day, seconds = (1, 55 + t) if t < 5 else (2, t - 5)
    return f"{day:02d}.02.2024 {'23:59' if day == 1 else '00:00'}:{seconds:06.3f}".replace(".", ",").replace(
        ",02,", ".02."
    )


TABS = {"delimiter": "\t", "decimal": "."}
QUOTED = {"delimiter": ",", "decimal": ".", "quote": '"'}
BLANKS = {"delimiter": "   ", "decimal": ".", "newline": "\r"}
DIALECTS = {
    "german, decimal comma, Latin-1": {
        "names": "Zeit [s];Kolbenweg/µm;Last [kN]", "scales": (1, 1e3, 1e-3), "digits": (6, 3, 7),
        "encoding": "latin-1", "header": "Prüfung Nr. 12;Schelle\nDatum;01.02.2024\n\n",
    },
    "UTF-16 with its mark": {"encoding": "utf-16"},
    "UTF-16 without a mark": {"encoding": "utf-16-le"},
    "UTF-8 with its mark, tabs, foreign units": {
        **TABS, "encoding": "utf-8-sig", "names": "Time (ms)\tLVDT in\tLoad (lbf)",
        "scales": (1e3, 1 / 25.4, 1 / 4.4482216152605), "digits": (3, 8, 8),
    },
    "MTS": {
        **TABS, "header": "MTS793|MPT|ENU|1|2|.|/|:|1|0|0|A\n\nData Header:\tTime:\t12.5\tSec\n",
        "names": "Time\tAxial Displacement\tAxial Force", "units": "Sec\tmm\tkN",
    },
    "Instron, all in quotes": {
        **QUOTED, "names": '"Time","Extension","Load"', "units": '"(s)","(mm)","(kN)"', "header": '"Results Table 1"\n',
    },
    "blanks, no line end but CR": {
        **BLANKS, "names": "# time_s   displacement_mm   force_N", "header": "# made by a logger\n",
        "scales": (1, 1, 1), "digits": (6, 6, 4),
    },
    "stamps of the clock": {"stamp": clock, "names": "Zeitstempel [s];Weg [mm];Kraft [kN]"},
    "Chinese, GB18030, wide brackets": {
        "encoding": "gb18030", "names": "时间（s）;位移（mm）;力（kN）", "scales": (1, 1, 1e-3), "digits": (6, 6, 7),
        "header": "试验名称;管夹往复试验\n试验日期;2024-05-17\n\n",
    },
    "Japanese, Shift-JIS": {
        "encoding": "cp932", "names": "経過時間[秒];変位[mm];試験力[kN]", "scales": (1, 1, 1e-3), "digits": (6, 6, 7),
    },
    "Korean": {"encoding": "cp949", "names": "시간(s);변위(mm);하중(N)", "scales": (1, 1, 1), "digits": (6, 6, 4)},
    "Russian, Windows": {
        "encoding": "cp1251", "names": "Время, с;Перемещение, мм;Сила, кН", "scales": (1, 1, 1e-3), "digits": (6, 6, 7),
        "header": "Испытание;хомут\n\n",
    },
    "Polish, Windows": {
        "encoding": "cp1250", "names": "Czas [s];Przemieszczenie tłoka [mm];Siła [kN]", "header": "Próbka;obejma\n\n",
    },
    "CRLF and a footer": {"newline": "\r\n", "footer": "\nEnd of file;;\n"},
}  # fmt: skip


@pytest.mark.parametrize(
    ("text", "encoding"),
    [
        (
            "Prüfkörper;Rohrschelle Ø 60,3 mm\nPrüfgeschwindigkeit;5 mm/s\nZeit [s];Weg [µm];Größe [mm²];T [°C]",
            "cp1252",
        ),
        ("Temps (s);Déplacement (mm);Numéro d'éprouvette;Fréquence;Préréglé;Côté à 20 °C", "cp1252"),
        ("Rörklämma;Förskjutning;Mätning;Över;Åldring;Längd", "cp1252"),
        # each pair of bytes is a Korean letter, too
        ("\t".join(f"T{place} °C" for place in range(9)), "cp1252"),
        ("时间(s)\t位移(mm)\t力(kN)", "gb18030"),
        ("時間(s),位移(mm),荷重(kN)\n試驗名稱,管夾", "big5"),
        ("時間,変位,荷重", "cp932"),
        ("ﾃﾞｰﾀ番号,時間(sec),ｽﾄﾛｰｸ(mm),荷重(N)", "cp932"),
        ("Испытание;хомут\nВремя;Ход;Усилие", "cp1251"),
        ("Czas [s];Przemieszczenie [mm];Siła [kN]", "cp1250"),
        ("Badanie zmęczeniowe obejmy\nŁukasz Żółć\nCzas;Wydłużenie;Obciążenie;Prędkość;Ciśnienie", "cp1250"),
        ("Zkouška potrubní objímky\nČas [s];Zatížení [kN];Měření;Počet cyklů;Průhyb;Teplota [°C]", "cp1250"),
        ("Idő [s];Elmozdulás [mm];Erő [kN]", "cp1250"),
        # powers of units are letters of the central European page
        ("Time [s];A [mm²];V [cm³];Flow [m³/h];T [°C]", "cp1252"),
        ("Tempo [s];Spostamento [mm];velocità;unità;più", "cp1252"),
        ("Prøvestykke nr. 3\nTid [s];Målt kraft [N];Tøyning", "cp1252"),
    ],
)
def test_a_code_page_is_that_of_the_language(text, encoding):
    rows = "".join(f"\n{row};{row / 7:.6f};-{row / 3:.5f}" for row in range(3000))
    assert decoded((text + rows).encode(encoding))[0] == text + rows


@pytest.mark.parametrize("dialect", DIALECTS)
def test_every_dialect_gives_the_same_campaign(tmp_path, dialect):
    runs = ten_runs()
    folder = write_texts(tmp_path / "exports", runs, **DIALECTS[dialect])
    found = pc.import_files(folder, tmp_path / "campaign", pattern="T{temperature_C}")
    assert not found.notes
    campaign = assert_same_campaign(tmp_path / "campaign", runs)
    assert [run.setup.temperature_C for run in campaign.runs] == [
        run.temperature for run in sorted(runs, key=lambda run: run.name + ".csv")
    ]


@pytest.mark.skipif(os.name == "nt", reason="names of files are text there")
def hour(t: float) -> str:
    """Give a stamp of minutes and seconds, which begins anew with the hour, five seconds on."""
    return f"{'59' if t < 5 else '00'}:{(55 + t) % 60:06.3f}"


@pytest.mark.parametrize(
    "stamp",
    [
        hour,
        lambda t: f"{'05' if t < 5 else '06'}/06/2024 {'23:59' if t < 5 else '00:00'}:{(55 + t) % 60:06.3f}",
        lambda t: f"06/{'05' if t < 5 else '06'}/2024 {'23:59' if t < 5 else '00:00'}:{(55 + t) % 60:06.3f}",
    ],
    ids=["the hour", "European dates", "American dates"],
)
def test_a_clock_goes_on_over_the_full_hour_and_midnight(tmp_path, stamp):
    run = loop(0.5, 2.0, cycles=18)
    (tmp_path / "x.csv").write_text(text(run, stamp=stamp, names="Zeit;Weg [mm];Kraft [kN]"), encoding="utf-8")
    found = pc.import_files(tmp_path / "x.csv", tmp_path / "c")
    (read,) = found.tests().tests.campaign.runs
    assert read.record.time_s[-1] - read.record.time_s[0] == pytest.approx(run.time[-1] - run.time[0], abs=2e-3)


def test_names_of_files_are_of_their_language_too(tmp_path):
    exports = tmp_path / os.fsdecode("próby siły".encode("cp1250"))
    try:
        exports.mkdir()
    except OSError:
        pytest.skip("files are named in UTF-8 alone here")
    run = loop()
    (exports / os.fsdecode("obciążenie_próbki.csv".encode("cp1250"))).write_text(text(run))
    pc.import_files(exports, tmp_path / "campaign")
    description = read_description(tmp_path / "campaign")
    assert [one.file for one in description.imported.files] == ["obciążenie_próbki.csv"]
    assert [run.run for run in description.imported.runs] == ["obciążenie_próbki"]


def test_text_is_unpacked(tmp_path):
    run = loop()
    path = tmp_path / "a.csv.gz"
    path.write_bytes(gzip.compress(text(run).encode()))
    (table,) = read_file(path).tables
    np.testing.assert_allclose(table.channels[1].values, run.y, atol=1e-6)


def test_blocks_of_numbers_become_tables(tmp_path):
    one, other = loop(0.3), loop(0.9)
    path = tmp_path / "a.csv"
    path.write_text(text(one) + "Block 2;;\nTime [s];Displacement [mm];Force [kN]\n" + text(other, names=""))
    tables = read_file(path).tables
    assert [table.length for table in tables] == [len(one.time), len(other.time)]
    assert tables[1].first_row == tables[0].first_row + len(one.time) + 2


@pytest.mark.parametrize(
    ("names", "rows", "units"),
    [
        ("Time;Disp;Force;Coil", ["s;mm;N;foo"], ["s", "mm", "N", "foo"]),
        ("Time;Disp;Force;Coil", ["s;mm;N;1/[current_A]"], ["s", "mm", "N", "1/[current_A]"]),
        ("Time;Disp;Force;Coil", ["(s);(mm);(bar x);(A)"], ["s", "mm", "bar x", "A"]),
        ("Time;Disp;Force;Coil", ["s;mm;N;A", "double;double;double;double"], ["s", "mm", "N", "A"]),
        ("s;mm;N;A", ["Time;Disp;Force;Coil"], ["s", "mm", "N", "A"]),
        ("Machine 7;;;", ["Time;Disp;Force;Coil"], [""] * 4),
        ("Machine 7;;;", ["t;y;F;T"], [""] * 4),
    ],
)
def test_a_row_of_units_is_one_though_nobody_knows_one_of_them(tmp_path, names, rows, units):
    path = tmp_path / "a.csv"
    body = "\n".join(f"{0.01 * row:.2f};{row % 7};{row % 5};1" for row in range(50))
    path.write_text("\n".join([names, *rows, body]))
    channels = read_file(path).tables[0].channels
    assert [channel.unit for channel in channels] == units
    assert [channel.name for channel in channels] in (["Time", "Disp", "Force", "Coil"], ["t", "y", "F", "T"])


def with_cells(run, cells, **options):
    """Give a run as a text in which some cells of force are others, by the sample that they belong to."""
    lines = text(run, names="Time [s];Weg [mm];Kraft [N]", header="", scales=(1, 1, 1), **options).splitlines()
    for sample, cell in cells.items():
        lines[sample + 1] = ";".join([*lines[sample + 1].split(";")[:2], cell])
    return "\n".join(lines) + "\n"


def test_text_among_numbers_is_told_with_column_row_and_what_stands_there(tmp_path):
    path, run = tmp_path / "a.csv", loop()
    path.write_text(with_cells(run, {100: "OVLD"}))
    found = pc.import_files(path, tmp_path / "c", dry_run=True)
    assert "'OVLD' in row 102" in found.found.imported.files[0].read_as
    assert any("column 'Kraft [N]' holds text for a number, 'OVLD' in row 102" in note for note in found.notes)
    path.write_text(with_cells(run, {sample: "OVLD" for sample in range(600) if abs(run.force[sample]) > 400}))
    with pytest.raises(
        pc.UserError, match=r"(?s)'Kraft \[N\]' holds text for a number in \d+ cells, first 'OVLD' in row"
    ):
        pc.import_files(path, tmp_path / "c", dry_run=True)
    path.write_text(with_cells(run, dict.fromkeys(range(600), "OVLD")))
    with pytest.raises(pc.UserError, match=r"'Kraft \[N\]' holds no numbers, first 'OVLD' in row 2"):
        pc.import_files(path, tmp_path / "c", dry_run=True)


@pytest.mark.parametrize("row", ["NaN;NaN;NaN", ";;", "", "{t};NaN;NaN", "{t};;", "ERR;ERR;ERR", "# buffer emptied"])
def test_a_lost_sample_parts_no_run(tmp_path, row):
    path, run = tmp_path / "a.csv", loop()
    lines = with_cells(run, {}, decimal=".").splitlines()
    lines[321] = row.format(t=lines[321].split(";")[0])
    path.write_text("\n".join(lines) + "\n")
    found = pc.import_files(path, tmp_path / "c").to_dict()
    (only,) = found["runs"]
    assert only["done"]
    assert_same_campaign(tmp_path / "c", [replace(run, name="a")], y_step=2e-3, force_step=20)


def test_channels_of_one_name_are_told_apart_and_control_characters_taken_out(tmp_path):
    pl.DataFrame({"Load [N]\x1b[31m": [1.0, 2.0]}).write_parquet(tmp_path / "a.parquet")
    assert read_file(tmp_path / "a.parquet").tables[0].channels[0].name == "Load [N] [31m"
    path = tmp_path / "a.csv"
    path.write_text(text(loop(), names="Time [s];Load [N];Load [N]"))
    with pytest.raises(pc.UserError, match=r"2 channels may be the force: 'Load \[N\]', 'Load #2 \[N\]'"):
        pc.import_files(path, tmp_path / "c", rate=200)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"", "is empty"),
        (b"no table at all\nin two lines\n", "holds no table of numbers"),
        (b"load / kN\n" + b"0.5\n-2\n1.25\n" * 5, "holds one column of numbers alone"),
        (b"a,b,c\n" + b"0,001,1,5,2,5\n" * 30, "3 names above 6 columns.*decimal commas"),
        (b"Load, N,Disp, mm\n" + b"1.5,2.5\n" * 30, "4 names above 2 columns.*a name that holds a comma"),
        (
            text(loop()).encode() + text(loop(), names="Force [kN];Time [s];Displacement [mm]").encode(),
            "has other columns",
        ),
        (b"\x89PNG\r\n\x1a\n" + bytes(range(256)), "is of no known format"),
        (
            text(loop(), names="t;y;F", units="s;mm;kN").encode()
            + text(loop(), names="t;y;F", units="s;mm;N").encode(),
            "has other columns or units from line",
        ),
        (gzip.compress(text(loop()).encode())[:200], "is no whole delimited text file"),
    ],
)
def test_what_is_no_table_is_told(tmp_path, content, told):
    path = tmp_path / "a.csv"
    path.write_bytes(content)
    with pytest.raises(pc.UserError, match=told):
        read_file(path)


@pytest.mark.parametrize("first", ["", ", DAQ Start"])
def test_remarks_that_most_rows_leave_off_are_no_column(tmp_path, first):
    """A logger's file had been refused for its "Events", of which only the first row has one."""
    run = loop()
    lines = ["Sampling Rate:  200", "Sample Number, Date/Time, CHANNEL0, CHANNEL1, Events"]
    for place, (t, y, force) in enumerate(zip(run.time, run.y, run.force, strict=True), 1):
        lines.append(
            f"  {place},   04/29/2022 12:11:{14 + t:06.3f} PM, {y:.4f}, {force:.4f}{first if place == 1 else ''}"
        )
    (tmp_path / "a.txt").write_text("\n".join(lines) + "\n")
    channels = read_file(tmp_path / "a.txt").tables[0].channels
    assert [channel.name for channel in channels] == ["Sample Number", "Date/Time", "CHANNEL0", "CHANNEL1"]
    assert channels[2].values == pytest.approx(run.y, abs=1e-4)


def test_fortrans_exponents_are_numbers(tmp_path):
    run = loop()
    rows = [f"{t:.9E}  {y:.9E}  {force:.9E}" for t, y, force in zip(run.time, run.y, run.force, strict=True)]
    for change in (str, lambda rows: rows.replace("E", "D")):
        (tmp_path / "a.dat").write_text("  time_s  displacement_mm  force_N\n" + change("\n".join(rows)) + "\n")
        (table,) = read_file(tmp_path / "a.dat").tables
        assert not table.unread
        np.testing.assert_allclose(table.channels[2].values, run.force, rtol=1e-8)


@pytest.mark.parametrize("ending", [".csv", ".xlsx"])
def test_names_of_runs_part_and_name_them(tmp_path, ending):
    """The same motion goes on under another name; a name stands for the rows below it, too."""

    def write(path, heading):
        heading = ("Time [s]", heading, "Displacement [mm]", "Force [N]")
        if ending == ".csv":
            path.write_text("\n".join(";".join(map(str, row)) for row in (heading, *rows)))
            return
        xlsxwriter = pytest.importorskip("xlsxwriter")
        with xlsxwriter.Workbook(path, {"strings_to_formulas": False}) as book:
            sheet = book.add_worksheet()
            for number, row in enumerate((heading, *rows)):
                sheet.write_row(number, 0, row)

    run = loop(cycles=20)
    names = np.full(len(run.time), "", dtype=object)
    names[: len(names) // 2 : 3], names[len(names) // 2] = "../T20 north*", "=T-30"
    rows = list(zip(run.time.tolist(), names.tolist(), run.y.tolist(), run.force.tolist(), strict=True))
    path, other = tmp_path / f"a{ending}", tmp_path / f"b{ending}"
    write(path, "Test name")
    rows[0] = (0.0, "../T20 north*", 0.0, 1e-9)
    write(other, "Valve")
    parted = pc.import_files(path, tmp_path / "c", pattern="T{temperature_C}").to_frame()
    assert parted["run"].to_list() == ["T20_north", "T-30"]
    assert parted["cycles"].to_list() == [10, 10]
    assert parted["temperature_C"].to_list() == [20, -30]
    # a column that isn't called so parts where it is stated; names that are taken stand behind their file's
    assert len(pc.import_files(other, tmp_path / "d", dry_run=True).to_frame()) == 1
    stated = "segment=Valve"
    conditions = tmp_path / "set.csv"
    conditions.write_text("run,humidity\n=T-30,40\nT20_north,50\n")
    found = pc.import_files(other, tmp_path / "c", columns=stated, conditions=conditions)
    assert [row["run"] for row in found.to_dict()["runs"]] == ["T20_north", "T-30", "b_T20_north", "b_T-30"]
    assert not any("no run here is called" in note for note in found.notes)
    with pytest.raises(pc.UserError, match="'Valve' holds no numbers"):
        pc.import_files(other, tmp_path / "d", dry_run=True, columns="force=Valve [N]")


@pytest.mark.parametrize(
    ("headers", "names"),
    [
        (("Test;A05_f2\nOperator;N. N.\n", "Test;A03_f2\nOperator;N. N.\n"), ("A05_f2", "A03_f2")),
        # a file's own header stands above the first one's
        (("Machine 7;100 kN\n\nRun 1;timed\n", "Run 2;timed\n"), ("Run_1", "Run_2")),
        (("# sweep at 20 °C\n", "# sweep at 60 °C\n"), ("sweep_at_20_C", "sweep_at_60_C")),
        # when they were written isn't what they are
        (("Date;01.02.2024 12:00\n", "Date;01.02.2024 12:10\n"), ("block_1", "block_2")),
        (("Test;A\n", "Test;A\n"), ("block_1", "block_2")),
        (("Test;A\n", ""), ("block_1", "block_2")),
    ],
)
def test_blocks_of_a_file_are_called_by_the_titles_above_them(tmp_path, headers, names):
    runs = (loop(0.5), loop(0.3))
    content = "\n\n".join(text(run, header=header) for run, header in zip(runs, headers, strict=True))
    (tmp_path / "day.csv").write_text(content, encoding="utf-8")
    found = pc.import_files([tmp_path / "day.csv"], tmp_path / "campaign")
    assert [run["run"] for run in found.to_dict()["runs"]] == [f"day_{name}" for name in names]


@pytest.mark.parametrize(("before", "after"), [(".", ","), (",", ".")])
@pytest.mark.parametrize("delimiter", [";", "\t"])
@pytest.mark.parametrize("share", [0.02, 0.3, 0.98])
def test_a_decimal_sign_that_changes_is_told_with_its_line(tmp_path, before, after, delimiter, share):
    names = delimiter.join(["Time [s]", "Displacement [mm]", "Force [kN]"])
    lines, others = (
        text(loop(cycles=20), names=names, delimiter=delimiter, decimal=decimal).split("\n")
        for decimal in (before, after)
    )
    first = next(place for place in range(int(share * len(lines)), len(lines)) if others[place].count(after) == 3)
    path = tmp_path / "a.csv"
    path.write_text("\n".join(lines[:first] + others[first:]))
    with pytest.raises(pc.UserError) as told:
        read_file(path)
    sign = {".": "decimal points", ",": "decimal commas"}
    assert f"changes its decimal sign in line {first + 1}: got " in str(told.value)
    assert f"with {sign[after]}; expected {sign[before]} as in the lines above" in str(told.value)


def test_thousands_beside_decimal_commas_are_no_decimals(tmp_path):
    """1.017 N among 998 N, in whole newtons: read as a decimal it would be a thousandth of itself."""
    run = loop(2.0)
    samples = zip(run.time, run.y, run.force, strict=True)
    rows = [f"{t:.4f};{y:.5f}".replace(".", ",") + f";{f:,.0f}".replace(",", ".") for t, y, f in samples]
    path = tmp_path / "a.csv"
    path.write_text("\n".join(["Zeit [s];Weg [mm];Kraft [N]", *rows]))
    (table,) = read_file(path).tables
    force = table.channels[2].values
    kept = np.isfinite(force)
    np.testing.assert_allclose(force[kept], np.round(run.force[kept]))
    assert 0 < np.count_nonzero(~kept) == table.unread[0].count


@pytest.mark.parametrize("cell", ["NaN", ""])
def test_a_channel_without_any_number_is_called_so(tmp_path, cell):
    rows = [f"{0.01 * place:.2f};{np.sin(0.3 * place):.4f};{cell};{20 + 0.01 * place:.2f}" for place in range(200)]
    text = "Zeit [s];Weg [mm];Kraft [kN];Temperatur [°C]\n" + "\n".join(rows) + "\n"
    (tmp_path / "a.csv").write_text(text, encoding="utf-8")
    with pytest.raises(pc.UserError, match=r"column 'Kraft \[kN\]' holds no number in any row, so there is no force"):
        pc.import_files([tmp_path / "a.csv"], tmp_path / "campaign")
