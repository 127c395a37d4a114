"""The published tables as observations, and the way from the printed law to one that fits them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_identification.fitting.identify import coefficient_entries
from pipeclamp_identification.fitting.joint.fitted import Fit
from pipeclamp_identification.fitting.least_squares import fit
from pipeclamp_identification.loops.published_rows import published_rows
from pipeclamp_identification.metrics_only.evidence import single_rows
from pipeclamp_identification.metrics_only.observations import METRICS, MetricObservations
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.file import SCHEMA, CoefficientEntry, DataSource, Interval, LawFile
from pipeclamp_models.law.law import Law, Structure, smoothing
from pipeclamp_models.law.range import rounded
from pipeclamp_models.realise.force import force_of_law
from pipeclamp_models.realise.motion import sinusoids

MADE_BY = "python build_scripts/bundled_laws.py"
PAPER = "Jiang, Ding, Wu, Bai, Shao, Zi, Symmetry 2020, 12(8), 1283, doi 10.3390/sym12081283"
FIGURE_14 = (
    (0.2, 2.0, 20.0), (0.2, 3.0, 20.0), (0.5, 4.0, 20.0), (0.5, 3.0, 100.0),
    (0.5, 3.0, 200.0), (0.5, 3.0, 300.0), (0.8, 3.0, 20.0), (1.0, 5.0, 20.0),
)  # fmt: skip
"""Conditions (A mm, f Hz, T degC) of the paper's Fig. 14."""

RANGE = {
    "A": Interval(minimum=0.2, maximum=1.0, unit="mm"),
    "f": Interval(minimum=1.0, maximum=5.0, unit="Hz"),
    "T": Interval(minimum=293.15, maximum=573.15, unit="K"),
}
RELATIVE_ERROR = 0.01


@dataclass(frozen=True)
class Reading:
    """One reading of the printed coefficients: scale of the temperature and sign of its exponent in k1."""

    name: str
    zero: float
    sign: int
    notes: str


READINGS = (
    Reading("published_R1", 0.0, -1, "temperature in kelvin, k1 falls with T (as the tables say)"),
    Reading("published_R2", 0.0, 1, "temperature in kelvin, k1 rises with T (as the words say)"),
    Reading("published_R3", CELSIUS, -1, "temperature in °C, k1 falls with T (as the tables say)"),
    Reading("published_R4", CELSIUS, 1, "temperature in °C, k1 rises with T (as the words say)"),
)
"""What the printed law leaves open, each combination by name; R1 errs least."""


def emwm2_observations() -> MetricObservations:
    """Give the 11 distinct conditions of specimen EMWM2 as observations of dW and W."""
    distinct = {
        (row.amplitude_mm, row.frequency_Hz, row.temperature_C): row
        for row in published_rows()
        if row.specimen == "EMWM2"
    }
    A, f, T = np.array(list(distinct)).T
    rows = list(distinct.values())
    return MetricObservations(
        sinusoids(A, f, T + CELSIUS),
        np.array([row.dissipated_energy_J for row in rows]),
        np.array([row.max_elastic_energy_J for row in rows]),
        np.full((len(rows), len(METRICS)), RELATIVE_ERROR),
        np.zeros((len(rows), len(METRICS))),
    )


def metric_errors(observations: MetricObservations, law: Law) -> tuple[float, float, float]:
    """Give the rms of the log ratios measured/computed: of dW and W together, of dW, of W."""
    logs = observations.logs(force_of_law(law, observations.motion).force)
    dissipated, elastic = np.sqrt(np.mean(logs**2, axis=0))
    return float(np.sqrt(np.mean(logs**2))), float(dissipated), float(elastic)


def reading_law(reading: Reading) -> Law:
    """Give the printed law in one of its readings."""
    structure = Structure("published")
    values = {parameter.name: float(parameter.starts[0]) for parameter in structure.equations.parameters}
    values |= {"T_zero": reading.zero, "p1_T": reading.sign * abs(values["p1_T"])}
    return Law(structure, values, *smoothing(RANGE["A"].minimum, RANGE["f"].minimum))


