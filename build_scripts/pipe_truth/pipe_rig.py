"""A virtual shaker test: a described system's sines, integrated in time, as a folder that `pipeclamp compare` reads.

The motion is that of the monolithic integration from rest until its transient is gone; harmonic balance, which the
comparison stands on, only says how long that takes and, where a law follows the motion's own amplitude, which it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from hashlib import sha256
from itertools import pairwise
from math import ceil, log, pi
from pathlib import Path

import numpy as np
import polars as pl

from pipeclamp_identification.on_pipe.measurement import FILE_NAME, MOTION_UNITS, Unit
from pipeclamp_identification.signals.harmonics import cycle_harmonics
from pipeclamp_models.pipe.description import PipeDescription, Place, read_pipe
from pipeclamp_models.pipe.modes import reduce
from pipeclamp_system.description.system import read_system
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.described import steady_clamps
from pipeclamp_system.transient.monolithic import clamp_equations, solve_monolithic

CYCLES, STEPS = 4, 64
"""Of the settled motion that are measured, and samples in each."""
SETTLED, LONGEST = 1e-3, 200
"""The transient is left to fall to this share, or for so many cycles."""
BOUNDS = np.arange(CYCLES + 1) * STEPS
SAME = 2e-3
"""Share by which the cycles that are measured may differ."""
ACCURACY = 1e-5


@dataclass(frozen=True)
class Sensor:
    """A sensor.

    Attributes:
        name: of the sensor.
        position: stated, m.
        unit: stated.
        gain: factor by which it is out of calibration, below 0 for a wrong sign.
        phase: by which it is ahead, degrees.
        delay: by which it is late, s.
        moved: m from the stated position at which it sits.
    """

    name: str
    position: float
    unit: Unit
    gain: float = 1.0
    phase: float = 0.0
    delay: float = 0.0
    moved: float = 0.0


@dataclass(frozen=True)
class RecordedDrive:
    """What is wrong with the recorded excitation and its time axis.

    Attributes:
        gain: stated over true excitation.
        delay: by which it is recorded late, s.
        rate: true over stated frequencies.
    """

    gain: float = 1.0
    delay: float = 0.0
    rate: float = 1.0


@dataclass(frozen=True)
class Sine:
    """A sine of the excitation: Hz, m/s2 of the base or N, degC of the clamps."""

    frequency: float
    drive: float
    temperature: float | None = None


def measure(
    system: Path, sensors: tuple[Sensor, ...], sines: tuple[Sine, ...], folder: Path, noise: float, seed: int,
    drive: RecordedDrive | None = None, kept: Path | None = None,
) -> str:  # fmt: skip
    """Measure the sines on a described system, write them, a file a temperature, and give what to describe of them.

    Args:
        system: SYSTEM.toml; its pipe's file holds what is true.
        sensors: at which it is measured.
        sines: of the excitation.
        folder: to write to.
        noise: rms of what is added to real and imaginary part each, as a share of the value; a tenth of it, of the
            sensor's largest value at that level, is there always.
        seed: of the noise.
        drive: what is wrong with the excitation as it is recorded.
        kept: folder in which exact motions are kept for further measurements of the same ones.
    """
    drive = drive or RecordedDrive()
    rng = np.random.default_rng(seed)
    pipe = read_pipe(system.parent / str(read_system(system).pipe.file))
    pipe = pipe.model_copy(
        update={
            "probes": tuple(Place(name=sensor.name, position_m=sensor.position + sensor.moved) for sensor in sensors)
        }
    )
    true = tuple(Sine(drive.rate * sine.frequency, sine.drive / drive.gain, sine.temperature) for sine in sines)
    exact = _motions(system, pipe, sensors, true, kept) * _recorded(sensors, true, drive)
    of_level = [[sine.drive == other.drive for other in sines] for sine in sines]
    highest = np.array([np.abs(exact[rows]).max(axis=0) for rows in of_level])
    size = noise * (np.abs(exact) + 0.1 * highest)
    seen = exact + size * (rng.standard_normal(exact.shape) + 1j * rng.standard_normal(exact.shape))
    folder.mkdir(parents=True, exist_ok=True)
    column = "acceleration_m_s2" if pipe.excitation.kind == "base" else "force_N"
    lines = []
    for number, temperature in enumerate(dict.fromkeys(sine.temperature for sine in sines)):
        rows = [index for index, sine in enumerate(sines) if sine.temperature == temperature]
        table = {"frequency_Hz": [sines[row].frequency for row in rows], column: [sines[row].drive for row in rows]}
        for index, sensor in enumerate(sensors):
            table[f"{sensor.name}_amplitude"] = np.abs(seen[rows, index]).tolist()
            table[f"{sensor.name}_phase_deg"] = np.degrees(np.angle(seen[rows, index])).tolist()
        pl.DataFrame(table).write_csv(folder / f"sines_{number}.csv")
        lines += ["[[responses]]", f'file = "sines_{number}.csv"']
        lines += [] if temperature is None else [f"temperature_C = {temperature}"]
    return "".join(f"{line}\n" for line in lines)


def _recorded(sensors: tuple[Sensor, ...], sines: tuple[Sine, ...], drive: RecordedDrive) -> np.ndarray:
    """Give recorded over true phasors, (sines, sensors)."""
    omega = 2 * pi * np.array([sine.frequency for sine in sines])[:, None]
    gain, phase, delay = (
        np.array([getattr(sensor, name) for sensor in sensors]) for name in ("gain", "phase", "delay")
    )
    return gain * np.exp(1j * (np.radians(phase) - omega * (delay - drive.delay)))


def _motions(
    system: Path, pipe: PipeDescription, sensors: tuple[Sensor, ...], sines: tuple[Sine, ...], kept: Path | None
) -> np.ndarray:
    """Give the true motions of `response`, (sines, sensors); those that are kept already aren't integrated again."""
    if kept is None:
        return np.array([response(system, pipe, sensors, sine) for sine in sines])
    laws = "".join(path.read_text(encoding="utf-8") for path in sorted(system.parent.glob("*.json")))
    units = [sensor.unit for sensor in sensors]
    key = sha256(f"{pipe!r}{laws}{system.read_text(encoding='utf-8')}{units}{sines}".encode()).hexdigest()[:16]
    file = kept / f"{key}.npy"
    if not file.is_file():
        kept.mkdir(parents=True, exist_ok=True)
        np.save(file, np.array([response(system, pipe, sensors, sine) for sine in sines]))
    return np.load(file)


