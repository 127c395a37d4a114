"""The report of an identification: the law, its parameters, surfaces and loops."""

from __future__ import annotations

import itertools

import numpy as np
import plotly.graph_objects as go

from pipeclamp.law import Law, compose
from pipeclamp.parameter_file import FitQuality, LawFile
from pipeclamp.realise.arrays import Array, realise
from pipeclamp.realise.text import equation_lines
from pipeclamp.symbols import REFERENCES, T_0
from pipeclamp_identification.compare import Comparison
from pipeclamp_identification.comparison_report import SINGLE_CYCLES, comparison_sections
from pipeclamp_identification.metric_law import METHOD
from pipeclamp_identification.pictures import curves_picture, surface_picture
from pipeclamp_identification.report import Section, Table

POINTS = 40


def coefficient_table(file: LawFile) -> Table:
    """Give the parameters with unit, standard error and how they came about."""
    rows = [
        (name, entry.value, entry.standard_error, entry.unit, entry.state, entry.reason or entry.meaning)
        for name, entry in file.coefficients.items()
    ]
    return Table(("parameter", "value", "standard error", "unit", "state", "meaning"), rows, f"Law {file.name}")


def fit_words(fit: FitQuality) -> str:
    """Say how well a law fits its data."""
    if fit.method == METHOD:
        return f"error {fit.nrmse:.2%} in dW and W (rms of log ratios)"
    scatter = f" (scatter {fit.noise_nrmse:.2%})" if fit.noise_nrmse is not None else f"; {SINGLE_CYCLES}"
    return f"error {fit.nrmse:.2%} of the rms force{scatter}"


def doubts(file: LawFile) -> list[str]:
    """Say what of a law is less sure than its standard errors tell."""
    lines = [
        f"{entry.pair[0]} and {entry.pair[1]} can hardly be told apart (correlation {entry.value:.3f})."
        for entry in file.correlations
    ]
    if file.fit and file.fit.unsettled:
        lines.append(
            f"On {file.fit.unsettled} of the cycles that the law was fitted to, its memory doesn't become periodic: "
            "the force that was compared there is that of one repetition among others."
        )
    return lines


def identification_sections(file: LawFile, comparison: Comparison) -> list[Section]:
    """Give the report of an identification from its file and its comparison with the campaign."""
    return [*law_sections(comparison.law, file), *comparison_sections(comparison)]


def law_sections(law: Law, file: LawFile) -> list[Section]:
    """Give the part of a report that shows a law: its equations, parameters and surfaces."""
    return [
        Section("Law", equation_lines(compose(law.structure))),
        Section("Parameters", doubts(file), [coefficient_table(file)]),
        Section("Surfaces", (), (), surface_pictures(law, file)),
    ]


def surface_pictures(law: Law, file: LawFile) -> list[go.Figure]:
    """Draw each coefficient over each pair of conditions it depends on, the others at the middle of the range."""
    equations = compose(law.structure)
    compiled = realise(equations)
    ranges = {
        name: np.linspace(file.range[name].minimum, file.range[name].maximum, POINTS)
        for name in compiled.slow
        if name in file.range and file.range[name].maximum > file.range[name].minimum
    }
    unknown = {} if "T" in file.range else {"T": float(REFERENCES[T_0])}
    middle = unknown | {
        name: (file.range[name].minimum + file.range[name].maximum) / 2 for name in compiled.slow if name in file.range
    }
    values = [law.values[name] for name in equations.names]

    def level(index: int, along: dict[str, Array]) -> Array:
        shape = np.broadcast_shapes(*(entry.shape for entry in along.values()))
        slow = [along.get(name, np.asarray(middle[name])) for name in compiled.slow]
        return np.broadcast_to(compiled.coefficients(*slow, *values, law.v_r, law.y_r)[index], shape)

    figures = []
    for index, coefficient in enumerate(equations.coefficients):
        free = {str(symbol) for symbol in coefficient.expression.free_symbols}
        varied = [name for name in ranges if name in free]
        label = f"{coefficient.symbol} / {coefficient.unit}"
        axes = {name: f"{name} / {file.range[name].unit}" for name in varied}
        for x, y in itertools.combinations(varied, 2):
            surface = level(index, {x: ranges[x][None, :], y: ranges[y][:, None]})
            title = f"{coefficient.symbol}({x}, {y})"
            figures.append(surface_picture(axes[x], axes[y], ranges[x], ranges[y], surface, label, title))
        if len(varied) == 1:
            (x,) = varied
            curve = (str(coefficient.symbol), ranges[x].tolist(), level(index, {x: ranges[x]}).tolist(), "lines")
            figures.append(curves_picture(axes[x], label, [curve], f"{coefficient.symbol}({x})"))
    return figures
