"""Breakdowns of a law's squared error along free motions: over time, between turning points, by what the motion does.

As those of sines, each parts the same whole. What of a part is scatter nobody knows: no motion repeats.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeclamp_identification.campaign.free_motion import FreeRun
from pipeclamp_identification.comparison.breakdown import LOOP_PLACES
from pipeclamp_identification.comparison.conditions import Condition, stated_conditions
from pipeclamp_identification.comparison.error_parts import Breakdown, ErrorPart
from pipeclamp_identification.fitting.free_misfit import FreeMisfit
from pipeclamp_identification.signals.half_cycles import HalfCycles, half_cycles
from pipeclamp_identification.signals.levels import distinct_texts, name_levels
from pipeclamp_models.base.arrays import Array, IntArray

TIME_PARTS = 10
EQUAL_PARTS = 6
"""Equal parts of a record's time, and of the range of what the motion does, into which the error is broken down."""
STILL_SPEED_SHARE = 0.01
"""Share of a record's largest speed below which the clamp nearly stands still: 1 % of the speed of a sine is within 0.6
degrees of its reversals."""
TURN_BACK_SHARE = 0.1
"""Share of the tracked amplitude by which the motion must go back to have turned: ripple on a larger motion is none."""
SMALLEST_TURNING_SHARE = 0.01
"""Of a record's largest tracked amplitude: motions below it don't turn."""
STANDING = len(LOOP_PLACES)
"""The place, after those of LOOP_PLACES, of samples at which the clamp nearly stands still."""
PLACE_NAMES = (*(name for name, *_ in LOOP_PLACES), "nearly still")
DIRECTIONS = ("the displacement falls", "the displacement rises")
COMPONENTS = (
    "mean force",
    "in step with the displacement (stiffness)",
    "in step with the velocity (damping)",
    "in step with neither displacement nor velocity",
)


@dataclass(frozen=True)
class FreeSamples:
    """The error of one run, sample by sample, and where in the motion each sample lies."""

    misfit: FreeMisfit

    @cached_property
    def squared_error(self) -> Array:
        """N2, shape (n,)."""
        return np.asarray((self.misfit.measured - self.misfit.computed) ** 2)

    @cached_property
    def half_cycles(self) -> HalfCycles:
        """Where each sample lies between turning points."""
        amplitude = self.misfit.amplitude
        return half_cycles(
            self.misfit.y, np.maximum(TURN_BACK_SHARE * amplitude, SMALLEST_TURNING_SHARE * float(np.max(amplitude)))
        )

    @cached_property
    def place(self) -> IntArray:
        """The place of PLACE_NAMES, shape (n,)."""
        ends = np.array([end for *_, end in LOOP_PLACES])
        place = np.searchsorted(ends, self.half_cycles.degrees, side="right").clip(0, len(LOOP_PLACES) - 1)
        speed = np.abs(self.misfit.v)
        return np.asarray(np.where(speed < STILL_SPEED_SHARE * np.max(speed), STANDING, place))

    @property
    def direction(self) -> IntArray:
        """The direction of DIRECTIONS, shape (n,)."""
        return np.asarray(self.half_cycles.rising, dtype=np.intp)

    def time_part(self, parts: int = TIME_PARTS) -> IntArray:
        """Give which of so many equal parts of the record's time each sample lies in, shape (n,)."""
        time = self.misfit.time
        return np.asarray(np.minimum(parts * time / time[-1], parts - 1), dtype=np.intp)


@dataclass(frozen=True)
class Classes:
    """Equal classes of a quantity over all runs.

    Attributes:
        name, unit: of the quantity.
        edges: shape (classes + 1,).
        of: the class of each sample, run by run.
    """

    name: str
    unit: str
    edges: Array
    of: tuple[IntArray, ...]

    @property
    def labels(self) -> list[str]:
        """What each class spans."""
        texts = distinct_texts(self.edges)
        return [f"{low} to {high}" for low, high in itertools.pairwise(texts)]


def classes_of(name: str, unit: str, values: Sequence[Array], count: int = EQUAL_PARTS) -> Classes:
    """Give equal classes over the range of a quantity; values by run, shape (n,) each."""
    low, high = min(float(np.min(one)) for one in values), max(float(np.max(one)) for one in values)
    edges = np.linspace(low, high if high > low else low + 1.0, count + 1)
    of = tuple(np.searchsorted(edges[1:-1], one, side="right") for one in values)
    return Classes(name, unit, edges, of)


