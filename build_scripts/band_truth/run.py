"""How often a 95 % band of the pipe's response holds the truth: from virtual tests to the peak on a virtual pipe.

    python build_scripts/band_truth/run.py 50 -o bands

Each case draws a clamp, tests it with noise (24 runs), identifies the base law, and computes the response of a pipe on
it with bands by the package. The truth is the same clamp, mounted once more, on the same pipe's modes, integrated in
time by code of its own (`device.py`). Rough: the clamp has an element that slips besides, which the law has no form
for, and each mounting differs by 0.3 % in stiffness and 0.6 % in damping.

`--monte-carlo N` holds the bands of the first cases against those of N samples of what isn't known, solved one by one.
"""

from __future__ import annotations

import argparse
import itertools
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import polars as pl
from device import Array, Device, drawn, on_machine, on_pipe

import pipeclamp as pc
from pipeclamp_models.pipe.description import read_pipe
from pipeclamp_models.pipe.modes import ReducedPipe, reduce
from pipeclamp_system.bands.response import banded_system, response_bands
from pipeclamp_system.bands.told import ResponseBands
from pipeclamp_system.steady.response import FrequencyResponse, amplitudes_of, run_response

AMPLITUDES, FREQUENCIES, CELSIUS = (0.2, 0.4, 0.7, 1.0), (1.0, 4.0, 15.0), (20.0, 150.0)
CYCLES, RATE, NOISE = 4, 400, 0.02
"""Of a test: cycles, samples a second, noise as a share of the rms force."""
MOUNTING = (0.003, 0.006)
PER_CENT = 95.0
SPREAD, PLACES = 0.12, 41
"""Of the frequencies round the peak at which the truth is integrated: share to either side, and how many."""
SETTLE, SETTLED, PER_CYCLE, STIFFEST = 130, 500, 240, 0.25
"""Of the integration: cycles while the peak is sought and once it is found, steps of a cycle at least, and of a step
times the fastest mode's rad/s, over 2 pi."""
CLOSE, CLOSELY = 3e-4, 9
"""Of the frequencies at the peak itself: share from one to the next, and how many; a quartic goes through them."""
NEARLY, MOST_MORE = 0.3, 4.0
"""Share by which the amplitude may miss the wanted one, and how much more is tried at a time."""
SEED = 1

PIPE = """name = "pipe"
[pipe]
outer_diameter_mm = 60.3
wall_mm = 3.91
length_m = {length}
material = "316L"
[ends]
left = "clamped"
right = "free"
[[clamps]]
name = "clamp"
position_m = {position}
[excitation]
kind = "base"
[damping]
ratio = 0.01
[modes]
up_to_Hz = {up_to}
"""
SYSTEM = """name = "case"
[pipe]
file = "pipe.toml"
[[clamps]]
at = "clamp"
law = "law.json"
temperature_C = {celsius}
track = true
amplitude_mm = 0.5
frequency_Hz = {middle}
[excitation]
kind = "sine"
acceleration_m_s2 = {acceleration}
frequency_Hz = {middle}
[run]
stop_s = 1.0
step_s = 0.001
[response]
from_Hz = {low}
to_Hz = {high}
dots = 0
"""


@dataclass(frozen=True)
class Case:
    """One case: what was said, and what is true."""

    rough: bool
    bands: ResponseBands
    amplitude: float
    frequency: float
    sampled: Array | None


