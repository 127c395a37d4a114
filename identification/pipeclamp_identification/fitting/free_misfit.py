"""The error of a law along records of free motion: the law follows them from rest, as an FMU would."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from pipeclamp_identification.campaign.free_motion import FreeRun
from pipeclamp_identification.fitting.beginning import MATERIAL, beginning, came_from
from pipeclamp_identification.fitting.observations import known_temperature
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.signals import condition_signal
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.file import LawFile, law_of
from pipeclamp_models.law.law import Law
from pipeclamp_models.realise.force import force_of_law
from pipeclamp_models.realise.motion import Motion, refuse_unknown_conditions
from pipeclamp_models.realise.scalar_law import parts_of_law
from pipeclamp_models.steps.tracker import Interval, held, start_tracking, tracked
from pipeclamp_models.steps.ways import ways_along

REMEMBERED_SHARE = 0.5
"""A law remembers its beginning to a record's end where another beginning shows there, by more than this share of what
it made of the force at first: what fades in time has long faded, and an element that never slips keeps all of it."""
NOWHERE = 1e-9
"""Share of the largest force that is round-off."""


@dataclass(frozen=True)
class FreeMisfit:
    """How a law fits one run of free motion, over all its samples.

    Attributes:
        run: its name.
        time: s from the record's beginning, shape (samples,).
        y, v: displacement in mm and velocity in mm/s, smoothed, same shape.
        measured, computed: force in N, same shape.
        amplitude, frequency: A in mm and f in Hz of the motion, tracked from what has passed, before they are held
            inside the law's range; same shape.
        ranges: the law's range of A and f.
        temperature_K: mean over the record; nan where it isn't known.
        came_from: displacement in mm from which the law is brought to where the record begins, so that its force at
            rest is the measured one; None where its memory is unloaded.
        adrift: whether the law's force or the measured one is known up to a constant only, for which the measured mean
            is taken.
        at_rest: force in N of the law where the record begins, at rest and its memory unloaded.
        nrmse_without: error as a share of the force, were the law without that constant force; None where it has none
            that is worth a word.
        remembers: whether the law has states; otherwise A and f are all that it knows of the motion's past.
        on_sines: the law's error as a share of the force on the sines that it was identified from, on left-out ones
            where its file knows that; None where it tells neither.
        scatter_on_sines: cycle-to-cycle scatter of those sines, as a share of their force; None where it isn't known.
    """

    run: str
    time: Array
    y: Array
    v: Array
    measured: Array
    computed: Array
    amplitude: Array
    frequency: Array
    ranges: tuple[Interval, Interval]
    temperature_K: float
    came_from: float | None
    adrift: bool
    at_rest: float = 0.0
    nrmse_without: float | None = None
    remembers: bool = True
    on_sines: float | None = None
    scatter_on_sines: float | None = None

    @property
    def squared_error(self) -> float:
        """Sum of squared errors, N2."""
        return float(np.sum((self.measured - self.computed) ** 2))

    @property
    def squared_force(self) -> float:
        """Sum of squared measured forces, N2."""
        return float(np.sum(self.measured**2))

    @property
    def nrmse(self) -> float:
        """Error of the run as a share of its force."""
        return math.sqrt(self.squared_error / self.squared_force)


def free_misfits(
    file: LawFile,
    runs: Sequence[FreeRun],
    others: Mapping[str, float] = MappingProxyType({}),
    *,
    timed: bool = True,
) -> tuple[FreeMisfit, ...]:
    """Hold a law against every sample of runs of free motion.

    The law begins at rest where the record begins, its memory loaded as the force at rest says (see `beginning`), and
    sees the motion without its sensor's noise. A and f follow the motion as an FMU's do that is built with `--track`;
    load cycles are counted as there. Effects of the rig (offset, delay, inertia) belong to what is measured. Where an
    element never slips along the whole record, so that the force is known up to a constant only, or the mean of the
    measured force isn't known, the measured mean is taken for that constant.

    Args:
        file: the law.
        runs: of free motion.
        others: temperatures in K, nan where not known, of the campaign's other runs: where none is known at all, the
            law is taken at its reference temperature.
        timed: whether their time was measured; otherwise f means nothing, and is what the law takes it for.

    Raises:
        UserError: the law follows a condition that isn't known, or gives no finite force.
    """
    law = law_of(file)
    temperature = _temperatures(runs)
    used = _usable(law, runs, temperature, others)
    ranges = _range(file, "A"), _range(file, "f")
    found = (_with_constant(law, run, T, ranges) for run, T in zip(runs, used, strict=True))
    on_sines, scatter = _on_sines(file), file.fit.noise_nrmse if file.fit else None
    return tuple(
        replace(
            misfit,
            temperature_K=float(np.mean(T)),
            frequency=misfit.frequency if timed else np.clip(misfit.frequency, *ranges[1]),
            on_sines=on_sines,
            scatter_on_sines=scatter,
        )
        for misfit, T in zip(found, temperature, strict=True)
    )


def _on_sines(file: LawFile) -> float | None:
    if not file.history:
        return None
    last = file.history[-1]
    return last.nrmse if last.refitted_nrmse is None else last.refitted_nrmse


def _range(file: LawFile, name: str) -> Interval:
    if name not in file.range:
        raise UserError(
            f"law {file.name}: its range doesn't hold {name}, inside which it follows a free motion; expected a law "
            "that was identified from tests"
        )
    return file.range[name].minimum, file.range[name].maximum


def _temperatures(runs: Sequence[FreeRun]) -> list[Array]:
    """Give each run's temperature in K along its motion, (n,) where the record measured it, else (), nan if unknown."""
    found = []
    for run in runs:
        measured = run.record.temperature_C
        known = np.zeros(0, dtype=np.intp) if measured is None else np.flatnonzero(np.isfinite(measured))
        if measured is not None and len(known):
            at = run.record.time_s[known] - run.record.time_s[0]
            found.append(np.interp(run.motion.time, at, measured[known]) + CELSIUS)
        else:
            found.append(np.asarray(run.setup.kelvin))
    return found


