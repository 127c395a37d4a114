"""The map: how far a law errs beyond scatter, over amplitude and frequency, at each level of a further condition."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pipeclamp_identification.comparison import breakdown
from pipeclamp_identification.comparison.conditions import Condition
from pipeclamp_identification.comparison.sums import RunSums

EDGES = (1.5, 2.3, 3.6, 5.5, 8.4, 13.0, 20.0)
"""Excess over scatter at which the colour changes: the scale of pages, to 30 by its logarithm, in eight steps."""
ERROR_EDGES = (0.005, 0.01, 0.02, 0.03, 0.05, 0.1, 0.2)
"""The same for errors as shares of the rms force, where no scatter is known."""


@dataclass(frozen=True)
class Cell:
    """The runs at one amplitude, frequency and further level.

    Attributes:
        runs: their names.
        error, scatter: as shares of the rms force; None where not known.
    """

    runs: tuple[str, ...]
    error: float | None
    scatter: float | None

    @property
    def excess(self) -> float | None:
        """Error over scatter: 1 is as good as can be."""
        return self.error / self.scatter if self.error is not None and self.scatter else None

    @property
    def shade(self) -> int:
        """Place on the colour scale, 0 the best."""
        if self.excess is not None:
            return sum(self.excess >= edge for edge in EDGES)
        return 0 if self.error is None else sum(self.error >= edge for edge in ERROR_EDGES)

    @property
    def text(self) -> str:
        """What stands in the cell."""
        if self.excess is not None:
            return f"{self.excess:.1f}" if self.excess < 9.95 else f"{self.excess:.0f}"
        return "" if self.error is None else f"{100 * self.error:.2g}%"

    @property
    def words(self) -> str:
        """What a pointer or a screen reader is told."""
        if self.error is None:
            return ""
        errs = f"error {100 * self.error:.3g}%"
        return errs if self.scatter is None else f"{errs}, scatter {100 * self.scatter:.2g}%, {self.text} times as much"


@dataclass(frozen=True)
class Panel:
    """The cells at one level of the further condition.

    Attributes:
        title: that level; empty where there is no further condition.
        rows: cells by falling amplitude and rising frequency; None where there is no test.
    """

    title: str
    rows: tuple[tuple[Cell | None, ...], ...]


@dataclass(frozen=True)
class ErrorMap:
    """A map.

    Attributes:
        by: what the panels are levels of; empty for none.
        choices: what panels may be levels of.
        amplitudes, frequencies: labels, mm falling and Hz rising.
        panels: the cells.
        scatter_known: whether cells say excess over scatter; else the error.
    """

    by: str
    choices: tuple[tuple[str, str], ...]
    amplitudes: tuple[str, ...]
    frequencies: tuple[str, ...]
    panels: tuple[Panel, ...]
    scatter_known: bool

    def worst(self) -> Cell | None:
        """Give the cell that a person should look at first."""
        cells = [cell for panel in self.panels for row in panel.rows for cell in row if cell]
        return max(cells, key=lambda cell: (cell.excess or 0.0, cell.error or 0.0), default=None)


def error_map(
    runs: Sequence[str], conditions: Sequence[Condition], sums: Sequence[RunSums] | None, by: str = ""
) -> ErrorMap:
    """Give the map of a law held against tests, or of the tests alone.

    Args:
        runs: their names.
        conditions: of the tests: A, f and further ones.
        sums: the law's squared error on each run; None where there is no law yet.
        by: key of the further condition; by default the one over which the error is least even; none where each run
            has a level of its own.
    """
    A, f, *further = conditions
    sorting = {condition.key: condition for condition in further if condition.sorts}
    chosen = sorting.get(by) or _least_even(list(sorting.values()), sums)
    levels: list[tuple[str, Sequence[int]]] = (
        [(chosen.words(level), level.rows.tolist()) for level in chosen.levels] if chosen else [("", range(len(runs)))]
    )

    def cell(rows: set[int]) -> Cell | None:
        return _cell([runs[row] for row in sorted(rows)], None if sums is None else [sums[row] for row in sorted(rows)])

    panels = tuple(
        Panel(
            title,
            tuple(
                tuple(cell(set(rows) & set(one.rows.tolist()) & set(other.rows.tolist())) for other in f.levels)
                for one in reversed(A.levels)
            ),
        )
        for title, rows in levels
    )
    return ErrorMap(
        chosen.key if chosen else "",
        tuple((condition.key, condition.title) for condition in sorting.values()),
        tuple(level.label for level in reversed(A.levels)),
        tuple(level.label for level in f.levels),
        panels,
        sums is not None and any(run.scatter_known for run in sums),
    )


def _least_even(conditions: Sequence[Condition], sums: Sequence[RunSums] | None) -> Condition | None:
    if not conditions or sums is None:
        return next(iter(conditions), None)
    return max(conditions, key=lambda condition: breakdown.by_condition(sums, condition).unevenness)


def _cell(runs: Sequence[str], sums: Sequence[RunSums] | None) -> Cell | None:
    if not runs:
        return None
    if sums is None:
        return Cell(tuple(runs), None, None)
    part = breakdown.part_of_runs("", sums)
    return Cell(tuple(runs), part.nrmse, part.noise_nrmse or None)
