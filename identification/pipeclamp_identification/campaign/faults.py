"""Faults of sensors, told as such before physics is asked: what they are, how large, in which runs, what was done."""

from __future__ import annotations

from collections.abc import Sequence
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
        "it doesn't follow the motion; zero_drift, gain_drift: its zero or its gain moves"
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


def runs_named(runs: Sequence[str]) -> str:
    """Name runs, a few of many."""
    return few_of(runs, MOST_RUNS_NAMED)
