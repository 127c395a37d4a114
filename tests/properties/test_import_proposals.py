"""Tables with any names, units and faults: what an import proposes runs, and whatever is wrong is told in a message."""

from __future__ import annotations

import random
import shlex

import numpy as np
import pytest
from exports import loop

import pipeclamp as pc

CASES = 80
NAMES = (
    "Time", "Zeit", "t", "Temps", "Weg", "Stroke", "LVDT 1", "x", "Force", "Kraft", "Load Cell", "F", "Temp", "Cycle",
    "Command", "Ch1", "", "A,b", "Pos (1)", "#", "none", "-F", 'a "q"', "Cost $", "x=1, y=2", "it's", "Überlast",
)  # fmt: skip
UNITS = ("s", "ms", "mm", "in", "µm", "N", "kN", "V", "foo", "%", "-", "", "°C", "K", "1/[current_A]", "Nm", "[mm]")
STYLES = ("{} [{}]", "{} ({})", "{}/{}", "{}_{}", "")
"""How a unit stands behind a name; "" for a row of its own."""


def table(dice: random.Random) -> str:
    run = loop(cycles=4, rate=100.0, seed=dice.randrange(99))
    columns = [run.time, run.y, run.force]
    columns += [dice.choice((run.time * 0 + 7, np.arange(len(run.time)) * 1.0)) for _ in range(dice.randrange(3))]
    delimiter, decimal = dice.choice(((";", ","), (",", "."), ("\t", "."), (" ", ".")))
    usual = (("Time", "s"), ("Weg", "mm"), ("Kraft", "N"))
    heads = [
        (usual[place][0] if place < 3 and dice.random() < 0.6 else dice.choice(NAMES),
         usual[place][1] if place < 3 and dice.random() < 0.6 else dice.choice(UNITS))
        for place in range(len(columns))
    ]  # fmt: skip

    def cell(text: str) -> str:
        return '"' + text.replace('"', '""') + '"' if delimiter in text or '"' in text else text

    style = dice.choice(STYLES)
    lines = [delimiter.join(cell(style.format(*head) if style and head[1] else head[0]) for head in heads)]
    lines += [] if style else [delimiter.join(cell(unit) for _, unit in heads)]
    for row in zip(*columns, strict=True):
        lines.append(delimiter.join(f"{value:.5f}".replace(".", decimal) for value in row))
    blank = delimiter.join(["NaN"] * len(columns))
    for _ in range(dice.randrange(4)):
        place = dice.randrange(2, len(lines))
        lines[place] = dice.choice(("", blank, "# remark", blank.replace("NaN", "ERR"), lines[place] + delimiter + "x"))
    return "\n".join(lines)


def test_what_is_proposed_runs_and_what_is_wrong_is_told(tmp_path):
    path, proposed = tmp_path / "a.csv", 0
    for seed in range(CASES):
        path.write_text(table(random.Random(seed)), encoding="utf-8")
        options: dict[str, object] = {}
        for _ in range(2):
            try:
                pc.import_files(path, tmp_path / "c", dry_run=True, **options)
                break
            except pc.UserError as error:
                lines = str(error).splitlines()
            option = next((line for line in lines if line.startswith("  --columns ")), "")
            assert "[...]" not in option, seed
            # what names and units can't tell of the samples may be refused still, but not what was proposed
            assert not (options and (option or "--columns:" in lines[0])), (seed, options, lines[0])
            if not option:
                break
            words = shlex.split(option)
            options, proposed = {"columns": words[1]}, proposed + 1
            if "--rate" in words:
                options["rate"] = 100.0
    assert proposed > CASES / 4


def test_what_is_proposed_as_time_rises(tmp_path):
    run = loop()
    rows = "\n".join(f"{y:.5f};{t:.4f};{force:.2f}" for t, y, force in zip(run.time, run.y, run.force, strict=True))
    (tmp_path / "a.csv").write_text("A;B;C\n" + rows)
    with pytest.raises(pc.UserError, match=r'--columns "time=B \[s\],displacement=A \[mm\],force=C \[N\]"'):
        pc.import_files(tmp_path / "a.csv", tmp_path / "c")
    (tmp_path / "b.csv").write_text("A;C\n" + "\n".join(";".join(row.split(";")[::2]) for row in rows.splitlines()))
    with pytest.raises(pc.UserError, match=r'--columns "displacement=A \[mm\],force=C \[N\]" --rate 1000'):
        pc.import_files(tmp_path / "b.csv", tmp_path / "c")
