"""Smoothing that records went through before they came here: a moving average leaves its mark on their noise.

The mean over a share p of the drive's period multiplies what happens at n times the drive's frequency by
sin(pi n p)/(pi n p): harmonics of the force shrink, and the noise between them vanishes at n = 1/p, 2/p, ... A campaign
whose noise does so was smoothed, and a law must be held against it through the same average.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pipeclamp_identification.campaign.cycles import Cycles
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.signals.spectrum import hann_spectrum
from pipeclamp_models.base.arrays import Array

LOWEST_ORDER, HIGHEST_ORDER = 2, 60
"""Orders between which noise is looked at."""
FEWEST_CYCLES_BETWEEN_HARMONICS = 4
"""Cycles from which on the noise between the motion's own harmonics can be seen."""
FEWEST_ORDERS = 20
MOST_RUNS_ASKED = 24
AVERAGED_SHARES = 1 / np.arange(3.0, 30.05, 0.1)
"""Averages over these shares of the period are looked for."""
EXPLAINED = 0.6
"""Share of the spectrum's ups and downs, its smooth course left aside, that the average's zeros must explain."""
NEAR_ONE = (0.5, 1.5)
"""The zeros must be about as deep, in decibels, as the average's own."""
LOWEST_NOISE = 1e-3
"""Noise does not fall lower beside its neighbours than this share: readings are rounded."""


@dataclass(frozen=True)
class Smoothing:
    """Moving averages that the channels of a campaign went through, as shares of the drive's period; zero for none."""

    displacement: float = 0.0
    force: float = 0.0

    def words(self) -> str:
        """Say what was found; empty where nothing was."""
        found = [
            f"{name} over {share:.1%} of the period"
            for name, share in (("displacement", self.displacement), ("force", self.force))
            if share
        ]
        if not found:
            return ""
        return f"the records went through a moving average ({', '.join(found)}); laws are held against them through it"


def gain(share: float, order: npt.ArrayLike) -> Array:
    """Give what a moving average over a share of the period leaves of a harmonic, with the order's shape."""
    return np.asarray(np.sinc(np.asarray(order) * share))


def averaged(periodic: Array, share: float) -> Array:
    """Give periodic samples after a moving average over a share of the period.

    Args:
        periodic: equally spaced over one period along the last axis.
        share: 0 for no average.
    """
    if not share:
        return periodic
    samples = periodic.shape[-1]
    return np.asarray(np.fft.irfft(np.fft.rfft(periodic) * gain(share, np.arange(samples // 2 + 1)), samples))


def find_smoothing(records: Sequence[tuple[Record, Cycles]]) -> Smoothing:
    """Find the moving averages that all records of a campaign went through, from the spectrum of their noise.

    Args:
        records: of all runs, with their cycles.
    """
    some = [records[place] for place in asked([cycles for _, cycles in records])]
    displacement = [_between_harmonics(record.displacement_mm, cycles) for record, cycles in some]
    force = [_between_harmonics(record.force_N, cycles) for record, cycles in some]
    return Smoothing(_share(displacement), _share(force))


def asked(runs: Sequence[Cycles]) -> list[int]:
    """Give the places of the runs whose noise is looked at, of many runs some."""
    usable = [place for place, cycles in enumerate(runs) if cycles.count >= FEWEST_CYCLES_BETWEEN_HARMONICS]
    return usable[:: max(1, len(usable) // MOST_RUNS_ASKED)]


def _between_harmonics(samples: Array, cycles: Cycles) -> Array:
    """Give the log of the noise's power halfway between the motion's harmonics, NaN where sampling ends, (orders,)."""
    steady = samples[cycles.steady]
    power = hann_spectrum(steady) ** 2
    orders = np.arange(LOWEST_ORDER, HIGHEST_ORDER) + 0.5
    level = np.full(len(orders), np.nan)
    # A window over c cycles puts harmonic n at line n c and blurs it over two lines either side.
    reach = max(int(cycles.count / 2 - 2), 0)
    middle = np.round(orders * cycles.count).astype(np.intp)
    sampled = middle + reach < 0.95 * len(power)
    between = power[middle[sampled, None] + np.arange(-reach, reach + 1)]
    level[sampled] = np.log(np.mean(between, axis=1) + np.finfo(float).tiny)
    return level


def _share(levels: Sequence[Array]) -> float:
    """Give the share of the period that the average goes over whose zeros the noise shows; zero for none."""
    if not levels:
        return 0.0
    orders = np.arange(LOWEST_ORDER, HIGHEST_ORDER) + 0.5
    table = np.array(levels)
    seen = np.isfinite(table).any(axis=0)
    if np.count_nonzero(seen) < FEWEST_ORDERS:
        return 0.0
    orders, table = orders[seen], table[:, seen]
    level = np.nanmedian(table - np.nanmean(table, axis=1, keepdims=True), axis=0)
    course = np.vander(np.log(orders), 4)
    smooth = np.linalg.qr(course)[0]
    rough = level - smooth @ (smooth.T @ level)
    best = (0.0, 0.0)
    for share in AVERAGED_SHARES:
        mark = np.log(gain(share, orders) ** 2 * orders**2 + LOWEST_NOISE)
        mark = mark - smooth @ (smooth.T @ mark)
        depth = float(mark @ rough / (mark @ mark))
        explained = depth**2 * float(mark @ mark) / max(float(rough @ rough), np.finfo(float).tiny)
        if NEAR_ONE[0] < depth < NEAR_ONE[1] and explained > best[0]:
            best = (explained, float(share))
    return best[1] if best[0] > EXPLAINED else 0.0
