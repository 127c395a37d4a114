"""Clipped sensors: a plateau of identical extreme values that quantisation can't explain."""

from __future__ import annotations

import numpy as np

from pipeclamp_identification.campaign.cycles import Cycles
from pipeclamp_identification.campaign.records import Record, UnusableRecord
from pipeclamp_models.base.arrays import Array

# a plateau shorter than this is no evidence, whatever else
FEWEST_ALIKE = 4
# flat-topped loops stay longer within one quantum of their extreme than a sine does
FLATTER_THAN_SINE = 3.0


def check_clipping(record: Record, cycles: Cycles) -> None:
    """Refuse a record whose displacement or force stands still at an extreme value, cycle by cycle.

    At its turning points a quantised sine of amplitude A stays within one quantum q of its extreme for
    sqrt(2 q/A)/pi of the cycle; a clipped one stays there much longer. The quantum is the smallest step
    between the values that the record holds.

    Args:
        record: the samples.
        cycles: its steady cycles.

    Raises:
        UnusableRecord: with the channel, the value and the length of the plateau.
    """
    for name in ("displacement_mm", "force_N"):
        samples = getattr(record, name)[cycles.steady]
        per_cycle = len(samples) / cycles.count
        for extreme in (np.max(samples), np.min(samples)):
            alike = _longest_row(samples == extreme)
            if alike >= FEWEST_ALIKE and alike > 2 + FLATTER_THAN_SINE * per_cycle * _quantised_share(samples):
                raise UnusableRecord(
                    f"clipped sensor: {name} stands at {extreme:g} for {alike} samples in a row "
                    f"({100 * alike / per_cycle:.0f} % of a cycle)"
                )


def _longest_row(alike: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> int:
    places = np.flatnonzero(alike)
    # places that follow one another keep their distance to a running count
    return int(np.max(np.unique(places - np.arange(len(places)), return_counts=True)[1]))


def _quantised_share(samples: Array) -> float:
    """Return the share of a cycle for which a sine, quantised as these samples are, stands at one extreme."""
    half_range = np.ptp(samples) / 2
    if half_range == 0.0:
        return 0.0
    steps = np.diff(np.unique(samples))
    # two readings of one value may differ by rounding where a factor was applied
    quantum = np.min(steps[steps > 1e-9 * half_range], initial=half_range)
    return float(np.sqrt(2 * quantum / half_range) / np.pi)
