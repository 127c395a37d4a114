"""The A and f that clamps' laws are taken for, found by runs: those of the motion that comes out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pipeclamp_fmu.contents.clamp_of_law import clamp_model, condition_parameter
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.file import Interval, LawFile, law_of
from pipeclamp_models.law.range import conditions_inside
from pipeclamp_models.realise.stepping import CONDITIONS_FIRST, conditions_of
from pipeclamp_system.cosim.building import law_in
from pipeclamp_system.cosim.result import CosimResult
from pipeclamp_system.description.system import ClampSource, SystemDescription

SOLVED, MOST_RUNS, FULL_STEPS = 2e-3, 20, 3
"""A and f are solved when they change by no more than this share; runs until it is given up, runs with full steps."""

MEASURED_SHARE = 0.3
"""Last part of a run, in which the A and f of its motion are measured."""
MEASURED_POINTS = 20_000
"""Points of it."""


class LawConditions(NamedTuple):
    """What a law's coefficients are taken for: A in mm, f in Hz."""

    A: float
    f: float


def given_conditions(clamp: ClampSource, system: SystemDescription) -> LawConditions:
    """Give what a clamp's law is taken for, or starts from."""
    return LawConditions(clamp.amplitude_mm or 0.0, clamp.frequency_Hz or system.excitation.frequency_Hz or 0.0)


def further_conditions(file: LawFile, source: ClampSource, where: str) -> dict[str, float]:
    """Give the conditions beyond A, f and T that a clamp's law follows, by the names that its equations give them.

    Raises:
        UserError: the clamp is given a condition that its law doesn't follow; the message begins with `where`.
    """
    model = clamp_model(file)
    further = {entry.name: entry.scale * entry.start for entry in model.further}
    scales = {entry.name: entry.scale for entry in model.further}
    for column, value in source.conditions.items():
        name, setting = condition_parameter(column, value)
        if name not in further:
            raise UserError(
                f"{where}: clamp {source.at!r}: conditions: {column}: law {source.law} doesn't follow it; leave it out "
                "or take a law with an effect that does"
            )
        further[name] = scales[name] * setting
    named = conditions_of(law_of(file).structure.equations_without_rig)[len(CONDITIONS_FIRST) :]
    return dict(zip(named, further.values(), strict=True))


def motion_conditions(result: CosimResult, name: str) -> LawConditions:
    """Give A and f of a clamp's motion over the last part of a run, whole cycles of it; 0 where it is still.

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
        return LawConditions(0.0, 0.0)
    return LawConditions(1e3 * math.sqrt(2 * variance), math.sqrt(float(np.mean(v**2)) / variance) / (2 * math.pi))


@dataclass(frozen=True)
class Solving:
    """Brings the A and f of some clamps' laws nearer to those of their motion, run by run.

    Attributes:
        ranges: what the law's data hold, by condition, of each clamp that is solved, by name.
    """

    ranges: Mapping[str, Mapping[str, Interval]]

    @classmethod
    def of(cls, system: SystemDescription, folder: Path) -> Solving:
        """Give what a system asks for; paths of its laws are relative to a folder."""
        solved = [clamp for clamp in system.clamps if clamp.mode == "solved"]
        return cls({clamp.at: law_in(folder, clamp.law).range if clamp.law else {} for clamp in solved})

    @property
    def most_runs(self) -> int:
        """Runs until it is given up."""
        return MOST_RUNS if self.ranges else 1

    def nearer(self, system: SystemDescription, result: CosimResult, runs: int) -> tuple[SystemDescription, float]:
        """Give the system for the next run, and by which share its A and f differ from those of the last one.

        Args:
            system: as it was run last.
            result: of that run.
            runs: how many there were.
        """
        clamps, changes = [], [0.0]
        for clamp in system.clamps:
            if clamp.at not in self.ranges:
                clamps.append(clamp)
                continue
            given = given_conditions(clamp, system)
            found = _held(motion_conditions(result, clamp.at), self.ranges[clamp.at])
            changes += [abs(new / old - 1) for new, old in zip(found, given, strict=True) if new > 0]
            clamps.append(_with_conditions(clamp, found, given, runs))
        return system.model_copy(update={"clamps": tuple(clamps)}), max(changes)


def _held(conditions: LawConditions, known: Mapping[str, Interval]) -> LawConditions:
    """Give A and f inside the range of a law's data, as the clamp FMU holds what it tracks; a still motion's stay 0."""
    moving = {name: value for name, value in conditions._asdict().items() if value > 0}
    return conditions._replace(**conditions_inside(known, moving))


def _with_conditions(clamp: ClampSource, found: LawConditions, given: LawConditions, runs: int) -> ClampSource:
    """Give the clamp with A and f nearer to those of its motion; a still clamp keeps its own."""
    # Near resonance the found amplitude can overshoot by as much as the given one was off: then half the way.
    share = 1.0 if runs <= FULL_STEPS else 0.5
    amplitude, frequency = (
        old + share * (new - old) if new > 0 else old for new, old in zip(found, given, strict=True)
    )
    return clamp.model_copy(update={"amplitude_mm": amplitude, "frequency_Hz": frequency})
