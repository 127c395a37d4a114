"""What a fit compares: the harmonics of measured loops."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from pipeclamp_identification.campaign.smoothing import averaged
from pipeclamp_identification.loops.loops import Loops, displacement_on_grid, on_grid
from pipeclamp_identification.signals.real_harmonics import as_real, for_both_parts, mean_squares_of, real_harmonics_of
from pipeclamp_identification.signals.sampled_transform import sampled_transform
from pipeclamp_models.base.arrays import Array, BoolArray, IntArray
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.base.said import few_of
from pipeclamp_models.base.signals import REFERENCES, condition_signal
from pipeclamp_models.base.threads import in_threads
from pipeclamp_models.law.outline import Sizes
from pipeclamp_models.realise.force import LawForce, known_jacobian
from pipeclamp_models.realise.motion import Motion
from pipeclamp_models.realise.sizes import data_sizes

FEW_SAMPLES = 400
"""Below so many samples a cycle, a law is seen through the record's own sampling."""
SAMPLES_PER_CYCLE = 512
"""Points of the cycle at which laws are evaluated: a step at a reversal must be placed well between samples."""
FEWEST_POINTS_PER_CYCLE = 64
"""Points at least, so that they show the harmonics."""
GRID_ERROR = 10.0
"""Times 1/points^2, the share of the force by which few points err: that of elements that slip, 6e-4 for 128."""
GRID_NOISE_SHARE = 0.05
"""What the points err by is less than this share of the scatter: half of what is worth an effect."""
POINTS_PER_SAMPLE = 2
"""Between two points force goes straight, and at a reversal it doesn't. A sample within half a step of one is bridged;
the next must lie beyond the point next to the reversal."""


class Observations(Protocol):
    """Measured quantities, in units of their own uncertainty, on known motions."""

    @property
    def motion(self) -> Motion:
        """The motions at which the law's force is wanted, one a row."""

    @property
    def force_amplitude(self) -> Array:
        """Half the range of the measured force in N, shape (R,)."""

    @property
    def are_linear(self) -> bool:
        """Whether the residuals are linear in the law's force."""

    @property
    def deny_constant_force(self) -> bool:
        """Whether forces at rest before the tests deny one: a law that has one then is another law."""

    @property
    def show_shape(self) -> bool:
        """Whether they show the shape of loops."""

    @property
    def runs(self) -> IntArray | None:
        """Number of the run of each row, shape (R,); None where each row is a run of its own."""

    def residual(self, law_force: LawForce) -> Array:
        """Give the weighted residuals, measured less law, shape (R, m), for the law's force on the motion."""

    def residual_slopes(self, law_force: LawForce, parameters: IntArray) -> Array:
        """Give the derivatives of the residuals by some of the parameters, shape (P, R, m)."""

    def compared(self, law_force: LawForce) -> int:
        """Give how many of the residuals are evidence; the others are zero, whatever the law."""


def harmonic_slopes(law_force: LawForce, count: int, parameters: IntArray) -> Array:
    """Give the derivatives of a force's harmonics 0..count by some of the law's parameters, shape (P, R, m)."""
    return known_jacobian(law_force).through(lambda forces: real_harmonics_of(forces, count), parameters)


def _transforms(loops: Loops, samples: int) -> Array | None:
    """Give each run its transform, shape (R, m, n); None where all have many samples a cycle that nothing smoothed."""
    few = [count < FEW_SAMPLES for count in _samples_per_cycle(loops)]
    if not any(few) and not loops.force_average:
        return None
    count = loops.force.shape[1] - 1
    plain = real_harmonics_of(np.eye(samples), count)
    own = np.tile(plain.T, (len(loops.run), 1, 1))

    def fill(row: int) -> None:
        carried = int(np.count_nonzero(np.isfinite(loops.force_standard_error[row, 1:])))
        sampled = sampled_transform(loops.phases[row], loops.at_reversals[row], samples, carried)
        own[row, : 2 * carried + 1] = sampled.T

    rows: list[int] = np.flatnonzero(few).tolist()
    with one_thread():
        in_threads(fill, rows, sum(len(loops.phases[row]) for row in rows) / max(len(rows), 1))
    # An average is symmetric: the transform of averaged forces is the averaged transform of forces.
    return averaged(own, loops.force_average)