def describe(folder: Path, sensors: tuple[Sensor, ...], files: str) -> None:
    """Write the description of a measurement: its sensors, and its files as they stand in it."""
    lines = [f'name = "{folder.name}"']
    for sensor in sensors:
        lines += ["[[probes]]", f'name = "{sensor.name}"', f"position_m = {sensor.position}", f'unit = "{sensor.unit}"']
    (folder / FILE_NAME).write_text("\n".join(lines) + "\n" + files, encoding="utf-8")


def response(system: Path, pipe: PipeDescription, sensors: tuple[Sensor, ...], sine: Sine) -> np.ndarray:
    """Give the fundamental at each sensor in its unit, phase relative to the excitation, (sensors,)."""
    reduced = reduce(pipe)
    clamps = steady_clamps(read_system(system), reduced, system.parent, sine.temperature, str(system))
    state = SteadySystem(reduced, clamps, lambda frequency: sine.drive).at(sine.frequency)
    assert state is not None and state.stable
    cycles = min(ceil(sine.frequency * log(1 / SETTLED) / -state.growth), LONGEST) + CYCLES
    omega = 2 * pi * sine.frequency
    equations = [
        clamp_equations(clamp.law, *conditions, clamp.temperature)
        for (_, clamp), conditions in zip(clamps, state.conditions.tolist(), strict=True)
    ]
    assert [index for index, _ in clamps] == list(range(len(reduced.clamp_names))), "a law for every clamp, in order"
    for longer in (1, 2, 4):
        time = np.arange(longer * cycles * STEPS + 1) / (STEPS * sine.frequency)
        result = solve_monolithic(reduced, equations, lambda t: sine.drive * np.sin(omega * t), time, ACCURACY)
        last = slice(-CYCLES * STEPS - 1, -1)
        lines = cycle_harmonics(omega * time[last], BOUNDS, list(result.probes[last].T), 1)[:, :, 1]
        if all(abs(after / before - 1) < SAME for line in np.abs(lines) for before, after in pairwise(line)):
            break
    else:
        raise ArithmeticError(f"{system}: no steady motion at {sine}")
    moved = lines.mean(axis=1) / -1j
    seen = []
    for sensor, displacement in zip(sensors, moved, strict=True):
        order, scale = MOTION_UNITS[sensor.unit]
        # The base's acceleration is drive sin(omega t), its displacement the opposite over omega^2.
        base = -sine.drive / omega**2 if order == 2 and pipe.excitation.kind == "base" else 0.0
        seen.append((displacement + base) * (1j * omega) ** order / scale)
    return np.array(seen)
