"""Channels out of nested tables, as MATLAB's structures and HDF5's groups are: by name, with units where they stand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pipeclamp_identification.importing.raw import RawTable, table_of

VALUES = ("values", "value", "data", "samples", "y", "Values", "Value", "Data")
UNIT = ("unit", "units", "Unit", "Units")
NAMES = ("names", "name", "labels", "columns", "channels", "header", "Names", "Name", "Labels", "colheaders")
MOST_COLUMNS = 1000
DEEPEST = 12


def tables_of(held: Mapping[str, Any]) -> list[RawTable]:
    """Give a table for each level with channels.

    Args:
        held: arrays, texts, lists and further such mappings by name.
    """
    found: list[tuple[str, list[tuple[str, str, object]]]] = []
    _collect("", held, found, 0)
    return [table for path, columns in found for table in table_of(path if len(found) > 1 else "", columns)]


def _collect(
    path: str, held: Mapping[str, Any], found: list[tuple[str, list[tuple[str, str, object]]]], depth: int
) -> None:
    columns: list[tuple[str, str, object]] = []
    matrix = _matrix(held)
    if matrix is not None:
        columns += matrix
    else:
        for name, value in held.items():
            if isinstance(value, Mapping):
                single = _channel(name, value)
                if single is not None:
                    columns.append(single)
                elif depth < DEEPEST:
                    _collect(f"{path}.{name}" if path else name, value, found, depth + 1)
            else:
                columns += _columns(name, value)
    if columns:
        found.append((path, columns))


def _channel(name: str, held: Mapping[str, Any]) -> tuple[str, str, object] | None:
    """Give a channel that is a structure of values and unit; None for any other structure."""
    values = next((held[key] for key in VALUES if key in held), None)
    unit = next((held[key] for key in UNIT if key in held), None)
    if values is None or not isinstance(unit, str) or np.squeeze(np.asarray(values)).ndim != 1:
        return None
    return name, unit, values


def _matrix(held: Mapping[str, Any]) -> list[tuple[str, str, object]] | None:
    """Give the columns of a matrix that stands beside their names; None where there is none."""
    names = next((_texts(held[key]) for key in NAMES if key in held and _texts(held[key])), [])
    if not names:
        return None
    units = next((_texts(held[key]) for key in UNIT if key in held), [])
    for key, value in held.items():
        if key in NAMES or key in UNIT or isinstance(value, Mapping | str):
            continue
        values = np.asarray(value)
        if values.ndim == 2 and values.dtype.kind in "fiub" and len(names) in values.shape:
            columns = values.T if values.shape[1] == len(names) else values
            stated = units if len(units) == len(names) else [""] * len(names)
            return [(name, unit, column) for name, unit, column in zip(names, stated, columns, strict=True)]
    return None


def _texts(value: Any) -> list[str]:
    if isinstance(value, str):
        return [value]
    if isinstance(value, Sequence | np.ndarray):
        flat = list(np.asarray(value, dtype=object).ravel())
        return [one.strip() for one in flat] if flat and all(isinstance(one, str) for one in flat) else []
    return []


def _columns(name: str, value: Any) -> list[tuple[str, str, object]]:
    """Give a variable's columns: itself, or those of a matrix by number."""
    if isinstance(value, str) or value is None:
        return []
    try:
        values = np.squeeze(np.asarray(value))
    except ValueError:  # of a list of unequal lengths
        return []
    if values.dtype.kind not in "fiub" or values.ndim == 0:
        return []
    if values.ndim == 1:
        return [(name, "", values)]
    if values.ndim == 2:
        columns = values.T if values.shape[0] >= values.shape[1] else values
        if len(columns) <= MOST_COLUMNS:
            return [(f"{name}({place})", "", column) for place, column in enumerate(columns, 1)]
    return []
