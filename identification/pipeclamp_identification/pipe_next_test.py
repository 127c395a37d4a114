"""Which further test would tell apart what these measurements can't: where the refitted models differ most."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from pipeclamp.errors import UserError
from pipeclamp.pipe_description import Place
from pipeclamp_identification.measured_table import DRIVES
from pipeclamp_identification.pipe_attribution import Attribution, Candidate
from pipeclamp_identification.pipe_measurement import (
    MeasurementDescription,
    PipeMeasurement,
    ProbeTable,
    SteadyMeasurement,
)
from pipeclamp_identification.pipe_model import CoupledModel, predict
from pipeclamp_identification.pipe_refit import changed

Array = NDArray[np.float64]

SINES = 12
"""Of a proposed series."""
LOUDER = (0.25, 4.0)
"""Times the levels that were measured."""
WIDER = 2.0
"""Times the highest frequency that was measured, and its inverse for the lowest."""
PLACES = 7
"""Positions along the pipe at which another probe is tried."""
AT_LEAST = 0.02
"""Difference of two models, as a share of the response's rms, below which a test tells nothing."""


@dataclass(frozen=True)
class Proposal:
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


def propose(attribution: Attribution) -> Proposal | None:
    """Propose the test at which the named candidates differ most; None where none is found that tells more."""
    named = attribution.named[:3]
    if len(named) < 2:
        return None
    measurement, model = attribution.task.measurement, attribution.task.model
    now = min(
        _difference(one.refit.prediction.response, other.refit.prediction.response)
        for one, other in combinations(named, 2)
    )
    best: tuple[float, str] | None = None
    for words, probes, test in _tests(measurement, model):
        responses = [_response(model, one, probes, test) for one in named]
        known = [response for response in responses if response is not None]
        if len(known) < len(named):
            continue
        apart = min(_difference(one, other) for one, other in combinations(known, 2))
        if best is None or apart > best[0]:
            best = apart, words
    if best is None or best[0] < max(AT_LEAST, 1.5 * now):
        return None
    return Proposal(best[1], best[0], now)


def _difference(one: NDArray[np.complex128], other: NDArray[np.complex128]) -> float:
    known = np.isfinite(one) & np.isfinite(other)
    if not known.any():
        return 0.0
    size = np.sqrt(np.mean(np.abs(np.where(known, one, 0.0)) ** 2, axis=0))
    off = np.sqrt(np.mean(np.abs(np.where(known, one - other, 0.0)) ** 2, axis=0))
    return float(np.max(off / np.where(size > 0, size, np.inf)))


def _response(
    model: CoupledModel, candidate: Candidate, probes: tuple[Place, ...], test: PipeMeasurement
) -> NDArray[np.complex128] | None:
    """Give what a refitted model's probes would show in a test; None where it has no steady states there."""
    described = replace(model, pipe=model.pipe.model_copy(update={"probes": probes}))
    refitted = changed(described, candidate.suspects, candidate.refit.values)
    try:
        response = predict(refitted, test).response
    except (UserError, np.linalg.LinAlgError):
        return None
    return response if np.isfinite(response).all() else None


def _tests(
    measurement: PipeMeasurement, model: CoupledModel
) -> Iterator[tuple[str, tuple[Place, ...], PipeMeasurement]]:
    """Give tests that could be made: in words, the probes, the sines."""
    steady, pipe = measurement.steady, model.pipe
    low, high = float(steady.frequency.min()), float(steady.frequency.max())
    levels = sorted({float(steady.level.min()), float(steady.level.max())})
    unit = DRIVES[steady.drive_unit].unit
    for level in (LOUDER[0] * levels[0], LOUDER[1] * levels[-1]):
        words = f"Measure at {level:.3g} {unit}, {low:.3g} to {high:.3g} Hz"
        yield words, pipe.probes, _sines(measurement, low, high, level)
    above = min(WIDER * high, pipe.modes.up_to_Hz)
    for begin, end in ((low / WIDER, low), (high, above)):
        if end > begin:
            words = f"Measure from {begin:.3g} to {end:.3g} Hz at {levels[-1]:.3g} {unit}"
            yield words, pipe.probes, _sines(measurement, begin, end, levels[-1])
    for number in range(1, PLACES + 1):
        position = pipe.pipe.length_m * number / (PLACES + 1)
        if all(abs(position - probe.position_m) > pipe.pipe.length_m / (2 * PLACES) for probe in pipe.probes):
            probe = ProbeTable(name="further", position_m=position, unit="mm")
            description = measurement.description.model_copy(update={"probes": (probe,)})
            test = _sines(measurement, low, high, levels[-1], description)
            place = Place(name="further", position_m=position)
            yield f"Measure with a probe at {position:.3g} m as well", (place,), test


def _sines(
    measurement: PipeMeasurement,
    low: float,
    high: float,
    level: float,
    description: MeasurementDescription | None = None,
) -> PipeMeasurement:
    """Give a test of sines at one level, in the measured unit."""
    description = description or measurement.description
    frequency, levels = np.linspace(low, high, SINES), np.full(SINES, level)
    kind = measurement.steady.drive_unit
    drive = DRIVES[kind].scale * levels
    if kind == "displacement_mm":
        drive = drive * (2 * np.pi * frequency) ** 2
    shape = SINES, len(description.probes)
    own = np.isnan(measurement.steady.temperature)
    temperature = np.full(SINES, np.nan if own.any() else measurement.steady.temperature[0])
    return PipeMeasurement(
        description,
        SteadyMeasurement(
            frequency=frequency,
            drive=drive,
            level=levels,
            drive_unit=kind,
            temperature=temperature,
            sweep=np.zeros(SINES, dtype=np.intp),
            source=("",) * SINES,
            response=np.zeros(shape, dtype=np.complex128),
            phased=np.ones(shape, dtype=np.bool_),
            scatter=np.full(shape, np.nan),
        ),
    )
