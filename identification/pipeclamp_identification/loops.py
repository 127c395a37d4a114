"""Loops: each run as the harmonics of its displacement and force, averaged over cycles, with their scatter.

Harmonics carry the whole loop in few numbers, tell what is periodic from what is noise, and give velocity and
acceleration by multiplication with i n omega, which delays nothing against the force.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from pipeclamp.symbols import CELSIUS
from pipeclamp_identification.campaign import Campaign, Run
from pipeclamp_identification.harmonics import (
    Array,
    ComplexArray,
    IntArray,
    carried_harmonics,
    cycle_harmonics,
    evaluate,
    unit_phasor,
)
from pipeclamp_identification.reversals import Bridged, bridged
from pipeclamp_identification.smoothing import gain

HARMONICS = 20

# a harmonic of the displacement below this many standard errors is taken for noise
SIGNIFICANT = 3.0
# the weight, in degrees of freedom, of the noise level as a first estimate of each harmonic's own scatter: keeps
# five cycles that agree by chance from weighing far too much
NOISE_FREEDOMS = 4.0
# no force is known better than this share of its rms, whatever a noise-free record says; much less, and what aliases
# into the harmonics of a noise-free record would count as evidence
FINEST_SHARE = 1e-5
# deviations beyond this many robust standard deviations are jumps of the loop itself
JUMP = 6.0
# parts of the cycle, of equal phase, over which the scatter is told
PHASE_BINS = 24
# a harmonic drifts when scatter alone would make so steady a change from cycle to cycle less often than this
DRIFT_BY_CHANCE = 1e-4


LEAST_GAIN = 0.3
"""Harmonics of the displacement of which a moving average left less than this are lost."""


@dataclass(frozen=True)
class Loops:
    """The loops of a campaign, one row per run (or, from `per_cycle`, one per run and cycle); R rows, H harmonics.

    x(theta) = Re sum X_n exp(i n theta) with theta = 2 pi f t + phase such that displacement[:, 1] = A is real and
    positive, so that the real parts of the force are in phase with the displacement. X_0 is the mean.
    Unknown temperature, density and conditions are nan. A harmonic that a run's sampling can't carry is zero with an
    infinite standard error.
    """

    run: tuple[str, ...]
    specimen: tuple[str | None, ...]
    cycle: Array
    """(R,) load cycles that the specimen had seen at the middle of the row."""
    amplitude_mm: Array
    frequency_Hz: Array
    temperature_K: Array
    density_g_cm3: Array
    conditions: Mapping[str, Array]
    displacement: ComplexArray
    """(R, H + 1) mm; harmonics that are not significant are zero."""
    force: ComplexArray
    """(R, H + 1) N."""
    force_standard_error: Array
    """(R, H + 1) N, of the real and of the imaginary part each."""
    noise_rms_N: Array
    """(R,) rms of what is not periodic in the force."""
    scatter_rms_N: Array
    """(R,) rms of what of it doesn't drift from cycle to cycle either: no law can explain it."""
    scatter_by_phase: Array
    """(R, PHASE_BINS) share of its power that lies in each part of the cycle, from the largest displacement on."""
    force_rms_N: Array
    """(R,) rms of the force over the steady samples."""
    samples: Array
    """(R,) number of steady samples."""
    cycles: tuple[Array, ...]
    """R arrays (cycles,): load cycles seen at the middle of each cycle."""
    displacement_per_cycle: tuple[ComplexArray, ...]
    """R arrays (cycles, H + 1) mm, each cycle turned so that its own fundamental is real."""
    force_per_cycle: tuple[ComplexArray, ...]
    """R arrays (cycles, H + 1) N, turned likewise."""
    phases: tuple[Array, ...] = ()
    """R arrays (samples,) rad: where in the cycle each steady sample lies, in the order of time."""
    at_reversals: tuple[Bridged, ...] = ()
    """R entries: the samples at reversals, which stand for the mean over their interval."""
    force_average: float = 0.0
    """Share of the period over which the force was averaged before it was recorded."""

    @property
    def show_scatter(self) -> tuple[bool, ...]:
        """Return for each row whether it has cycles to scatter: one alone shows the noise between its samples only."""
        return tuple(len(cycles) > 1 for cycles in self.cycles)

    @property
    def noise_nrmse(self) -> float:
        """Return the part of the force, over all samples, that is not periodic: no law can explain it."""
        noise = np.sum(self.samples * self.noise_rms_N**2)
        return math.sqrt(noise / np.sum(self.samples * self.force_rms_N**2))


