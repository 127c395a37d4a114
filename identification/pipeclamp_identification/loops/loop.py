"""A loop: one run as the harmonics of its displacement and force, averaged over cycles, with their scatter.

Harmonics carry the whole loop in few numbers, tell what is periodic from what is noise, and give velocity and
acceleration by multiplication with i n omega, which delays nothing against the force.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pipeclamp_identification.campaign.reading import Run
from pipeclamp_identification.campaign.smoothing import gain
from pipeclamp_identification.loops.at_rest import force_at_rest
from pipeclamp_identification.loops.scatter import (
    displacement_noise,
    drifting_force,
    harmonic_variance,
    noise_by_phase,
)
from pipeclamp_identification.signals.harmonics import carried_harmonics, cycle_harmonics, evaluate
from pipeclamp_identification.signals.reversals import Bridged, bridged
from pipeclamp_models.base.arrays import Array, ComplexArray, IntArray
from pipeclamp_models.base.units import CELSIUS

SIGNIFICANT_STANDARD_ERRORS = 3.0
"""A harmonic of the displacement below this many standard errors is taken for noise."""
FINEST_SHARE = 1e-5
"""No force is known better than this share of its rms, whatever a noise-free record says; much less, and what aliases
into the harmonics of a noise-free record would count as evidence."""
STRETCHES = 3
"""Of a record's cycles: as few as show whether what changes along them bends."""
LEAST_GAIN = 0.3
"""Harmonics of the displacement of which a moving average left less than this are lost."""


