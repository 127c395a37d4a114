"""What is left when the best law is in: harmonics, place in the loop, conditions, locked to time or to motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeclamp.realise.arrays import Array
from pipeclamp_identification.campaign import Campaign
from pipeclamp_identification.loops import on_grid
from pipeclamp_identification.misfit import RunMisfit
from pipeclamp_identification.problem import Judged, Problem

POINTS = 360
STRONGEST = 3
LINE = 25.0
"""A spectral line counts when its power is this many times the median around it, in at least half of the runs."""
LINE_SHARE = 0.25
"""Lines together below this share of the noise (rms) are left unmentioned."""


@dataclass(frozen=True)
class Leftover:
    """A description of what a law leaves over.

    Attributes:
        words: sentences, most important first.
        phase: degrees of the cycle after the largest displacement, shape (n,).
        shape: rms over runs of the residual force along the cycle, N, shape (n,).
        time_locked_Hz: frequencies of lines that are the same in every run, whatever the drive's frequency.
    """

    words: tuple[str, ...]
    phase: Array
    shape: Array
    time_locked_Hz: tuple[float, ...]


def describe(judged: Judged, problem: Problem, campaign: Campaign, misfits: tuple[RunMisfit, ...]) -> Leftover:
    """Describe what a law leaves over.

    Args:
        judged: the law.
        problem: the data.
        campaign: the tests, for what isn't periodic in the records.
        misfits: the law's error on each sample.
    """
    residual = problem.harmonics.plain_residual(judged.result.response)
    residual = np.where(problem.harmonics.seen, residual, 0.0)
    loop = _along_cycle(residual)
    shape = np.sqrt(np.mean(loop**2, axis=0))
    phase = 360.0 * np.arange(POINTS) / POINTS
    lines = time_locked_lines(campaign, misfits)
    words = [_harmonic_words(judged), _place_words(shape, phase), *_condition_words(residual, problem)]
    if lines:
        named = ", ".join(f"{line:.2f} Hz" for line in lines)
        words.append(
            f"a force at {named} is there in most runs whatever the drive's frequency: locked to time, not motion"
        )
    return Leftover(tuple(words), phase, shape, lines)


def _along_cycle(residual: Array) -> Array:
    """Give residual harmonics as force along the cycle, shape (R, n)."""
    harmonics = np.zeros((len(residual), (residual.shape[1] + 1) // 2), dtype=np.complex128)
    harmonics[:, 0] = residual[:, 0]
    harmonics[:, 1:] = residual[:, 1::2] + 1j * residual[:, 2::2]
    return on_grid(harmonics, POINTS)


def _harmonic_words(judged: Judged) -> str:
    excess = np.maximum(judged.lack.by_channel, 0.0)
    order = np.argsort(-excess)[:STRONGEST]
    total = max(float(excess.sum()), 1e-300)
    parts = [
        f"{_channel(int(channel))} ({excess[channel] / total:.0%})"
        for channel in order
        if excess[channel] > 0.03 * total
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
        "at the turning points" if towards < 25 else "through the middle" if towards > 65 else "between end and middle"
    )
    return f"along the loop it is largest {place} ({branch}, {angle:.0f} deg after the largest displacement)"


def _condition_words(residual: Array, problem: Problem) -> list[str]:
    """Say with which conditions it grows: rank correlation of each run's residual with the conditions."""
    loops = problem.loops
    size = np.log(np.sqrt(np.sum(residual**2, axis=1)) + 1e-9)
    columns = {
        "A": loops.amplitude_mm, "f": loops.frequency_Hz, "T": loops.temperature_K, "density": loops.density_g_cm3,
        "cycle number": loops.cycle, **loops.conditions,
    }  # fmt: skip
    words = []
    for name, values in columns.items():
        if np.all(np.isfinite(values)) and np.ptp(values) > 0.02 * np.max(np.abs(values)):
            slope = float(np.corrcoef(_ranks(values), _ranks(size))[0, 1])
            if abs(slope) > 0.4:
                words.append(f"it {'grows' if slope > 0 else 'falls'} with {name} (rank correlation {slope:.2f})")
    return words


def _ranks(values: Array) -> Array:
    return np.argsort(np.argsort(values)).astype(float)


def time_locked_lines(campaign: Campaign, misfits: tuple[RunMisfit, ...]) -> tuple[float, ...]:
    """Find lines at one absolute frequency in what isn't periodic with the motion, in at least half of the runs."""
    found: list[float] = []
    power_in, power_all, resolution = 0.0, 0.0, []
    for run, misfit in zip(campaign.runs, misfits, strict=True):
        error = misfit.measured - misfit.computed
        time = run.record.time_s[run.cycles.steady]
        step = (time[-1] - time[0]) / (len(time) - 1)
        drive = run.cycles.frequency_Hz
        spectrum = np.abs(np.fft.rfft((error - error.mean()) * np.hanning(len(error)))) ** 2
        frequency = np.fft.rfftfreq(len(error), step)
        order = frequency / drive
        # What repeats with the motion is the law's own lack, not a line of its own.
        own = np.abs(order - np.round(order)) * drive < 2.5 / (len(error) * step)
        usable = ~own & (frequency > 2.0 / (len(error) * step))
        if np.count_nonzero(usable) < 20:
            continue
        median = float(np.median(spectrum[usable]))
        lines = usable & (spectrum > LINE * median)
        found += frequency[lines].tolist()
        power_in += float(spectrum[lines].sum())
        power_all += float(spectrum[usable].sum())
        resolution.append(1.0 / (len(error) * step))
    if not resolution or power_in < LINE_SHARE**2 * power_all:
        return ()
    width = 2.0 * float(np.max(resolution))
    return _common(found, width, 0.5 * len(resolution))


def _common(frequencies: list[float], width: float, least: float) -> tuple[float, ...]:
    """Give the centres of clusters of frequencies that come from at least so many runs."""
    lines, rest = [], np.sort(frequencies)
    while len(rest):
        cluster = rest[rest < rest[0] + width]
        if len(cluster) >= least:
            lines.append(float(np.mean(cluster)))
        rest = rest[len(cluster) :]
    return tuple(lines)
