"""A law's squared error in parts that add up to the whole, each beside its scatter and its force."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class ErrorPart:
    """A part of the error.

    Attributes:
        label: which part.
        squared_error: N2.
        squared_scatter: of it, what no law can explain, N2; None where no run has two cycles to tell.
        squared_force: that the part would have if each run's force were spread evenly over its samples, N2.
        runs: number of runs in it.
    """

    label: str
    squared_error: float
    squared_scatter: float | None
    squared_force: float
    runs: int

    @property
    def nrmse(self) -> float | None:
        """Error as a share of the rms force; None where the part has no sample."""
        return math.sqrt(self.squared_error / self.squared_force) if self.squared_force > 0.0 else None

    @property
    def noise_nrmse(self) -> float | None:
        """Scatter as a share of the rms force; None where it isn't known."""
        if self.squared_scatter is None or self.squared_force <= 0.0:
            return None
        return math.sqrt(self.squared_scatter / self.squared_force)


@dataclass(frozen=True)
class Breakdown:
    """The whole error in parts.

    Attributes:
        by: what it is broken down by.
        parts: in their natural order.
    """

    by: str
    parts: tuple[ErrorPart, ...]

    @property
    def squared_error(self) -> float:
        """Sum over the parts, N2."""
        return sum(part.squared_error for part in self.parts)

    def noise_share(self, part: ErrorPart) -> float | None:
        """Give the scatter in a part as a share of the whole squared error; None where it isn't known."""
        if part.squared_scatter is None or self.squared_error <= 0.0:
            return None
        return part.squared_scatter / self.squared_error

    @property
    def excess(self) -> float:
        """Squared error beyond scatter, N2."""
        return sum(part.squared_error - (part.squared_scatter or 0.0) for part in self.parts)

    def share(self, part: ErrorPart) -> float:
        """Give the share of the squared error that lies in a part."""
        return part.squared_error / self.squared_error if self.squared_error > 0.0 else 0.0

    def excess_share(self, part: ErrorPart) -> float:
        """Give the share of the squared error beyond scatter; below zero where a part errs by less than its scatter."""
        excess = self.excess
        return (part.squared_error - (part.squared_scatter or 0.0)) / excess if excess > 0.0 else 0.0

    def even_share(self, part: ErrorPart) -> float:
        """Give the share that the part would have if every run's error were spread evenly."""
        return part.squared_force / sum(entry.squared_force for entry in self.parts)

    @property
    def unevenness(self) -> float:
        """Return the share of the error that would have to move to be spread evenly."""
        return sum(abs(self.share(part) - self.even_share(part)) for part in self.parts) / 2

    def worst_first(self) -> list[ErrorPart]:
        """Give the parts by falling error."""
        return sorted(self.parts, key=lambda part: -(part.nrmse or 0.0))
