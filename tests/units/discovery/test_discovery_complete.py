"""A law that leaves scatter only may owe this to several effects that stand for one term."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.discovery import discover
from pipeclamp_identification.discovery.columns import TermColumn
from pipeclamp_identification.discovery.grammar import terms
from pipeclamp_identification.discovery.guards import Guard
from pipeclamp_identification.discovery.hearing import Hearing, RefittedTerm, TermFound
from pipeclamp_identification.fitting.identify import identify, law_file
from pipeclamp_identification.workflow import discover as putting
from pipeclamp_identification.workflow.on_records import RecordTests
from pipeclamp_models.base.processes import ALONE
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import Provenance, law_of
from pipeclamp_models.law.law import Structure
from pipeclamp_models.law.step import BeforeAfter

PLAN = replace(Plan((0.3, 0.6, 1.0), (1.0, 4.0), (20.0,), seed=4), rate=400.0, repeats=1)
PARTS = ("hardening", "asymmetry")


@pytest.fixture(scope="module")
def tests(tmp_path_factory):
    folder = tmp_path_factory.mktemp("complete") / "campaign"
    write_campaign(folder, virtual_runs(law_of(open_law("emwm2")), PLAN), name="complete", notes="")
    return read_campaign(folder)


@pytest.mark.parametrize(
    ("effects", "leaves_scatter", "places"),
    [
        ((), True, []),
        (PARTS[:1], True, []),  # a term of the form that the effect has had taken its place, and foretold no better
        (PARTS, True, [PARTS[1:], PARTS]),  # called complete, it had been left alone
        (PARTS, False, [(), PARTS[1:], PARTS]),  # complete but for its form
    ],
)
def test_of_a_complete_law_a_term_is_sought_in_the_place_of_its_effects(
    tests, effects, leaves_scatter, places, monkeypatch
):
    diagnosis = SimpleNamespace(law=None, is_adequate=lambda law: leaves_scatter, candidates=())
    found = SimpleNamespace(verdict="complete", kind=None, effects=(), diagnosis=diagnosis)
    asked = []

    def nothing(evaluation, columns, gone, bar, workers):
        asked.append(gone)
        return "no term of the grammar could be fitted together with the law"

    monkeypatch.setattr(discover, "diagnosed", lambda *given, **named: found)
    monkeypatch.setattr(discover, "kept_back", lambda loops, *given: np.arange(len(loops.rows)) % 5 == 2)
    monkeypatch.setattr(discover, "_asked", nothing)
    monkeypatch.setattr(discover, "all_columns", lambda *given: [])
    monkeypatch.setattr(discover, "beside_another_law", lambda *given: [])
    file = law_file(identify(tests, Structure("power", effects)), tests, name="law", provenance=Provenance("complete"))
    result = discover.search(file, tests, workers=ALONE)
    assert asked == places
    assert result.found is None
    assert result.reason.startswith("nothing is missing") == leaves_scatter
    assert ("in the place of its effects" in result.reason) == (leaves_scatter and len(effects) > 1)


@pytest.mark.parametrize(
    ("causes", "passes", "asked", "reason"),
    [
        (("memory",), True, 0, "the catalogue has what is missing: memory; `add` it first"),
        (("asymmetry", "pressed_slip"), False, 1, "these tests can't tell which: asymmetry, pressed_slip"),
        (("asymmetry", "pressed_slip"), True, 1, ""),  # it had not been looked for
    ],
)
def test_where_tests_tell_no_cause_from_another_a_term_may_better_both(
    tests, causes, passes, asked, reason, monkeypatch
):
    """Of bumpers on both sides two effects might have been the cause, and neither came near."""
    diagnosis = SimpleNamespace(law=None, is_adequate=lambda law: False, candidates=())
    named = SimpleNamespace(verdict="ambiguous", kind="cause", effects=causes, diagnosis=diagnosis)
    term = next(iter(terms(("A", "f"), {})))
    found = TermFound(term, SimpleNamespace(squares=1.0), None, (), "", (Guard("asked", passes, "too little"),))
    counted = []
    monkeypatch.setattr(discover, "diagnosed", lambda *given, **named_too: named)
    monkeypatch.setattr(discover, "kept_back", lambda loops, *given: np.arange(len(loops.rows)) % 5 == 2)
    monkeypatch.setattr(discover, "_asked", lambda *given: counted.append(1) or found)
    monkeypatch.setattr(discover, "all_columns", lambda *given: [])
    monkeypatch.setattr(discover, "best_heard", lambda heard, problem: heard[0])
    file = law_file(identify(tests, Structure("power")), tests, name="law", provenance=Provenance("several"))
    result = discover.search(file, tests, workers=ALONE)
    assert len(counted) == asked
    assert reason in result.reason
    assert bool(result.reason) == bool(reason)
    assert (result.found is found) == (passes and bool(asked))


@pytest.mark.parametrize(("leaves_scatter", "asked"), [(True, 0), (False, 1)])
def test_a_part_with_which_only_scatter_is_left_comes_before_any_term(tests, leaves_scatter, asked, monkeypatch):
    """A stop that is rounder than the catalogue's was given as a spring, beside which nothing is left either."""
    with_it, law = SimpleNamespace(effects=("end_stop",)), SimpleNamespace(effects=())
    diagnosis = SimpleNamespace(
        law=law, is_adequate=lambda judged: judged is with_it and leaves_scatter, candidates=(with_it,)
    )
    named = SimpleNamespace(verdict="missing", kind="part", effects=("end_stop",), diagnosis=diagnosis)
    searched = []
    monkeypatch.setattr(discover, "diagnosed", lambda *given, **named_too: named)
    monkeypatch.setattr(discover, "kept_back", lambda loops, *given: np.arange(len(loops.rows)) % 5 == 2)
    monkeypatch.setattr(discover, "judge", lambda *given: SimpleNamespace())
    monkeypatch.setattr(discover, "_weighed", lambda *given: (SimpleNamespace(loops=None), law))
    monkeypatch.setattr(discover, "terms_asked", lambda problem: [])
    monkeypatch.setattr(discover, "to_better", lambda *given: [])
    monkeypatch.setattr(discover, "Evaluation", lambda *given: None)
    monkeypatch.setattr(discover, "all_columns", lambda *given: [])
    monkeypatch.setattr(discover, "_asked", lambda *given: searched.append(1) or "none")
    monkeypatch.setattr(discover, "in_the_place_of_effects", lambda *given: [])
    file = law_file(identify(tests, Structure("power")), tests, name="law", provenance=Provenance("part"))
    result = discover.search(file, tests, workers=ALONE)
    assert len(searched) == asked
    assert ("end_stop; `add` it first" in result.reason) == leaves_scatter


