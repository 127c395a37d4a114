"""The virtual rig of the truth table: what it drives, how well it measures, and the campaign that comes of it."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from hidden import COLUMN
from truth import SUBSTEPS, Array, Motion, drive

from pipeclamp_identification.campaign.clipping import check_clipping
from pipeclamp_identification.campaign.cycles import find_cycles
from pipeclamp_identification.campaign.reading import Campaign, Run
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.runs_table import Setup

DENSITIES = (2.0, 2.286, 2.571)
LEVELS = (5.0, 10.0, 20.0)


@dataclass(frozen=True)
class Design:
    """A test plan: every combination of A mm, f Hz, T degC is one run of so many cycles at this rate."""

    amplitudes: tuple[float, ...]
    frequencies: tuple[float, ...]
    temperatures: tuple[float, ...]
    cycles: float
    rate: float


DESIGNS = {
    "A": Design((0.2, 0.5, 0.8, 1.0), (1.0, 3.0, 5.0), (20.0, 100.0, 200.0, 300.0), 5.0, 500.0),
    "B": Design((0.3, 0.6, 1.0), (1.0, 2.0, 4.0, 8.0), (20.0, 80.0, 160.0, 250.0), 6.0, 1000.0),
}
HELD_OUT = {
    "A": Design((0.35, 0.65, 0.9), (2.0, 4.0), (60.0, 150.0, 250.0), 4.0, 500.0),
    "B": Design((0.45, 0.8), (1.5, 3.0, 6.0), (50.0, 120.0, 200.0), 4.0, 1000.0),
}


NARROW = {
    "two neighbouring frequencies": Design((0.3, 0.6, 1.0), (3.0, 4.0), (20.0,), 2.5, 160.0),
    "one frequency": Design((0.2, 0.4, 0.6, 0.8, 1.0), (2.0,), (20.0,), 2.5, 80.0),
    "neighbouring amplitudes": Design((0.75, 0.85, 1.0), (1.0, 3.0), (20.0,), 2.5, 120.0),
    "one amplitude": Design((0.8,), (1.0, 2.0, 4.0, 8.0), (20.0,), 2.5, 320.0),
    "two by two": Design((0.5, 1.0), (2.0, 4.0), (20.0,), 2.5, 160.0),
    "two temperatures": Design((0.4, 1.0), (1.0, 4.0), (20.0, 250.0), 2.5, 160.0),
}
"""Test plans that leave much open: few conditions, short and coarsely sampled records."""


def plan(name: str) -> Design:
    """Give a test plan by its name."""
    return {**DESIGNS, **NARROW}[name]


def held_out(name: str) -> Design:
    """Give the conditions that a test plan leaves out: of a narrow one, those between its own."""
    if name in HELD_OUT:
        return HELD_OUT[name]
    narrow = NARROW[name]
    A, f, T = (_between(levels) for levels in (narrow.amplitudes, narrow.frequencies, narrow.temperatures))
    return replace(narrow, amplitudes=A, frequencies=f, temperatures=T)


def _between(levels: tuple[float, ...]) -> tuple[float, ...]:
    return tuple((low + high) / 2 for low, high in itertools.pairwise(levels)) or levels


@dataclass(frozen=True)
class Quality:
    """How well the rig measures.

    Attributes:
        noise: rms of the force noise, N.
        coloured: share of its power that is slow (AR(1) with 0.2 s).
        displacement_noise: rms, mm.
        force_step, displacement_step: quantisation, N and mm.
        force_zero, displacement_zero: by which the zeros differ from run to run, rms, N and mm.
    """

    noise: float
    coloured: float
    displacement_noise: float
    force_step: float
    displacement_step: float
    force_zero: float
    displacement_zero: float


SLOW = 0.2
BETWEEN_STARTS = 8.0
"""Load cycles from the start of one record to that of the next."""


@dataclass(frozen=True)
class Batch:
    """Runs of one frequency."""

    motion: Motion
    rows: tuple[Mapping[str, float], ...]


def batches(
    design: Design,
    random: np.random.Generator,
    needs: frozenset[str],
    ridden: tuple[int, float] | None = None,
    wanted: Mapping[str, float] | None = None,
) -> list[Batch]:
    """Drive all runs of a design.

    Args:
        design: the plan.
        random: generator of the rig's errors: amplitude, temperature, start in the cycle, distortion.
        needs: what varies besides: "density", "condition", "cycles".
        ridden: order and share of a tone that rides on the fundamental, or None.
        wanted: values of what varies besides, the same in every run.
    """
    wanted = wanted or {}
    extra = random.uniform(0.0, 0.4)
    count = len(design.amplitudes) * len(design.frequencies) * len(design.temperatures)
    order = random.permutation(count)
    place = 0
    angles = random.uniform(0.0, 2 * np.pi, 2)
    shares = random.uniform(0.001, 0.006), random.uniform(0.003, 0.012)
    result = []
    for k, f in enumerate(design.frequencies):
        pairs = list(itertools.product(enumerate(design.amplitudes), enumerate(design.temperatures)))
        R = len(pairs)
        A = np.array([pair[0][1] for pair in pairs]) * (1 + 0.01 * random.standard_normal(R))
        celsius = np.array([pair[1][1] for pair in pairs]) + 1.5 * random.standard_normal(R)
        start = random.uniform(0.0, 2 * np.pi, R)
        tones: dict[int, npt.NDArray[np.complex128]] = {1: A * np.exp(1j * start)}
        for index, share in enumerate(shares):
            wander = 1 + 0.1 * random.standard_normal(R)
            turned = np.exp(1j * ((index + 2) * start + angles[index]))
            tones[index + 2] = A * share * wander * turned
        if ridden:
            order_ridden, share_ridden = ridden
            tones[order_ridden] = A * share_ridden * np.exp(1j * order_ridden * start)
        samples = round((design.cycles + extra) * design.rate / f)
        time, y, v, a = drive(tones, f, design.rate, samples)
        level = np.array([(i + j + k) % 3 for (i, _), (j, _) in pairs])
        other = np.array([(i + 2 * j + k) % 3 for (i, _), (j, _) in pairs])
        varied = {
            "density": np.array(DENSITIES)[level], "condition": np.array(LEVELS)[other],
            "cycles": BETWEEN_STARTS * order[place : place + R],
        }  # fmt: skip
        place += R
        rho, u, seen = (
            np.broadcast_to(wanted.get(name, values), R) if name in needs else np.full(R, unvaried)
            for (name, values), unvaried in zip(varied.items(), (np.nan, np.nan, 0.0), strict=True)
        )
        column = (slice(None), None)
        motion = Motion(
            time, y, v, a, tuple(tones.items()), A[column], celsius[column] + 273.15, rho[column], u[column],
            seen[column], f, random.standard_normal((R, 4)),
        )  # fmt: skip
        rows = tuple(
            {
                "amplitude_mm": pair[0][1], "frequency_Hz": f, "temperature_C": float(celsius[index]),
                "density_g_cm3": float(rho[index]), COLUMN: float(u[index]), "first_cycle": float(seen[index]),
            }
            for index, pair in enumerate(pairs)
        )  # fmt: skip
        result.append(Batch(motion, rows))
    return result


def recorded(batch: Batch, force: Array, every: int = SUBSTEPS) -> tuple[Array, Array, Array]:
    """Give time (n,), displacement and force (R, n) at the samples of the record, or at every so many fine steps."""
    first = int(np.searchsorted(batch.motion.time, -1e-9))
    kept = slice(first, None, every)
    return batch.motion.time[kept], batch.motion.y[:, kept], force[:, kept]


def measured(time: Array, y: Array, force: Array, quality: Quality, random: np.random.Generator) -> tuple[Array, Array]:
    """Give what the sensors show of displacement and force, (R, n) each."""
    white = random.standard_normal(force.shape)
    decay = np.exp(-(time[1] - time[0]) / SLOW)
    slow = np.empty_like(white)
    kicks = random.standard_normal(force.shape)
    slow[:, 0] = kicks[:, 0]
    for index in range(1, force.shape[1]):
        slow[:, index] = decay * slow[:, index - 1] + np.sqrt(1 - decay**2) * kicks[:, index]
    noise = quality.noise * (np.sqrt(1 - quality.coloured) * white + np.sqrt(quality.coloured) * slow)
    zeros = random.standard_normal((2, len(force), 1))
    shown = force + noise + quality.force_zero * zeros[0]
    place = y + quality.displacement_noise * random.standard_normal(y.shape) + quality.displacement_zero * zeros[1]
    return _quantised(place, quality.displacement_step), _quantised(shown, quality.force_step)


def _quantised(values: Array, step: float) -> Array:
    return np.round(values / step) * step if step > 0 else values


def campaign_of(
    name: str, runs: Sequence[Batch], channels: Sequence[tuple[Array, Array, Array]], needs: frozenset[str]
) -> Campaign:
    """Give the package's campaign of these records, in the order in which they were run.

    Args:
        name: of the campaign.
        runs: as `batches` gives them.
        channels: time (n,), displacement and force (R, n) of each batch.
        needs: what varies besides.
    """
    found = []
    for batch, (time, y, force) in zip(runs, channels, strict=True):
        for index, row in enumerate(batch.rows):
            record = Record(time.copy(), y[index].copy(), force[index].copy())
            cycles = find_cycles(record)
            check_clipping(record, cycles)
            run = Run(
                name=f"A{row['amplitude_mm']:g}_f{row['frequency_Hz']:g}_T{row['temperature_C']:.0f}".replace(".", "p"),
                setup=Setup(
                    specimen=f"rho{row['density_g_cm3']:g}" if "density" in needs else None,
                    temperature_C=row["temperature_C"],
                    density_g_cm3=row["density_g_cm3"] if "density" in needs else None,
                    first_cycle=row["first_cycle"],
                    conditions={COLUMN: row[COLUMN]} if "condition" in needs else {},
                ),
                amplitude_mm=row["amplitude_mm"],
                frequency_Hz=row["frequency_Hz"],
                record=record,
                cycles=cycles,
            )
            found.append(run)
    found.sort(key=lambda run: run.setup.first_cycle)
    columns = (COLUMN,) if "condition" in needs else ()
    return Campaign(name, "virtual", f"sha256:{name}", tuple(found), (), columns)
