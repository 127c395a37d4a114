"""A law's history keeps the law at each stage, so that any of them can be held against tests again."""

import re

import pytest

from pipeclamp.pages.sections import comparison_page
from pipeclamp.pages.waterfall import ESTIMATED, LEFT_OUT, USED, RungBars, rungs_of, waterfall_picture, with_promised
from pipeclamp.show.law import parameters_table
from pipeclamp.show.views import comparison_view, laws_view
from pipeclamp_identification.campaign.bundled import bundled_campaign
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.comparison.compare import compare
from pipeclamp_identification.comparison.laws import laws_held, stages_held
from pipeclamp_identification.workflow.change import add_effect, remove_effect
from pipeclamp_identification.workflow.on_records import RecordTests
from pipeclamp_models.law.file import Provenance, law_text, parse_law


@pytest.fixture(scope="module")
def climbed():
    """Tests, the base law, the one with an effect more, and the one that lost it again."""
    tests = RecordTests(read_campaign(bundled_campaign("clamp_a")))
    base = tests.identify().file(name="law", provenance=Provenance("test"))
    added = add_effect(base, "damping_temperature", tests, provenance=Provenance("test")).after
    removed = remove_effect(added, "damping_temperature", tests, provenance=Provenance("test")).after
    return tests, base, added, removed


def test_a_law_of_one_step_has_its_picture_too(climbed):
    tests, base, *_ = climbed
    (picture,) = comparison_page([(base, tests.compare(base))])[0].figures
    assert [list(bars.y) for bars in picture.data] == [[pytest.approx(100 * base.fit.nrmse)]]


def test_each_stage_errs_as_it_did(climbed):
    tests, base, added, removed = climbed
    read_again = parse_law(law_text(removed), "law")
    stages = stages_held(read_again, tests.compare(removed))
    assert [stage.label for stage in stages] == ["power", "+ damping_temperature", "- damping_temperature"]
    for stage, file in zip(stages, (base, added, removed), strict=True):
        assert stage.nrmse == pytest.approx(compare(file, tests.campaign).nrmse, rel=1e-9)


def test_a_stage_that_cannot_be_computed_is_left_out(climbed):
    tests, _, added, _ = climbed
    first, last = added.history
    strange = first.model_copy(update={"stage": first.stage.model_copy(update={"effects": ("of_a_later_version",)})})
    file = added.model_copy(update={"history": (strange, last)})
    assert [stage.label for stage in stages_held(file, tests.compare(added))] == ["+ damping_temperature"]


def test_what_each_rung_took_is_told(climbed):
    _, _, added, removed = climbed
    (power, took, gave) = waterfall_picture(rungs_of(removed), added.fit.noise_nrmse, "falling").data[0].x
    assert power == "power"
    assert re.search(r"squared error<br>above scatter<br>\N{MINUS SIGN}\d\d%$", took)
    assert re.search(r"squared error<br>above scatter<br>\+\d+%$", gave)
    assert set(rungs_of(removed)[0].errors) == {USED, LEFT_OUT}


def test_laws_of_one_name_are_told_apart(climbed):
    tests, base, added, _ = climbed
    held = [(file, tests.compare(file)) for file in (base, added, added, base)]
    labels = [law.label for law in laws_held(held)]
    assert labels == ["law", "law: damping_temperature", "law (2)", "law: power"]
    answer, difference, *details = comparison_page(held)
    assert difference.explorer["laws"] == labels
    errors = [row[2] for row in answer.tables[0].rows]
    assert errors[3] == errors[0] > errors[1] == errors[2]
    least = "law: damping_temperature errs least of the 4 laws; all that follows is about it."
    assert answer.paragraphs[:2] == [least, *comparison_view(held[1][1]).lines[:1]]
    assert laws_view(held).lines == [least, *comparison_view(held[1][1]).lines]
    along = next(section for section in details if section.title == "Along the loop")
    assert along.paragraphs[0] == "Of law: damping_temperature.", "which law it is of"


def test_an_estimated_error_never_takes_the_place_of_that_of_fits(climbed):
    """Two quantities have two names; what comes takes the share that the diagnosis states, whatever the bars are."""
    _, _, added, _ = climbed
    rungs = rungs_of(added)
    now, coming = RungBars("law as it is", {ESTIMATED: 0.02}), RungBars("or + a + b", {ESTIMATED: 0.01}, True, 0.73)
    assert with_promised(rungs, now, [])[-1] == rungs[-1]
    *_, last, more = with_promised(rungs, now, [coming])
    assert last.errors == {**rungs[-1].errors, ESTIMATED: 0.02}
    assert more == coming
    label = waterfall_picture([*rungs[:-1], last, more], None, "falling").data[0].x[-1]
    assert label == "or + a<br>+ b<br>would take 73%<br>of what is missing"
    untold = [RungBars("power", {USED: 0.02})]
    assert with_promised(untold, now, [])[-1].errors == {USED: 0.02, ESTIMATED: 0.02}


def test_names_of_many_rungs_stand_beside_each_other_without_overlapping():
    """At 1300 px "+ stiffness_frequency" ran into "+ damping_temperature" and that into "+ exponential_stiffening"."""
    names = ["power", "+ stiffness_frequency", "+ damping_temperature", "+ exponential_stiffening", "+ inertia"]
    names += ["+ slip_spread", "+ loosening", "+ oil_damper + gas_spring"]
    picture = waterfall_picture([RungBars(name, {LEFT_OUT: 0.1}) for name in names], None, "falling")
    labels = picture.data[0].x
    assert max(len(line) for label in labels for line in label.split("<br>")) <= (1100 - 130) / 7 / len(names) + 1
    assert labels[3].replace("<br>", "").startswith("+\N{NO-BREAK SPACE}exponential_stiffening")
    assert waterfall_picture([RungBars(names[3], {LEFT_OUT: 0.1})], None, "").data[0].x[0].count("<br>") == 1


def test_a_standard_error_is_told_in_plain_figures(climbed):
    """A stiffness of 297 ± 200 N/mm, not ± 2e+02."""
    _, base, *_ = climbed
    k10 = base.coefficients["k10"].model_copy(update={"value": 297.4, "standard_error": 187.0})
    file = base.model_copy(update={"coefficients": {**base.coefficients, "k10": k10}})
    rows = {row[0]: row[2] for row in parameters_table([file]).rows}
    assert rows["k10"] == "297.4 ± 200"


def test_bars_of_one_kind_say_which_tests_they_are_of():
    """A law held against others than it was fitted to: the bars aren't the error that the answer states."""
    picture = waterfall_picture([RungBars("power", {USED: 0.1})], None, "")
    assert picture.layout.showlegend
    assert [bar.name for bar in picture.data] == [USED]
