"""Which loop tests narrow the band of a pipe's peak, and by how much, as data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pipeclamp_identification.campaign.drive import DrivePlan
from pipeclamp_identification.diagnosis.further_test.outlook import PROFILES, RUNS_OF_A_TEST, SINE
from pipeclamp_models.base.arrays import Array
from pipeclamp_system.bands.band import Band
from pipeclamp_system.bands.response_bands import PeakBand


@dataclass(frozen=True)
class NextLoopTest:
    """A loop test, and the band of the peak after it.

    Attributes:
        law: name of the law whose clamp is tested.
        clamps: of the pipe, that have it.
        amplitude_mm, frequency_Hz: its conditions.
        temperature_C: likewise; None where the temperature of the law's tests isn't known.
        amplitude, frequency: bands of the peak after it and all tests before, mm and Hz.
    """

    law: str
    clamps: tuple[str, ...]
    amplitude_mm: float
    frequency_Hz: float
    temperature_C: float | None
    amplitude: Band
    frequency: Band

    @property
    def plan(self) -> DrivePlan:
        """What the machine is asked to do."""
        return DrivePlan(PROFILES[SINE], self.amplitude_mm, self.frequency_Hz)


@dataclass(frozen=True, eq=False)
class Map:
    """What every test that was looked at would leave, as the first one.

    Attributes:
        law: whose clamp is tested.
        grid: A (mm), f (Hz), T (K), shape (R,) each.
        share: of the band's width that is left, shape (R,).
        motion: A, f, T of the pipe's motion at its peak.
        tested: the law's range of A, f and, where known, T.
    """

    law: str
    grid: Mapping[str, Array]
    share: Array
    motion: Mapping[str, float]
    tested: Mapping[str, tuple[float, float]]


@dataclass(frozen=True, eq=False)
class BandPlan:
    """Which loop tests narrow the band of a peak.

    Attributes:
        system: name.
        curve: which one, in words; point: the clamp or probe.
        per_cent: that bands hold.
        before: the peak's band.
        tests: one after another, best first; none where none is worth its time.
        floor: band of the amplitude that no number of loop tests of the same kind goes below, mm.
        maps: of each law.
        limits: within which tests were sought, in words, by law.
        noise: what was reckoned with, in words, by law.
        gaps: what the laws' files don't tell, in words.
    """

    system: str
    curve: str
    point: str
    per_cent: float
    before: PeakBand
    tests: tuple[NextLoopTest, ...]
    floor: Band
    maps: tuple[Map, ...]
    limits: Mapping[str, str]
    noise: Mapping[str, str]
    gaps: tuple[str, ...]


def test_words(test: NextLoopTest) -> str:
    """Say which test it is."""
    warm = "the temperature of the tests so far" if test.temperature_C is None else f"{test.temperature_C:.3g} °C"
    return (
        f"{PROFILES[SINE].words} of the clamp of {test.law} at {test.amplitude_mm:.3g} mm, {test.frequency_Hz:.3g} Hz, "
        f"{warm}, {RUNS_OF_A_TEST} times"
    )
