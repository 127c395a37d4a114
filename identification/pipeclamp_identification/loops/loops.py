"""Loops: those of a campaign's runs, or of their cycles, stacked into arrays."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Generic, TypeVar

import numpy as np
import numpy.typing as npt

from pipeclamp_identification.campaign.drive import Kinematics
from pipeclamp_identification.campaign.reading import Campaign, Run
from pipeclamp_identification.loops.at_rest import deny_constant_force
from pipeclamp_identification.loops.loop import Loop, loop_of
from pipeclamp_identification.loops.scatter import DRIFT_AMONG_DRIFTS_BY_CHANCE, DRIFT_BY_CHANCE, drift_alike
from pipeclamp_identification.signals.reversals import Bridged
from pipeclamp_models.base.arrays import Array, ComplexArray
from pipeclamp_models.base.threads import in_threads

HIGHEST_HARMONIC = 20
"""H, the highest harmonic that is kept."""
PRELOADED = 0.8
"""Share of the squared force that mean forces hold, above which most of it is a constant load: their rms is twice
that of the rest, and a force with y^2 alone, more of a mean than any clamp makes of its motion, has 2/3."""

Number = TypeVar("Number", bound=np.generic)
Entry = TypeVar("Entry")


class _Stacked(cached_property[npt.NDArray[Number]], Generic[Number]):
    """What each row holds under the same name, as one array, stacked when it is first asked for."""

    def __init__(self) -> None:
        super().__init__(lambda loops: np.array(_of_rows(loops, self.attrname)))


class _Listed(cached_property[tuple[Entry, ...]], Generic[Entry]):
    """What each row holds under the same name, where rows differ in length."""

    def __init__(self) -> None:
        super().__init__(lambda loops: tuple(_of_rows(loops, self.attrname)))


def _of_rows(loops: Loops, name: str | None) -> list[Any]:
    return [getattr(row, str(name)) for row in loops.rows]


@dataclass(frozen=True)
class Loops:
    """The loops of a campaign, one row per run (or, from `per_cycle`, one per run and cycle); R rows, H harmonics.

    Arrays stack what `Loop` says of each row, under the same names.
    """

    rows: tuple[Loop, ...]
    force_average: float = 0.0
    """Share of the period over which the force was averaged before it was recorded."""
    time_measured: bool = True
    """Whether seconds are seconds; otherwise speeds and frequencies mean nothing."""

    run = _Listed[str]()
    specimen = _Listed[str | None]()
    cycle = _Stacked[np.float64]()
    """(R,) load cycles that the specimen had seen at the middle of the row."""
    amplitude_mm = _Stacked[np.float64]()
    frequency_Hz = _Stacked[np.float64]()
    temperature_K = _Stacked[np.float64]()
    density_g_cm3 = _Stacked[np.float64]()
    displacement = _Stacked[np.complex128]()
    """(R, H + 1) mm."""
    force = _Stacked[np.complex128]()
    """(R, H + 1) N."""
    force_standard_error = _Stacked[np.float64]()
    """(R, H + 1) N."""
    noise_rms_N = _Stacked[np.float64]()
    scatter_rms_N = _Stacked[np.float64]()
    scatter_by_phase = _Stacked[np.float64]()
    """(R, PHASE_BINS)."""
    force_rms_N = _Stacked[np.float64]()
    force_at_rest_N = _Stacked[np.float64]()
    samples = _Stacked[np.float64]()
    cycles = _Listed[Array]()
    displacement_per_cycle = _Listed[ComplexArray]()
    force_per_cycle = _Listed[ComplexArray]()
    phases = _Listed[Array]()
    at_reversals = _Listed[Bridged]()
    shows_scatter = _Listed[bool]()

    @cached_property
    def conditions(self) -> Mapping[str, Array]:
        """Return the further conditions by name, (R,) each."""
        names = self.rows[0].conditions
        return {name: np.array([row.conditions[name] for row in self.rows]) for name in names}

    @property
    def noise_nrmse(self) -> float:
        """Return the part of the force, over all samples, that is not periodic: no law can explain it."""
        noise = np.sum(self.samples * self.noise_rms_N**2)
        return math.sqrt(noise / np.sum(self.samples * self.force_rms_N**2))

    @property
    def mean_share(self) -> float:
        """Return the share of the squared force, over all samples, that the rows' mean forces hold: a preload."""
        means = np.sum(self.samples * self.force[:, 0].real ** 2)
        return float(means / np.sum(self.samples * self.force_rms_N**2))

    @cached_property
    def deny_constant_force(self) -> bool:
        """Return whether the forces at rest before the tests deny that a part of the mean forces is constant."""
        _, first = np.unique(self.run, return_index=True)
        return deny_constant_force(
            self.force_at_rest_N[first], self.force[first, 0].real, self.force_standard_error[first, 0]
        )


