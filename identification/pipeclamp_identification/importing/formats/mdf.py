"""ASAM MDF, versions 3 and 4, by asammdf; a group's master channel is its time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pipeclamp_identification.importing.raw import COMPRESSED, Format, RawTable, refuse_size, table_of


def read(path: Path) -> Sequence[RawTable]:
    """Read a table for each channel group."""
    from asammdf import MDF

    size = path.stat().st_size
    tables: list[RawTable] = []
    with MDF(path) as file:
        groups: list[Any] = file.groups
        for place, group in enumerate(groups):
            count = int(group.channel_group.cycles_nr)
            refuse_size(f"channel group {place + 1}", count, size, COMPRESSED)
            if not count:
                continue
            master = file.masters_db.get(place)
            columns: list[tuple[str, str, object]] = []
            time: object = None
            for index, channel in enumerate(group.channels):
                if index == master:
                    continue
                signal = file.get(group=place, index=index)
                columns.append((str(channel.name), str(signal.unit or ""), signal.samples))
                time = signal.timestamps
            if time is not None:
                columns.insert(0, ("master time", "s", time))
            tables += table_of(f"group {place + 1}" if len(groups) > 1 else "", columns)
    return tables


FORMAT = Format(
    name="ASAM MDF",
    suffixes=(".mf4", ".mdf", ".dat"),
    begins=lambda head: head[:8] in (b"MDF     ", b"UnFinMF "),
    read=read,
    module="asammdf",
    package="asammdf",
)
