"""Cost of FMU steps driven by fmpy, as ratios within one run.

Run: python build_scripts/benchmarks/fmu_step.py [LAW ...]

Prints what set (2 Real) + step + get (1 Real) of a clamp FMU costs as a ratio to a pythonfmu slave with the same
variables that does nothing, and what a macro step of a pipe with a clamp costs in the same unit.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from math import cos, pi, sin
from pathlib import Path

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from pythonfmu import FmuBuilder

from pipeclamp_fmu.build import build_clamp, build_pipe
from pipeclamp_fmu.slaves import clamp as clamp_slave
from pipeclamp_models.law.bundled import bundled_laws, open_law
from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_models.pipe.modes import reduce

STEPS = 4000
ROUNDS = 15
H = 1e-3
SHORT = 2e-5
"""A macro step short enough for a clamp with steep damping to be coupled one after the other."""

PIPE = """
name = "bench"
[pipe]
outer_diameter_mm = 60.3
wall_mm = 3.91
length_m = 6.0
material = "316L"
fluid = "water"
[ends]
left = "pinned"
right = "pinned"
[[clamps]]
name = "clamp1"
position_m = 2.0
[damping]
ratio = 0.01
[modes]
up_to_Hz = 500
"""

EMPTY = '''
from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

class Empty(Fmi2Slave):
    """The clamp's variables as plain attributes, and nothing done."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        for kind, names, causality in {groups}:
            for name in names:
                local = name.replace(".", "_") + "_value"
                setattr(self, local, kind is Real and 0.0)
                variability = Fmi2Variability.tunable if causality == "parameter" else (
                    Fmi2Variability.continuous if kind is Real else Fmi2Variability.discrete)
                self.register_variable(
                    kind(name, causality=Fmi2Causality[causality], variability=variability,
                         getter=lambda local=local: getattr(self, local),
                         setter=lambda value, local=local: setattr(self, local, value)), nested=False)

    def do_step(self, current_time, step_size):
        return True
'''


def empty_slave(folder: Path) -> Path:
    """Build the slave that does nothing, with the clamp's variables, as pythonfmu's users write one."""
    groups = (
        f"((Real, {clamp_slave.INPUTS}, 'input'), (Real, {clamp_slave.PARAMETERS}, 'parameter'), "
        f"(Real, {clamp_slave.OUTPUTS}, 'output'), (Boolean, {clamp_slave.BOOLEAN_PARAMETERS}, 'parameter'), "
        f"(Boolean, {clamp_slave.BOOLEAN_LOCALS}, 'local'))"
    )
    script = folder / "empty_slave.py"
    script.write_text(EMPTY.replace("{groups}", groups), encoding="utf-8")
    return Path(FmuBuilder.build_FMU(script, folder / "empty.fmu"))


def instance(path: Path) -> tuple[FMU2Slave, dict[str, int]]:
    """Give an initialised instance and its value references by name."""
    description = read_model_description(path)
    fmu = FMU2Slave(
        guid=description.guid,
        unzipDirectory=extract(path),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName=path.stem,
    )
    fmu.instantiate()
    fmu.setupExperiment()
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    return fmu, {variable.name: variable.valueReference for variable in description.modelVariables}


def drive_clamp(path: Path, track: bool = False) -> Callable[[], float]:
    """Give what measures one round of set + step + get with a clamp's variables, s per step."""
    fmu, references = instance(path)
    fmu.setBoolean([references["track"]], [track])
    inputs = [references["flange.s"], references["flange.v"]]
    outputs = [references["flange.f"]]
    motion = [[5e-4 * sin(2 * pi * 3 * H * n), 5e-4 * 2 * pi * 3 * cos(2 * pi * 3 * H * n)] for n in range(STEPS)]

    def measure() -> float:
        begin = time.perf_counter()
        for n, values in enumerate(motion):
            fmu.setReal(inputs, values)
            fmu.doStep(n * H, H)
            fmu.getReal(outputs)
        return (time.perf_counter() - begin) / STEPS

    return measure


def drive_pair(pipe_path: Path, clamp_path: Path) -> Callable[[], float]:
    """Give what measures one round of macro steps of a pipe with one clamp, coupled one after the other, s per step."""
    pipe, of_pipe = instance(pipe_path)
    clamp, of_clamp = instance(clamp_path)
    loads = [of_pipe["base.a"], of_pipe["clamp1.f"]]
    motion = [of_pipe["clamp1.s"], of_pipe["clamp1.v"]]
    inputs, outputs = [of_clamp["flange.s"], of_clamp["flange.v"]], [of_clamp["flange.f"]]

    def measure() -> float:
        force = clamp.getReal(outputs)[0]
        begin = time.perf_counter()
        for n in range(STEPS):
            pipe.setReal(loads, [0.5 * sin(2 * pi * 10 * n * SHORT), force])
            pipe.doStep(n * SHORT, SHORT)
            clamp.setReal(inputs, pipe.getReal(motion))
            clamp.doStep(n * SHORT, SHORT)
            force = clamp.getReal(outputs)[0]
        return (time.perf_counter() - begin) / STEPS

    return measure


def main(names: list[str]) -> None:
    """Measure and print."""
    base = "empty pythonfmu slave"
    with tempfile.TemporaryDirectory() as folder:
        measures = {base: drive_clamp(empty_slave(Path(folder)))}
        for name in names or bundled_laws():
            path = Path(folder) / f"{Path(name).stem}.fmu"
            build_clamp(open_law(name), path)
            measures[f"clamp {path.stem}"] = drive_clamp(path)
            measures[f"clamp {path.stem}, track"] = drive_clamp(path, track=True)
        pipe = Path(folder) / "pipe.fmu"
        description = parse_pipe(PIPE)
        build_pipe(reduce(description), pipe)
        modes = len(reduce(description).omega)
        measures[f"pipe of {modes} modes + clamp {path.stem}"] = drive_pair(pipe, path)
        # One after the other in each round, so that what the machine does besides hits all alike.
        rounds = [{name: measure() for name, measure in measures.items()} for _ in range(ROUNDS)]
    for name in measures:
        ratio = statistics.median(entry[name] / entry[base] for entry in rounds)
        print(f"{name:40s} {1e6 * min(entry[name] for entry in rounds):8.2f} us   ratio {ratio:.2f}")


if __name__ == "__main__":
    main(sys.argv[1:])
