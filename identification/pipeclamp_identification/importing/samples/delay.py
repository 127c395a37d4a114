"""A delay of the force behind the displacement that all runs of a rig share: the same milliseconds at every frequency.

Dry friction turns with the velocity. Its jump at each reversal makes odd harmonics of the force in quadrature,
F_n = i 4 F_c/(pi n) of a displacement cos(theta); a force that is read late by tau has each turned by -n omega tau.
High harmonics, which springs hardly reach, tell tau so, run by run. What the clamp itself is late by (memory) goes with
the phase, not with time: a delay is told only where runs of different frequency agree on it. It is never taken off.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pipeclamp_identification.campaign.cycles import Cycles
from pipeclamp_identification.campaign.description import ImportedDelay
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.signals.harmonics import carried_harmonics, cycle_harmonics
from pipeclamp_identification.signals.sample_noise import scatter_by_median
from pipeclamp_models.base.arrays import ComplexArray, IntArray
from pipeclamp_models.base.digits import rounded_to

LOWEST, HIGHEST = 7, 15
"""Orders of the harmonics that are asked: springs that harden by powers up to five make none of them."""
SEEN = 5.0
"""Standard errors, from cycle to cycle, that their sum must have."""
SURE = 4.0
"""Standard errors, from run to run, from which on a delay is told."""
FEWEST_RUNS = 4
FREQUENCIES_APART = 1.5
"""Factor between the lowest and the highest frequency of the runs that tell it."""
ALIKE = 0.3
"""Share by which the slower and the faster half of the runs may differ in it."""
OF_MEDIAN = 1.2533
"""Standard error of a median of normal numbers, over that of their mean."""
OF_TURN = 2e-3
"""Share of the fastest cycle below which a delay does no harm."""


def common_delay(of_runs: Sequence[tuple[float, float]]) -> ImportedDelay | None:
    """Give the delay of the force that all runs share; None where none is seen.

    Args:
        of_runs: frequency in Hz and delay in s of each run whose harmonics tell it.
    """
    if len(of_runs) < FEWEST_RUNS:
        return None
    frequency, delays = np.array(sorted(of_runs)).T
    if frequency[-1] < FREQUENCIES_APART * frequency[0]:
        return None
    delay = float(np.median(delays))
    error = OF_MEDIAN * scatter_by_median(delays - delay) / math.sqrt(len(delays))
    slow, fast = (float(np.median(half)) for half in np.array_split(delays, 2))
    if abs(delay) * frequency[-1] < OF_TURN or abs(delay) < SURE * error or abs(slow - fast) > ALIKE * abs(delay):
        return None
    late, early = ("force", "displacement") if delay > 0 else ("displacement", "force")
    words = (
        f"the {late} is {1e3 * abs(delay):.3g} ms (standard error {1e3 * error:.1g} ms) behind the {early}, alike from "
        f"{frequency[0]:.3g} to {frequency[-1]:.3g} Hz in {len(delays)} runs, by the harmonics that friction makes "
        "when it turns; it is not taken off, and a law takes it for damping; to do: use one filter for both channels, "
        "or shift one of them before the import"
    )
    return ImportedDelay(
        delay_ms=rounded_to(1e3 * delay, 4), standard_error_ms=rounded_to(max(1e3 * error, 1e-6), 2), words=words
    )


def delay_of(record: Record, cycles: Cycles) -> float | None:
    """Give by how many seconds a run's force comes late; None where its harmonics don't tell."""
    phase, bounds = cycles.phase(record), cycles.bounds - cycles.bounds[0]
    count = min(HIGHEST, carried_harmonics(phase, bounds))
    orders = np.arange(LOWEST, count + 1, 2)
    if cycles.count < 2 or len(orders) < 2:
        return None
    y, force = record.displacement_mm[cycles.steady], record.force_N[cycles.steady]
    Y, F = cycle_harmonics(phase, bounds, [y, force], count)
    turned = F[:, orders] * np.exp(-1j * orders * np.angle(Y[:, 1])[:, None]) / 1j
    mean = np.mean(turned, axis=0)
    error = np.std(turned, axis=0, ddof=1) / math.sqrt(cycles.count)
    if np.linalg.norm(mean) < SEEN * np.linalg.norm(error) or not _is_frictions(mean, orders):
        return None
    angle = np.unwrap(np.concatenate([[0.0], np.angle(mean)]))[1:]
    weight = np.abs(mean) ** 2 * orders
    omega = 2 * math.pi * cycles.frequency_Hz
    return -float(weight @ angle / (weight @ orders)) / omega


def _is_frictions(mean: ComplexArray, orders: IntArray) -> bool:
    """Tell whether the harmonics turn in proportion to their order, as those of a late jump do."""
    angle = np.unwrap(np.concatenate([[0.0], np.angle(mean)]))[1:]
    weight = np.abs(mean) ** 2
    order = np.asarray(orders, dtype=np.float64)
    slope = float(weight * order @ angle / (weight * order @ order))
    rest = float(np.sqrt(weight @ (angle - slope * order) ** 2 / np.sum(weight)))
    return abs(angle[0]) < math.pi / 2 and rest < 0.3