def _usable(
    law: Law, runs: Sequence[FreeRun], temperature: Sequence[Array], others: Mapping[str, float]
) -> list[Array]:
    """Give temperatures that the law can be evaluated at.

    Raises:
        UserError: they are known for some of the campaign's runs only.
    """
    if "T" not in law.equations.slow_signals:
        return list(temperature)
    mean = np.array([*(float(np.mean(T)) for T in temperature), *others.values()])
    usual = known_temperature(mean, [*(run.name for run in runs), *others])
    return [np.where(np.isfinite(T), T, value) for T, value in zip(temperature, usual, strict=False)]


def _with_constant(law: Law, run: FreeRun, temperature: Array, ranges: tuple[Interval, Interval]) -> FreeMisfit:
    """Give the misfit of a run, and what it would be without the force that the law has at rest.

    Sines in which a clamp always slips don't tell a constant force from slip forces that differ between the
    directions; at rest they part.
    """
    found = _misfit(law, run, temperature, ranges)
    if found.adrift or not abs(found.at_rest) > MATERIAL * math.sqrt(np.mean(found.measured**2)):
        return found
    moved = replace(run, record=replace(run.record, force_N=run.record.force_N + found.at_rest))
    without = _misfit(law, moved, temperature, ranges)
    return replace(found, nrmse_without=math.sqrt(without.squared_error / found.squared_force))


def _misfit(law: Law, run: FreeRun, temperature: Array, ranges: tuple[Interval, Interval]) -> FreeMisfit:
    motion, tracks = _law_motion(law, run, temperature, ranges)
    force = force_of_law(law, motion).force[0]
    at_rest = float(force[0])
    begin = beginning(law, run, motion, force, ranges[0][1])
    if begin:
        motion = replace(motion, memory=begin.memory)
        force = force_of_law(law, motion).force[0]
    if not np.all(np.isfinite(force)):
        raise UserError(
            f"the law gives a force that is not finite on run {run.name!r}; expected a motion near the law's range"
        )
    time = run.record.time_s - run.record.time_s[0]
    on_samples = [np.interp(time, run.motion.time, values) for values in (run.motion.y, run.motion.v, force, *tracks)]
    y, v, computed, amplitude, frequency = on_samples
    measured = run.record.force_N
    adrift = not run.mean_known or _remembers_its_beginning(law, motion, force)
    if adrift:
        computed = computed + np.mean(measured - computed)
    return FreeMisfit(
        run.name,
        time,
        y,
        v,
        measured,
        computed,
        amplitude,
        frequency,
        ranges,
        float(np.mean(temperature)),
        begin.came_from if begin else None,
        adrift,
        at_rest if run.begins_at_rest else 0.0,
        remembers=bool(law.equations.states),
    )


