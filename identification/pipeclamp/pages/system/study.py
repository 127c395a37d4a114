"""The report of a study: the vibration level over what was varied."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go

from pipeclamp.pages.page import Report, Section, doubted
from pipeclamp.pages.pictures import cells_picture, curves_picture
from pipeclamp.pages.system.bands import FAINT, add_area
from pipeclamp.show.table import Table
from pipeclamp_identification.comparison.sentences import sentence
from pipeclamp_identification.workflow.next_step import NextStep
from pipeclamp_models.base.said import counted
from pipeclamp_models.base.tables import pl
from pipeclamp_system.description.trust_mark import doubt
from pipeclamp_system.study.case import HIGH, IN_RANGE, LOW, TRUSTED
from pipeclamp_system.study.description import Study

LEVEL = ".s [mm]"
"""How columns of displacement amplitudes end."""
UNIT_OF_ENDING = {
    "_kg_m2": "kg m²", "_kg_m3": "kg/m³", "_kg_m": "kg/m", "_m_s2": "m/s²", "_m_s": "m/s", "_N_mm": "N/mm",
    "_GPa": "GPa", "_bar": "bar", "_mm": "mm", "_kg": "kg", "_Hz": "Hz", "_C": "°C", "_N": "N", "_m": "m",
}  # fmt: skip
"""By the ends of a description's keys, longer ones first."""


def study_page(study: Study, frame: pl.DataFrame, following: NextStep) -> Report:
    """Give the page of a study."""
    description = study.description
    return Report(f"Study: {description.name}", description.notes, study_sections(study, frame, following))


def study_sections(study: Study, frame: pl.DataFrame, following: NextStep | None = None) -> list[Section]:
    """Give the report of a study; the first section holds the summary in words, and what comes next."""
    failed = frame.filter(pl.col("error") != "")
    fine = frame.filter(pl.col("error") == "")
    points = [name for name in frame.columns if name.endswith(LEVEL)]
    axes = list(study.description.axes)
    marks = _marks(fine, axes)
    what = [
        *([f"{failed.height} cases gave no result; the first: {failed['error'][0]}"] if failed.height else []),
        *_extremes_words(fine, points, axes),
        *_unstable_words(fine),
        *marks,
        *_range_words(fine),
        *_bands_words(study, fine, points),
    ]
    figures = [_picture(fine, axes, name) for name in points if fine.height and fine[name].max()]
    if marks:
        for figure in figures:
            doubted(figure)
    rows = [(row["case"], *(row[axis] for axis in axes), row["error"]) for row in failed.head(20).iter_rows(named=True)]
    tables = [Table(("case", *axes, "error"), rows, "cases without a result (the first 20)")] if rows else []
    note = "Over the first two of what is varied; the largest over the rest." if len(axes) > 1 else ""
    first, line = (following.before(), following.line) if following else ([], "")
    how = (
        f"study {study.description.name!r}: {frame.height} cases, {study.description.measure}; varied: "
        f"{', '.join(named(axis)[0] for axis in axes)}"
    )
    # what came out stands before how; names of places that begin a line stay as they are
    answer = Section("What came out", [*(f"{each}." for each in what), sentence(how), *first], command=line)
    return [answer, Section("Vibration level", (note,) if note else (), tables, figures)]


def _extremes_words(fine: pl.DataFrame, points: list[str], axes: list[str]) -> list[str]:
    """Say where each place moves least and most."""
    lines = []
    for name in points:
        known = fine.filter(pl.col(name).is_not_null())
        if not known.height:
            continue
        for word, order in (("least", False), ("most", True)):
            row = known.sort(name, descending=order).row(0, named=True)
            where = ", ".join(axis_setting(axis, row[axis]) for axis in axes)
            lines.append(f"{name.removesuffix(LEVEL)} moves {word} at {where}: {row[name]:.4g} mm")
    return lines


def _unstable_words(fine: pl.DataFrame) -> list[str]:
    """Say how many cases aren't stable, and how many nothing damps; nothing where that wasn't asked."""
    if "stable" not in fine.columns:
        return []
    unstable, undamped = fine.filter(pl.col("stable") == 0.0).height, fine["stable"].null_count()
    words = [f"not stable: {counted(unstable, 'case')}"] if unstable else []
    neither = f"neither stable nor unstable, as nothing damps it: {counted(undamped, 'case')}"
    return [*words, neither] if undamped else words