def motion_classes(samples: Sequence[FreeSamples]) -> tuple[Classes, ...]:
    """Give the classes of what motions do: displacement, speed, tracked amplitude and frequency."""
    runs = [one.misfit for one in samples]
    return (
        classes_of("displacement", "mm", [run.y for run in runs]),
        speed_classes(samples),
        amplitude_classes(samples),
        classes_of("tracked frequency", "Hz", [run.frequency for run in runs]),
    )


def speed_classes(samples: Sequence[FreeSamples], count: int = EQUAL_PARTS) -> Classes:
    """Give classes of the speed."""
    return classes_of("speed", "mm/s", [np.abs(one.misfit.v) for one in samples], count)


def amplitude_classes(samples: Sequence[FreeSamples], count: int = EQUAL_PARTS) -> Classes:
    """Give classes of the tracked amplitude."""
    return classes_of("tracked amplitude", "mm", [one.misfit.amplitude for one in samples], count)


def by_time(samples: Sequence[FreeSamples]) -> Breakdown:
    """Break the error down by time within the record."""
    labels = [f"{100 * part // TIME_PARTS} to {100 * (part + 1) // TIME_PARTS}" for part in range(TIME_PARTS)]
    return _broken("time within the record / %", labels, samples, [one.time_part() for one in samples])


def by_free_place(samples: Sequence[FreeSamples]) -> Breakdown:
    """Break the error down by place between turning points."""
    return _broken("place between turning points", PLACE_NAMES, samples, [one.place for one in samples])


def by_direction(samples: Sequence[FreeSamples]) -> Breakdown:
    """Break the error down by the direction of the motion, between turning points."""
    return _broken("direction", DIRECTIONS, samples, [one.direction for one in samples])


def by_class(samples: Sequence[FreeSamples], classes: Classes) -> Breakdown:
    """Break the error down by classes of what the motion does."""
    return _broken(f"{classes.name} / {classes.unit}", classes.labels, samples, classes.of)


def by_component(samples: Sequence[FreeSamples]) -> Breakdown:
    """Break the error down into what is constant, goes with the displacement, with the velocity, and the rest.

    Run by run, each in what those before it leave.
    """
    error = np.zeros(len(COMPONENTS))
    for one in samples:
        run = one.misfit
        off = run.measured - run.computed
        basis = np.linalg.qr(np.stack([np.ones_like(run.y), run.y, run.v], axis=1))[0]
        error[:-1] += (off @ basis) ** 2
        error[-1] += max(float(off @ off - np.sum((off @ basis) ** 2)), 0.0)
    force = sum(one.misfit.squared_force for one in samples)
    parts = (
        ErrorPart(label, float(square), None, force, len(samples))
        for label, square in zip(COMPONENTS, error, strict=True)
    )
    return Breakdown("component", tuple(parts))


def by_free_condition(samples: Sequence[FreeSamples], condition: Condition) -> Breakdown:
    """Break the error down by the levels of a condition."""
    index = np.zeros(len(samples), dtype=np.intp)
    for place, level in enumerate(condition.levels):
        index[level.rows] = place
    rows = [np.full(len(one.misfit.time), place) for one, place in zip(samples, index, strict=True)]
    return _broken(condition.title, [level.label for level in condition.levels], samples, rows)


def free_conditions(runs: Sequence[FreeRun], misfits: Sequence[FreeMisfit]) -> tuple[Condition, ...]:
    """Give what varies from run to run of free motion: the run itself, and its conditions."""
    columns = runs[0].setup.conditions
    conditions = (
        Condition("run", "run", "", name_levels([run.name for run in runs]), ordered=False),
        *stated_conditions(
            np.array([misfit.temperature_K for misfit in misfits]),
            {
                "density_g_cm3": np.array([run.setup.density for run in runs]),
                "first_cycle": np.array([run.setup.first_cycle for run in runs]),
                **{name: np.array([run.setup.conditions[name] for run in runs]) for name in columns},
            },
            [run.setup.specimen for run in runs],
        ),
    )
    return tuple(condition for condition in conditions if condition.varies)


def _broken(by: str, labels: Sequence[str], samples: Sequence[FreeSamples], index: Sequence[IntArray]) -> Breakdown:
    """Sum up the error by parts; those that no sample lies in are left out."""
    count = len(labels)
    error, force, runs = np.zeros(count), np.zeros(count), np.zeros(count, dtype=np.intp)
    for one, part in zip(samples, index, strict=True):
        number = np.bincount(part, minlength=count)
        error += np.bincount(part, one.squared_error, count)
        force += number * (one.misfit.squared_force / len(part))
        runs += number > 0
    return Breakdown(
        by,
        tuple(
            ErrorPart(label, float(error[place]), None, float(force[place]), int(runs[place]))
            for place, label in enumerate(labels)
            if runs[place]
        ),
    )
