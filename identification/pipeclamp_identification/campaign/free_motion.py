"""Runs of free motion: what makes their records usable, where there are no cycles to go by."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.campaign.clipping import (
    CHANNEL_UNITS,
    FEWEST_ON_A_PLATEAU,
    FLATTER_THAN_SINE,
    NOISY,
    longest_row,
)
from pipeclamp_identification.campaign.cycles import FEWEST_SAMPLES_PER_CYCLE, WIDEST_GAP
from pipeclamp_identification.campaign.faults import Channel, SensorFailure
from pipeclamp_identification.campaign.plausibility import Fundamental
from pipeclamp_identification.campaign.records import Record, UnusableRecord
from pipeclamp_identification.campaign.runs_table import Setup
from pipeclamp_identification.signals.sample_noise import sample_noise
from pipeclamp_identification.signals.smooth_motion import SmoothMotion, smooth_motion
from pipeclamp_models.base.arrays import Array

WENT_ON = 0.05
"""Share of its range by which the other channel must have gone on for a plateau to be a sensor's end: a machine may
dwell, and a record rest."""
FEWEST_STUCK = 20
"""Samples of one value from which on a channel with noise is stuck: of one reading in two or three that is as the last,
so many in a row are no chance."""
SMOOTH_TOP = 8
"""Quanta by which a smooth extreme, quantised, falls over as many samples as it stands, whatever its curvature."""
STANDING_SHARE = 1e-9
"""Share of a channel's largest value that is rounding: what varies by less stands."""
REST_VELOCITY_SHARE = 0.1
"""Share of the rms velocity above which a record doesn't begin at rest."""


@dataclass(frozen=True)
class FreeRun:
    """One usable run of free motion.

    Attributes:
        name: as runs.csv has it.
        setup: the conditions of the test.
        record: its samples.
        motion: of these.
        mean_known: whether the mean of its force counts.
    """

    name: str
    setup: Setup
    record: Record
    motion: SmoothMotion
    mean_known: bool = True

    @property
    def begins_at_rest(self) -> bool:
        """Whether the record does, as a law's memory takes it for granted."""
        return begins_at_rest(self.motion)


def begins_at_rest(motion: SmoothMotion) -> bool:
    """Tell whether a motion begins at rest."""
    return bool(abs(motion.v[0]) <= REST_VELOCITY_SHARE * math.sqrt(np.mean(motion.v**2)))


def free_motion(record: Record) -> SmoothMotion:
    """Give the motion of a record that follows no sine.

    Args:
        record: samples that `check_samples` has passed.

    Raises:
        UnusableRecord: too few samples, a gap in time, nothing but noise, a clipped sensor.
    """
    time = record.time_s - record.time_s[0]
    if time[-1] <= 0.0 or len(time) < FEWEST_SAMPLES_PER_CYCLE:
        raise UnusableRecord(
            f"too few samples: {len(time)} over {time[-1]:g} s; expected at least {FEWEST_SAMPLES_PER_CYCLE}"
        )
    motion = smooth_motion(time, record.displacement_mm)
    if np.std(motion.y) <= motion.noise_mm:
        raise UnusableRecord(
            f"constant displacement but for noise: it stays within {np.ptp(record.displacement_mm):.3g} mm"
        )
    frequency = motion.frequency
    per_period = len(time) / (frequency * float(time[-1]))
    if per_period < FEWEST_SAMPLES_PER_CYCLE:
        raise UnusableRecord(
            f"too few samples: {per_period:.1f} per period of its mean frequency, {frequency:.4g} Hz; expected at "
            f"least {FEWEST_SAMPLES_PER_CYCLE}"
        )
    gap = np.diff(time)
    widest = int(np.argmax(gap))
    if frequency * gap[widest] > WIDEST_GAP:
        raise UnusableRecord(
            f"a gap of {gap[widest]:g} s in time in row {widest + 3}: {frequency * gap[widest]:.2f} of a period at its "
            f"mean frequency, {frequency:.4g} Hz; expected at most {WIDEST_GAP}"
        )
    _check_clipping(record)
    return motion


