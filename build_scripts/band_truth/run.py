"""How often a 95 % band of the pipe's response holds the truth: from virtual tests to the peak on a virtual pipe.

    python build_scripts/band_truth/run.py 50 -o bands

Each case draws a clamp, tests it with noise (24 runs), identifies the base law, and computes the response of a pipe on
it with bands by the package. The truth is the same clamp, mounted once more, on the same pipe's modes, integrated in
time by code of its own (`device.py`). Rough: the clamp has an element that slips besides, which the law has no form
for, and each mounting differs by 0.3 % in stiffness and 0.6 % in damping.

A run that was cut off goes on where its table ends. The bands' ends are solved without branches apart, which no
peak here is on: they take most of a response's time.

`--monte-carlo N` holds the bands against those of N samples of what isn't known too, solved one by one.
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
from scipy.stats import binomtest

import pipeclamp as pc
from pipeclamp_models.pipe.description import read_pipe
from pipeclamp_models.pipe.modes import ReducedPipe, reduce
from pipeclamp_system.bands.response import BandedSystem, banded_system
from pipeclamp_system.bands.response_bands import CurveBands
from pipeclamp_system.response.curves import Curve
from pipeclamp_system.response.run import run_response
from pipeclamp_system.steady.states import amplitudes_of

AMPLITUDES, FREQUENCIES, CELSIUS = (0.2, 0.4, 0.7, 1.0), (1.0, 4.0, 15.0), (20.0, 150.0)
CYCLES, RATE, NOISE = 4, 400, 0.02
"""Of a test: cycles, samples a second, noise as a share of the rms force."""
MOUNTING = (0.003, 0.006)
PER_CENT = 95.0
KINDS = ("clean", "rough")
SPREAD, PLACES = 0.12, 41
"""Of the frequencies round the peak at which the truth is integrated: share to either side, and how many."""
SETTLE, SETTLED, PER_CYCLE, STIFFEST = 40, 250, 240, 0.25
"""Of the integration: cycles while the peak is sought and once it is found, steps of a cycle at least, and of a step
times the fastest mode's rad/s, over 2 pi."""
CLOSE, CLOSELY, MOST_MOVES = 3e-4, 9, 4
"""Of the frequencies at the peak itself: share from one to the next, and how many; a quartic goes through them. And how
often they move on where the highest lies at their end."""
INSIDE = 0.999
"""Of the response's frequencies: a peak at their end is none, and its band isn't counted."""
NEARLY, MOST_MORE, MOST_DRIVES = 0.3, 4.0, 12
"""Share by which the amplitude may miss the wanted one, how much more is tried at a time, and how often."""
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
    bands: CurveBands
    amplitude: float
    frequency: float
    inside: bool
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


@dataclass(frozen=True)
class Swept:
    """A device on a pipe under sines whose frequency goes on and on: motion settles from where the last one ended."""

    device: Device
    pipe: ReducedPipe
    kelvin: float
    acceleration: float

    def amplitudes(self, frequencies: Array, cycles: int, state: Array) -> Array:
        """Give half the peak-to-peak displacement, mm, after cycles at each frequency, Hz; moves the state."""
        pipe, omega = self.pipe, np.array(self.pipe.omega)
        fastest = float(np.sqrt(np.linalg.eigvalsh(_on_device(pipe, self.device))[-1]))
        zeta = np.array(pipe.damping) / (2 * omega)
        participation, shape = np.array(pipe.excitation_participation), np.array(pipe.clamp_shapes[0])
        numbers = self.device.numbers(self.kelvin)
        found = []
        for frequency in frequencies.tolist():
            per_cycle = max(PER_CYCLE, int(fastest / (frequency * STIFFEST)))
            one = on_pipe(
                frequency, self.acceleration, cycles, per_cycle, omega, zeta, participation, shape, numbers, state
            )
            found.append(float(one))
        return np.array(found)

    def highest(self, near: float) -> tuple[float, float, Array]:
        """Give frequency (Hz) and amplitude (mm) of the highest motion met round a frequency, upwards or downwards.

        Also the state there.
        """
        best = (near, 0.0, self.rest())
        for side in (1, -1):
            state = self.rest()
            for frequency in near * np.linspace(1 - side * SPREAD, 1 + side * SPREAD, PLACES):
                amplitude = float(self.amplitudes(np.array([frequency]), SETTLE, state)[0])
                if amplitude > best[1]:
                    best = (float(frequency), amplitude, state.copy())
        return best

    def rest(self) -> Array:
        """Give the state at rest."""
        return np.zeros(2 * len(self.pipe.omega) + 1)


