"""What `plan SYSTEM.toml` answers: the band of the pipe's peak, and after which loop tests it is how narrow."""

from __future__ import annotations

from collections.abc import Mapping

from pydantic import Field

from pipeclamp_identification.diagnosis.further_test.outlook import RUNS_OF_A_TEST
from pipeclamp_identification.planning.band_plan import BandPlan, NextLoopTest
from pipeclamp_models.base.answer import AnswerModel
from pipeclamp_system.bands.band import Band


class BandAnswer(AnswerModel):
    """A number with the ends of its band, and what of its variance comes from what."""

    value: float
    low: float
    high: float
    shares: Mapping[str, float] = Field(description="of the variance: parameters, runs, form, solution")


class LoopTestAnswer(AnswerModel):
    """A loop test that is proposed, and the bands of the peak after it and all before it."""

    law: str = Field(description="whose clamp is tested")
    clamps: tuple[str, ...] = Field(description="of the pipe, that have this law")
    amplitude_mm: float
    frequency_Hz: float
    temperature_C: float | None = Field(description="None: that of the law's tests, which isn't known")
    repeats: int
    peak_mm: BandAnswer
    peak_Hz: BandAnswer


class BandPlanAnswer(AnswerModel):
    """Which loop tests narrow the band of the pipe's peak."""

    system: str
    curve: str
    point: str = Field(description="clamp or probe")
    per_cent: float = Field(description="that bands hold")
    peak_mm: BandAnswer
    peak_Hz: BandAnswer
    tests: tuple[LoopTestAnswer, ...] = Field(description="one after another; none: no test is worth its time")
    at_best_mm: BandAnswer = Field(description="band that no number of such tests goes below")
    limits: Mapping[str, str] = Field(description="within which tests were sought, by law")
    noise: Mapping[str, str] = Field(description="of the force, that was reckoned with, by law")
    gaps: tuple[str, ...] = Field(description="what the laws' files don't tell")


def band_plan_answer(plan: BandPlan) -> BandPlanAnswer:
    """Give what a plan found."""
    return BandPlanAnswer(
        system=plan.system,
        curve=plan.curve,
        point=plan.point,
        per_cent=plan.per_cent,
        peak_mm=_band(plan.before.amplitude),
        peak_Hz=_band(plan.before.frequency),
        tests=tuple(_test(test) for test in plan.tests),
        at_best_mm=_band(plan.floor),
        limits=plan.limits,
        noise=plan.noise,
        gaps=plan.gaps,
    )


def _band(band: Band) -> BandAnswer:
    return BandAnswer(value=band.value, low=band.low, high=band.high, shares=band.shares)


def _test(test: NextLoopTest) -> LoopTestAnswer:
    return LoopTestAnswer(
        law=test.law,
        clamps=test.clamps,
        amplitude_mm=test.amplitude_mm,
        frequency_Hz=test.frequency_Hz,
        temperature_C=test.temperature_C,
        repeats=RUNS_OF_A_TEST,
        peak_mm=_band(test.amplitude),
        peak_Hz=_band(test.frequency),
    )
