"""A described system as harmonic balance needs it: the pipe's modes, the clamps' laws, the sine."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.signals import OWN_SIGNALS, signal_in_range
from pipeclamp_models.base.toml_file import unknown
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.file import Interval, LawFile, law_of
from pipeclamp_models.pipe.description import read_pipe
from pipeclamp_models.pipe.modes import ReducedPipe, reduce
from pipeclamp_system.cosim.building import law_in
from pipeclamp_system.cosim.law_conditions import further_conditions
from pipeclamp_system.description.excitation import require_kind, sine_amplitude
from pipeclamp_system.description.system import ClampSource, ResponseTable, SystemDescription, read_system
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.clamp import SAMPLES_PER_CYCLE, SteadyClamp, samples_of_law

AROUND = 0.7
"""Of the excitation's frequency: where the response begins unless told, and the inverse of where it ends."""


@dataclass(frozen=True, eq=False)
class RespondingSystem:
    """A system that has a frequency response, as its file describes it."""

    description: SystemDescription
    table: ResponseTable
    pipe: ReducedPipe


def read_responding(path: Path) -> RespondingSystem:
    """Read SYSTEM.toml, and refuse what has no frequency response before anything of it is computed.

    Raises:
        UserError: the system can't be read, or has no sine, no law or nothing to show.
    """
    description = read_system(path)
    table = response_table(description, str(path))
    if description.pipe.file is None:
        raise UserError(f"{path}: pipe: a response needs the pipe's equations; expected file = 'PIPE.toml', not an FMU")
    pipe = reduce(read_pipe(path.parent / description.pipe.file))
    require_kind(description.excitation, pipe.excitation, str(path))
    if not description.clamps and not pipe.probe_names:
        raise UserError(
            f"{path}: there is neither a clamp nor a probe whose motion could be shown; expected one of them"
        )
    steady_system(description, pipe, path.parent, None, 1.0, table.harmonics, str(path))
    return RespondingSystem(description, table, pipe)


def response_table(description: SystemDescription, where: str) -> ResponseTable:
    """Give what a system says of its response, or what follows from its excitation; `where` is named in errors.

    Raises:
        UserError: the excitation is a record.
    """
    excitation = description.excitation
    if excitation.kind == "record":
        raise UserError(f"{where}: excitation: a record has no frequency response; expected kind = 'sine' or 'sweep'")
    if description.response is not None:
        return description.response
    first, last = excitation.frequency_Hz or excitation.from_Hz, excitation.frequency_Hz or excitation.to_Hz
    assert first is not None and last is not None, "the description holds this"
    low, high = min(first, last), max(first, last)
    return ResponseTable(from_Hz=AROUND * low, to_Hz=high / AROUND)


def steady_clamp(
    source: ClampSource, folder: Path, temperature: float | None, where: str, samples: int = SAMPLES_PER_CYCLE
) -> SteadyClamp:
    """Give a clamp of a system as harmonic balance needs it; a temperature in degC stands in for its own.

    A cycle has so many samples, or more where its law asks for more.

    Raises:
        UserError: it is an FMU, whose equations can't be read, or is given a condition that its law doesn't follow.
    """
    if source.law is None:
        raise UserError(f"{where}: clamp {source.at!r}: a response needs the law's equations; expected law, not an FMU")
    file = law_in(folder, source.law)
    given = source.mode == "given"
    law = law_of(file)
    followed = further_conditions(file, source, where)
    kelvin = (source.temperature_C if temperature is None else temperature) + CELSIUS
    largest, fastest = (file.range[name].maximum for name in ("A", "f"))
    needed = samples_of_law(law, {"T": kelvin, **followed}, largest, fastest, samples)
    return SteadyClamp(
        law,
        kelvin,
        source.amplitude_mm if given else None,
        source.frequency_Hz if given else None,
        (file.range["A"].minimum, file.range["A"].maximum),
        (file.range["f"].minimum, file.range["f"].maximum),
        followed,
        samples=needed,
        ranges={
            name: (interval.minimum, interval.maximum)
            for name, interval in ranges_of(file).items()
            if name in ("T", *followed)
        },
        jumps=needed > samples,
    )


def ranges_of(file: LawFile) -> dict[str, Interval]:
    """Give what a law's data hold, by the names that its equations give the conditions.

    Load cycles count from 0, as in the clamp's FMU: tests begin within the first one.
    """
    found = {signal_in_range(name): interval for name, interval in file.range.items()}
    cycles = OWN_SIGNALS["first_cycle"]
    return found | {cycles: found[cycles].model_copy(update={"minimum": 0.0})} if cycles in found else found


def steady_clamps(
    description: SystemDescription, pipe: ReducedPipe, folder: Path, temperature: float | None, where: str,
    samples: int = SAMPLES_PER_CYCLE,
) -> list[tuple[int, SteadyClamp]]:  # fmt: skip
    """Give the clamps of a system and which of the pipe's each is; arguments as of `steady_system` and `steady_clamp`.

    Raises:
        UserError: a clamp is at no place of the pipe, or is an FMU.
    """
    clamps = []
    for source in description.clamps:
        if source.at not in pipe.clamp_names:
            raise UserError(f"{where}: clamps: {unknown(source.at, list(pipe.clamp_names), 'clamp')}")
        clamps.append((pipe.clamp_names.index(source.at), steady_clamp(source, folder, temperature, where, samples)))
    return clamps


def steady_system(
    description: SystemDescription, pipe: ReducedPipe, folder: Path, temperature: float | None, level: float,
    harmonics: int | None, where: str,
) -> SteadySystem:  # fmt: skip
    """Give a described system as harmonic balance needs it; `where` is named in errors.

    Harmonics are as many as each motion asks for where they are None.

    Raises:
        UserError: a clamp is at no place of the pipe, or is an FMU.
    """
    clamps = steady_clamps(description, pipe, folder, temperature, where)
    excitation = description.excitation
    return SteadySystem(pipe, clamps, lambda frequency: level * sine_amplitude(excitation, frequency), harmonics)
