"""Which channel is a quantity, where names and units tell it; else the question, and what would answer it."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_identification.importing.channels.naming import (
    SEGMENT,
    fits_unit,
    integrations_of,
    is_count,
    is_extreme,
    is_frequency,
    is_of_another,
    is_something_else,
    rank,
    serves,
    unit_of,
)
from pipeclamp_identification.importing.raw import Channel, RawTable
from pipeclamp_identification.units.stated import OURS, Quantity, is_unit, quantity_of_unit
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.units import unit_shown

NEEDED = ("time", "displacement", "force")
NONE = "none"
"""States that a quantity isn't there."""
MOST_FALLS = 0.1
"""Share of its steps in which a time may fall, as it does where a clock begins anew."""
STILL_SHARE = 0.02
"""Standard deviation of a channel that hardly moves, as a share of its mean."""
SLOW = 1.0
"""Steps of a time without a unit from which on milliseconds are likelier than seconds."""
USUAL = {"time": ("s", "ms"), "displacement": ("mm", "m"), "force": ("N", "kN"), "temperature": ("°C", "K")}
"""Units that a channel without one may be in, the first of them ours."""
NO_UNIT = ("", "-", "--", "1")
SYMBOLS = {"time": ("t",), "displacement": ("x", "y", "d", "s", "u", "z"), "force": ("f", "p")}
"""Letters that stand for a quantity: of channels without a unit, those that are called so are proposed first."""
NAMED = 3
"""Rank of a channel from which on its name surely is a quantity's."""
A_RATE = 0.99
"""Correlation from which on a channel is another one's rate of change: a speed beside its displacement."""
LOOKED_AT = 20_000
"""Samples by which that is told; files may hold millions."""


@dataclass(frozen=True)
class Choice:
    """An entry of --columns, and the channel that it takes; "" for none."""

    text: str
    channel: str


@dataclass(frozen=True)
class Question:
    """What names and units don't tell: of which quantity, why, and the entries of --columns that would.

    `is_missing`: nothing in the table looks like it.
    """

    ours: str
    why: str
    choices: tuple[Choice, ...]
    is_missing: bool = False

    def as_others(self, units: Mapping[str, str]) -> Question:
        """Give it with the choice first that other files state, which is said; `units` by names of channels."""
        theirs = [one for one in self.choices if one.text.endswith(f" [{units.get(one.channel)}]")]
        if not theirs:
            return self
        why = f"{self.why}; other files state {units[theirs[0].channel]}"
        return replace(self, why=why, choices=(*theirs, *(one for one in self.choices if one not in theirs)))


def find(
    quantity: Quantity, table: RawTable, taken: Collection[str], stated: Mapping[str, str]
) -> Channel | Question | None:
    """Find the channel of a quantity; a question where several may be it, or its unit isn't known.

    Args:
        quantity: time, displacement, force, temperature or segment; of the last two there may be none.
        table: as a file holds it.
        taken: headings of channels that are something else.
        stated: what the user says that channels are, by heading.
    """
    channels = [channel for channel in table.channels if channel.heading not in taken]
    ranked: dict[int, list[Channel]] = {}
    for channel in channels:
        if own := rank(quantity, channel):
            ranked.setdefault(own, []).append(channel)
    if ranked:
        best = ranked[max(ranked)]
        if quantity == "time" and len(best) > 1:
            best = list(_that_go_on(best))
        if len(best) > 1:
            return None if quantity == SEGMENT else _which(quantity, best)
        (channel,) = best
        if quantity == "force" and (moving := _move_in_its_place(channel, channels)):
            return _which(quantity, [channel, *moving])
        return channel if quantity == SEGMENT or unit_of(channel) else _in_which_unit(quantity, channel)
    if quantity == SEGMENT:
        return None
    if called := [channel for channel in channels if is_of_another(quantity, channel)]:
        return _in_another_unit(quantity, called, channels)
    return _missing(quantity, table, channels, stated) if quantity in NEEDED else None


def _move_in_its_place(force: Channel, channels: Sequence[Channel]) -> list[Channel]:
    """Give the other channels in a unit of force that move, where the one that is called so hardly does.

    A constant load that a bearing bears stands beside the force of its motion.
    """
    if _moves(force):
        return []
    return [one for one in channels if one is not force and serves("force", one) and _moves(one)]


