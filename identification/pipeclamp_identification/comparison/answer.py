"""What `compare` answers of a law and records: the error of each run, and where it sits."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal

import numpy as np
from pydantic import Field

from pipeclamp_identification.campaign.faults import SensorFault
from pipeclamp_identification.comparison import breakdown, free_breakdown
from pipeclamp_identification.comparison.breakdown import BRANCHES, LOOP_PLACES, phase_edges, place_of
from pipeclamp_identification.comparison.compare import Comparison, celsius, where_words
from pipeclamp_identification.comparison.concentration import region
from pipeclamp_identification.comparison.densest_region import Region
from pipeclamp_identification.comparison.error_parts import Breakdown, ErrorPart
from pipeclamp_identification.comparison.free_breakdown import FreeSamples
from pipeclamp_identification.comparison.free_concentration import error_outside, free_region, outside_share
from pipeclamp_identification.fitting.free_misfit import FreeMisfit
from pipeclamp_models.base.answer import AnswerModel, LeftOutRun, left_out_runs
from pipeclamp_models.base.units import celsius_of


class PartAnswer(AnswerModel):
    """A part of the squared error."""

    part: str
    nrmse: float | None = Field(description="error as a share of the rms force; None where the part has no sample")
    noise_nrmse: float | None = Field(description="scatter, likewise; None where it isn't known")
    share: float = Field(description="of the whole squared error")
    noise_share: float | None = Field(description="the scatter in this part as a share of the whole squared error")
    even_share: float = Field(description="share that the part would hold if every run erred evenly")
    runs: int


class PhaseAnswer(PartAnswer):
    """A part of the cycle, in degrees after the largest displacement."""

    from_deg: float
    to_deg: float
    place: str
    branch: str


class RegionAnswer(AnswerModel):
    """Where the error is densest: in words, with the share of the squared error beyond scatter that lies there."""

    words: tuple[str, ...]
    share: float
    even_share: float


class DriftAnswer(AnswerModel):
    """Drift of the measured force against the law from a record's first cycle to its last, of its first harmonic."""

    in_phase: float
    in_quadrature: float
    standard_error: float


class FreeWhereAnswer(AnswerModel):
    """Where the error along free motions sits; each breakdown parts the same whole."""

    region: RegionAnswer | None
    components: tuple[PartAnswer, ...] = Field(description="constant, with the displacement, with the velocity, rest")
    time: tuple[PartAnswer, ...] = Field(description="tenths of each record")
    places: tuple[PartAnswer, ...] = Field(description="between turning points, or nearly still")
    directions: tuple[PartAnswer, ...]
    displacement: tuple[PartAnswer, ...] = Field(description="classes, mm")
    speed: tuple[PartAnswer, ...] = Field(description="classes, mm/s")
    tracked_amplitude: tuple[PartAnswer, ...] = Field(description="classes, mm")
    tracked_frequency: tuple[PartAnswer, ...] = Field(description="classes, Hz")
    conditions: Mapping[str, tuple[PartAnswer, ...]] = Field(description="run, and what varies from run to run")


class WhereAnswer(AnswerModel):
    """Where the error sits: of the sines, and in `free` of free motions."""

    words: tuple[str, ...]
    region: RegionAnswer | None
    phases: tuple[PhaseAnswer, ...]
    places: tuple[PartAnswer, ...]
    branches: tuple[PartAnswer, ...]
    harmonics: tuple[PartAnswer, ...]
    cycles: tuple[PartAnswer, ...]
    drift: DriftAnswer | None
    conditions: Mapping[str, tuple[PartAnswer, ...]]
    free: FreeWhereAnswer | None = Field(default=None, description="None where every motion is a sine")


class TrackedAnswer(AnswerModel):
    """Amplitude or frequency of a free motion, tracked as an FMU does: from the middle of the law's range on."""

    minimum: float
    maximum: float
    outside_share: float = Field(description="of the time, outside the law's range; the law is then taken at its end")
    outside_error_share: float = Field(default=0.0, description="of the squared error, that lies there")


