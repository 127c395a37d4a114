"""Co-simulation of a pipe FMU with clamp FMUs: from SYSTEM.toml to a result with its energy balance."""

from __future__ import annotations

import math
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pipeclamp.bundled import open_law
from pipeclamp.errors import UserError
from pipeclamp.parameter_file import Interval, LawFile, read_law
from pipeclamp.pipe import ReducedPipe, reduce
from pipeclamp.pipe_description import read_pipe
from pipeclamp_fmu.build import (
    build_clamp,
    build_excitation,
    build_native_clamp,
    build_native_excitation,
    build_native_pipe,
    build_pipe,
)
from pipeclamp_fmu.excitation import Samples
from pipeclamp_identification.broyden import Tolerance
from pipeclamp_identification.cosim_result import CosimResult
from pipeclamp_identification.coupled_variables import PipeVariables, clamp_parameters, pipe_variables
from pipeclamp_identification.coupling import ORDER, ROLLS_BACK, Participant, Point, System, march
from pipeclamp_identification.divergence import EnergyGuard
from pipeclamp_identification.energy import EnergyBalance, received_work
from pipeclamp_identification.excitation import Signal, excitation_signal
from pipeclamp_identification.hidden_motion import hidden_share
from pipeclamp_identification.importer import FmuParticipant, HeldInputs, LoadedFmu, opened
from pipeclamp_identification.interrupts import held_back
from pipeclamp_identification.schemes import advance_of, best_allowed
from pipeclamp_identification.step_control import march_controlled
from pipeclamp_identification.step_error import step_error
from pipeclamp_identification.system import ClampSource, LawMode, PipeSource, SystemDescription, read_system

Array = NDArray[np.float64]
Progress = Callable[[float], None]

PIPE_ENERGIES = ("energyPipe", "energyDissipated", "workExcitation", "workClamps")
CLAMP_WATCHED = ("A_used", "f_used", "T_used", "energyDissipated")
CLAMP_UNITS = ("m", "Hz", "K", "J")

MODE_CODES: dict[LawMode, float] = {"given": 0.0, "solved": 1.0, "tracked": 2.0}
"""How a result's columns say where a law's A and f came from."""

SOLVED, MOST_RUNS, FULL_STEPS = 2e-3, 20, 3
"""A and f are solved when they change by no more than this share; runs until it is given up, runs with full steps."""

CHECK_SHARE = 1 / 3
"""Of the work, that a run in twice the step is."""

MEASURED_SHARE = 0.3
"""Last part of a run, in which the A and f of its motion are measured."""
MEASURED_POINTS = 20_000
"""Points of it."""


@dataclass(frozen=True)
class Builders:
    """What makes the FMUs of clamps that are given by their laws, of pipes that are described, of excitations."""

    clamp: Callable[[LawFile, Path], object] = build_clamp
    pipe: Callable[[ReducedPipe, Path], object] = build_pipe
    excitation: Callable[[Samples, Path], object] = build_excitation


PYTHON = Builders()
"""Python FMUs: made at once, and run wherever this program does."""

NATIVE = Builders(build_native_clamp, build_native_pipe, build_native_excitation)
"""Native FMUs: they take a C compiler, and run wherever they were compiled for."""


def run_system(path: Path, progress: Progress | None = None) -> CosimResult:
    """Co-simulate the system that a file describes.

    Args:
        path: SYSTEM.toml; paths in it are relative to its folder.
        progress: told the share done, 0 to 1, about every hundredth.

    Raises:
        UserError: the system can't be read or built, an FMU refuses, or the run diverges; the message names the place.
    """
    return run_described(read_system(path), path.parent, str(path), progress)


