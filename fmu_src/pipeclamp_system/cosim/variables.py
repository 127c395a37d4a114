"""What the FMUs of pipe and clamps couple and start with, by our names: the same for our own runs and for an SSP."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pipeclamp_fmu.contents.clamp_of_law import condition_parameter
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.toml_file import unknown
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_system.description.system import ClampSource, SystemDescription
from pipeclamp_system.fmus.variables import Variables


@dataclass(frozen=True)
class PipeVariables:
    """What a pipe FMU couples, read off its variables."""

    excitation: str
    clamps: tuple[str, ...]
    probes: tuple[str, ...]

    @property
    def kind(self) -> str:
        """What shakes the pipe: "base" or "force"."""
        return "base" if self.excitation == "base.a" else "force"


def pipe_variables(variables: Variables, path: Path, description: SystemDescription, where: str) -> PipeVariables:
    """Read off a pipe FMU what it couples.

    Args:
        variables: of the FMU at `path`.
        path: named in errors.
        description: of the system, whose clamps sit at places of the pipe.
        where: the system's file, named in errors.

    Raises:
        UserError: it is no pipe FMU, or has no place for a clamp.
    """
    inputs = [name for name, variable in variables.items() if variable.causality == "input"]
    outputs = [name for name, variable in variables.items() if variable.causality == "output"]
    excitation = [name for name in inputs if name in ("base.a", "excitation.f")]
    if len(excitation) != 1:
        raise UserError(
            f"{path}: this isn't a pipe FMU: expected one of the inputs base.a and excitation.f, or variables "
            f"that say what stands for it; got inputs {', '.join(inputs) or 'none'}"
        )
    clamps = tuple(name.removesuffix(".f") for name in inputs if name.endswith(".f") and name != excitation[0])
    for index, clamp in enumerate(description.clamps, 1):
        if clamp.at not in clamps:
            raise UserError(f"{where}: clamps[{index}].at: {unknown(clamp.at, list(clamps), 'clamp')}")
    places = [name.removesuffix(".s") for name in outputs if name.endswith(".s")]
    return PipeVariables(excitation[0], clamps, tuple(name for name in places if name not in clamps))


def clamp_parameters(
    source: ClampSource, description: SystemDescription, variables: Variables
) -> dict[str, float | bool]:
    """Give the parameters that a clamp's FMU starts with; of them, a clamp that isn't ours gets what it has.

    Raises:
        UserError: one of ours is given a condition that its law doesn't follow.
    """
    frequency = source.frequency_Hz or description.excitation.frequency_Hz
    parameters: dict[str, float | bool] = {"T": source.temperature_C + CELSIUS, "track": source.track}
    if source.amplitude_mm is not None:
        parameters["A"] = 1e-3 * source.amplitude_mm
    if frequency is not None:
        parameters["f"] = frequency
    ours = "A_used" in variables
    for column, value in source.conditions.items():
        name, setting = condition_parameter(column, value)
        if ours and name not in variables:
            raise UserError(
                f"clamp {source.at!r}: conditions: {column}: its law doesn't follow it, as its FMU has no parameter "
                f"{name}; leave it out, or take a law with an effect that follows it"
            )
        parameters[name] = setting
    return {name: value for name, value in parameters.items() if ours or name in variables}
