"""Records that can't be what a clamp did: a reversed sign, other units than others, other settings than stated."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeclamp_identification.campaign.cycles import Cycles
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.signals.harmonics import cycle_harmonics
from pipeclamp_identification.units.doubts import StatedAndShown
from pipeclamp_models.base.arrays import Array, ComplexArray
from pipeclamp_models.base.digits import plain
from pipeclamp_models.base.said import few_of

MOST_NAMED = 3
"""Runs that a sentence names."""
SURE_STANDARD_ERRORS = 3.0
"""Standard errors by which something must be negative: a clamp without loss shows either sign."""
BEYOND_DOUBT = 5.0
"""Standard errors by which a loop must make energy, or its force fall with the displacement, to be told: of hundreds
without loss, or without stiffness, none does so by chance."""
WRONG_UNITS = 100.0
"""Factor between a run's dynamic stiffness and that of most others that units make, whose prefixes differ by 1000. A
device whose force hardly follows the amplitude may span as much, but from run to run; hence also the next one."""
JUMP_FACTOR = 30.0
"""Factor to the next run that makes a jump: the middle, in logs, between one and a thousand."""
MISSING_MEAN_SHARE = 0.25
"""Of the second harmonic, below which a mean force is missing: half of the least that comes with it, for a record that
begins at rest may keep some of what its sensor has lost."""
CLEARLY_UNLIKE, STANDARD_ERRORS_OF_A_MEAN = 10.0, 2.0
"""Standard errors of the second harmonic by which it surely is one, and within which the mean force may be none: so a
mean of half the second harmonic is told from none."""
FEWEST_UNLIKE_ENDS = 4
"""Runs in which it must be so: a constant load may make up for the mean force of tests that are alike."""
STATED_APART = 0.2
"""Share by which a measured setting may differ from the stated one: drives miss by a few percent, and the fundamental
of a triangle is 19 % below its peak."""
PEAK_TO_PEAK = (0.45, 0.55)
"""Measured over stated amplitude where the stated one is from peak to peak."""


@dataclass(frozen=True)
class Fundamental:
    """What the first harmonics of a record's displacement and force say.

    Attributes:
        amplitude_mm: of the displacement.
        stiffness: F1/Y1 in N/mm, complex; the imaginary part is positive where energy is dissipated.
        standard_error: of its real and of its imaginary part each, at most, N/mm.
    """

    amplitude_mm: float
    stiffness: complex
    standard_error: float

    @property
    def dissipated_energy(self) -> float:
        """Energy in J that the fundamental dissipates in a cycle, pi A^2 Im(F1/Y1)."""
        return math.pi * self.amplitude_mm**2 * self.stiffness.imag / 1e3


@dataclass(frozen=True)
class EvenForce:
    """What of a record's force is alike at both ends of a cycle, in N: what presses more at one end makes all of it.

    Attributes:
        mean: over whole cycles.
        second: its second harmonic in the phase of the displacement, but for what the displacement's own makes.
        standard_error: of the second, the scatter from cycle to cycle and the drive's distortion counted.
    """

    mean: float
    second: float
    standard_error: float


@dataclass(frozen=True)
class CycleByCycle:
    """Mean and fundamental of each cycle, (cycles, 2) complex: displacement in mm, force in N."""

    displacement: ComplexArray
    force: ComplexArray

    @cached_property
    def stiffness(self) -> ComplexArray:
        """F1/Y1 of each cycle in N/mm; the imaginary part is positive where energy is dissipated."""
        return self.force[:, 1] / self.displacement[:, 1]


def cycle_by_cycle(record: Record, cycles: Cycles) -> CycleByCycle:
    """Give mean and fundamental of each steady cycle of a record that `check_samples` has passed."""
    y, force = record.displacement_mm[cycles.steady], record.force_N[cycles.steady]
    bounds = cycles.bounds - cycles.bounds[0]
    return CycleByCycle(*cycle_harmonics(cycles.phase(record), bounds, [y, force], 1))


def fundamental_of(record: Record, cycles: Cycles, known: CycleByCycle | None = None) -> Fundamental:
    """Give a record's fundamental, with the scatter from cycle to cycle and what noise makes of it.

    Args:
        record: samples that `check_samples` has passed.
        cycles: its steady cycles.
        known: `cycle_by_cycle` of them, where it is known already.
    """
    known = known or cycle_by_cycle(record, cycles)
    force = record.force_N[cycles.steady]
    Y, F, per_cycle = known.displacement[:, 1], known.force[:, 1], known.stiffness
    amplitude = float(np.mean(np.abs(Y)))
    # what the fundamental leaves of the force is taken for noise, so that a single cycle has a standard error too
    rest = max(float(np.var(force)) - float(np.mean(np.abs(F))) ** 2 / 2, 0.0)
    noise = math.sqrt(2 * rest / len(force)) / amplitude
    scatter = float(np.std(per_cycle, ddof=1)) / math.sqrt(cycles.count) if cycles.count > 1 else 0.0
    return Fundamental(amplitude, complex(np.mean(per_cycle)), math.hypot(noise, scatter))


def even_force_of(record: Record, cycles: Cycles, shown: Fundamental) -> EvenForce:
    """Give what of a record's force is alike at both ends of a cycle.

    Harmonics are fitted together, so that the mean beside a second one is another than that of `cycle_by_cycle`.

    Args:
        record: samples that `check_samples` has passed.
        cycles: its steady cycles.
        shown: its fundamental.
    """
    y, force = record.displacement_mm[cycles.steady], record.force_N[cycles.steady]
    Y, F = cycle_harmonics(cycles.phase(record), cycles.bounds - cycles.bounds[0], [y, force], 2)
    own = shown.stiffness * Y[:, 2]
    second = ((F[:, 2] - own) * np.conj(Y[:, 1] / np.abs(Y[:, 1])) ** 2).real
    single = shown.standard_error * shown.amplitude_mm
    scatter = float(np.std(second, ddof=1)) / math.sqrt(cycles.count) if cycles.count > 1 else single
    # the stiffness at twice the frequency is another one
    error = math.hypot(scatter, abs(np.mean(own)))
    return EvenForce(float(np.mean(F[:, 0].real)), float(np.mean(second)), error)


def lack_means(even: Sequence[EvenForce]) -> bool:
    """Tell whether the means of forces are missing, as from a sensor that passes none.

    Whatever presses, holds or damps more on one side makes a mean force and a second harmonic together: of y^2, v^2 and
    all that goes with them as much of both, of a stop that is touched for a moment half as much, of one touched for
    half the cycle half as much again.

    Args:
        even: of all runs.
    """
    # a run's scatter from few cycles is rough: it counts as that of the run in the middle at least
    usual = float(np.median([one.standard_error for one in even])) if even else 0.0
    doubts = [max(one.standard_error, usual) for one in even]
    sure = [abs(one.second) > CLEARLY_UNLIKE * doubt for one, doubt in zip(even, doubts, strict=True)]
    if sum(sure) < FEWEST_UNLIKE_ENDS:
        return False
    most = max(abs(one.second) for one in even)
    return all(
        abs(one.mean) <= MISSING_MEAN_SHARE * (abs(one.second) if clear else most) + STANDARD_ERRORS_OF_A_MEAN * doubt
        for one, doubt, clear in zip(even, doubts, sure, strict=True)
    )


def implausible(shown: Mapping[str, Fundamental]) -> dict[str, str]:
    """Give the runs whose records can't be used for what they show, with the reason; fundamentals by run."""
    units = zip(shown, other_units(list(shown.values())), strict=True)
    signs = {run: reversed_sign(fundamental) for run, fundamental in shown.items()}
    return {run: reason for run, unit in units if (reason := signs[run] or unit)}


