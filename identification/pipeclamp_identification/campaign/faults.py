"""Faults of sensors, told as such before physics is asked: what they are, how large, in which runs, what was done."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from pydantic import Field

from pipeclamp_identification.campaign.records import UnusableRecord
from pipeclamp_models.base.answer import AnswerModel
from pipeclamp_models.base.said import counted, few_of

Channel = Literal["force", "displacement"]
FaultKind = Literal["clipped", "stuck", "dead", "zero_drift", "gain_drift"]
Done = Literal["left out", "corrected", "kept"]

MOST_RUNS_NAMED = 4
"""Runs that a sentence names one by one."""
NEEDS = {
    "clipped": "to do: repeat them within the sensor's range, or with a larger one",
    "stuck": "to do: look at plug and logger, and repeat them",
    "dead": "to do: look at sensor, plug and amplifier, and repeat them",
}
"""What to do about runs that can't be used."""


class FaultyRun(AnswerModel):
    """A run that shows a fault, and how large it is there."""

    run: str
    size: float | None = Field(description="of the fault, in its unit; null where it has no size in one run alone")
    standard_error: float | None


class SensorFault(AnswerModel):
    """A gross fault of a sensor, found in the records before any law is asked."""

    channel: Channel
    fault: FaultKind = Field(
        description="clipped: it stands at the end of its range; stuck: it stands still while the other goes on; dead: "
        "it doesn't follow the motion; zero_drift, gain_drift: its zero or its gain moves (of the force, or the "
        "device changes as a whole)"
    )
    over: Literal["record", "campaign"] = Field(description="whether it shows inside records, or from run to run")
    size: float | None = Field(description="of the largest, in `unit`: clipped at; drift from first to last")
    unit: str
    runs: tuple[FaultyRun, ...]
    done: Done = Field(description="what was done with these runs before anything was fitted")
    words: str


class SensorFailure(UnusableRecord):
    """A record that can't be used because a sensor failed: its channel, how, at which value."""

    def __init__(self, reason: str, channel: Channel, fault: FaultKind, size: float | None, unit: str) -> None:
        super().__init__(reason)
        self.channel, self.fault, self.size, self.unit = channel, fault, size, unit

    def __reduce__(self) -> tuple[type[SensorFailure], tuple[str, Channel, FaultKind, float | None, str]]:
        """Give how to make a copy: a campaign may go to another process."""
        return SensorFailure, (str(self), self.channel, self.fault, self.size, self.unit)


def faults_of_failures(failures: Sequence[tuple[str, SensorFailure]]) -> tuple[SensorFault, ...]:
    """Give the faults for which runs were left out, those alike together; failures with their run's name."""
    together: dict[tuple[Channel, FaultKind], list[tuple[str, SensorFailure]]] = {}
    for run, failure in failures:
        together.setdefault((failure.channel, failure.fault), []).append((run, failure))
    found = []
    for (channel, kind), members in together.items():
        sizes = [abs(failure.size) for _, failure in members if failure.size is not None]
        count = counted(len(members), "run")
        words = (
            f"the {channel} channel is {kind} in {count} ({runs_named([run for run, _ in members])}): {members[0][1]}; "
            f"left out; {NEEDS[kind]}"
        )
        found.append(
            SensorFault(
                channel=channel,
                fault=kind,
                over="record",
                size=max(sizes, default=None),
                unit=members[0][1].unit,
                runs=tuple(FaultyRun(run=run, size=one.size, standard_error=None) for run, one in members),
                done="left out",
                words=words,
            )
        )
    return tuple(found)


@dataclass(frozen=True)
class StuckInPart:
    """A channel that stands still beside the steady cycles of a record, while the other one goes on.

    Attributes:
        channel: which.
        from_s, to_s: from when to when, by the record's clock.
        value: at which it stands, in the channel's unit.
        unit: of it.
    """

    channel: Channel
    from_s: float
    to_s: float
    value: float
    unit: str


def faults_of_parts(stuck: Mapping[str, StuckInPart]) -> tuple[SensorFault, ...]:
    """Give the faults of runs, by name, in whose records a channel stands still for a part: the others are used."""
    found = []
    for channel in dict.fromkeys(one.channel for one in stuck.values()):
        members = {run: one for run, one in stuck.items() if one.channel == channel}
        where = runs_named([f"{run}: from {one.from_s:.4g} to {one.to_s:.4g} s" for run, one in members.items()])
        found.append(
            SensorFault(
                channel=channel,
                fault="stuck",
                over="record",
                size=max(abs(one.value) for one in members.values()),
                unit=next(iter(members.values())).unit,
                runs=tuple(FaultyRun(run=run, size=one.value, standard_error=None) for run, one in members.items()),
                done="kept",
                words=(
                    f"the {channel} channel is stuck in a part of {counted(len(members), 'run')} ({where}): it stands "
                    "still while the other channel goes on; that part is cut off, and only the cycles beside it are "
                    f"used; {NEEDS['stuck']}"
                ),
            )
        )
    return tuple(found)


def runs_named(runs: Sequence[str]) -> str:
    """Name runs, a few of many."""
    return few_of(runs, MOST_RUNS_NAMED)