def _range_words(fine: pl.DataFrame) -> list[str]:
    """Say which clamps' laws are used beyond the range of their data."""
    lines = []
    for name in (column.removesuffix(IN_RANGE) for column in fine.columns if column.endswith(IN_RANGE)):
        inside = fine[f"{name}{IN_RANGE}"].drop_nulls()
        if not inside.all():
            lines.append(
                f"{name}: its law is used beyond the range of its data in {(~inside).sum()} of {inside.len()} cases"
            )
    return lines


def named(axis: str) -> tuple[str, str]:
    """Give what is varied in words, and its unit: "position of clamp1" and "m" of pipe.clamps.clamp1.position_m."""
    *place, key = axis.split(".")
    name, unit = next(
        ((key.removesuffix(end), unit) for end, unit in UNIT_OF_ENDING.items() if key.endswith(end)), (key, "")
    )
    whose = f"all {place[-2]}" if place[-1] == "*" else place[-1]
    return f"{name.replace('_', ' ')} of {whose}", unit


def axis_title(axis: str) -> str:
    """Give what is varied with its unit, as an axis has it."""
    return " / ".join(filter(None, named(axis)))


def axis_setting(axis: str, value: float) -> str:
    """Give a value of what is varied in words: "position of clamp1 4.5 m"."""
    name, unit = named(axis)
    return " ".join(filter(None, (name, f"{value:g}", unit)))


def _bands_words(study: Study, fine: pl.DataFrame, points: list[str]) -> list[str]:
    """Say where each amplitude's band is widest beside it."""
    lines = []
    for name in points:
        low, high = (name.removesuffix(LEVEL) + end for end in (LOW, HIGH))
        if low not in fine.columns:
            continue
        known = fine.filter(pl.col(low).is_not_null() & (pl.col(name) > 0))
        if known.height:
            widest = known.sort((pl.col(high) - pl.col(low)) / pl.col(name), descending=True).row(0, named=True)
            where = ", ".join(axis_setting(axis, widest[axis]) for axis in study.description.axes)
            lines.append(
                f"{name.removesuffix(LEVEL)} is least sure at {where}: {widest[name]:.4g} mm ({study.per_cent:g}%: "
                f"{widest[low]:.4g} to {widest[high]:.4g})"
            )
    return lines


def _marks(fine: pl.DataFrame, axes: list[str]) -> list[str]:
    """Say which co-simulated cases aren't to be trusted."""
    doubtful = fine.filter(~pl.col(TRUSTED)) if TRUSTED in fine.columns else fine.clear()
    if not doubtful.height:
        return []
    first = doubtful.row(0, named=True)
    where = ", ".join(axis_setting(axis, first[axis]) for axis in axes)
    return [
        doubt(
            f"{doubtful.height} of {fine.height} cases, column {TRUSTED!r} says which; the first, at {where}: "
            f"{first['doubts']}; use a smaller step_s"
        )
    ]


def _picture(frame: pl.DataFrame, axes: list[str], name: str) -> go.Figure:
    """Draw a level over the first two axes, or over the only one."""
    title = f"{name.removesuffix(LEVEL)}: amplitude"
    if len(axes) == 1:
        line = frame.sort(axes[0])
        curve = (name, line[axes[0]].to_list(), line[name].to_list(), "lines+markers")
        figure = curves_picture(axis_title(axes[0]), "amplitude / mm", [curve], title)
        low, high = (name.removesuffix(LEVEL) + end for end in (LOW, HIGH))
        if low in line.columns:
            own = line.filter(pl.col(low).is_not_null())
            x, below, above = (own[column].to_numpy() for column in (axes[0], low, high))
            add_area(figure, x, below, above, "band", opacity=FAINT)
        return figure
    largest = frame.group_by(axes[:2]).agg(pl.col(name).max())
    xs, ys = (np.unique(largest[axis].to_numpy()) for axis in axes[:2])
    level = np.full((ys.size, xs.size), np.nan)
    for x, y, value in largest.iter_rows():
        level[np.searchsorted(ys, y), np.searchsorted(xs, x)] = np.nan if value is None else value
    level[level <= 0] = np.nan
    return cells_picture(axis_title(axes[0]), axis_title(axes[1]), xs, ys, level, "mm", title)
