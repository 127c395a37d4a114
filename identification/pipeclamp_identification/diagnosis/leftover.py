"""What is left when the best law is in: harmonics, place in the loop, conditions, locked to time or to motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.campaign.reading import Campaign
from pipeclamp_identification.diagnosis.problem import Judged, Problem
from pipeclamp_identification.diagnosis.run_scatter import Directions
from pipeclamp_identification.diagnosis.thresholds import HALVES_CHANCE, LINE_NOISE_RATIO, LINE_STANDARD_ERRORS
from pipeclamp_identification.fitting.misfit import RunMisfit
from pipeclamp_identification.loops.loops import Loops, on_grid
from pipeclamp_identification.signals.chances import of_all, of_larger_ratio, of_rank_correlation, rank_correlation
from pipeclamp_identification.signals.real_harmonics import as_complex
from pipeclamp_identification.signals.spectrum import hann_spectrum
from pipeclamp_models.base.arrays import Array, BoolArray
from pipeclamp_models.base.said import few_of

SAMPLES_PER_CYCLE = 360
"""Points along the cycle at which the leftover is drawn: one a degree."""
STRONGEST = 3
"""Parts of harmonics that are named, largest first."""
SMALLEST_NAMED = 0.03
"""Harmonics with less of the whole than this are left out of the words."""
END_DEG = 25.0
"""Nearer than this to a reversal, where |y| is above 0.9 A, is at the turning points; so much from y = 0 the middle."""
HELD_CONSTANT_SHARE = 0.02
"""Conditions that vary by less than this share are held constant: drives never hit their set points."""
WORTH_SAYING = 0.4
"""A weaker rank correlation is nothing that can be seen in a picture."""
TOLD_CHANCE = 0.01
"""Correlations that chance makes more often than this are not told."""
MOST_TRENDS = 2
"""Trends that are told: conditions that went together in the tests all show the same one."""
MOST_LINES_NAMED = 4
"""Lines that are named one by one."""
NEIGHBOURS = 30
"""Bins on either side of a line that say what noise makes there."""
NEAREST = 3
"""Bins nearer to a line than this hold some of the line itself."""
LOBE = 1.6
"""Half width of a line under a Hann window, in bins: there it is 18 dB below its top."""
FEWEST_NEIGHBOURS = 8
"""Bins on either side from which a line's neighbouring level is told."""
FEWEST_SHARE = 0.2
"""A line must be looked for in this share of the runs."""
HALVES = np.array([0.5, 1.5, 2.5])
"""Multiples of the drive's frequency, of which a force follows the motion, but not every cycle alike."""
FEWEST_CYCLES_BESIDE_HALVES = 4
"""Cycles from which on there are multiples of the record's length beside the halves."""
FEWEST_RUNS_WITH_LINES = 4
"""Runs that must have been looked at: a line of fewer may be one run's own."""
MOST_CYCLES, MOST_SAMPLES = 100, 100_000
"""Of a record, in which halves and lines are looked for: an hour's record would take more memory than there is."""


@dataclass(frozen=True)
class Leftover:
    """A description of what a law leaves over.

    Attributes:
        words: sentences on what repeats with each cycle, most important first.
        words_of_lines: sentences on what doesn't.
        phase: degrees of the cycle after the largest displacement, shape (n,).
        shape: rms over runs of the residual force along the cycle, N, shape (n,).
        time_locked_Hz: frequencies of lines that don't repeat with the motion.
        fractions: multiples of the drive's frequency, not whole, at which there are lines.
    """

    words: tuple[str, ...]
    words_of_lines: tuple[str, ...]
    phase: Array
    shape: Array
    time_locked_Hz: tuple[float, ...]
    fractions: tuple[float, ...]

    @property
    def not_periodic(self) -> bool:
        """Whether something is left that is neither scatter nor repeats with each cycle."""
        return bool(self.time_locked_Hz or self.fractions)


