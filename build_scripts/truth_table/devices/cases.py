"""The cases of other devices: which there are, and how one is drawn, measured and written."""

from __future__ import annotations

import json
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from devices.registry import DEVICES, Device
from devices.rigs import CURRENT, NOISES, RIGS, Records, Rig, habits, measured, rms, tested
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.writing import WrittenRun, write_campaign
from pipeclamp_models.law.catalogue import identifiers

DRAWS = 4
"""Devices of each law."""


@dataclass(frozen=True)
class DeviceCase:
    """A device of a law, by its number."""

    law: str
    draw: int

    @property
    def device(self) -> Device:
        """Its law."""
        return DEVICES[self.law]

    @property
    def truth(self) -> frozenset[str]:
        """The ids of what it really holds; none, where the catalogue lacks any of its physics."""
        effects = self.device.effects
        return effects if effects <= set(identifiers()) else frozenset()

    @property
    def rig_name(self) -> str:
        """The rig it is put on."""
        return self.device.rigs[self.draw % len(self.device.rigs)]

    @property
    def rig(self) -> Rig:
        """The rig it is put on."""
        return RIGS[self.rig_name]

    @property
    def name(self) -> str:
        """Its unique name."""
        return f"{self.law}/{self.rig_name.replace(' ', '_')}/{self.draw}"

    @property
    def family(self) -> tuple[str, ...]:
        """What a share of the cases is spread over."""
        return (self.law,)


def device_cases() -> list[DeviceCase]:
    """Give every case, in a fixed order."""
    return [DeviceCase(law, draw) for law in DEVICES for draw in range(DRAWS)]


@dataclass(frozen=True)
class DeviceTests:
    """A device, tested.

    Attributes:
        parameters: of its law.
        force: order of its force, N.
        noise: rms force noise as a share of the campaign's rms force.
        campaign, held_out: what the sensors show.
    """

    parameters: dict[str, float]
    force: float
    noise: float
    campaign: list[Records]
    held_out: list[Records]


def measure_device(case: DeviceCase, seed: int) -> DeviceTests:
    """Draw a device and test it."""
    random = np.random.default_rng([seed, zlib.crc32(case.name.encode())])
    rig, device = case.rig, case.device
    force = float(np.exp(random.uniform(*np.log(rig.force))))
    p = device.draw(random, rig.largest, force, rig.turn)
    habit = habits(random)
    share = float(np.exp(random.uniform(*np.log(NOISES))))
    ideal = [tested(device, p, plan, rig.rate, habit, random) for plan in (rig.campaign, rig.held_out)]
    noise = share * rms(ideal[0])
    campaign, held_out = (measured(one, noise, rig.largest, random) for one in ideal)
    return DeviceTests(p, force, share, campaign, held_out)


def write_device(case: DeviceCase, seed: int, folder: Path) -> DeviceTests:
    """Test a device and write the folders `campaign` and `held_out`, and device.json, into a new folder.

    Raises:
        UserError: a folder exists, or can't be written.
    """
    tests = measure_device(case, seed)
    folder.mkdir(parents=True, exist_ok=True)
    notes = f"virtual device {case.name}, seed {seed}; sensor noise {tests.noise:.2%} of the rms force"
    for name, records in (("campaign", tests.campaign), ("held_out", tests.held_out)):
        write_campaign(folder / name, written(records), name=f"{case.name} {name}", notes=notes)
    device = case.device
    truth = {"law": case.law, "equation": device.equation, "source": device.source, "effects": sorted(device.effects),
             "rig": case.rig_name, "force_N": tests.force, "noise": tests.noise,
             "parameters": tests.parameters}  # fmt: skip
    (folder / "device.json").write_text(json.dumps(truth, indent=1), encoding="utf-8")
    return tests


def written(records: Sequence[Records]) -> Iterator[WrittenRun]:
    """Give the runs as a campaign's writer takes them."""
    for one in records:
        for place, run in enumerate(one.runs):
            row: dict[str, str | float | None] = {
                "run": run.name, "amplitude_mm": run.A, "frequency_Hz": run.f, "temperature_C": run.T,
            }  # fmt: skip
            if run.current is not None:
                row[CURRENT] = run.current
            yield WrittenRun(row, Record(one.time, one.y[:, place].copy(), one.force[:, place].copy()))
