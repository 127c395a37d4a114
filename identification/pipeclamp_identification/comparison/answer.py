"""What `compare` answers of a law and records: the error of each run, and where it sits."""

from __future__ import annotations

from collections.abc import Mapping

from pydantic import Field

from pipeclamp_identification.comparison import breakdown
from pipeclamp_identification.comparison.breakdown import BRANCHES, PLACES, Breakdown, Part, phase_edges, place_of
from pipeclamp_identification.comparison.compare import Comparison, celsius, where_words
from pipeclamp_identification.comparison.concentration import region
from pipeclamp_identification.fitting.misfit import known_noise
from pipeclamp_models.base.answer import AnswerModel, LeftOutRun


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


class WhereAnswer(AnswerModel):
    """Where the error sits."""

    words: tuple[str, ...]
    region: RegionAnswer | None
    phases: tuple[PhaseAnswer, ...]
    places: tuple[PartAnswer, ...]
    branches: tuple[PartAnswer, ...]
    harmonics: tuple[PartAnswer, ...]
    cycles: tuple[PartAnswer, ...]
    drift: DriftAnswer | None
    conditions: Mapping[str, tuple[PartAnswer, ...]]


class RunComparison(AnswerModel):
    """The error of one run."""

    run: str
    nrmse: float = Field(description="rms error over rms force of the run's steady samples")
    noise_nrmse: float | None = Field(description="cycle-to-cycle scatter of it; None of a single cycle")
    amplitude_mm: float
    frequency_Hz: float
    temperature_C: float | None
    outside_range: str | None = Field(description="what lies outside the range that the law was identified in")


class ComparisonAnswer(AnswerModel):
    """The answer of `pipeclamp compare --json` for records."""

    nrmse: float = Field(description="rms error over rms force, over the steady samples of all runs")
    noise_nrmse: float | None = Field(description="cycle-to-cycle scatter of it, which no law can explain")
    runs: tuple[RunComparison, ...]
    where: WhereAnswer
    left_out: tuple[LeftOutRun, ...]


def comparison_answer(comparison: Comparison) -> ComparisonAnswer:
    """Give what a comparison found; what isn't known is None."""
    loops = comparison.loops
    return ComparisonAnswer(
        nrmse=comparison.nrmse,
        noise_nrmse=known_noise(comparison.runs, loops),
        runs=tuple(
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
        where=_where(comparison),
        left_out=tuple(LeftOutRun(run=entry.run, reason=entry.reason) for entry in comparison.campaign.left_out),
    )


def _where(comparison: Comparison) -> WhereAnswer:
    sums = comparison.sums
    drift, densest = breakdown.drift(sums), region(sums, comparison.varied)
    return WhereAnswer(
        words=tuple(where_words(comparison)),
        region=None
        if densest is None
        else RegionAnswer(words=densest.words, share=densest.share, even_share=densest.even),
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
    )


def parts_answer(parts: Breakdown) -> tuple[PartAnswer, ...]:
    """Give the parts of a breakdown; what isn't known is None."""
    return tuple(_part(parts, part) for part in parts.parts)


def _part(parts: Breakdown, part: Part) -> PartAnswer:
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
            PhaseAnswer(**vars(part), from_deg=begin, to_deg=end, place=PLACES[place][0], branch=BRANCHES[branch])
        )
    return tuple(found)