@dataclass(frozen=True)
class LoopObservations:
    """Harmonics of measured loops.

    Attributes:
        motion: the measured motions, R rows.
        harmonics: measured force in N as `real_harmonics_of` gives it, shape (R, 2 H + 1).
        standard_error: of each of them, same shape; infinite where there is none.
        force_amplitude: N, shape (R,).
        transforms: how each record's sampling turns force into harmonics, shape (R, 2 H + 1, n): points of the cycle
            last, as in forces, which a fit is quickest with; None where it is fine enough for that not to matter.
        deny_constant_force: whether forces at rest before the tests do.
        runs: number of the run of each row, shape (R,); None where each row is a run of its own.
    """

    motion: Motion
    harmonics: Array
    standard_error: Array
    force_amplitude: Array
    transforms: Array | None = None
    deny_constant_force: bool = False
    runs: IntArray | None = None

    @property
    def show_shape(self) -> bool:
        """As harmonics do."""
        return True

    @property
    def are_linear(self) -> bool:
        """Harmonics are."""
        return True

    def transformed(self, force: Array) -> Array:
        """Give the harmonics of force on the motion's grid, shape (..., R, n), as the records would show them."""
        with np.errstate(over="ignore", invalid="ignore"):  # of a force beyond all numbers, which a fit refuses
            if self.transforms is None:
                return real_harmonics_of(force, (self.harmonics.shape[1] - 1) // 2)
            by_run = np.moveaxis(np.atleast_3d(force.T).T, 1, 0)
            found = by_run @ np.swapaxes(self.transforms, 1, 2)
        return np.asarray(np.moveaxis(found, 0, 1).reshape(*force.shape[:-1], -1))

    @property
    def seen(self) -> BoolArray:
        """Whether each entry was measured; sampling may not carry the highest harmonics."""
        return np.isfinite(self.standard_error)

    def plain_residual(self, law_force: LawForce) -> Array:
        """Give measured less law in N; the mean force that a row which is adrift can hold is no evidence."""
        residual = self.harmonics - self.transformed(law_force.force)
        residual[:, 0] -= np.clip(residual[:, 0], -law_force.held, law_force.held)
        return np.asarray(residual)

    def open_means(self, law_force: LawForce) -> BoolArray:
        """Tell in which rows a state that is adrift can hold the measured mean force, shape (R,)."""
        if not law_force.adrift.any():
            return law_force.adrift
        return np.asarray(law_force.adrift & (self.plain_residual(law_force)[:, 0] == 0.0))

    def off_in_mean(self, law_force: LawForce) -> Array:
        """Give the measured mean force less the law's own, N, shape (R,)."""
        return np.asarray(self.harmonics[:, 0] - law_force.force.mean(axis=1))

    def plain_slopes(self, law_force: LawForce, parameters: IntArray) -> Array:
        """Give the derivatives of the plain residuals; the transform is linear."""
        slopes = -known_jacobian(law_force).through(self.transformed, parameters)
        slopes[:, self.open_means(law_force), 0] = 0.0
        return np.asarray(slopes)

    def in_units(self, plain: Array) -> Array:
        """Give harmonics in N in units of their standard error."""
        return np.asarray(plain / self.standard_error)

    def residual(self, law_force: LawForce) -> Array:
        """Give (measured - law)/standard error."""
        return np.asarray(self.plain_residual(law_force) / self.standard_error)

    def residual_slopes(self, law_force: LawForce, parameters: IntArray) -> Array:
        """Give the derivatives of the residuals."""
        return np.asarray(self.plain_slopes(law_force, parameters) / self.standard_error)

    def compared(self, law_force: LawForce) -> int:
        """Give how many of the residuals are evidence."""
        return int(np.count_nonzero(self.seen) - np.count_nonzero(law_force.adrift & self.seen[:, 0]))

    def rows(self, chosen: IntArray) -> LoopObservations:
        """Give the observations of some of the loops."""
        return replace(
            self,
            motion=self.motion.rows(chosen),
            harmonics=self.harmonics[chosen],
            standard_error=self.standard_error[chosen],
            force_amplitude=self.force_amplitude[chosen],
            transforms=None if self.transforms is None else self.transforms[chosen],
            runs=None if self.runs is None else np.unique(self.runs[chosen], return_inverse=True)[1].astype(np.intp),
        )

    def mean_squares(self, law_force: LawForce, explained: Array | float = 0.0) -> Array:
        """Give the mean square of each loop's error, N2, shape (R,), by Parseval; scatter, and what is explained
        besides (harmonics, N), left aside."""
        return mean_squares_of(np.where(self.seen, self.plain_residual(law_force) - explained, 0.0))

    def with_discrepancy(self, law_force: LawForce, explained: Array | float = 0.0) -> LoopObservations:
        """Widen the uncertainty by what a law leaves over beyond the noise, as if it were spread over all harmonics.

        Where the law misses something, noise alone would let the quietest runs and the quietest harmonics rule the
        fit. Spread evenly, a law that misses much is fitted for the smallest rms force, and one that misses nothing by
        the noise. What is explained besides the law, N, of the harmonics' shape, isn't missed.
        """
        used = np.isfinite(self.standard_error)
        error = np.where(used, self.plain_residual(law_force) - explained, 0.0)
        noise = np.where(used, self.standard_error, 0.0) ** 2
        excess = max(float(np.sum(error**2 - noise)) / np.count_nonzero(used), 0.0)
        return replace(self, standard_error=np.sqrt(self.standard_error**2 + excess))

    def deviance(self, law_force: LawForce) -> float:
        """Give minus twice the log-likelihood of the harmonics but for a constant, the law's own discrepancy counted as
        noise: laws that were fitted with unlike weights compare by it."""
        widened = self.with_discrepancy(law_force)
        residual = widened.residual(law_force)[self.seen]
        return float(residual @ residual + 2 * np.sum(np.log(widened.standard_error[self.seen])))


@dataclass(frozen=True)
class WeightedLoops:
    """What observations that weigh loops' harmonics otherwise have in common, as of `Observations`.

    Attributes:
        loops: the harmonics as they were measured.
    """

    loops: LoopObservations

    @property
    def motion(self) -> Motion:
        """The measured motions."""
        return self.loops.motion

    @property
    def force_amplitude(self) -> Array:
        """Half the range of the measured force, N, shape (R,)."""
        return self.loops.force_amplitude

    @property
    def are_linear(self) -> bool:
        """As harmonics are."""
        return True

    @property
    def deny_constant_force(self) -> bool:
        """Whether forces at rest before the tests do."""
        return self.loops.deny_constant_force

    @property
    def show_shape(self) -> bool:
        """As harmonics do."""
        return True

    @property
    def runs(self) -> IntArray | None:
        """Number of the run of each row, shape (R,); None where each row is a run of its own."""
        return self.loops.runs


def loop_motion(loops: Loops, samples: int = SAMPLES_PER_CYCLE) -> Motion:
    """Give the measured motions of loops over one cycle, for laws to be evaluated on.

    Further conditions are named as in the campaign.

    Raises:
        UserError: the temperature is known for some runs only.
    """
    slow = {
        "A": loops.amplitude_mm,
        "f": loops.frequency_Hz,
        "T": known_temperature(loops.temperature_K, loops.run),
        "N": loops.cycle,
        "rho": loops.density_g_cm3,
        **{condition_signal(name): values for name, values in loops.conditions.items()},
    }
    y, v, a = displacement_on_grid(loops, samples)
    columns = {name: values[:, None] for name, values in slow.items()}
    h = 1.0 / (loops.frequency_Hz[:, None] * samples)
    return Motion(y, v, a, columns, h, assumed=assumed_signals(loops.temperature_K))


def assumed_signals(temperature: Array) -> frozenset[str]:
    """Give the slow signals whose values are assumed: T, where no run's temperature, in K, is known."""
    return frozenset() if np.any(np.isfinite(temperature)) else frozenset({"T"})


def known_temperature(temperature: Array, runs: Sequence[str]) -> Array:
    """Give the temperatures in K; where none is known at all the reference, so that a law without T can be identified.

    Args:
        temperature: K, nan where it isn't known, shape (R,).
        runs: names of the runs; several rows of one share its name.

    Raises:
        UserError: it is known for some runs only.
    """
    known = np.isfinite(temperature)
    if not known.any():
        return np.full(len(temperature), float(REFERENCES["T_0"]))
    if not known.all():
        every = list(dict.fromkeys(runs))
        blank = list(dict.fromkeys(run for run, there in zip(runs, known, strict=True) if not there))
        raise UserError(
            f"the temperature is known for {len(every) - len(blank)} of {len(every)} runs only, not for "
            f"{few_of(blank, most=5)}; fill in temperature_C in runs.csv, take the "
            "rows without it out, or blank it everywhere"
        )
    return temperature


def loop_observations(loops: Loops, samples: int = SAMPLES_PER_CYCLE) -> LoopObservations:
    """Give the harmonics of loops as observations, in units of their scatter; laws are evaluated at so many points."""
    error = for_both_parts(loops.force_standard_error)
    amplitude = np.ptp(on_grid(loops.force, SAMPLES_PER_CYCLE), axis=1) / 2
    names, of_row = np.unique(loops.run, return_inverse=True)
    return LoopObservations(
        loop_motion(loops, samples), as_real(loops.force), error, amplitude, _transforms(loops, samples),
        loops.deny_constant_force, of_row.astype(np.intp) if len(names) < len(loops.run) else None,
    )  # fmt: skip


def points_enough(loops: Loops) -> int:
    """Give how many points of the cycle err by far less than loops scatter: `SAMPLES_PER_CYCLE` at most.

    Where laws are seen through a record's own sampling, they lie close enough for that too.
    """
    per_cycle = _samples_per_cycle(loops)
    sampled = POINTS_PER_SAMPLE * max((count for count in per_cycle if count < FEW_SAMPLES), default=0.0)
    points = 2 * FEWEST_POINTS_PER_CYCLE
    while points < SAMPLES_PER_CYCLE and not (
        points >= sampled and GRID_ERROR / points**2 <= GRID_NOISE_SHARE * loops.noise_nrmse
    ):
        points *= 2
    return points


def _samples_per_cycle(loops: Loops) -> list[float]:
    return [len(phase) / len(cycles) for phase, cycles in zip(loops.phases, loops.cycles, strict=True)]


def coarser(loops: Loops, observations: LoopObservations) -> LoopObservations:
    """Give loops at a quarter of the points, for fits that only lead near."""
    return loop_observations(loops, max(FEWEST_POINTS_PER_CYCLE, observations.motion.y.shape[1] // 4))


def as_seen_at_few(few: LoopObservations, many: LoopObservations, law: tuple[LawForce, LawForce]) -> LoopObservations:
    """Give what was measured, with what few points of the cycle show otherwise than many, as a law has it.

    A jump of force between two of few points is no physics, nor is how a state that moves with the steps lags behind;
    either can be many times the noise.

    Args:
        few: at few points of the cycle.
        many: the same loops at many.
        law: the law's force at few of them and at many.
    """
    at_few, at_many = law
    error = few.transformed(at_few.force) - many.transformed(at_many.force)
    return replace(few, harmonics=many.harmonics + error)


def data_scales(observations: Observations) -> Sizes:
    """Give the sizes of the data in which starts and bounds of parameters are stated."""
    return data_sizes(observations.motion, observations.force_amplitude)