class RunComparison(AnswerModel):
    """The error of one run."""

    run: str
    motion: Literal["sine", "free"] = "sine"
    nrmse: float = Field(description="rms error over rms force: of a sine's steady samples, of all of a free motion")
    noise_nrmse: float | None = Field(
        description="cycle-to-cycle scatter of it; None of a single cycle and of a free motion"
    )
    amplitude_mm: float | None = Field(description="None of a free motion")
    frequency_Hz: float | None = Field(description="None of a free motion")
    temperature_C: float | None
    outside_range: str | None = Field(description="what lies outside the range that the law was identified in")
    tracked_amplitude_mm: TrackedAnswer | None = Field(default=None, description="None of a sine")
    tracked_frequency_Hz: TrackedAnswer | None = Field(default=None, description="None of a sine")
    came_from_mm: float | None = Field(
        default=None,
        description="of a free motion: whence the law was brought to where the record begins, so that its force at "
        "rest is the measured one; None where its memory begins unloaded",
    )
    mean_taken: bool | None = Field(
        default=None,
        description="of a free motion: the law's force or the measured one is known up to a constant only, and the "
        "measured mean is taken",
    )
    rest_force_N: float | None = Field(
        default=None,
        description="of a free motion: the law's force where the record begins, at rest and unloaded; None where it "
        "has none worth a word",
    )
    nrmse_without_rest_force: float | None = Field(
        default=None, description="nrmse, were the law without that constant force"
    )


class ComparisonAnswer(AnswerModel):
    """The answer of `pipeclamp compare --json` for records."""

    nrmse: float = Field(description="rms error over rms force, over the samples of all runs that are used")
    noise_nrmse: float | None = Field(
        description="cycle-to-cycle scatter of it, which no law can explain; None where a free motion counts, whose "
        "scatter nobody knows"
    )
    mean_share: float | None = Field(
        description="share of the squared force that the mean forces of the sines hold, a constant load; None without "
        "sines"
    )
    runs: tuple[RunComparison, ...]
    where: WhereAnswer
    left_out: tuple[LeftOutRun, ...]
    sensors: tuple[SensorFault, ...] = Field(description="gross faults of sensors, and what was done about them")


def comparison_answer(comparison: Comparison) -> ComparisonAnswer:
    """Give what a comparison found; what isn't known is None."""
    loops = comparison.loops
    return ComparisonAnswer(
        nrmse=comparison.nrmse,
        noise_nrmse=comparison.known_noise,
        mean_share=loops.mean_share if comparison.runs else None,
        runs=(
            *(
                RunComparison(
                    run=run.run,
                    nrmse=run.nrmse,
                    noise_nrmse=run.noise_nrmse if sums.scatter_known else None,
                    amplitude_mm=float(loops.amplitude_mm[row]),
                    frequency_Hz=float(loops.frequency_Hz[row]),
                    temperature_C=celsius(loops, row),
                    outside_range=comparison.outside.get(run.run),
                )
                for row, (run, sums) in enumerate(zip(comparison.runs, comparison.sums, strict=True))
            ),
            *(_free_run(run, comparison) for run in comparison.free),
        ),
        where=_where(comparison),
        left_out=left_out_runs(comparison.campaign.left_out),
        sensors=comparison.campaign.faults,
    )


