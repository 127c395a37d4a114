"""The published table rows (Tables 2-5 of Symmetry 2020, 12(8), 1283), and which of them match a run's conditions."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib import resources

from pipeclamp_identification.campaign.reading import Run
from pipeclamp_identification.loops.energies import stiffness_of_energy

RELATIVE, KELVINS = 0.02, 5.0
"""How far a run may lie from a published row's nominal conditions: what test rigs keep to."""


@dataclass(frozen=True)
class PublishedRow:
    """One measured row of the paper's tables."""

    table: int
    specimen: str
    density_g_cm3: float
    amplitude_mm: float
    frequency_Hz: float
    temperature_C: float
    loss_factor: float
    dissipated_energy_J: float
    max_elastic_energy_J: float

    @property
    def stiffness(self) -> float:
        """Return the stiffness in N/mm that belongs to W: k = 2 W/X0^2, Eq. 4."""
        return stiffness_of_energy(self.max_elastic_energy_J, self.amplitude_mm)


@cache
def published_rows() -> tuple[PublishedRow, ...]:
    """Return the rows of Tables 2-5, in the paper's order; a condition that several tables share is there as often."""
    text = resources.files("pipeclamp_models").joinpath("data", "published_tables.csv").read_text(encoding="utf-8")
    return tuple(_rows(text))


def _rows(text: str) -> Iterator[PublishedRow]:
    for row in csv.DictReader(io.StringIO(text)):
        # Table 1 lists the specimens only
        if row["loss_factor"]:
            numbers = {column: float(cell) for column, cell in row.items() if column not in ("table", "specimen")}
            yield PublishedRow(table=int(row["table"]), specimen=row["specimen"], **numbers)


def matching_row(run: Run) -> PublishedRow | None:
    """Return the published row at a run's conditions, or None.

    Args:
        run: with nominal conditions; its specimen is known by its density or, where that isn't given, by its name.
    """
    for row in published_rows():
        if (
            _same_specimen(run, row)
            and _near(run.amplitude_mm, row.amplitude_mm)
            and _near(run.frequency_Hz, row.frequency_Hz)
            and run.setup.temperature_C is not None
            and abs(run.setup.temperature_C - row.temperature_C) <= KELVINS
        ):
            return row
    return None


def _same_specimen(run: Run, row: PublishedRow) -> bool:
    if run.setup.density_g_cm3 is None:
        return run.setup.specimen == row.specimen
    return _near(run.setup.density_g_cm3, row.density_g_cm3)


def _near(value: float | None, published: float) -> bool:
    return value is not None and abs(value - published) <= RELATIVE * published
