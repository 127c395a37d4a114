"""A law's file as the clamp's FMU takes it."""

from __future__ import annotations

from pipeclamp_fmu.contents.clamp_model import USUAL, ClampModel, ClampStart, Entry, FurtherCondition
from pipeclamp_fmu.slaves.clamp import MM, within
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.signals import CONDITION
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.equations import symbols
from pipeclamp_models.law.file import Interval, LawFile, law_of
from pipeclamp_models.realise.reading.text import equation_lines
from pipeclamp_models.realise.scalar_law import parameter_values, source_of
from pipeclamp_models.realise.stepping import (
    CONDITIONS_FIRST,
    conditions_of,
    parameter_symbols,
)

FIRST_CYCLE = "firstCycle"
"""The clamp FMU's parameter for load cycles that it has seen."""

G_CM3 = 1e-3
"""1 kg/m3 in g/cm3."""

SMOOTHING = {
    "v_r": ("mm/s", "velocity below which sgn v is smooth"),
    "y_r": ("mm", "displacement below which sgn y is smooth"),
}


def clamp_model(file: LawFile, start: ClampStart = USUAL) -> ClampModel:
    """Give a law as the clamp FMU needs it.

    Args:
        file: the law.
        start: what the FMU starts with.

    Raises:
        UserError: the law's range lacks a condition that the law depends on, or what it is told to start with.
    """
    _require_in_range(file, start)
    law = law_of(file)
    equations = law.structure.equations_without_rig
    described = {entry.name: (entry.unit, entry.meaning) for entry in equations.parameters} | SMOOTHING
    names = [str(symbol) for symbol in parameter_symbols(equations.composed)]
    entries = [(name, file.coefficients[name]) for name in equations.names]
    return ClampModel(
        name=file.name,
        source=source_of(law.structure),
        coefficients=tuple(
            Entry(name, *described[name], value) for name, value in zip(names, parameter_values(law), strict=True)
        ),
        range_A=_ends(file.range["A"]),
        range_f=_ends(file.range["f"]),
        range_T=_ends(file.range["T"]) if "T" in file.range else None,
        further=tuple(_further(name, file) for name in conditions_of(equations)[len(CONDITIONS_FIRST) :]),
        equations=equation_lines(equations.composed),
        parameters=[
            (
                name,
                f"{entry.value:.6g}",
                entry.state if entry.standard_error is None else f"{entry.standard_error:.2g}",
                entry.unit,
                entry.meaning,
            )
            for name, entry in entries
        ],
        notes=_notes(file),
        history=file.history,
        fit=file.fit,
        start=start,
        about=file.about,
    )


def condition_parameter(column: str, value: float) -> tuple[str, float]:
    """Give the clamp FMU's parameter for a column of runs.csv, and its value there."""
    return _parameter_name(column), value / G_CM3 if column == "density_g_cm3" else value


def _parameter_name(column: str) -> str:
    """Give the name of the clamp FMU's parameter for a column of runs.csv."""
    own = {"density_g_cm3": str(symbols.rho), "first_cycle": FIRST_CYCLE}
    return own.get(column, f"condition.{str(symbols.condition_symbol(column)).removeprefix(CONDITION)}")


def _require_in_range(file: LawFile, start: ClampStart) -> None:
    """Refuse start values that the law's data don't hold.

    Raises:
        UserError: one of them.
    """
    for name, meaning, value, zero, unit in (
        ("A", "amplitude", start.A and MM * start.A, 0.0, "mm"),
        ("f", "frequency", start.f, 0.0, "Hz"),
        ("T", "temperature", start.T, CELSIUS, "°C"),
    ):
        known = file.range.get(name)
        if value is None or known is None or within(value, (known.minimum, known.maximum)):
            continue
        low, high, got = (entry - zero for entry in (known.minimum, known.maximum, value))
        raise UserError(
            f"law {file.name!r}: the FMU would start with {meaning} {name} = {got:g} {unit}; expected {low:g} to "
            f"{high:g} {unit}, where the law's data lie: give another {meaning}, or a law from tests that hold it"
        )


def _further(name: str, file: LawFile) -> FurtherCondition:
    """Give a slow signal besides A, f and T as a parameter: load cycles, density, or a column of the test table."""
    columns = {str(symbols.condition_symbol(column)): column for column in file.range}
    key = columns.get(name, name)
    if key not in file.range:
        raise UserError(
            f"law {file.name!r} depends on {name.removeprefix(CONDITION)}, but its range doesn't hold it; "
            "expected a law identified from tests that state it: identify it anew"
        )
    interval = _ends(file.range[key])
    if name == str(symbols.N):
        return FurtherCondition(
            name=FIRST_CYCLE,
            meaning="load cycles that the clamp has seen before the start",
            unit="1",
            display_unit="",
            law_unit="cycles",
            scale=1.0,
            interval=(0.0, interval[1]),
            positive=False,
            start=0.0,
            counted=True,
        )
    if name == str(symbols.rho):
        return FurtherCondition(
            name=name,
            meaning="density of the wire mesh",
            unit="kg/m3",
            display_unit="g/cm3",
            law_unit="g/cm3",
            scale=G_CM3,
            interval=interval,
            positive=True,
            start=(interval[0] + interval[1]) / 2 / G_CM3,
        )
    return FurtherCondition(
        name=_parameter_name(key),
        meaning=f"test condition {key}, in the unit of its name",
        unit="",
        display_unit="",
        law_unit="",
        scale=1.0,
        interval=interval,
        positive=False,
        start=sum(interval) / 2,
    )


def _ends(interval: Interval) -> tuple[float, float]:
    return (interval.minimum, interval.maximum)


def _notes(file: LawFile) -> list[str]:
    notes = [file.notes] if file.notes else []
    effects = f" with {', '.join(file.effects)}" if file.effects else ""
    notes.append(f"Base law {file.base}{effects}; data: {file.data.name} ({file.data.fingerprint}).")
    smoothing = f"sgn v is smooth below v_r = {file.smoothing['v_r']:.3g} mm/s"
    notes.append(f"{smoothing}, sgn y below y_r = {file.smoothing['y_r']:.3g} mm.")
    if file.data.time_measured is False:
        notes.append("The time of its tests was not measured: of speed and frequency it says nothing.")
    if about := file.data.about_mm:
        notes.append(f"Its tests moved about {about:.3g} mm, and y counts as their displacement did.")
    return notes