def _moves(channel: Channel) -> bool:
    """Tell whether a channel's values differ by more than the noise of a constant one."""
    values = channel.values[np.isfinite(channel.values)]
    largest = float(np.max(np.abs(values), initial=0.0))
    if largest == 0:
        return False
    shares = values / largest  # the squares of a damaged file's numbers may be beyond all numbers
    return bool(np.std(shares) > STILL_SHARE * abs(float(np.mean(shares))))


def _that_go_on(times: Sequence[Channel]) -> Sequence[Channel]:
    """Give the times that don't begin anew with each cycle or block, where one at least doesn't; equal ones once."""
    going = [channel for channel in times if not np.any(np.diff(channel.values) < 0)] or times
    same = all(np.array_equal(going[0].values, one.values, equal_nan=True) for one in going[1:])
    return going[:1] if same else going


def _which(quantity: Quantity, best: Sequence[Channel]) -> Question:
    best = sorted(best, key=lambda channel: not _moves(channel))
    names = ", ".join(repr(channel.heading) for channel in best)
    return Question(quantity, f"{len(best)} channels may be the {quantity}: {names}", _choices(quantity, best))


def _in_which_unit(quantity: Quantity, channel: Channel) -> Question:
    units = USUAL[quantity]
    # of a time that stands in every other row no two samples follow each other
    steps = np.diff(channel.values[np.isfinite(channel.values)])
    if quantity == "time" and len(steps) and abs(float(np.median(steps))) >= SLOW:
        units = units[::-1]
    return Question(
        quantity,
        f"no {'known ' if channel.heading.endswith(']') else ''}unit is stated of {channel.heading!r}",
        tuple(Choice(f"{quantity}={channel.heading} [{unit}]", channel.heading) for unit in units),
    )


def _in_another_unit(quantity: Quantity, called: Sequence[Channel], channels: Sequence[Channel]) -> Question:
    """Ask about channels that are called so, but in a unit of something else, or in one that nobody knows."""
    unit = unit_of(called[0])
    of = quantity_of_unit(unit)
    if of:
        what = f"a unit of {of}"
    elif is_unit(unit) and unit not in NO_UNIT:
        what = f"no unit of {quantity}: state how much 1 {unit} is"
    else:
        what = "no known unit"
    if len(called) == 1 and not of and unit in NO_UNIT:
        return _in_which_unit(quantity, called[0])
    fitting = [channel for channel in channels if serves(quantity, channel)]
    return Question(
        quantity,
        f"{called[0].heading!r} is called a {quantity}, but {unit!r} is {what}",
        _choices(quantity, [*called, *fitting]),
    )


def _missing(quantity: Quantity, table: RawTable, channels: Sequence[Channel], stated: Mapping[str, str]) -> Question:
    """Ask which channel is a quantity that none is called; those without a unit come first. Arguments as of `find`."""
    reached = [one for one in table.channels if is_extreme(quantity, one)]
    if len(reached) > 1:
        why = f"{reached[0].heading!r} is what a cycle reached, no sample of the {quantity}: take the file of samples"
        return Question(quantity, why, (), is_missing=True)
    likely = _likely(quantity, channels)
    rates = [one for one in channels if integrations_of(one)] if quantity == "displacement" else []
    # forces stand over speeds in tables without a time, too, but over no accelerations
    timed = any(rank("time", one) >= NAMED for one in table.channels)
    integrable = [one for one in rates if timed or integrations_of(one) > 1]
    if rates:
        likely = [*integrable, *(one for one in likely if not quantity_of_unit(unit_of(one)) and one not in rates)]
    if integrable:
        why = f"no channel is called a displacement, but {integrable[0].heading!r} can be integrated to one"
    elif rates:
        why = f"{rates[0].heading!r} is a speed, and forces over speeds are no loops: take the records"
    else:
        why = _why_missing(quantity, table, stated)
    return Question(quantity, why, _choices(quantity, likely), is_missing=True)


def _likely(quantity: Quantity, channels: Sequence[Channel]) -> list[Channel]:
    """Give the channels that may be a quantity that none is called, likeliest first."""
    # what surely is something else would serve, but wrongly
    some = [
        one
        for one in channels
        if not is_count(one) and not is_something_else(quantity, one) and rank(SEGMENT, one) < NAMED
    ]
    likely = _likely_times(some) if quantity == "time" else _likely_motions(some)
    return sorted(likely, key=lambda one: one.name.casefold().strip() not in SYMBOLS.get(quantity, ()))