@dataclass(frozen=True)
class _RunLoop:
    cycles: Array
    displacement: ComplexArray
    force: ComplexArray
    displacement_per_cycle: ComplexArray
    force_per_cycle: ComplexArray
    force_standard_error: Array
    noise_rms_N: float
    scatter_rms_N: float
    scatter_by_phase: Array
    force_rms_N: float
    samples: int
    phase: Array
    at_reversals: Bridged


def loops_of(campaign: Campaign, harmonics: int = HARMONICS) -> Loops:
    """Turn a campaign's records into loops.

    Args:
        campaign: as `read_campaign` returns it.
        harmonics: H, the highest harmonic to keep.

    Returns:
        One row per usable run, in the campaign's order.
    """
    loops = [_run_loop(run, harmonics, campaign.smoothing.displacement) for run in campaign.runs]
    runs = campaign.runs
    displacement = np.stack([loop.displacement for loop in loops])
    return Loops(
        run=tuple(run.name for run in runs),
        specimen=tuple(run.specimen for run in runs),
        cycle=np.array([np.mean(loop.cycles) for loop in loops]),
        amplitude_mm=displacement[:, 1].real.copy(),
        frequency_Hz=np.array([run.cycles.frequency_Hz for run in runs]),
        temperature_K=np.array([_kelvin(run) for run in runs]),
        density_g_cm3=np.array([math.nan if run.density_g_cm3 is None else run.density_g_cm3 for run in runs]),
        conditions=MappingProxyType(
            {name: np.array([run.conditions[name] for run in runs]) for name in campaign.condition_columns}
        ),
        displacement=displacement,
        force=np.stack([loop.force for loop in loops]),
        force_standard_error=np.stack([loop.force_standard_error for loop in loops]),
        noise_rms_N=np.array([loop.noise_rms_N for loop in loops]),
        scatter_rms_N=np.array([loop.scatter_rms_N for loop in loops]),
        scatter_by_phase=np.array([loop.scatter_by_phase for loop in loops]),
        force_rms_N=np.array([loop.force_rms_N for loop in loops]),
        samples=np.array([float(loop.samples) for loop in loops]),
        cycles=tuple(loop.cycles for loop in loops),
        displacement_per_cycle=tuple(loop.displacement_per_cycle for loop in loops),
        force_per_cycle=tuple(loop.force_per_cycle for loop in loops),
        phases=tuple(loop.phase for loop in loops),
        at_reversals=tuple(loop.at_reversals for loop in loops),
        force_average=campaign.smoothing.force,
    )


