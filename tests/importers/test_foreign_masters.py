"""Pipe and clamp, Python and native, coupled in Ecos and in libcosim give what our own parallel scheme gives."""

import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import foreign_masters
import numpy as np
import pytest

from pipeclamp_identification.coupling import Explicit, System, march
from pipeclamp_identification.importer import FmuParticipant, opened

STEP_NS, STEPS = 20_000, 3000
MODULES = {"ecos": "ecospy", "libcosim": "libcosimpy"}
NEEDS = {"ecos": "ecospy from PyPI and Debian's libtbb12", "libcosim": "libcosimpy from PyPI"}


@pytest.fixture(scope="module", params=["python", "native", "further"])
def clamp_fmu(request, fmus):
    """Give the path of a clamp of each kind, and of one that follows density, a further condition and load cycles."""
    if request.param == "native":
        return request.getfixturevalue("native_fmus")[2]
    return fmus["memory" if request.param == "python" else "further"]


@pytest.fixture(scope="module")
def own(fmus, clamp_fmu):
    """Our parallel scheme's displacement and force, (STEPS, 2)."""
    with opened([(fmus["pipe"], "pipe"), (clamp_fmu, "clamp")]) as (pipe, clamp):
        pipe.initialise({})
        clamp.initialise(foreign_masters.START)
        system = System(
            FmuParticipant(pipe, ["base.a", "clamp1.f"], ["clamp1.s", "clamp1.v"], []),
            (FmuParticipant(clamp, ["flange.s", "flange.v"], ["flange.f"], []),),
            foreign_masters.excitation,
        )
        points = list(march(system, Explicit(system, sequential=False), 1e-9 * STEP_NS, STEPS))
    return np.array([(point.displacement[0], point.force[0]) for point in points[1:]])


@pytest.mark.parametrize("master", MODULES)
def test_it_gives_what_our_parallel_scheme_gives(fmus, clamp_fmu, own, master):
    if find_spec(MODULES[master]) is None:
        pytest.skip(f"{master} isn't installed: it needs {NEEDS[master]}")
    program = Path(foreign_masters.__file__)
    arguments = [master, str(fmus["pipe"]), str(clamp_fmu), str(STEP_NS), str(STEPS)]
    run = subprocess.run(
        [sys.executable, str(program), *arguments], capture_output=True, text=True, timeout=120, check=False
    )
    if "libtbb" in run.stderr and "cannot open shared object" in run.stderr:
        pytest.skip(f"{master} can't be loaded: it needs {NEEDS[master]}")
    assert run.stdout, run.stderr
    theirs = np.array(json.loads(run.stdout.splitlines()[-1]))
    assert theirs.shape == own.shape
    size = np.abs(own).max(axis=0)
    assert size[0] > 1e-6, "the pipe must move"
    assert (np.abs(theirs - own).max(axis=0) < 1e-9 * size).all()