def describe(judged: Judged, problem: Problem, campaign: Campaign, misfits: tuple[RunMisfit, ...]) -> Leftover:
    """Describe what a law leaves over.

    Args:
        judged: the law.
        problem: the data.
        campaign: the tests, for what isn't periodic in the records.
        misfits: the law's error on each sample.
    """
    residual = problem.plain_residual(judged.result.law_force)
    residual = np.where(problem.harmonics.seen, residual, 0.0)
    loop = _along_cycle(residual)
    shape = np.sqrt(np.mean(loop**2, axis=0))
    phase = 360.0 * np.arange(SAMPLES_PER_CYCLE) / SAMPLES_PER_CYCLE
    # An average leaves noise with zeros of its own, beside which anything looks like a line.
    smoothed = bool(campaign.smoothing.force)
    lines = () if smoothed else time_locked_lines(campaign, misfits)
    fractions = () if smoothed else fractional_lines(campaign, misfits)
    found, varied = (_harmonic_words(judged), _place_words(shape, phase)), _varied(problem.loops)
    words = (*found, *_condition_words(residual, varied), *_trend_words(residual, varied, problem.noise.directions))
    of_lines = (*_time_locked_words(lines, problem.loops), *_fractional_words(fractions))
    return Leftover(words, of_lines, phase, shape, lines, fractions)


def _time_locked_words(lines: Sequence[float], loops: Loops) -> list[str]:
    """Say at which frequencies, Hz, lines don't repeat with the motion, and which runs' loops hold them."""
    if not lines:
        return []
    named = few_of([f"{line:.2f} Hz" for line in lines], MOST_LINES_NAMED)
    words = f"a force at {named} doesn't repeat with the motion: locked to time, or to several cycles"
    return [words, *harmonics_at(lines[:MOST_LINES_NAMED], loops)]


def _fractional_words(fractions: Sequence[float]) -> list[str]:
    """Say at which multiples of the drive's frequency, not whole, there are lines."""
    if not fractions:
        return []
    named = ", ".join(f"{fraction:.3g}" for fraction in fractions)
    return [f"a force at {named} times the drive's frequency: it follows the motion, but not every cycle alike"]


def harmonics_at(lines: Sequence[float], loops: Loops) -> list[str]:
    """Say of which runs a line that is locked to time is a harmonic, and so passes for a part of their loops.

    Args:
        lines: frequencies, Hz.
        loops: the tests.
    """
    f = loops.frequency_Hz
    width = f / np.maximum([len(cycles) for cycles in loops.cycles], 1)
    said = []
    for line in lines:
        order = np.rint(line / f)
        met = (order >= 1) & (order < loops.force.shape[1]) & (np.abs(order * f - line) < width)
        for one in np.unique(order[met]):
            at = f"{np.median(f[met & (order == one)]):.3g}"
            said.append(f"of the runs at {at} Hz it is harmonic {one:.0f}, and passes for a part of their loops")
    return said


def _along_cycle(residual: Array) -> Array:
    """Give residual harmonics as force along the cycle, shape (R, n)."""
    return on_grid(as_complex(residual), SAMPLES_PER_CYCLE)


def _harmonic_words(judged: Judged) -> str:
    excess = np.maximum(judged.lack.by_channel, 0.0)
    order = np.argsort(-excess)[:STRONGEST]
    total = max(float(excess.sum()), 1e-300)
    parts = [
        f"{_channel(int(channel))} ({excess[channel] / total:.0%})"
        for channel in order
        if excess[channel] > SMALLEST_NAMED * total
    ]
    return "most of it lies in " + ", ".join(parts) if parts else "it is spread over all harmonics"


def _channel(channel: int) -> str:
    if channel == 0:
        return "the mean force"
    order, part = (channel + 1) // 2, "in phase" if channel % 2 else "in quadrature"
    return f"harmonic {order} {part}"


def _place_words(shape: Array, phase: Array) -> str:
    """Say where along the loop it is largest: turning points, middle, loading or unloading."""
    angle = float(phase[int(np.argmax(shape))])
    towards = min(angle % 180.0, 180.0 - angle % 180.0)
    branch = "unloading from the positive end" if angle < 180.0 else "loading towards the positive end"
    place = (
        "at the turning points"
        if towards < END_DEG
        else "through the middle"
        if towards > 90 - END_DEG
        else "between end and middle"
    )
    return f"along the loop it is largest {place} ({branch}, {angle:.0f}° after the largest displacement)"


