"""Ten runs of a known clamp, and what test machines make of them: what imports are held against."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

SETTINGS = [(A, f, T) for A in (0.3, 0.9) for f in (1.0, 2.0, 5.0) for T in (20.0,)] + [
    (A, f, 150.0) for A in (0.3, 0.9) for f in (1.0, 5.0)
]
RATE = 200.0
"""Samples per second."""
CYCLES = 6


@dataclass(frozen=True)
class Loop:
    """A run: what was set, and its samples in s, mm and N."""

    name: str
    amplitude: float
    frequency: float
    temperature: float
    time: np.ndarray
    y: np.ndarray
    force: np.ndarray


def loop(
    amplitude: float = 0.5,
    frequency: float = 2.0,
    temperature: float = 20.0,
    cycles: float = CYCLES,
    seed: int = 0,
    rate: float = RATE,
    delay: float = 0.0,
) -> Loop:
    """A spring that hardens, a dashpot and dry friction, with noise of both sensors and their last digits."""
    rng = np.random.default_rng(seed)
    time = np.round(np.arange(round(cycles * rate / frequency)) / rate, 6)
    omega = 2 * np.pi * frequency
    y = amplitude * np.sin(omega * time)
    late, v = amplitude * np.sin(omega * (time - delay)), omega * amplitude * np.cos(omega * (time - delay))
    softer = 1 - 0.001 * (temperature - 20)
    force = softer * (1200 * late + 200 * late**3 + 4 * v + 60 * np.tanh(v / 0.5))
    return Loop(
        f"A{amplitude}_f{frequency:g}_T{temperature:g}",
        amplitude,
        frequency,
        temperature,
        time,
        np.round(y + rng.normal(0, 2e-4, len(y)), 6),
        np.round(force + rng.normal(0, 1.0, len(y)), 4),
    )


def ten_runs() -> list[Loop]:
    return [loop(A, f, T, seed=seed) for seed, (A, f, T) in enumerate(SETTINGS)]


def text(
    run: Loop,
    *,
    names: str = "Time [s];Displacement [mm];Force [kN]",
    delimiter: str = ";",
    decimal: str = ",",
    header: str = "Test machine 7\nOperator;N. N.\n\n",
    units: str = "",
    scales: tuple[float, float, float] = (1.0, 1.0, 1e-3),
    digits: tuple[int, int, int] = (6, 6, 7),
    quote: str = "",
    footer: str = "",
    stamp: Callable[[float], str] | None = None,
) -> str:
    """Give a run as an export: time, displacement and force, each by its factor, with so many digits."""
    lines = [header + names] if names else []
    lines += [units] if units else []
    for t, y, force in zip(run.time, run.y, run.force, strict=True):
        values = (t * scales[0], y * scales[1], force * scales[2])
        cells = [f"{value:.{places}f}".replace(".", decimal) for value, places in zip(values, digits, strict=True)]
        if stamp:
            cells[0] = stamp(t)
        lines.append(delimiter.join(quote + cell + quote for cell in cells))
    return "\n".join(lines) + "\n" + footer


def write_texts(folder: Path, runs: list[Loop], encoding: str = "utf-8", newline: str = "\n", **options) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    for run in runs:
        content = text(run, **options).replace("\n", newline)
        (folder / f"{run.name}.csv").write_bytes(content.encode(encoding))
    return folder


def assert_same_campaign(
    folder: Path, runs: list[Loop], *, force_step: float = 1e-3, y_step: float = 1e-6, t_step: float = 1e-6
):
    """Hold an imported campaign against its runs, to the digits that a format keeps."""
    from pipeclamp_identification.campaign.reading import read_campaign

    campaign = read_campaign(folder)
    assert not campaign.left_out
    found = {run.name: run for run in campaign.runs}
    assert sorted(found) == sorted(run.name for run in runs)
    for run in runs:
        record = found[run.name].record
        assert len(record.time_s) == len(run.time)
        np.testing.assert_allclose(record.time_s - record.time_s[0], run.time - run.time[0], atol=t_step, rtol=0)
        np.testing.assert_allclose(record.displacement_mm, run.y, atol=y_step, rtol=1e-6)
        np.testing.assert_allclose(record.force_N, run.force, atol=force_step, rtol=1e-6)
        assert found[run.name].cycles.frequency_Hz == __import__("pytest").approx(run.frequency, rel=1e-3)
    return campaign
