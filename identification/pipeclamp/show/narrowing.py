"""The loop tests that narrow a pipe's band, in sentences and a table."""

from __future__ import annotations

from pathlib import Path

from pipeclamp.show.table import Table
from pipeclamp.show.view import View
from pipeclamp_identification.comparison.sentences import sentence
from pipeclamp_identification.diagnosis.further_test.outlook import RUNS_OF_A_TEST
from pipeclamp_identification.planning.band_plan import BandPlan, Map, test_words
from pipeclamp_identification.planning.narrowing_answer import band_plan_answer
from pipeclamp_identification.planning.narrowing_search import WORTH_SHARE
from pipeclamp_system.bands.band import NAMED_SHARE, Band, beside_words, ends_words, figures, origin_words


def width(band: Band) -> float:
    """Give how wide a band is."""
    return band.high - band.low


def band_plan_view(plan: BandPlan, drive: Path | None) -> View:
    """Give how a plan is told; `drive` is where the first test's drive signal was written."""
    return View(band_plan_answer(plan), [tests_table(plan)] if plan.tests else [], band_plan_words(plan, drive))


def tests_table(plan: BandPlan) -> Table:
    """Give the tests, one after another, with the band after each."""
    header = ("", "A / mm", "f / Hz", "T / °C", "peak / mm: low", "high", "width", "peak / Hz: low", "high")
    before = plan.before
    rows: list[tuple[str | float | None, ...]] = [
        ("now", None, None, None, *_ends(before.amplitude, before.amplitude), *figures(before.frequency)[1:])
    ]
    several = len({test.law for test in plan.tests}) > 1
    for number, test in enumerate(plan.tests, 1):
        name = f"after test {number}" + (f", of {test.law}" if several else "")
        rows.append(
            (name, test.amplitude_mm, test.frequency_Hz, test.temperature_C, *_ends(test.amplitude, before.amplitude),
             *figures(test.frequency)[1:])
        )  # fmt: skip
    rows.append(("at best", None, None, None, *_ends(plan.floor, before.amplitude), None, None))
    return Table(header, rows, f"{plan.per_cent:g}% band of the peak at {plan.point}, each test {RUNS_OF_A_TEST} times")


def _ends(band: Band, before: Band) -> tuple[str, str, str]:
    share = f"{width(band) / width(before):.0%}" if width(before) > 0 else ""
    return *figures(band)[1:], share


def beyond_words(one: Map) -> str:
    """Say where a clamp moves beyond its law's tests at the peak; nothing where it doesn't."""
    told = (("A", "mm"), ("f", "Hz"))
    outside = [
        f"{name} = {one.motion[name]:.3g} {unit} (tests: {one.tested[name][0]:.3g} to {one.tested[name][1]:.3g})"
        for name, unit in told
        if not one.tested[name][0] <= one.motion[name] <= one.tested[name][1]
    ]
    if not outside:
        return ""
    return (
        f"At that peak the clamp of {one.law} moves beyond its tests: {', '.join(outside)}. The band there is "
        "carried on from what the law is off in its tests; none has shown what it is off in such a motion."
    )


def band_plan_words(plan: BandPlan, drive: Path | None = None) -> list[str]:
    """Say which test narrows the band most, what stays, and what was reckoned with."""
    amplitude = plan.before.amplitude
    ends = ends_words(amplitude, "mm", plan.per_cent)
    lines = [f"Peak at {plan.point}, {plan.curve}: {ends}{beside_words(amplitude, 'the peak')}."]
    lines += [words for one in plan.maps if (words := beyond_words(one))]
    at_best = f"{plan.floor.low:.4g} to {plan.floor.high:.4g} mm"
    if plan.tests:
        first = plan.tests[0]
        lines.append(
            f"Next test: run {test_words(first)}: the band goes to {first.amplitude.low:.4g} to "
            f"{first.amplitude.high:.4g} mm, {width(first.amplitude) / width(amplitude):.0%} of its width."
        )
        lines.append(
            f"Stop there, or after test {len(plan.tests)}: a further one would take less than {WORTH_SHARE:.0%} of it."
        )
    else:
        lines.append(f"No loop test within the limits takes {WORTH_SHARE:.0%} of the band's width.")
    stays = "mountings and the law's form stay" if plan.floor.shares["form"] >= NAMED_SHARE else "mountings stay"
    lines.append(f"No number of such tests goes below {at_best}: {stays}.")
    last = plan.tests[-1].amplitude if plan.tests else amplitude
    lines += map(sentence, origin_words("the peak then", last))
    for law, words in plan.limits.items():
        lines.append(f"Sought for {law} within {words}; noise of the force: {plan.noise[law]}.")
    if drive and plan.tests:
        lines.append(f"{drive} holds its drive signal: {plan.tests[0].plan.words()}; run it {RUNS_OF_A_TEST} times.")
    elif drive:
        lines.append(f"{drive} isn't written: no test is proposed.")
    return [*lines, *plan.gaps]
