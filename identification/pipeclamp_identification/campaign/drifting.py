"""Sensors that drift inside records: a zero or a gain that moves slowly.

A zero moves the mean and nothing else; a gain moves stiffness and damping in one ratio. What follows the motion, or
changes the loop, is the clamp's, and is left to the laws.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pipeclamp_identification.campaign.clipping import CHANNEL_COLUMNS
from pipeclamp_identification.campaign.cycles import Cycles
from pipeclamp_identification.campaign.drift_words import (
    built_up_words,
    gain_drift_words,
    zero_drift_words,
    zero_or_position_words,
)
from pipeclamp_identification.campaign.faults import Channel, Done, FaultKind, FaultyRun, SensorFault, runs_named
from pipeclamp_identification.campaign.plausibility import CycleByCycle
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.signals.between_cycles import between_cycles
from pipeclamp_identification.signals.orthonormal import orthonormal
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.digits import one_digit

FALSE_ALARM_CHANCE = 1e-3
"""A campaign without faults raises an alarm of a kind less often than this by scatter alone."""
ZERO_SHARE = 0.01
"""A zero that moves by less than this share of the amplitude, from first to last, does no harm: a cycle of five then
gains less than a thousandth of its amplitude in quadrature."""
GAIN_SHARE = 0.02
"""A gain that moves by less is within what clamps do in a test by themselves."""
POOLED_FREEDOMS = 4.0
"""The weight, in degrees of freedom, of the scatter of all runs as a first estimate of each run's own."""
GOES_ON_SHARE = 0.3
"""A drift goes on: its later half is this share of its earlier one at least. What dies away is the clamp's memory of
the test's beginning."""
FOLLOWED_SHARE = 0.3
"""A quantity that moves by less than this share of what another would make of it doesn't follow that."""
BY_ITSELF_SHARE = 0.5
"""A mean force has moved by itself where the mean position makes less than about half of its change: what positions do
is known roughly, by the loop's stiffness."""
MOTION_STAYS = 0.25
"""A motion that changes by less than this share of a gain's change stays: a stiffness that follows the amplitude would
have to follow it four times over to make that gain."""
SEEN_STANDARD_ERRORS = 4.0
"""Standard errors that something must be off zero to count as seen: by scatter alone six in a hundred thousand are."""
VARIED = 1.2
"""Largest over smallest amplitude from which on the force can show how it follows them."""
ALIKE_WITHIN = 0.25
"""Stiffness and damping change alike where their difference is known to this share of the change, and is none."""
ALIKE_SHARE = 0.1
"""Nor do they differ by more than this share of the change, or by what scatter makes of it: a gain that moves within a
cycle bends the loop a little."""
MEAN_OF_LOOP = 0.5
"""A loop that changes takes its mean along, by so much of its change where its halves are as unequal as clamps are."""
MEAN_OF_SPEED = 2.0
"""A motion that becomes faster takes the loop's mean along, by so much of the frequency's change at most: dampers that
differ by direction do, with the square of the velocity where a fluid is throttled."""
SAME_WAY, FEWEST_ALIKE = 0.9, 6
"""Runs drift together where this share of so many at least drifts one way."""
FEWEST_CYCLES_THAT_DRIFT = 3
OWN_SHARE = 0.2
"""Share of the order's own variance that the conditions must leave: a plan that was run in the order of its conditions
can't tell a drift from them."""
LEFT_OUT_SHARE = 0.5
"""If more than this share of the runs shows a falling gain, they are kept: nothing would be left to judge by."""


@dataclass(frozen=True)
class Change:
    """By how much a quantity changes from first to last, with its standard error and degrees of freedom."""

    size: float
    error: float
    freedoms: float

    def times(self, scale: float) -> Change:
        """Give it in another unit, of which a size of one is so much."""
        return Change(self.size * scale, self.error * scale, self.freedoms)

    def is_real(self, runs: int, least: float) -> bool:
        """Tell whether it is at least so large, and no chance among so many runs."""
        return abs(self.size) >= least and chance_of(self.size, self.error, self.freedoms) < FALSE_ALARM_CHANCE / runs

    @property
    def certain(self) -> float:
        """What it is at least, `SEEN_STANDARD_ERRORS` standard errors off; zero where that is nothing."""
        return max(abs(self.size) - SEEN_STANDARD_ERRORS * self.error, 0.0)