def reversed_sign(fundamental: Fundamental) -> str | None:
    """Say that a record's force has the wrong sign; None where it hasn't.

    Inertia makes the stiffness negative and a delay the dissipated energy; both at once only a reversed channel does.
    """
    k, energy = fundamental.stiffness, fundamental.dissipated_energy
    if max(k.real, k.imag) >= -SURE_STANDARD_ERRORS * fundamental.standard_error:
        return None
    return (
        f"its force has the wrong sign: stiffness {plain(k.real, 4)} N/mm and {plain(energy, 3)} J "
        "dissipated a cycle, both negative; force is positive with positive displacement: turn its sign in the record, "
        'or in all of them by [columns] force_N = { from = "...", factor = -1 } in campaign.toml'
    )


def makes_energy(shown: Mapping[str, Fundamental]) -> str:
    """Say in how many runs the loop makes energy, beyond scatter, as no passive device does; empty where none does.

    Args:
        shown: fundamentals by run, of those that can be used.
    """
    making = _surely_negative(shown, lambda stiffness: stiffness.imag)
    if not making:
        return ""
    worst = making[0]
    makes = "loops make" if len(making) > 1 else "loop makes"
    k = shown[worst].stiffness
    # of a force that is a sine, dW over 2 pi times the energy stored at most
    loss = k.imag / abs(k)
    of_worst = f"loss factor {loss:.2g} of its fundamental, {plain(shown[worst].dissipated_energy, 3)} J a cycle"
    return (
        f"in {len(making)} of {len(shown)} runs the {makes} energy, most in run {worst!r} ({of_worst}), as no passive "
        "device does: check the sign of force and displacement, the order of the columns, and a delay between the "
        "channels"
    )


