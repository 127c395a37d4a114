"""What the virtual rig runs, and how well it measures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_identification.campaign.cycles import find_cycles
from pipeclamp_identification.campaign.drive import Drive
from pipeclamp_identification.campaign.plausibility import fundamental_of
from pipeclamp_identification.campaign.records import Record, UnusableRecord, check_samples
from pipeclamp_models.base.digits import rounded_to
from pipeclamp_models.base.errors import UsageError, UserError
from pipeclamp_models.base.units import CELSIUS

MOST_SAMPLES_AT_A_FREQUENCY = 10_000_000
"""More at one frequency don't fit into the memory of a small machine."""
FEWEST_SAMPLES_A_CYCLE = 20
"""Of the fastest tone of the motion."""
ZERO_OR_MORE = (
    "ramp_cycles", "force_noise", "displacement_noise", "force_step", "displacement_step", "distortion", "riding",
    "amplitude_error", "temperature_error", "force_range", "displacement_range", "specimen_scatter",
)  # fmt: skip
OF_EITHER_SIGN = ("force_drift", "displacement_drift", "force_gain_drift", "about")
"""Fields of a plan by what they may be."""


@dataclass(frozen=True)
class RigRun:
    """One run of a campaign that was planned: its name, mm, Hz, degC, and the load cycles before it."""

    run: str
    amplitude_mm: float
    frequency_Hz: float
    temperature_C: float
    first_cycle: float


@dataclass(frozen=True)
class TestPlan:
    """What the virtual rig runs and how well it measures.

    Attributes:
        amplitudes: mm; frequencies: Hz; temperatures: degC; every combination is one run.
        cycles: cycles per record; need not be whole.
        ramp_cycles: cycles of ramp-in before them.
        rate: samples per second.
        force_noise: rms of the force sensor's noise in N.
        displacement_noise: rms of the displacement sensor's noise in mm.
        force_step, displacement_step: quantisation in N and mm; 0 for none.
        about: displacement about which the runs move, mm; None for that of the tests of the law that is run.
        distortion: third harmonic of the drive as a share of the amplitude.
        riding: small cycles that ride on the large one, as a share of its amplitude.
        riding_order: so many of them a cycle.
        amplitude_error: rms of the amplitude's error as a share.
        temperature_error: rms of the temperature's error in K.
        force_drift, displacement_drift: of the channels' zeros, N/s and mm/s, from each record's first sample on.
        force_gain_drift: of the force channel's gain, share per second, likewise.
        force_range, displacement_range: where the sensors end on either side, N and mm; 0 for nowhere.
        specimens: so many, each run in every combination; 0 for one without a name.
        specimen_scatter: rms share by which each specimen's stiffness, and its damping, differ from the law's.
        repeats: runs of each combination.
        seed: of the random numbers; the same seed gives the same campaign.
        drive: the displacement of every run, where it isn't made of these amplitudes, frequencies, cycles and tones.
        runs: all runs in their order, where they aren't every combination; amplitudes, frequencies and temperatures are
            theirs.
    """

    amplitudes: tuple[float, ...] = (0.2, 0.5, 0.8, 1.0)
    frequencies: tuple[float, ...] = (1.0, 3.0, 5.0)
    temperatures: tuple[float, ...] = (20.0, 100.0, 200.0, 300.0)
    cycles: float = 5.0
    ramp_cycles: float = 0.0
    rate: float = 1000.0
    force_noise: float = 3.0
    displacement_noise: float = 0.0002
    force_step: float = 0.1
    displacement_step: float = 0.0001
    about: float | None = None
    distortion: float = 0.005
    riding: float = 0.0
    riding_order: int = 7
    amplitude_error: float = 0.005
    temperature_error: float = 1.0
    force_drift: float = 0.0
    displacement_drift: float = 0.0
    force_gain_drift: float = 0.0
    force_range: float = 0.0
    displacement_range: float = 0.0
    specimens: int = 0
    specimen_scatter: float = 0.0
    repeats: int = 1
    seed: int = 0
    drive: Drive | None = None
    runs: tuple[RigRun, ...] = ()

    def duration_s(self, frequency: float) -> float:
        """Give how long a record at a frequency (Hz) is, s."""
        return self.drive.duration_s if self.drive else (self.cycles + self.ramp_cycles) / frequency

    def check(self) -> None:
        """Refuse a plan that can't be run.

        Raises:
            UsageError: a value is out of its range; the message names it.
        """
        self._check_levels()
        self._check_counts()
        self._check_rate()
        for name in ZERO_OR_MORE:
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) >= 0):
                raise UsageError(f"test plan: {name} is {getattr(self, name):g}; expected a number of at least 0")
        for name in OF_EITHER_SIGN:
            if not np.isfinite(getattr(self, name) or 0.0):
                raise UsageError(f"test plan: {name} is {getattr(self, name):g}; expected a finite number")

    def _check_levels(self) -> None:
        """Refuse amplitudes, frequencies and temperatures that no rig has, or that are there twice."""
        if not (self.amplitudes and self.frequencies and self.temperatures):
            raise UsageError("test plan: got an empty list; expected at least one amplitude, frequency and temperature")
        lists = {"amplitude": self.amplitudes, "frequency": self.frequencies, "temperature": self.temperatures}
        for name, values in lists.items():
            texts = [f"{value:g}" for value in values]
            if len(set(texts)) < len(texts):
                raise UsageError(f"test plan: {name} {', '.join(texts)}; expected each value once")
        for name, values in (("amplitude", self.amplitudes), ("frequency", self.frequencies)):
            for value in values:
                if not (np.isfinite(value) and value > 0):
                    raise UsageError(f"test plan: {name} is {value:g}; expected a number above 0")
        for value in self.temperatures:
            if not (np.isfinite(value) and value > -CELSIUS):
                raise UsageError(f"test plan: temperature is {value:g} °C; expected a number above {-CELSIUS:g}")

    def _check_counts(self) -> None:
        """Refuse less than a cycle, less than one run of each combination, and more samples than memory holds."""
        if not self.cycles >= 1:
            raise UsageError(f"test plan: {self.cycles:g} cycles; expected at least one whole cycle")
        if self.repeats < 1:
            raise UsageError(f"test plan: {self.repeats} repeats; expected at least 1")
        samples = self.duration_s(min(self.frequencies)) * self.rate
        if not samples * len(self.amplitudes) * len(self.temperatures) * self.repeats <= MOST_SAMPLES_AT_A_FREQUENCY:
            raise UsageError(
                f"test plan: {samples:.3g} samples per record at {min(self.frequencies):g} Hz; expected at most "
                f"{MOST_SAMPLES_AT_A_FREQUENCY:.0e} at one frequency over all amplitudes and temperatures: "
                "fewer cycles, a lower rate"
            )

    def _check_rate(self) -> None:
        """Refuse fewer samples than the fastest tone of the motion needs."""
        if self.riding_order < 2:
            raise UsageError(f"test plan: riding_order is {self.riding_order}; expected a whole number above 1")
        fastest = max(self.frequencies) * (self.riding_order if self.riding > 0 else 1)
        if self.drive:
            fastest = self.drive.highest_frequency()
        if not self.rate >= FEWEST_SAMPLES_A_CYCLE * fastest:
            raise UsageError(
                f"test plan: {self.rate:g} samples per second for {fastest:g} Hz; "
                f"expected at least {FEWEST_SAMPLES_A_CYCLE} samples per cycle"
            )


