"""Columns of text as numbers, one for each text: what tells the runs of a table apart may be names."""

from __future__ import annotations

import numpy as np

from pipeclamp_identification.importing.raw import LabelColumn
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.tables import pl

MOST = 10_000
"""Different texts from which on a column holds remarks, and no names of runs."""


class Labels:
    """The texts of a column, taken block after block."""

    def __init__(self) -> None:
        self._known: dict[str, float] = {}
        self._blocks: list[Array] = []

    def add(self, cells: pl.Series) -> None:
        """Take the cells of a block."""
        if len(self._known) > MOST:
            return
        text = cells.str.strip_chars()
        named = text.set(text == "", None)
        for own in named.unique(maintain_order=True).drop_nulls().to_list():
            self._known.setdefault(own, float(len(self._known)))
        codes = named.replace_strict(self._known, default=None, return_dtype=pl.Float64)
        self._blocks.append(codes.fill_null(float("nan")).to_numpy())

    def column(self, name: str, unit: str, length: int) -> LabelColumn | None:
        """Give the column; None where its texts are no labels of all cells, `length` of them.

        A blank cell has the label of the one above it.
        """
        if not self._known or len(self._known) > MOST or sum(map(len, self._blocks)) != length:
            return None
        codes = np.concatenate(self._blocks)
        above = np.maximum.accumulate(np.where(np.isnan(codes), 0, np.arange(length)))
        return LabelColumn(name, unit, np.asarray(codes[above]), tuple(self._known))
