"""What stands above the blocks of a text: where it tells them apart, it names them."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence

from pipeclamp_identification.importing.texts.sniffing import COMMENT, cells_of

NAMING = re.compile(r"[^\W\d_]|^\d+$")
"""A letter somewhere, or nothing but digits."""


def names_of_blocks(above: Sequence[Sequence[str]], delimiter: str) -> list[str]:
    """Give each block's name: what differs in the first line above that is another for each; else its number.

    Stamps of time are others for each, too, but no names.

    Args:
        above: lines above each block, without those of its columns' names and units. The first block may have more, as
            a file's header stands above it: the lowest ones count.
        delimiter: between cells.
    """
    rows = [[_cells(line, delimiter) for line in lines] for lines in above]
    for place in range(-min(map(len, rows)), 0):
        names = _what_differs([lines[place] for lines in rows])
        if all(map(NAMING.search, names)) and len(set(names)) == len(names):
            return names
    return [f"block {number}" for number in range(1, len(above) + 1)]


def _cells(line: str, delimiter: str) -> list[str]:
    """Give a line's cells; one where blanks part the numbers, as they part words."""
    plain = COMMENT.sub("", line).strip()
    return [plain] if delimiter == " " else cells_of(plain, delimiter)


def _what_differs(rows: Sequence[Sequence[str]]) -> list[str]:
    """Give the cells of each row that aren't the same in all, in one text."""
    columns = [cells for cells in itertools.zip_longest(*rows, fillvalue="") if len(set(cells)) > 1]
    return [" ".join(filter(None, (cells[row] for cells in columns))) for row in range(len(rows))]
