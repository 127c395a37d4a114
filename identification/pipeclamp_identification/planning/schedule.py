"""In which order a campaign runs, and how long that takes: blocks of one temperature, repeats against drift."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeclamp_identification.campaign.drive import FULL_CYCLES, RAMP_CYCLES
from pipeclamp_identification.campaign.rig.plan import RigRun, plain_name
from pipeclamp_identification.planning.rig_times import RigTimes
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import read_text

LABORATORY = 20.0
"""degC, from which a rig is heated."""
TABLE = "plan.csv"
HOUR, MINUTE = 3600.0, 60.0
SCHEDULE_COLUMNS = (
    "order", "run", "file", "kind", "block", "repeat", "temperature_C", "amplitude_mm", "frequency_Hz", "cycles",
    "ramp_cycles", "duration_s", "wait_min", "start_min", "first_cycle", "drive",
)  # fmt: skip

AmplitudeAndFrequency = tuple[float, float]
"""Amplitude, mm, and frequency, Hz."""


def run_cycles() -> int:
    """Give the load cycles of a run, as its drive signal has them."""
    return FULL_CYCLES + 2 * RAMP_CYCLES


def _run_s(times: RigTimes, frequency: float) -> float:
    """Give the seconds of a run with the pause after it."""
    return run_cycles() / frequency + times.pause_s


@dataclass(frozen=True)
class ScheduledRun:
    """One run of a campaign.

    Attributes:
        run: name; kind: test, or reference, which is the same condition again and again.
        block: number from 1, of one temperature; repeat: number from 1 within it.
        amplitude_mm, frequency_Hz, temperature_C: its condition.
        wait_min: minutes before it, in which the clamp is brought to its temperature.
        start_min: when it begins, from the start of the campaign.
        first_cycle: load cycles before it.
    """

    run: str
    kind: str
    block: int
    repeat: int
    amplitude_mm: float
    frequency_Hz: float
    temperature_C: float
    wait_min: float
    start_min: float
    first_cycle: int

    @property
    def drive(self) -> str:
        """The file of its drive signal, in the plan's folder."""
        return f"drives/{plain_name(f'A{self.amplitude_mm:g}_f{self.frequency_Hz:g}')}.csv"


def scheduled(
    conditions: Sequence[AmplitudeAndFrequency], temperatures: Sequence[float], repeats: int, times: RigTimes, seed: int
) -> tuple[ScheduledRun, ...]:
    """Put a campaign's runs in order.

    Temperatures rise, a block each, for heating takes its time; where there are several the campaign ends with
    reference runs at the first one again, which tell what heat has changed for good. Each block begins and ends with a
    reference run. Within it, each condition comes once in random order, then once in the reverse of it, and so on: what
    drifts evenly is the same on average for all of them after each pair.

    Args:
        conditions: of each block.
        temperatures: degC.
        repeats: of each condition in a block.
        times: what the rig needs besides.
        seed: of the random order.
    """
    random = np.random.default_rng(seed)
    reference = _middle(conditions)
    runs: list[ScheduledRun] = []
    minutes, cycles, at = 0.0, 0, LABORATORY
    levels = sorted(temperatures)
    blocks = [*levels, levels[0]] if len(levels) > 1 else levels
    for number, temperature in enumerate(blocks, 1):
        last = number > len(levels)
        told = [("reference", 1, reference)] if last else _block(conditions, reference, repeats, random)
        wait = times.change_min(at, temperature)
        at = temperature
        for kind, repeat, (A, f) in told:
            name = plain_name(f"B{number}_A{A:g}_f{f:g}_T{temperature:g}")
            name += f"_ref{repeat}" if kind == "reference" else f"_{repeat}"
            minutes += wait
            runs.append(ScheduledRun(name, kind, number, repeat, A, f, temperature, wait, minutes, cycles))
            minutes += _run_s(times, f) / MINUTE
            cycles += run_cycles()
            wait = 0.0
    return tuple(runs)