def test_a_term_must_better_every_effect_that_may_be_the_cause():
    candidates = [SimpleNamespace(effects=(name,)) for name in ("a", "b", "c", "d", "e", "f")]
    asked = discover.to_better(candidates, {"b"}, ("a", "f"))
    assert [one.effects for one in asked] == [("a",), ("c",), ("d",), ("f",)]


def test_a_term_with_something_added_comes_back_as_the_term():
    """A form that only adds to the best one had counted against it in draws of the conditions."""
    by_id = {term.declaration.id: term for term in terms(("A", "f"), {})}
    random = np.random.default_rng(3)
    names = ("found_smooth_slip_by_f", "found_smooth_slip_off_middle_by_f", "found_bent_slip_3_by_f")
    changes = random.standard_normal((3, 12, 5))
    refitted = [
        RefittedTerm(SimpleNamespace(), by_id[name], TermColumn(by_id[name], {}, change, True))
        for name, change in zip(names, changes, strict=True)
    ]
    law = SimpleNamespace(fitted=SimpleNamespace(residual=changes[0], jacobian=random.standard_normal((12, 5, 2))))
    evaluation = SimpleNamespace(law=law, problem=SimpleNamespace(groups=np.repeat(np.arange(4), 3)))
    hearing = Hearing(evaluation, [], refitted, None)
    assert hearing.alike(0).tolist() == [True, True, False]
    assert hearing.alike(1).tolist() == [False, True, False]


