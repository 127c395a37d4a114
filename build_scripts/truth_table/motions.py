"""Laws identified on sines, along motions that are none: `python build_scripts/truth_table/motions.py [--cases WORD]`.

Devices of other code (`devices/`) are tested by sines, and then moved like the ground in an earthquake, by a sweep of
falling amplitude, and at random, all within the amplitudes and frequencies of the sines. Said of each law: its error on
left-out sines, on those motions, and how much of the motions' time the tracked A lies outside of the law's range.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from devices.cases import DeviceCase, device_cases, measure_device, written
from devices.drive import Array, Drive

from pipeclamp_identification.campaign.free_motion import FreeRun, free_motion
from pipeclamp_identification.campaign.reading import Campaign, read_campaign
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.runs_table import Setup
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.comparison.compare import compare
from pipeclamp_identification.fitting.free_misfit import FreeMisfit, free_misfits
from pipeclamp_identification.fitting.identify import identify, law_file
from pipeclamp_identification.fitting.misfit import overall_nrmse
from pipeclamp_models.law.file import LawFile, Provenance
from pipeclamp_models.law.law import Structure

POWERS = tuple((name, 0.0) for name in ("alpha_A", "c_A", "k1_A", "k3_A"))
"""Of the amplitude, held where they do nothing."""
LAWS: tuple[Structure, ...] = (
    Structure(),
    *(
        Structure(base, effects, frozen)
        for base, effects in (("memory", ()), ("power", ("bouc_wen",)), ("power", ("slip_spread",)))
        for frozen in ((), POWERS)
    ),
)
"""A law whose coefficients follow A and f alone; laws with memory, each with powers of the amplitude and without."""
DEVICES = ("bouc_wen/", "dahl/", "friction_pendulum/", "iwan/", "drag/", "relief_damper/", "play_and_slip/")
PERIODS = 20.0
"""Length of a motion, in periods of the middle frequency."""
LINES = 40
"""Sines that a random motion is made of."""

Displacement = Callable[[Array], Array]
"""Over time as a share of the whole, 0 to 1."""


def displacements(periods: float, low: float, high: float, random: np.random.Generator) -> dict[str, Displacement]:
    """Give motions by name, in no unit; periods of the middle frequency, lowest and highest share of it."""
    share = np.sort(random.uniform(low, high, LINES))
    angle = random.uniform(0, 2 * np.pi, LINES)

    def noise(x: Array) -> Array:
        return np.asarray(np.sum(np.sin(2 * np.pi * periods * share * x[:, None] + angle) / share, axis=1))

    def sweep(x: Array) -> Array:
        turns = periods * (low * x + (high - low) * x**2 / 2)
        return np.asarray((1 - 0.8 * x) * np.sin(2 * np.pi * turns))

    def window(x: Array) -> Array:
        return np.asarray(np.sin(np.pi * np.clip(np.minimum(x, 1 - x) / 0.1, 0, 1) / 2) ** 2)

    return {
        "earthquake": lambda x: x**2 * np.exp(-12 * x) * window(x) * noise(x),
        "sweep": lambda x: window(x) * sweep(x),
        "random": lambda x: window(x) * noise(x),
    }


def free_runs(case: DeviceCase, seed: int) -> dict[str, FreeRun]:
    """Give a device's records along the motions, with the noise of its sensors."""
    tests, device, rig = measure_device(case, seed), case.device, case.rig
    random = np.random.default_rng([seed, 13])
    plan = rig.campaign
    middle = float(np.sqrt(min(plan.f) * max(plan.f)))
    T = sorted(plan.T)[len(plan.T) // 2]
    every = int(np.ceil(max(device.steps * max(plan.f), device.fastest(tests.parameters) / 0.7) / rig.rate))
    samples = round(PERIODS / middle * rig.rate)
    step = 1 / (rig.rate * every)
    x = np.arange(2 * samples * every + 1) / (2 * samples * every)
    found = {}
    for name, shape in displacements(PERIODS, min(plan.f) / middle, max(plan.f) / middle, random).items():
        y = shape(x)
        y = rig.largest * y / np.max(np.abs(y))
        v = np.gradient(y, step / 2)
        a = np.gradient(v, step / 2)
        columns = (channel[:, None] for channel in (y, v, a))
        force = device.force(Drive(step, *columns, middle, np.array([T]), np.zeros(1)), tests.parameters)[::every, 0]
        noise = tests.noise * float(np.sqrt(np.mean(force**2)))
        record = Record(
            np.arange(len(force)) / rig.rate, y[:: 2 * every].copy(), force + noise * random.standard_normal(len(force))
        )
        found[name] = FreeRun(name, Setup(temperature_C=T), record, free_motion(record))
    return found


def sines(case: DeviceCase, seed: int) -> tuple[Campaign, Campaign]:
    """Give a device's campaign of sines and those that are left out."""
    tests = measure_device(case, seed)
    with tempfile.TemporaryDirectory() as place:
        campaigns = []
        for name, records in (("campaign", tests.campaign), ("held_out", tests.held_out)):
            write_campaign(Path(place) / name, written(records), name=name, notes="")
            campaigns.append(read_campaign(Path(place) / name))
    return campaigns[0], campaigns[1]


def identified(campaign: Campaign, structure: Structure) -> LawFile:
    """Fit a law to sines."""
    return law_file(identify(campaign, structure), campaign, name=structure.base, provenance=Provenance("motions"))


def outside(misfit: FreeMisfit) -> float:
    """Give the share of the time for which A lies outside the law's range."""
    low, high = misfit.ranges[0]
    return float(np.mean((misfit.amplitude < low) | (misfit.amplitude > high)))


def lines_of(case: DeviceCase, seed: int) -> list[str]:
    """Give a device's lines of the table."""
    campaign, held_out = sines(case, seed)
    runs = free_runs(case, seed)
    lines = []
    for structure in LAWS:
        file = identified(campaign, structure)
        misfits = {name: free_misfits(file, [run])[0] for name, run in runs.items()}
        errors = [overall_nrmse((one,)) for one in misfits.values()]
        cells = [f"{compare(file, held_out).nrmse:.1%}", *(f"{error:.1%}" for error in errors)]
        cells += [" / ".join(f"{outside(one):.0%}" for one in misfits.values())]
        law = " + ".join((structure.base, *structure.effects)) + (" without powers of A" if structure.frozen else "")
        lines.append(f"| {case.name} | {law} | {' | '.join(cells)} |")
    return lines


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", nargs="*", default=list(DEVICES), help="devices whose name contains one of these")
    parser.add_argument("--draws", type=int, default=1, help="of each device")
    parser.add_argument("--seed", type=int, default=0, help="seed of everything that is drawn")
    given = parser.parse_args()
    cases = [case for case in device_cases() if any(word in case.name for word in given.cases)]
    cases = [case for case in cases if case.draw < given.draws and not case.rig.campaign.current]
    if not cases:
        sys.exit(f"--cases {' '.join(given.cases)}: no case has such a name")
    print("| device | law | left-out sines | earthquake | sweep | random | time with A outside the range |")
    print("|---|---|---|---|---|---|---|")
    for case in cases:
        for line in lines_of(case, given.seed):
            print(line, flush=True)


if __name__ == "__main__":
    main()