def per_cycle(loops: Loops) -> Loops:
    """Return loops with one row per run and cycle, for effects that change from cycle to cycle.

    Args:
        loops: one row per run.

    Returns:
        One row per cycle, the runs' cycles one after another; standard errors are those of a single cycle.
    """
    counts = np.array([len(cycles) for cycles in loops.cycles])
    row = np.repeat(np.arange(len(counts)), counts)
    kept = loops.displacement != 0
    displacement = np.concatenate(loops.displacement_per_cycle) * kept[row]
    starts = [_starts(phase) for phase in loops.phases]
    return Loops(
        run=tuple(loops.run[r] for r in row),
        specimen=tuple(loops.specimen[r] for r in row),
        cycle=np.concatenate(loops.cycles),
        amplitude_mm=displacement[:, 1].real.copy(),
        frequency_Hz=loops.frequency_Hz[row],
        temperature_K=loops.temperature_K[row],
        density_g_cm3=loops.density_g_cm3[row],
        conditions=MappingProxyType({name: values[row] for name, values in loops.conditions.items()}),
        displacement=displacement,
        force=np.concatenate(loops.force_per_cycle),
        force_standard_error=loops.force_standard_error[row] * np.sqrt(counts)[row, None],
        noise_rms_N=loops.noise_rms_N[row],
        scatter_rms_N=loops.scatter_rms_N[row],
        scatter_by_phase=loops.scatter_by_phase[row],
        force_rms_N=loops.force_rms_N[row],
        samples=(loops.samples / counts)[row],
        cycles=tuple(np.concatenate(loops.cycles)[:, None]),
        displacement_per_cycle=tuple(displacement[:, None, :]),
        force_per_cycle=tuple(np.concatenate(loops.force_per_cycle)[:, None, :]),
        phases=tuple(
            part for phase, own in zip(loops.phases, starts, strict=True) for part in np.split(phase, own[1:])
        ),
        at_reversals=tuple(
            at.within(first, last)
            for at, phase, own in zip(loops.at_reversals, loops.phases, starts, strict=True)
            for first, last in itertools.pairwise([*own, len(phase)])
        ),
        force_average=loops.force_average,
    )


def _starts(phase: Array) -> IntArray:
    """Return where each cycle begins: the phase within the cycle falls back there."""
    return np.concatenate([[0], np.flatnonzero(np.diff(phase) < -np.pi) + 1])


def on_grid(harmonics: ComplexArray, count: int, derivative: int = 0) -> Array:
    """Return x, or its derivative by theta, at theta_j = 2 pi j/count.

    Args:
        harmonics: (R, H + 1).
        count: number of grid points.
        derivative: how often to differentiate by theta.

    Returns:
        (R, count) in the harmonics' unit per rad^derivative.
    """
    order = np.arange(harmonics.shape[1])
    phasors = np.exp(2j * np.pi * (np.outer(order, np.arange(count)) % count) / count)
    return np.asarray(((harmonics * (1j * order) ** derivative) @ phasors).real)


def displacement_on_grid(loops: Loops, count: int) -> tuple[Array, Array, Array]:
    """Return displacement, velocity and acceleration over one cycle.

    Args:
        loops: R rows.
        count: number of points theta_j = 2 pi j/count.

    Returns:
        y (R, count) mm, v (R, count) mm/s, a (R, count) mm/s2.
    """
    speed = 2 * np.pi * loops.frequency_Hz[:, None]
    y, slope, curvature = (on_grid(loops.displacement, count, derivative) for derivative in range(3))
    return y, speed * slope, speed**2 * curvature


def _kelvin(run: Run) -> float:
    """Return the temperature that the record measured, or else the one of runs.csv, or nan."""
    measured = run.record.temperature_C
    if measured is not None:
        steady = measured[run.cycles.steady]
        known = steady[np.isfinite(steady)]
        if len(known):
            return float(np.mean(known)) + CELSIUS
    return math.nan if run.temperature_C is None else run.temperature_C + CELSIUS