def _likely_times(channels: Sequence[Channel]) -> list[Channel]:
    """Give the channels that rise as a time does; what is in another unit, or a spectrum's axis, is no time."""
    fitting = [one for one in channels if unit_of(one) in NO_UNIT or fits_unit("time", unit_of(one))]
    return [one for one in fitting if _rises(one.values) and not is_frequency(one)]


def _likely_motions(channels: Sequence[Channel]) -> list[Channel]:
    """Give the channels by their units: of none, of a unit that nobody knows, of another quantity; rates come last."""
    plain = [one for one in channels if unit_of(one) in NO_UNIT]
    others = [one for one in channels if unit_of(one) not in NO_UNIT]
    by_unit = [*plain, *sorted(others, key=lambda one: bool(quantity_of_unit(unit_of(one))))]
    rates = _likeness_to_rates(by_unit)
    return sorted(by_unit, key=lambda one: rates[one.heading])


def _why_missing(quantity: Quantity, table: RawTable, stated: Mapping[str, str]) -> str:
    """Say why no channel is a quantity.

    Args:
        quantity: the quantity.
        table: as a file holds it.
        stated: what the user says that channels are, by heading.
    """
    texts = [column for column in table.unread if column.is_whole and rank(quantity, column.channel)]
    if texts:
        return f"{texts[-1].words()}, so there is no {quantity}: export it as numbers"
    other = next((one.heading for one in table.channels if one.heading in stated and rank(quantity, one)), None)
    if other is None and (called := _called_otherwise(quantity, table.channels)):
        return called
    why = f"no {'other ' if other else ''}channel is called a {quantity} or is in a unit of one"
    return why if other is None else f"--columns states {other!r} as {stated[other]}, and {why}"


def _called_otherwise(quantity: Quantity, channels: Sequence[Channel]) -> str:
    """Say which channel is in a unit of a quantity, but is called another one; "" where none is."""
    for one in channels:
        other = next((other for other in OURS if is_of_another(other, one)), None)
        if other and quantity_of_unit(unit_of(one)) == quantity:
            return f"{one.heading!r} is in a unit of {quantity}, but is called a {other}"
    return ""


def _rises(values: Array) -> bool:
    """Tell whether samples rise as a time does, but for where a clock begins anew."""
    step = np.diff(values[np.isfinite(values)])
    return bool(np.any(step > 0)) and int(np.count_nonzero(step < 0)) <= MOST_FALLS * len(step)


def _likeness_to_rates(channels: Sequence[Channel]) -> Mapping[str, float]:
    """Give how surely each channel, by its heading, is the rate of change of another one, 0 where it isn't."""
    if len(channels) < 2:
        return {channel.heading: 0.0 for channel in channels}
    values = np.nan_to_num(np.array([channel.values[:LOOKED_AT] for channel in channels]))
    if values.shape[1] < 2:
        return {channel.heading: 0.0 for channel in channels}
    own, change = _normed(values), _normed(np.gradient(values, axis=1))
    likeness = own @ change.T
    np.fill_diagonal(likeness, 0.0)
    most = np.max(likeness, axis=1)
    return {one.heading: float(like) if like >= A_RATE else 0.0 for one, like in zip(channels, most, strict=True)}


def _normed(values: Array) -> Array:
    """Give rows about their means, so that their products are correlations."""
    about = values - np.mean(values, axis=1, keepdims=True)
    size = np.linalg.norm(about, axis=1, keepdims=True)
    normed: Array = np.divide(about, size, out=np.zeros_like(about), where=size > 0)
    return normed


def _choices(quantity: Quantity, channels: Sequence[Channel]) -> tuple[Choice, ...]:
    """Give an entry that serves for each channel; and one that there is none, of a quantity that isn't needed."""
    choices = [Choice(f"{quantity}={_with_unit(quantity, channel)}", channel.heading) for channel in channels]
    return (*choices, *(() if quantity in NEEDED else (Choice(f"{quantity}={NONE}", ""),)))


def _with_unit(quantity: Quantity, channel: Channel) -> str:
    """Give a channel as --columns takes it: its unit behind it where the file states none, or none of the quantity.

    What is measured in volts or parts of a hundred must be said what one of them is: [1 N] leaves the number to change.
    """
    unit, ours = unit_of(channel), unit_shown(OURS[quantity])
    if fits_unit(quantity, unit) or (quantity == "displacement" and integrations_of(channel)):
        return channel.heading
    scaled = unit not in NO_UNIT and is_unit(unit) and not quantity_of_unit(unit)
    return f"{channel.heading} [{'1 ' if scaled else ''}{ours}]"
