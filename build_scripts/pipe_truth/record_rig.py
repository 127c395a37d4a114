"""A virtual shaker test with motions other than sines: sweeps, bursts, random excitation, integrated in time.

The truth comes from SciPy's LSODA at a tight tolerance, the comparison stands on its own way of marching.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import pi
from pathlib import Path
from typing import Literal

import numpy as np
import polars as pl
from pipe_rig import Sensor

from pipeclamp_identification.on_pipe.measurement import MOTION_UNITS
from pipeclamp_models.pipe.description import Place, read_pipe
from pipeclamp_models.pipe.modes import reduce
from pipeclamp_system.description.system import read_system
from pipeclamp_system.steady.described import steady_clamps
from pipeclamp_system.transient.monolithic import clamp_equations, solve_monolithic

RATE = 250.0
"""Samples a second."""
ACCURACY = 1e-5
TONES = 120
"""Sines of random phases that random excitation is made of."""
DRIVE_NOISE = 0.3
"""Of the sensors' noise: that of the recorded excitation."""


@dataclass(frozen=True)
class DrivenMotion:
    """An excitation.

    Attributes:
        kind: a sweep up; bursts, each a sweep that is faded in and out, with rest between them; random excitation.
        level: amplitude, of random excitation sqrt(2) times its rms, m/s2 of the base or N.
        low, high: Hz.
        duration: s.
    """

    kind: Literal["sweep", "burst", "random"]
    level: float
    low: float
    high: float
    duration: float

    def drive(self, seed: int) -> Callable[[float], float]:
        """Give the excitation over time."""
        rng = np.random.default_rng(seed)
        low, rise = self.low, (self.high - self.low) / self.duration
        if self.kind == "random":
            omega = 2 * pi * (self.low + (self.high - self.low) * (np.arange(TONES) + rng.random(TONES)) / TONES)
            phase = 2 * pi * rng.random(TONES)
            each = self.level / np.sqrt(TONES)
            return lambda t: each * float(np.sum(np.sin(omega * t + phase)))
        if self.kind == "sweep":
            return lambda t: self.level * float(np.sin(2 * pi * (low * t + rise * t * t / 2)))
        bursts, share = 3, 0.4
        period = self.duration / bursts
        steep = (self.high - self.low) / (share * period)

        def burst(t: float) -> float:
            number, within = divmod(t, period)
            if within > share * period:
                return 0.0
            size = self.level * (number + 1) / bursts * np.sin(pi * within / (share * period)) ** 2
            return float(size * np.sin(2 * pi * (low * within + steep * within * within / 2)))

        return burst


def measure_motions(
    system: Path, sensors: tuple[Sensor, ...], motions: tuple[DrivenMotion, ...], folder: Path, noise: float, seed: int
) -> str:
    """Measure motions on a described system, write their records, and give what to write of them in the description.

    Args:
        system: SYSTEM.toml; its pipe's file holds what is true.
        sensors: at which it is measured.
        motions: the excitations, a record each.
        folder: to write to.
        noise: rms of what is added to each sensor, white, as a share of its rms.
        seed: of noise and random excitation.
    """
    described = read_system(system)
    pipe = read_pipe(system.parent / str(described.pipe.file))
    places = tuple(Place(name=sensor.name, position_m=sensor.position) for sensor in sensors)
    reduced = reduce(pipe.model_copy(update={"probes": places}))
    clamps = steady_clamps(described, reduced, system.parent, None, str(system))
    equations = []
    for _, clamp in clamps:
        assert clamp.amplitude is not None and clamp.frequency is not None, "laws are taken for a stated motion"
        equations.append(clamp_equations(clamp.law, clamp.amplitude, clamp.frequency, clamp.temperature))
    assert [index for index, _ in clamps] == list(range(len(reduced.clamp_names))), "a law for every clamp, in order"
    rng = np.random.default_rng(seed)
    base = pipe.excitation.kind == "base"
    folder.mkdir(parents=True, exist_ok=True)
    text = ""
    for number, motion in enumerate(motions):
        drive = motion.drive(seed + number)
        time = np.arange(round(motion.duration * RATE) + 1) / RATE
        result = solve_monolithic(reduced, equations, drive, time, ACCURACY)
        moved = (result.probes, result.probe_velocity, result.probe_acceleration)
        exact = np.array([drive(t) for t in time])
        table = {"time_s": time, "acceleration_m_s2" if base else "force_N": _noisy(exact, DRIVE_NOISE * noise, rng)}
        for index, sensor in enumerate(sensors):
            order, scale = MOTION_UNITS[sensor.unit]
            values = moved[order][:, index] + (exact if base and order == 2 else 0.0)
            table[sensor.name] = sensor.gain * _noisy(values, noise, rng) / scale
        name = f"{motion.kind}_{number}.csv"
        pl.DataFrame(table).write_csv(folder / name)
        text += f'[[records]]\nfile = "{name}"\n'
    return text


def _noisy(values: np.ndarray, share: float, rng: np.random.Generator) -> np.ndarray:
    """Give values with white noise, a share of their rms."""
    return values + share * np.sqrt(np.mean(values**2)) * rng.standard_normal(values.size)
