"""ASAM MDF, versions 3 and 4, by asammdf; a group's master channel is its time.

asammdf's C code reads damaged files beyond their ends, so they are read in a process of their own.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pipeclamp_identification.importing.apart import read_apart
from pipeclamp_identification.importing.raw import COMPRESSED, Damaged, Format, RawTable, refuse_size, table_of


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
            _refuse_beyond_record(place, group)
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


def _refuse_beyond_record(place: int, group: Any) -> None:
    """Refuse channels that lie beyond the group's records: asammdf's C code reads there without looking.

    Raises:
        Damaged: one does.
    """
    record = int(group.channel_group.samples_byte_nr)
    for channel in group.channels:
        first = getattr(channel, "byte_offset", None)
        if first is None:  # version 3 counts bits
            bits = int(channel.start_offset) + 8 * int(getattr(channel, "additional_byte_offset", 0))
        else:
            bits = 8 * int(first) + int(channel.bit_offset)
        if record <= 0 or bits < 0 or bits + int(channel.bit_count) > 8 * record:
            raise Damaged(
                f"channel {channel.name!r} of group {place + 1} lies beyond its records of {record} bytes; export or "
                "copy it again"
            )


FORMAT = Format(
    name="ASAM MDF",
    suffixes=(".mf4", ".mdf", ".dat"),
    begins=lambda head: head[:8] in (b"MDF     ", b"UnFinMF "),
    read=lambda path: read_apart(__name__, path),
    module="asammdf",
    package="asammdf",
)
