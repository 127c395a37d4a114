"""Channels that are made of several: the way between two sides, the sum of load cells, the mean of gauges."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_identification.importing.channels.columns import UNIT_BEHIND, Stated, channels_called
from pipeclamp_identification.importing.channels.naming import unit_of
from pipeclamp_identification.importing.raw import Channel, RawTable
from pipeclamp_models.base.errors import UserError

MEAN = re.compile(r"mean\((.+)\)", re.IGNORECASE)
SIGNS = re.compile(r" ([+-]) ")
"""Between channels: a hyphen within a name has no blanks beside it, as a rule."""


@dataclass(frozen=True)
class Combined:
    """Channels, how they count, and what comes of them is called."""

    name: str
    channels: tuple[Channel, ...]
    weights: tuple[float, ...]


def with_combined(table: RawTable, stated: Sequence[Stated]) -> RawTable:
    """Give a table with the channels that are stated as made of others, in the place of these.

    Args:
        table: as a file holds it.
        stated: what the user says; of one that is in the table as it is called, nothing is made.

    Raises:
        UserError: what it is made of is in different units.
    """
    parts: list[Channel] = []
    made = []
    for one in stated:
        found = None if channels_called(table, one.channel) else _combined(table, one.channel)
        if found is None:
            continue
        units = {unit_of(channel) for channel in found.channels}
        if len(units) > 1:
            raise UserError(
                f"--columns, {one.ours}={one.channel}: "
                f"{' and '.join(repr(channel.heading) for channel in found.channels)} are in different units; "
                "expected channels of one unit"
            )
        values = np.stack([channel.values for channel in found.channels])
        made.append(Channel(found.name, units.pop(), np.asarray(np.tensordot(found.weights, values, 1))))
        parts += found.channels
    if not made:
        return table
    kept = {channel.heading for one in stated for channel in channels_called(table, one.channel)}
    gone = {channel.heading for channel in parts} - kept
    return replace(table, channels=(*(one for one in table.channels if one.heading not in gone), *made))


def _combined(table: RawTable, text: str) -> Combined | None:
    """Give what a text makes of a table's channels; None where it names none of them.

    A unit may stand behind all of it, where the file states none.
    """
    bodies = [text, *([found[1]] if (found := UNIT_BEHIND.fullmatch(text)) else [])]
    for body in bodies:
        for names, weights in _ways(body):
            channels = [channels_called(table, name) for name in names]
            if all(len(called) == 1 for called in channels):
                return Combined(body, tuple(called[0] for called in channels), tuple(weights))
    return None


def _ways(text: str) -> Iterator[tuple[list[str], list[float]]]:
    """Give the names of channels that a text may hold, and how each counts."""
    if mean := MEAN.fullmatch(text):
        names = [name.strip() for name in mean[1].split(",")]
        yield names, [1 / len(names)] * len(names)
    names, signs = SIGNS.split(text)[::2], SIGNS.findall(text)
    if signs:
        yield [name.strip() for name in names], [1.0, *(float(f"{sign}1") for sign in signs)]
    for sign in SIGNS.finditer(text):  # a name may hold others
        yield [text[: sign.start()].strip(), text[sign.end() :].strip()], [1.0, float(f"{sign[1]}1")]
