"""What a run's record says of the run: small beside its samples, enough to judge all runs together."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.campaign.clipping import CHANNEL_UNITS, Extremes, extremes_of, stuck_beside
from pipeclamp_identification.campaign.cycles import Cycles
from pipeclamp_identification.campaign.faults import Channel, SensorFailure, StuckInPart
from pipeclamp_identification.campaign.free_motion import begins_at_rest, fundamental_of_motion
from pipeclamp_identification.campaign.plausibility import (
    CycleByCycle,
    EvenForce,
    Fundamental,
    cycle_by_cycle,
    even_force_of,
    fundamental_of,
)
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.signals.smooth_motion import SmoothMotion


@dataclass(frozen=True)
class LeftOut:
    """A run that can't be used, and why; with the failure, where a sensor's is the reason."""

    run: str
    reason: str
    failure: SensorFailure | None = None

    def __str__(self) -> str:
        return f"run {self.run!r} is left out: {self.reason}"


@dataclass(frozen=True)
class SeenRecord:
    """What a record shows.

    Attributes:
        start_s, end_s, step_s: when it begins and ends by its own clock, and its usual step.
        temperature_C: mean of what was measured; nan where it wasn't.
        shown: of a sine the fundamental, of a free motion the equivalent spring and dashpot.
        place_mm: about which the displacement moves; of a free motion that begins at rest, where it rests.
        mean_force_N: over its cycles, or all of a free motion.
    """

    start_s: float
    end_s: float
    step_s: float
    temperature_C: float
    shown: Fundamental
    place_mm: float
    mean_force_N: float


@dataclass(frozen=True)
class SeenSine(SeenRecord):
    """What a record of a sine shows.

    Attributes:
        cycles: the steady ones.
        by_cycle: mean and fundamental of each.
        ends: how far each channel goes.
        stuck: a channel that stands still beside them; None where none does.
        even: what of the force is alike at both ends of a cycle.
    """

    cycles: Cycles
    by_cycle: CycleByCycle
    ends: Mapping[Channel, Extremes]
    stuck: StuckInPart | None
    even: EvenForce


@dataclass(frozen=True)
class SeenFree(SeenRecord):
    """What a record of a free motion shows: also whether it begins at rest."""

    begins_at_rest: bool


def seen_sine(record: Record, cycles: Cycles) -> SeenSine:
    """Look at a record of a sine that can be used."""
    by_cycle = cycle_by_cycle(record, cycles)
    shown = fundamental_of(record, cycles, by_cycle)
    amplitudes: dict[Channel, float] = {
        "displacement": shown.amplitude_mm, "force": shown.amplitude_mm * abs(shown.stiffness)
    }  # fmt: skip
    ends = {channel: extremes_of(record, cycles, channel, amplitudes[channel]) for channel in CHANNEL_UNITS}
    place, mean_force = (float(np.mean(one[:, 0].real)) for one in (by_cycle.displacement, by_cycle.force))
    stuck, even = stuck_beside(record, cycles), even_force_of(record, cycles, shown)
    return SeenSine(*_clock(record), shown, place, mean_force, cycles, by_cycle, ends, stuck, even)


def seen_free(record: Record, motion: SmoothMotion) -> SeenFree:
    """Look at a record of a free motion that can be used."""
    at_rest = begins_at_rest(motion)
    place, mean_force = float(motion.y[0] if at_rest else np.mean(motion.y)), float(np.mean(record.force_N))
    return SeenFree(*_clock(record), fundamental_of_motion(record, motion), place, mean_force, at_rest)


def _clock(record: Record) -> tuple[float, float, float, float]:
    """Give begin, end and step of the time, and the mean temperature."""
    time, temperature = record.time_s, record.temperature_C
    known = np.empty(0) if temperature is None else temperature[np.isfinite(temperature)]
    begin, end = float(time[0]), float(time[-1])
    return begin, end, (end - begin) / (len(time) - 1), float(np.mean(known)) if len(known) else math.nan