def _run_loop(run: Run, harmonics: int, average: float) -> _RunLoop:
    record, cycles = run.record, run.cycles
    y, force = record.displacement_mm[cycles.steady], record.force_N[cycles.steady]
    phase = cycles.phase(record)
    bounds = cycles.bounds - cycles.bounds[0]
    count = min(harmonics, carried_harmonics(phase, bounds))
    fitted = cycle_harmonics(phase, bounds, [y, force], count)
    # each cycle has its own phase: a drive that wanders in phase doesn't smear the mean loop
    lag = np.angle(fitted[0, :, 1])
    fitted *= np.exp(-1j * lag[:, None] * np.arange(count + 1))
    # the clamp saw the displacement before it was averaged; what an average leaves little of isn't brought back
    left = gain(average, np.arange(count + 1))
    fitted[0] *= np.where(left > LEAST_GAIN, 1 / np.maximum(left, LEAST_GAIN), 0.0)
    own_phase = phase + np.repeat(lag - 2 * np.pi * np.arange(cycles.count), np.diff(bounds))
    residual = force - evaluate(np.mean(fitted[1], axis=0), own_phase)
    at_reversals = bridged(np.mean(fitted[0], axis=0), own_phase, len(y) / cycles.count, count)
    change = at_reversals.change(residual[at_reversals.places])
    residual[at_reversals.sample] += change
    fitted[1] += _sums(change, own_phase, at_reversals.sample, bounds, count)
    mean_displacement, mean_force = np.mean(fitted, axis=1)
    order = np.argsort(own_phase, kind="stable")
    noise, spread = _noise(own_phase[order], residual[order])
    drift = _drift(fitted[1], phase / (2 * np.pi), own_phase)
    scatter, spread = (noise, spread) if drift is None else _noise(own_phase[order], (residual - drift)[order])
    per_sample = len(y) / cycles.count
    force_variance = _variance(fitted[1], 2 * noise**2 / per_sample)
    displacement_error = np.sqrt(_variance(fitted[0], _displacement_noise(fitted[0])) / cycles.count)
    force_rms = math.sqrt(np.mean(force**2))
    force_error = np.maximum(np.sqrt(force_variance / cycles.count), FINEST_SHARE * force_rms)
    insignificant = np.abs(mean_displacement) < SIGNIFICANT * displacement_error
    insignificant[:2] = False
    middle = np.asarray(run.first_cycle + cycles.before + 0.5 + np.arange(cycles.count), dtype=np.float64)
    return _RunLoop(
        cycles=middle,
        displacement=_padded(np.where(insignificant, 0, mean_displacement), harmonics),
        force=_padded(mean_force, harmonics),
        displacement_per_cycle=_padded(fitted[0], harmonics),
        force_per_cycle=_padded(fitted[1], harmonics),
        force_standard_error=np.append(force_error, np.full(harmonics - count, math.inf)),
        noise_rms_N=noise,
        scatter_rms_N=scatter,
        scatter_by_phase=spread,
        force_rms_N=force_rms,
        samples=len(y),
        phase=own_phase,
        at_reversals=at_reversals,
    )


def _sums(change: Array, phase: Array, sample: IntArray, bounds: IntArray, count: int) -> ComplexArray:
    """Give the harmonics, (cycles, count + 1), that a change of single samples makes in each cycle."""
    cycle = np.searchsorted(bounds, sample, side="right") - 1
    harmonics = np.zeros((len(bounds) - 1, count + 1), dtype=np.complex128)
    np.add.at(harmonics, cycle, change[:, None] * np.exp(-1j * np.outer(phase[sample], np.arange(count + 1))))
    harmonics[:, 1:] *= 2.0
    return np.asarray(harmonics / np.diff(bounds)[:, None])


def _padded(values: ComplexArray, harmonics: int) -> ComplexArray:
    """Add zeros for the harmonics that the sampling can't carry."""
    full = np.zeros((*values.shape[:-1], harmonics + 1), dtype=np.complex128)
    full[..., : values.shape[-1]] = values
    return full


def _drift(per_cycle: ComplexArray, elapsed: Array, phase: Array) -> Array | None:
    """Return the force that steadily changes from cycle to cycle, less its mean loop; None where none does.

    A harmonic drifts when a line through its cycles leaves so little over that scatter would hardly do so: with two
    freedoms for the line's slope and 2 (cycles - 2) for the rest, the F distribution's tail is a power.

    Args:
        per_cycle: harmonics of the force, (cycles, H + 1).
        elapsed: cycles since the first sample, (N,).
        phase: (N,) rad.
    """
    cycles = len(per_cycle)
    if cycles < 3:
        return None
    along = np.arange(cycles) - (cycles - 1) / 2
    deviation = per_cycle - np.mean(per_cycle, axis=0)
    slope = along @ deviation / (along @ along)
    explained = np.abs(slope) ** 2 * (along @ along)
    rest = np.sum(np.abs(deviation - along[:, None] * slope) ** 2, axis=0)
    drifting = np.flatnonzero(explained > (DRIFT_BY_CHANCE ** (-1 / (cycles - 2)) - 1) * rest)
    if len(drifting) == 0:
        return None
    # a cycle's harmonics are those at its middle; before the first middle and after the last the line goes on
    place = elapsed - 0.5
    left = np.clip(np.floor(place).astype(np.intp), 0, cycles - 2)
    share = place - left
    force = np.zeros(len(phase))
    for order in drifting:
        between = (1 - share) * deviation[left, order] + share * deviation[left + 1, order]
        force += (between * unit_phasor(order * phase)).real
    return force