def chance_of(size: float, error: float, freedoms: float) -> float:
    """Give the chance that scatter alone makes a change of this size or more, two-sided.

    Student's distribution by Wallace's normal approximation (Ann. Math. Stat. 30, 1959): a few percent too large, a
    third with one freedom.
    """
    if error <= 0.0:
        return 0.0 if size else 1.0
    z = math.sqrt(freedoms * math.log1p((size / error) ** 2 / freedoms)) * (8 * freedoms + 1) / (8 * freedoms + 3)
    return math.erfc(z / math.sqrt(2))


@dataclass(frozen=True)
class Watched:
    """A run as it is watched for drifts.

    Attributes:
        name: the run's.
        start_s, end_s: when its record begins and ends, by its own clock.
        nominal_mm: stated amplitude, None where it isn't.
        conditions: the level of each condition, by name.
        by_cycle: mean and fundamental of each cycle.
    """

    name: str
    start_s: float
    end_s: float
    nominal_mm: float | None
    conditions: Mapping[str, str]
    by_cycle: CycleByCycle

    @cached_property
    def amplitudes(self) -> tuple[float, float]:
        """Of displacement and force, mm and N."""
        known = self.by_cycle
        return float(np.mean(np.abs(known.displacement[:, 1]))), float(np.mean(np.abs(known.force[:, 1])))


@dataclass(frozen=True)
class InRecord:
    """What changes inside a record, as shares: means over the amplitude, the others over their size."""

    mean_force: Change
    mean_displacement: Change
    elastic: Change
    damping: Change
    amplitude: Change
    force: Change
    stiffness_share: float
    """In-phase force over the force's amplitude: what of it follows the mean position."""
    loop: float
    """By how much the loop itself changes at least, as a share."""
    frequency: float
    """By how much the motion's frequency changes at least, as a share: little, unless it is a piece of a sweep."""
    goes_on: tuple[bool, bool]
    """Whether the drifts of mean force and mean displacement go on."""

    @property
    def force_of_position(self) -> float:
        """By how much the mean force would change if the clamp moved as the mean displacement does, as a share."""
        return abs(self.stiffness_share * self.mean_displacement.size)

    @property
    def force_shows_position(self) -> bool:
        """Whether that stands out of the scatter of the mean force."""
        return self.force_of_position > SEEN_STANDARD_ERRORS * self.mean_force.error


def drifting(runs: Sequence[Watched]) -> tuple[SensorFault, ...]:
    """Find the sensors that drift inside records; what was done says what `repaired` and the reader do."""
    found = _in_records(runs)
    return tuple(
        filter(
            None,
            (
                _fault(_force_zeros(found), "force", "zero_drift", "N", "corrected", runs),
                _fault(_displacement_zeros(found), "displacement", "zero_drift", "mm", "corrected", runs),
                _fault(_zeros_or_positions(found), "displacement", "zero_drift", "mm", "kept", runs),
                _fault(_force_gains(found), "force", "gain_drift", "share", "left out", runs),
                _fault(_displacement_gains(found, runs), "displacement", "gain_drift", "share", "left out", runs),
            ),
        )
    )


