"""What is said where no term can be proposed."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from pipeclamp.show.discovery import discovery_words, formula_read
from pipeclamp_identification.discovery.discover import TermSearch, catalogue_first
from pipeclamp_identification.discovery.grammar import terms
from pipeclamp_identification.discovery.proposal import PowersBack, TermProposal, formula_of
from pipeclamp_models.law.step import BeforeAfter


def test_who_gets_no_term_reads_what_was_tried_and_where_the_rest_lies():
    diagnosed = SimpleNamespace(left_over=lambda: ("the law as it is leaves 4 N", "most of it lies in harmonic 3"))
    for tried, told in ((348, True), (0, False)):
        search = TermSearch(diagnosed, None, tried, "no term explains more than chance")
        words = " ".join(discovery_words(TermProposal(search, None, None, None, None, None, (), search.reason, ())))
        assert words.startswith("Nothing is proposed: no term explains more than chance.")
        assert ("348 terms were tried" in words) == told
        assert ("the law as it is leaves 4 N; most of it lies in harmonic 3." in words) == told


def test_where_the_rest_lies_is_in_the_answer_too():
    """Programs had to diagnose again for it; and where nothing can be said of it, the sentence had been empty."""
    for rest in (("the law as it is leaves 4 N",), ()):
        search = TermSearch(SimpleNamespace(left_over=lambda rest=rest: rest), None, 348, "no term explains enough")
        proposal = TermProposal(search, None, None, None, None, None, (), search.reason, ())
        assert proposal.answer().left_over == rest
        assert any("Where the rest lies" in line for line in discovery_words(proposal)) == bool(rest)


def test_powers_that_are_fitted_again_are_told_with_what_they_alone_do():
    """The error of the law with them stood beside that of the law without, and nothing said why they differ."""
    search = TermSearch(SimpleNamespace(left_over=lambda: ()), None, 348, "no term passes")
    back = PowersBack(("k1_A", "c_A"), BeforeAfter(0.0141, 0.0137))
    blank = TermProposal(search, None, object(), BeforeAfter(0.0141, 0.0101), None, None, (), "no term passes", ())
    line = (
        "k1_A and c_A, without which the law was, are fitted again first, for a term might stand for them: that alone "
        "makes 1.41% -> 1.37%."
    )
    for proposal, told in ((replace(blank, powers_back=back), True), (blank, False)):
        assert (line in discovery_words(replace(proposal, instead="memory"))) == told


def test_what_keeps_a_division_from_nothing_is_no_part_of_a_formula_that_people_read():
    for name in ("found_activated_relaxing", "found_thixotropic_dry"):
        (term,) = (one for one in terms((), {}) if one.declaration.id == name)
        read = formula_read(formula_of(term.declaration))
        assert "1e-" not in read
        assert "1e-" in formula_of(term.declaration)


def test_the_best_term_is_told_by_what_its_numbers_are():
    """It had been a line of code: F += F_x * ((y / sqrt(y**2 + y_r**2)) * (max(sqrt(y**2 + y_r**2) - y_x, 0) ...)."""
    (stop,) = (one for one in terms(("A", "f"), {}) if one.declaration.id == "found_stop_both_2")
    law = SimpleNamespace(values={"F_x": 237.392, "y_x": 0.67023, "k1": 1.0})
    fit = SimpleNamespace(law=law, standard_errors=lambda: {"F_x": 12.3}, at_bound={"y_x": 0.67023})
    judged = SimpleNamespace(result=fit)
    found = SimpleNamespace(term=stop, judged=judged, rivals=(), next_test="", caution="")
    reason = f"{stop.acts_like}: it comes back in 53% of draws"
    search = TermSearch(SimpleNamespace(left_over=lambda: ()), found, 348, reason)
    proposal = TermProposal(search, None, None, None, None, None, (), reason, ())
    words = discovery_words(proposal)
    assert words[:2] == [
        "Nothing is proposed: a spring that begins beyond a displacement on both sides and grows with the square: it "
        "comes back in 53% of draws.",
        "Its numbers: force of the term 237 ± 10 N, displacement from which it acts 0.67 mm (at its bound).",
    ]
    assert "**" not in " ".join(words)
    told = proposal.answer().numbers
    assert [(one.symbol, one.value, one.unit) for one in told] == [("F_x", 237.392, "N"), ("y_x", 0.67023, "mm")]
    assert [(one.standard_error, one.at_bound) for one in told] == [(12.3, False), (None, True)]
    assert formula_read(formula_of(stop.declaration)) == "F += F_x * (sign(y) * (max(|y| - y_x, 0) / A_0)**2)"


@pytest.mark.parametrize(
    ("causes", "told", "untold"),
    [
        (("asymmetry",), "what is missing: asymmetry; `add` it first", "can't tell"),
        (("asymmetry", "pressed_slip"), "can't tell which: asymmetry, pressed_slip; a test", "`add` it"),
    ],
)
def test_who_can_not_tell_two_causes_apart_is_told_a_way_on(causes, told, untold):
    """He had been told that the catalogue has what is missing, and to add "it", of two effects."""
    reason = catalogue_first(causes)
    assert told in reason
    assert untold not in reason