def phase_bin(phase: Array) -> IntArray:
    """Return the part of the cycle, 0 to PHASE_BINS - 1, in which each phase in rad lies."""
    place = np.floor(phase * (PHASE_BINS / (2 * np.pi))).astype(np.intp)
    return np.asarray(place % PHASE_BINS)


def _noise(phase: Array, residual: Array) -> tuple[float, Array]:
    """Return the rms of what is not periodic, and how its power spreads over the cycle, from neighbours in phase.

    Neighbours in phase come from different cycles. What a sample differs by from the line through the one before and
    the one after holds the noise of all three and next to nothing of the loop: its mean square gives the noise
    variance (Gasser, Sroka and Jennen-Steinmetz, Biometrika 1986) and needs no count of fitted parameters. A jump of
    the loop, such as friction makes at a reversal, shows in a few samples among hundreds, far beyond the others.

    Args:
        phase: (N,) rad, ascending.
        residual: (N,) force without its harmonics.
    """
    spacing = np.maximum(np.diff(phase), 1e-12)
    before = spacing[1:] / (spacing[1:] + spacing[:-1])
    off = residual[1:-1] - before * residual[:-2] - (1 - before) * residual[2:]
    off /= np.sqrt(1 + before**2 + (1 - before) ** 2)
    typical = float(np.median(np.abs(off))) / 0.6745
    # quantised readings of equal phase may agree exactly more often than not
    usual = np.abs(off) <= JUMP * typical if typical > 0.0 else np.ones(len(off), dtype=np.bool_)
    squares = off[usual] ** 2
    power = np.bincount(phase_bin(phase[1:-1][usual]), squares, PHASE_BINS)
    whole = float(np.sum(power))
    shares = power / whole if whole > 0.0 else np.full(PHASE_BINS, 1 / PHASE_BINS)
    return math.sqrt(np.mean(squares)), shares


def _displacement_noise(per_cycle_harmonics: ComplexArray) -> float:
    """Return the noise level of a cycle's harmonics of displacement: most of them hold nothing else.

    Args:
        per_cycle_harmonics: (cycles, H + 1).

    Returns:
        The variance of the real part, in the harmonics' unit squared.
    """
    cycles = len(per_cycle_harmonics)
    if cycles > 1:
        spread = np.sum(np.abs(per_cycle_harmonics - np.mean(per_cycle_harmonics, axis=0)) ** 2, axis=0)
        return float(np.median(spread[1:])) / (2 * (cycles - 1))
    # one cycle has no scatter: the upper half of its harmonics is the best that is known of the noise
    upper = np.abs(per_cycle_harmonics[0, per_cycle_harmonics.shape[1] // 2 + 1 :]) ** 2
    return float(np.median(upper)) / 2 if len(upper) else 0.0


def _variance(per_cycle_harmonics: ComplexArray, noise: float) -> Array:
    """Return each harmonic's variance from cycle to cycle, of the real and of the imaginary part each.

    Args:
        per_cycle_harmonics: (cycles, H + 1).
        noise: the variance that noise alone gives the real part of a harmonic above 0.

    Returns:
        (H + 1,), a mean of the scatter and the noise level, weighted by their degrees of freedom.
    """
    cycles, count = per_cycle_harmonics.shape
    parts = np.where(np.arange(count) > 0, 2.0, 1.0)
    freedoms = parts * (cycles - 1)
    spread = np.sum(np.abs(per_cycle_harmonics - np.mean(per_cycle_harmonics, axis=0)) ** 2, axis=0)
    # the mean has half the variance of a harmonic's part
    return np.asarray((NOISE_FREEDOMS * noise * parts / 2 + spread) / (NOISE_FREEDOMS + freedoms))
