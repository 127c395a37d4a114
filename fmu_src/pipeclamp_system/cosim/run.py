"""Co-simulation of a pipe FMU with clamp FMUs: from SYSTEM.toml to a result with its energy balance."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from pipeclamp_fmu.slaves.own_motion import OFF_BY
from pipeclamp_models.base.errors import UserError
from pipeclamp_system.cosim.beating import Beats
from pipeclamp_system.cosim.building import TO_RUN, Builders, finished
from pipeclamp_system.cosim.divergence import DivergedError, EnergyGuard
from pipeclamp_system.cosim.interrupts import held_back
from pipeclamp_system.cosim.law_conditions import SOLVED, Solving
from pipeclamp_system.cosim.recording import CLAMP_UNITS, Recording, pipe_watched, recorded_result
from pipeclamp_system.cosim.result import CosimResult
from pipeclamp_system.cosim.static_stability import about_rest
from pipeclamp_system.cosim.step_error import order_of, step_error
from pipeclamp_system.cosim.variables import PipeVariables, clamp_parameters, pipe_variables
from pipeclamp_system.coupling.broyden import SolverTolerance
from pipeclamp_system.coupling.march import Participant, Point, System, march
from pipeclamp_system.coupling.schemes import advance_of, best_allowed
from pipeclamp_system.coupling.step_control import march_controlled
from pipeclamp_system.description.excitation import Signal, excitation_signal
from pipeclamp_system.description.scheme import ORDER, ROLLS_BACK
from pipeclamp_system.description.system import RunTable, SystemDescription, read_system
from pipeclamp_system.fmus.participant import FmuParticipant, HeldInputs, LoadedFmu, opened

ShareDone = Callable[[float], None]
"""Told the share of a run that is done, 0 to 1."""

CHECK_SHARE = 1 / 3
"""Of the work, that a run in twice the step is."""


def run_system(path: Path, progress: ShareDone | None = None) -> CosimResult:
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
    progress: ShareDone | None = None,
    *,
    checked: bool = True,
    build: Builders = TO_RUN,
) -> CosimResult:
    """Co-simulate a described system.

    Args:
        description: the system.
        folder: what its paths are relative to.
        where: named in errors.
        progress: as of `run_system`.
        checked: whether the error of its step is told, by another run in twice the step.
        build: what makes the FMUs that it lacks.

    Raises:
        UserError: as `run_system`.
    """
    leaves_rest = about_rest(description, folder, where, ", at any step_s")
    try:
        result = _ran(description, folder, where, progress, checked=checked, build=build)
    except DivergedError as error:
        raise (UserError(f"{where}: {leaves_rest}") if leaves_rest else error) from error
    return replace(result, warnings=(leaves_rest, *result.warnings), leaves_rest=True) if leaves_rest else result


def _ran(
    description: SystemDescription,
    folder: Path,
    where: str,
    progress: ShareDone | None,
    *,
    checked: bool,
    build: Builders,
) -> CosimResult:
    """Co-simulate as `run_described`, and check the result by a run in another step."""
    tell, tell_check = _shared(progress, 1 - CHECK_SHARE if checked else 1.0)
    with finished(description, folder, build) as ready:
        result, ready = _solved(ready, folder, where, tell)
        if not checked:
            return result
        beats = _beats(result, ready, folder, where)
        if beats is not None:
            # Two runs of a swing drift apart: what they differ by is no error of their steps.
            return replace(result, beats=beats)
        return _checked(result, ready, folder, where, tell_check)


def _solved(
    ready: SystemDescription, folder: Path, where: str, progress: ShareDone | None
) -> tuple[CosimResult, SystemDescription]:
    """Run a description whose FMUs are finished until A and f are solved; give it with those of the last run, too."""
    solving = Solving.of(ready, folder)
    for runs in range(1, solving.most_runs + 1):
        result = _once(ready, folder, where, progress)
        nearer, off = solving.nearer(ready, result, runs)
        if off <= SOLVED or runs == solving.most_runs:
            break
        ready = nearer
    return replace(result, runs=runs, unsolved=off if off > SOLVED else 0.0), ready


def _shared(progress: ShareDone | None, share: float) -> tuple[ShareDone | None, ShareDone | None]:
    """Split a progress into that of a first part, which has a share of the work, and that of the rest."""
    if progress is None:
        return None, None
    return lambda done: progress(share * done), lambda done: progress(share + (1 - share) * done)


def _checked(
    result: CosimResult, ready: SystemDescription, folder: Path, where: str, progress: ShareDone | None
) -> CosimResult:
    """Give the result with the error that it owes to its step: by a run in twice the step, or in half of it.

    A run that fails, itself hides motion, or takes the same steps (there is none longer than the whole run) can't tell;
    the half step is asked only where nothing else is in doubt.
    """
    doubtful = bool(result.doubts())
    for factor in (2.0,) if doubtful else (2.0, 0.5):
        try:
            other = _coupled(_in_steps(ready, factor), folder, where, progress, result.means_told)
        except UserError:
            continue
        if other.hidden_share <= result.trusted_share and other.time.size != result.time.size:
            return replace(result, step_error=step_error(result, other), order=order_of(result, other))
    return result if doubtful else replace(result, step_error=math.inf)


def _beats(result: CosimResult, ready: SystemDescription, folder: Path, where: str) -> Beats | None:
    """Tell whether an amplitude swings, and for a tracker alone: further runs, in which A and f stand still, tell.

    They begin at the means over the last two fifths of the run, and are solved: the amplitude that the clamp comes to
    is then that of its law.
    """
    tracked = {clamp.at for clamp in ready.clamps if clamp.mode == "tracked"}
    swings = {name: swing for name in tracked if (swing := result.swing(name)) is not None}
    if not swings:
        return None
    late = result.time >= 0.6 * result.time[-1]
    means = {
        name: [float(np.mean(result.columns[f"{name}.{signal}_used"][late])) for signal in "Af"] for name in tracked
    }
    held = [
        clamp.model_copy(
            update={
                "track": False, "solve": True, "amplitude_mm": 1e3 * means[clamp.at][0],
                "frequency_Hz": means[clamp.at][1],
            }
        )
        if clamp.at in tracked
        else clamp
        for clamp in ready.clamps
    ]  # fmt: skip
    name = max(swings, key=lambda one: swings[one].high - swings[one].low)
    try:
        still, _ = _solved(ready.model_copy(update={"clamps": tuple(held)}), folder, where, None)
    except UserError as error:
        return Beats(name, swings[name], means[name][0], None, failed=str(error))
    held_at = float(still.columns[f"{name}.A_used"][-1])
    motion = np.stack([still.time, still.columns[f"{name}.s"]])
    if any(still.swing(one) is not None for one in swings):
        return Beats(name, swings[name], held_at, None, held_motion=motion)
    settles_at = still.amplitude(f"{name}.s")
    return Beats(name, swings[name], held_at, settles_at, solved=not still.unsolved, held_motion=motion)


def _in_steps(description: SystemDescription, factor: float) -> SystemDescription:
    """Give a description with macro steps that are longer by a factor; of controlled ones their tolerance too."""
    run = description.run
    update = {"step_s": factor * run.even_step_s}
    if run.energy_tolerance is not None:
        update["energy_tolerance"] = factor ** ORDER[run.scheme] * run.energy_tolerance
    return description.model_copy(update={"run": run.model_copy(update=update)})


def _once(description: SystemDescription, folder: Path, where: str, progress: ShareDone | None) -> CosimResult:
    """Run a description whose FMUs are finished: where linear forces diverge, with their means."""
    try:
        return _coupled(description, folder, where, progress, means=False)
    except DivergedError:
        if description.run.scheme not in ROLLS_BACK:
            raise
        result = _coupled(description, folder, where, progress, means=True)
        word = (
            f"forces that are linear over a step of {description.run.even_step_s:g} s diverge beside clamps so stiff: "
            "the pipe was told their means instead"
        )
        return replace(result, warnings=(word, *result.warnings))


def _coupled(
    description: SystemDescription, folder: Path, where: str, progress: ShareDone | None, means: bool
) -> CosimResult:
    """Run a description whose FMUs are finished; schemes that roll back tell the pipe linear forces, or their means.

    A force that is held at the mean of the clamp's at both ends does the work on the pipe that a spring takes up, so
    that no spring is too stiff; linear forces err by half as much, where they don't diverge.
    """
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
            start["inputsAtStepEnd"] = scheme in ROLLS_BACK and not means
        pipe.initialise(start)
        for fmu, source in zip(clamps, description.clamps, strict=True):
            fmu.initialise(clamp_parameters(source, description, fmu.variables))
        result = _run(description, variables, signal, pipe, clamps, progress, let_through, means)
        if scheme == run.scheme:
            return result
        word = f"{', '.join(stuck)} can't save and restore a state: coupled by {scheme!r} instead of {run.scheme!r}"
        return replace(result, warnings=(word, *result.warnings))


def _run(
    description: SystemDescription,
    variables: PipeVariables,
    signal: Signal,
    pipe: LoadedFmu,
    clamps: Sequence[LoadedFmu],
    progress: ShareDone | None,
    between_steps: Callable[[], None],
    means: bool,
) -> CosimResult:
    """March the initialised FMUs and keep what they say."""
    names = [clamp.at for clamp in description.clamps]
    run = description.run
    pipe_participant = FmuParticipant(
        pipe,
        [variables.excitation, *(f"{name}.f" for name in names)],
        [*(f"{name}.s" for name in names), *(f"{name}.v" for name in names)],
        pipe_watched(variables),
    )
    clamp_participants = {
        name: FmuParticipant(clamp, ["flange.s", "flange.v"], ["flange.f"], tuple(CLAMP_UNITS), ["inRange"])
        for name, clamp in zip(names, clamps, strict=True)
    }
    coupled_pipe: Participant = pipe_participant
    means = run.scheme in ROLLS_BACK and (means or "inputsAtStepEnd" not in pipe.variables)
    if means:
        forces = (clamp.outputs()[0] for clamp in clamp_participants.values())
        coupled_pipe = HeldInputs(pipe_participant, (signal(0.0), *forces))
    system = System(coupled_pipe, tuple(clamp_participants.values()), signal)
    recording, guard = Recording(pipe_participant, clamp_participants), EnergyGuard()
    taken, report = 0, _by_per_cent(progress)
    try:
        for point in _marched(system, run):
            between_steps()
            recording.take(point)
            guard.check(point, recording.last("energyPipe"), recording.last("workExcitation"))
            taken += 1
            report(point.time / run.stop_s)
    except UserError as error:
        raise _stopped(error, run, taken, guard.since) from error
    finally:
        for participant in (pipe_participant, *clamp_participants.values()):
            participant.release()
    # That a force is off for the A and f of its motion, the result says in its own words, of the run's end.
    warnings = [
        f"{fmu.instance}: {text}" for fmu in (pipe, *clamps) for text in fmu.messages.warnings if OFF_BY not in text
    ]
    return replace(recorded_result(description, variables, recording, warnings), means_told=means)


def _by_per_cent(progress: ShareDone | None) -> ShareDone:
    """Give what tells a progress the share that is done, once a per cent."""
    shown = -1

    def report(share: float) -> None:
        nonlocal shown
        percent = int(100 * share + 1e-6)
        if progress is not None and percent > shown:
            progress(percent / 100)
            shown = percent

    return report


def _stopped(error: UserError, run: RunTable, taken: int, diverging_since: int) -> UserError:
    """Give the error of a run that was stopped in a step; where it diverges since one (not 0), with what to do."""
    of_steps = "" if run.energy_tolerance else f" of {run.steps}"
    stopped = f"{error}; the run was stopped in step {taken}{of_steps}"
    if not diverging_since:
        return UserError(stopped)
    other = "" if run.scheme in ROLLS_BACK else "scheme = 'iterated' or "
    return DivergedError(
        f"the coupling diverges from step {diverging_since} on: {stopped}; use {other}a smaller step_s"
    )


def _marched(system: System, run: RunTable) -> Iterator[Point]:
    """Step initialised participants as a run asks for."""
    even = run.energy_tolerance is None or run.scheme not in ROLLS_BACK
    advance = advance_of(run.scheme, system, SolverTolerance(run.tolerance, run.max_iterations), locates=even)
    if even:
        return march(system, advance, run.even_step_s, run.steps)
    assert run.energy_tolerance is not None
    return march_controlled(system, advance, run.step_s, run.stop_s, run.energy_tolerance)
