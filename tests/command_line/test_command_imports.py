"""Each command loads only what its own way needs: start-up is half of a short command's time."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

LISTED = "LOADED_MODULES"
CALL = f"""
import atexit, os, pathlib, runpy, sys
atexit.register(lambda: pathlib.Path(os.environ["{LISTED}"]).write_text(" ".join(sys.modules)))
runpy.run_module("pipeclamp", run_name="__main__")
"""
"""Runs a command as `python -m pipeclamp` does, and writes the names of all modules that it loaded."""

HELP = {"typer", "pydantic"}
"""typer asks for pydantic by itself where it is installed; Rich is for what is found, help does without it."""
TERMINAL = {*HELP, "rich"}
EQUATIONS = {"numpy", "sympy", "pydantic"}
TESTS = {"numpy", "polars", "pydantic"}
"""SymPy is for equations that no command has been on before."""
FIT = {"scipy", "scipy.optimize", "scipy.linalg", "scipy.sparse", "scipy.special", "numpy.f2py"}
"""SciPy asks for NumPy's f2py by itself."""
DRAWN = {"plotly", "jinja2", "pipeclamp.pages", "joblib", "scipy.integrate", "scipy.interpolate", "scipy.stats"}
COMPARED = {"pipeclamp_identification.comparison.compare", "pipeclamp_identification.metrics_only"}
"""One module shows what is held against records, and against metrics."""
PAGE = {*FIT, *DRAWN, "sympy"}
"""One module gives all pages, those of a diagnosis among them."""
WATCHED = {
    *(*TERMINAL, *EQUATIONS, *TESTS, *FIT, *PAGE),
    *("control", "fmpy", "matplotlib", "pandas", "pythonfmu", "scipy.signal"),
    *("pipeclamp_fmu", "pipeclamp_models.pipe"),
    *("pipeclamp_identification.attribution", "pipeclamp_identification.on_pipe"),
    *COMPARED,
    *("pipeclamp_system.coupling", "pipeclamp_system.cosim", "pipeclamp_system.steady", "pipeclamp_system.study"),
}
"""Packages that cost time to load, and rooms of our own that bring such with them."""

MAY_LOAD = {
    "--help": HELP,
    "identify --help": HELP,
    "effects": {*TERMINAL, *EQUATIONS},
    "metrics clamp_a": {*TERMINAL, *TESTS, *COMPARED},
    "identify clamp_a -o LAW": {*TERMINAL, *TESTS, *FIT},
    "identify emwm2_tables -o LAW": {*TERMINAL, *TESTS, *FIT, "pipeclamp_identification.metrics_only"},
    "build-fmu emwm2 -o FMU": {
        *(*TERMINAL, *EQUATIONS),
        *("scipy", "scipy.linalg", "numpy.f2py", "jinja2", "pythonfmu", "pipeclamp_fmu", "pipeclamp_models.pipe"),
    },
    "compare emwm2 clamp_a_heldout": {*TERMINAL, *TESTS, *COMPARED},
    "compare emwm2 clamp_a_heldout --report PAGE": {*TERMINAL, *TESTS, *COMPARED, *PAGE},
}


def loaded(words: Sequence[str], tmp_path: Path, before: str = "") -> set[str]:
    """Give what of the watched a command loads; `before` is run in its process first."""
    listed = tmp_path / "loaded.txt"
    call = [sys.executable, "-c", before + CALL, *words]
    ours = {"PYTHONPATH": os.pathsep.join(sys.path), "PYTHONIOENCODING": "utf-8", LISTED: str(listed)}
    done = subprocess.run(call, env={**os.environ, **ours}, capture_output=True, encoding="utf-8", check=False)
    assert done.returncode == 0, done.stderr
    return set(listed.read_text().split()) & WATCHED


@pytest.mark.parametrize("command", MAY_LOAD)
def test_a_command_loads_only_what_it_may(command: str, tmp_path: Path):
    files = {"LAW": tmp_path / "law.json", "PAGE": tmp_path / "page.html", "FMU": tmp_path / "law.fmu"}
    words = [str(files.get(word, word)) for word in command.split()]
    found = loaded(words, tmp_path)
    if "sympy" in found:  # this was the first command on these equations
        found = loaded(words, tmp_path)
    assert found <= MAY_LOAD[command]


def test_what_diagnoses_does_without_statistics_that_take_half_a_second_to_load(tmp_path: Path):
    rooms = ", ".join(f"pipeclamp_identification.{room}" for room in ("diagnosis.diagnosed", "workflow.discover"))
    assert "scipy.stats" not in loaded(["--help"], tmp_path, f"import {rooms}")


def test_no_model_is_built_before_it_is_used():
    """A model's validator takes longer to build than the module around it to load, and a command uses few."""
    built = """
import pydantic
from pipeclamp.studio import session
from pipeclamp_identification.workflow import schemas

models = [pydantic.BaseModel]
for model in models:
    models += model.__subclasses__()
ours = [model for model in models if model.__module__.startswith("pipeclamp")]
print(sum(model.__pydantic_complete__ for model in ours), len(ours))
"""
    call = [sys.executable, "-c", built]
    done = subprocess.run(
        call, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    count, of_all = map(int, done.stdout.split())
    # defaults that are tables themselves are made, and so built, with the module
    assert count < of_all / 10


def test_what_no_command_may_load_would_be_seen(tmp_path: Path):
    too_much = {"control", "scipy.signal", "scipy.stats", "pipeclamp_identification.attribution"}
    before = "import pipeclamp_identification.attribution.verdict, control, scipy.stats"
    assert too_much <= loaded(["--help"], tmp_path, before)
