"""A described system as an SSP, to be run by other people's masters."""

from __future__ import annotations

import tempfile
from pathlib import Path

from pipeclamp_fmu.contents.excitation import Samples
from pipeclamp_fmu.ssp import Component, Port, SystemStructure, write_ssp
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import untaken
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_system.cosim.building import Builders, finished
from pipeclamp_system.cosim.parallel_step import ParallelStep, parallel_step
from pipeclamp_system.cosim.variables import clamp_parameters, pipe_variables
from pipeclamp_system.description.excitation import excitation_signal
from pipeclamp_system.description.system import read_system
from pipeclamp_system.fmus.variables import find_variables, read_model_description, renamed, variables_of

PIPE, EXCITATION = "pipe", "excitation"
"""Names of the elements beside the clamps, unless a clamp has one of them."""
FLANGE = ("flange.s", "flange.v", "flange.f")
EXCITATION_UNITS = {"base": "m/s2", "force": "N"}

MOST_EXCITATION_SAMPLES = 200_000
"""Of the excitation, one a step, in its FMU."""


def write_system(path: Path, output: Path, build: Builders, tell: Progress = silent) -> ParallelStep:
    """Write the system that a file describes as an SSP: excitation, pipe, clamps, connections, parameters, step.

    Args:
        path: SYSTEM.toml; paths in it are relative to its folder.
        output: the SSP to write, whole or not at all.
        build: what makes the FMUs of clamps, pipe and excitation.
        tell: told which steps are tried.

    Returns:
        the step that masters may take that couple in parallel, as most do.

    Raises:
        UserError: the system can't be read or built, has too many steps, or the file can't be written.
    """
    folder = path.parent
    described = read_system(path)
    run = described.run
    if run.steps > MOST_EXCITATION_SAMPLES:
        raise UserError(
            f"{path}: run has {run.steps} steps; expected at most {MOST_EXCITATION_SAMPLES}, "
            "as an SSP holds a sample for each"
        )
    with finished(described, folder, build) as description, tempfile.TemporaryDirectory(prefix="pipeclamp_") as scratch:
        pipe_fmu = folder / str(description.pipe.fmu)
        pipe = renamed(variables_of(read_model_description(pipe_fmu)), description.pipe.variables, pipe_fmu)
        coupled = pipe_variables(pipe, pipe_fmu, description, str(path))
        signal = excitation_signal(description.excitation, coupled.kind, run.stop_s, folder, str(path))
        values = [signal(min(index * run.even_step_s, run.stop_s)) for index in range(run.steps + 1)]
        excitation_fmu = Path(scratch) / "excitation.fmu"
        build.excitation(Samples(run.even_step_s, values, EXCITATION_UNITS[coupled.kind]), excitation_fmu)
        taken = {clamp.at.casefold() for clamp in description.clamps}
        pipe_name, excitation_name = (untaken(name, taken) for name in (PIPE, EXCITATION))
        connections: list[tuple[Port, Port]] = [
            ((excitation_name, "signal"), (pipe_name, pipe[coupled.excitation].name))
        ]
        components = [Component(excitation_name, excitation_fmu, {}), Component(pipe_name, pipe_fmu, {})]
        for source in description.clamps:
            name, fmu = source.at, folder / str(source.fmu)
            clamp = renamed(variables_of(read_model_description(fmu)), source.variables, fmu)
            parameters = clamp_parameters(source, description, clamp)
            theirs = [variable.name for variable in find_variables(clamp, list(parameters), fmu)]
            components.append(Component(name, fmu, dict(zip(theirs, parameters.values(), strict=True))))
            s, v, f = (variable.name for variable in find_variables(clamp, FLANGE, fmu))
            places = [f"{name}.{kind}" for kind in "svf"]
            pipe_s, pipe_v, pipe_f = (variable.name for variable in find_variables(pipe, places, pipe_fmu))
            connections += [
                ((pipe_name, pipe_s), (name, s)),
                ((pipe_name, pipe_v), (name, v)),
                ((name, f), (pipe_name, pipe_f)),
            ]
        found = parallel_step(description, folder, str(path), tell)
        write_ssp(SystemStructure(description.name, components, connections, run.stop_s, found.step), output)
    return found
