"""The page of a law: its equations, parameters and surfaces."""

from __future__ import annotations

import itertools
import re

import numpy as np
import plotly.graph_objects as go

from pipeclamp.pages.page import Section
from pipeclamp.pages.pictures import curves_picture, surface_picture
from pipeclamp.show.law import coefficient_table, doubts
from pipeclamp_identification.comparison.in_the_middle import middle_of_range
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.signals import REFERENCES, signal_in_range
from pipeclamp_models.base.units import CELSIUS, unit_shown
from pipeclamp_models.equations.symbols import FIXED, SLOW
from pipeclamp_models.law.file import LawFile, law_of
from pipeclamp_models.law.law import Law
from pipeclamp_models.realise.arrays import realise
from pipeclamp_models.realise.reading.text import equation_lines, law_statements

POINTS_PER_AXIS = 40
FLAT = 1e-3
"""Over a condition by which a coefficient changes by less than this share of itself nothing is drawn."""


def law_sections(file: LawFile) -> list[Section]:
    """Give the part of a page that shows a law: its equations, parameters and surfaces."""
    law = law_of(file)
    return [
        Section("Law", _fixed_words(law), formulas=law_statements(law.equations.composed)),
        Section("Parameters", doubts(file), [coefficient_table(file)]),
        Section("Surfaces", (), (), surface_pictures(law, file)),
    ]


def _fixed_words(law: Law) -> list[str]:
    """Say what stands in the equations beside parameters: reference values, and what rounds kinks off."""
    values = {
        **{name: f"{value:g}" for name, value in REFERENCES.items()},
        "v_r": f"{law.v_r:.3g}",
        "y_r": f"{law.y_r:.3g}",
    }
    lines = " ".join(equation_lines(law.equations.composed))
    there = [one for one in FIXED if re.search(rf"\b{one.symbol}\b", lines)]
    told = [
        f"{one.symbol} = {values[str(one.symbol)]} {unit_shown(one.unit)} ({one.meaning.split(',')[0]})"
        for one in there
    ]
    return [f"Here {', '.join(told)}."] if told else []


def surface_pictures(law: Law, file: LawFile) -> list[go.Figure]:
    """Draw each coefficient over each pair of conditions it varies with, the others at the middle of the range."""
    equations = law.equations
    compiled = realise(equations)
    own = {str(signal.symbol) for signal in SLOW}
    # a further column has a signal of another name
    columns = {signal_in_range(name): name for name in file.range}
    known = {name: file.range[columns[name]] for name in compiled.slow if name in columns}
    ranges = {
        name: np.linspace(interval.minimum, interval.maximum, POINTS_PER_AXIS)
        for name, interval in known.items()
        if interval.maximum > interval.minimum
    }
    unknown = {} if "T" in file.range else {"T": float(REFERENCES["T_0"])}
    middles = middle_of_range(file)
    middle = unknown | {name: middles[columns[name]] for name in known}
    values = [law.values[name] for name in equations.names]

    def level(index: int, along: dict[str, Array]) -> Array:
        shape = np.broadcast_shapes(*(entry.shape for entry in along.values()))
        slow = [along.get(name, np.asarray(middle[name])) for name in compiled.slow]
        return np.broadcast_to(compiled.coefficients(*slow, *values, law.v_r, law.y_r)[index], shape)

    figures = []
    for index, coefficient in enumerate(equations.composed.coefficients):
        free = {str(symbol) for symbol in coefficient.expression.free_symbols}
        # a further condition is a coefficient of its own: over itself it says nothing
        follows = [name for name in ranges if name in free and not coefficient.expression.is_Symbol]
        varied = [name for name in follows if not _is_flat(level(index, {name: ranges[name]}))]
        label = f"{coefficient.symbol} / {unit_shown(coefficient.unit)}"
        shown = {name: _shown(name, known[name].unit) if name in own else columns[name] for name in varied}
        drawn = {name: ranges[name] - CELSIUS if name == "T" else ranges[name] for name in varied}
        for x, y in itertools.combinations(varied, 2):
            surface = level(index, {x: ranges[x][None, :], y: ranges[y][:, None]})
            title = f"{coefficient.symbol}({x}, {y})"
            figures.append(surface_picture(shown[x], shown[y], drawn[x], drawn[y], surface, label, title))
        if len(varied) == 1:
            (x,) = varied
            curve = (str(coefficient.symbol), drawn[x].tolist(), level(index, {x: ranges[x]}).tolist(), "lines")
            figures.append(curves_picture(shown[x], label, [curve], f"{coefficient.symbol}({x})"))
    return figures


def _shown(name: str, unit: str) -> str:
    """Give what stands at an axis: temperatures as tests state them, though the law's equations are in K."""
    return f"{name} / {'°C' if name == 'T' else unit_shown(unit)}"


def _is_flat(values: Array) -> bool:
    return bool(np.ptp(values) <= FLAT * np.max(np.abs(values)))
