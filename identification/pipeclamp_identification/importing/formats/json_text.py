"""JSON: lists of samples by name, rows that are lists or objects, and a table written object by object, a line each."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pipeclamp_identification.importing.nested import tables_of
from pipeclamp_identification.importing.raw import Damaged, Format, RawTable
from pipeclamp_models.base.arrays import Array

BEGINS = re.compile(rb"(?:\xef\xbb\xbf)?\s*(?:\{\s*[\"}]|\[\s*[\[{])")
"""An object, or a list of lists or objects; a text's own "[Header]" is none."""


def read(path: Path) -> Sequence[RawTable]:
    """Read a table for each object that holds lists of samples, and of rows that are objects."""
    loaded = _loaded(path.read_text(encoding="utf-8-sig"))
    if isinstance(loaded, dict) and str(schema := loaded.get("schema", "")).startswith("pipeclamp-"):
        raise Damaged(f"was written by pipeclamp ({schema}), and holds no test; expected a test machine's file")
    held = _held(loaded)
    return tables_of(held if isinstance(held, Mapping) else {"rows": held})


def _loaded(text: str) -> Any:
    """Give what a text holds; of several objects, a line each, a list of them."""
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        lines = [line for line in text.splitlines() if line.strip()]
        if len(lines) < 2 or not error.msg.startswith("Extra data"):
            raise
        return [json.loads(line) for line in lines]
    except RecursionError as error:
        raise Damaged("is nested too deeply to be read") from error


def _held(value: Any) -> Any:
    """Give a value with lists of numbers as arrays, and rows as the columns that they make."""
    if isinstance(value, dict):
        if _are_numbered(value):
            return _numbers(value.values())
        return {name: _held(one) for name, one in value.items()}
    if not isinstance(value, list):
        return value
    if value and all(map(_is_number, value)):
        return _numbers(value)
    if value and all(isinstance(one, dict) for one in value):
        return _columns(value) if all(map(_is_flat, value)) else [_held(one) for one in value]
    inner = [_held(one) for one in value]
    rows = [one for one in inner if isinstance(one, np.ndarray) and one.ndim == 1]
    if len(rows) == len(inner) > 1 and len({len(one) for one in rows}) == 1:
        return np.stack(rows)
    return inner


def _columns(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Give the columns of rows that are objects: numbers, or texts; what a row lacks is blank."""
    found: dict[str, Any] = {}
    for name in dict.fromkeys(name for row in rows for name in row):
        cells = [row.get(name) for row in rows]
        if all(map(_is_number, cells)):
            found[name] = _numbers(cells)
        elif all(isinstance(cell, str) for cell in cells):
            found[name] = cells
    return found


def _are_numbered(value: Mapping[str, Any]) -> bool:
    """Tell whether an object is a column whose samples are called by their places, as pandas writes it."""
    return (
        len(value) > 1
        and list(value) == [str(place) for place in range(len(value))]
        and all(map(_is_number, value.values()))
    )


def _is_flat(row: Mapping[str, Any]) -> bool:
    return not any(isinstance(cell, dict | list) for cell in row.values())


def _is_number(cell: Any) -> bool:
    """Tell whether a cell is a number, or blank."""
    return cell is None or (isinstance(cell, int | float) and not isinstance(cell, bool))


def _numbers(cells: Any) -> Array:
    numbers: Array = np.array([np.nan if cell is None else cell for cell in cells], dtype=np.float64)
    return numbers


FORMAT = Format(
    name="JSON", suffixes=(".json", ".jsonl", ".ndjson"), begins=lambda head: bool(BEGINS.match(head)), read=read,
    is_also_notes=True,
)  # fmt: skip
