"""A campaign before any test: which runs, in which order, and which effects they would name in how many hours."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_identification.diagnosis.further_test.limits import Limits, limits_words, reach_around, stated_levels
from pipeclamp_identification.diagnosis.further_test.outlook import PROFILES, SINE
from pipeclamp_identification.planning.hidden import peak_forces
from pipeclamp_identification.planning.loop_tests import RIG
from pipeclamp_identification.planning.rig_times import HOURS, RIG_TIMES, SCATTER_BEFOREHAND, RigTimes
from pipeclamp_identification.planning.scene import Scene, scene
from pipeclamp_identification.planning.schedule import (
    LABORATORY,
    AmplitudeAndFrequency,
    ScheduledRun,
    hours_of,
    scheduled,
)
from pipeclamp_identification.planning.telling import Power, power
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UsageError
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.file import LawFile
from pipeclamp_models.law.range import celsius_tested

MOST_LEVELS = {"A": 7, "f": 7, "T": 5}
"""Levels within the limits, of which plans take some."""
LEVEL_COUNTS = {"A": (3, 4, 5, 7), "f": (3, 4, 5, 7), "T": (1, 3, 5)}
"""Numbers of levels: from fewer than three no law can be foretold at their ends, and no form be judged."""
MOST_REPEATS = 6
AS_GOOD_TIMES = 1.05
"""A plan that needs an effect this many times as large as another one's names as well; the shorter one is taken."""
LONGER_TIMES = 2.0
"""Times the hours, up to which plans are looked at, to say what more time would give."""
PROFILE = PROFILES[SINE]


@dataclass(frozen=True)
class PlanRequest:
    """What a campaign is planned for.

    Attributes:
        hours: rig hours that it may take.
        noise_N: rms noise of the force.
        scatter: rms share by which stiffness and damping differ from run to run.
        rate: samples per second.
        times: what the rig needs besides the runs.
        seed: of the random order.
    """

    hours: float = HOURS
    noise_N: float = RIG.force_noise
    scatter: float = SCATTER_BEFOREHAND
    rate: float = RIG.rate
    times: RigTimes = RIG_TIMES
    seed: int = 0

    def check(self) -> None:
        """Refuse what can't be planned for.

        Raises:
            UsageError: a number is out of its range.
        """
        for name, value in (
            ("--hours", self.hours), ("--force-noise", self.noise_N), ("--heating", self.times.heating)
        ):  # fmt: skip
            if not (math.isfinite(value) and value > 0):
                raise UsageError(f"{name}: got {value:g}; expected a number above 0")
        for name, value in (
            ("--scatter", self.scatter), ("--soak", self.times.soak_min), ("--pause", self.times.pause_s)
        ):  # fmt: skip
            if not (math.isfinite(value) and value >= 0):
                raise UsageError(f"{name}: got {value:g}; expected a number of at least 0")


@dataclass(frozen=True)
class PlanStage:
    """What is known after a block: hours, and the rms force above which nine of ten effects are named; None: none."""

    temperature_C: float
    hours: float
    newtons: float | None
    told: int


@dataclass(frozen=True)
class TriedPlan:
    """A plan that was looked at: its hours, its runs, what it names, and how many effects it can tell."""

    hours: float
    runs: int
    newtons: float
    told: int


@dataclass(frozen=True, eq=False)
class CampaignPlan:
    """A campaign before any test.

    Attributes:
        law: name of the law that the clamp is expected to be like.
        asked: what it was planned for.
        limits: closed ones, within which it lies.
        timed: whether the law's tests had a time; otherwise its frequency is a name for a cycle at any rate.
        runs: in their order.
        repeats: of each condition.
        hours: that it takes.
        power: what it names.
        stages: after each block of one temperature.
        tried: all plans that were looked at.
        about_mm: displacement about which the law's tests moved, where that isn't about zero.
    """

    law: str
    asked: PlanRequest
    limits: Limits
    timed: bool
    runs: tuple[ScheduledRun, ...]
    repeats: int
    hours: float
    power: Power
    stages: tuple[PlanStage, ...]
    tried: tuple[TriedPlan, ...]
    about_mm: float | None


def plan_campaign(
    file: LawFile, limits: Limits | None = None, asked: PlanRequest | None = None, progress: Progress = silent
) -> CampaignPlan:
    """Give the campaign that names the most and the smallest effects within its hours.

    Args:
        file: a law like that which the clamp is expected to have: its base law stands for the clamp.
        limits: what the rig can do; where nothing is stated, around that law's data.
        asked: what the campaign is for.
        progress: told what is being done.

    Raises:
        UsageError: nothing can be driven within the limits, or no campaign fits into the hours.
    """
    asked = asked or PlanRequest()
    asked.check()
    levels = _Levels(_within(file, limits))
    levels.refuse_force(peak_forces(file, levels.grid))
    schedules = list(_schedules(levels, asked))
    if not any(hours <= asked.hours for hours, *_ in schedules):
        shortest = f"; the shortest takes {min(hours for hours, *_ in schedules):.2g} h" if schedules else ""
        raise UsageError(f"--hours: got {asked.hours:g}; no campaign fits into that{shortest}")
    view = scene(file, levels.grid, asked.noise_N, asked.rate, asked.scatter, progress)
    tried: list[TriedPlan] = []
    fitting: list[tuple[TriedPlan, int, tuple[ScheduledRun, ...], Power]] = []
    for hours, repeats, runs in schedules:
        if hours > LONGER_TIMES * asked.hours:
            continue
        found = power(view, levels.counted(runs))
        one = TriedPlan(hours, len(runs), found.from_newtons, int(found.told.sum()))
        tried.append(one)
        if hours <= asked.hours:
            fitting.append((one, repeats, runs, found))
    most = max(one.told for one, *_ in fitting)
    lowest = min(one.newtons for one, *_ in fitting if one.told == most)
    as_good = [each for each in fitting if each[0].told == most and each[0].newtons <= AS_GOOD_TIMES * lowest]
    best, repeats, runs, found = min(as_good, key=lambda each: each[0].hours)
    stages = tuple(_stages(runs, levels, view, asked))
    return CampaignPlan(
        file.name, asked, levels.limits, file.data.is_timed, runs, repeats, best.hours, found, stages,
        tuple(dict.fromkeys(tried)), file.data.about_mm,
    )  # fmt: skip


