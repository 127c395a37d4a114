"""The rigs that virtual devices are put on: test plans, and how well the rig drives and measures."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from devices.drive import Array, Drive, ramped
from devices.hysteresis import Parameters
from devices.registry import Device

CURRENT = "current_A"
RAMP_CYCLES = 1.0
CYCLES = 5.0
MOST_EXTRA = 0.4
"""Share of a cycle by which records are longer, at most."""
AMPLITUDE_ERROR = 0.01
"""Standard deviation from run to run, of the amplitude set."""
TEMPERATURE_ERROR = 1.0
"""K, likewise."""
NOISES = (0.003, 0.01)
"""Rms force noise as a share of the campaign's rms force."""
DISPLACEMENT_NOISE = 2e-4
"""Rms, as a share of the largest amplitude."""
WANDER = 0.1
"""Standard deviation from run to run of the drive's distortion, as a share of it."""
STABLE = 0.7
"""Largest step times the fastest rate of a state: a quarter of what the Runge-Kutta method is stable up to."""


@dataclass(frozen=True)
class Plan:
    """A test plan: every combination of A mm, f Hz, T degC and current is a run."""

    A: tuple[float, ...]
    f: tuple[float, ...]
    T: tuple[float, ...]
    current: tuple[float, ...] = ()


@dataclass(frozen=True)
class Rig:
    """A test rig.

    Attributes:
        campaign, held_out: test plans.
        rate: samples per second.
        force: lowest and highest order of the force, N.
    """

    campaign: Plan
    held_out: Plan
    rate: float
    force: tuple[float, float]

    @property
    def largest(self) -> float:
        """Largest amplitude, mm."""
        return max(self.campaign.A)

    @property
    def turn(self) -> float:
        """Circular frequency in the middle of the plan, rad/s."""
        return 2 * math.pi * math.sqrt(min(self.campaign.f) * max(self.campaign.f))


RIGS = {
    "clamp": Rig(
        Plan((0.2, 0.5, 0.8, 1.0), (1.0, 3.0, 5.0), (20.0, 150.0, 300.0)),
        Plan((0.35, 0.9), (2.0, 4.0), (80.0, 220.0)), 500.0, (200.0, 3000.0),
    ),
    "mount": Rig(
        Plan((0.1, 0.2, 0.5, 1.0), (4.0, 8.0, 15.0, 25.0), (23.0,)),
        Plan((0.15, 0.35, 0.75), (6.0, 11.0, 20.0), (23.0,)), 1000.0, (10.0, 2000.0),
    ),
    "damper": Rig(
        Plan((10.0, 20.0, 35.0, 50.0), (0.25, 0.5, 1.0, 2.0), (20.0,)),
        Plan((15.0, 28.0, 45.0), (0.35, 0.75, 1.5), (20.0,)), 200.0, (5e3, 1e5),
    ),
    "bench": Rig(
        Plan((1.0, 2.5, 5.0, 8.0), (0.2, 1.0, 4.0), (-10.0, 20.0, 50.0)),
        Plan((1.7, 6.5), (0.5, 2.0), (5.0, 35.0)), 500.0, (50.0, 2e4),
    ),
    "controlled bench": Rig(
        Plan((1.0, 2.5, 5.0, 8.0), (0.5, 1.5, 4.0), (20.0,), (0.0, 0.5, 1.0)),
        Plan((1.7, 6.5), (1.0, 2.5), (20.0,), (0.25, 0.75)), 500.0, (300.0, 5e3),
    ),
    "controlled damper": Rig(
        Plan((10.0, 25.0, 50.0), (0.25, 0.7, 2.0), (20.0,), (0.0, 0.7, 1.4, 2.0)),
        Plan((17.0, 40.0), (0.4, 1.3), (20.0,), (0.3, 1.0, 1.7)), 200.0, (1e4, 1e5),
    ),
}  # fmt: skip
"""By name: a shaker with an oven, a shaker for mounts, a seismic test machine, a universal one, and with current."""


@dataclass(frozen=True)
class Set:
    """What was set in a run; None where the rig has no such condition."""

    A: float
    f: float
    T: float
    current: float | None

    @property
    def name(self) -> str:
        """Its name."""
        words = f"A{self.A:g}_f{self.f:g}_T{self.T:g}" + ("" if self.current is None else f"_I{self.current:g}")
        return words.replace(".", "p").replace("-", "m")


