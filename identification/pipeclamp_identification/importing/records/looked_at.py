"""Some runs of an imported campaign looked at more closely: their loops, delay and smoothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeclamp_identification.campaign.cycles import Cycles
from pipeclamp_identification.campaign.description import CampaignDescription, ImportedDelay
from pipeclamp_identification.campaign.judging import JudgedRuns
from pipeclamp_identification.campaign.reading import read_run
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.runs_table import RunRow
from pipeclamp_identification.campaign.smoothing import Smoothing, asked, find_smoothing
from pipeclamp_identification.importing.samples.delay import common_delay, delay_of
from pipeclamp_models.base.arrays import Array

MOST = 96
"""Runs that are looked at, evenly over the campaign: a page of more loops nobody reads."""
POINTS = 240
"""Points of a cycle that are kept."""
CYCLES = 4
"""Cycles of a run that are kept."""


@dataclass(frozen=True)
class ShownLoop:
    """Some cycles of a run: displacement in mm and force in N, shape (n,); and how many cycles it has in all."""

    run: str
    cycles: int
    displacement: Array
    force: Array


@dataclass(frozen=True)
class LookedAt:
    """What some runs of a campaign show: loops, the delay that all share, the smoothing of records."""

    loops: tuple[ShownLoop, ...]
    delay: ImportedDelay | None
    smoothing: Smoothing


def looked_at(folder: Path, description: CampaignDescription, rows: Sequence[RunRow], judged: JudgedRuns) -> LookedAt:
    """Read the records of some runs once more, one at a time.

    Args:
        folder: of the campaign.
        description: its campaign.toml.
        rows: of its runs.csv.
        judged: its runs.
    """
    by_name = {row.run: row for row in rows}

    def record_of(name: str) -> Record:
        _, record = read_run(folder, description, by_name[name])
        return judged.sensors.repaired(name, record, judged.sines[name])

    names = list(judged.sines)
    loops, delays = [], []
    for place in np.unique(np.linspace(0, len(names) - 1, min(MOST, len(names))).astype(np.intp)).tolist():
        name = names[place]
        record, cycles = record_of(name), judged.sines[name].cycles
        loops.append(_shown(name, record, cycles))
        if (delay := delay_of(record, cycles)) is not None:
            delays.append((cycles.frequency_Hz, delay))
    cycles_of = [one.cycles for one in judged.sines.values()]
    smoothing = find_smoothing([(record_of(names[place]), cycles_of[place]) for place in asked(cycles_of)])
    return LookedAt(tuple(loops), common_delay(delays), smoothing)


def _shown(name: str, record: Record, cycles: Cycles) -> ShownLoop:
    """Give a run's first steady cycles, thinned out."""
    count = min(CYCLES, cycles.count)
    first, last = int(cycles.bounds[0]), int(cycles.bounds[count])
    places = np.unique(np.linspace(first, last - 1, min(POINTS * count, last - first)).astype(np.intp))
    return ShownLoop(name, cycles.count, np.round(record.displacement_mm[places], 6), record.force_N[places])
