"""Lines above a table: a temperature is that of its runs, unless it may be another or something else tells."""

from __future__ import annotations

import pytest
from exports import loop, write_texts

import pipeclamp as pc
from pipeclamp_identification.campaign.description import read_description
from pipeclamp_identification.campaign.runs_table import read_runs_table
from pipeclamp_identification.importing.texts.above import temperature_above

STATED = [
    (["Prüftemperatur", "23", "°C"], 23.0),
    (["Pruefkammertemperatur", "-40,5", "°C"], -40.5),
    (["Solltemperatur Ofen", "150", "[°C]"], 150.0),
    (["Probentemperatur / °C", "23"], 23.0),
    (["Temperature [°C]", "80"], 80.0),
    (["Temperature:", "\N{MINUS SIGN}20", "degC", ""], -20.0),
    (["# Test temperature: 23 \N{PLUS-MINUS SIGN} 2 deg C"], 23.0),
    (["Specimen Temperature;296.15;K"], 23.0),
    (["Temp. = 73.4 F"], 23.0),
    (["T = 80 °C"], 80.0),
    (["Température d'essai", "23", "°C"], 23.0),
    (["Temperatura di prova", "23", "°C"], 23.0),
    (["Temperatura de ensayo: 23 °C"], 23.0),
    (["Specimen : Temperature (C)", "23"], 23.0),
]
OPEN = [
    ([["Temperature", "23"]], "states no unit"),
    ([["Raumtemperatur", "21", "°C"]], "may be another than the test's"),
    ([["Oil temperature: 45 °C"]], "may be another than the test's"),
    ([["Environment : Temperature (C)", "23"]], "may be another than the test's"),
    ([["Prüftemperatur", "80", "°C"], ["Temperature: 23 °C"]], "don't agree"),
]
NONE = [
    ["Max. temperature", "200", "°C"],
    ["Temperature range: -60 to 200 °C"],
    ["Temperature - 20 °C"],
    ["Temperature compensation", "1"],
    ["Temperature", "RT"],
    ["Temperature", "23", "mm"],
    ["Prüftemperatur", "-300", "°C"],
    ["T", "80", "K"],
    ["Time [s]", "Temperature [°C]"],
]


@pytest.mark.parametrize(("row", "temperature"), STATED)
def test_the_tests_temperature_is_found(row, temperature):
    found = temperature_above([["Machine", "7"], row, ["Date", "01.02.2024"]])
    assert found.temperature_C == pytest.approx(temperature, abs=1e-6)


def test_of_several_the_tests_counts_and_twice_the_same_is_one():
    rows = [["Raumtemperatur", "21", "°C"], ["Prüftemperatur", "80", "°C"], ["Temperature", "80", "°C"]]
    assert temperature_above(rows).temperature_C == 80.0


@pytest.mark.parametrize(("rows", "why"), OPEN)
def test_what_is_open_stays_so_and_is_told(rows, why):
    found = temperature_above(rows)
    assert found.temperature_C is None
    assert why in found.words


@pytest.mark.parametrize("row", NONE)
def test_other_lines_state_none(row):
    assert temperature_above([row]) is None


def temperatures(folder):
    return {row.run: row.setup.temperature_C for row in read_runs_table(folder, read_description(folder)).rows}


def header(line):
    return {"header": f"Prüfung 12;Schelle\nDatum;01.02.2024\n{line}\n\n", "encoding": "latin-1"}


def test_it_becomes_that_of_the_runs_and_is_told_and_kept(tmp_path):
    folder = write_texts(tmp_path / "e", [loop(0.3), loop(0.6)], **header("Prüftemperatur;23;°C"))
    found = pc.import_files(folder, tmp_path / "c")
    assert set(temperatures(tmp_path / "c").values()) == {23.0}
    (note,) = [note for note in found.notes if "Prüftemperatur 23 °C" in note]
    assert "A0.3_f2_T20.csv and 1 more: temperature 23 °C" in note
    assert not any("no temperature" in line for line in found.view().lines)
    assert "temperature 23 °C, as 'Prüftemperatur 23 °C'" in (tmp_path / "c" / "campaign.toml").read_text("utf-8")
    assert "Prüftemperatur 23 °C" in (tmp_path / "c" / "import.html").read_text("utf-8")


def test_what_is_known_from_elsewhere_goes_before_it(tmp_path):
    folder = write_texts(tmp_path / "e", [loop(0.3)], **header("Prüftemperatur;23;°C"))
    for option in ({"pattern": "T{temperature_C}"}, {"columns": "temperature=none"}):
        campaign = tmp_path / next(iter(option))
        found = pc.import_files(folder, campaign, **option)
        assert temperatures(campaign) == {"A0.3_f2_T20": 20.0 if "pattern" in option else None}
        assert not any("Prüftemperatur" in note for note in found.notes)
    lines = (folder / "A0.3_f2_T20.csv").read_text("latin-1").split("\n")
    first = next(place for place, line in enumerate(lines) if line.startswith("Time"))
    lines[first:] = [lines[first] + ";Temperatur [°C]", *(f"{line};81,5" for line in lines[first + 1 :] if line)]
    (folder / "A0.3_f2_T20.csv").write_text("\n".join(lines), "latin-1")
    assert set(temperatures(pc.import_files(folder, tmp_path / "channel").folder).values()) == {81.5}


