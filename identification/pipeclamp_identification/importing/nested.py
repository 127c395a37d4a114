"""Channels out of nested tables, as MATLAB's structures and HDF5's groups are: by name, with units where they stand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from pipeclamp_identification.importing.raw import RawTable, table_of

VALUES = ("values", "value", "data", "samples", "y", "Values", "Value", "Data")
UNIT = ("unit", "units", "Unit", "Units")
HEADER, DATA = "_Header", "_Data"
"""catman's "Channel_1_Header", with SignalName and Unit, and "Channel_1_Data"."""
SIGNAL_NAME = "SignalName"
AXES = ("x_values", "y_values")
"""Simcenter Testlab's signals: structures of a start, an increment and a quantity, and of values and a quantity."""
NAMES = ("names", "name", "labels", "columns", "channels", "header", "Names", "Name", "Labels", "colheaders")
MOST_COLUMNS = 1000
DEEPEST = 12

_Level = tuple[str, list[tuple[str, str, object]], Mapping[str, object]]
"""Its path, its channels with their units, and what else it states, by name."""


def tables_of(held: Mapping[str, Any]) -> list[RawTable]:
    """Give a table for each level with channels.

    Args:
        held: arrays, texts, lists and further such mappings by name.
    """
    found: list[_Level] = []
    _collect("", held, {}, found, 0)
    return [
        replace(table, properties=properties)
        for path, columns, properties in found
        for table in table_of(path if len(found) > 1 else "", columns)
    ]


def _collect(path: str, held: Mapping[str, Any], above: Mapping[str, object], found: list[_Level], depth: int) -> None:
    """Collect the levels with channels; what stands above one holds for it too."""
    properties = {**above, **_single(held)}
    columns: list[tuple[str, str, object]] = []
    inner: dict[str, Mapping[str, Any]] = _apart(held)
    matrix = _matrix(held)
    if matrix is not None:
        columns += matrix
    elif not inner:
        for name, value in held.items():
            header = held.get(f"{name.removesuffix(DATA)}{HEADER}") if name.endswith(DATA) else None
            if isinstance(header, Mapping) and isinstance(header.get(SIGNAL_NAME), str):
                columns.append((header[SIGNAL_NAME], _unit(header), value))
            elif isinstance(value, Mapping):
                listed = _signal(value, name) or _channels(value, name)
                if listed:
                    columns += listed
                else:
                    inner[name] = value
            elif several := _several(value):
                inner |= dict(zip(_called(several, name), several, strict=True))
            else:
                columns += _columns(name, value)
    if columns:
        found.append((path, columns, properties))
    if depth < DEEPEST:
        for name, value in inner.items():
            below = f"{path}{'' if name.startswith('(') else '.'}{name}" if path else name
            _collect(below, value, properties, found, depth + 1)


def _single(held: Mapping[str, Any]) -> dict[str, object]:
    """Give the numbers and texts that stand by themselves, by name."""
    numbers = {
        name: np.asarray(value).item()
        for name, value in held.items()
        if isinstance(value, int | float | np.generic | np.ndarray) and np.asarray(value).size == 1
    }
    return {**numbers, **{name: value for name, value in held.items() if isinstance(value, str)}}


def _called(several: Sequence[Mapping[str, Any]], name: str) -> list[str]:
    """Give names of structures of a list: their own, where these tell them apart, else the list's and their places."""
    own = [next((_texts(one[key]) for key in NAMES if key in one), []) for one in several]
    called = [texts[0] for texts in own if len(texts) == 1 and texts[0]]
    if len(several) > 1 and len(set(called)) == len(several):
        return called
    return [f"{name}({number})" for number in range(1, len(several) + 1)]


def _apart(held: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    """Give the structures of an array of them, which is read as one of lists; nothing where it is none."""
    lists = {name: value for name, value in held.items() if isinstance(value, list) and len(value) > 1}
    counts = {len(value) for value in lists.values()}
    of_samples = [value for value in lists.values() if all(map(_is_row, value))]
    if len(counts) != 1 or len(of_samples) < 2:
        return {}
    texts = next((_texts(held[key]) for key in NAMES if key in lists and _texts(held[key])), [])
    names = texts if len(set(texts)) == len(texts) > 0 else [f"({number})" for number in range(1, counts.pop() + 1)]
    return {
        name: {key: value[place] for key, value in lists.items() if not isinstance(value[place], str)}
        for place, name in enumerate(names)
    }


def _several(value: Any) -> list[Mapping[str, Any]]:
    """Give structures of a list of them, or of matrices; nothing for anything else."""
    if not isinstance(value, list) or not value:
        return []
    if all(isinstance(one, Mapping) for one in value):
        return value
    if len(value) > 1 and all(isinstance(one, np.ndarray) and one.ndim == 2 for one in value):
        return [{"columns": one} for one in value]
    return []


def _channels(held: Mapping[str, Any], name: str) -> list[tuple[str, str, object]]:
    """Give the channel that a structure of values and unit is, or those that one of lists of these is; else nothing."""
    values = next((held[key] for key in VALUES if key in held), None)
    unit = next((held[key] for key in UNIT if key in held), None)
    own = next((held[key] for key in NAMES if key in held), name)
    if isinstance(values, list) and values and all(map(_is_row, values)):
        names, units = _texts(own), _texts(unit)
        if len(names) == len(values):
            stated = units if len(units) == len(names) else [""] * len(names)
            return list(zip(names, stated, values, strict=True))
    if values is None or not isinstance(unit, str) or np.squeeze(np.asarray(values)).ndim != 1:
        return []
    return [(own if isinstance(own, str) and own else name, unit, values)]


def _signal(held: Mapping[str, Any], name: str) -> list[tuple[str, str, object]]:
    """Give a signal's time and channels; nothing where the structure is none, or one over something else than time."""
    x, y = (held.get(axis) for axis in AXES)
    if not (isinstance(x, Mapping) and isinstance(y, Mapping)) or not {"start_value", "increment"} <= x.keys():
        return []
    values = np.squeeze(np.asarray(y.get("values")))
    if values.ndim not in (1, 2) or values.dtype.kind not in "fiu" or _quantity(x) != "s":
        return []
    columns = [values] if values.ndim == 1 else list(values.T)
    record = held.get("function_record")
    texts = _texts(record["name"]) if isinstance(record, Mapping) and "name" in record else []
    names = [f"{name}({place})" for place in range(1, len(columns) + 1)] if len(columns) > 1 else [name]
    names = texts if len(texts) == len(columns) else names
    time = float(x["start_value"]) + float(x["increment"]) * np.arange(len(values))
    unit = _quantity(y)
    return [(f"{name} time", "s", time), *((own, unit, column) for own, column in zip(names, columns, strict=True))]


def _quantity(axis: Mapping[str, Any]) -> str:
    """Give the unit of an axis; none where a factor stands beside it: whether it was applied, files don't say."""
    quantity = axis.get("quantity")
    if not isinstance(quantity, Mapping) or not isinstance(quantity.get("label"), str):
        return ""
    turned = quantity.get("unit_transformation")
    plain = not isinstance(turned, Mapping) or (turned.get("factor", 1), turned.get("offset", 0)) == (1, 0)
    return str(quantity["label"]) if plain else ""


def _unit(held: Mapping[str, Any]) -> str:
    """Give the unit that a structure states."""
    return next((held[key] for key in UNIT if isinstance(held.get(key), str)), "")


def _is_row(value: Any) -> bool:
    return isinstance(value, np.ndarray) and value.ndim == 1


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