def _in_records(runs: Sequence[Watched]) -> dict[str, InRecord]:
    long = [run for run in runs if len(run.by_cycle.force) >= FEWEST_CYCLES_THAT_DRIFT]
    if not long:
        return {}
    series, units = [], []
    for run in long:
        A, F = run.amplitudes
        y, force, k = run.by_cycle.displacement, run.by_cycle.force, run.by_cycle.stiffness
        mean = np.mean(k)
        series.append(
            np.stack(
                [
                    force[:, 0].real / F,
                    y[:, 0].real / A,
                    k.real / (abs(mean.real) or 1.0),
                    k.imag / (abs(mean.imag) or 1.0),
                    np.abs(y[:, 1]) / A,
                    np.abs(force[:, 1]) / F,
                    # the fundamental's phase, about the frequency of all cycles, falls behind or runs ahead
                    1.0 + np.gradient(np.unwrap(np.angle(y[:, 1]))) / (2 * np.pi),
                ]
            )
        )
        units.append(np.array([F, A, abs(mean.real) * A, abs(mean.imag) * A, A, F, A]))
    changes = _changes(series, units)
    found = {}
    for row, run in enumerate(long):
        usual = complex(np.mean(run.by_cycle.stiffness))
        in_phase, in_quadrature = usual.real / abs(usual), usual.imag / abs(usual)
        mean_force, mean_displacement, elastic, damping, amplitude, size, frequency = changes[row]
        found[run.name] = InRecord(
            mean_force=mean_force,
            mean_displacement=mean_displacement,
            elastic=elastic,
            damping=damping,
            amplitude=amplitude,
            force=size,
            stiffness_share=in_phase,
            loop=math.hypot(in_phase * elastic.certain, in_quadrature * damping.certain),
            frequency=frequency.certain,
            goes_on=(_goes_on(series[row][0]), _goes_on(series[row][1])),
        )
    return found


def _lines(series: Array) -> tuple[Array, Array]:
    """Give the slopes of lines through rows of values, per step, and the sums of squares that they leave over."""
    along = np.arange(series.shape[1]) - (series.shape[1] - 1) / 2
    slopes = series @ along / (along @ along)
    rest = series - series.mean(axis=1, keepdims=True) - np.outer(slopes, along)
    return slopes, np.sum(rest**2, axis=1)


def _changes(runs: Sequence[Array], units: Sequence[Array]) -> list[list[Change]]:
    """Give the changes of each run's series, (series, cycles), from its first cycle to its last by lines.

    Their scatter is partly that of all runs together: as shares, or in N and mm where that makes more of it. A sensor's
    noise doesn't grow with the loop, so of a small one it is a larger share than of most.

    Args:
        runs: shares, as they follow from cycle to cycle.
        units: what a share of one is of each series in N or mm, shape (series,), of each run.
    """
    lines = [_lines(series) for series in runs]
    left = [rest / (series.shape[1] - 2) for series, (_, rest) in zip(runs, lines, strict=True)]
    of_share = np.median(left, axis=0)
    of_sensor = np.median([rest * unit**2 for rest, unit in zip(left, units, strict=True)], axis=0)
    shared = POOLED_FREEDOMS if len(runs) > 1 else 0.0
    changes = []
    for series, (slopes, rest), unit in zip(runs, lines, units, strict=True):
        pooled = np.maximum(of_share, of_sensor / np.where(unit > 0, unit, np.inf) ** 2)
        count = series.shape[1]
        freedoms = count - 2 + shared
        spread = count * (count**2 - 1) / 12
        errors = (count - 1) * np.sqrt((rest + shared * pooled) / freedoms / spread)
        sizes = slopes * (count - 1)
        changes.append(
            [Change(size, error, freedoms) for size, error in zip(sizes.tolist(), errors.tolist(), strict=True)]
        )
    return changes


def _goes_on(values: Array) -> bool:
    """Tell whether a drift goes on in the later half of its cycles as in the earlier one."""
    half = (len(values) + 1) // 2
    early, late = float(values[half - 1] - values[0]), float(values[-1] - values[-half])
    return late * early > 0 and abs(late) >= GOES_ON_SHARE * abs(early)


FoundChanges = dict[str, Change]


def _force_zeros(found: Mapping[str, InRecord]) -> FoundChanges:
    """Find mean forces that drift while position and loop stay."""
    every = _of_all([one.mean_force for one in found.values()])
    drifts = {}
    for run, one in found.items():
        followed = one.stiffness_share * one.mean_displacement.size
        size = abs(one.mean_force.size)
        of_motion = max(MEAN_OF_LOOP * one.loop, MEAN_OF_SPEED * one.frequency)
        alone = abs(one.mean_force.size - followed) > BY_ITSELF_SHARE * size and size > of_motion
        if alone and (every or (one.goes_on[0] and one.mean_force.is_real(len(found), ZERO_SHARE))):
            drifts[run] = one.mean_force
    return drifts