@dataclass(frozen=True)
class Loop:
    """The loop of one run, of one of its cycles, or of a stretch of them; H harmonics.

    x(theta) = Re sum X_n exp(i n theta) with theta = 2 pi f t + phase such that displacement[1] = A is real and
    positive, so that the real parts of the force are in phase with the displacement. X_0 is the mean.
    Unknown temperature, density and conditions are nan. A harmonic that the run's sampling can't carry is zero with an
    infinite standard error.
    """

    run: str
    specimen: str | None
    frequency_Hz: float
    temperature_K: float
    density_g_cm3: float
    conditions: Mapping[str, float]
    displacement: ComplexArray
    """(H + 1,) mm; harmonics that are not significant are zero."""
    force: ComplexArray
    """(H + 1,) N."""
    force_standard_error: Array
    """(H + 1,) N, of the real and of the imaginary part each; infinite for a mean that isn't known."""
    noise_rms_N: float
    """Rms of what is not periodic in the force."""
    scatter_rms_N: float
    """Rms of what of it doesn't drift from cycle to cycle either: no law can explain it."""
    scatter_by_phase: Array
    """(PHASE_BINS,) share of its power that lies in each part of the cycle, from the largest displacement on."""
    force_rms_N: float
    """Rms of the force over the steady samples."""
    force_at_rest_N: float
    """Mean force before the record's motion begins; nan where that isn't known."""
    samples: float
    """Number of steady samples; a cycle's share of its run's may be a fraction."""
    cycles: Array
    """(cycles,) load cycles that the specimen had seen at the middle of each cycle."""
    displacement_per_cycle: ComplexArray
    """(cycles, H + 1) mm, each cycle turned so that its own fundamental is real."""
    force_per_cycle: ComplexArray
    """(cycles, H + 1) N, turned likewise."""
    phases: Array
    """(samples,) rad: where in the cycle each steady sample lies, in the order of time."""
    at_reversals: Bridged
    """The samples at reversals, which stand for the mean over their interval."""
    labels: Mapping[str, str] = field(default_factory=dict)
    """Texts that may group runs, by column of runs.csv; blank where there is none."""

    @property
    def cycle(self) -> float:
        """Return the load cycles that the specimen had seen, a geometric mean: what ages goes by their logarithm."""
        return float(np.exp(np.mean(np.log(self.cycles))))

    @property
    def amplitude_mm(self) -> float:
        """Return the amplitude of the displacement's fundamental."""
        return float(self.displacement[1].real)

    @property
    def shows_scatter(self) -> bool:
        """Return whether it has cycles to scatter: one alone shows the noise between its samples only."""
        return len(self.cycles) > 1

    def by_cycle(self) -> Iterator[Loop]:
        """Give the loop of each of its cycles; standard errors are those of a single cycle."""
        return self._in_parts(np.arange(len(self.cycles)))

    def by_stretch(self) -> Iterator[Loop]:
        """Give the loops of stretches of its cycles, about as long as one another."""
        count = len(self.cycles)
        return self._in_parts(np.arange(count) * min(STRETCHES, count) // count)

    def _in_parts(self, part: IntArray) -> Iterator[Loop]:
        """Give the loop of each part of its cycles; `part` is the number of each cycle's, (cycles,), rising."""
        count = len(self.cycles)
        displacement = self.displacement_per_cycle * (self.displacement != 0)
        # each cycle begins where the phase within the cycle falls back
        starts = np.array([0, *(np.flatnonzero(np.diff(self.phases) < -np.pi) + 1).tolist(), len(self.phases)])
        edges = [0, *(np.flatnonzero(np.diff(part)) + 1).tolist(), count]
        for first, last in itertools.pairwise(edges):
            own, samples = slice(first, last), starts[[first, last]].tolist()
            yield replace(
                self,
                displacement=displacement[own].mean(axis=0),
                force=self.force_per_cycle[own].mean(axis=0),
                force_standard_error=self.force_standard_error * np.sqrt(count / (last - first)),
                samples=self.samples * (last - first) / count,
                cycles=self.cycles[own],
                displacement_per_cycle=displacement[own],
                force_per_cycle=self.force_per_cycle[own],
                phases=self.phases[slice(*samples)],
                at_reversals=self.at_reversals.within(*samples),
            )


def loop_of(
    run: Run,
    condition_columns: Sequence[str],
    harmonics: int,
    displacement_average: float,
    drift_by_chance: float,
) -> Loop:
    """Turn a run's record into its loop.

    Args:
        run: with C steady cycles.
        condition_columns: names of the further conditions, in their order.
        harmonics: H, the highest harmonic to keep.
        displacement_average: share of the period over which the displacement was averaged before it was recorded.
        drift_by_chance: as for `drifting_force`.
    """
    cycles = run.cycles
    own = _in_own_phase(run, harmonics, displacement_average)
    mean_displacement, mean_force = np.mean(own.fitted, axis=1)
    order = np.argsort(own.phase, kind="stable")
    noise, spread = noise_by_phase(own.phase[order], own.residual[order])
    drift = drifting_force(own.fitted[1], own.drive_phase / (2 * np.pi), own.phase, drift_by_chance)
    scatter, spread = (
        (noise, spread) if drift is None else noise_by_phase(own.phase[order], (own.residual - drift)[order])
    )
    force_rms = math.sqrt(np.mean(run.record.force_N[cycles.steady] ** 2))
    displacement_error, force_error = _standard_errors(own.fitted, noise, len(own.phase) / cycles.count)
    force_error = np.maximum(force_error, FINEST_SHARE * force_rms)
    if not run.mean_known:
        force_error[0] = math.inf
    insignificant = np.abs(mean_displacement) < SIGNIFICANT_STANDARD_ERRORS * displacement_error
    insignificant[:2] = False
    return Loop(
        run=run.name,
        specimen=run.setup.specimen,
        frequency_Hz=cycles.frequency_Hz,
        temperature_K=_kelvin(run),
        density_g_cm3=run.setup.density,
        conditions={name: run.setup.conditions[name] for name in condition_columns},
        displacement=_padded(np.where(insignificant, 0, mean_displacement), harmonics),
        force=_padded(mean_force, harmonics),
        force_standard_error=np.append(force_error, np.full(harmonics + 1 - len(force_error), math.inf)),
        noise_rms_N=noise,
        scatter_rms_N=scatter,
        scatter_by_phase=spread,
        force_rms_N=force_rms,
        force_at_rest_N=force_at_rest(run.record, cycles),
        samples=float(len(own.phase)),
        cycles=np.asarray(run.setup.first_cycle + cycles.before + 0.5 + np.arange(cycles.count), dtype=np.float64),
        displacement_per_cycle=_padded(own.fitted[0], harmonics),
        force_per_cycle=_padded(own.fitted[1], harmonics),
        phases=own.phase,
        at_reversals=own.at_reversals,
        labels=run.setup.texts,
    )


@dataclass(frozen=True)
class _InOwnPhase:
    """The C steady cycles of a record, each in its own phase.

    Attributes:
        fitted: harmonics of displacement (mm) and force (N) of each cycle, (2, C, h + 1).
        drive_phase: of the n samples, as the drive goes on, rad, (n,).
        phase: of the samples in their cycles' own phase, rad, (n,).
        residual: what the mean loop leaves of the force, N, (n,).
        at_reversals: the samples in whose interval the motion reverses.
    """

    fitted: ComplexArray
    drive_phase: Array
    phase: Array
    residual: Array
    at_reversals: Bridged


def _in_own_phase(run: Run, harmonics: int, displacement_average: float) -> _InOwnPhase:
    """Fit the cycles of a run; arguments as for `loop_of`."""
    record, cycles = run.record, run.cycles
    y, force = record.displacement_mm[cycles.steady], record.force_N[cycles.steady]
    phase = cycles.phase(record)
    bounds = cycles.bounds - cycles.bounds[0]
    count = min(harmonics, carried_harmonics(phase, bounds))
    fitted = cycle_harmonics(phase, bounds, [y, force], count)
    # each cycle has its own phase: a drive that wanders in phase doesn't smear the mean loop; half a turn off, that
    # phase would go to and fro between -pi and pi
    lag = np.unwrap(np.angle(fitted[0, :, 1]))
    fitted *= np.exp(-1j * lag[:, None] * np.arange(count + 1))
    # the clamp saw the displacement before it was averaged; what an average leaves little of isn't brought back
    left = gain(displacement_average, np.arange(count + 1))
    fitted[0] *= np.where(left > LEAST_GAIN, 1 / np.maximum(left, LEAST_GAIN), 0.0)
    own_phase = phase + np.repeat(lag - 2 * np.pi * np.arange(cycles.count), np.diff(bounds))
    residual = force - evaluate(np.mean(fitted[1], axis=0), own_phase)
    at_reversals = bridged(np.mean(fitted[0], axis=0), own_phase, len(y) / cycles.count, count)
    change = at_reversals.change(residual[at_reversals.places])
    residual[at_reversals.sample] += change
    fitted[1] += _sums(change, own_phase, at_reversals.sample, bounds, count)
    return _InOwnPhase(fitted, phase, own_phase, residual, at_reversals)


def _standard_errors(fitted: ComplexArray, noise: float, samples: float) -> tuple[Array, Array]:
    """Give the standard errors of the mean harmonics of displacement (mm) and force (N), from cycle to cycle.

    Args:
        fitted: of each cycle, (2, C, h + 1).
        noise: of a sample of the force, N.
        samples: in a cycle.
    """
    cycles = fitted.shape[1]
    force_variance = harmonic_variance(fitted[1], 2 * noise**2 / samples)
    displacement_variance = harmonic_variance(fitted[0], displacement_noise(fitted[0]))
    return np.sqrt(displacement_variance / cycles), np.sqrt(force_variance / cycles)


def _kelvin(run: Run) -> float:
    """Return the temperature that the record measured, or else the one of runs.csv, or nan."""
    measured = run.record.temperature_C
    if measured is not None:
        steady = measured[run.cycles.steady]
        known = steady[np.isfinite(steady)]
        if len(known):
            return float(np.mean(known)) + CELSIUS
    return run.setup.kelvin


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
