"""Cycles: the fundamental of a record's displacement, its steady part, and where each cycle begins."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

import numpy as np

from pipeclamp_identification.campaign.records import Record, UnusableRecord
from pipeclamp_identification.signals.half_cycles import turning_points
from pipeclamp_identification.signals.harmonics import carried_harmonics, cycle_harmonics, evaluate, phasor_powers
from pipeclamp_identification.signals.sample_noise import sample_noise
from pipeclamp_identification.signals.spectrum import hann_spectrum
from pipeclamp_models.base.arrays import Array, ComplexArray, IntArray

RAMP = 0.02
"""Neighbouring cycles of a ramp differ by more than this share of the amplitude, in amplitude or in mean."""
STEADY_SHARE = 0.005
"""Neighbouring cycles of a steady drive may always differ by this."""
FRESH_TIMES, FRESH_SHARE = 4.0, 2e-3
"""A first cycle stands apart when the force changes after it this many times more than after any other, and by this
share of its amplitude at least."""
MISSING = 0.02
"""A cycle counts as full when no more than this of it, or one sample, is missing: the fit of harmonics bridges
that."""
DISTORTION = 5
"""Harmonics of the displacement that are told apart from its fundamental while the frequency is sought."""
RIDING_ORDER = 20
"""The highest order of small cycles that ride on a large one, which are part of the drive as its fundamental is."""
TRIFLE = 0.05
"""A share of a cycle that is none."""
TURN_BACK_SHARE = 0.1
"""A way back of less than this share of the whole one is no turn of a record that may be one cycle."""
LACKING = 1.25
"""What such a record may lack until it is where it began, in units of its longest step."""
SAME_VALUE = 4 * math.sqrt(2)
"""Times the rms of the noise within which two samples of it are the same value: 4 standard errors of their
difference."""
CLEAR_OF_NOISE = 20.0
"""Times the rms of its noise by which a motion that turns again and again is one."""
FEWEST_SAMPLES_PER_CYCLE = 8
"""The fewest samples per cycle with which a loop's shape is more than guesswork."""
SAMPLES_ENOUGH = 128
"""Samples per cycle with which amplitude, mean and a rough frequency are known well enough."""
SAMPLES_OF_MANY, MANY = 16, 20
"""And of many cycles, with which the sine is found that they are split by."""
WIDEST_GAP = 0.25
"""The widest gap in time, in cycles, across which the loop's shape is still known."""
LAID_OUT_TURN_SHARE = 0.004
"""A way back of less than this share of the whole one is no turn of a motion that is laid out over sines."""


@dataclass(frozen=True)
class Cycles:
    """The steady, whole cycles of a record.

    Cycle k holds the samples bounds[k] to bounds[k + 1] - 1; `before` is the number of cycles, a fraction too,
    from the record's first sample to the first steady one.
    """

    frequency_Hz: float
    bounds: IntArray
    before: float

    @property
    def count(self) -> int:
        """Return the number of whole cycles."""
        return len(self.bounds) - 1

    @property
    def steady(self) -> slice:
        """Return the samples of the whole cycles."""
        return slice(int(self.bounds[0]), int(self.bounds[-1]))

    def phase(self, record: Record) -> Array:
        """Return the phase 2 pi f t of the steady samples, 0 at the first of them.

        Args:
            record: the record that these cycles were found in.

        Returns:
            (samples,) rad.
        """
        time = record.time_s[self.steady]
        phase: Array = (2 * np.pi * self.frequency_Hz) * (time - time[0])
        return phase


