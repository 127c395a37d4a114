"""Hostile files given to commands as a user gives them: each ends in an answer or in one short message.

The environment variable PIPECLAMP_HOSTILE_COMMANDS says how many inputs each command gets.
"""

from __future__ import annotations

import os
import random
import re
import shutil
import sys
import warnings

import pytest
from project import EXAMPLES

from pipeclamp.__main__ import main
from pipeclamp_models.base.said import LONGEST_LINE
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import law_text

EACH = int(os.environ.get("PIPECLAMP_HOSTILE_COMMANDS", "4"))
NASTY = [
    *("", "nan", "-inf", "1e39", "9" * 400, "[/b]", "\x1b[2J", "\0", "\r", '"', "[" * 500, "x" * 5000, "../../x", "é"),
    *("-273.15", "0", "-1", "%s", "{}", ",,,,", "sin(" * 99, "\u202e"),
]
COMMANDS = {
    "metrics": ("small/runs.csv", "metrics", "small"),
    "metrics, description": ("small/campaign.toml", "metrics", "small", "--json", "out.json"),
    "metrics, record": ("small/record", "metrics", "small", "--report", "out.html"),
    "compare": ("law.json", "compare", "law.json", "small"),
    "build-fmu": ("law.json", "build-fmu", "law.json", "-o", "out.fmu"),
    "set-parameters": ("clamp.fmu", "set-parameters", "clamp.fmu", "law.json", "-o", "out.fmu"),
    "build-pipe": ("pipe.toml", "build-pipe", "pipe.toml", "-o", "out.fmu"),
    "cosim": ("system.toml", "cosim", "system.toml", "-o", "out.csv"),
    "cosim, law": ("clamp_a.json", "cosim", "system.toml", "-o", "out.csv"),
    "import": ("export.csv", "import", "export.csv", "-o", "out"),
    "import, conditions": ("set.csv", "import", "export.csv", "-o", "out", "--conditions", "set.csv"),
}


@pytest.fixture(scope="module")
def whole(pipeclamp, small, tmp_path_factory):
    """A folder with a whole file for each command."""
    folder = tmp_path_factory.mktemp("whole") / "files"
    shutil.copytree(EXAMPLES, folder)
    shutil.copytree(small, folder / "small")
    for name in ("clamp_a.json", "law.json"):
        (folder / name).write_text(law_text(open_law("emwm2")), encoding="utf-8")
    pipeclamp("build-fmu", "law.json", "-o", "clamp.fmu", cwd=folder)
    text = (folder / "system.toml").read_text(encoding="utf-8")
    (folder / "system.toml").write_text(re.sub(r"stop_s = .*", "stop_s = 0.2", text), encoding="utf-8")
    record = sorted((folder / "small" / "runs").iterdir())[0]
    (folder / "export.csv").write_bytes(record.read_bytes())
    (folder / "set.csv").write_text("file;temperature_C;specimen\nexport.csv;21,5;s7\n", encoding="utf-8")
    return folder


def damaged(content: bytes, chance: random.Random) -> bytes:
    first, second = sorted(chance.randrange(len(content) + 1) for _ in range(2))
    nasty = chance.choice(NASTY).encode()
    value = chance.choice(list(re.finditer(rb"[-\w.+]+", content)))
    ways = (
        content[: value.start()] + nasty + content[value.end() :], content[:first] + nasty + content[first:],
        content[:first], content[:first] + content[second:], content[:second] + content[first:], nasty,
    )  # fmt: skip
    return chance.choice(ways)


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_answers_or_says_what_is_wrong_in_a_line(name, whole, tmp_path, monkeypatch, capsys):
    file, *words = COMMANDS[name]
    monkeypatch.setattr(sys, "argv", ["pipeclamp", *words])
    chance = random.Random(name)
    for number in range(EACH):
        folder = tmp_path / str(number)
        shutil.copytree(whole, folder)
        before = {path.name for path in folder.iterdir()}
        path = folder / file if (folder / file).exists() else sorted((folder / "small" / "runs").iterdir())[1]
        path.write_bytes(damaged(path.read_bytes(), chance))
        monkeypatch.chdir(folder)
        capsys.readouterr()
        status: object = 0
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                main()
            except SystemExit as end:
                status = end.code or 0
        told = capsys.readouterr()
        assert status in (0, 1, 2), (number, told.err)
        if status == 1:
            message = next(line for line in told.err.splitlines() if line.startswith("pipeclamp: "))
            assert len(message) <= LONGEST_LINE + len("pipeclamp: "), message
            assert {path.name for path in folder.iterdir()} == before
        assert "Traceback" not in told.err
        shutil.rmtree(folder)