def _varied(loops: Loops) -> dict[str, Array]:
    """Give the conditions that are known of all runs and vary, by name, shape (R,) each."""
    columns = {
        "A": loops.amplitude_mm, "f": loops.frequency_Hz, "T": loops.temperature_K, "density": loops.density_g_cm3,
        "cycle number": loops.cycle, **loops.conditions,
    }  # fmt: skip
    return {
        name: values
        for name, values in columns.items()
        if np.all(np.isfinite(values)) and np.ptp(values) > HELD_CONSTANT_SHARE * np.max(np.abs(values))
    }


def _correlation(values: Array, of: Array) -> float:
    """Give the rank correlation of what is of runs with a condition; 0 where it isn't worth saying, or chance."""
    slope = rank_correlation(values, of)
    worth = abs(slope) > WORTH_SAYING and of_rank_correlation(slope, len(values)) < TOLD_CHANCE
    return slope if worth else 0.0


def _condition_words(residual: Array, varied: Mapping[str, Array]) -> list[str]:
    """Say with which conditions it grows: rank correlation of each run's residual with the conditions."""
    size = np.log(np.sqrt(np.sum(residual**2, axis=1)) + 1e-9)
    slopes = {name: _correlation(values, size) for name, values in varied.items()}
    return [
        f"it {'grows' if slope > 0 else 'falls'} with {name} (rank correlation {slope:.2f})"
        for name, slope in slopes.items()
        if slope
    ]


def _trend_words(residual: Array, varied: Mapping[str, Array], off: Directions) -> list[str]:
    """Say over which conditions stiffness and damping go another way than the law's, the clearest first.

    Where a law is too stiff at one end and too soft at the other, what is left is as large at both.
    """
    found: list[tuple[float, str]] = []
    for what, direction in (("stiffness", off.elastic), ("damping", off.damping)):
        squares = np.sum(direction**2, axis=1)
        if not np.all(squares > 0):
            continue
        share = np.sum(residual * direction, axis=1) / squares
        for name, values in varied.items():
            slope = _correlation(values, share)
            low, high = (
                float(np.median(share[end]))
                for end in (values <= np.quantile(values, 1 / 3), values >= np.quantile(values, 2 / 3))
            )
            if not slope or low * high >= 0:
                continue
            way = "rises" if slope > 0 else "falls"
            ends = f"{100 * low:+.2g}% in the lowest third of it, {100 * high:+.2g}% in the highest"
            words = f"its {what} {way} with {name} against the law's: {ends} (rank correlation {slope:.2f})"
            found.append((-abs(slope), words))
    return [words for _, words in sorted(found)[:MOST_TRENDS]]


def pooled_lines(campaign: Campaign, misfits: tuple[RunMisfit, ...], candidates: Array) -> tuple[float, ...]:
    """Find lines that stand out of their neighbouring spectrum in all runs together.

    Args:
        campaign: the tests.
        misfits: the law's error on each sample.
        candidates: where to look, Hz, shape (n,), rising.

    Returns:
        candidates whose power, over the local median and averaged over runs, is beyond what noise would make.
    """
    level = np.full((len(misfits), len(candidates)), np.nan)
    for row, (run, misfit) in enumerate(zip(campaign.runs, misfits, strict=True)):
        time = run.record.time_s[run.cycles.steady][:MOST_SAMPLES]
        length = time[-1] - time[0]
        error = (misfit.measured - misfit.computed)[:MOST_SAMPLES]
        spectrum = hann_spectrum(error) ** 2
        width = 1.0 / (length * (1 + 1 / (len(error) - 1)))
        drive = run.cycles.frequency_Hz
        place = candidates / width
        line = np.round(place).astype(np.intp)
        order = np.arange(len(spectrum)) * width / drive
        # What repeats with the motion is the law's own lack, not a line of its own.
        own = np.abs(order - np.round(order)) * drive < LOBE * width
        inside = (line >= 2) & (line < len(spectrum) - 2)
        over_noise = np.where(own, np.nan, spectrum / _backgrounds(spectrum, ~own))
        level[row, inside] = over_noise[line[inside]]
    seen = np.isfinite(level)
    count = seen.sum(axis=0)
    mean = np.where(seen, level, 0.0).sum(axis=0) / np.maximum(count, 1)
    looked_for = count >= max(FEWEST_RUNS_WITH_LINES, FEWEST_SHARE * len(misfits))
    middle = np.zeros(len(candidates))
    middle[looked_for] = np.nanmedian(level[:, looked_for], axis=0)
    beyond = (
        looked_for & (middle > LINE_NOISE_RATIO) & (mean > 1 + LINE_STANDARD_ERRORS / np.sqrt(np.maximum(count, 1)))
    )
    found = np.array([index for index in np.flatnonzero(beyond) if mean[index] == _largest_near(mean, int(index))], int)
    # Neighbouring candidates may share their lines in all runs.
    lines = np.split(found, np.flatnonzero(np.diff(found) > 1) + 1) if len(found) else []
    return tuple(float(np.mean(candidates[line])) for line in lines)