def _free_run(run: FreeMisfit, comparison: Comparison) -> RunComparison:
    """Give the error of a run of free motion."""
    A, f = (
        TrackedAnswer(
            minimum=float(np.min(values)),
            maximum=float(np.max(values)),
            outside_share=outside_share((FreeSamples(run),), index),
            outside_error_share=error_outside((FreeSamples(run),), index),
        )
        for index, values in enumerate((run.amplitude, run.frequency))
    )
    return RunComparison(
        run=run.run,
        motion="free",
        nrmse=run.nrmse,
        noise_nrmse=None,
        amplitude_mm=None,
        frequency_Hz=None,
        temperature_C=celsius_of(run.temperature_K) if math.isfinite(run.temperature_K) else None,
        outside_range=comparison.outside.get(run.run),
        tracked_amplitude_mm=A,
        tracked_frequency_Hz=f,
        came_from_mm=run.came_from,
        mean_taken=run.adrift,
        rest_force_N=None if run.nrmse_without is None else run.at_rest,
        nrmse_without_rest_force=run.nrmse_without,
    )


def _where(comparison: Comparison) -> WhereAnswer:
    free = _free_where(comparison) if comparison.free else None
    words = tuple(where_words(comparison))
    if not comparison.runs:
        return WhereAnswer(
            words=words, region=None, phases=(), places=(), branches=(), harmonics=(), cycles=(), drift=None,
            conditions={}, free=free,
        )  # fmt: skip
    sums = comparison.sums
    drift = breakdown.drift(sums)
    return WhereAnswer(
        words=words,
        region=region_answer(region(sums, comparison.varied)),
        phases=_phases(breakdown.along_loop(sums)),
        places=parts_answer(breakdown.by_place(sums)),
        branches=parts_answer(breakdown.by_branch(sums)),
        harmonics=parts_answer(breakdown.by_harmonic(sums)),
        cycles=parts_answer(breakdown.along_cycles(sums)),
        drift=None
        if drift is None
        else DriftAnswer(
            in_phase=drift.in_phase, in_quadrature=drift.in_quadrature, standard_error=drift.standard_error
        ),
        conditions={
            condition.key: parts_answer(breakdown.by_condition(sums, condition)) for condition in comparison.varied
        },
        free=free,
    )


def region_answer(found: Region | None) -> RegionAnswer | None:
    """Give what an answer says of the region that holds most of the error, where there is one."""
    return None if found is None else RegionAnswer(words=found.words, share=found.share, even_share=found.even)


def _free_where(comparison: Comparison) -> FreeWhereAnswer:
    samples, varied = comparison.free_samples, comparison.free_varied
    displacement, speed, amplitude, frequency = (
        parts_answer(free_breakdown.by_class(samples, classes)) for classes in free_breakdown.motion_classes(samples)
    )
    return FreeWhereAnswer(
        region=region_answer(free_region(samples, varied)),
        components=parts_answer(free_breakdown.by_component(samples)),
        time=parts_answer(free_breakdown.by_time(samples)),
        places=parts_answer(free_breakdown.by_free_place(samples)),
        directions=parts_answer(free_breakdown.by_direction(samples)),
        displacement=displacement,
        speed=speed,
        tracked_amplitude=amplitude,
        tracked_frequency=frequency,
        conditions={
            condition.key: parts_answer(free_breakdown.by_free_condition(samples, condition)) for condition in varied
        },
    )


def parts_answer(parts: Breakdown) -> tuple[PartAnswer, ...]:
    """Give the parts of a breakdown; what isn't known is None."""
    return tuple(_part(parts, part) for part in parts.parts)


def _part(parts: Breakdown, part: ErrorPart) -> PartAnswer:
    return PartAnswer(
        part=part.label,
        nrmse=part.nrmse,
        noise_nrmse=part.noise_nrmse,
        share=parts.share(part),
        noise_share=parts.noise_share(part),
        even_share=parts.even_share(part),
        runs=part.runs,
    )


def _phases(phases: Breakdown) -> tuple[PhaseAnswer, ...]:
    found = []
    for index, part in enumerate(parts_answer(phases)):
        place, branch = place_of(index)
        begin, end = phase_edges(index)
        found.append(
            PhaseAnswer(**vars(part), from_deg=begin, to_deg=end, place=LOOP_PLACES[place][0], branch=BRANCHES[branch])
        )
    return tuple(found)