def tested(device: Device, folder: Path, random: np.random.Generator, rough: bool) -> None:
    """Write the campaign of a device."""
    rows = []
    for number, (A, f, celsius) in enumerate(itertools.product(AMPLITUDES, FREQUENCIES, CELSIUS)):
        own = device.mounted(random, *MOUNTING) if rough else device
        A = A * (1 + 0.01 * random.standard_normal())
        t = np.arange(round(CYCLES * RATE * max(f, 1.0) / f)) / (RATE * max(f, 1.0))
        fine = 8
        every = np.arange(len(t) * fine) * (t[1] / fine)
        y, v = A * np.sin(2 * np.pi * f * every), 2 * np.pi * f * A * np.cos(2 * np.pi * f * every)
        force = on_machine(y, v, t[1] / fine, own.numbers(celsius + 273.15))[::fine]
        force = force + NOISE * np.sqrt(np.mean(force**2)) * random.standard_normal(len(force))
        pl.DataFrame({"time_s": t, "displacement_mm": y[::fine], "force_N": force}).write_csv(folder / f"{number}.csv")
        rows.append(
            {
                "run": str(number),
                "file": f"{number}.csv",
                "amplitude_mm": A,
                "frequency_Hz": f,
                "temperature_C": celsius,
            }
        )
    pl.DataFrame(rows).write_csv(folder / "runs.csv")
    (folder / "campaign.toml").write_text('name = "drawn"\n', encoding="utf-8")


def truth(device: Device, pipe: ReducedPipe, kelvin: float, acceleration: float, near: float) -> tuple[float, float]:
    """Give frequency (Hz) and amplitude (mm) of the true peak near a frequency."""
    omega, numbers = np.array(pipe.omega), device.numbers(kelvin)
    fastest = float(np.sqrt(np.linalg.eigvalsh(_on_device(pipe, device))[-1]))
    zeta = np.array(pipe.damping) / (2 * omega)
    participation, shape = np.array(pipe.excitation_participation), np.array(pipe.clamp_shapes[0])
    frequencies = near * np.linspace(1 - SPREAD, 1 + SPREAD, PLACES)

    def amplitudes(at: Array, cycles: int) -> Array:
        found = []
        for frequency in at.tolist():
            per_cycle = max(PER_CYCLE, int(fastest / (frequency * STIFFEST)))
            one = on_pipe(frequency, acceleration, cycles, per_cycle, omega, zeta, participation, shape, numbers)
            found.append(float(one))
        return np.array(found)

    for _ in range(2):  # once more about the highest
        found = amplitudes(frequencies, SETTLE)
        top = int(np.clip(np.argmax(found), 1, len(found) - 2))
        peak = float(frequencies[top])
        frequencies = np.linspace(frequencies[top - 1], frequencies[top + 1], 9)
    steps = np.arange(CLOSELY) - CLOSELY // 2
    curve = np.polyfit(steps, amplitudes(peak * (1 + CLOSE * steps), SETTLED), 4)
    fine = np.linspace(steps[0], steps[-1], 8001)
    top = int(np.argmax(np.polyval(curve, fine)))
    return peak * float(1 + CLOSE * fine[top]), float(np.polyval(curve, fine[top]))


def case(number: int, rough: bool, samples: int) -> Case:
    """Draw, test, identify, simulate and integrate one case."""
    random = np.random.default_rng([SEED, number, rough])
    device = drawn(random, rough)
    celsius, length = random.uniform(20.0, 150.0), random.uniform(3.0, 6.0)
    with tempfile.TemporaryDirectory(prefix="pipeclamp_bands_") as name:
        folder = Path(name)
        position = random.uniform(0.6, 0.95) * length
        text = PIPE.format(length=round(length, 3), position=position, up_to=60.0)
        (folder / "pipe.toml").write_text(text, encoding="utf-8")
        pipe = reduce(read_pipe(folder / "pipe.toml"))
        first = _first(pipe, device)
        acceleration = _drive(device, pipe, celsius + 273.15, first, random.uniform(0.3, 0.8))
        tests = folder / "tests"
        tests.mkdir()
        tested(device, tests, random, rough)
        pc.identify(pc.read_campaign(tests)).save(folder / "law.json")
        path = folder / "system.toml"
        ends = {"low": 0.75 * first, "middle": first, "high": 1.3 * first}
        path.write_text(SYSTEM.format(celsius=celsius, acceleration=acceleration, **ends), encoding="utf-8")
        response = run_response(path)
        bands = response_bands(path, response, PER_CENT)
        mounted = device.mounted(random, *MOUNTING) if rough else device
        near = bands.curves[0].peaks[0].frequency.value
        frequency, amplitude = truth(mounted, pipe, celsius + 273.15, acceleration, near)
        sampled = _sampled(path, response, samples) if samples else None
    return Case(rough, bands, amplitude, frequency, sampled)