def _backgrounds(spectrum: Array, usable: BoolArray) -> Array:
    """Give the mean power that noise has at each line, from its neighbours on both sides; NaN where there are too few.

    Coloured noise falls with frequency: the geometric mean of the medians on either side follows the slope.
    """
    width = NEIGHBOURS - NEAREST + 1
    lines = np.where(usable, spectrum, np.nan)
    lines[0] = np.nan
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(lines, NEIGHBOURS, constant_values=np.nan), width)
    ordered = np.sort(windows, axis=1)
    count = np.sum(np.isfinite(ordered), axis=1)
    row = np.arange(len(ordered))
    medians = (ordered[row, np.maximum(count - 1, 0) // 2] + ordered[row, np.minimum(count // 2, width - 1)]) / 2
    medians[count < FEWEST_NEIGHBOURS] = np.nan
    below, above = medians[: len(spectrum)], medians[NEIGHBOURS + NEAREST :]
    return np.asarray(np.sqrt(below * above) / np.log(2))


def _largest_near(mean: Array, index: int) -> float:
    """Give the largest of the values within so many places: a line shows in its neighbours too."""
    return float(mean[max(index - NEIGHBOURS, 0) : index + NEIGHBOURS + 1].max())


def time_locked_lines(campaign: Campaign, misfits: tuple[RunMisfit, ...]) -> tuple[float, ...]:
    """Find lines at one absolute frequency, Hz, in all runs together: mains hum, say."""
    parts = (run.record.time_s[:MOST_SAMPLES] for run in campaign.runs)
    longest = max(float(part[-1] - part[0]) for part in parts)
    rate = min(len(run.record.time_s) / float(run.record.time_s[-1] - run.record.time_s[0]) for run in campaign.runs)
    slowest = min(run.cycles.frequency_Hz for run in campaign.runs)
    candidates = np.arange(2.5 * slowest, 0.45 * rate, 0.5 / longest)
    return pooled_lines(campaign, misfits, candidates)


def fractional_lines(campaign: Campaign, misfits: tuple[RunMisfit, ...]) -> tuple[float, ...]:
    """Find forces at halves of the drive's frequency, in all runs together: subharmonics of the motion.

    Over an even number of cycles the motion's own harmonics and halves are orthogonal to all other multiples of the
    record's length, whose power says what noise makes. Each half is held against those beside it in its own run, a few
    where cycles are few, and the runs' chances are put together by Fisher's method: a mean of such ratios would exceed
    one without any line, and the more surely the more runs there are.
    """
    chances = np.zeros((0, len(HALVES)))
    for run, misfit in zip(campaign.runs, misfits, strict=True):
        count = min(run.cycles.count, MOST_CYCLES) // 2 * 2
        if count < FEWEST_CYCLES_BESIDE_HALVES:
            continue
        samples = int(run.cycles.bounds[count] - run.cycles.bounds[0])
        error = (misfit.measured - misfit.computed)[:samples]
        phase = run.cycles.phase(run.record)[:samples]

        def power(orders: Array, error: Array = error, phase: Array = phase) -> Array:
            return np.asarray(np.abs(np.exp(-1j * np.outer(orders, phase)) @ error) ** 2)

        between = np.arange(1, count // 2) / count
        beside = np.array([power(np.concatenate([half - between, half + between])).mean() for half in HALVES])
        chances = np.vstack([chances, of_larger_ratio(power(HALVES) / beside, 2, 4 * len(between))])
    if len(chances) < FEWEST_RUNS_WITH_LINES:
        return ()
    together = of_all(chances)
    return tuple(float(half) for half, one in zip(HALVES, together, strict=True) if one < HALVES_CHANCE)
