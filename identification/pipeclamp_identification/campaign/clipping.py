"""Sensors that stand still: at the end of their range, or wherever they were when they failed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from pipeclamp_identification.campaign.cycles import Cycles
from pipeclamp_identification.campaign.faults import Channel, SensorFailure, StuckInPart
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.signals.sample_noise import sample_noise
from pipeclamp_models.base.arrays import Array, BoolArray

FEWEST_ON_A_PLATEAU = 4
"""A plateau shorter than this is no evidence, whatever else."""
FLATTER_THAN_SINE = 3.0
"""Flat-topped loops stay longer within one quantum of their extreme than a sine does."""
STILL_GOES_ON = 0.5
"""Share of its amplitude in the steady cycles with which a channel goes on."""
LONGER_THAN_FRICTION = 0.6
"""Friction's plateau lasts half a cycle at most, from one reversal to the next."""
AT_REVERSAL = 0.015
"""A plateau that ends nearer to a reversal than this share of the cycle, at both ends of the loop, is friction's."""
NOISY = 0.6
"""A channel with more noise than this, in quanta, shows it on friction's plateau too; rounding alone makes 0.29."""
FEWEST_PILED, PILED_OVER_NEXT, NEXT_VALUES = 8, 5, 4
"""Many samples at the very extreme are none of a noisy top's, whose values grow rarer towards it; a quantised sine
without noise stays 2.4 times as long in its last quantum as in the one before."""
FEWEST_AT_END, AMPLITUDES_APART = 3, 1.05
"""As many runs as must share an extreme value, and by how much their amplitudes must differ, to be no chance."""
ROUNDING_SHARE = 1e-9
"""Values that differ by less than this share of half the range are one."""
FEWEST_QUANTA = 500
"""A range of fewer quanta than this meets the same value twice by chance."""

CHANNEL_UNITS: Mapping[Channel, str] = {"displacement": "mm", "force": "N"}
Column = Literal["displacement_mm", "force_N"]
CHANNEL_COLUMNS: Mapping[Channel, Column] = {"displacement": "displacement_mm", "force": "force_N"}


def check_clipping(record: Record, cycles: Cycles) -> None:
    """Refuse a record whose displacement or force stands still, at an extreme value or for most of a cycle.

    At its turning points a quantised sine of amplitude A stays within one quantum q of its extreme for
    sqrt(2 q/A)/pi of the cycle; a clipped one stays there much longer. The quantum is the smallest step
    between the values that the record holds. Dry friction in a record without noise stands as long; it lets go when
    the motion turns.

    Args:
        record: the samples.
        cycles: its steady cycles.

    Raises:
        SensorFailure: with the channel, the value and the length of the plateau.
    """
    for channel, name in CHANNEL_COLUMNS.items():
        samples = getattr(record, name)[cycles.steady]
        per_cycle = len(samples) / cycles.count
        begin, steps = longest_row(samples[1:] == samples[:-1])
        still, value = steps + 1, float(samples[begin])
        if still > LONGER_THAN_FRICTION * per_cycle:
            raise SensorFailure(
                f"stuck sensor: {name} stands at {value:g} for {still} samples in a row "
                f"({still / per_cycle:.1f} cycles)", channel, "stuck", value, CHANNEL_UNITS[channel],
            )  # fmt: skip
        for extreme in (np.max(samples), np.min(samples)):
            at = samples == extreme
            if np.count_nonzero(at) < FEWEST_ON_A_PLATEAU:
                continue
            first, alike = longest_row(at)
            flat = alike >= FEWEST_ON_A_PLATEAU and alike > 2 + FLATTER_THAN_SINE * per_cycle * _quantised_share(
                samples
            )
            if not (flat or _piles_up(samples, at)) or (
                channel == "force" and _is_frictions(record, cycles, first + alike)
            ):
                continue
            raise SensorFailure(
                f"clipped sensor: {name} stands at {extreme:g} for {alike} samples in a row "
                f"({100 * alike / per_cycle:.0f}% of a cycle)",
                channel, "clipped", float(extreme), CHANNEL_UNITS[channel],
            )  # fmt: skip


def stuck_beside(record: Record, cycles: Cycles) -> StuckInPart | None:
    """Find where a channel stands still outside the steady cycles for a cycle or longer, while the other goes on.

    At rest both stand still.

    Args:
        record: the samples.
        cycles: its steady cycles.
    """
    names = list(CHANNEL_COLUMNS.items())
    period = 1.0 / cycles.frequency_Hz
    for part in (slice(cycles.steady.stop - 1, len(record.time_s)), slice(0, cycles.steady.start + 1)):
        time = record.time_s[part]
        for (channel, name), (_, other) in zip(names, names[::-1], strict=True):
            samples = getattr(record, name)[part]
            begin, steps = longest_row(samples[1:] == samples[:-1])
            still = slice(begin, begin + steps + 1)
            if steps == 0 or time[still][-1] - time[still][0] < period:
                continue
            goes_on = _swing(time[still], getattr(record, other)[part][still], cycles.frequency_Hz)
            usual = _swing(record.time_s[cycles.steady], getattr(record, other)[cycles.steady], cycles.frequency_Hz)
            if goes_on > STILL_GOES_ON * usual:
                start, end = (float(at) for at in time[still][[0, -1]])
                return StuckInPart(channel, start, end, float(samples[begin]), CHANNEL_UNITS[channel])
    return None


