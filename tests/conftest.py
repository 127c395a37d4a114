"""What tests of several kinds share: records of known harmonics, and campaigns written to disk."""

from __future__ import annotations

import gc
import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest

from pipeclamp_identification.campaign.clipping import check_clipping
from pipeclamp_identification.campaign.cycles import find_cycles
from pipeclamp_identification.campaign.reading import Campaign, Run
from pipeclamp_identification.campaign.records import Record, check_samples
from pipeclamp_identification.campaign.runs_table import Setup
from pipeclamp_identification.fitting.misfit import RunMisfit
from pipeclamp_identification.signals.harmonics import cycle_harmonics
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.law.law import Structure

OBJECTS_BETWEEN_SEARCHES = 20_000
"""Python looks for unreachable cycles of objects after so many new ones: after its usual 700, tests spend a twentieth
of their time on looking through what libraries have loaded, as commands did."""


def pytest_configure(config: pytest.Config) -> None:
    """What commands keep from call to call goes where pytest keeps things, and each process of tests has one core."""
    gc.set_threshold(OBJECTS_BETWEEN_SEARCHES)
    os.environ["PIPECLAMP_CACHE"] = str(config.cache.mkdir("pipeclamp"))
    os.environ["LOKY_MAX_CPU_COUNT"] = "1"


@pytest.fixture(scope="session", autouse=True)
def linear_algebra_on_one_thread() -> Iterator[None]:
    """What tests call from within runs as it does in a command: on two threads it takes several times as long."""
    with one_thread():
        yield


def _record(
    displacement: Sequence[complex] = (0.0, 0.8),
    force: Sequence[complex] = (0.0, 2000.0 + 400.0j, 0.0, 60.0 + 90.0j),
    frequency: float = 3.0,
    rate: float = 500.0,
    cycles: float = 5.0,
    phase: float = 0.0,
    start: float = 0.0,
) -> Record:
    """Give a record whose displacement and force are these harmonics, sampled without noise."""
    time = start + np.arange(round(cycles * rate / frequency)) / rate
    theta = 2 * np.pi * frequency * (time - start) + phase

    def wave(harmonics: Sequence[complex]) -> np.ndarray:
        return sum(((x * np.exp(1j * n * theta)).real for n, x in enumerate(harmonics)), np.zeros_like(theta))

    return Record(time, wave(displacement), wave(force))


def _run(record: Record, name: str = "run", **conditions: object) -> Run:
    check_samples(record)
    cycles = find_cycles(record)
    check_clipping(record, cycles)
    motion = {column: conditions.pop(column, None) for column in ("amplitude_mm", "frequency_Hz")}
    return Run(name=name, setup=Setup(**conditions), record=record, cycles=cycles, **motion)


def _campaign(*runs: Run) -> Campaign:
    return Campaign("test", "", "sha256:none", runs, (), tuple(runs[0].setup.conditions))


def _csv(record: Record) -> str:
    rows = zip(record.time_s, record.displacement_mm, record.force_N, strict=True)
    return "time_s,displacement_mm,force_N\n" + "".join(f"{t:.6f},{y:.6f},{force:.4f}\n" for t, y, force in rows)


@pytest.fixture(scope="session")
def harmonic_record() -> Callable[..., Record]:
    """Give a function that makes noise-free records of known harmonics."""
    return _record


@pytest.fixture(scope="session")
def run_of() -> Callable[..., Run]:
    """Give a function that makes a run of a record, checked as the campaign's reader does."""
    return _run


def _misfit(run: Run, error: Callable[[np.ndarray, np.ndarray], np.ndarray], noise: float = 0.0) -> RunMisfit:
    """Give the misfit of a law that errs by error(phase, cycle), N, on a run whose displacement is nearly a cosine."""
    cycles, steady = run.cycles, run.cycles.steady
    phase, bounds = cycles.phase(run.record), cycles.bounds - cycles.bounds[0]
    lag = np.angle(cycle_harmonics(phase, bounds, [run.record.displacement_mm[steady]], 1)[0, 0, 1])
    # a hair above zero, where rounding would else decide on which side of a reversal a sample lies
    within = (phase + lag + 1e-9) % (2 * np.pi)
    measured = run.record.force_N[steady]
    off = error(within, np.repeat(np.arange(cycles.count), np.diff(bounds)))
    return RunMisfit(run.name, within, measured, measured - off, noise)


@pytest.fixture(scope="session")
def misfit_of() -> Callable[..., RunMisfit]:
    """Give a function that makes the misfit of a law whose error is known."""
    return _misfit


@pytest.fixture(scope="session")
def campaign_of() -> Callable[..., Campaign]:
    """Give a function that makes a campaign of runs."""
    return _campaign


@pytest.fixture(scope="session")
def csv_text() -> Callable[[Record], str]:
    """Give a function that writes a record as CSV."""
    return _csv


@pytest.fixture
def campaign_folder(tmp_path: Path) -> Callable[..., Path]:
    """Give a function that writes a campaign's folder from its texts; one good run unless told otherwise."""

    def write(
        description: str = 'name = "small"\n',
        table: str = "run,file,amplitude_mm,frequency_Hz,temperature_C\nA,runs/A.csv,0.8,3,20\n",
        records: Mapping[str, str | bytes] | None = None,
        folder: str = "campaign",
    ) -> Path:
        root = tmp_path / folder
        (root / "runs").mkdir(parents=True)
        (root / "campaign.toml").write_text(description, encoding="utf-8")
        (root / "runs.csv").write_text(table, encoding="utf-8")
        for name, content in ({"runs/A.csv": _csv(_record())} if records is None else records).items():
            data = content.encode() if isinstance(content, str) else content
            (root / name).write_bytes(data)
        return root

    return write


def _write_law(
    path: Path, values: Mapping[str, float], base: str = "power", effects: tuple[str, ...] = (), v_r: float = 0.05
) -> None:
    """Write a law with these values; exponents that aren't given are 0."""
    structure = Structure(base, effects)
    held = structure.held()
    content = {
        "schema": "pipeclamp-law-1",
        "name": path.stem,
        "base": base,
        "effects": list(effects),
        "smoothing": {"v_r": v_r, "y_r": 0.001},
        "coefficients": {
            parameter.name: {
                "value": values.get(parameter.name, held.get(parameter.name, 0.0)),
                "unit": parameter.unit,
                "state": "given",
            }
            for parameter in structure.equations.parameters
        },
        "range": {
            "A": {"minimum": 0.01, "maximum": 5.0, "unit": "mm"},
            "f": {"minimum": 1.0, "maximum": 60.0, "unit": "Hz"},
            "T": {"minimum": 290.0, "maximum": 580.0, "unit": "K"},
        },
        "data": {"name": "made up", "fingerprint": "sha256:0", "runs_used": 0},
        "software": "test",
        "command": "test",
    }
    path.write_text(json.dumps(content), encoding="utf-8")


@pytest.fixture(scope="session")
def write_law() -> Callable[..., None]:
    """Give a function that writes a law's file from its values."""
    return _write_law


@pytest.fixture(scope="session")
def measured_data() -> Path:
    """Give the folder of the measured data, which is not in the repository."""
    if "PIPECLAMP_DATA" not in os.environ:
        pytest.skip("the environment variable PIPECLAMP_DATA doesn't say where the measured data lie")
    return Path(os.environ["PIPECLAMP_DATA"])
