"""A comparison told: how much a law errs and where, as sentences and tables, worst first."""

from __future__ import annotations

import numpy as np

from pipeclamp.show.table import SINGLE_CYCLES, Table, outside_cell, outside_head
from pipeclamp.show.view import View
from pipeclamp_identification.comparison.answer import comparison_answer
from pipeclamp_identification.comparison.compare import Comparison, celsius, where_words
from pipeclamp_identification.comparison.error_parts import Breakdown, ErrorPart
from pipeclamp_identification.comparison.sentences import about_mean, sentence
from pipeclamp_identification.fitting.misfit import overall_nrmse
from pipeclamp_identification.loops.loops import PRELOADED
from pipeclamp_identification.workflow.along_free import along_free
from pipeclamp_models.base.said import counted

RUNS_PRINTED = 8
"""Runs that a terminal shows, worst first."""
SHOWN_BY_VALUE = ("amplitude_mm", "frequency_Hz", "temperature_C")
"""Conditions that are shown with their value in each run, not with their level."""
_MEAN_TAKEN = "The force is known up to a constant only, and the measured mean is taken"


def how_much(comparison: Comparison) -> list[str]:
    """Say how much the law errs, and what of it is scatter."""
    if not comparison.free:
        return _errs(comparison, "")
    free = f"RMS error {overall_nrmse(comparison.free):.2%} of RMS force over {counted(len(comparison.free), 'run')}"
    words = [f"{free} of free motion; {along_free(comparison.free).scatter_words()}."]
    words += [f"{_MEAN_TAKEN}: {run.run}." for run in comparison.free if run.adrift]
    return [*words, *(_errs(comparison, " of sines") if comparison.runs else [])]


def found_words(comparison: Comparison) -> list[str]:
    """Say where the error sits; of free motions alone also what it calls for, which else a diagnosis tells."""
    alone = comparison.free and not comparison.runs
    return [*where_words(comparison), *([along_free(comparison.free).words()] if alone else [])]


def _errs(comparison: Comparison, which: str) -> list[str]:
    """Say how much the law errs on sines."""
    runs, single = len(comparison.runs), comparison.single_cycles
    error, mean = overall_nrmse(comparison.runs), comparison.loops.mean_share
    noise = None if single == runs else comparison.noise_nrmse
    errs = f"RMS error {error:.2%} of RMS force over {counted(runs, 'run')}{which}"
    if noise is None:
        words = [f"{errs}; {SINGLE_CYCLES}."]
    else:
        words = [f"{errs}; {noise:.2%} is cycle-to-cycle scatter, which no law can explain."]
    if 0 < single < runs:
        words.append(f"{single} of {runs} runs hold one cycle only: their scatter isn't known.")
    return [*words, sentence(about_mean(mean, error, noise))] if mean > PRELOADED else words


def worst_table(comparison: Comparison, most: int | None = None) -> Table:
    """Give the runs as a table, worst first."""
    loops = comparison.loops
    further = [condition for condition in comparison.varied if condition.key not in SHOWN_BY_VALUE]
    rows = [
        (
            comparison.runs[row].run,
            float(loops.amplitude_mm[row]),
            float(loops.frequency_Hz[row]),
            celsius(loops, row),
            *(condition.level_of(row).label for condition in further),
            100 * comparison.runs[row].nrmse,
            100 * comparison.runs[row].noise_nrmse if comparison.sums[row].scatter_known else None,
            *outside_cell(comparison.outside, comparison.runs[row].run),
        )
        for row in comparison.worst_first()[:most]
    ]
    conditions = ("A / mm", "f / Hz", "T / °C", *(condition.title for condition in further))
    header = ("run", *conditions, "error / %", "scatter / %", *outside_head(comparison.outside))
    order = in_order(len(rows), len(comparison.runs))
    return Table(header, rows, f"error and cycle-to-cycle scatter, as a share of the run's rms force; {order}")


def in_order(shown: int, of: int) -> str:
    """Say in which order runs stand, and of how many they are the worst."""
    return "worst first" if shown == of else f"the {shown} worst of {of} runs, worst first"


def free_table(comparison: Comparison) -> Table:
    """Give the runs of free motion as a table, worst first."""
    rows = [
        (
            run.run,
            float(run.time[-1]),
            float(np.max(np.abs(run.y - run.y[0]))),
            float(np.max(np.abs(run.v))),
            run.came_from,
            100 * run.nrmse,
            *outside_cell(comparison.outside, run.run),
        )
        for run in comparison.worst_free_first()
    ]
    header = (
        "run of free motion", "duration / s", "farthest / mm", "fastest / mm/s", "came from / mm", "error / %",
        *outside_head(comparison.outside),
    )  # fmt: skip
    caption = "error as a share of the run's rms force; worst first; where the law's memory isn't unloaded: came from"
    return Table(header, rows, caption)


def percent(share: float | None) -> float | None:
    """Give a share in percent; None where it isn't known."""
    return None if share is None else 100 * share


def beside_even(erred: str) -> str:
    """Say what share stands beside that of a part, which is there if something erred evenly, so told."""
    return f"Beside the share of the squared error that a part holds stands the share that it would hold if {erred}."


def parts_table(parts: Breakdown, *, even: bool = True, runs: bool = False, most: int | None = None) -> Table:
    """Give parts as a table, worst first."""
    known = any(part.squared_scatter is not None for part in parts.parts)
    header = [parts.by, "error / %", *(["scatter / %"] if known else []), "share of squared error / %"]
    header += ["share beyond scatter / %"] if known else []
    header += ["share if even / %"] if even else []
    header += ["runs"] if runs else []

    def row(part: ErrorPart) -> list[str | float | None]:
        beyond = None if part.squared_scatter is None else 100 * parts.excess_share(part)
        scatter = [percent(part.noise_nrmse)] if known else []
        return [
            part.label,
            percent(part.nrmse),
            *scatter,
            100 * parts.share(part),
            *([beyond] if known else []),
            *([100 * parts.even_share(part)] if even else []),
            *([float(part.runs)] if runs else []),
        ]

    return Table(header, [row(part) for part in parts.worst_first()[:most]], f"by {parts.by}, worst first")


def comparison_view(comparison: Comparison) -> View:
    """Tell how a law stands against records."""
    return View(
        comparison_answer(comparison),
        [
            *([worst_table(comparison, most=RUNS_PRINTED)] if comparison.runs else []),
            *([free_table(comparison)] if comparison.free else []),
        ],
        [*how_much(comparison), *found_words(comparison)],
    )