def run_described(
    description: SystemDescription,
    folder: Path,
    where: str,
    progress: Progress | None = None,
    *,
    checked: bool = True,
) -> CosimResult:
    """Co-simulate a described system.

    Args:
        description: the system.
        folder: what its paths are relative to.
        where: named in errors.
        progress: as of `run_system`.
        checked: whether the error of its step is told, by another run in twice the step.

    Raises:
        UserError: as `run_system`.
    """
    tell, tell_check = _shared(progress, 1 - CHECK_SHARE if checked else 1.0)
    with finished(description, folder) as ready:
        solved = [clamp.mode == "solved" for clamp in ready.clamps]
        ranges = [
            law_in(folder, clamp.law).range if is_solved and clamp.law else {}
            for is_solved, clamp in zip(solved, ready.clamps, strict=True)
        ]
        for runs in range(1, (MOST_RUNS if any(solved) else 1) + 1):
            result = _once(ready, folder, where, tell)
            found = [
                _held(motion_conditions(result, clamp.at), known)
                for clamp, known in zip(ready.clamps, ranges, strict=True)
            ]
            changes = [
                abs(new / old - 1)
                for is_solved, clamp, pair in zip(solved, ready.clamps, found, strict=True)
                if is_solved
                for new, old in zip(pair, _conditions(clamp, ready), strict=True)
            ]
            off = max(changes, default=0.0)
            if off <= SOLVED:
                break
            clamps = tuple(
                _with_conditions(clamp, pair, _conditions(clamp, ready), runs) if is_solved else clamp
                for is_solved, clamp, pair in zip(solved, ready.clamps, found, strict=True)
            )
            ready = ready.model_copy(update={"clamps": clamps})
        result = replace(result, runs=runs, unsolved=off if off > SOLVED else 0.0)
        return _checked(result, ready, folder, where, tell_check) if checked else result


def _shared(progress: Progress | None, share: float) -> tuple[Progress | None, Progress | None]:
    """Split a progress into that of a first part, which has a share of the work, and that of the rest."""
    if progress is None:
        return None, None
    return lambda done: progress(share * done), lambda done: progress(share + (1 - share) * done)


def _checked(
    result: CosimResult, ready: SystemDescription, folder: Path, where: str, progress: Progress | None
) -> CosimResult:
    """Give the result with the error that it owes to its step: by a run in twice the step, or in half of it.

    A run that fails, itself hides motion, or takes the same steps (there is none longer than the whole run) can't tell;
    the half step is asked only where nothing else is in doubt.
    """
    doubtful = bool(result.doubts())
    for factor in (2.0,) if doubtful else (2.0, 0.5):
        try:
            other = _once(_in_steps(ready, factor), folder, where, progress)
        except UserError:
            continue
        if other.hidden_share <= result.trusted_share and other.time.size != result.time.size:
            return replace(result, step_error=step_error(result, other))
    return result if doubtful else replace(result, step_error=math.inf)


def _in_steps(description: SystemDescription, factor: float) -> SystemDescription:
    """Give a description with macro steps that are longer by a factor; of controlled ones their tolerance too."""
    run = description.run
    update = {"step_s": factor * run.even_step_s}
    if run.energy_tolerance is not None:
        update["energy_tolerance"] = factor ** ORDER[run.scheme] * run.energy_tolerance
    return description.model_copy(update={"run": run.model_copy(update=update)})


def motion_conditions(result: CosimResult, name: str) -> tuple[float, float]:
    """Give A (mm) and f (Hz) of a clamp's motion over the last part of a run, whole cycles of it.

    A = sqrt(2 var s), f = sqrt(var v/var s)/(2 pi), as the clamp FMU's tracker has them.
    """
    s, v = result.columns[f"{name}.s"], result.columns[f"{name}.v"]
    # Steps may differ in length; the averages want even ones.
    even = np.linspace((1 - MEASURED_SHARE) * result.time[-1], result.time[-1], MEASURED_POINTS)
    s, v = np.interp(even, result.time, s), np.interp(even, result.time, v)
    rising = np.flatnonzero((s[:-1] < s.mean()) & (s[1:] >= s.mean()))
    if rising.size > 1:
        s, v = s[rising[0] : rising[-1]], v[rising[0] : rising[-1]]
    variance = float(np.var(s))
    if variance == 0.0:
        return 0.0, 0.0
    return 1e3 * math.sqrt(2 * variance), math.sqrt(float(np.mean(v**2)) / variance) / (2 * math.pi)