def driven(plan: TestPlan, drive: Drive) -> TestPlan:
    """Give a plan whose runs follow a drive signal, at the temperatures and with the sensors of another.

    Raises:
        UserError: the drive signal holds no whole cycle.
    """
    record = Record(drive.time_s, drive.displacement_mm, drive.displacement_mm)
    try:
        check_samples(record)
        cycles = find_cycles(record)
    except UnusableRecord as fault:
        raise UserError(f"drive signal: {fault}; expected whole cycles of one frequency at full amplitude") from fault
    # nominal ones: what a record shows counts
    amplitude, frequency = (
        rounded_to(value, 3) for value in (fundamental_of(record, cycles).amplitude_mm, cycles.frequency_Hz)
    )
    return replace(plan, amplitudes=(amplitude,), frequencies=(frequency,), drive=drive)


def planned(plan: TestPlan, runs: Sequence[RigRun]) -> TestPlan:
    """Give a plan of these runs, with the sensors and the cycles of another."""
    levels = (
        sorted({getattr(run, name) for run in runs}) for name in ("amplitude_mm", "frequency_Hz", "temperature_C")
    )
    amplitudes, frequencies, temperatures = map(tuple, levels)
    return replace(
        plan, amplitudes=amplitudes, frequencies=frequencies, temperatures=temperatures, repeats=1, runs=tuple(runs)
    )


def plain_name(text: str) -> str:
    """Give a name of a run or a file that says numbers without points and signs: A0p5 for A0.5."""
    return text.replace(".", "p").replace("-", "m")