def reading_file(reading: Reading, software: str) -> LawFile:
    """Give the parameter file of a reading, with what it errs against the paper's own tables."""
    law = reading_law(reading)
    observations = emwm2_observations()
    _, dissipated, elastic = metric_errors(observations, law)
    return LawFile(
        schema=SCHEMA,
        name=reading.name,
        notes=f"The published law, read with {reading.notes}; without the sine term of c, which can't be recovered. "
        f"Against the paper's own Tables 2, 3, 5 it errs by {elastic:.1%} in W and {dissipated:.1%} in dW "
        "(rms of log ratios over 11 conditions).",
        base="published",
        smoothing={"v_r": law.v_r, "y_r": law.y_r},
        coefficients={
            parameter.name: CoefficientEntry(
                value=law.values[parameter.name], unit=parameter.unit, state="given", meaning=parameter.meaning
            )
            for parameter in law.equations.parameters
        },
        range=RANGE,
        data=DataSource(name=PAPER, fingerprint="none: printed coefficients", runs_used=0),
        software=software,
        command=MADE_BY,
    )


@dataclass(frozen=True)
class PublishedStep:
    """One step of the way.

    Attributes:
        title: what the law is now.
        law: the law.
        errors: rms log ratio of dW and W together, of dW, of W.
        rests_on: conditions (A mm, f Hz, T degC) without which what the step gained would be gone.
        fit: the fit; None for the printed law.
    """

    title: str
    law: Law
    errors: tuple[float, float, float]
    rests_on: tuple[tuple[float, float, float], ...]
    fit: Fit | None


PRINTED_FORM = (("c_A", 0.0),)
"""The printed c has no power of A (only the sine term that can't be recovered), so the refitted one has none
either."""
WITHOUT_T_POWERS = (*PRINTED_FORM, ("k1_T", 0.0), ("k3_T", 0.0))
WAY = (
    ("refitted", Structure("power", frozen=PRINTED_FORM)),
    ("+ damping_temperature", Structure("power", ("damping_temperature",), PRINTED_FORM)),
    (
        "+ contact_growth, in place of the powers of T",
        Structure("power", ("damping_temperature", "contact_growth"), WITHOUT_T_POWERS),
    ),
    (
        "+ stiffness_frequency",
        Structure("power", ("damping_temperature", "contact_growth", "stiffness_frequency"), WITHOUT_T_POWERS),
    ),
)


def way() -> tuple[PublishedStep, ...]:
    """Go from the printed law to one that fits the tables, effect by effect."""
    observations = emwm2_observations()
    printed = reading_law(READINGS[0])
    steps = [
        PublishedStep(
            "as printed (reading R1)",
            printed,
            metric_errors(observations, printed),
            (),
            None,
        )
    ]
    for title, structure in WAY:
        result = fit(structure, observations)
        rests_on = _single_conditions(result, observations) if structure.effects else ()
        steps.append(PublishedStep(title, result.law, metric_errors(observations, result.law), rests_on, result))
    return tuple(steps)


def _single_conditions(result: Fit, observations: MetricObservations) -> tuple[tuple[float, float, float], ...]:
    """Give the conditions without any one of which the last effect of a law gains little."""
    structure = result.law.structure
    slow = observations.motion.slow
    return tuple(
        (float(slow["A"][row, 0]), float(slow["f"][row, 0]), float(slow["T"][row, 0] - CELSIUS))
        for row in single_rows(result, replace(structure, effects=structure.effects[:-1]), observations)
    )


def emwm2_file(software: str) -> LawFile:
    """Give the parameter file of the law that fits the tables: the last step of the way."""
    last = way()[-1]
    assert last.fit is not None
    return LawFile(
        schema=SCHEMA,
        name="emwm2",
        notes="Fitted to dW and W of Tables 2, 3, 5 (specimen EMWM2, 11 conditions); "
        f"rms log ratio {last.errors[0]:.2%}. "
        "contact_growth rests on the one row at 300 °C.",
        base=last.law.structure.base,
        effects=last.law.structure.effects,
        smoothing={"v_r": rounded(last.law.v_r), "y_r": rounded(last.law.y_r)},
        coefficients=coefficient_entries(last.fit),
        range=RANGE,
        data=DataSource(name=PAPER, fingerprint="none: printed tables", runs_used=11),
        software=software,
        command=MADE_BY,
    )


def bundled_files(software: str) -> tuple[LawFile, ...]:
    """Give every law file that comes with the program, made anew."""
    return (*(reading_file(reading, software) for reading in READINGS), emwm2_file(software))