def _held(conditions: tuple[float, float], known: Mapping[str, Interval]) -> tuple[float, float]:
    """Give A and f inside the range of a law's data, as the clamp FMU holds what it tracks; a still motion's stay 0."""
    values = dict(zip(("A", "f"), conditions, strict=True))
    for name, value in values.items():
        if name in known and value > 0:
            values[name] = min(max(value, known[name].minimum), known[name].maximum)
    return values["A"], values["f"]


def _conditions(clamp: ClampSource, description: SystemDescription) -> tuple[float, float]:
    """Give A (mm) and f (Hz) that a clamp's law is taken for, or starts from."""
    return clamp.amplitude_mm or 0.0, clamp.frequency_Hz or description.excitation.frequency_Hz or 0.0


def _with_conditions(
    clamp: ClampSource, found: tuple[float, float], given: tuple[float, float], runs: int
) -> ClampSource:
    """Give the clamp with A and f nearer to those of its motion; a still clamp keeps its own."""
    # Near resonance the found amplitude can overshoot by as much as the given one was off: then half the way.
    share = 1.0 if runs <= FULL_STEPS else 0.5
    amplitude, frequency = (
        old + share * (new - old) if new > 0 else old for new, old in zip(found, given, strict=True)
    )
    return clamp.model_copy(update={"amplitude_mm": amplitude, "frequency_Hz": frequency})


def _once(description: SystemDescription, folder: Path, where: str, progress: Progress | None) -> CosimResult:
    """Run a description whose FMUs are finished."""
    paths = [(folder / str(description.pipe.fmu), "pipe"), *((folder / str(c.fmu), c.at) for c in description.clamps)]
    with held_back() as let_through, opened(paths) as (pipe, *clamps):
        pipe.rename(description.pipe.variables)
        for fmu, source in zip(clamps, description.clamps, strict=True):
            fmu.rename(source.variables)
        variables = pipe_variables(pipe.variables, pipe.path, description, where)
        run = description.run
        signal = excitation_signal(description.excitation, variables.kind, run.stop_s, folder, where)
        stuck = [fmu.instance for fmu in (pipe, *clamps) if not fmu.can_roll_back]
        scheme = best_allowed(run.scheme, not stuck)
        description = description.model_copy(update={"run": run.model_copy(update={"scheme": scheme})})
        start: dict[str, float | bool] = {variables.excitation: signal(0.0)}
        if "inputsAtStepEnd" in pipe.variables:
            start["inputsAtStepEnd"] = scheme in ROLLS_BACK
        pipe.initialise(start)
        for fmu, source in zip(clamps, description.clamps, strict=True):
            fmu.initialise(clamp_parameters(source, description, fmu.variables))
        result = _run(description, variables, signal, pipe, clamps, progress, let_through)
        if scheme == run.scheme:
            return result
        word = f"{', '.join(stuck)} can't save and restore a state: coupled by {scheme!r} instead of {run.scheme!r}"
        return replace(result, warnings=(word, *result.warnings))