def _schedules(levels: _Levels, asked: PlanRequest) -> Iterator[tuple[float, int, tuple[ScheduledRun, ...]]]:
    """Give hours, repeats and runs of campaigns, of each choice of levels up to the first that takes far too long."""
    for counts in itertools.product(*LEVEL_COUNTS.values()):
        conditions, temperatures = levels.some(*counts)
        for repeats in range(1, MOST_REPEATS + 1) if conditions else ():
            runs = scheduled(conditions, temperatures, repeats, asked.times, asked.seed)
            hours = hours_of(runs, asked.times)
            yield hours, repeats, runs
            if hours > LONGER_TIMES * asked.hours:
                break


def _within(file: LawFile, limits: Limits | None) -> Limits:
    """Give closed limits: as stated, else around a law's data."""
    A, f, T = (file.range.get(name) for name in ("A", "f", "T"))
    assert A is not None and f is not None, "a law's file holds both"
    celsius = celsius_tested(T) if T else (LABORATORY, LABORATORY)
    ends = replace(Limits(), amplitude=(A.minimum, A.maximum), frequency=(f.minimum, f.maximum), temperature=celsius)
    return reach_around(ends.amplitude, ends.frequency, ends.temperature, limits or ends, timed=file.data.is_timed)


class _Levels:
    """The finest levels within limits, every combination of them, and which of these a sine test can drive."""

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        A, f, T = limits.amplitude, limits.frequency, limits.temperature
        self.A = stated_levels(np.geomspace(A[0], A[1] / PROFILE.peak_displacement, MOST_LEVELS["A"]), *A)
        self.f = stated_levels(np.geomspace(*f, MOST_LEVELS["f"]), *f)
        self.T = stated_levels(np.linspace(*T, MOST_LEVELS["T"]), *T)
        every = np.array(list(itertools.product(self.A.tolist(), self.f.tolist(), self.T.tolist())))
        slow = PROFILE.peak_velocity * every[:, 0] * every[:, 1] <= limits.velocity
        if not slow.any():
            raise UsageError(f"--limits: no sine test keeps all of {limits_words(limits)}; expected wider ones")
        every = every[slow]
        self.grid = {"A": every[:, 0], "f": every[:, 1], "T": every[:, 2] + CELSIUS}
        self._rows = {tuple(row): place for place, row in enumerate(every.tolist())}

    def refuse_force(self, peak: Array) -> None:
        """Leave out conditions that ask for more than the rig's force, by the law's largest there, N, shape (R,)."""
        self._rows = {one: place for one, place in self._rows.items() if peak[place] <= self.limits.force}

    def some(self, A: int, f: int, T: int) -> tuple[list[AmplitudeAndFrequency], list[float]]:
        """Give so many levels of each, evenly chosen: the conditions of a block, and the temperatures."""
        temperatures = _spread(self.T, T)
        pairs = itertools.product(_spread(self.A, A), _spread(self.f, f))
        return [pair for pair in pairs if all((*pair, celsius) in self._rows for celsius in temperatures)], temperatures

    def counted(self, runs: Iterable[ScheduledRun]) -> Array:
        """Give how many runs there are at each condition, shape (R,)."""
        found = np.zeros(len(self.grid["A"]))
        for run in runs:
            found[self._rows[run.amplitude_mm, run.frequency_Hz, run.temperature_C]] += 1
        return found


def _spread(levels: Array, count: int) -> list[float]:
    """Give so many of the levels, both ends among them; of one alone the first."""
    places = np.unique(np.round(np.linspace(0, len(levels) - 1, count)).astype(int))
    return [float(value) for value in levels[places]]


def _stages(runs: Sequence[ScheduledRun], levels: _Levels, view: Scene, asked: PlanRequest) -> Iterator[PlanStage]:
    """Give what is known after each block."""
    for block in range(1, runs[-1].block + 1):
        so_far = [run for run in runs if run.block <= block]
        found = power(view, levels.counted(so_far))
        newtons = found.from_newtons
        yield PlanStage(
            so_far[-1].temperature_C, hours_of(so_far, asked.times), newtons if math.isfinite(newtons) else None,
            int(found.told.sum()),
        )  # fmt: skip
