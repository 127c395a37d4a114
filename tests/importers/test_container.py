"""fmucontainer nests native pipe and clamp in one FMU, which gives in fmpy what our own parallel scheme gives.

So it does with two clamps of one program; and fmutool compiles an FMU's sources.
"""

import math
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest

from pipeclamp_system.coupling.march import Explicit, System, march
from pipeclamp_system.fmus.participant import FmuParticipant, opened

H, STEPS = 2e-5, 1500
WIRING = """rule;from_fmu;from_port;to_fmu;to_port
FMU;pipe.fmu;;;
FMU;clamp.fmu;;;
INPUT;;base.a;pipe.fmu;base.a
LINK;pipe.fmu;clamp1.s;clamp.fmu;flange.s
LINK;pipe.fmu;clamp1.v;clamp.fmu;flange.v
LINK;clamp.fmu;flange.f;pipe.fmu;clamp1.f
OUTPUT;pipe.fmu;clamp1.s;;clamp1.s
OUTPUT;clamp.fmu;flange.f;;flange.f
FMU;second.fmu;;;
LINK;pipe.fmu;clamp2.s;second.fmu;flange.s
LINK;pipe.fmu;clamp2.v;second.fmu;flange.v
LINK;second.fmu;flange.f;pipe.fmu;clamp2.f
OUTPUT;second.fmu;flange.f;;second.f
"""


def excitation(time):
    return 2.0 * math.sin(2 * math.pi * 10 * time)


def found(name):
    """Give the path of one of the toolbox's programs; skip where there is none."""
    program = shutil.which(name, path=str(Path(sys.executable).parent)) or shutil.which(name)
    if program is None:
        pytest.skip(f"{name} isn't installed: pip install fmu-manipulation-toolbox")
    return program


def test_a_container_gives_what_our_parallel_scheme_gives(native_pipes, native_fmus, tmp_path):
    program = found("fmucontainer")
    shutil.copy(native_pipes["pipe"], tmp_path / "pipe.fmu")
    shutil.copy(native_fmus[2], tmp_path / "clamp.fmu")
    shutil.copy(native_fmus[2], tmp_path / "second.fmu")
    (tmp_path / "system.csv").write_text(WIRING, encoding="utf-8")
    command = [program, "-container", f"system.csv:{H}", "-no-auto-input", "-no-auto-output"]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (tmp_path / "system.fmu").exists(), run.stdout + run.stderr

    time = H * np.arange(STEPS + 1)
    signals = np.rec.fromarrays([time, np.vectorize(excitation)(time)], names=["time", "base.a"])
    result = fmpy.simulate_fmu(
        str(tmp_path / "system.fmu"), stop_time=STEPS * H, step_size=H, output_interval=H, input=signals,
        output=["clamp1.s", "flange.f", "second.f"],
    )  # fmt: skip
    names = ("pipe", "clamp", "second")
    with opened([(tmp_path / f"{name}.fmu", name) for name in names]) as (pipe, *clamps):
        for fmu in (pipe, *clamps):
            fmu.initialise({})
        moved = ["clamp1.s", "clamp2.s", "clamp1.v", "clamp2.v"]
        system = System(
            FmuParticipant(pipe, ["base.a", "clamp1.f", "clamp2.f"], moved, []),
            tuple(FmuParticipant(clamp, ["flange.s", "flange.v"], ["flange.f"], []) for clamp in clamps),
            excitation,
        )
        points = list(march(system, Explicit(system, sequential=False), H, STEPS))
    own = np.array([(point.displacement[0], *point.force) for point in points])
    theirs = np.array([result["clamp1.s"], result["flange.f"], result["second.f"]]).T
    assert np.abs(own[:, 0]).max() > 1e-6, "the pipe must move"
    assert (np.abs(theirs - own).max(axis=0) < 1e-9 * np.abs(own).max(axis=0)).all()


@pytest.mark.parametrize("fmi", [2, 3])
def test_fmutool_compiles_the_sources(native_fmus, tmp_path, fmi):
    """To a library whose functions have the standard's names."""
    bare = tmp_path / "bare.fmu"
    with zipfile.ZipFile(native_fmus[fmi]) as whole, zipfile.ZipFile(bare, "w") as sources:
        for name in whole.namelist():
            if not name.startswith("binaries/"):
                sources.writestr(name, whole.read(name))
    assert fmpy.supported_platforms(str(bare)) == ["c-code"]
    compiled = tmp_path / "compiled.fmu"
    command = [found("fmutool"), "-input", str(bare), "-compile-sources", "-output", str(compiled)]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert compiled.exists(), run.stdout + run.stderr
    start = {"flange.s": 3e-4}
    forces = [
        fmpy.simulate_fmu(str(path), stop_time=0.01, start_values=start, output=["flange.f"])["flange.f"]
        for path in (compiled, native_fmus[fmi])
    ]
    assert np.abs(forces[1]).max() > 0
    np.testing.assert_allclose(*forces, rtol=1e-12)