def find_cycles(record: Record, *, timed: bool = True) -> Cycles:
    """Split a record into cycles by the phase of its displacement's fundamental.

    A ramp-in, a ramp-out and rest before the test are left aside: the steady part is the longest row of cycles
    of agreeing amplitude and mean, extended to the first and last sample that still follow it. A first cycle in which
    the force still remembers what was before is left aside too.

    Args:
        record: samples that `check_samples` has passed.
        timed: whether its time was measured. Where it wasn't, and the motion turns at equal times, these tell the
            frequency: a sine that is fitted to cycles of unlike amplitudes has another one, and means nothing.

    Returns:
        The whole cycles, counted from the first steady sample.

    Raises:
        UnusableRecord: less than one cycle, no vibration, or too few samples in a cycle.
    """
    time, y = record.time_s - record.time_s[0], record.displacement_mm
    duration = time[-1]
    interval = duration / max(len(time) - 1, 1)
    if duration <= 0.0 or len(time) < FEWEST_SAMPLES_PER_CYCLE:
        raise UnusableRecord(f"no full cycle: {len(time)} samples over {duration:g} s")
    if not timed and (told := _frequency_of_turns(time, y)) and (cycles := _cycles_of(time, record, told, interval)):
        return cycles
    frequency = _coarse_frequency(time, y, interval)
    _require_samples(time, y, frequency, interval)
    first, last, frequency, rest = _steady_sine(time, y, frequency, interval)
    _require_vibration(y, frequency, rest)
    if (first > 0 or last < len(time)) and len(_bounds(time[first:last], frequency, interval)) > 2:
        # a ramp draws the coarse frequency away: its cycles don't close, and what follows them so roughly may be ramp
        first, last, frequency, _ = _steady_sine(time, y, frequency, interval)
    if first > 0:
        first += _over(time[first:last], frequency, interval)
    bounds = first + _bounds(time[first:last], frequency, interval)
    fresh = False
    if len(bounds) > 2:
        displacement, force = _few_harmonics(time, [y, record.force_N], bounds, frequency)
        fresh = _starts_fresh(force)
        frequency += _frequency_correction(displacement, frequency)
        bounds = first + _bounds(time[first:last], frequency, interval)
    if len(bounds) < 2 and (closing := _closing_frequency(time, y, record.force_N)):
        frequency, first, last = closing, 0, len(time)
        bounds = _bounds(time, frequency, interval)
        if len(bounds) < 2:  # it lacks its last step, which may be longer than others
            bounds = np.array([0, len(time)], dtype=np.intp)
    if len(bounds) < 2 and len(_turns(y)) < 3:
        raise UnusableRecord(f"no full cycle: it goes from {y[0]:.4g} to {y[-1]:.4g} mm and never turns back")
    if len(bounds) < 2:
        held = frequency * (time[last - 1] - time[first] + interval)
        if held < TRIFLE:
            raise UnusableRecord("no full cycle: no part of it follows a sine")
        raise UnusableRecord(f"no full cycle: {held:.2f} of one at {frequency:.4g} Hz is steady")
    if fresh:
        bounds = bounds[1:]
    return Cycles(frequency, bounds, before=float(frequency * time[bounds[0]]))


def _cycles_of(time: Array, record: Record, frequency: float, interval: float) -> Cycles | None:
    """Give the steady cycles of a record whose frequency is known; None where there is none."""
    first, last = _steady_samples(time, record.displacement_mm, frequency, interval)
    if first > 0:
        first += _over(time[first:last], frequency, interval)
    bounds = first + _bounds(time[first:last], frequency, interval)
    if len(bounds) < 2:
        return None
    if len(bounds) > 2 and _starts_fresh(_few_harmonics(time, [record.force_N], bounds, frequency)[0]):
        bounds = bounds[1:]
    return Cycles(frequency, bounds, before=float(frequency * time[bounds[0]]))


def _frequency_of_turns(time: Array, y: Array) -> float | None:
    """Give the frequency of a motion that turns at equal times, as one does that is laid out over sines; else None."""
    turns = time[turning_points(y, np.full(len(y), LAID_OUT_TURN_SHARE * float(np.ptp(y))))]
    # where there is but one within, its ends are turns too
    turns = turns[1:-1] if len(turns) > 3 else turns
    halves = np.diff(turns)
    if len(halves) < 1 or np.ptp(halves) > np.max(np.diff(time)):
        return None
    return float(0.5 * len(halves) / (turns[-1] - turns[0]))


def _turns(y: Array) -> IntArray:
    """Give the samples at which a motion turns by more than a trifle, its two ends included."""
    return turning_points(y, np.full(len(y), TURN_BACK_SHARE * float(np.ptp(y))))


