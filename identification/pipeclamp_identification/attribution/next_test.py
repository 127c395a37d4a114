"""Which further test would tell apart what these measurements can't: where the refitted models differ most."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from pipeclamp_identification.attribution.compared import Compared
from pipeclamp_identification.attribution.refit import changed
from pipeclamp_identification.attribution.verdict import Attribution, Candidate
from pipeclamp_identification.on_pipe.measurement import (
    MeasurementDescription,
    PipeMeasurement,
    ProbeTable,
    SteadyMeasurement,
)
from pipeclamp_identification.on_pipe.model import CoupledModel
from pipeclamp_identification.on_pipe.prediction import predict
from pipeclamp_models.base.arrays import Array, ComplexArray
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.pipe.description import Place
from pipeclamp_system.description.measured_table import DRIVES, Drive

SINES = 12
"""Of a proposed series."""
LOUDER = (0.25, 4.0)
"""Times the levels that were measured."""
FREQUENCY_WIDENING = 2.0
"""Times the highest frequency that was measured, and its inverse for the lowest."""
PROBE_POSITIONS = 7
"""Positions along the pipe at which another probe is tried."""
AT_LEAST = 0.02
"""Difference of two models, as a share of the response's rms, below which a test tells nothing."""


@dataclass(frozen=True)
class PipeTestProposal:
    """A test that would tell refitted models apart.

    Attributes:
        test: in words.
        apart: rms of the difference of those two models that differ least there, as a share of the rms response.
        now: the same at what was measured.
    """

    test: str
    apart: float
    now: float

    def words(self) -> str:
        """Say which test, and why."""
        return (
            f"{self.test}: there the explanations differ by {self.apart:.1%} of the response at least; at what was "
            f"measured, by {self.now:.1%}."
        )


@dataclass(frozen=True)
class Tested:
    """What was measured so far: Hz, least and largest level in the excitation's unit, degC of the clamps; in words."""

    verb: str
    description: MeasurementDescription
    low: float
    high: float
    quietest: float
    loudest: float
    drive_unit: Drive
    temperature: float | None


def propose(attribution: Attribution, compared: Compared) -> PipeTestProposal | None:
    """Propose the sines at which the named candidates differ most; None where none is found that tells more."""
    named = attribution.named[:3]
    if len(named) < 2:
        return None
    model = attribution.task.model
    now = min(_difference_now(one, other) for one, other in combinations(named, 2))
    best: tuple[float, str] | None = None
    for choices, probes, test in _tests(tested(compared), model):
        responses = [_response(model, one, probes, test) for one in named]
        known = [response for response in responses if response is not None]
        if len(known) < len(named):
            continue
        for words, own in choices:
            apart = min(_difference(one[:, own], other[:, own]) for one, other in combinations(known, 2))
            if best is None or apart > best[0]:
                best = apart, words
    if best is None or best[0] < max(AT_LEAST, 1.5 * now):
        return None
    return PipeTestProposal(best[1], best[0], now)


def tested(compared: Compared) -> Tested:
    """Give the range that was measured: of the sines, where there are any, else of the records."""
    if compared.sines:
        steady = compared.sines.measurement.steady
        own = np.isnan(steady.temperature)
        return Tested(
            "Measure", compared.description, float(steady.frequency.min()), float(steady.frequency.max()),
            float(steady.level.min()), float(steady.level.max()), steady.drive_unit,
            None if own.any() else float(steady.temperature[0]),
        )  # fmt: skip
    assert compared.records
    records = [pair.record for pair in compared.records.pairs]
    levels = [math.sqrt(2 * float(np.mean(record.drive**2))) / DRIVES[record.drive_unit].scale for record in records]
    edges = compared.records.edges.tolist()
    return Tested(
        "Measure sines", compared.description, edges[0], edges[-1], min(levels), max(levels), records[0].drive_unit,
        records[0].temperature,
    )  # fmt: skip


def _difference_now(one: Candidate, other: Candidate) -> float:
    """Give by how much two models differ at what was measured."""
    first, second = one.refit.computed, other.refit.computed
    found = [
        _difference(mine.computed, theirs.computed) for mine, theirs in zip(first.records, second.records, strict=True)
    ]
    if first.sines and second.sines:
        found.append(_difference(first.sines.response, second.sines.response))
    return max(found)


