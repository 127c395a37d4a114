"""A command ends when its work is done: Python doesn't search all that it loaded for what nobody needs any more."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

LEFT = "LEFT_TO_SEARCH"
CALL = f"""
import atexit, gc, os, pathlib, runpy
atexit.register(lambda: pathlib.Path(os.environ["{LEFT}"]).write_text(str(len(gc.get_objects()))))
runpy.run_module("pipeclamp", run_name="__main__")
"""
"""Runs a command as `python -m pipeclamp` does, and writes how many objects are to be searched at its end."""
FEW = 5_000
"""Objects that exit handlers make; a command that only says what it is loads ten times as many."""


@pytest.mark.parametrize(("words", "status"), [(["--help"], 0), (["compare", "clamp_a", "no_such_folder"], 1)])
def test_what_a_command_loaded_is_not_searched_at_its_end(words: list[str], status: int, tmp_path: Path):
    left = tmp_path / "left.txt"
    ours = {"PYTHONPATH": os.pathsep.join(sys.path), LEFT: str(left)}
    done = subprocess.run([sys.executable, "-c", CALL, *words], env={**os.environ, **ours}, capture_output=True)
    assert done.returncode == status, done.stderr
    assert int(left.read_text()) < FEW
