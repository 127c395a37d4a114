"""JSON: the shapes in which programs write tables of tests, each the same campaign as the text of them."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from exports import loop, text

import pipeclamp as pc
from pipeclamp_identification.importing.reading import read_file

RUN = loop(0.5, 2.0, cycles=5)
COLUMNS = {"time (s)": RUN.time, "stroke (mm)": RUN.y, "force (N)": RUN.force}
LISTS = {name: values.tolist() for name, values in COLUMNS.items()}
ROWS = np.column_stack(list(COLUMNS.values())).tolist()

SHAPES = {
    "lists by name": {"specimen": "X7", "length": 40.0, "data": LISTS},
    "values and units": {
        "channels": {
            "time": {"unit": "s", "values": LISTS["time (s)"]},
            "stroke": {"unit": "mm", "values": LISTS["stroke (mm)"]},
            "force": {"unit": "N", "values": LISTS["force (N)"]},
        }
    },
    "rows that are objects": [dict(zip(COLUMNS, row, strict=True)) for row in ROWS],
    "rows beside names": {"columns": list(COLUMNS), "index": list(range(len(ROWS))), "data": ROWS},
    "columns of numbered samples": {
        name: {str(place): value for place, value in enumerate(values)} for name, values in LISTS.items()
    },
}


@pytest.mark.parametrize("shape", SHAPES)
def test_tables_of_any_usual_shape_are_read(tmp_path, shape):
    (tmp_path / "a.json").write_text(json.dumps(SHAPES[shape], indent=1))
    (table,) = [one for one in read_file(tmp_path / "a.json").tables if one.length == len(ROWS)]
    assert len(table.channels) == 3
    pc.import_files(tmp_path / "a.json", tmp_path / "camp")
    (run,) = pc.read_campaign(tmp_path / "camp").tests.campaign.runs
    np.testing.assert_allclose(run.record.force_N, RUN.force, atol=1e-6)
    assert run.setup.specimen == ("X7" if shape == "lists by name" else None)


def test_an_object_a_line_is_a_table_and_blanks_are_blank(tmp_path):
    rows = [dict(zip(COLUMNS, row, strict=True)) for row in ROWS]
    rows[7]["force (N)"] = None
    (tmp_path / "log.jsonl").write_text("\n".join(map(json.dumps, rows)) + "\n")
    (table,) = read_file(tmp_path / "log.jsonl").tables
    assert table.length == len(ROWS)
    assert math.isnan(table.channels[2].values[7])


def test_several_tests_of_one_file_are_tables(tmp_path):
    held = {"tests": [{"name": "up", **LISTS}, {"name": "down", **LISTS}]}
    (tmp_path / "a.json").write_text(json.dumps(held))
    assert [table.name for table in read_file(tmp_path / "a.json").tables] == ["up", "down"]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ('{"a": [1, 2', "no whole JSON file"),
        ('{"name": "x", "n": 3}', "holds no channel of numbers; expected JSON"),
        ("[" * 4000 + "]" * 4000, "no whole JSON file|nested too deeply"),
        ('{"schema": "pipeclamp-law-1", "covariance": [1.0, 2.0]}', r"was written by pipeclamp \(pipeclamp-law-1\)"),
    ],
)
def test_what_is_no_table_is_told_in_a_sentence(tmp_path, content, words):
    (tmp_path / "a.json").write_text(content)
    with pytest.raises(pc.UserError, match=words):
        read_file(tmp_path / "a.json")


def test_a_text_with_its_header_in_brackets_is_none(tmp_path):
    (tmp_path / "a.csv").write_text(text(RUN, header="[Test machine 7]\n"))
    assert read_file(tmp_path / "a.csv").format == "delimited text"


def test_notes_beside_tests_are_left_and_told(tmp_path):
    folder = tmp_path / "exports"
    folder.mkdir()
    (folder / "A.csv").write_text(text(RUN))
    (folder / "setup.json").write_text(json.dumps({"operator": "N. N."}))
    found = pc.import_files(folder, tmp_path / "camp")
    assert "not read beside files of other formats, which they may describe: setup.json" in " ".join(found.notes)
    (folder / "A.csv").unlink()
    (folder / "setup.json").write_text(json.dumps(LISTS))
    assert [run["file"] for run in pc.import_files(folder, tmp_path / "other").to_dict()["runs"]] == ["setup.json"]