def _of_all(changes: Sequence[Change]) -> bool:
    """Tell whether next to all runs drift one way, by the scatter from run to run."""
    sizes = np.array([change.size for change in changes])
    if len(changes) < FEWEST_ALIKE or max(np.mean(sizes > 0), np.mean(sizes < 0)) < SAME_WAY:
        return False
    error = float(np.std(sizes, ddof=1)) / math.sqrt(len(sizes))
    return Change(float(np.mean(sizes)), error, len(sizes) - 1).is_real(1, ZERO_SHARE)


def _displacement_zeros(found: Mapping[str, InRecord]) -> FoundChanges:
    """Find mean displacements that drift while the force, which would show it, says that the clamp didn't move."""
    return {
        run: one.mean_displacement
        for run, one in _drifting_displacements(found).items()
        if one.force_shows_position and abs(one.mean_force.size) < FOLLOWED_SHARE * one.force_of_position
    }


def _zeros_or_positions(found: Mapping[str, InRecord]) -> FoundChanges:
    """Find mean displacements that drift where the force is too small to tell whether the clamp moved."""
    drifting = _drifting_displacements(found)
    return {run: one.mean_displacement for run, one in drifting.items() if not one.force_shows_position}


def _drifting_displacements(found: Mapping[str, InRecord]) -> dict[str, InRecord]:
    """Find the runs whose mean displacement drifts, whatever drifts it."""
    every = _of_all([one.mean_displacement for one in found.values()])
    return {
        run: one
        for run, one in found.items()
        if every or (one.goes_on[1] and one.mean_displacement.is_real(len(found), ZERO_SHARE))
    }


def _force_gains(found: Mapping[str, InRecord]) -> FoundChanges:
    """Find forces of which stiffness and damping change in one ratio, while the motion stays."""
    drifts = {}
    for run, one in found.items():
        both = (one.elastic, one.damping)
        mean = alike(*both)
        if mean is None or abs(mean.size) < GAIN_SHARE or one.amplitude.certain > MOTION_STAYS * abs(mean.size):
            continue
        if all(change.is_real(len(found), 0.0) for change in both):
            drifts[run] = mean
    return drifts


def alike(one: Change, other: Change) -> Change | None:
    """Give the mean of two changes; None unless they are known to be alike."""
    weights = np.array([one.error, other.error]) ** -2.0 if one.error and other.error else np.ones(2)
    size = float(weights @ [one.size, other.size] / weights.sum())
    doubt = math.hypot(one.error, other.error)
    if doubt > ALIKE_WITHIN * abs(size) or abs(one.size - other.size) > max(2 * doubt, ALIKE_SHARE * abs(size)):
        return None
    return Change(size, float(weights.sum() ** -0.5), min(one.freedoms, other.freedoms))


def _displacement_gains(found: Mapping[str, InRecord], runs: Sequence[Watched]) -> FoundChanges:
    """Find amplitudes that change without the force that such a change makes from run to run."""
    exponent = _force_over_amplitude(runs)
    drifts = {}
    for run, one in found.items():
        force = abs(exponent * one.amplitude.size)
        seen = force > SEEN_STANDARD_ERRORS * one.force.error and abs(one.force.size) < FOLLOWED_SHARE * force
        if one.amplitude.is_real(len(found), GAIN_SHARE) and seen:
            drifts[run] = one.amplitude
    return drifts


def _force_over_amplitude(runs: Sequence[Watched]) -> float:
    """Give the exponent with which the force grows with the amplitude from run to run; zero where none is seen."""
    A, F = np.log(np.array([run.amplitudes for run in runs])).T
    others = conditions_basis(runs, leave=("amplitude_mm",))
    own = A - others @ (others.T @ A)
    if np.sum(own**2) < OWN_SHARE * np.sum((A - A.mean()) ** 2) or np.ptp(A) < math.log(VARIED):
        return 0.0
    return float(own @ F / (own @ own))


