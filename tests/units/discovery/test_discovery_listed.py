"""Where no term passes, an effect of the catalogue may that no diagnosis names: its user had been left with neither."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp.show.discovery import discovery_words
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.diagnosis.named import NO_PROOF
from pipeclamp_identification.discovery import discover, listed
from pipeclamp_identification.discovery.discover import TermSearch
from pipeclamp_identification.discovery.grammar import terms
from pipeclamp_identification.discovery.guards import Guard
from pipeclamp_identification.discovery.hearing import Hurdle, TermFound
from pipeclamp_identification.discovery.listed import EffectFound, effect_instead
from pipeclamp_identification.discovery.proposal import refused
from pipeclamp_identification.fitting.identify import identify, law_file
from pipeclamp_identification.workflow import discover as putting
from pipeclamp_identification.workflow.on_records import RecordTests
from pipeclamp_models.base.processes import ALONE
from pipeclamp_models.law.file import Provenance, law_of
from pipeclamp_models.law.law import Law, Structure, with_effect

PLAN = replace(Plan((0.3, 0.5, 0.7, 1.0), (1.0, 2.0, 4.0), (20.0,), seed=4), rate=400.0, repeats=1)
BASE = {
    "k10": 1450.0, "k1_A": -0.22, "k1_T": -0.1, "k30": 250.0, "k3_A": -0.9, "k3_T": -0.1,
    "c0": 80.0, "c_A": 0.05, "c_f": -0.15, "alpha0": 0.45, "alpha_A": 0.2, "alpha_f": 0.01,
}  # fmt: skip
GROUPS = np.repeat(np.arange(8), 4)
TURNS = np.where(GROUPS % 2, 20.0, -20.0)
REASON = "dry friction: it comes back in 20% of draws"
NOTHING = "no term of the grammar explains more"
TERM = next(iter(terms(("A", "f"), {})))
FITTED = SimpleNamespace(
    law=SimpleNamespace(values=dict.fromkeys((one.symbol for one in TERM.declaration.parameters), 1.0)),
    at_bound=(), standard_errors=dict,
)  # fmt: skip
PASSED = TermFound(
    TERM, SimpleNamespace(squares=0.0, result=FITTED), None, (), "", (Guard("asked", True, ""),)
)  # fmt: skip


@pytest.fixture(scope="module")
def tests(tmp_path_factory):
    """Tests of a clamp with quadratic damping, which the law that is asked lacks."""
    hidden = Law(Structure("power", ("quadratic_damping",)), {**BASE, "c2": 0.1}, 0.0126, 0.002)
    folder = tmp_path_factory.mktemp("listed") / "campaign"
    write_campaign(folder, virtual_runs(hidden, PLAN), name="listed", notes="")
    return read_campaign(folder)


def judged(name, squares, akaike, objections=()):
    """The law with an effect."""
    law = f"with {name}"
    return SimpleNamespace(
        effects=(name,), objections=objections, squares=float(np.sum(squares)), akaike=akaike,
        score=SimpleNamespace(squares=squares), result=SimpleNamespace(law=law),
        fitted=SimpleNamespace(residual=None, jacobian=None),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("failing", "by_chance", "expected"),
    [
        ((), 900.0, "likely"),
        (("likely",), 900.0, "best"),
        (("likely", "best", "worse"), 900.0, None),
        ((), 4000.0, None),  # what the best of all terms would explain, too
    ],
)
def test_the_likeliest_effect_that_passes_is_taken(failing, by_chance, expected, monkeypatch):
    """Not one that a bound stopped, nor one that foretells worse beyond doubt, however likely."""
    every = [
        judged("best", 100.0 + TURNS, 900.0),
        judged("likely", 102.0 - TURNS, 800.0),
        judged("worse", 150.0 + TURNS, 700.0),
        judged("stopped", 50.0 + TURNS, 600.0, ("k ran into its bound",)),
    ]
    passes = Guard("asked", True, "so much")
    monkeypatch.setattr(listed, "_takes_a_part", lambda one, diagnosis: passes)
    monkeypatch.setattr(listed, "beyond_the_tests", lambda *given: passes)
    monkeypatch.setattr(
        listed, "confirmed",
        lambda law, found, *given: replace(passes, passed=found.removeprefix("with ") not in failing),
    )  # fmt: skip
    law = judged("", 200.0 + TURNS, 2000.0)
    diagnosis = SimpleNamespace(law=law, candidates=every, problem=SimpleNamespace(groups=GROUPS))
    monkeypatch.setattr(listed, "screened_columns", lambda *given: SimpleNamespace(by_chance=lambda: by_chance))
    found = effect_instead(diagnosis, Hurdle(law, every, None, ()), diagnosis.problem, [])
    assert (found and found.name) == expected


def test_what_takes_no_part_is_not_asked_further(monkeypatch):
    """A part that rests on one level of A or f is made up between the others."""
    law, one = judged("", 200.0 + TURNS, 2000.0), judged("resonance", 100.0 + TURNS, 900.0)
    diagnosis = SimpleNamespace(law=law, candidates=[one], problem=None)
    monkeypatch.setattr(listed, "takes_part", lambda *given: True)
    monkeypatch.setattr(listed, "explained_share", lambda *given: 0.3)
    monkeypatch.setattr(listed, "rests_on", lambda *given: SimpleNamespace(condition="f"))
    assert effect_instead(diagnosis, Hurdle(law, [one], None, ()), None, []) is None


@pytest.mark.parametrize(
    ("verdict", "adequate", "heard", "asked"),
    [
        ("unknown", False, NOTHING, True),
        ("unknown", False, PASSED, True),
        ("missing", False, NOTHING, False),
        ("complete", False, NOTHING, False),
        ("complete", True, NOTHING, False),
        ("unknown", True, NOTHING, False),
    ],
)
def test_an_effect_is_asked_where_something_is_missing_that_no_diagnosis_names(
    tests, verdict, adequate, heard, asked, monkeypatch
):
    """Also where a term passes, which may not hold on all tests: ageing contacts were left with neither.

    Not where a diagnosis names one, nor where what is left is let pass: as form, or for the tests are too few.
    Of twelve runs that scatter by a per cent, with nothing missing, `stiffness_frequency` would have joined.
    """
    diagnosis = SimpleNamespace(law=None, is_adequate=lambda law: adequate, candidates=())
    found = SimpleNamespace(verdict=verdict, kind=None, effects=(), diagnosis=diagnosis)
    effect = EffectFound(judged("quadratic_damping", TURNS, 0.0), ())
    monkeypatch.setattr(discover, "diagnosed", lambda *given, **named: found)
    monkeypatch.setattr(discover, "kept_back", lambda loops, *given: np.arange(len(loops.rows)) % 5 == 2)
    monkeypatch.setattr(discover, "_asked", lambda *given: heard)
    monkeypatch.setattr(discover, "in_the_place_of_effects", lambda *given: [])
    monkeypatch.setattr(discover, "best_heard", lambda heard, problem: heard[0])
    monkeypatch.setattr(discover, "all_columns", lambda *given: [])
    monkeypatch.setattr(discover, "beside_another_law", lambda *given: [])
    monkeypatch.setattr(discover, "effect_instead", lambda *given: effect)
    law = identify(tests, Structure("power", ("hardening",)))
    file = law_file(law, tests, name="law", provenance=Provenance("test"))
    assert discover.search(file, tests, workers=ALONE).instead is (effect if asked else None)


@pytest.mark.parametrize(
    ("found", "reason"), [(None, f"{REASON}."), (PASSED, "on left-out conditions of all tests 2.00% -> 2.10%.")]
)
@pytest.mark.parametrize(("name", "joins"), [("quadratic_damping", True), ("asymmetry", False)])
def test_an_effect_joins_as_a_part_where_it_holds_on_all_tests(tests, name, joins, found, reason, monkeypatch):
    """Where no term passes, and where the law with one that does is refused on all tests."""
    file = law_file(identify(tests), tests, name="law", provenance=Provenance("test"))
    larger = with_effect(law_of(file).structure, name)
    one = judged(name, TURNS, 0.0)
    one.result = SimpleNamespace(law=identify(tests, larger).fit.law)
    diagnosed = SimpleNamespace(comparison=SimpleNamespace(known_noise=0.01), left_over=lambda: ("it leaves 4 N",))
    asked = Guard("takes a part", True, "it takes 28 %")
    search = TermSearch(diagnosed, found, 838, "" if found else REASON, instead=EffectFound(one, (asked,)))
    monkeypatch.setattr(putting, "search", lambda *given, **named: search)
    worse = Guard("on all tests", False, reason.removesuffix("."))
    monkeypatch.setattr(putting, "_put_in", lambda term, proposal, *rest: refused(proposal, worse))
    proposal = putting.discover(file, RecordTests(tests), command="test")
    answer, told = proposal.answer(), " ".join(discovery_words(proposal))
    assert not answer.proposed
    assert answer.instead == (name if joins else None)
    assert "is proposed: " in told
    assert reason in told
    if not joins:
        assert proposal.after is None
        assert answer.left_over
        return
    assert proposal.after.effects == (name,)
    assert proposal.after.history[-1].kind == "part"
    assert answer.heldout_after < 0.8 * answer.heldout_before
    assert [guard.asked for guard in answer.guards] == ["takes a part", "on all tests", "passive"]
    assert all(guard.passed for guard in answer.guards)
    assert told.startswith(f"{name} of the catalogue takes a part of what is missing")
    assert NO_PROOF[1:] in told
    assert "838 terms were tried" in told