def _block(
    conditions: Sequence[AmplitudeAndFrequency],
    reference: AmplitudeAndFrequency,
    repeats: int,
    random: np.random.Generator,
) -> list[tuple[str, int, AmplitudeAndFrequency]]:
    told = [("reference", 1, reference)]
    order = random.permutation(len(conditions))
    for repeat in range(1, repeats + 1):
        if repeat > 1:
            order = order[::-1] if repeat % 2 == 0 else random.permutation(len(conditions))
        told += [("test", repeat, conditions[place]) for place in order.tolist()]
    return [*told, ("reference", 2, reference)]


def _middle(conditions: Sequence[AmplitudeAndFrequency]) -> AmplitudeAndFrequency:
    """Give the condition in the middle of all, in octaves."""
    logarithms = np.log(np.array(conditions))
    middle = (logarithms.min(axis=0) + logarithms.max(axis=0)) / 2
    return conditions[int(np.argmin(np.sum((logarithms - middle) ** 2, axis=1)))]


def hours_of(runs: Sequence[ScheduledRun], times: RigTimes) -> float:
    """Give the hours that a campaign takes."""
    return (runs[-1].start_min + _run_s(times, runs[-1].frequency_Hz) / MINUTE) * MINUTE / HOUR


def table_text(runs: Sequence[ScheduledRun]) -> str:
    """Give the text of plan.csv: a row a run, in their order."""
    text = io.StringIO()
    writer = csv.DictWriter(text, SCHEDULE_COLUMNS, lineterminator="\n")
    writer.writeheader()
    for order, one in enumerate(runs, 1):
        own = {name: getattr(one, name) for name in SCHEDULE_COLUMNS if hasattr(one, name)}
        further = {
            "order": order,
            "file": f"runs/{one.run}.csv",
            "cycles": FULL_CYCLES,
            "ramp_cycles": RAMP_CYCLES,
            "duration_s": f"{run_cycles() / one.frequency_Hz:.4g}",
            "wait_min": f"{one.wait_min:.4g}",
            "start_min": f"{one.start_min:.5g}",
        }
        writer.writerow({**own, **further})
    return text.getvalue()


def read_plan(folder: Path) -> tuple[RigRun, ...]:
    """Read the runs of a plan, in their order; from its folder or its plan.csv.

    Raises:
        UserError: there is none, or a row isn't one of a plan; the message names it.
    """
    path = folder / TABLE if folder.is_dir() else folder
    rows = csv.DictReader(io.StringIO(read_text(path, "a plan, as `pipeclamp plan -o FOLDER` writes it")))
    needed = ("run", "amplitude_mm", "frequency_Hz", "temperature_C", "first_cycle")
    missing = [name for name in needed if name not in (rows.fieldnames or ())]
    if missing:
        raise UserError(f"{path}: no column {', '.join(missing)}; expected a plan, as `pipeclamp plan` writes it")
    found = [_planned(row, f"{path}, row {number}") for number, row in enumerate(rows, 2)]
    if not found:
        raise UserError(f"{path}: no rows; expected one a run")
    names = [run.run for run in found]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise UserError(f"{path}: run {twice!r} stands there twice; expected each name once")
    return tuple(found)


def _planned(row: Mapping[str, str | None], where: str) -> RigRun:
    numbers = []
    for name in ("amplitude_mm", "frequency_Hz", "temperature_C", "first_cycle"):
        try:
            numbers.append(float(row[name] or ""))
        except ValueError:
            raise UserError(f"{where}, column {name!r}: got {row[name]!r}; expected a number") from None
        if not math.isfinite(numbers[-1]) or (name == "first_cycle" and numbers[-1] < 0):
            least = " of 0 or more" if name == "first_cycle" else ""
            raise UserError(f"{where}, column {name!r}: got {row[name]!r}; expected a finite number{least}")
    if not row["run"]:
        raise UserError(f"{where}, column 'run': nothing; expected its name")
    return RigRun(row["run"], *numbers)
