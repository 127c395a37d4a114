"""The coupled model of a measurement: its pipe, with the measurement's probes, and its clamps."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from pipeclamp_identification.on_pipe.instrument import Instrument
from pipeclamp_identification.on_pipe.measurement import MeasurementDescription
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.pipe.description import PipeDescription, Place, read_pipe
from pipeclamp_models.pipe.modes import ReducedPipe, reduce, reduce_likewise
from pipeclamp_system.description.measured_table import DRIVES, Drive
from pipeclamp_system.description.system import SystemDescription, read_system
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.clamp import SteadyClamp
from pipeclamp_system.steady.described import steady_clamps

SAMPLES_PER_CYCLE = 128
"""Of a cycle, at which the clamps' laws are evaluated; 256 change a response by less than 0.1 %."""

REDUCTION = 1e-3
"""Error of the pipe's reduction: well below what sensors err by."""


@dataclass(frozen=True, eq=False)
class CoupledModel:
    """A pipe with its clamps, as harmonic balance needs it.

    Attributes:
        pipe: the pipe, with the measurement's probes in their order.
        clamps: which of the pipe's clamps have a law, and the law, by temperature in degC; None: the system's own.
        clamp_names: of those, in their order.
        harmonics: up to which their motion is balanced; None: as many as each motion asks for.
        stated: the pipe as it is stated, in modes; `pipe` may differ from it a little.
        instrument: what the measuring chain makes of its motion.
    """

    pipe: PipeDescription
    clamps: Mapping[float | None, tuple[tuple[int, SteadyClamp], ...]]
    clamp_names: tuple[str, ...]
    harmonics: int | None
    stated: ReducedPipe
    instrument: Instrument = field(default_factory=Instrument)

    @property
    def reduced(self) -> ReducedPipe:
        """The pipe in as many modes as the stated one."""
        return _reduced(self.pipe, self.stated)

    def moves_as(self, other: CoupledModel) -> bool:
        """Tell whether another model, made of the same one, moves alike: they differ in what is seen at most."""
        pipe = self.pipe.model_copy(update={"probes": other.pipe.probes})
        driven, known = (each.instrument for each in (self, other))
        return (
            pipe == other.pipe
            and (self.clamps is other.clamps or _as_stated(self.clamps) == _as_stated(other.clamps))
            and (driven.excitation.gain, driven.frequency) == (known.excitation.gain, known.frequency)
        )

    def system(
        self, temperature: float | None, excitation: Callable[[float], float], harmonics: int | None = None
    ) -> SteadySystem:
        """Give pipe and clamps at a temperature (degC) under a sine; the excitation's amplitude is m/s2 or N over Hz.

        Harmonics are the model's where they are None.

        Raises:
            UserError: the pipe can't be reduced.
        """
        return SteadySystem(self.reduced, self.clamps[temperature], excitation, harmonics or self.harmonics)


def _as_stated(clamps: Mapping[float | None, tuple[tuple[int, SteadyClamp], ...]]) -> object:
    """Give what clamps are made of, to hold them against others."""
    return {temperature: [(place, vars(clamp)) for place, clamp in own] for temperature, own in clamps.items()}


@lru_cache(maxsize=64)
def _reduced(description: PipeDescription, neighbour: ReducedPipe) -> ReducedPipe:
    return reduce_likewise(description, neighbour)


def read_model(
    path: Path, description: MeasurementDescription, drives: Iterable[Drive], clamps_at: Iterable[float | None]
) -> tuple[SystemDescription, CoupledModel]:
    """Read a coupled system, with the probes of a measurement on its pipe.

    Args:
        path: SYSTEM.toml.
        description: of the measurement.
        drives: columns that its excitation stands in.
        clamps_at: temperatures of the clamps, degC; None for the system's own.

    Raises:
        UserError: the system can't be read or built, or the measurement doesn't belong to it.
    """
    system, pipe = _measured_pipe(path, description, drives)
    reduced = reduce(pipe)
    clamps = {
        temperature: tuple(steady_clamps(system, reduced, path.parent, temperature, str(path), SAMPLES_PER_CYCLE))
        for temperature in clamps_at
    }
    names = tuple(source.at for source in system.clamps)
    harmonics = system.response.harmonics if system.response else None
    return system, CoupledModel(pipe, clamps, names, harmonics, reduced)


def _measured_pipe(
    path: Path, description: MeasurementDescription, drives: Iterable[Drive]
) -> tuple[SystemDescription, PipeDescription]:
    """Read a coupled system; give it, and its pipe with a measurement's probes.

    Raises:
        UserError: they can't be read, or the measurement doesn't belong to them.
    """
    system = read_system(path)
    if system.pipe.file is None:
        raise UserError(
            f"{path}: pipe: a comparison needs the pipe's equations; expected file = 'PIPE.toml', not an FMU"
        )
    pipe_path = path.parent / system.pipe.file
    pipe = with_probes(read_pipe(pipe_path), description, str(pipe_path))
    for drive in sorted(drives):
        kind = DRIVES[drive].shakes
        if kind != pipe.excitation.kind:
            raise UserError(
                f"{pipe_path}: excitation: the pipe is excited by {pipe.excitation.kind}, the measurement by {kind} "
                f"({drive}); expected the same; set excitation.kind = {kind!r}"
            )
    modes = pipe.modes.model_copy(update={"error": min(pipe.modes.error, REDUCTION)})
    return system, pipe.model_copy(update={"modes": modes})


def with_probes(pipe: PipeDescription, measurement: MeasurementDescription, where: str) -> PipeDescription:
    """Give a pipe with the probes of a measurement in place of its own; `where` is named in errors.

    Raises:
        UserError: a probe's position isn't known, or is beyond the pipe's end.
    """
    known = {place.name: place.position_m for place in (*pipe.probes, *pipe.clamps)}
    places = []
    for probe in measurement.probes:
        position = known.get(probe.name) if probe.position_m is None else probe.position_m
        if position is None:
            raise UserError(
                f"measurement: probe {probe.name!r} has no position_m, and {where} names no such probe or clamp; "
                "expected its position along the pipe in m"
            )
        if position > pipe.pipe.length_m:
            raise UserError(
                f"measurement: probe {probe.name!r}: got position_m = {position:g}; expected at most the pipe's "
                f"length_m = {pipe.pipe.length_m:g} ({where})"
            )
        places.append(Place(name=probe.name, position_m=position))
    return pipe.model_copy(update={"probes": tuple(places)})