def _law_motion(
    law: Law, run: FreeRun, temperature: Array, ranges: tuple[Interval, Interval]
) -> tuple[Motion, tuple[Array, Array]]:
    """Give a run's motion for the law to be evaluated on, and A and f before they are held inside the law's range."""
    smooth = run.motion
    y, v = smooth.y[None], smooth.v[None]
    rest, h = np.full((1, 1), smooth.y[0]), np.full((1, 1), smooth.step)
    tracks = tracked_along(smooth.step, smooth.y, smooth.v, ranges)
    A, f = (np.clip(values, *interval) for values, interval in zip(tracks, ranges, strict=True))
    conditions = {
        "A": A[None],
        "f": f[None],
        "T": np.atleast_2d(temperature),
        "N": np.full((1, 1), run.setup.first_cycle),
        "rho": np.full((1, 1), run.setup.density),
        **{condition_signal(name): np.full((1, 1), value) for name, value in run.setup.conditions.items()},
    }
    columns = {"rho": "density_g_cm3", **{condition_signal(name): name for name in run.setup.conditions}}
    for signal, column in columns.items():
        if signal in law.equations.slow_signals and not np.all(np.isfinite(conditions[signal])):
            raise UserError(f"the law depends on {column}, which isn't known for {run.name}; fill it in in runs.csv")
    motion = Motion(y, v, smooth.a[None], conditions, h, periodic=False, rest=rest)
    refuse_unknown_conditions(sorted(law.equations.slow_signals), motion)
    means = {name: float(np.mean(values)) for name, values in conditions.items()}
    ways = ways_along(y, v, h, rest, parts_of_law(law, means, ranges[0][1], ranges[1][1]))
    counted = np.cumsum(ways.length / (4 * A), axis=1)[:, :-1]
    # as the FMU counts: those that have passed before
    cycles = run.setup.first_cycle + np.pad(counted, ((0, 0), (1, 0)))
    return replace(motion, slow={**conditions, "N": cycles}, ways=ways), tracks


def tracked_along(step: float, y: Array, v: Array, ranges: tuple[Interval, Interval]) -> tuple[Array, Array]:
    """Give A (mm) and f (Hz) along a motion, before they are held inside the law's range.

    They start in the middle of that range, as in an FMU that is told nothing else.

    Args:
        step: s between samples.
        y, v: mm and mm/s, shape (n,).
        ranges: the law's range of A and f.
    """
    A, f = (held(sum(interval) / 2, interval) for interval in ranges)
    averages = start_tracking(A, f)
    amplitudes, frequencies = [A], [f]
    for place, speed in zip(y[1:].tolist(), v[1:].tolist(), strict=True):
        A, f, averages = tracked(averages, step, f, ranges, place, speed)
        amplitudes.append(A)
        frequencies.append(f)
    return np.array(amplitudes), np.array(frequencies)


def _remembers_its_beginning(law: Law, motion: Motion, force: Array) -> bool:
    """Tell whether the force still shows at the end where the law's memory began.

    The other beginning is one loaded over the whole way of the motion.
    """
    if not law.equations.states:
        return False
    other = force_of_law(law, replace(motion, memory=came_from(law, motion, -float(np.ptp(motion.y))).memory)).force[0]
    apart = np.abs(other - force)
    at_first, at_last = float(np.max(apart[: len(apart) // 10 + 1])), float(apart[-1])
    return at_first > NOWHERE * float(np.max(np.abs(force))) and at_last > REMEMBERED_SHARE * at_first
