"""Runs of masters of others, each in a process of its own, and how their figures are held against ours."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib.util import find_spec
from types import ModuleType

import numpy as np
import pytest

PACKAGES = {"fmpy": "fmpy", "ecos": "ecospy", "libcosim": "libcosimpy"}
"""Of each master, from PyPI; Ecos also needs Debian's libtbb12."""


def told_by(master: str, program: ModuleType, *arguments: object) -> np.ndarray:
    """Give what a program tells, JSON on its last line, when a master runs it; skip where there is no such master."""
    package = PACKAGES[master]
    if find_spec(package) is None:
        pytest.skip(f"{master} isn't installed: pip install {package}")
    command = [sys.executable, str(program.__file__), master, *map(str, arguments)]
    run = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    if "libtbb" in run.stderr and "cannot open shared object" in run.stderr:
        pytest.skip(f"{master} can't be loaded: it needs Debian's libtbb12")
    assert run.stdout, run.stderr
    return np.array(json.loads(run.stdout.splitlines()[-1]))


def assert_the_same(theirs: np.ndarray, own: np.ndarray) -> None:
    """Hold a master's figures, the pipe's displacement first, against our parallel scheme's, (STEPS, signals)."""
    assert theirs.shape == own.shape
    size = np.abs(own).max(axis=0)
    assert size[0] > 1e-6, "the pipe must move"
    assert (np.abs(theirs - own).max(axis=0) < 1e-9 * size).all()
