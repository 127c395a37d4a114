"""The page of a comparison: how much a law errs and where, as tables, worst first, and pictures."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from pipeclamp.pages.error_pictures import (
    ErrorBars,
    HarmonicLevels,
    LoopInTime,
    along_loop_picture,
    bars_of,
    cycles_picture,
    error_bars,
    harmonics_picture,
)
from pipeclamp.pages.explorer import explored
from pipeclamp.pages.free_comparison import free_sections
from pipeclamp.pages.page import Section
from pipeclamp.show.comparison import beside_even, found_words, how_much, parts_table, worst_table
from pipeclamp_identification.comparison import breakdown
from pipeclamp_identification.comparison.breakdown import phase_edges
from pipeclamp_identification.comparison.compare import Comparison
from pipeclamp_identification.comparison.conditions import Condition
from pipeclamp_identification.comparison.error_parts import Breakdown
from pipeclamp_identification.comparison.laws import ComparedLaw
from pipeclamp_identification.comparison.sentences import sentence
from pipeclamp_identification.fitting.misfit import DRAWN_SAMPLES, force_of_rows, loop_of_run
from pipeclamp_identification.loops.scatter import PHASE_BINS
from pipeclamp_models.base.digits import one_digit

EVEN = beside_even("every run erred by the same part of its force, all along the loop")


HARMONICS_SHOWN = 12


def answer_words(comparison: Comparison) -> list[str]:
    """Say how much a law errs, where, and what to know of the tests."""
    words = [*how_much(comparison), *found_words(comparison)]
    if comparison.outside:
        count = len(comparison.outside)
        several = "runs lie" if count > 1 else "run lies"
        words.append(f"{count} {several} outside the range in which the law was identified.")
    words += [sentence(str(entry)) for entry in comparison.campaign.left_out]
    return [*words, *(f"Note: {remark}." for remark in comparison.campaign.remarks)]


def difference_section(comparison: Comparison, laws: Sequence[ComparedLaw], title: str = "Difference") -> Section:
    """Show what is measured less what each law gives, run by run, with the map over A and f to pick them from."""
    A, f, *further = comparison.conditions
    held = sorted((condition for condition in further if condition.varies), key=partial(_evenness, comparison))
    return Section(title, explorer=explored(comparison.loops, laws, (A, f, *held), comparison.campaign.name))


def _evenness(comparison: Comparison, condition: Condition) -> float:
    return -breakdown.by_condition(comparison.sums, condition).unevenness


def detail_sections(comparison: Comparison) -> list[Section]:
    """Show where a law errs: along free motions, along the loop, by harmonic, along cycles, by condition, all runs."""
    free = free_sections(comparison)
    if not comparison.runs:
        return free
    return [
        *free,
        _along_loop_section(comparison),
        _harmonics_section(comparison),
        _cycles_section(comparison),
        *_conditions_sections(comparison),
        Section("All runs", (), [worst_table(comparison)]),
    ]


def _along_loop_section(comparison: Comparison) -> Section:
    phases = breakdown.along_loop(comparison.sums)
    middles = [sum(phase_edges(index)) / 2 for index in range(PHASE_BINS)]
    bars = bars_of("all runs, share of the rms force", "phase / deg after the largest displacement", phases)
    row = comparison.worst_first()[0]
    _, measured = loop_of_run(comparison.loops, row)
    run = comparison.runs[row]
    law = force_of_rows(comparison.law, comparison.loops, DRAWN_SAMPLES)[row]
    degrees = 360.0 * np.arange(DRAWN_SAMPLES) / DRAWN_SAMPLES
    loop = LoopInTime(f"the worst run: {run.run}, {100 * run.nrmse:.2g}%", degrees, measured, law)
    picture = along_loop_picture(
        ErrorBars(bars.title, bars.axis, middles, bars.error, bars.scatter),
        loop,
        breakdown.LOOP_PLACES[0][2],
        "Along the loop; near the reversals shaded",
    )
    words = (
        "On unloading the displacement falls from its largest value, on loading it rises again. Just after and just "
        "before a reversal are the 30 degrees on either side of it, with the last 13% of the displacement."
    )
    tables = [parts_table(breakdown.by_branch(comparison.sums)), parts_table(breakdown.by_place(comparison.sums))]
    return Section("Along the loop", [words, EVEN], tables, [picture])


def _harmonics_section(comparison: Comparison) -> Section:
    harmonics = breakdown.by_harmonic(comparison.sums)
    table = parts_table(harmonics, even=False, most=HARMONICS_SHOWN)
    levels = [_harmonic_levels(comparison, harmonics, quadrature) for quadrature in (False, True)]
    picture = harmonics_picture(levels, "By harmonic, rms over all runs, percent of the rms force")
    words = (
        "In phase with the displacement is what a spring makes, in quadrature what damping makes; harmonic 0 is the "
        "mean."
    )
    return Section("By harmonic", [words], [table], [picture])


def _harmonic_levels(comparison: Comparison, harmonics: Breakdown, quadrature: bool) -> HarmonicLevels:
    """Pick the harmonics in phase, or in quadrature, out of the breakdown."""
    squares = np.stack(breakdown.squared_harmonics(comparison.sums, comparison.loops))
    force = sum(run.squared_force for run in comparison.sums)
    order = np.arange(1 if quadrature else 0, squares.shape[1])
    parts = [harmonics.parts[breakdown.harmonic_index(int(n), quadrature)] for n in order]
    measured, computed = (100 * np.sqrt(square[order, int(quadrature)] / force) for square in squares)
    scatter = np.array([100 * (part.noise_nrmse or 0.0) for part in parts])
    return HarmonicLevels(
        "in quadrature (damping)" if quadrature else "in phase (spring)",
        order.astype(np.float64),
        measured,
        computed,
        np.array([100 * (part.nrmse or 0.0) for part in parts]),
        None if parts[0].noise_nrmse is None else scatter,
    )


def _cycles_section(comparison: Comparison) -> Section:
    cycles = breakdown.along_cycles(comparison.sums)
    if len(cycles.parts) == 1:
        return Section("Along cycles", ["Every record holds one cycle: nothing can be said along cycles."])
    drift = breakdown.drift(comparison.sums)
    words = []
    if drift:
        words.append(
            "From a record's first cycle to its last the measured force drifts against the law by "
            f"{100 * drift.in_phase:+.2g}% in phase and {100 * drift.in_quadrature:+.2g}% in quadrature of its first "
            f"harmonic, standard error {one_digit(100 * drift.standard_error)}%."
        )
    bars = bars_of("all runs, share of the rms force", cycles.by, cycles, short=True)
    measured, computed = breakdown.amplitude_along_cycles(comparison.sums, comparison.loops)
    picture = cycles_picture(bars, 100 * measured, 100 * computed, "Along cycles")
    return Section("Along cycles", words, [parts_table(cycles)], [picture])


def _conditions_sections(comparison: Comparison) -> list[Section]:
    broken = [breakdown.by_condition(comparison.sums, condition) for condition in comparison.varied]
    if not broken:
        return []
    picture = error_bars([bars_of("", parts.by, parts) for parts in broken], "By condition, percent of the rms force")
    return [Section("By condition", [EVEN], [parts_table(parts, runs=True) for parts in broken], [picture])]
