"""fmucontainer nests native pipe and clamp in one FMU, which gives in fmpy what our own parallel scheme gives."""

import math
import shutil
import subprocess
import sys
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
"""


def excitation(time):
    return 2.0 * math.sin(2 * math.pi * 10 * time)


def test_a_container_gives_what_our_parallel_scheme_gives(native_pipes, native_fmus, tmp_path):
    program = shutil.which("fmucontainer", path=str(Path(sys.executable).parent)) or shutil.which("fmucontainer")
    if program is None:
        pytest.skip("fmucontainer isn't installed: pip install fmu-manipulation-toolbox")
    shutil.copy(native_pipes["pipe"], tmp_path / "pipe.fmu")
    shutil.copy(native_fmus[2], tmp_path / "clamp.fmu")
    (tmp_path / "system.csv").write_text(WIRING, encoding="utf-8")
    command = [program, "-container", f"system.csv:{H}", "-no-auto-input", "-no-auto-output"]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (tmp_path / "system.fmu").exists(), run.stdout + run.stderr

    time = H * np.arange(STEPS + 1)
    signals = np.rec.fromarrays([time, np.vectorize(excitation)(time)], names=["time", "base.a"])
    result = fmpy.simulate_fmu(
        str(tmp_path / "system.fmu"), stop_time=STEPS * H, step_size=H, output_interval=H, input=signals,
        output=["clamp1.s", "flange.f"],
    )  # fmt: skip
    with opened([(tmp_path / "pipe.fmu", "pipe"), (tmp_path / "clamp.fmu", "clamp")]) as (pipe, clamp):
        pipe.initialise({})
        clamp.initialise({})
        system = System(
            FmuParticipant(pipe, ["base.a", "clamp1.f"], ["clamp1.s", "clamp1.v"], []),
            (FmuParticipant(clamp, ["flange.s", "flange.v"], ["flange.f"], []),),
            excitation,
        )
        points = list(march(system, Explicit(system, sequential=False), H, STEPS))
    own = np.array([(point.displacement[0], point.force[0]) for point in points])
    theirs = np.array([result["clamp1.s"], result["flange.f"]]).T
    assert np.abs(own[:, 0]).max() > 1e-6, "the pipe must move"
    assert (np.abs(theirs - own).max(axis=0) < 1e-9 * np.abs(own).max(axis=0)).all()
