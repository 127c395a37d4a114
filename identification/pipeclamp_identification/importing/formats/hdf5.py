"""HDF5, by h5py: data sets of one row each, of columns with names, and of records; MATLAB's own goes to `matlab`."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pipeclamp_identification.importing.nested import tables_of
from pipeclamp_identification.importing.raw import COMPRESSED, Format, RawTable, refuse_size

UNITS = ("unit", "units", "Unit", "Units", "UNIT")
NAMES = ("columns", "names", "channels", "column_names")
DEEPEST = 12


def read(path: Path) -> Sequence[RawTable]:
    """Read a table for each group."""
    import h5py

    with h5py.File(path, "r") as file:
        return tables_of(_held(file, path.stat().st_size, 0))


def _held(group: Any, size: int, depth: int) -> dict[str, Any]:
    """Give what a group holds as nested dicts; what lies in other files is left aside."""
    import h5py

    found: dict[str, Any] = {}
    for name in group:
        if not isinstance(group.get(name, getlink=True), h5py.HardLink):
            continue
        item = group[name]
        if isinstance(item, h5py.Group):
            if depth < DEEPEST:
                found[name] = _held(item, size, depth + 1)
        elif isinstance(item, h5py.Dataset) and not item.external and item.shape:
            refuse_size(f"data set {item.name!r}", float(np.prod(item.shape, dtype=np.float64)), size, COMPRESSED)
            found[name] = _data(item)
    return {**_stated(group, found), **found}


def _stated(group: Any, held: Collection[str]) -> dict[str, Any]:
    """Give the single numbers and texts that a group's attributes state, but for names that what it holds has."""
    found: dict[str, Any] = {}
    for name, value in group.attrs.items():
        texts = _texts(value)
        if name not in held and name not in (*UNITS, *NAMES) and len(texts) == 1:
            found[name] = texts[0] if np.asarray(value).dtype.kind in "OSU" else np.asarray(value).item()
    return found


def _data(item: Any) -> Any:
    """Give a data set: an array; with its unit, or its columns' names, where it states them."""
    if item.dtype.names:
        values = item[()]
        return {name: values[name] for name in item.dtype.names}
    if item.dtype.kind not in "fiubSO":
        return None
    attributes = {name: _texts(item.attrs[name]) for name in (*UNITS, *NAMES) if name in item.attrs}
    unit = next((attributes[name] for name in UNITS if name in attributes), None)
    names = next((attributes[name] for name in NAMES if name in attributes), None)
    values = item[()]
    if item.dtype.kind in "SO":
        return _texts(values)
    if values.ndim == 2 and names:
        return {"names": names, "units": unit or [], "values": values}
    return {"values": values, "unit": unit[0]} if unit else values


def _texts(values: Any) -> list[str]:
    """Give texts of an attribute."""
    flat = np.atleast_1d(np.asarray(values, dtype=object)).ravel()
    return [one.decode("utf-8", "replace") if isinstance(one, bytes) else str(one) for one in flat]


FORMAT = Format(
    name="HDF5",
    suffixes=(".h5", ".hdf5", ".hdf", ".he5"),
    begins=lambda head: head[:8] == b"\x89HDF\r\n\x1a\n",
    read=read,
    module="h5py",
    package="h5py",
)
