"""Numbers above tables that were set and that nothing uses are told: a law without them would lack a condition."""

from __future__ import annotations

import pytest
from exports import loop, write_texts

import pipeclamp as pc

TOLD = "'Schraubenmoment [Nm]' stands above the tables, differs (10, 20, 35) and isn't used"


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