def _difference(one: Array | ComplexArray, other: Array | ComplexArray) -> float:
    known = np.isfinite(one) & np.isfinite(other)
    if not known.any():
        return 0.0
    size = np.sqrt(np.mean(np.abs(np.where(known, one, 0.0)) ** 2, axis=0))
    off = np.sqrt(np.mean(np.abs(np.where(known, one - other, 0.0)) ** 2, axis=0))
    return float(np.max(off / np.where(size > 0, size, np.inf)))


def _response(
    model: CoupledModel, candidate: Candidate, probes: tuple[Place, ...], test: PipeMeasurement
) -> ComplexArray | None:
    """Give what a refitted model's probes would show in a test; None where it has no steady states there."""
    described = replace(model, pipe=model.pipe.model_copy(update={"probes": probes}))
    refitted = changed(described, candidate.suspects, candidate.refit.values)
    try:
        response = predict(refitted, test).response
    except (UserError, np.linalg.LinAlgError):
        return None
    return response if np.isfinite(response).all() else None


def _tests(
    so_far: Tested, model: CoupledModel
) -> Iterator[tuple[list[tuple[str, slice]], tuple[Place, ...], PipeMeasurement]]:
    """Give tests that could be made: each in words with the probes that count for it; all probes, and the sines.

    Places for a further probe are choices of one series of sines, whose response is followed once for all of them.
    """
    pipe, low, high, verb = model.pipe, so_far.low, so_far.high, so_far.verb
    unit = DRIVES[so_far.drive_unit].unit
    for level in (LOUDER[0] * so_far.quietest, LOUDER[1] * so_far.loudest):
        words = f"{verb} at {level:.3g} {unit}, {low:.3g} to {high:.3g} Hz"
        yield [(words, slice(None))], pipe.probes, _sines(so_far, low, high, level)
    above = min(FREQUENCY_WIDENING * high, pipe.modes.up_to_Hz)
    for begin, end in ((low / FREQUENCY_WIDENING, low), (high, above)):
        if end > begin:
            words = f"{verb} from {begin:.3g} to {end:.3g} Hz at {so_far.loudest:.3g} {unit}"
            yield [(words, slice(None))], pipe.probes, _sines(so_far, begin, end, so_far.loudest)
    length = pipe.pipe.length_m
    positions = [
        position
        for position in (length * number / (PROBE_POSITIONS + 1) for number in range(1, PROBE_POSITIONS + 1))
        if all(abs(position - probe.position_m) > length / (2 * PROBE_POSITIONS) for probe in pipe.probes)
    ]
    if positions:
        places = tuple(Place(name=f"further{index}", position_m=position) for index, position in enumerate(positions))
        probes = tuple(ProbeTable(name=place.name, position_m=place.position_m, unit="mm") for place in places)
        description = so_far.description.model_copy(update={"probes": probes})
        choices = [
            (f"{verb} with a probe at {position:.3g} m as well", slice(index, index + 1))
            for index, position in enumerate(positions)
        ]
        yield choices, places, _sines(so_far, low, high, so_far.loudest, description)


def _sines(
    so_far: Tested, low: float, high: float, level: float, description: MeasurementDescription | None = None
) -> PipeMeasurement:
    """Give a test of sines at one level, in the measured unit."""
    description = description or so_far.description
    frequency, levels = np.linspace(low, high, SINES), np.full(SINES, level)
    drive = DRIVES[so_far.drive_unit].scale * levels
    if so_far.drive_unit == "displacement_mm":
        drive = drive * (2 * np.pi * frequency) ** 2
    shape = SINES, len(description.probes)
    return PipeMeasurement(
        description,
        SteadyMeasurement(
            frequency=frequency,
            drive=drive,
            level=levels,
            drive_unit=so_far.drive_unit,
            temperature=np.full(SINES, np.nan if so_far.temperature is None else so_far.temperature),
            sweep=np.zeros(SINES, dtype=np.intp),
            source=("",) * SINES,
            response=np.zeros(shape, dtype=np.complex128),
            phased=np.ones(shape, dtype=np.bool_),
            scatter=np.full(shape, np.nan),
        ),
    )
