"""A term is sought in the place of those effects that stood for it, whichever of the law's they are."""

from types import SimpleNamespace

import pytest

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.diagnosis.problem import judge, prepare, weighed_again
from pipeclamp_identification.discovery.bases import with_needed_back, without_last_effects
from pipeclamp_identification.discovery.discover import in_the_place_of_effects
from pipeclamp_identification.discovery.grammar import terms
from pipeclamp_identification.discovery.guards import Guard
from pipeclamp_identification.discovery.hearing import TermFound
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.base.processes import ALONE
from pipeclamp_models.law.law import Law, Structure, with_effect

BASE = {
    "k10": 1450.0, "k1_A": -0.22, "k1_T": -0.1, "k30": 250.0, "k3_A": -0.9, "k3_T": -0.1,
    "c0": 80.0, "c_A": 0.05, "c_f": -0.15, "alpha0": 0.45, "alpha_A": 0.2, "alpha_f": 0.01,
}  # fmt: skip
STOP = next(one.declaration for one in terms(("A", "f", "T"), {}) if one.declaration.id == "found_stop_positive_2")
OWN = {"F_x": 900.0, "y_x": 0.4}
WARM = {"c_T1": -0.5, "c_T2": 0.1, "c_T3": 0.0}
STANDS_FOR_IT, REAL = ("asymmetry", "end_stop"), "damping_temperature"
PLAN = Plan((0.3, 0.6, 1.0), (1.0, 4.0), (20.0, 120.0), rate=400.0, seed=4)


@pytest.fixture(scope="module", params=[True, False], ids=["one is real", "none is"])
def asked(request, tmp_path_factory):
    """A law that lacks a stop, which others stand for, and has what is real among them, and with the stop for all."""
    effects = (STANDS_FOR_IT[0], REAL, STANDS_FOR_IT[1]) if request.param else STANDS_FOR_IT
    real = tuple(name for name in effects if name == REAL)
    truth = Structure("power", (*real, STOP.id), declared=(STOP,))
    folder = tmp_path_factory.mktemp("stop") / "campaign"
    values = {**BASE, **OWN, **(WARM if real else {})}
    write_campaign(folder, virtual_runs(Law(truth, values, 0.0126, 0.002), PLAN), name="virtual", notes="")
    structure = Structure("power", effects)
    problem, first = prepare(structure, loops_of(read_campaign(folder)))
    problem, law = weighed_again(problem, structure, first, [first])
    instead = with_effect(Structure("power").with_declared([STOP]), STOP.id)
    found = judge((STOP.id,), instead, [{**instead.own(law.result.law.values), **OWN}], problem)
    return SimpleNamespace(problem=problem, law=law, effects=effects, real=real, found=found)


def test_what_is_needed_beside_a_term_comes_back(asked):
    """What stood for it was added before and after what is real: no number of last effects holds it alone."""
    back = list(with_needed_back(asked.found, asked.effects, asked.law, asked.problem, ALONE))
    first = [(one.gone, one.law.result.law.structure.effects) for one in back][:1]
    assert first == ([(STANDS_FOR_IT, (REAL,))] if asked.real else [])
    assert not {one.gone for one in back} & {one.gone for one in without_last_effects(asked.law, asked.problem)}


def test_a_term_is_sought_in_the_place_of_what_is_not_needed_beside_it(asked):
    """A stop was sought beside what is real and what stood for a part of it, or without what is real, only."""
    term = next(one for one in terms(("A", "f", "T"), {}) if one.declaration.id == STOP.id)
    places = []

    def search(basis):
        places.append(basis.gone)
        return TermFound(
            term, asked.found, asked.law, (), "", (Guard("", basis.gone == STANDS_FOR_IT, ""),), basis.gone
        )

    passed = in_the_place_of_effects(asked.law, asked.problem, search, ALONE)
    assert [one.gone for one in passed] == [STANDS_FOR_IT]
    last = [asked.effects[-count:] for count in range(1, len(asked.effects) + 1)]
    assert places == [*last, *([STANDS_FOR_IT] if asked.real else [])]