@pytest.mark.parametrize(("holding", "proposed"), [("beside", "beside"), ("", "instead"), ("instead", "instead")])
def test_where_the_best_term_does_not_hold_on_all_tests_the_next_is_put_in(tests, holding, proposed, monkeypatch):
    """A term in the place of an effect may foretell all tests worse; a search had ended there."""
    term = next(iter(terms(("A", "f"), {})))
    best, next_best = (
        TermFound(term, None, None, (), "", (Guard("asked", True, ""),), gone) for gone in (("instead",), ("beside",))
    )
    compared = SimpleNamespace(comparison=SimpleNamespace(known_noise=None))
    found = discover.TermSearch(compared, best, 9, "", (next_best,))
    monkeypatch.setattr(putting, "search", lambda *given, **named: found)
    monkeypatch.setattr(
        putting, "_put_in",
        lambda one, proposal, *rest: replace(proposal, declaration="put in" if one.gone == (holding,) else None),
    )  # fmt: skip
    monkeypatch.setattr(putting, "with_powers_back", lambda *given, **named: None)
    result = putting.discover(SimpleNamespace(date=None), RecordTests(tests), command="")
    assert result.found.gone == (proposed,)
    assert result.proposed == bool(holding)


@pytest.mark.parametrize(
    ("after", "beside", "gone", "passes", "told"),
    [
        (0.1540, True, 0, False, "less than 5% of what is missing there"),
        (0.1496, True, 0, True, ""),
        (0.1540, False, 2, True, ""),
        (0.1560, True, 0, False, ""),
        (0.1560, False, 2, True, "as well with fewer parameters"),
        (0.1560, False, 0, False, ""),  # as many
        (0.1600, False, 2, False, ""),
    ],
)
def test_a_term_beside_a_law_takes_a_material_part_on_all_tests(after, beside, gone, passes, told):
    """Of a measured device a slip force that follows the frequency was proposed for 15.51 to 15.40 %.

    One in the place of two effects had been refused where the error rose by a hundredth of itself.
    """
    before, law = (SimpleNamespace(coefficients=dict.fromkeys(range(count))) for count in (16, 16 - gone))
    change = SimpleNamespace(
        heldout=BeforeAfter(0.1551, after), nrmse=BeforeAfter(0.15, 0.15), noise_nrmse=0.0475, before=before, after=law
    )
    guard = putting._on_all_tests(change, beside=beside)
    assert guard.passed is passes
    assert (told in guard.words) if told else guard.words.endswith(f"{after:.2%}")


@pytest.mark.parametrize("turned", [1, -1])
def test_what_is_kept_back_are_groups_on_which_a_law_errs_as_on_the_others(turned):
    """By number they were two of a grease's twelve groups on which the law erred by less than a thirtieth of it all."""
    amplitudes, frequencies = (0.2, 0.5, 0.8, 1.0), (1.0, 3.0, 5.0)
    points = [(a, f) for a in amplitudes for f in frequencies for _ in range(2)]
    runs = np.array([f"r{number:02d}" for number in range(len(points))])
    errors = np.array([3781, 679, 152, 213, 49, 404, 256, 57, 158, 280, 227, 218])
    amplitude, frequency = np.array(points).T
    nowhere = np.zeros(len(points))
    loops = SimpleNamespace(
        run=runs, amplitude_mm=amplitude, frequency_Hz=frequency, temperature_K=nowhere, density_g_cm3=nowhere,
        conditions={},
    )  # fmt: skip
    # the law was judged on the runs in another order, the first one in two parts
    judged_on = np.r_[runs, runs[:1]][::turned]
    squares = np.r_[np.repeat(errors / 2, 2), 0.0][::turned]
    law = SimpleNamespace(score=SimpleNamespace(squares=squares))
    problem = SimpleNamespace(loops=SimpleNamespace(run=judged_on))
    kept = discover.kept_back(loops, SimpleNamespace(law=law, problem=problem))
    assert sorted({points[place] for place in np.flatnonzero(kept)}) == [(0.5, 1.0), (0.5, 5.0)]
    assert kept.sum() == 4