def _closing_frequency(time: Array, y: Array, force: Array) -> float | None:
    """Give the frequency of a record that is one cycle from end to end, None where it isn't.

    The best sine of one triangle, there and back, has another frequency, by which a part of the cycle would be missing.
    A cycle that was cut out by a counter lacks its last step, and ends on its way there. One that a machine caught
    among thousands may be back within the noise of both channels alone: so closely that noise hides whether its last
    sample repeats the first or stands a step before it.
    """
    size = float(np.ptp(y))
    turns = _turns(y)
    if len(turns) - 2 > 2:
        return None
    if abs(y[-1] - y[0]) <= STEADY_SHARE * size:
        return float(1.0 / time[-1])
    if _comes_back(y) and _comes_back(force):
        return float(1.0 / (time[-1] * (1 + 0.5 / (len(time) - 1))))
    if not lacks_a_step(y):
        return None
    return float(1.0 / (time[-1] + (y[0] - y[-1]) / (y[-1] - y[-2]) * (time[-1] - time[-2])))


def _comes_back(values: Array) -> bool:
    """Tell whether a channel ends where it began, within its noise, and not far off."""
    size = float(np.ptp(values))
    return bool(
        abs(values[-1] - values[0])
        <= min(TURN_BACK_SHARE * size, max(STEADY_SHARE * size, SAME_VALUE * sample_noise(values)))
    )


def lacks_a_step(y: Array) -> bool:
    """Tell whether a motion ends on its way to where it began, a step before it."""
    last, lacking = y[-1] - y[-2], y[0] - y[-1]
    goes_on = last * (y[1] - y[0]) > 0 and last * lacking > 0
    return bool(goes_on and abs(lacking) <= LACKING * np.max(np.abs(np.diff(y))))


def _require_samples(time: Array, y: Array, frequency: float, interval: float) -> None:
    if frequency * interval * FEWEST_SAMPLES_PER_CYCLE > 1.0:
        # the strongest line of noise lies anywhere
        _require_vibration(y, *_fitted_sine(time, y, frequency))
        raise UnusableRecord(
            f"too few samples: {1.0 / (frequency * interval):.1f} per cycle at {frequency:.4g} Hz; "
            f"expected at least {FEWEST_SAMPLES_PER_CYCLE}"
        )
    gap = np.diff(time)
    widest = int(np.argmax(gap))
    if frequency * gap[widest] > WIDEST_GAP:
        raise UnusableRecord(
            f"a gap of {gap[widest]:g} s in time in row {widest + 3}: {frequency * gap[widest]:.2f} of a cycle at "
            f"{frequency:.4g} Hz; expected at most {WIDEST_GAP}"
        )


def _require_vibration(y: Array, frequency: float, rest: float) -> None:
    """Refuse a displacement that is nothing but noise or drift, in which some fundamental is always found."""
    if rest > 0.5:
        size = float(np.ptp(y))
        turns = _turns(y)
        wanders = size > CLEAR_OF_NOISE * sample_noise(y) and len(turns) > 4
        what = "no sine in it" if wanders else "constant displacement but for noise or drift"
        raise UnusableRecord(
            f"{what}: it stays within {size:.3g} mm, and of the sine of "
            f"{frequency:.4g} Hz that fits it best {100 * rest:.0f}% of the amplitude is left over"
        )


def _starts_fresh(force: ComplexArray) -> bool:
    """Tell by the force's harmonics of each cycle whether the specimen had not been through a whole one before.

    Friction starts on its virgin curve, though the displacement may be steady from the first sample on. That cycle
    stands apart from the next as no two later ones do; with a drift, which is the clamp's own, all differ alike.
    """
    if len(force) < 3:
        return False
    change = np.linalg.norm(np.diff(force, axis=0), axis=1)
    size = float(np.max(np.abs(force[:, 1])))
    return bool(change[0] > FRESH_TIMES * np.max(change[1:]) and change[0] > FRESH_SHARE * size)


def _coarse_frequency(time: Array, y: Array, interval: float) -> float:
    """Find the strongest line of the spectrum, or, where only a few cycles are there, the sine that fits best."""
    if np.max(np.diff(time)) < 1.5 * interval:
        samples, step = y, time[-1] / (len(time) - 1)
    else:
        grid = np.linspace(0.0, time[-1], len(time))
        samples, step = np.interp(grid, time, y), float(grid[1])
    count = len(samples)
    level = hann_spectrum(samples)
    peak = int(np.argmax(level[1:])) + 1
    if peak < 4:
        return _best_sine(time, y)
    if peak == len(level) - 1:
        return float(peak / (count * step))
    # a Hann window's line is near enough a parabola in the logarithm
    left, top, right = np.log(np.maximum(level[peak - 1 : peak + 2], level[peak] * 1e-9))
    offset = (left - right) / (2 * (left - 2 * top + right)) if left + right < 2 * top else 0.0
    return float((peak + offset) / (count * step))


