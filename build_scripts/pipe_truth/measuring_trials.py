"""A clamped pipe under one level of drive, weak or strong, of which the measurement, the pipe or the clamp is wrong."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from designs import DESIGNS, MASS, Design, Trial, sines
from pipe_rig import RecordedDrive, Sensor
from record_rig import DrivenMotion

LINE = """
name = "line"
[pipe]
outer_diameter_mm = 60.3
wall_mm = 3.91
length_m = 4.0
material = {{ E_GPa = {modulus}, density_kg_m3 = 7950.0 }}
[ends]
left = "clamped"
right = {right}
[[supports]]
position_m = 2.9
condition = {{ stiffness_N_mm = {support} }}
[[clamps]]
name = "clamp1"
position_m = {clamp}
{further}
[damping]
ratio = {ratio}
[modes]
up_to_Hz = 90
"""
LAW = {"k10": 20.0, "k30": 8.0, "c0": 1.0, "alpha0": 0.6}
DRIVES = {"weak": 0.3, "strong": 2.0}
"""m/s2; of the strong one the response bends over."""
NOISES = (0.01, 0.05)


def _design(drive: float) -> Design:
    return Design(
        LINE,
        {"modulus": 195.0, "right": '"pinned"', "support": 15.0, "clamp": 1.6, "ratio": 0.02, "further": ""},
        {"clamp1": LAW},
        '[excitation]\nkind = "sine"\nacceleration_m_s2 = 1.0\nfrequency_Hz = 17.0\n',
        (0.5, 17.0),
        (Sensor("near", 1.2, "m/s2"), Sensor("far", 2.2, "mm")),
        sines(12.0, 23.0, 16, (drive,)),
        {"random": (DrivenMotion("random", 3 * drive, 8.0, 30.0, 8.0),)},
    )


MEASURING_DESIGNS: Mapping[str, Design] = {f"line {name}": _design(drive) for name, drive in DRIVES.items()}
DESIGNS_AND_LINES = {**DESIGNS, **MEASURING_DESIGNS}


@dataclass(frozen=True)
class Fault:
    """What is hidden, as of `Trial`."""

    hidden: str
    truth: tuple[str, ...]
    fields: Mapping[str, object] = field(default_factory=dict)
    law: Mapping[str, float] = field(default_factory=dict)
    sensors: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    drive: RecordedDrive = field(default_factory=RecordedDrive)


FAULTS = (
    Fault("nothing", ()),
    Fault("both sensors 10 % too high", ("sensors.gain",), sensors={"near": {"gain": 1.1}, "far": {"gain": 1.1}}),
    Fault("frequency axis 1 % off", ("frequency_axis",), drive=RecordedDrive(rate=1.01)),
    Fault("clamp 5 % softer", ("clamp1.stiffness",), law={"k10": 19.0, "k30": 7.6}),
    Fault("clamp 20 % stiffer", ("clamp1.stiffness",), law={"k10": 24.0, "k30": 9.6}),
    Fault("clamp damping 0.7 times", ("clamp1.damping",), law={"c0": 0.7}),
    Fault(
        "support 8 N/mm instead of 15, 1 kg at 3.3 m", ("support:2.9.stiffness", "added_mass"),
        {"support": 8.0, "further": MASS.format(3.3, 1.0)},
    ),
    Fault("one sensor 10 % too high", ("sensor:far.gain",), sensors={"far": {"gain": 1.1}}),
    Fault("one sensor's sign", ("sensor:near.phase",), sensors={"near": {"gain": -1.0}}),
    Fault("one sensor 8 degrees ahead", ("sensor:far.phase",), sensors={"far": {"phase": 8.0}}),
    Fault("one sensor 2 ms late", ("sensor:far.delay",), sensors={"far": {"delay": 2e-3}}),
    Fault("m/s2 stated, g recorded", ("sensor:near.gain",), sensors={"near": {"gain": 1 / 9.80665}}),
    Fault("one sensor 0.15 m off", ("sensor:far.position",), sensors={"far": {"moved": 0.15}}),
    Fault("excitation 10 % too high", ("excitation.gain",), drive=RecordedDrive(gain=1.1)),
    Fault("excitation 2 ms late", ("excitation.delay",), drive=RecordedDrive(delay=2e-3)),
    Fault("clamp at 1.75 m instead of 1.6 m", ("clamp1.position",), {"clamp": 1.75}),
    Fault("modulus 10 % higher", ("modulus",), {"modulus": 214.5}),
)  # fmt: skip

MEASURING_TRIALS = tuple(
    Trial(
        name, fault.hidden, fault.truth, fault.fields, {"clamp1": fault.law}, noise=noise, sensors=fault.sensors,
        drive=fault.drive,
    )
    for noise in NOISES
    for fault in FAULTS
    for name in MEASURING_DESIGNS
) + tuple(
    replace(Trial(name, "nothing", (), noise=noise), measured=("random",))
    for noise in NOISES
    for name in MEASURING_DESIGNS
)  # fmt: skip