def loops_of(campaign: Campaign) -> Loops:
    """Turn a campaign's records into loops.

    Args:
        campaign: as `read_campaign` returns it.

    Returns:
        One row per usable run, in the campaign's order.
    """
    average = campaign.smoothing.displacement
    size = sum(len(run.record.time_s) for run in campaign.runs) / max(len(campaign.runs), 1)

    def rows(drift_by_chance: float) -> list[Loop]:
        def row(run: Run) -> Loop:
            return loop_of(run, campaign.condition_columns, HIGHEST_HARMONIC, average, drift_by_chance)

        return in_threads(row, campaign.runs, size)

    found = rows(DRIFT_BY_CHANCE)
    if drift_alike([row.force_per_cycle for row in found]):
        found = rows(DRIFT_AMONG_DRIFTS_BY_CHANCE)
    return Loops(tuple(found), campaign.smoothing.force, campaign.time_measured)


def per_cycle(loops: Loops) -> Loops:
    """Return loops with one row per run and cycle, for effects that change from cycle to cycle.

    Args:
        loops: one row per run.

    Returns:
        One row per cycle, the runs' cycles one after another; standard errors are those of a single cycle.
    """
    cycles = tuple(cycle for row in loops.rows for cycle in row.by_cycle())
    return Loops(cycles, loops.force_average, loops.time_measured)


def by_stretch(loops: Loops) -> Loops:
    """Return loops with up to three rows a run, each of a stretch of its cycles, for what changes along a record.

    Args:
        loops: one row per run; loops that are in stretches already stay as they are.

    Returns:
        One row a stretch, the runs' stretches one after another; standard errors are those of their own cycles.
    """
    if len(np.unique(loops.run)) < len(loops.run):
        return loops
    stretches = tuple(stretch for row in loops.rows for stretch in row.by_stretch())
    return Loops(stretches, loops.force_average, loops.time_measured)


def one_row_a_run(loops: Loops) -> Loops:
    """Return loops with one row for each run, in the order of their names: of its stretches the middle one."""
    order = np.argsort(loops.run, kind="stable")
    first, rows = np.unique(np.asarray(loops.run)[order], return_index=True, return_counts=True)[1:]
    middle = order[first + rows // 2]
    return Loops(tuple(loops.rows[place] for place in middle.tolist()), loops.force_average, loops.time_measured)


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
    terms = harmonics * (1j * order) ** derivative
    # the real part alone, which is half of a complex product's work
    return np.asarray(terms.real @ phasors.real - terms.imag @ phasors.imag)


def displacement_on_grid(loops: Loops, count: int) -> Kinematics:
    """Return displacement, velocity and acceleration over one cycle.

    Args:
        loops: R rows.
        count: number of points theta_j = 2 pi j/count.

    Returns:
        y (R, count) mm, v (R, count) mm/s, a (R, count) mm/s2.
    """
    speed = 2 * np.pi * loops.frequency_Hz[:, None]
    y, slope, curvature = (on_grid(loops.displacement, count, derivative) for derivative in range(3))
    return Kinematics(y, speed * slope, speed**2 * curvature)
