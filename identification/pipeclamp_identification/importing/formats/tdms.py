"""TDMS of National Instruments' LabVIEW and DIAdem, by npTDMS; a waveform's own increment is its time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pipeclamp_identification.importing.raw import Format, RawTable, refuse_size, table_of

UNITS = ("unit_string", "NI_UnitDescription", "unit", "Unit")
"""Properties in which programs state a channel's unit."""


def read(path: Path) -> Sequence[RawTable]:
    """Read a table for each group, of the channels of one length each."""
    from nptdms import TdmsFile

    size = path.stat().st_size
    tables: list[RawTable] = []
    with TdmsFile.open(path) as file:
        groups = [(group.name, group.channels()) for group in file.groups()]
        for name, channels in groups:
            columns: list[tuple[str, str, object]] = []
            increments = set()
            for channel in channels:
                refuse_size(f"channel {channel.name!r}", len(channel), size)
                if not len(channel):
                    continue
                samples = channel[:]
                if isinstance(samples, np.ndarray) and samples.dtype.kind == "M":
                    # stamps of time, in seconds since the first
                    columns.append((channel.name, "s", (samples - samples[0]) / np.timedelta64(1, "ns") * 1e-9))
                else:
                    columns.append((channel.name, _unit(channel), samples))
                if (increment := _number(channel, "wf_increment")) > 0:
                    increments.add((len(channel), increment, _number(channel, "wf_start_offset")))
            for count, increment, start in increments:
                columns.append(("waveform time", "s", start + increment * np.arange(count)))
            tables += table_of(name if len(groups) > 1 else "", columns)
    return tables


def _number(channel: Any, name: str) -> float:
    """Give a property that is a number; 0 for any other."""
    value = channel.properties.get(name, 0.0)
    return float(value) if isinstance(value, int | float) and math.isfinite(value) else 0.0


def _unit(channel: Any) -> str:
    return next((str(channel.properties[name]).strip() for name in UNITS if channel.properties.get(name)), "")


FORMAT = Format(
    name="NI TDMS",
    suffixes=(".tdms",),
    begins=lambda head: head[:4] == b"TDSm",
    read=read,
    module="nptdms",
    package="npTDMS",
)
