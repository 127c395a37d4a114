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
from pipeclamp_identification.discovery.hearing import Hearing, RefittedTerm
from pipeclamp_identification.fitting.identify import identify, law_file
from pipeclamp_models.base.processes import ALONE
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import Provenance, law_of
from pipeclamp_models.law.law import Structure

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
    monkeypatch.setattr(discover, "_asked", nothing)
    monkeypatch.setattr(discover, "all_columns", lambda *given: [])
    monkeypatch.setattr(discover, "beside_another_law", lambda *given: [])
    file = law_file(identify(tests, Structure("power", effects)), tests, name="law", provenance=Provenance("complete"))
    result = discover.search(file, tests, workers=ALONE)
    assert asked == places
    assert result.found is None
    assert result.reason.startswith("nothing is missing") == leaves_scatter
    assert ("in the place of its effects" in result.reason) == (leaves_scatter and bool(effects))


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
