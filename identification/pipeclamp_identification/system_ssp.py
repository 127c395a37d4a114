"""A described system as an SSP, to be run by other people's masters."""

from __future__ import annotations

import tempfile
from pathlib import Path

from pipeclamp.errors import UserError
from pipeclamp_fmu.excitation import Samples
from pipeclamp_fmu.ssp import Component, SystemStructure, write_ssp
from pipeclamp_identification.cosim import Builders, clamp_parameters, finished, pipe_variables
from pipeclamp_identification.excitation import excitation_signal
from pipeclamp_identification.importer import opened
from pipeclamp_identification.system import read_system

PIPE, EXCITATION = "pipe", "excitation"
UNITS = {"base": "m/s2", "force": "N"}

MOST_SAMPLES = 200_000
"""Of the excitation, one a step, in its FMU."""


def write_system(path: Path, output: Path, build: Builders) -> None:
    """Write the system that a file describes as an SSP: excitation, pipe, clamps, connections, parameters.

    Args:
        path: SYSTEM.toml; paths in it are relative to its folder.
        output: the SSP to write, whole or not at all.
        build: what makes the FMUs of clamps, pipe and excitation.

    Raises:
        UserError: the system can't be read or built, has too many steps, or the file can't be written.
    """
    folder = path.parent
    described = read_system(path)
    run = described.run
    if run.steps > MOST_SAMPLES:
        raise UserError(
            f"{path}: run has {run.steps} steps; expected at most {MOST_SAMPLES}, as an SSP holds a sample for each"
        )
    with finished(described, folder, build) as description, tempfile.TemporaryDirectory(prefix="pipeclamp_") as scratch:
        pipe_fmu = folder / str(description.pipe.fmu)
        with opened([(pipe_fmu, PIPE)]) as (pipe,):
            variables = pipe_variables(pipe)
        signal = excitation_signal(description.excitation, variables.kind, run.stop_s, folder, str(path))
        values = [signal(min(index * run.step_s, run.stop_s)) for index in range(run.steps + 1)]
        excitation_fmu = Path(scratch) / "excitation.fmu"
        build.excitation(Samples(run.step_s, values, UNITS[variables.kind]), excitation_fmu)
        clamps = [
            Component(clamp.at, folder / str(clamp.fmu), clamp_parameters(clamp, description))
            for clamp in description.clamps
        ]
        connections = [((EXCITATION, "signal"), (PIPE, variables.excitation))]
        for name in (clamp.at for clamp in description.clamps):
            connections += [
                ((PIPE, f"{name}.s"), (name, "flange.s")),
                ((PIPE, f"{name}.v"), (name, "flange.v")),
                ((name, "flange.f"), (PIPE, f"{name}.f")),
            ]
        components = (Component(EXCITATION, excitation_fmu, {}), Component(PIPE, pipe_fmu, {}), *clamps)
        write_ssp(SystemStructure(description.name, components, connections, run.stop_s), output)
