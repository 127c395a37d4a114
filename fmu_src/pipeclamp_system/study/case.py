"""One case of a study: what the system's pipe does there."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from pipeclamp_fmu.build import build_pipe
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.pipe.description import PipeDescription
from pipeclamp_models.pipe.modes import ReducedPipe, reduce
from pipeclamp_system.bands.band import Band, band_of, steps_of
from pipeclamp_system.bands.described import unknown_of
from pipeclamp_system.bands.response import DAMP_IT, moving_of
from pipeclamp_system.bands.sensitivity import moves_at, of_half_range, with_laws
from pipeclamp_system.cosim.result import CosimResult
from pipeclamp_system.cosim.run import ShareDone, run_described
from pipeclamp_system.description.excitation import require_kind
from pipeclamp_system.description.system import PipeSource, SystemDescription
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.described import response_table, steady_clamps, steady_system
from pipeclamp_system.steady.states import SteadyState, about_unbounded, amplitudes_of
from pipeclamp_system.study.description import Study, Values

Row = dict[str, Any]

TRUSTED = "trusted"
"""Column that says whether a co-simulated case is to be trusted."""

LOW, HIGH = ".s_low [mm]", ".s_high [mm]"
"""How columns end that hold the ends of an amplitude's band."""

IN_RANGE = ".inRange"
"""How columns end that say whether a clamp's law was used inside the range of its data."""


@lru_cache(maxsize=64)
def _reduced(text: str) -> ReducedPipe:
    return reduce(PipeDescription.model_validate_json(text))


@one_thread()
def evaluate(study: Study, number: int, values: Values) -> Row:
    """Evaluate a case; what it can't be is said in its row, so that the others go on.

    Args:
        study: the study.
        number: of the case.
        values: what is varied, in this case.

    Returns:
        its number, values, amplitudes (mm) and frequency (Hz) by point, whether each clamp's law has data for that
        motion, whether all of it is stable (of "cosim": whether it is to be trusted, and why not, or ""), the time it
        took (s), and an error or "".
    """
    begin = time.perf_counter()
    row: Row = {"case": number, **values, "error": ""}
    try:
        row |= _measured(study, *study.described(values))
    except (UserError, ArithmeticError, np.linalg.LinAlgError) as error:
        row["error"] = str(error)
    return row | {"seconds": time.perf_counter() - begin}


def _measured(study: Study, pipe_table: PipeDescription, system: SystemDescription) -> Row:
    """Give what the study asks for."""
    where = study.description.name
    if study.description.measure == "cosim":
        return _cosimulated(study, pipe_table, system)
    pipe = _reduced(pipe_table.model_dump_json())
    require_kind(system.excitation, pipe.excitation, where)
    table = response_table(system, where)
    steady = steady_system(system, pipe, study.folder, None, 1.0, table.harmonics, where)
    if study.description.measure == "peak":
        followed = steady.followed(table.from_Hz, table.to_Hz)
        states, pieces = list(followed.states), followed.pieces
        if followed.unbounded:
            raise UserError(f"the response has no peak: it is {about_unbounded(followed)}")
        if states and not followed.complete:
            raise UserError(f"the response was {followed.reach()}; its peak isn't known: try other ends of [response]")
    else:
        frequency = system.excitation.frequency_Hz
        if frequency is None:
            raise UserError(f"{where}: measure = 'steady' needs an excitation of kind 'sine'; use 'peak' or 'cosim'")
        state = steady.at(frequency)
        states = [] if state is None else [state]
        pieces = ()
    if not states:
        raise UserError(f"{where}: no steady state was found")
    if study.per_cent is not None and any(state.cycles is not None for state in states):
        raise UserError(f"{where}: the motion was found in time, and a band follows from one that is balanced")
    if study.per_cent is not None and any(state.neutral for state in states):
        raise UserError(f"{where}: nothing damps the motion, so that no band of it is known; {DAMP_IT}")
    amplitudes = np.array([amplitudes_of(state) for state in states])
    points = (*(clamp.at for clamp in system.clamps), *pipe.probe_names)
    bands = None if study.per_cent is None else _bands(study, system, pipe, steady, states[0], pieces)
    row: Row = {
        "stable": _stable(states),
        "pipe_stable": float(pipe.stability.kind == "stable"),
    }
    for index, name in enumerate(points):
        highest = int(amplitudes[:, index].argmax())
        row[f"{name}.s [mm]"] = float(amplitudes[highest, index])
        if bands is not None:
            row[f"{name}{LOW}"] = max(row[f"{name}.s [mm]"] + bands[index].low, 0.0)
            row[f"{name}{HIGH}"] = row[f"{name}.s [mm]"] + bands[index].high
        row[f"{name}.frequency [Hz]"] = states[highest].frequency
        if index < len(system.clamps):
            row[f"{name}{IN_RANGE}"] = not states[highest].beyond[index]
    return row


def _stable(states: Sequence[SteadyState]) -> float | None:
    """Give 1 where all motions are stable, 0 where one isn't; None where nothing damps what isn't."""
    if any(not (state.stable or state.neutral) for state in states):
        return 0.0
    return None if any(state.neutral for state in states) else 1.0


def _bands(
    study: Study, system: SystemDescription, pipe: ReducedPipe, steady: SteadySystem, state: SteadyState,
    pieces: Sequence[Sequence[SteadyState]],
) -> list[Band]:  # fmt: skip
    """Give the band beside the amplitude of each clamp and probe, mm, to first order: of the peak, or of one state."""
    assert study.per_cent is not None
    steps, what = steps_of(study.per_cent), unknown_of(system, study.folder)
    found = steady_clamps(system, pipe, study.folder, None, study.description.name)
    clamps = with_laws([clamp for _, clamp in found], what)
    if pieces:
        sizes = what.scales
        tops = [max(own, key=lambda one: one.peak()[1]) for own in moving_of(steady, clamps, pieces, what)]
        told = [(one.peak_moves(sizes)[1], one.peak_errors()[1]) for one in tops]
    else:
        motion = np.concatenate([state.clamps, state.probes])
        told = [(one, 0.0) for one in of_half_range(motion, moves_at(steady, clamps, state, what)).T]
    return [band_of(0.0, slopes, what, steps, off) for slopes, off in told]


def _cosimulated(study: Study, pipe_table: PipeDescription, system: SystemDescription) -> Row:
    """Co-simulate a case; amplitudes are those of the last fifth."""
    result = run_varied(pipe_table, system, study.folder, study.description.name)
    row: Row = {TRUSTED: result.trusted, "doubts": "; ".join(what for what, _ in result.doubts())}
    row |= {f"{name}{IN_RANGE}": name not in result.out_of_range for name in result.clamp_names}
    return row | {
        f"{point}.s [mm]": 1e3 * result.amplitude(f"{point}.s") for point in (*result.clamp_names, *result.probe_names)
    }


def run_varied(
    pipe_table: PipeDescription, system: SystemDescription, folder: Path, where: str, progress: ShareDone | None = None
) -> CosimResult:
    """Co-simulate a system on a pipe that stands in no file; other arguments as of `run_described`."""
    with tempfile.TemporaryDirectory(prefix="pipeclamp_") as name:
        file = Path(name) / "pipe.fmu"
        build_pipe(_reduced(pipe_table.model_dump_json()), file)
        return run_described(
            system.model_copy(update={"pipe": PipeSource(fmu=str(file))}), folder, where, progress
        )  # fmt: skip