def falls_with_displacement(shown: Mapping[str, Fundamental]) -> str:
    """Say in how many runs the force falls with the displacement, beyond scatter; empty where it does in none.

    Args:
        shown: fundamentals by run, of those that can be used.
    """
    falling = _surely_negative(shown, lambda stiffness: stiffness.real)
    if not falling:
        return ""
    worst = falling[0]
    return (
        f"in {len(falling)} of {len(shown)} runs the force falls with the displacement, most in run {worst!r} "
        f"({plain(shown[worst].stiffness.real, 4)} N/mm): a mass between the device and the force sensor makes that, "
        "or a mass in the device, a long delay between the channels, or another column than the force"
    )


def _surely_negative(shown: Mapping[str, Fundamental], part: Callable[[complex], float]) -> list[str]:
    """Give the runs in which a part of the dynamic stiffness is negative beyond doubt, that of the largest share first.

    A run's scatter from few cycles is rough: it counts as that of the run in the middle at least.
    """
    size = {run: abs(one.stiffness) for run, one in shown.items() if one.stiffness}
    share = {run: part(shown[run].stiffness) / size[run] for run in size}
    doubt = {run: shown[run].standard_error / size[run] for run in size}
    usual = float(np.median([*doubt.values()])) if doubt else 0.0
    negative = [run for run in size if share[run] < -BEYOND_DOUBT * max(doubt[run], usual)]
    return sorted(negative, key=share.__getitem__)


def other_units(fundamentals: Sequence[Fundamental]) -> list[str | None]:
    """Say of each run whether its force or displacement is in other units than in most runs; None where it isn't."""
    size = np.array([abs(fundamental.stiffness) for fundamental in fundamentals])
    known = size > SURE_STANDARD_ERRORS * np.array([fundamental.standard_error for fundamental in fundamentals])
    found: list[str | None] = [None] * len(size)
    if not np.any(known):
        return found
    order = np.flatnonzero(known)[np.argsort(size[known], kind="stable")]
    groups = np.split(order, np.flatnonzero(size[order][1:] > JUMP_FACTOR * size[order][:-1]) + 1)
    most = max(groups, key=len)
    if 2 * len(most) <= len(order):
        return found
    usual = float(np.median(size[most]))
    for row in np.setdiff1d(order, most):
        if max(size[row] / usual, usual / size[row]) >= WRONG_UNITS:
            found[row] = (
                f"its dynamic stiffness is {plain(size[row], 4)} N/mm, the median of the others {plain(usual, 4)} "
                "N/mm: check the units of force (N) and displacement (mm)"
            )
    return found


def unless_contradicted(stated: float | None, shown: float) -> float | None:
    """Give a stated setting; None where the record shows another."""
    return stated if stated is not None and abs(shown - stated) <= STATED_APART * stated else None


def contradiction(column: str, settings: Mapping[str, StatedAndShown]) -> str:
    """Say that records show other settings than runs.csv states in a column, by runs; empty where they don't."""
    wrong = {
        run: (stated, shown)
        for run, (stated, shown) in settings.items()
        if stated and unless_contradicted(stated, shown) is None
    }
    if not wrong:
        return ""
    stated, shown = np.array([*wrong.values()]).T
    ratio = float(np.median(shown / stated))
    low, high = PEAK_TO_PEAK
    asked = " (stated from peak to peak?)" if column == "amplitude_mm" and low < ratio < high else ""
    return (
        f"{column} in runs.csv is {_span(stated)}, the records show {_span(shown)}, {plain(ratio, 2)} times as much, "
        f"in {len(wrong)} of {len(settings)} runs ({few_of([*wrong], MOST_NAMED)}){asked}; "
        "what the records show is used"
    )


def _span(values: Array) -> str:
    low, high = plain(float(np.min(values)), 3), plain(float(np.max(values)), 3)
    return low if low == high else f"{low} to {high}"
