"""TDMS of National Instruments' LabVIEW and DIAdem, by npTDMS; a waveform's own increment is its time."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from pipeclamp_identification.importing.raw import (
    Damaged,
    Format,
    LabelColumn,
    RawTable,
    refuse_size,
    table_of,
)
from pipeclamp_identification.importing.texts.labels import Labels
from pipeclamp_models.base.tables import pl

UNITS = ("unit_string", "NI_UnitDescription", "unit", "Unit")
"""Properties in which programs state a channel's unit."""


def read(path: Path) -> Sequence[RawTable]:
    """Read a table for each group, of the channels of one length each.

    Raises:
        Damaged: it breaks off before every channel has a sample.
    """
    from nptdms import TdmsFile

    size = path.stat().st_size
    with TdmsFile.open(path) as file:
        groups = [(group, dict(file.properties) | dict(group.properties)) for group in file.groups()]
        return [
            replace(table, properties=properties)
            for group, properties in groups
            for table in _tables(group.name if len(groups) > 1 else "", group.channels(), size, _lacking(file))
        ]


def _lacking(file: Any) -> dict[str, int]:
    """Give how many samples each channel, by its path, lacks where the file breaks off."""
    statuses = file.file_status.channel_statuses or {}
    short = {path: one.expected_length - one.read_length for path, one in statuses.items()}
    return {path: count for path, count in short.items() if count > 0}


def _tables(name: str, channels: Sequence[Any], size: int, lacking: Mapping[str, int]) -> list[RawTable]:
    """Give the tables of a group's channels; texts are labels of those that are as long.

    Args:
        name: of the group.
        channels: as npTDMS gives them.
        size: bytes of the file.
        lacking: samples that channels lack where the file breaks off: those beside them end where they do.
    """
    whole = {channel.path: len(channel) + lacking.get(channel.path, 0) for channel in channels}
    ends = {length: min(len(one) for one in channels if whole[one.path] == length) for length in whole.values()}
    cut = {length: end for length, end in ends.items() if end < length}
    for channel in channels:
        if whole[channel.path] and not len(channel):
            raise Damaged(
                f"breaks off: of {channel.name!r} it holds none of {whole[channel.path]} samples; copy it again"
            )
    columns: list[tuple[str, str, object]] = []
    labels: list[LabelColumn] = []
    increments = set()
    for channel in channels:
        refuse_size(f"channel {channel.name!r}", len(channel), size)
        if not len(channel):
            continue
        samples = channel[: ends[whole[channel.path]]]
        kind = samples.dtype.kind if isinstance(samples, np.ndarray) else "O"
        if kind in "OUS":
            texts = Labels()
            texts.add(pl.Series(list(map(str, samples)), dtype=pl.String))
            labels += filter(None, [texts.column(channel.name, "", len(samples))])
        elif kind == "M":
            # stamps of time, in seconds since the first
            columns.append((channel.name, "s", (samples - samples[0]) / np.timedelta64(1, "ns") * 1e-9))
        else:
            columns.append((channel.name, _unit(channel), samples))
        if (increment := _number(channel, "wf_increment")) > 0:
            increments.add((len(samples), increment, _number(channel, "wf_start_offset")))
    for count, increment, start in increments:
        columns.append(("waveform time", "s", start + increment * np.arange(count)))
    words = tuple(f"the file breaks off: {end} of {length} samples are taken" for length, end in cut.items())
    return [
        replace(table, joined=words, labels=tuple(label for label in labels if len(label.values) == table.length))
        for table in table_of(name, columns)
    ]


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