def _check_clipping(record: Record) -> None:
    """Refuse a record in which a sensor stands at an extreme that it entered at speed, while the other one went on.

    A force that never moves is no force at all. Dry friction stands as long as the motion goes one way, and a force is
    none within a clearance; where the channel has noise that its readings show, these would show it, too. It is clipped
    then however the motion went on, and stuck where it stands at any value while the motion turned.

    Raises:
        SensorFailure: with the channel, the value and the length of the plateau.
    """
    if np.ptp(record.force_N) == 0.0:
        value = float(record.force_N[0])
        raise SensorFailure(
            f"stuck sensor: force_N stands at {value:g} all through the record", "force", "stuck", value,
            CHANNEL_UNITS["force"],
        )  # fmt: skip
    channels = {"displacement_mm": record.displacement_mm, "force_N": record.force_N}
    for name, other in (("displacement_mm", record.force_N), ("force_N", record.displacement_mm)):
        samples = channels[name]
        quantum = _quantum(samples)
        channel: Channel = "force" if name == "force_N" else "displacement"
        begin, steps = longest_row(samples[1:] == samples[:-1])
        still = slice(begin, begin + steps + 1)
        moving = (samples < np.max(samples)) & (samples > np.min(samples))
        moving[still] = False
        shows_noise = np.count_nonzero(moving) > FEWEST_STUCK and sample_noise(samples[moving]) > NOISY * quantum
        for extreme in (np.max(samples), np.min(samples)):
            first, alike = longest_row(samples == extreme)
            last = first + alike
            if alike < FEWEST_ON_A_PLATEAU or first < alike or last + alike > len(samples):
                continue
            before, after = abs(extreme - samples[first - alike]), abs(extreme - samples[last + alike - 1])
            entered = min(before, after) > FLATTER_THAN_SINE**2 * SMOOTH_TOP * quantum
            way = np.ptp(other[first:last]) if shows_noise and channel == "force" else _excursion(other[first:last])
            if entered and way > WENT_ON * np.ptp(other):
                raise SensorFailure(
                    f"clipped sensor: {name} stands at {extreme:g} for {alike} samples in a row, from "
                    f"{record.time_s[first]:g} s on", channel, "clipped", float(extreme), CHANNEL_UNITS[channel],
                )  # fmt: skip
        if shows_noise and steps >= FEWEST_STUCK and _excursion(other[still]) > WENT_ON * np.ptp(other):
            value = float(samples[begin])
            raise SensorFailure(
                f"stuck sensor: {name} stands at {value:g} for {steps + 1} samples in a row, from "
                f"{record.time_s[begin]:g} s on", channel, "stuck", value, CHANNEL_UNITS[channel],
            )  # fmt: skip


def _excursion(samples: Array) -> float:
    """Give by how far samples go beyond both their ends."""
    low, high = sorted((float(samples[0]), float(samples[-1])))
    return max(float(np.max(samples)) - high, low - float(np.min(samples)))


def _quantum(samples: Array) -> float:
    """Give the smallest step between the values that a channel holds."""
    steps = np.diff(np.unique(samples))
    # two readings of one value may differ by rounding where a factor was applied
    return float(np.min(steps[steps > 1e-9 * np.ptp(samples)], initial=np.ptp(samples)))


def fundamental_of_motion(record: Record, motion: SmoothMotion) -> Fundamental:
    """Give the equivalent linear spring and dashpot of a record, at the motion's mean frequency.

    Each period of it counts once, so that neighbouring samples don't pass for evidence of their own. A way at constant
    speed tells of no dashpot.
    """
    force = np.interp(motion.time, record.time_s - record.time_s[0], record.force_N)
    moving = np.stack([motion.y, motion.v])
    basis = moving - np.mean(moving, axis=1, keepdims=True)
    scale = np.std(moving, axis=1, keepdims=True)
    told = scale > STANDING_SHARE * np.max(np.abs(moving), axis=1, keepdims=True)
    basis = np.where(told, basis / np.where(told, scale, 1.0), 0.0)
    centred = force - np.mean(force)
    solution, *_ = np.linalg.lstsq(basis.T, centred, rcond=None)
    rest = float(np.std(centred - solution @ basis))
    amplitude = motion.amplitude
    per_mm = np.sqrt(2) / amplitude
    periods = max(motion.frequency * float(motion.time[-1]), 1.0)
    return Fundamental(
        amplitude, complex(solution[0] * per_mm, solution[1] * per_mm), rest * per_mm / math.sqrt(periods)
    )
