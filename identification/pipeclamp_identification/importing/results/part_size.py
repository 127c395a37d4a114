"""Strains and moduli become the part's amplitude and stiffness by its height and area, where these are stated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_identification.importing.channels.naming import unit_of
from pipeclamp_identification.importing.raw import Channel, RawTable
from pipeclamp_identification.importing.results.quantities import (
    LOSSES,
    STIFFNESSES,
    amplitude_share,
    is_modulus,
    is_strain,
    quantity_of,
)
from pipeclamp_identification.units.stated import Conversion, conversion
from pipeclamp_models.base.arrays import Array

SIZES: Mapping[str, str] = {"size": "size_mm", "area": "area_mm2"}
"""Columns of a table of conditions, or fields of a name's pattern, that state a part's height and area."""
SHARES: Mapping[str, float] = {"%": 0.01, "-": 1.0, "1": 1.0}
"""Units of strains, and what 1 of them is."""
SIZE_WORDS = (
    f"the part's size:\n  --conditions TABLE.csv with the columns file,{','.join(SIZES.values())}: the height and the "
    "area of each file's part\n  or"
)


@dataclass(frozen=True)
class ResultColumn:
    """A channel of results: which quantity it is, what turns it into ours, and the unit that counted.

    `scale`: a further factor for each row, shape (rows,), where a part's size changes from row to row.
    """

    quantity: str
    channel: Channel
    conversion: Conversion
    unit: str = ""
    stated: bool = False
    scale: Array | None = None

    @property
    def values(self) -> Array:
        """Its numbers in our unit, shape (rows,)."""
        turned: Array = self.conversion.factor * self.channel.values + self.conversion.offset
        return turned if self.scale is None else turned * self.scale


def by_part_size(
    table: RawTable, columns: Mapping[str, ResultColumn], sizes: Mapping[str, float], *, amplitude_known: bool
) -> dict[str, ResultColumn]:
    """Give the amplitude that a strain states and the stiffness that moduli state, as far as the part's size is known.

    Args:
        table: as a file holds it.
        columns: that are known, with `size` and `area` among them where columns hold these.
        sizes: size_mm and area_mm2 that are stated of the file.
        amplitude_known: whether something else states the amplitude.
    """
    height, area = (_stated(table, columns.get(one), sizes.get(column)) for one, column in SIZES.items())
    found: dict[str, ResultColumn] = {}
    if height is not None and not amplitude_known and "amplitude" not in columns:
        strain = next((one for one in strains_of(table, columns) if unit_of(one) in SHARES), None)
        if strain:
            share = Conversion(SHARES[unit_of(strain)] * amplitude_share(strain.name))
            found["amplitude"] = _scaled(ResultColumn("amplitude", strain, share, unit_of(strain)), height)
    if height is not None and area is not None and not columns.keys() & set(STIFFNESSES):
        for quantity, channel in moduli_of(table, columns).items():
            turned = conversion("modulus", unit_of(channel), "MPa")
            found[quantity] = _scaled(ResultColumn(quantity, channel, turned, unit_of(channel)), area / height)
    return found


def strains_of(table: RawTable, columns: Mapping[str, ResultColumn]) -> list[Channel]:
    """Give the strains and angles of a table that are nothing else yet, the likeliest amplitude first.

    That is the one of the rows that state a stiffness, and a strain before the angle that made it.
    """
    taken = {one.channel.heading for one in columns.values()}
    stiff = [np.isfinite(one.values) for one in table.channels if quantity_of(one) in STIFFNESSES]
    of = np.any(stiff, axis=0) if stiff else np.ones(table.length, dtype=bool)
    strains = [one for one in table.channels if one.heading not in taken and is_strain(one)]
    return sorted(
        strains, key=lambda one: (int(np.count_nonzero(np.isnan(one.values[of]))), unit_of(one) not in SHARES)
    )


def moduli_of(table: RawTable, columns: Mapping[str, ResultColumn]) -> dict[str, Channel]:
    """Give a table's moduli by the stiffness that each makes: storage and loss, or one of the two with what was lost.

    None where these don't say both how stiff the part was and what it lost.

    Args:
        table: as a file holds it.
        columns: that are known.
    """
    moduli = {quantity_of(one): one for one in table.channels if is_modulus(one)}
    if {"storage_stiffness", "loss_stiffness"} <= moduli.keys():
        return {quantity: moduli[quantity] for quantity in ("storage_stiffness", "loss_stiffness")}
    if columns.keys() & set(LOSSES):
        one = next((one for one in ("storage_stiffness", "dynamic_stiffness") if one in moduli), None)
        return {one: moduli[one]} if one else {}
    return {}


def _stated(table: RawTable, column: ResultColumn | None, of_file: float | None) -> Array | None:
    """Give a size of each row: of a column, else of the file; None where neither states it."""
    if column is not None:
        return column.values
    return None if of_file is None else np.full(table.length, float(of_file))


def _scaled(column: ResultColumn, scale: Array) -> ResultColumn:
    """Give a column with a factor for each row; one and the same is a part of what turns it."""
    if len(scale) and np.all(scale == scale[0]):
        return replace(column, conversion=Conversion(column.conversion.factor * float(scale[0])))
    return replace(column, scale=scale)
