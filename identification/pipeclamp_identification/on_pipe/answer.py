"""What `compare` answers of a coupled system: how much it errs on the pipe, and where."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from pydantic import Field

from pipeclamp_identification.comparison.answer import PartAnswer, RegionAnswer, parts_answer, region_answer
from pipeclamp_identification.on_pipe.measurement import QUANTITIES
from pipeclamp_identification.on_pipe.records import RecordsComparison, records_words
from pipeclamp_identification.on_pipe.sines import PipeComparison
from pipeclamp_identification.on_pipe.where import where_words
from pipeclamp_models.base.answer import AnswerModel, known


def where_told(description: str = "") -> Any:
    """Give a field that is left out where it has nothing to say."""
    return Field(None, exclude_if=lambda value: value is None, description=description or None)


class ProbeAnswer(AnswerModel):
    """The error at one probe."""

    probe: str
    quantity: str | None = where_told("of sines: displacement, velocity or acceleration")
    nrmse: float | None = Field(description="error as a share of the rms of what was measured; None: nothing was")
    noise_nrmse: float | None = Field(description="scatter, likewise; None where it isn't known")


class SineAnswer(AnswerModel):
    """The error of one sine; of the excitation's three columns the one that was driven is there."""

    file: str
    frequency_Hz: float
    acceleration_m_s2: float | None = where_told()
    displacement_mm: float | None = where_told()
    force_N: float | None = where_told()
    temperature_C: float | None = Field(description="of the clamps; None where it wasn't measured")
    nrmse: float | None
    stable_motions: int = Field(description="of the model under that sine; compared is one of them")
    truncated: float | None = Field(
        description="what the computed motion is off by because harmonics are left out, as a share; None: no motion"
    )


class RecordAnswer(AnswerModel):
    """The error of one record of any motion."""

    file: str
    nrmse: float | None


class PipeWhereAnswer(AnswerModel):
    """Where the error sits."""

    words: tuple[str, ...]
    region: RegionAnswer | None = Field(description="where it is densest; None where it is spread evenly")
    kinds: tuple[PartAnswer, ...] | None = where_told("of sines: amplitude and phase")
    probes: tuple[PartAnswer, ...]
    conditions: Mapping[str, tuple[PartAnswer, ...]]


class BandsOnPipeAnswer(AnswerModel):
    """How much of what was measured lies in the band of the model."""

    per_cent: float = Field(description="that each band holds")
    compared: int = Field(description="measured amplitudes")
    outside: int = Field(description="of them, those outside their band")
    share_outside: float
    half_width: float = Field(description="median of half a band, as a share of the computed amplitude")


class OnPipeAnswer(AnswerModel):
    """A coupled system against sines, or against records of any motion."""

    nrmse: float = Field(description="error as a share of the rms of what was measured")
    noise_nrmse: float | None = Field(description="the part of it that is scatter between repeats; None: not known")
    probes: tuple[ProbeAnswer, ...]
    sines: tuple[SineAnswer, ...] | None = where_told()
    records: tuple[RecordAnswer, ...] | None = where_told()
    where: PipeWhereAnswer


def sines_answer(comparison: PipeComparison) -> OnPipeAnswer:
    """Give what a comparison with sines found; what isn't known is None."""
    by_probe = comparison.by_probe()
    measured = zip(comparison.measurement.description.probes, by_probe.parts, strict=True)
    return OnPipeAnswer(
        nrmse=comparison.nrmse,
        noise_nrmse=comparison.noise_nrmse,
        probes=tuple(
            ProbeAnswer(
                probe=probe.name, quantity=QUANTITIES[probe.order], nrmse=part.nrmse, noise_nrmse=part.noise_nrmse
            )
            for probe, part in measured
        ),
        sines=tuple(_sine(comparison, row) for row in range(comparison.measurement.steady.frequency.size)),
        where=PipeWhereAnswer(
            words=tuple(where_words(comparison)),
            region=region_answer(comparison.region()),
            kinds=parts_answer(comparison.by_kind()),
            probes=parts_answer(by_probe),
            conditions={
                condition.key: parts_answer(comparison.by_condition(condition)) for condition in comparison.conditions
            },
        ),
    )


def _sine(comparison: PipeComparison, row: int) -> SineAnswer:
    steady = comparison.measurement.steady
    level = float(steady.level[row])
    return SineAnswer(
        file=steady.source[row],
        frequency_Hz=float(steady.frequency[row]),
        acceleration_m_s2=level if steady.drive_unit == "acceleration_m_s2" else None,
        displacement_mm=level if steady.drive_unit == "displacement_mm" else None,
        force_N=level if steady.drive_unit == "force_N" else None,
        temperature_C=known(float(steady.temperature[row])),
        nrmse=comparison.part("", np.array([row])).nrmse,
        stable_motions=int(comparison.prediction.branches[row]),
        truncated=known(float(comparison.truncated[row])),
    )


def records_answer(comparison: RecordsComparison) -> OnPipeAnswer:
    """Give what a comparison with records found; scatter isn't known of them."""
    by_probe, by_band, *_ = comparison.breakdowns()
    squares = (squares.sum(axis=(1, 2)) for squares in comparison.squares)
    return OnPipeAnswer(
        nrmse=comparison.nrmse,
        noise_nrmse=None,
        probes=tuple(ProbeAnswer(probe=part.label, nrmse=part.nrmse, noise_nrmse=None) for part in by_probe.parts),
        records=tuple(
            RecordAnswer(file=pair.name, nrmse=math.sqrt(float(error / measured)) if measured else None)
            for pair, error, measured in zip(comparison.pairs, *squares, strict=True)
        ),
        where=PipeWhereAnswer(
            words=tuple(records_words(comparison)[1:2]),
            region=region_answer(comparison.region()),
            probes=parts_answer(by_probe),
            conditions={"frequency_Hz": parts_answer(by_band)},
        ),
    )
