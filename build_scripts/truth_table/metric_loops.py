"""The virtual rig that keeps dW and W only: its test plans, its errors, and what a paper would print of its loops."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from hidden import COLUMN
from rig import BETWEEN_STARTS, DENSITIES, LEVELS
from truth import SUBSTEPS, Array, Motion, drive

Condition = tuple[float, float, float]


def cross(A: float, f: float, T: float) -> tuple[Condition, ...]:
    """Give a plan that varies one of A mm, f Hz, T degC at a time, through this condition: 11 as in the paper."""
    found = [(A, one, T) for one in (1.0, 2.0, 3.0, 4.0, 5.0)]
    found += [(one, f, T) for one in (0.2, 0.5, 0.8, 1.0) if one != A]
    return (*found, *((A, f, one) for one in (20.0, 100.0, 200.0, 300.0) if one != T))


PLANS: Mapping[str, tuple[Condition, ...]] = {
    "cross of 11": cross(0.8, 3.0, 20.0),
    "three crosses": tuple(dict.fromkeys((*cross(0.8, 3.0, 20.0), *cross(0.5, 2.0, 200.0), *cross(0.2, 5.0, 300.0)))),
    "grid of 48": tuple(itertools.product((0.2, 0.5, 0.8, 1.0), (1.0, 3.0, 5.0), (20.0, 100.0, 200.0, 300.0))),
}
"""Test plans as conditions (A mm, f Hz, T degC), one row each."""
CYCLES = 5
"""Load cycles of a run, the last of which is kept."""
SAMPLES = 64
"""Samples per cycle, each in SUBSTEPS fine steps."""
DIGITS = 4
"""Significant digits that are printed."""


@dataclass(frozen=True)
class Errors:
    """What makes rows scatter, standard deviations.

    Attributes:
        amplitude: share by which the rig misses an amplitude that is printed as it was set.
        temperature: degC, likewise.
        stiffness, damping: share by which the clamp differs from run to run.
        reading: share by which dW and W are read wrongly, each by itself.
        distortion: share of the drive's second and third harmonic.
    """

    amplitude: float = 0.0
    temperature: float = 0.0
    stiffness: float = 0.0
    damping: float = 0.0
    reading: float = 0.0
    distortion: float = 0.0

    def times(self, factor: float) -> Errors:
        """Give what scatters, larger by a factor; the drive's distortion stays, for it is the same in every run."""
        return Errors(
            self.amplitude * factor, self.temperature * factor, self.stiffness * factor, self.damping * factor,
            self.reading * factor, self.distortion,
        )  # fmt: skip


@dataclass(frozen=True)
class Luck:
    """What is drawn once for a campaign of R rows, so that larger errors are the same ones, enlarged.

    Attributes:
        motion: standard normal, of amplitude and temperature, (R, 2).
        run: standard normal, of what differs from run to run, (R, 4).
        reading: standard normal, of dW and W, (R, 2).
        angles: phases of the drive's second and third harmonic.
        order: in which the rows are run, (R,).
    """

    motion: Array
    run: Array
    reading: Array
    angles: Array
    order: npt.NDArray[np.intp]


def draw_luck(random: np.random.Generator, rows: int) -> Luck:
    """Draw what errors are made of."""
    return Luck(
        random.standard_normal((rows, 2)), random.standard_normal((rows, 4)), random.standard_normal((rows, 2)),
        random.uniform(0.0, 2 * np.pi, 2), random.permutation(rows),
    )  # fmt: skip


@dataclass(frozen=True)
class Series:
    """The runs of one frequency: their places in the plan, and their motion."""

    places: npt.NDArray[np.intp]
    motion: Motion


def driven(plan: Sequence[Condition], luck: Luck, errors: Errors, needs: frozenset[str]) -> list[Series]:
    """Drive all rows of a plan.

    Args:
        plan: the conditions, R rows.
        luck: what the errors are made of.
        errors: how large they are.
        needs: what varies besides: "density", "condition", "cycles".
    """
    A, f, T = np.array(plan).T
    A = A * (1 + errors.amplitude * luck.motion[:, 0])
    T = T + errors.temperature * luck.motion[:, 1] + 273.15
    further = besides(luck.order, needs)
    result = []
    for frequency in np.unique(f):
        places = np.flatnonzero(f == frequency)
        tones = {1: A[places].astype(np.complex128)}
        for number, angle in enumerate(luck.angles, 2):
            tones[number] = A[places] * errors.distortion * np.exp(1j * angle)
        time, y, v, a = drive(tones, float(frequency), SAMPLES * float(frequency), CYCLES * SAMPLES)
        rho, u, seen = (further[name][places, None] for name in ("density_g_cm3", COLUMN, "first_cycle"))
        result.append(
            Series(
                places,
                Motion(
                    time, y, v, a, tuple(tones.items()), A[places, None], T[places, None], rho, u, seen,
                    float(frequency), luck.run[places],
                ),
            )
        )  # fmt: skip
    return result


def besides(order: npt.NDArray[np.intp], needs: frozenset[str]) -> dict[str, Array]:
    """Give what varies besides A, f and T by its column, (R,); nan, or 0 cycles, where it doesn't.

    Args:
        order: in which the rows are run, (R,).
        needs: what varies.
    """
    rows = np.arange(len(order))
    return {
        "density_g_cm3": np.where("density" in needs, np.array(DENSITIES)[(rows + rows // 3) % 3], np.nan),
        COLUMN: np.where("condition" in needs, np.array(LEVELS)[(rows // 2 + rows // 5) % 3], np.nan),
        "first_cycle": np.where("cycles" in needs, BETWEEN_STARTS * order, 0.0),
    }


def energies(motion: Motion, force: Array) -> Array:
    """Give dW and W in J of the last cycle of each run, (R, 2): the loop's area, and a quarter of F's range times y's.

    Args:
        motion: of R runs in fine steps.
        force: on it, N, (R, n).
    """
    last = slice(-SAMPLES * SUBSTEPS - 1, None)
    y, F = motion.y[:, last], force[:, last]
    area = np.sum(np.diff(y, axis=1) * (F[:, 1:] + F[:, :-1]) / 2, axis=1)
    return np.stack([area, np.ptp(F, axis=1) * np.ptp(y, axis=1) / 8], axis=1) / 1e3


def printed(plan: Sequence[Condition], values: Array, order: npt.NDArray[np.intp], needs: frozenset[str]) -> str:
    """Give the runs.csv that a paper would leave: conditions as they were set, dW and W rounded.

    Args:
        plan: the conditions, R rows.
        values: dW and W in J, (R, 2).
        order: in which the rows were run.
        needs: what varied besides.
    """
    names = {"density": "density_g_cm3", "condition": COLUMN, "cycles": "first_cycle"}
    further = besides(order, needs)
    # the loop that is kept is the last one of its run
    further["first_cycle"] = further["first_cycle"] + CYCLES - 0.5
    columns = {names[need]: further[names[need]] for need in sorted(needs)}
    header = ["run", "amplitude_mm", "frequency_Hz", "temperature_C", *columns]
    lines = [",".join([*header, "dissipated_energy_J", "max_elastic_energy_J"])]
    for row, (condition, energy) in enumerate(zip(plan, values, strict=True)):
        cells = [f"{one:g}" for one in (*condition, *(column[row] for column in columns.values()))]
        lines.append(",".join([f"r{row}", *cells, *(f"{one:#.{DIGITS}g}" for one in energy)]))
    return "\n".join(lines) + "\n"
