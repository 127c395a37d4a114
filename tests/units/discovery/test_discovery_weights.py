"""The tests are weighed again by the best term so far, and a refined form may be that of a term that did worse."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.diagnosis.problem import judge, prepare, weighed_again
from pipeclamp_identification.diagnosis.thresholds import RIVAL_LIKELIHOOD
from pipeclamp_identification.discovery import refining
from pipeclamp_identification.discovery.columns import Evaluation
from pipeclamp_identification.discovery.grammar import terms
from pipeclamp_identification.discovery.guards import Guard
from pipeclamp_identification.discovery.hearing import Hearing, Hurdle, TermFound, refitted_of
from pipeclamp_identification.discovery.refining import Refining
from pipeclamp_identification.discovery.weights import weighed_by
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.base.processes import ALONE
from pipeclamp_models.law.law import Law, Structure, with_effect

BASE = {
    "k10": 1450.0, "k1_A": -0.22, "k1_T": -0.1, "k30": 250.0, "k3_A": -0.9, "k3_T": -0.1,
    "c0": 80.0, "c_A": 0.05, "c_f": -0.15, "alpha0": 0.45, "alpha_A": 0.2, "alpha_f": 0.01,
}  # fmt: skip
PLAN = Plan((0.2, 0.5, 0.8, 1.0), (1.0, 3.0), (20.0,), rate=500.0, seed=4)
TERMS = {term.declaration.id: term for term in terms(("A", "f"), {})}
SQUARE, LINEAR, ELSE = "found_stop_positive_2", "found_stop_positive_1", "found_dry_damping"
STARTS = {SQUARE: {"F_x": 900.0, "y_x": 0.4}, LINEAR: {"F_x": 300.0, "y_x": 0.4}, ELSE: {"F_x": 1.0}}


@pytest.fixture(scope="module")
def hearing(tmp_path_factory):
    """Terms that were fitted together with a law that lacks a stop on one side: that stop, another one, and another."""
    folder = tmp_path_factory.mktemp("stop") / "campaign"
    base = Structure("power")

    def having(name):
        return with_effect(base.with_declared([TERMS[name].declaration]), name)

    truth = Law(having(SQUARE), {**BASE, "F_x": 900.0, "y_x": 0.4}, 0.0126, 0.002)
    write_campaign(folder, virtual_runs(truth, PLAN), name="virtual", notes="")
    loops = loops_of(read_campaign(folder))
    problem, first = prepare(base, loops)
    problem, law = weighed_again(problem, base, first, [first])
    evaluation = Evaluation(problem, law)
    fitted = [
        each
        for name, own in STARTS.items()
        for each in refitted_of(
            judge((name,), having(name), [{**law.result.law.values, **own}], problem), TERMS[name], evaluation
        )
    ]
    columns = [column for name in STARTS for column in evaluation.columns(TERMS[name])]
    return Hearing(evaluation, columns, fitted, Hurdle(law, [], loops, ()))


def test_what_a_term_takes_is_granted_no_longer(hearing):
    """The law without it had been granted an error so large that no form of the term could better another."""
    square, linear, _ = hearing.refitted
    weighed, (again,) = weighed_by(square, [square], hearing)
    granted, before = weighed.evaluation.problem.discrepancy, hearing.evaluation.problem.discrepancy
    assert granted < 0.1 * before
    (other,) = (one for one in weighed.refitted if one.term is linear.term)
    assert other.squares - again.squares > 3 * (linear.squares - square.squares)
    assert [one.term for one in weighed.refitted] == [one.term for one in hearing.refitted]
    assert weighed.bar.law.squares > 10 * hearing.bar.law.squares


def test_where_a_term_takes_little_the_weights_stay(hearing):
    *_, small = hearing.refitted
    weighed, near = weighed_by(small, [small], hearing)
    assert weighed is hearing
    assert near == [small]


def test_forms_of_a_term_that_does_worse_are_tried_too(hearing, monkeypatch):
    """Only what did as well as the best had been refined; a number of another one may be what is missing."""
    square, _, worse = hearing.refitted
    assert worse.squares > square.squares + RIVAL_LIKELIHOOD
    asked = []
    monkeypatch.setattr(refining, "refinements", lambda term, *given: asked.append(term.declaration.id) or iter(()))
    monkeypatch.setattr(refining, "joined", lambda *given: pytest.fail("no second term may be joined"))
    monkeypatch.setattr(refining, "may_join", lambda one, other: False)
    assert Refining((("A", "f"), {}), ALONE)._one_more(square, hearing) is None
    assert asked == [SQUARE, LINEAR, ELSE]


def test_forms_of_a_term_that_a_bound_stops_are_tried_too(hearing, monkeypatch):
    """A step that is as sharp as it may be may be wider, and lie elsewhere at each frequency: not tried before."""
    square, linear, _ = hearing.refitted
    asked = []
    monkeypatch.setattr(refining, "refinements", lambda term, *given: asked.append(term.declaration.id) or iter(()))
    monkeypatch.setattr(refining, "may_join", lambda one, other: False)
    stopped = replace(hearing, refitted=[square], stopped=[linear])
    assert Refining((("A", "f"), {}), ALONE)._one_more(square, stopped) is None
    assert asked == [SQUARE, LINEAR]


def test_where_the_best_refined_form_fails_the_next_is_asked(hearing, monkeypatch):
    """One that gained by numbers of the law that hardly anything determines had ended the search for the right one."""
    _, linear, other = hearing.refitted
    asked = []

    def betters(best, plain, tried, hearing):
        asked.append(best)
        return len(asked) == 2

    monkeypatch.setattr(refining, "may_join", lambda one, other: False)
    monkeypatch.setattr(refining, "betters", betters)
    monkeypatch.setattr(Hearing, "of", lambda self, best, rivals: SimpleNamespace(passed=True, term=best.term))
    found, best, _ = Refining(((), {}), ALONE)._one_more(linear, replace(hearing, refitted=[linear, other]))
    first, second = (one.term.declaration.id for one in asked)
    assert first != second == found.term.declaration.id == best.term.declaration.id
    assert asked[0].squares <= asked[1].squares + RIVAL_LIKELIHOOD


@pytest.mark.parametrize(
    ("gone", "ahead", "goes_on"), [((), 1e9, True), (("stribeck",), 0.0, True), (("stribeck",), 1e9, False)]
)
def test_a_form_that_fails_on_the_way_is_refined_further(hearing, monkeypatch, gone, ahead, goes_on):
    """In the place of effects a term with one number free failed where these foretell better, and two were needed.

    But not where they are so far ahead of it that it isn't what they stand for.
    """
    _, linear, other = hearing.refitted

    def asked(self, best, rivals):
        chance, edges = Guard("more than chance", True, ""), Guard("does no harm beyond", False, "")
        return TermFound(best.term, best.judged, hearing.bar.law, (), "", (chance, edges), gone)

    monkeypatch.setattr(refining, "may_join", lambda one, other: False)
    monkeypatch.setattr(refining, "betters", lambda best, plain, tried, hearing: True)
    monkeypatch.setattr(Hearing, "of", asked)
    heard, near = weighed_by(linear, [linear], replace(hearing, refitted=[linear, other]))
    bar = replace(heard.bar, law=SimpleNamespace(squares=heard.bar.law.squares - ahead))
    heard = replace(heard, gone=gone, bar=bar)
    monkeypatch.setattr(refining, "weighed_by", lambda best, others, hearing: (heard, near))
    further = Refining(((), {}), ALONE)._one_more(linear, heard)
    assert (further is not None) == goes_on
    if further is None:
        return
    form, best, wider = further
    assert not form.passed
    assert best.term is form.term
    assert best in wider.refitted


@pytest.mark.parametrize(
    ("failed", "gone", "refined"),
    [
        ("comes back", (), True), ("comes back", ("stribeck",), True), ("does no harm beyond", (), True),
        ("confirmed", (), False), ("confirmed", ("stribeck",), True), ("more than chance", ("stribeck",), False),
    ],
)  # fmt: skip
def test_a_term_that_other_forms_equal_in_draws_is_refined(hearing, monkeypatch, failed, gone, refined):
    """Of forms that all lack one number each does best in some draws; the one that has it came back in all of them."""
    square, *_ = hearing.refitted
    names = ("more than chance", "comes back", "does no harm beyond", "confirmed")
    guards = tuple(Guard(name, name != failed, "") for name in names)
    found, asked = TermFound(square.term, square.judged, hearing.bar.law, (), "", guards, gone), []
    monkeypatch.setattr(Refining, "_one_more", lambda self, best, hearing: asked.append(best))
    assert Refining(((), {}), ALONE).of(found, square, hearing) is found
    assert asked == [square] * refined


def test_a_form_that_the_law_was_given_before_is_no_form_of_another_term(hearing, monkeypatch):
    """A second search of a law with a refined term ended with an error: one id declared twice, and differently."""
    square, *_ = hearing.refitted
    known = next(form for form, _ in refining.refinements(square.term, square.judged.result.law.values, ("A", "f"), {}))
    law = hearing.evaluation.law
    own = known.declaration.model_copy(update={"title": "as it was fitted"})
    having = replace(law.result.law, structure=law.result.law.structure.with_declared([own]))
    evaluation = replace(hearing.evaluation, law=replace(law, result=replace(law.result, law=having)))
    tried = []
    monkeypatch.setattr(refining, "may_join", lambda one, other: False)
    monkeypatch.setattr(refining, "weighed_by", lambda best, near, heard: (heard, near))
    monkeypatch.setattr(refining, "judge_each", lambda every, *given: tried.extend(every) or list(every))
    monkeypatch.setattr(refining, "refitted_of", lambda *given: [])
    assert Refining((("A", "f"), {}), ALONE)._one_more(square, replace(hearing, evaluation=evaluation)) is None
    names = {one.effects[0] for one in tried}
    assert names
    assert known.declaration.id not in names


@pytest.mark.parametrize("last", [True, False])
def test_what_passed_last_of_refined_forms_is_given(hearing, monkeypatch, last):
    square, linear, other = hearing.refitted
    plain, way, end = (
        TermFound(one.term, one.judged, hearing.bar.law, (), "", (Guard("confirmed", passed, ""),), ("stribeck",))
        for one, passed in ((other, False), (linear, False), (square, last))
    )
    forms = [(way, linear, hearing), (end, square, hearing), None]
    monkeypatch.setattr(Refining, "_one_more", lambda self, best, hearing: forms.pop(0))
    found = Refining(((), {}), ALONE).of(plain, other, hearing)
    assert not forms
    assert found.term is (square.term if last else other.term)