def _first(pipe: ReducedPipe, device: Device) -> float:
    """Give the first natural frequency of the pipe on the device's stiffness, Hz."""
    return float(np.sqrt(np.linalg.eigvalsh(_on_device(pipe, device))[0]) / (2 * np.pi))


def _on_device(pipe: ReducedPipe, device: Device) -> Array:
    """Give the stiffness of the pipe's modes with the device's, 1/s2."""
    shape = np.array(pipe.clamp_shapes[0])
    return np.asarray(np.diag(np.square(pipe.omega)) + 1e3 * (device.k + device.element) * np.outer(shape, shape))


def _drive(device: Device, pipe: ReducedPipe, kelvin: float, near: float, wanted: float) -> float:
    """Give the acceleration, m/s2, at which the clamp moves about so many mm at the peak."""
    acceleration, amplitude = 0.02, 0.0
    while abs(amplitude / wanted - 1) > NEARLY:
        _, amplitude = truth(device, pipe, kelvin, acceleration, near)
        acceleration *= min(wanted / amplitude, MOST_MORE)  # a softening clamp has no motion beyond
    return acceleration


def _sampled(path: Path, response: FrequencyResponse, samples: int) -> Array:
    """Give the peaks of a response with samples of what isn't known, each solved by itself."""
    system = banded_system(path, response)
    random = np.random.default_rng(SEED)
    draws = random.multivariate_normal(np.zeros(len(system.unknown.quantities)), system.unknown.covariance, samples)
    curve = response.curves[0]
    return np.array([max(amplitudes_of(s)[0] for s in system.solved(curve, one).states) for one in draws])


def main() -> None:
    """Run the cases and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", type=int, help="of each kind, clean and rough")
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder for the table")
    parser.add_argument("--monte-carlo", type=int, default=0, metavar="N", help="samples for each case")
    told = parser.parse_args()
    told.output.mkdir(parents=True, exist_ok=True)
    rows = []
    for rough, number in itertools.product((False, True), range(told.cases)):
        begun = time.perf_counter()
        rows.append(row(case(number, rough, told.monte_carlo), number) | {"seconds": time.perf_counter() - begun})
        print(rows[-1], flush=True)
        frame = pl.from_dicts(rows, infer_schema_length=None)
        frame.write_csv(told.output / "bands.csv")
    for kind in ("clean", "rough"):
        own = frame.filter(pl.col("kind") == kind)
        for what in ("amplitude", "frequency"):
            held, off = own[f"{what} held"], own[f"{what} off"].to_numpy()
            wrong = np.abs(own[f"{what} true"].to_numpy() / own[what].to_numpy() - 1)
            print(
                f"{kind}: the {PER_CENT:g} % band of the peak's {what} holds the truth in {int(held.sum())} of "
                f"{len(held)}; off by {np.sqrt(np.mean(off**2)):.2f} standard deviations (rms), {wrong.max():.2g} of "
                "it at most"
            )


def row(found: Case, number: int) -> dict[str, float | str | bool]:
    """Give the table's row of a case."""
    peak = found.bands.curves[0].peaks[0]
    told: dict[str, float | str | bool] = {"kind": "rough" if found.rough else "clean", "case": number}
    for what, band, true in (
        ("amplitude", peak.amplitude, found.amplitude),
        ("frequency", peak.frequency, found.frequency),
    ):
        told |= {what: band.value, f"{what} low": band.low, f"{what} high": band.high, f"{what} true": true}
        told |= {f"{what} held": band.low <= true <= band.high, f"{what} off": (true - band.value) / band.deviation}
    told |= {f"share of {kind}": share for kind, share in peak.amplitude.shares.items()}
    if found.sampled is not None:
        low, high = np.percentile(found.sampled, [50 - PER_CENT / 2, 50 + PER_CENT / 2])
        told |= {"sampled low": float(low), "sampled high": float(high)}
    return told


if __name__ == "__main__":
    main()