def truth(swept: Swept, near: float) -> tuple[float, float]:
    """Give frequency (Hz) and amplitude (mm) of the true peak near a frequency."""
    peak, _, state = swept.highest(near)
    step = 2 * SPREAD / (PLACES - 1)
    around = peak * np.linspace(1 - step, 1 + step, 17)
    peak = float(around[np.argmax(swept.amplitudes(around, SETTLE, state.copy()))])
    for _ in range(MOST_MOVES):
        steps = np.arange(CLOSELY) - CLOSELY // 2
        close = peak * (1 + CLOSE * steps)
        swept.amplitudes(close[:1], SETTLED, state)
        curve = np.polyfit(steps, swept.amplitudes(close, SETTLED, state), 4)
        fine = np.linspace(steps[0], steps[-1], 8001)
        top = int(np.argmax(np.polyval(curve, fine)))
        found = peak * float(1 + CLOSE * fine[top])
        if 0 < top < len(fine) - 1:
            break
        peak = found  # the highest lies beside these
    return found, float(np.polyval(curve, fine[top]))


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
        whole = banded_system(path, response)
        system = _Quick(path, whole.description, whole.unknown)
        bands = system.bands(response.curves[0], PER_CENT)
        mounted = device.mounted(random, *MOUNTING) if rough else device
        near = bands.peaks[0].frequency.value
        frequency, amplitude = truth(Swept(mounted, pipe, celsius + 273.15, acceleration), near)
        sampled = _sampled(system, response.curves[0], samples) if samples else None
    return Case(rough, bands, amplitude, frequency, near < INSIDE * ends["high"], sampled)


def _first(pipe: ReducedPipe, device: Device) -> float:
    """Give the first natural frequency of the pipe on the device's stiffness, Hz."""
    return float(np.sqrt(np.linalg.eigvalsh(_on_device(pipe, device))[0]) / (2 * np.pi))


def _on_device(pipe: ReducedPipe, device: Device) -> Array:
    """Give the stiffness of the pipe's modes with the device's, 1/s2."""
    shape = np.array(pipe.clamp_shapes[0])
    return np.asarray(np.diag(np.square(pipe.omega)) + 1e3 * (device.k + device.element) * np.outer(shape, shape))


def _drive(device: Device, pipe: ReducedPipe, kelvin: float, near: float, wanted: float) -> float:
    """Give the acceleration, m/s2, at which the clamp moves about so many mm at the peak."""
    acceleration = 0.02
    for _ in range(MOST_DRIVES):  # a motion that jumps past the amplitude wanted has none near it
        _, amplitude, _ = Swept(device, pipe, kelvin, acceleration).highest(near)
        acceleration *= min(wanted / amplitude, MOST_MORE)  # a softening clamp has no motion beyond
        if abs(amplitude / wanted - 1) <= NEARLY:
            break
    return acceleration


class _Quick(BandedSystem):
    """A system whose bands' ends are solved without branches apart."""

    def solved(self, curve: Curve, amounts: Array, *, apart: bool = False) -> Curve:
        return super().solved(curve, amounts, apart=apart)


def _sampled(system: BandedSystem, curve: Curve, samples: int) -> Array:
    """Give the peaks of a curve with samples of what isn't known, each solved by itself."""
    unknown, random = system.unknown, np.random.default_rng(SEED)
    draws = random.multivariate_normal(unknown.means, unknown.covariance, samples)
    return np.array([max(amplitudes_of(s)[0] for s in system.solved(curve, one, apart=False).states) for one in draws])


def main() -> None:
    """Run the cases and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", type=int, help="of each kind, clean and rough")
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder for the table")
    parser.add_argument("--monte-carlo", type=int, default=0, metavar="N", help="samples for each case")
    told = parser.parse_args()
    told.output.mkdir(parents=True, exist_ok=True)
    path = told.output / "bands.csv"
    rows = pl.read_csv(path).to_dicts() if path.is_file() else []
    done = {(one["kind"], one["case"]) for one in rows}
    for number, rough in itertools.product(range(told.cases), (False, True)):
        if (KINDS[rough], number) in done:
            continue
        begun = time.process_time()
        rows.append(row(case(number, rough, told.monte_carlo), number) | {"CPU s": time.process_time() - begun})
        print(rows[-1], flush=True)
        pl.from_dicts(rows, infer_schema_length=None).write_csv(path)
    print("\n".join(summary(pl.from_dicts(rows, infer_schema_length=None))))


def summary(frame: pl.DataFrame) -> list[str]:
    """Say how often the bands held the truth."""
    lines = []
    for kind in KINDS:
        own = frame.filter((pl.col("kind") == kind) & pl.col("inside"))
        for what in ("amplitude", "frequency") if len(own) else ():
            held, cases, off = int(own[f"{what} held"].sum()), len(own), own[f"{what} off"].to_numpy()
            sure = binomtest(held, cases).proportion_ci(0.95, "exact")
            wrong = np.abs(own[f"{what} true"].to_numpy() / own[what].to_numpy() - 1)
            lines.append(
                f"{kind}: the {PER_CENT:g} % band of the peak's {what} holds the truth in {held} of {cases} "
                f"({100 * held / cases:.1f} %; 95 % confidence: {100 * sure.low:.0f} to {100 * sure.high:.0f} %); "
                f"off by {np.sqrt(np.mean(off**2)):.2f} standard deviations (rms), "
                f"median {np.median(np.abs(off)):.2f}; {wrong.max():.2g} of it at most"
            )
    return lines


def row(found: Case, number: int) -> dict[str, float | str | bool]:
    """Give the table's row of a case."""
    peak = found.bands.peaks[0]
    told: dict[str, float | str | bool] = {"kind": KINDS[found.rough], "case": number, "inside": found.inside}
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