def _best_sine(time: Array, y: Array) -> float:
    """Scan for the frequency whose sine plus constant fits best: a spectrum can't resolve so few cycles."""
    some = np.unique(np.linspace(0, len(time) - 1, 256).astype(np.intp))
    candidates = np.arange(0.2, 5.0, 0.05) / time[-1]
    phase = 2 * np.pi * candidates[:, None] * time[some]
    basis = np.stack([np.ones_like(phase), np.cos(phase), np.sin(phase)], axis=-1)
    transposed = np.swapaxes(basis, 1, 2)
    gram = transposed @ basis
    # a trace of a ridge, as in `_least_squares`: samples far apart may all lie on a few phases
    gram[:, range(3), range(3)] += 1e-13 * np.trace(gram, axis1=1, axis2=2)[:, None]
    solution = np.linalg.solve(gram, transposed @ y[some, None])
    error = np.sum((basis @ solution - y[some, None]) ** 2, axis=(1, 2))
    return float(candidates[np.argmin(error)])


def _bounds(time: Array, frequency: float, interval: float) -> IntArray:
    """Return where the whole cycles begin, the first at the first sample, and where the last one ends."""
    elapsed = frequency * (time - time[0])
    coverage = elapsed[-1] + frequency * interval
    whole = int(np.floor(coverage + max(MISSING, frequency * interval)))
    # rounding must not push a sample that lies on a boundary into the cycle before
    edges = np.arange(whole + 1) - 1e-9
    return np.searchsorted(elapsed, edges)


def _over(time: Array, frequency: float, interval: float) -> int:
    """Return how many of steady samples are over, where whole cycles end with the last of them.

    After a ramp these go: the displacement may be steady, and the force still remembers how it came to be.
    """
    whole = len(_bounds(time, frequency, interval)) - 1
    over = float(time[-1] - time[0]) + interval - whole / frequency
    return int(np.searchsorted(time, time[0] + over - 1e-9 / frequency)) if whole and over > 0 else 0


def _steady_sine(time: Array, y: Array, frequency: float, interval: float) -> tuple[int, int, float, float]:
    """Return the first steady sample, the one after the last, their frequency and what its sine leaves of them.

    What is coarse needs few samples; the frequency's last digits and the loops take all of them.
    """
    stride = max(1, int(1.0 / (SAMPLES_ENOUGH * frequency * interval)))
    first, last = _steady_samples(time[::stride], y[::stride], frequency, interval * stride)
    first, last = first * stride, min(last * stride, len(time))
    if frequency * (time[last - 1] - time[first]) > MANY:
        stride = max(1, int(1.0 / (SAMPLES_OF_MANY * frequency * interval)))
    return first, last, *_fitted_sine(time[first:last:stride], y[first:last:stride], frequency)


def _steady_samples(time: Array, y: Array, frequency: float, interval: float) -> tuple[int, int]:
    """Return the first steady sample and the one after the last."""
    bounds = _bounds(time, frequency, interval)
    if len(bounds) < 3:
        return 0, len(time)
    phase = 2 * np.pi * frequency * time
    harmonics = cycle_harmonics(phase[: bounds[-1]], bounds, [y[: bounds[-1]]], 1)[0]
    amplitude, mean = np.abs(harmonics[:, 1]), harmonics[:, 0].real
    change = np.maximum(np.abs(np.diff(amplitude)), np.abs(np.diff(mean))) / np.max(amplitude)
    # what most cycles do is this drive's own scatter
    agree = change <= min(max(4 * median(change.tolist()), STEADY_SHARE), RAMP)
    rows = np.split(np.arange(len(amplitude)), np.flatnonzero(~agree) + 1)
    # rest before the test is steady too, but has no amplitude
    rows = [row for row in rows if np.max(amplitude[row]) > np.max(amplitude) / 2]
    row = max(rows, key=lambda cycles: (len(cycles), np.mean(amplitude[cycles])))
    first, last = int(bounds[row[0]]), int(bounds[row[-1] + 1])
    if first > 0:
        head = slice(first, int(bounds[row[0] + 1]))
        first -= _samples_that_follow(time, y, frequency, head, slice(int(bounds[row[0] - 1]), first), backwards=True)
    if last < len(time):
        tail = slice(int(bounds[row[-1]]), last)
        end = int(np.searchsorted(time, time[last - 1] + 1.0 / frequency))
        last += _samples_that_follow(time, y, frequency, tail, slice(last, end), backwards=False)
    return first, last


