"""Runs to be picked on a page: their mean cycles and those of the laws, packed so that hundreds fit."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pipeclamp_identification.comparison.conditions import Condition
from pipeclamp_identification.comparison.drawn import MOST_POINTS, DrawnRun, drawn_runs
from pipeclamp_identification.comparison.laws import ComparedLaw
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.digits import rounded_to

OF_ALL_RUNS = 80_000
"""Points of all runs' cycles together: more make a page that is slow to open."""
LEAST_POINTS = 32
LARGEST_INT16 = 32_767


def explored(
    loops: Loops, laws: Sequence[ComparedLaw], conditions: Sequence[Condition], title: str
) -> Mapping[str, Any]:
    """Give what a page needs to draw any run under any of the laws.

    Args:
        loops: the tests.
        laws: each held against them, the one that the page is about last.
        conditions: A, f and those that vary further.
        title: of the tests, for those who can't see the map.
    """
    points = max(min(MOST_POINTS, OF_ALL_RUNS // len(loops.run)), LEAST_POINTS)
    A, f, *further = conditions
    shown = [A, f, *(condition for condition in further if condition.varies)]
    return {
        "title": title,
        "laws": [law.label for law in laws],
        "conditions": [
            {"title": condition.title, "labels": [level.label for level in condition.levels]} for condition in shown
        ],
        "runs": [
            _run(run, [_place(condition, row) for condition in shown], _words(shown, row))
            for row, run in enumerate(drawn_runs(loops, laws, points))
        ],
    }


def _place(condition: Condition, row: int) -> int:
    return next(place for place, level in enumerate(condition.levels) if row in level.rows)


def _words(conditions: Sequence[Condition], row: int) -> str:
    return ", ".join(
        f"{condition.name} {level.label} {condition.unit}".strip() if condition.unit else condition.words(level)
        for condition in conditions
        for level in [condition.level_of(row)]
    )


def _run(run: DrawnRun, levels: Sequence[int], words: str) -> Mapping[str, Any]:
    return {
        "run": run.run,
        "levels": levels,
        "words": words,
        "phase": _packed(run.phase),
        "y": _packed(run.y),
        "v": _packed(run.v),
        "measured": _packed(run.measured),
        "laws": [_packed(force) for force in run.laws],
        "scatter": None if run.scatter is None else [rounded_to(value, 3) for value in run.scatter],
        "squared_force": run.squared_force,
        "squared_error": run.squared_error,
        "squared_scatter": run.squared_scatter,
    }


def _packed(values: Array) -> Mapping[str, Any]:
    """Give samples as whole numbers of a step, two bytes each: finer than a picture shows."""
    step = float(np.max(np.abs(values))) / LARGEST_INT16 or 1.0
    return {"step": step, "int16": base64.b64encode(np.round(values / step).astype("<i2").tobytes()).decode("ascii")}
