"""A general effect is no cause where several of its special cases do as well together: it may stand for them."""

from types import SimpleNamespace

import pytest
from few_effects import few_effects

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.diagnosis.diagnosed import diagnosed
from pipeclamp_identification.diagnosis.weighing import several
from pipeclamp_identification.diagnosis.weighing.scales import Weighed
from pipeclamp_identification.fitting.identify import identify, law_file
from pipeclamp_models.law.file import Provenance
from pipeclamp_models.law.law import Law, Structure

MOUNT = {
    "k10": 28.0, "k1_A": -0.1, "k1_T": 0.0, "k30": 1.3, "k3_A": 0.0, "k3_T": 0.0,
    "c0": 1.8, "c_A": 0.05, "c_f": -0.05, "alpha0": 0.35, "alpha_A": 0.0, "alpha_f": 0.0,
}  # fmt: skip
PLAN = Plan(
    (0.2, 0.6, 1.6), (1.0, 5.0, 12.0, 30.0), (20.0,), rate=4000.0, seed=5, force_noise=0.08, force_step=0.0
)  # fmt: skip
"""A shaker for mounts: at 30 Hz what grows with the acceleration is as large as the spring."""


@pytest.mark.parametrize(
    ("hidden", "kind", "named"),
    [
        ({"m": 6e-5, "c1": 0.02}, "part", "inertia"),
        ({"k_i": 8.0, "f_i": 9.0, "zeta_i": 0.15, "b_i": 0.02}, "cause", "inner_mass"),
    ],
)
def test_a_mass_and_a_dashpot_are_no_mass_on_a_spring(hidden, kind, named, tmp_path):
    """Of both at once `inner_mass` had been the cause, its own frequency far above the tests'."""
    effects = ("inertia", "viscous") if "m" in hidden else ("inner_mass",)
    runs = virtual_runs(Law(Structure("power", effects), {**MOUNT, **hidden}, 0.0126, 0.002), PLAN)
    write_campaign(tmp_path / "tests", runs, name="virtual", notes="")
    tests = read_campaign(tmp_path / "tests")
    with few_effects("inner_mass", "inertia", "viscous", "quadratic_damping", "relaxation"):
        found = diagnosed(law_file(identify(tests), tests, name="law", provenance=Provenance("test")), tests)
    assert (found.verdict, found.kind, found.effects) == ("missing", kind, (named,))
    told = "inertia and viscous, special cases of inner_mass, fit these tests"
    assert (told in found.diagnosis.reasons[0]) == (kind == "part")


def judged(*effects, akaike, objections=()):
    law = SimpleNamespace(structure=Structure("power", effects))
    return SimpleNamespace(
        effects=effects, akaike=akaike, objections=objections, squares=akaike, result=SimpleNamespace(law=law)
    )


def asked(monkeypatch, fits, *, near=True, effects=("oil_damper",), others=(), rivals=()):
    """Give what becomes of a cause beside special cases of it that fit so well together, by their names."""
    laws = {frozenset(names): judged(*others, *names, akaike=akaike) for names, akaike in fits.items()}
    whole = judged(*effects, akaike=100.0)
    alone = [judged(name, akaike=500.0 + place) for place, name in enumerate(("viscous", "relaxation"))]
    scales = SimpleNamespace(
        structure=Structure("power", ()), law=None, workers=None, sound=[whole, *alone],
        problem=SimpleNamespace(loops=SimpleNamespace(conditions=(), time_measured=True)),
    )  # fmt: skip
    monkeypatch.setattr(several, "in_place_of", lambda gone, come, *of: laws.get(frozenset(come)))
    monkeypatch.setattr(several, "judge_each", lambda contenders, problem, workers: contenders)
    monkeypatch.setattr(several, "rivals_of", lambda best, asked, problem: asked if near else [])
    monkeypatch.setattr(several, "explained_share", lambda one, law: 0.5)
    monkeypatch.setattr(several, "first_of_pairs", lambda likely, sound, scales: [likely[0].effects[len(others)]])
    monkeypatch.setattr(several, "helps_alone", lambda name, sound, law: name in ("viscous", "relaxation"))
    together = whole if effects[1:] else None
    verdict = "ambiguous" if rivals else "missing"
    found = Weighed(verdict, (*effects[:1], *rivals), "cause", whole, together, ("it explains it",))
    return found, several.unless_several_do(found, scales)


TWO, THREE = ("viscous", "relaxation"), ("viscous", "quadratic_damping", "relaxation")


@pytest.mark.parametrize(
    ("fits", "near", "kind", "named"),
    [
        ({TWO: 104.0}, True, "part", "oil_damper"),  # they leave about as little
        ({TWO: 90.0}, True, "part", "viscous"),  # and the fit prefers them
        ({TWO: 200.0}, False, "cause", "oil_damper"),  # they come nowhere near
        ({}, True, "cause", "oil_damper"),  # they don't fit into the law
    ],
)
def test_a_general_effect_beside_several_special_cases(fits, near, kind, named, monkeypatch):
    found, then = asked(monkeypatch, fits, near=near)
    assert (then.kind, then.effects) == (kind, (named,))
    assert (then is found) == (kind == "cause")


def test_fewer_special_cases_go_before_more_that_fit_hardly_better(monkeypatch):
    """A third one that is not there takes some of the noise."""
    assert asked(monkeypatch, {TWO: 92.0, THREE: 90.0})[1].pair.effects == TWO
    assert asked(monkeypatch, {TWO: 192.0, THREE: 90.0})[1].pair.effects == THREE


def test_special_cases_of_one_of_two_stand_beside_the_other(monkeypatch):
    _, then = asked(monkeypatch, {TWO: 104.0}, effects=("oil_damper", "offset"), others=("offset",))
    assert (then.kind, then.effects) == ("part", ("oil_damper",))
    assert then.reasons[-1].startswith("viscous and relaxation, special cases of oil_damper, leave about as little")


def test_what_rivals_a_general_effect_stays_named_beside_it(monkeypatch):
    _, then = asked(monkeypatch, {TWO: 90.0}, rivals=("stribeck",))
    assert (then.verdict, then.kind, then.effects) == ("ambiguous", "part", ("oil_damper", "stribeck"))