@contextmanager
def finished(description: SystemDescription, folder: Path, build: Builders = PYTHON) -> Iterator[SystemDescription]:
    """Give the description with all its FMUs built; those that were built are gone at the end.

    Args:
        description: the system.
        folder: what its paths are relative to.
        build: what makes the FMUs.

    Raises:
        UserError: a pipe or a law can't be read or built.
    """
    built = Path(tempfile.mkdtemp(prefix="pipeclamp_"))
    try:
        pipe = description.pipe
        if pipe.fmu is None:
            build.pipe(reduce(read_pipe(folder / str(pipe.file))), built / "pipe.fmu")
            pipe = PipeSource(fmu=str(built / "pipe.fmu"))
        clamps = []
        for index, clamp in enumerate(description.clamps):
            if clamp.fmu is None:
                output = built / f"clamp_{index}.fmu"
                build.clamp(law_in(folder, str(clamp.law)), output)
                clamp = clamp.model_copy(update={"fmu": str(output)})
            clamps.append(clamp)
        yield description.model_copy(update={"pipe": pipe, "clamps": tuple(clamps)})
    finally:
        shutil.rmtree(built, ignore_errors=True)


def law_in(folder: Path, name: str) -> LawFile:
    """Give a law by its path relative to a folder, or by the name of a bundled one."""
    path = folder / name
    return read_law(path) if path.suffix or path.exists() else open_law(name)


def _run(
    description: SystemDescription,
    variables: PipeVariables,
    signal: Signal,
    pipe: LoadedFmu,
    clamps: Sequence[LoadedFmu],
    progress: Progress | None,
    between_steps: Callable[[], None],
) -> CosimResult:
    """March the initialised FMUs and keep what they say."""
    names = tuple(clamp.at for clamp in description.clamps)
    run = description.run
    pipe_participant = FmuParticipant(
        pipe,
        [variables.excitation, *(f"{name}.f" for name in names)],
        [*(f"{name}.s" for name in names), *(f"{name}.v" for name in names)],
        [*(f"{name}.{kind}" for name in variables.probes for kind in "sva"), *PIPE_ENERGIES],
    )
    clamp_participants = tuple(
        FmuParticipant(clamp, ["flange.s", "flange.v"], ["flange.f"], CLAMP_WATCHED, ["inRange"]) for clamp in clamps
    )
    coupled_pipe: Participant = pipe_participant
    if run.scheme in ROLLS_BACK and "inputsAtStepEnd" not in pipe.variables:
        coupled_pipe = HeldInputs(
            pipe_participant, (signal(0.0), *(clamp.outputs()[0] for clamp in clamp_participants))
        )
    system = System(coupled_pipe, clamp_participants, signal)
    participants = (pipe_participant, *clamp_participants)
    tolerance = Tolerance(run.tolerance, run.max_iterations)
    points: list[Point] = []
    watched: list[list[float]] = []
    in_range = [True] * len(clamps)
    guard = EnergyGuard()
    energy, work = (3 * len(variables.probes) + PIPE_ENERGIES.index(name) for name in ("energyPipe", "workExcitation"))
    advance = advance_of(run.scheme, system, tolerance)
    if run.energy_tolerance is None or run.scheme not in ROLLS_BACK:
        marched = march(system, advance, run.even_step_s, run.steps)
    else:
        marched = march_controlled(system, advance, run.step_s, run.stop_s, run.energy_tolerance)
    told = -1
    try:
        for point in marched:
            between_steps()
            row = [value for participant in participants for value in participant.watched()]
            guard.check(point, row[energy], row[work])
            points.append(point)
            watched.append(row)
            for index, participant in enumerate(clamp_participants):
                in_range[index] = in_range[index] and all(participant.flags())
            percent = int(100 * point.time / run.stop_s + 1e-6)
            if progress is not None and percent > told:
                progress(percent / 100)
                told = percent
    except UserError as error:
        of_steps = "" if run.energy_tolerance else f" of {run.steps}"
        diverging = f"the coupling diverges from step {guard.since} on: " if guard.since else ""
        remedy = "; use scheme = 'iterated' or a smaller step_s" if guard.since else ""
        raise UserError(f"{diverging}{error}; the run was stopped in step {len(points)}{of_steps}{remedy}") from error
    finally:
        for participant in participants:
            participant.release()
    return _result(description, variables, points, np.array(watched), in_range, (pipe, *clamps))