def test_names_that_state_another_one_leave_it_open(tmp_path):
    runs = [loop(0.3, temperature=80.0), loop(0.6, temperature=80.0)]
    folder = write_texts(tmp_path / "e", runs, **header("Prüftemperatur;23;°C"))
    found = pc.import_files(folder, tmp_path / "c")
    assert set(temperatures(tmp_path / "c").values()) == {None}
    assert any("names of 2 of these files state another temperature" in note for note in found.notes)
    assert "T{temperature_C}" in found.to_dict()["pattern"]


def test_names_that_state_the_same_need_no_pattern(tmp_path):
    folder = write_texts(tmp_path / "e", [loop(0.3)], **header("Prüftemperatur;20;°C"))
    (only,) = folder.iterdir()
    only.rename(folder / "Schelle_7_20C.csv")
    found = pc.import_files(folder, tmp_path / "c")
    assert "{temperature_C}" in found.to_dict()["pattern"]
    assert set(temperatures(tmp_path / "c").values()) == {20.0}
    assert not any("names look as if" in line for line in found.view().lines)


def test_an_open_one_is_told_beside_no_temperature(tmp_path):
    folder = write_texts(tmp_path / "e", [loop(0.3)], **header("Raumtemperatur;21;°C"))
    found = pc.import_files(folder, tmp_path / "c")
    assert set(temperatures(tmp_path / "c").values()) == {None}
    assert any("'Raumtemperatur 21 °C' may be another than the test's" in note for note in found.notes)


def test_blocks_of_a_text_have_each_its_own_or_that_of_the_file(tmp_path):
    folder = write_texts(tmp_path / "e", [loop(0.3), loop(0.6), loop(0.9)])
    first, second, third = (path.read_text() for path in sorted(folder.iterdir()))
    (tmp_path / "a.csv").write_text(
        f"Temperature;23;°C\n{first}\n\nTemperature;80;°C\n{second}\n\nTest;3\n{third}", "utf-8"
    )
    pc.import_files(tmp_path / "a.csv", tmp_path / "c")
    assert list(temperatures(tmp_path / "c").values()) == [23.0, 80.0, 23.0]


def test_rows_above_the_table_of_a_sheet_count_too(tmp_path):
    pytest.importorskip("python_calamine")
    import xlsxwriter

    run = loop(0.3)
    with xlsxwriter.Workbook(str(tmp_path / "a.xlsx")) as book:
        sheet = book.add_worksheet("A")
        sheet.write_row(0, 0, ["Test temperature", 80.5, "°C"])
        sheet.write_row(2, 0, ["Time [s]", "Displacement [mm]", "Force [N]"])
        for place, row in enumerate(zip(run.time, run.y, run.force, strict=True)):
            sheet.write_row(3 + place, 0, row)
    pc.import_files(tmp_path / "a.xlsx", tmp_path / "c")
    assert list(temperatures(tmp_path / "c").values()) == [80.5]


TOLD = "'Schraubenmoment [Nm]' stands above the tables, differs (10, 20, 35) and isn't used"
"""Numbers that were set and that nothing uses are told: a law without them would lack a condition."""


def exported(folder, line, settings=((10, 0.3), (10, 0.6), (20, 0.3), (20, 0.6), (35, 0.3), (35, 0.6))):
    """A text for each setting and amplitude, with a line above the table that is formed of the setting."""
    for place, (setting, amplitude) in enumerate(settings):
        run = loop(amplitude, seed=place)
        run = type(run)(f"M{setting}_{place}_{run.name}", *list(vars(run).values())[1:])
        header = f"Prüfung;Schelle\n{line.format(setting=setting, place=place, amplitude=amplitude)}\n\n"
        write_texts(folder, [run], header=header, encoding="latin-1")
    return folder


def notes(found):
    return [note for note in found.notes if "stands above the tables" in note]


@pytest.mark.parametrize("line", ["Schraubenmoment;{setting};Nm", "Schraubenmoment [Nm];{setting}"])
def test_a_setting_that_comes_again_is_told_with_the_column_that_takes_it(tmp_path, line):
    (note,) = notes(pc.import_files(exported(tmp_path / "e", line), tmp_path / "c"))
    assert note.startswith(TOLD)
    assert "'schraubenmoment_Nm'" in note


def test_one_that_names_state_is_known(tmp_path):
    folder = exported(tmp_path / "e", "Schraubenmoment;{setting};Nm")
    assert not notes(pc.import_files(folder, tmp_path / "c", pattern="M{torque_Nm}_"))


@pytest.mark.parametrize(
    "line",
    [
        "Schraubenmoment;20;Nm",  # the same all along
        "Schraubenmoment;{place};Nm",  # another in each: measured, or counted
        "Schraubenmoment;{setting}",  # of no unit: the number of a program, perhaps
        "Weg;{amplitude};mm",  # measured in the runs
        "Dauer;{setting};s",
    ],
)
def test_others_are_not(tmp_path, line):
    assert not notes(pc.import_files(exported(tmp_path / "e", line), tmp_path / "c"))


def test_three_tables_tell_nothing(tmp_path):
    settings = ((10, 0.3), (10, 0.6), (20, 0.3))
    folder = exported(tmp_path / "e", "Schraubenmoment;{setting};Nm", settings)
    assert not notes(pc.import_files(folder, tmp_path / "c"))
