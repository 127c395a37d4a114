"""The report of an identification: the law, its parameters, surfaces and loops."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go

from pipeclamp.law import Law, compose
from pipeclamp.parameter_file import LawFile
from pipeclamp.realise.arrays import realise
from pipeclamp.realise.text import equation_lines
from pipeclamp_identification.campaign import Campaign
from pipeclamp_identification.compare import Comparison, comparison_sections
from pipeclamp_identification.identify import Identification
from pipeclamp_identification.pictures import curves_picture, waterfall_picture
from pipeclamp_identification.report import Section, Table

POINTS = 60


def coefficient_table(file: LawFile) -> Table:
    """Give the parameters with unit, standard error and how they came about."""
    rows = [
        (name, entry.value, entry.standard_error, entry.unit, entry.state, entry.reason or entry.meaning)
        for name, entry in file.coefficients.items()
    ]
    return Table(("parameter", "value", "standard error", "unit", "state", "meaning"), rows, f"Law {file.name}")


def identification_sections(file: LawFile, identification: Identification, campaign: Campaign) -> list[Section]:
    """Give the report of an identification."""
    law = identification.fit.law
    comparison = Comparison(law, campaign, identification.loops, identification.misfits, {})
    correlations = [
        f"{entry.pair[0]} and {entry.pair[1]} can hardly be told apart (correlation {entry.value:.3f})."
        for entry in file.correlations
    ]
    steps = [(step.step, step.nrmse) for step in file.history]
    noise = file.fit.noise_nrmse if file.fit else None
    return [
        Section("Law", equation_lines(law.structure)),
        Section("Parameters", correlations, [coefficient_table(file)]),
        Section("Surfaces", (), (), surface_pictures(law, file)),
        Section("Error, step by step", (), (), [waterfall_picture(steps, noise, "error", "Error after each step")]),
        *comparison_sections(comparison),
    ]


def surface_pictures(law: Law, file: LawFile) -> list[go.Figure]:
    """Draw each coefficient over the conditions it depends on, the others at the middle of the law's range."""
    equations = compose(law.structure)
    compiled = realise(equations)
    ranges = {name: (file.range[name].minimum, file.range[name].maximum) for name in compiled.slow if name in file.range}
    middle = {name: (low + high) / 2 for name, (low, high) in ranges.items()}
    values = [law.values[name] for name in equations.names]
    figures = []
    for index, coefficient in enumerate(equations.coefficients):
        free = {str(symbol) for symbol in coefficient.expression.free_symbols}
        curves = []
        for name, (low, high) in ranges.items():
            if name not in free or high <= low:
                continue
            along = np.linspace(low, high, POINTS)
            slow = [along if other == name else np.full(POINTS, middle[other]) for other in compiled.slow]
            level = np.broadcast_to(compiled.coefficients(*slow, *values, law.v_r, law.y_r)[index], along.shape)
            share = (along - low) / (high - low)
            curves.append((f"{name} from {low:.4g} to {high:.4g} {file.range[name].unit}", share, level, "lines"))
        if curves:
            title = f"{coefficient.symbol} over its conditions, the others at mid range"
            figures.append(
                curves_picture("place in the range, 0 to 1", f"{coefficient.symbol} / {coefficient.unit}", curves, title)
            )
    return figures