@dataclass(frozen=True)
class Habits:
    """What a rig does in every run: size and angle of the drive's second and third harmonic, as shares of A, rad."""

    shares: tuple[float, float]
    angles: tuple[float, float]


def habits(random: np.random.Generator) -> Habits:
    """Draw a rig's habits."""
    shares = random.uniform(0.001, 0.006), random.uniform(0.003, 0.012)
    angles = random.uniform(0.0, 2 * np.pi, 2)
    return Habits((float(shares[0]), float(shares[1])), (float(angles[0]), float(angles[1])))


def settings(plan: Plan, f: float) -> list[Set]:
    """Give the runs of a plan at one of its frequencies."""
    currents: Sequence[float | None] = plan.current or (None,)
    return [Set(A, f, T, current) for T, current, A in itertools.product(plan.T, currents, plan.A)]


def driven(
    runs: Sequence[Set],
    rate: float,
    habit: Habits,
    random: np.random.Generator,
    steps: int,
    fastest: float,
    run_in: int = 0,
) -> tuple[Drive, int]:
    """Drive runs of one frequency from rest; give the motion and the steps between two samples.

    Args:
        runs: what is set.
        rate: samples per second.
        habit: of the rig.
        random: generator of what differs from run to run.
        steps: least steps a cycle.
        fastest: rate of a state in 1/s that the steps must resolve.
        run_in: cycles between the ramp and those that are recorded.
    """
    f, R = runs[0].f, len(runs)
    A = np.array([run.A for run in runs]) * (1 + AMPLITUDE_ERROR * random.standard_normal(R))
    T = np.array([run.T for run in runs]) + TEMPERATURE_ERROR * random.standard_normal(R)
    every = math.ceil(max(steps * f, fastest / STABLE) / rate)
    tones = {1: -1j * A}
    for index, (share, angle) in enumerate(zip(habit.shares, habit.angles, strict=True)):
        tones[index + 2] = A * share * (1 + WANDER * random.standard_normal(R)) * np.exp(1j * angle)
    samples = round((RAMP_CYCLES + run_in + CYCLES + random.uniform(0.0, MOST_EXTRA)) * rate / f)
    step = 1 / (rate * every)
    y, v, a = ramped(tones, f, step, samples * every, RAMP_CYCLES)
    return Drive(step, y, v, a, f, T, np.array([run.current or 0.0 for run in runs])), every


@dataclass(frozen=True)
class Records:
    """Runs of one frequency: what was set, time (m,) s, displacement and force (m, R), mm, N."""

    runs: tuple[Set, ...]
    time: Array
    y: Array
    force: Array


def tested(
    device: Device, p: Parameters, plan: Plan, rate: float, habit: Habits, random: np.random.Generator
) -> list[Records]:
    """Give what ideal sensors show of a device's runs, one entry for each frequency."""
    result = []
    for f in plan.f:
        runs = settings(plan, f)
        drive, every = driven(runs, rate, habit, random, device.steps, device.fastest(p), device.run_in)
        first = round((RAMP_CYCLES + device.run_in) * rate / f) if device.run_in else 0
        force = device.force(drive, p)[::every][first:]
        time = np.arange(len(force)) / rate
        result.append(Records(tuple(runs), time, drive.y[:: 2 * every][first:], force))
    return result


def rms(records: Sequence[Records]) -> float:
    """Give the rms force over all samples, N."""
    return math.sqrt(sum(float(np.sum(one.force**2)) for one in records) / sum(one.force.size for one in records))


def measured(records: Sequence[Records], noise: float, largest: float, random: np.random.Generator) -> list[Records]:
    """Give what real sensors show.

    Args:
        records: of ideal sensors.
        noise: rms force noise, N; a third of it is the force's quantisation.
        largest: amplitude in mm of which the displacement noise is a share.
        random: generator.
    """
    result = []
    for one in records:
        force = one.force + noise * random.standard_normal(one.force.shape)
        y = one.y + DISPLACEMENT_NOISE * largest * random.standard_normal(one.y.shape)
        result.append(Records(one.runs, one.time, y, np.round(force / noise * 3) * noise / 3))
    return result
