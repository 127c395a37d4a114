"""The published tables as observations, and the way from the printed law to one that fits them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from importlib import resources
from io import BytesIO

import numpy as np
import numpy.typing as npt
import polars as pl

from pipeclamp.law import Law, Structure, compose, smoothing
from pipeclamp.parameter_file import CoefficientEntry, DataSource, Interval, LawFile
from pipeclamp.response import law_response, sinusoids
from pipeclamp_identification.fit import Fit, fit
from pipeclamp_identification.observations import MetricObservations

CELSIUS = 273.15
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
ROWS_ALIKE = 0.5
"""An effect rests on one row when leaving that row out takes away more than this share of what it gains."""


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
    Reading("published_R3", CELSIUS, -1, "temperature in degC, k1 falls with T (as the tables say)"),
    Reading("published_R4", CELSIUS, 1, "temperature in degC, k1 rises with T (as the words say)"),
)
"""What PUBLISHED_LAW.md leaves open, each combination by name; R1 errs least."""


def published_tables() -> pl.DataFrame:
    """Give Tables 2-5 of the paper as rows (specimen, conditions, eta, dW, W)."""
    content = resources.files("pipeclamp").joinpath("data", "published_tables.csv").read_bytes()
    return pl.read_csv(BytesIO(content)).filter(pl.col("dissipated_energy_J").is_not_null())


def emwm2_observations() -> MetricObservations:
    """Give the 11 distinct conditions of specimen EMWM2 as observations of dW and W."""
    table = (
        published_tables()
        .filter(pl.col("specimen") == "EMWM2")
        .unique(subset=["amplitude_mm", "frequency_Hz", "temperature_C"], maintain_order=True)
    )
    motion = sinusoids(
        table["amplitude_mm"].to_numpy(), table["frequency_Hz"].to_numpy(), table["temperature_C"].to_numpy() + CELSIUS
    )
    return MetricObservations(motion, table["dissipated_energy_J"].to_numpy(), table["max_elastic_energy_J"].to_numpy())


def metric_errors(observations: MetricObservations, law: Law) -> tuple[float, float, float]:
    """Give the rms of the log ratios measured/computed: of dW and W together, of dW, of W."""
    logs = observations.residual(law_response(law, observations.motion)) * observations.relative_error
    dissipated, elastic = np.sqrt(np.mean(logs**2, axis=0))
    return float(np.sqrt(np.mean(logs**2))), float(dissipated), float(elastic)


def reading_law(reading: Reading) -> Law:
    """Give the printed law in one of its readings."""
    structure = Structure("published")
    values = {parameter.name: float(parameter.starts[0]) for parameter in compose(structure).parameters}
    values |= {"T_zero": reading.zero, "p1_T": reading.sign * abs(values["p1_T"])}
    return Law(structure, values, *smoothing(RANGE["A"].minimum, RANGE["f"].minimum))


def reading_file(reading: Reading, software: str) -> LawFile:
    """Give the parameter file of a reading, with what it errs against the paper's own tables."""
    law = reading_law(reading)
    observations = emwm2_observations()
    _, dissipated, elastic = metric_errors(observations, law)
    return LawFile(
        schema="pipeclamp-law-1",
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
            for parameter in compose(law.structure).parameters
        },
        range=RANGE,
        data=DataSource(name=PAPER, fingerprint="none: printed coefficients", runs_used=0),
        software=software,
        command="python build_scripts/bundled_laws.py",
    )


@dataclass(frozen=True)
class Step:
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


# The printed c has no power of A (only the sine term that can't be recovered), so the refitted one has none either.
PRINTED_FORM = (("c_A", 0.0),)
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


def way() -> tuple[Step, ...]:
    """Go from the printed law to one that fits the tables, effect by effect."""
    observations = emwm2_observations()
    printed = reading_law(READINGS[0])
    steps = [
        Step(
            "as printed (reading R1)",
            printed,
            metric_errors(observations, printed),
            (),
            None,
        )
    ]
    for title, structure in WAY:
        result = fit(structure, observations)
        rests_on = _single_rows(result, observations) if structure.effects else ()
        steps.append(Step(title, result.law, metric_errors(observations, result.law), rests_on, result))
    return tuple(steps)


def _single_rows(result: Fit, observations: MetricObservations) -> tuple[tuple[float, float, float], ...]:
    """Give the conditions without any one of which the last effect of a law gains little."""
    structure = result.law.structure
    without = replace(structure, effects=structure.effects[:-1])

    def gain(rows: npt.NDArray[np.intp]) -> float:
        part = observations.rows(rows)
        plain = fit(without, part, start=result.law.values)
        return plain.cost - fit(structure, part, start=result.law.values).cost

    everything = np.arange(len(observations.dissipated_energy))
    whole = gain(everything)
    slow = observations.motion.slow
    return tuple(
        (float(slow["A"][row, 0]), float(slow["f"][row, 0]), float(slow["T"][row, 0] - CELSIUS))
        for row in everything
        if gain(np.delete(everything, row)) < ROWS_ALIKE * whole
    )