def _fault(
    drifts: FoundChanges, channel: Channel, kind: FaultKind, unit: str, done: Done, runs: Sequence[Watched]
) -> SensorFault | None:
    """Put the runs that show a drift into one fault, sizes in its unit."""
    if not drifts:
        return None
    if done == "left out" and len(drifts) > LEFT_OUT_SHARE * len(runs):
        done = "kept"
    place = 0 if channel == "displacement" else 1
    scale = {run.name: run.amplitudes[place] if kind == "zero_drift" else 1.0 for run in runs}
    sizes = {run: change.times(scale[run]) for run, change in drifts.items()}
    worst = max(drifts, key=lambda run: abs(drifts[run].size))
    size, error = sizes[worst].size, sizes[worst].error
    others = "" if len(drifts) == 1 else f"; {len(drifts)} of {len(runs)} runs do ({runs_named(list(drifts))})"
    where = f"in run {worst}, from its first cycle to its last{others}"
    share = f"{abs(drifts[worst].size):.1%} of the amplitude"
    shown = f"by {size:+.3g} {unit} ({share}, standard error {one_digit(error)} {unit})"
    if kind == "gain_drift":
        words = gain_drift_words(channel, f"by {size:+.2%} (standard error {100 * error:.1g}%) {where}", done)
    elif done == "kept":
        words = zero_or_position_words(f"{shown} {where}")
    elif channel == "force" and _grows_with_amplitude(sizes, runs):
        words = built_up_words(f"{shown} {where}")
    else:
        words = zero_drift_words(channel, f"{shown} {where}")
    return SensorFault(
        channel=channel, fault=kind, over="record", size=size, unit=unit, done=done, words=words,
        runs=tuple(FaultyRun(run=run, size=one.size, standard_error=one.error) for run, one in sizes.items()),
    )  # fmt: skip


def _grows_with_amplitude(sizes: Mapping[str, Change], runs: Sequence[Watched]) -> bool:
    """Tell whether drifts grow with the amplitude of the motion, by a line through their logarithms."""
    amplitude = {run.name: run.amplitudes[0] for run in runs}
    y = np.log([abs(change.size) for change in sizes.values()])
    x = np.log([amplitude[run] for run in sizes])
    if len(x) < FEWEST_ALIKE or np.ptp(x) < math.log(VARIED):
        return False
    x, y = x - x.mean(), y - y.mean()
    slope = float(x @ y / (x @ x))
    error = math.sqrt(float(np.sum((y - slope * x) ** 2)) / (len(x) - 2) / float(x @ x))
    return slope > 0 and chance_of(slope, error, len(x) - 2) < FALSE_ALARM_CHANCE


def conditions_basis(runs: Sequence[Watched], leave: Sequence[str] = (), pairs: bool = False) -> Array:
    """Give an orthonormal basis of what conditions may do to runs: a constant each level of each, or of each pair."""
    columns = [np.ones(len(runs))]
    own = [[run.conditions[name] for run in runs] for name in runs[0].conditions if name not in leave]
    if pairs and len(own) > 1:
        own = [list(map("|".join, zip(*two, strict=True))) for two in itertools.combinations(own, 2)]
    for values in own:
        columns += [np.array([float(value == level) for value in values]) for level in sorted(set(values))[1:]]
    return orthonormal(np.stack(columns, axis=1))


def repaired(record: Record, cycles: Cycles, by_cycle: CycleByCycle, channels: Sequence[Channel]) -> Record:
    """Take the drift of the means off a record's channels; the mean over the steady cycles stays."""
    elapsed = cycles.frequency_Hz * (record.time_s - record.time_s[cycles.bounds[0]])
    # outside the steady cycles the line would run off
    within = np.clip(elapsed, 0.0, float(cycles.count))
    for channel in channels:
        means = (by_cycle.force if channel == "force" else by_cycle.displacement)[:, 0].real
        drift = between_cycles(means - np.mean(means), within)
        record = without(record, channel, drift)
    return record


def without(record: Record, channel: Channel, drift: Array | float) -> Record:
    """Give a record with a drift taken off one of its channels."""
    column = CHANNEL_COLUMNS[channel]
    return replace(record, **{column: getattr(record, column) - drift})
