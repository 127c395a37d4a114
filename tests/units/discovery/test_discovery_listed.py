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
from pipeclamp_identification.discovery.guards import Guard
from pipeclamp_identification.discovery.hearing import Hurdle
from pipeclamp_identification.discovery.listed import EffectFound, effect_instead
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
    ("verdict", "adequate", "asked"),
    [
        ("unknown", False, True),
        ("missing", False, False),
        ("complete", False, False),
        ("complete", True, False),
        ("unknown", True, False),
    ],
)
def test_an_effect_is_asked_where_something_is_missing_and_no_term_passes(tests, verdict, adequate, asked, monkeypatch):
    """Not where a diagnosis names one, nor where what is left is let pass: as form, or for the tests are too few.

    Of twelve runs that scatter by a per cent, with nothing missing, `stiffness_frequency` would have joined.
    """
    diagnosis = SimpleNamespace(law=None, is_adequate=lambda law: adequate, candidates=())
    found = SimpleNamespace(verdict=verdict, kind=None, effects=(), diagnosis=diagnosis)
    effect = EffectFound(judged("quadratic_damping", TURNS, 0.0), ())
    monkeypatch.setattr(discover, "diagnosed", lambda *given, **named: found)
    monkeypatch.setattr(discover, "_asked", lambda *given: "no term of the grammar explains more")
    monkeypatch.setattr(discover, "all_columns", lambda *given: [])
    monkeypatch.setattr(discover, "beside_another_law", lambda *given: [])
    monkeypatch.setattr(discover, "effect_instead", lambda *given: effect)
    law = identify(tests, Structure("power", ("hardening",)))
    file = law_file(law, tests, name="law", provenance=Provenance("test"))
    assert discover.search(file, tests, workers=ALONE).instead is (effect if asked else None)


@pytest.mark.parametrize(("name", "joins"), [("quadratic_damping", True), ("asymmetry", False)])
def test_an_effect_joins_as_a_part_where_it_holds_on_all_tests(tests, name, joins, monkeypatch):
    file = law_file(identify(tests), tests, name="law", provenance=Provenance("test"))
    larger = with_effect(law_of(file).structure, name)
    one = judged(name, TURNS, 0.0)
    one.result = SimpleNamespace(law=identify(tests, larger).fit.law)
    diagnosed = SimpleNamespace(comparison=SimpleNamespace(known_noise=0.01), left_over=lambda: ("it leaves 4 N",))
    asked = Guard("takes a part", True, "it takes 28 %")
    search = TermSearch(diagnosed, None, 838, REASON, instead=EffectFound(one, (asked,)))
    monkeypatch.setattr(putting, "search", lambda *given, **named: search)
    proposal = putting.discover(file, RecordTests(tests), command="test")
    answer, told = proposal.answer(), " ".join(discovery_words(proposal))
    assert not answer.proposed
    assert answer.instead == (name if joins else None)
    assert f"is proposed: {REASON}." in told
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
