"""Breakdowns of a law's squared error: along the loop, by harmonic, along cycles, by condition.

Every breakdown parts the same whole: its parts' squared errors add up to that of all samples. Beside each stands the
scatter that no law can explain, and the force that the part would have if every run's were spread evenly over its
samples, by which errors of parts of unequal size compare.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.comparison.conditions import Condition
from pipeclamp_identification.comparison.error_parts import Breakdown, ErrorPart
from pipeclamp_identification.comparison.sums import RunSums
from pipeclamp_identification.loops.loops import HIGHEST_HARMONIC, Loops
from pipeclamp_identification.loops.scatter import PHASE_BINS
from pipeclamp_models.base.arrays import Array, ComplexArray

LOOP_PLACES = (
    ("just after the reversal", 0.0, 30.0),
    ("between reversal and middle", 30.0, 75.0),
    ("through the middle", 75.0, 105.0),
    ("between middle and reversal", 105.0, 150.0),
    ("just before the reversal", 150.0, 180.0),
)
"""Where a sample lies between two turning points, in degrees of phase after the last one; 30 of them hold the last
13 % of the displacement."""
BRANCHES = ("unloading", "loading")
"""The displacement falls from its largest value, then rises again."""
MOST_CYCLES_SINGLY = 12
"""More cycles than this are grouped."""


@dataclass(frozen=True)
class Drift:
    """By how much the measured force drifts against the law from a record's first cycle to its last, pooled over runs.

    Attributes:
        in_phase, in_quadrature: of the first harmonic, as a share of it: stiffness and damping.
        standard_error: of both, from what doesn't follow the line.
    """

    in_phase: float
    in_quadrature: float
    standard_error: float


def phase_edges(index: int) -> tuple[float, float]:
    """Give where a part of the cycle begins and ends, degrees after the largest displacement."""
    return 360.0 * index / PHASE_BINS, 360.0 * (index + 1) / PHASE_BINS


def place_of(index: int) -> tuple[int, int]:
    """Give the place (of LOOP_PLACES) and the branch (of BRANCHES) in which a part of the cycle lies."""
    middle = sum(phase_edges(index)) / 2
    since = middle % 180.0
    return next(place for place, (_, _, end) in enumerate(LOOP_PLACES) if since < end), int(middle // 180.0)


def excess_table(sums: Sequence[RunSums]) -> tuple[Array, Array]:
    """Give squared error beyond scatter, and evenly spread squared force, N2, shape (R, PHASE_BINS) each."""
    known = _known(sums)
    error = np.array([run.by_phase - (run.scatter_by_phase if known else 0.0) for run in sums])
    force = np.array([run.squared_force / run.samples * run.samples_by_phase for run in sums])
    return error, force


def along_loop(sums: Sequence[RunSums]) -> Breakdown:
    """Break the error down by phase, in PHASE_BINS equal parts of the cycle."""
    labels = ["{:g} to {:g} deg".format(*phase_edges(index)) for index in range(PHASE_BINS)]
    return Breakdown("phase", _phase_parts(sums, labels, list(range(PHASE_BINS))))


def by_place(sums: Sequence[RunSums]) -> Breakdown:
    """Break the error down by place between turning points and by branch."""
    labels = [f"{place}, {branch}" for branch in BRANCHES for place, *_ in LOOP_PLACES]
    places = [place + len(LOOP_PLACES) * branch for place, branch in map(place_of, range(PHASE_BINS))]
    return Breakdown("place in the loop", _phase_parts(sums, labels, places))


def by_branch(sums: Sequence[RunSums]) -> Breakdown:
    """Break the error down into loading and unloading."""
    return Breakdown("branch", _phase_parts(sums, list(BRANCHES), [place_of(index)[1] for index in range(PHASE_BINS)]))


def _phase_parts(sums: Sequence[RunSums], labels: Sequence[str], part_of_bin: Sequence[int]) -> tuple[ErrorPart, ...]:
    def total(by_phase: Array) -> Array:
        return np.bincount(part_of_bin, by_phase, len(labels)).astype(np.float64)

    error = total(np.sum([run.by_phase for run in sums], axis=0))
    scatter = total(np.sum([run.scatter_by_phase for run in sums], axis=0))
    force = total(np.sum(excess_table(sums)[1], axis=0))
    return _parts(labels, error, scatter, force, sums)


def by_harmonic(sums: Sequence[RunSums]) -> Breakdown:
    """Break the error down by harmonic, in phase and in quadrature with the displacement.

    What the harmonics leave, higher ones and what doesn't repeat with the cycle, is the last part.
    """
    error = np.zeros((HIGHEST_HARMONIC + 1, 2))
    scatter = np.zeros((HIGHEST_HARMONIC + 1, 2))
    for run in sums:
        carried = slice(0, run.harmonics.shape[1])
        error[carried] += run.samples * _mean_squares(run.harmonics)
        if run.scatter_known:
            # a cycle differs from the next by the scatter of both, and by next to nothing of a drift
            scatter[carried] += run.samples * _mean_squares(np.diff(run.harmonics, axis=0)) / 2
        else:
            # white noise has the same power in each of the cycle's degrees of freedom
            scatter[carried] += run.squared_scatter / run.samples
    # the mean has no part in quadrature
    in_harmonics, scatter_in_harmonics = np.delete(error.ravel(), 1), np.delete(scatter.ravel(), 1)
    whole, noise = sum(run.squared_error for run in sums), sum(run.squared_scatter for run in sums)
    # in records with gaps the harmonics are not quite orthogonal, and can hold more than the whole
    in_harmonics *= min(1.0, whole / max(float(np.sum(in_harmonics)), 1e-300))
    labels = ["mean force"]
    for order in range(1, HIGHEST_HARMONIC + 1):
        labels += [f"harmonic {order} in phase", f"harmonic {order} in quadrature"]
    labels.append("higher harmonics, or not periodic")
    rest = max(whole - float(np.sum(in_harmonics)), 0.0)  # round-off may make it negative
    scatter_in_rest = max(noise - np.sum(scatter_in_harmonics), 0.0)
    force = np.full(len(labels), sum(run.squared_force for run in sums))
    return Breakdown(
        "harmonic",
        _parts(labels, np.append(in_harmonics, rest), np.append(scatter_in_harmonics, scatter_in_rest), force, sums),
    )


def harmonic_index(order: int, quadrature: bool) -> int:
    """Give where a harmonic stands among the parts of `by_harmonic`: the mean, 1 in phase, 1 in quadrature, 2 ..."""
    return max(2 * order - 1, 0) + int(quadrature)


def squared_harmonics(sums: Sequence[RunSums], loops: Loops) -> tuple[Array, Array]:
    """Give the squared force by harmonic, in phase and in quadrature, of all samples: measured, and by the law.

    Args:
        sums: of each run.
        loops: the same runs.

    Returns:
        N2, shape (HIGHEST_HARMONIC + 1, 2) each.
    """
    measured, computed = np.zeros((HIGHEST_HARMONIC + 1, 2)), np.zeros((HIGHEST_HARMONIC + 1, 2))
    for run, force in zip(sums, loops.force_per_cycle, strict=True):
        carried = run.harmonics.shape[1]
        for square, harmonics in ((measured, force[:, :carried]), (computed, force[:, :carried] - run.harmonics)):
            square[:carried] += _mean_squares(harmonics) * run.samples
    return measured, computed


def _mean_squares(harmonics: ComplexArray) -> Array:
    """Give the mean square that each harmonic makes, in phase and in quadrature: X^2/2, X_0^2; shape (H + 1, 2)."""
    parts = np.stack([harmonics.real, harmonics.imag], axis=-1)
    weight = np.where(np.arange(harmonics.shape[1]) > 0, 0.5, 1.0)[:, None]
    return np.asarray(weight * np.mean(parts**2, axis=0))


def cycle_edges(sums: Sequence[RunSums]) -> list[int]:
    """Give where groups of cycles begin, and where the last one ends, counted from 0 within the record."""
    longest = max(len(run.by_cycle) for run in sums)
    return sorted({round(edge) for edge in np.linspace(0, longest, min(longest, MOST_CYCLES_SINGLY) + 1)})


def along_cycles(sums: Sequence[RunSums]) -> Breakdown:
    """Break the error down by the number of the cycle within its record, 1 the first steady one."""
    parts = []
    for first, end in itertools.pairwise(cycle_edges(sums)):
        chosen = [run for run in sums if len(run.by_cycle) > first]
        samples = [float(np.sum(run.samples_by_cycle[first:end])) / run.samples for run in chosen]
        scatter = sum(share * run.squared_scatter for share, run in zip(samples, chosen, strict=True))
        parts.append(
            ErrorPart(
                f"cycle {first + 1}" if end == first + 1 else f"cycles {first + 1} to {end}",
                sum(float(np.sum(run.by_cycle[first:end])) for run in chosen),
                scatter if _known(chosen) else None,
                sum(share * run.squared_force for share, run in zip(samples, chosen, strict=True)),
                len(chosen),
            )
        )
    return Breakdown("cycle within the record", tuple(parts))


def amplitude_along_cycles(sums: Sequence[RunSums], loops: Loops) -> tuple[Array, Array]:
    """Give the amplitude of the force's first harmonic cycle by cycle, measured and by the law, mean over runs.

    Returns:
        each as a share of its own mean over the record, shape (cycles of the longest record,).
    """
    longest = max(len(run.by_cycle) for run in sums)
    total, count = np.zeros((2, longest)), np.zeros(longest)
    for run, force in zip(sums, loops.force_per_cycle, strict=True):
        amplitude = np.abs([force[:, 1], force[:, 1] - run.harmonics[:, 1]])
        total[:, : len(force)] += amplitude / np.mean(amplitude, axis=1, keepdims=True)
        count[: len(force)] += 1
    measured, computed = total / count
    return measured, computed


def drift(sums: Sequence[RunSums]) -> Drift | None:
    """Give the drift within records; None where too few cycles show one."""
    across, along, free = [], [], 0
    for run in sums:
        count = len(run.by_cycle)
        if count > 1:
            along.append(np.arange(count) / (count - 1) - 0.5)
            relative = run.harmonics[:, 1] / run.fundamental_N
            across.append(relative - np.mean(relative))
            free += count - 1
    if free < 3:
        return None
    x, error = np.concatenate(along), np.concatenate(across)
    slope = complex(x @ error / (x @ x))
    variance = float(np.sum(np.abs(error - slope * x) ** 2)) / (2 * (free - 1))
    return Drift(slope.real, slope.imag, math.sqrt(variance / float(x @ x)))


def by_condition(sums: Sequence[RunSums], condition: Condition) -> Breakdown:
    """Break the error down by the levels of a condition."""
    levels = condition.levels
    return Breakdown(
        condition.title, tuple(part_of_runs(level.label, [sums[row] for row in level.rows]) for level in levels)
    )


def part_of_runs(label: str, sums: Sequence[RunSums]) -> ErrorPart:
    """Give the part of the error that some runs have."""
    return ErrorPart(
        label,
        sum(run.squared_error for run in sums),
        sum(run.squared_scatter for run in sums) if _known(sums) else None,
        sum(run.squared_force for run in sums),
        len(sums),
    )


def _known(sums: Sequence[RunSums]) -> bool:
    return any(run.scatter_known for run in sums)


def _parts(
    labels: Sequence[str], error: Array, scatter: Array, force: Array, sums: Sequence[RunSums]
) -> tuple[ErrorPart, ...]:
    known = _known(sums)
    return tuple(
        ErrorPart(label, float(one), float(other) if known else None, float(even), len(sums))
        for label, one, other, even in zip(labels, error, scatter, force, strict=True)
    )