def _samples_that_follow(
    time: Array, y: Array, frequency: float, cycle: slice, beyond: slice, *, backwards: bool
) -> int:
    """Count the samples next to a steady cycle that repeat it, before the first that doesn't."""
    phase = 2 * np.pi * frequency * time[cycle]
    whole = np.array([0, len(phase)])
    harmonics = cycle_harmonics(phase, whole, [y[cycle]], min(RIDING_ORDER, carried_harmonics(phase, whole)))[0, 0]
    tones = np.flatnonzero(np.abs(harmonics) > RAMP * abs(harmonics[1]))
    harmonics = harmonics[: int(np.max(tones, initial=DISTORTION)) + 1]
    noise = np.std(y[cycle] - evaluate(harmonics, phase))
    off = np.abs(y[beyond] - evaluate(harmonics, 2 * np.pi * frequency * time[beyond]))
    strays = np.flatnonzero((off[::-1] if backwards else off) > RAMP * abs(harmonics[1]) + 6 * noise)
    return int(strays[0]) if len(strays) else len(off)


def _fitted_sine(time: Array, y: Array, frequency: float) -> tuple[float, float]:
    """Fit mean, a few harmonics and the frequency at once by Gauss-Newton: works for any number of cycles.

    Returns:
        the frequency, and the rms of what the fundamental leaves over as a share of its amplitude.
    """
    t = time - (time[0] + time[-1]) / 2
    duration = float(t[-1] - t[0])
    # little more than one cycle can't tell a wrong frequency from harmonics
    order = np.arange(1, 1 + (DISTORTION if frequency * duration > 1.2 else 1))
    for _ in range(20):
        powers = phasor_powers(2 * np.pi * frequency * t, len(order))
        basis = np.vstack([np.ones_like(t), powers.real, powers.imag])
        solution = _least_squares(basis, y)
        cosines, sines = solution[1 : len(order) + 1], solution[len(order) + 1 :]
        slope = np.concatenate([[0.0], order * sines, -order * cosines]) @ basis
        step = float(_least_squares(np.vstack([basis, 2 * np.pi * t * slope]), y)[-1])
        frequency += float(np.clip(step, -0.2 / duration, 0.2 / duration))
        # convergence is quadratic: what is left is the square of this
        if abs(step) * duration < 1e-4:
            break
    amplitude = math.hypot(cosines[0], sines[0])
    rest = math.sqrt(max(float(np.var(y)) - amplitude**2 / 2, 0.0))
    return max(frequency, 1e-3 / duration), rest / amplitude if amplitude > 0.0 else math.inf


def _least_squares(basis: Array, y: Array) -> Array:
    """Solve by the normal equations: the harmonics of whole cycles are nearly orthogonal.

    A trace of a ridge lets a record that is no vibration at all pass here, to be told so by what it leaves over.
    """
    gram = basis @ basis.T
    gram.flat[:: len(gram) + 1] += 1e-13 * np.trace(gram)
    return np.asarray(np.linalg.solve(gram, basis @ y), dtype=np.float64)


def _frequency_correction(displacement: ComplexArray, frequency: float) -> float:
    """Return by how much the frequency errs, from the slope of the fundamental's phase over the cycles."""
    lag = np.unwrap(np.angle(displacement[:, 1]))
    cycles = np.arange(len(lag)) - (len(lag) - 1) / 2
    return float(frequency * (cycles @ lag) / (cycles @ cycles) / (2 * np.pi))


def _few_harmonics(time: Array, channels: Sequence[Array], bounds: IntArray, frequency: float) -> ComplexArray:
    """Return the lowest harmonics, (channels, cycles, count + 1), of each cycle."""
    steady = slice(bounds[0], bounds[-1])
    phase = 2 * np.pi * frequency * (time[steady] - time[bounds[0]])
    whole: IntArray = bounds - bounds[0]
    count = min(DISTORTION, carried_harmonics(phase, whole))
    return cycle_harmonics(phase, whole, [samples[steady] for samples in channels], count)
