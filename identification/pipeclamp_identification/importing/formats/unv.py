"""Universal files (UFF, UNV) with data sets 58, functions at nodes, by pyuff; those of time responses are read."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pipeclamp_identification.importing.raw import Damaged, Format, RawTable, refuse_size, table_of

TIME_RESPONSE = 1
QUANTITIES = {5: "Temperature", 8: "Displacement", 9: "Force", 11: "Velocity", 12: "Acceleration", 13: "Force"}
"""What the ordinate holds, by its number in the data set."""
UNITS = 164
"""The data set of the file's system of units."""
NOTHING = ("", "NONE", "None")
BEGINS = re.compile(rb"\s*-1\s*\n\s*\d+b?[\s\d]*\n")
END = b"    -1"
"""What ends each data set, and so a file; of a binary one it follows the samples on the same line."""
TAIL = 4096
"""Bytes in which it is looked for."""


def read(path: Path) -> Sequence[RawTable]:
    """Read the time responses of a universal file, those of one length as a table.

    Raises:
        Damaged: it breaks off, or claims what it can't hold.
    """
    import pyuff

    with path.open("rb") as stream:
        stream.seek(-min(TAIL, path.stat().st_size), os.SEEK_END)
        tail = stream.read().rstrip(b"\0\x1a \t\r\n")
    if not tail.endswith(END):
        # of an open data set nothing would be read, and nothing said
        raise Damaged("breaks off within its last data set; export or copy it again")
    file = pyuff.UFF(str(path))
    kinds = [int(kind) for kind in file.get_set_types()]
    size = path.stat().st_size
    system: dict[str, Any] = next((file.read_sets(place) for place, kind in enumerate(kinds) if kind == UNITS), {})
    columns: list[tuple[str, str, object]] = []
    times: dict[int, tuple[str, str, object]] = {}
    for place, kind in enumerate(kinds):
        if kind != 58:
            continue
        data = file.read_sets(place)
        if int(data.get("func_type", 0)) not in (0, TIME_RESPONSE) or np.iscomplexobj(data["data"]):
            continue
        samples = np.asarray(data["data"], dtype=np.float64)
        refuse_size(f"data set {place + 1}", float(data.get("num_pts", len(samples))), size)
        if len(samples) != int(data.get("num_pts", len(samples))):
            raise Damaged(f"ends within data set {place + 1}: {len(samples)} of {data['num_pts']} samples")
        unit = _text(data, "ordinate_axis_units_lab") or _unit(data, system)
        columns.append((_name(data, place), unit, samples))
        times.setdefault(
            len(samples), ("abscissa time", _text(data, "abscissa_axis_units_lab") or "s", np.asarray(data["x"]))
        )
    return table_of("", [*times.values(), *columns])


def _text(data: dict[str, Any], key: str) -> str:
    text = str(data.get(key, "")).strip()
    return "" if text in NOTHING else text


def _unit(data: dict[str, Any], system: dict[str, Any]) -> str:
    """Give the unit of a displacement or force by the file's system of units: by its factor, SI becomes the file's."""
    of, unit = {"Displacement": ("length", "m"), "Force": ("force", "N")}.get(_quantity(data), ("", ""))
    factor = float(system.get(of, 0.0))
    return (unit if factor == 1.0 else f"{1 / factor:.10g} {unit}") if factor > 0.0 else ""


def _quantity(data: dict[str, Any]) -> str:
    return QUANTITIES.get(int(data.get("ordinate_spec_data_type", 0)), "")


def _name(data: dict[str, Any], place: int) -> str:
    """Give what a data set is called: its axis, else its quantity, its first line or number; and its node."""
    found = _text(data, "ordinate_axis_lab") or _quantity(data) or _text(data, "id1") or f"data set {place + 1}"
    node = f" {data['rsp_ent_name']}".replace("NONE", "").rstrip() if "rsp_ent_name" in data else ""
    return found + node


FORMAT = Format(
    name="universal file (58)",
    suffixes=(".uff", ".unv", ".bunv"),
    begins=lambda head: bool(BEGINS.match(head.replace(b"\r\n", b"\n").replace(b"\r", b"\n"))),
    read=read,
    module="pyuff",
    package="pyuff",
)