def _result(
    description: SystemDescription,
    variables: PipeVariables,
    points: Sequence[Point],
    watched: Array,
    in_range: Sequence[bool],
    fmus: Sequence[LoadedFmu],
) -> CosimResult:
    names = tuple(clamp.at for clamp in description.clamps)
    columns: dict[str, Array] = {}
    units: dict[str, str] = {}

    def keep(name: str, unit: str, values: Array | list[float] | list[int]) -> None:
        columns[name], units[name] = np.asarray(values, dtype=np.float64), unit

    displacement = np.array([point.displacement for point in points])
    velocity = np.array([point.velocity for point in points])
    force = np.array([point.force for point in points])
    keep("time", "s", [point.time for point in points])
    keep(variables.excitation, "m/s2" if variables.kind == "base" else "N", [point.excitation for point in points])
    energies_at = 3 * len(variables.probes)
    clamps_at = energies_at + len(PIPE_ENERGIES)
    for index, name in enumerate(names):
        keep(f"{name}.s", "m", displacement[:, index])
        keep(f"{name}.v", "m/s", velocity[:, index])
        keep(f"{name}.f", "N", force[:, index])
        own = watched[:, clamps_at + len(CLAMP_WATCHED) * index :]
        for column, (kind, unit) in enumerate(zip(CLAMP_WATCHED, CLAMP_UNITS, strict=True)):
            keep(f"{name}.{kind}", unit, own[:, column])
    for name, clamp in zip(names, description.clamps, strict=True):
        keep(f"{name}.law_mode", "0 given, 1 solved, 2 tracked", np.full(len(points), MODE_CODES[clamp.mode]))
    for index, name in enumerate(variables.probes):
        for column, (kind, unit) in enumerate((("s", "m"), ("v", "m/s"), ("a", "m/s2"))):
            keep(f"{name}.{kind}", unit, watched[:, 3 * index + column])
    # A parallel master tells the clamps where they were one step before.
    told = np.vstack([displacement[:1], displacement[:-1]]) if description.run.scheme == "parallel" else displacement
    stored, dissipated, work, delivered = watched[:, energies_at:clamps_at].T
    if np.isnan(delivered).any():  # a foreign pipe: by the forces that it was told, and its motion
        given = np.array([point.told for point in points]).reshape(len(points), len(names))
        if description.run.scheme not in ROLLS_BACK:
            given = np.repeat(given[1:], 2, axis=0)  # held over each step
            places = np.repeat(displacement, 2, axis=0)[1:-1]
            delivered = np.concatenate([[0.0], received_work(given, places).sum(axis=1)[1::2]])
        else:
            delivered = received_work(given, displacement).sum(axis=1)
    balance = EnergyBalance(
        excitation=work,
        pipe_stored=stored,
        pipe_dissipated=dissipated,
        clamps_received=received_work(force, told).sum(axis=1),
        clamps_dissipated=np.array([columns[f"{name}.energyDissipated"] for name in names])
        .reshape(len(names), len(points))
        .sum(axis=0),
        delivered=delivered,
    )
    for name in balance.final():
        keep(f"energy.{name}", "J", getattr(balance, name))
    keep("trials", "1", [point.trials for point in points])
    return CosimResult(
        name=description.name,
        scheme=description.run.scheme,
        step=description.run.even_step_s,
        clamp_names=names,
        probe_names=variables.probes,
        columns=columns,
        units=units,
        energy=balance,
        out_of_range=tuple(name for name, inside in zip(names, in_range, strict=True) if not inside),
        modes=tuple(clamp.mode for clamp in description.clamps),
        trusted_share=description.run.trusted_share,
        hidden_share=hidden_share(columns["time"], displacement, velocity),
        excitation_frequency=description.excitation.highest_frequency,
        steady=description.excitation.kind == "sine",
        warnings=tuple(f"{fmu.instance}: {text}" for fmu in fmus for text in fmu.messages.warnings),
    )