def _swing(time: Array, samples: Array, frequency: float) -> float:
    """Give the amplitude of a channel at a frequency, a constant and a line beside it."""
    phase = 2 * np.pi * frequency * (time - time[0])
    basis = np.stack([np.ones_like(phase), phase, np.cos(phase), np.sin(phase)], axis=1)
    return float(np.hypot(*np.linalg.lstsq(basis, samples, rcond=None)[0][2:]))


def _piles_up(samples: Array, at: BoolArray) -> bool:
    """Tell whether more samples stand at an extreme than a top that is seen through noise has there."""
    count = np.count_nonzero(at)
    if count < FEWEST_PILED:
        return False
    # a periodic record without noise meets each of its values once a cycle, but for rounding
    _, counts = np.unique(np.round(samples / (ROUNDING_SHARE * np.ptp(samples) / 2)), return_counts=True)
    beside = counts[1 : 1 + NEXT_VALUES] if samples[at][0] == np.min(samples) else counts[-1 - NEXT_VALUES : -1]
    return bool(count > PILED_OVER_NEXT * np.max(beside, initial=1))


def _is_frictions(record: Record, cycles: Cycles, end: int) -> bool:
    """Tell whether a plateau of the force that ends at this steady sample is that of friction in a noiseless record."""
    force, y = record.force_N[cycles.steady], record.displacement_mm[cycles.steady]
    # fourth differences leave next to nothing of a smooth loop
    noise = sample_noise(force)
    if noise > NOISY * quantum_of(force):
        return False
    near = max(2, round(AT_REVERSAL * len(y) / cycles.count))
    around = y[max(end - near, 0) : end + near + 1]
    return bool({int(np.argmax(around)), int(np.argmin(around))} - {0, len(around) - 1})


@dataclass(frozen=True)
class Extremes:
    """How far a channel of a run goes.

    Attributes:
        low, high: its least and largest value.
        held: those of the two in which neighbouring samples agree.
        quanta: steps between its values that its range holds; 0 where nothing is held, and nobody asks.
        amplitude: of the channel's fundamental, which says how different runs are: at other temperatures a motion that
            is the same has another force.
    """

    low: float
    high: float
    held: frozenset[float]
    quanta: float
    amplitude: float


def extremes_of(record: Record, cycles: Cycles, channel: Channel, amplitude: float) -> Extremes:
    """Give how far a channel of a run goes; `amplitude` is that of its fundamental."""
    samples = getattr(record, CHANNEL_COLUMNS[channel])[cycles.steady]
    low, high = float(np.min(samples)), float(np.max(samples))
    agreeing = samples[1:][samples[1:] == samples[:-1]]
    held = frozenset({low, high}.intersection(agreeing.tolist()))
    quanta = (high - low) / quantum_of(samples) if held and high > low else 0.0
    return Extremes(low, high, held, quanta, amplitude)


def at_common_end(runs: Mapping[str, Extremes]) -> dict[str, float]:
    """Give the runs of different amplitude that reach one and the same extreme value, beyond which no run goes."""
    found: dict[str, float] = {}
    for sign in (1.0, -1.0):
        ends = {run: (one.high if sign > 0 else one.low) for run, one in runs.items()}
        farthest = max(ends.values(), key=lambda end: sign * end, default=0.0)
        there = [run for run, end in ends.items() if end == farthest and end in runs[run].held]
        sizes = [runs[run].amplitude for run in there]
        fine = [run for run in there if runs[run].quanta >= FEWEST_QUANTA]
        if len(fine) >= FEWEST_AT_END and max(sizes) > AMPLITUDES_APART * min(sizes):
            found |= dict.fromkeys(there, farthest)
    return found


def longest_row(alike: BoolArray) -> tuple[int, int]:
    """Give where the longest row of True begins, and how long it is: 0 where nothing is True."""
    places = np.flatnonzero(alike)
    if len(places) == 0:
        return 0, 0
    edges = np.concatenate([[0], np.flatnonzero(np.diff(places) > 1) + 1, [len(places)]])
    lengths = np.diff(edges)
    longest = int(np.argmax(lengths))
    return int(places[edges[longest]]), int(lengths[longest])


def quantum_of(samples: Array) -> float:
    """Give the smallest step between the values that a channel holds, half its range at most."""
    half_range = float(np.ptp(samples)) / 2
    steps = np.diff(np.unique(samples))
    # two readings of one value may differ by rounding where a factor was applied
    return float(np.min(steps[steps > ROUNDING_SHARE * half_range], initial=half_range))


def _quantised_share(samples: Array) -> float:
    """Return the share of a cycle for which a sine, quantised as these samples are, stands at one extreme."""
    half_range = np.ptp(samples) / 2
    return 0.0 if half_range == 0.0 else float(np.sqrt(2 * quantum_of(samples) / half_range) / np.pi)
