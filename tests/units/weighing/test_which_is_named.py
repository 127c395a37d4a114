"""Which of several candidates is named: no general one without need, nor what only mends a form."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp_identification.diagnosis.open_means import OpenMeans, with_means_counted
from pipeclamp_identification.diagnosis.problem import Judged
from pipeclamp_identification.diagnosis.run_scatter import RunScatter
from pipeclamp_identification.diagnosis.weighing import causes, parts, reasons, scales
from pipeclamp_identification.diagnosis.weighing import weigh as verdicts
from pipeclamp_identification.diagnosis.weighing.channel import BentChannel
from pipeclamp_identification.diagnosis.weighing.parts import one_part
from pipeclamp_identification.diagnosis.weighing.scales import Scales
from pipeclamp_identification.diagnosis.weighing.special_cases import simpler_words
from pipeclamp_identification.diagnosis.weighing.tolerance import Tolerance
from pipeclamp_identification.diagnosis.weighing.weigh import weigh
from pipeclamp_models.base.processes import Workers
from pipeclamp_models.law.law import Structure


def candidate(effect, left, squares, structure="power"):
    """Give a law with an effect that leaves these mean squares on left-out conditions."""
    law = SimpleNamespace(structure=Structure(structure, (effect,) if effect else ()))
    score = SimpleNamespace(mean_squares=np.full(6, left), axes=None)
    return SimpleNamespace(
        effects=(effect,), result=SimpleNamespace(law=law, equations=NAMES, fitted_parameters=()), score=score,
        missing=6 * left,
        squares=squares, akaike=squares, heldout_by={}, objections=(), may_be_cause=True,
        lack=SimpleNamespace(p_value=0.0, share=9.0, sure_share=9.0),
    )  # fmt: skip


def stand_in(monkeypatch, name, function):
    """Put a function in the place of another wherever a verdict is weighed."""
    for room in (scales, causes, parts, reasons, verdicts):
        if hasattr(room, name):
            monkeypatch.setattr(room, name, function)


TOLERANCE = Tolerance(0.1, 0.1, 0.75)


TESTS, NAMES = SimpleNamespace(loops=None), SimpleNamespace(names=())


def on_scales(law, candidates, problem=TESTS, tolerance=TOLERANCE):
    return Scales(law.result.law.structure, problem, law, candidates, tolerance, Workers(1, print))


def weighed(law, candidates, problem=TESTS, tolerance=TOLERANCE):
    return weigh(on_scales(law, candidates, problem, tolerance))


@pytest.fixture(autouse=True)
def straight(monkeypatch):
    """The force channel is straight, but where a test bends it."""
    stand_in(monkeypatch, "bent_channel", lambda problem, law: None)


def usable(*candidates):
    law = candidate("", 100.0, 1000.0)
    return [each.effects[0] for each in on_scales(law, candidates).usable]


@pytest.mark.parametrize(("general", "special"), [("inner_mass", "inertia"), ("gas_spring", "asymmetry")])
@pytest.mark.parametrize(("left", "named"), [(7.0, False), (3.0, True)])
def test_beside_its_special_case(general, special, left, named):
    found = usable(candidate(general, left, 90.0), candidate(special, 8.0, 100.0))
    assert found == ([general, special] if named else [special])
    law, *both = candidate("", 100.0, 1000.0), candidate(general, left, 90.0), candidate(special, 8.0, 100.0)
    said = [simpler_words(each, both, law, TOLERANCE) for each in both]
    assert said == [[] if named else [f"{special}, a special case of it, leaves about as little"], []]


@pytest.mark.parametrize(("squares", "named"), [(800.0, True), (400.0, False)])
def test_a_special_case_must_take_half_in_units_of_the_noise_too(squares, named):
    """Of a weak pressed_slip scatter hid in N that displacement_friction took a third of it."""
    found = usable(candidate("pressed_slip", 7.0, 90.0), candidate("displacement_friction", 8.0, squares))
    assert ("pressed_slip" in found) == named


@pytest.mark.parametrize(("special_left", "told"), [(100.0, False), (85.0, True)])
def test_what_takes_nothing_is_no_special_case_that_leaves_as_little(special_left, told):
    """Of a wire rope `memory`, no help by the same table, "left about as little" as a `slip_spread` that took 21 %."""
    law = candidate("", 100.0, 1000.0)
    general, special = candidate("slip_spread", 79.0, 1010.0), candidate("memory", special_left, 1005.0)
    general.akaike = special.akaike = 900.0  # the fit to all tests prefers them, left-out conditions in noise don't
    assert bool(simpler_words(general, [general, special], law, TOLERANCE)) == told


@pytest.mark.parametrize(("left", "named"), [(8.0, True), (7.0, False)])
def test_a_special_case_that_takes_as_much_is_named_though_neither_explains_all(left, named):
    """An oil damper, its valve open for ever, had been the cause of a rubber mount's relaxation."""
    general, special = candidate("oil_damper", 7.0, 90.0), candidate("relaxation", left, 100.0)
    general.lack, special.lack = (SimpleNamespace(p_value=0.0, share=left, sure_share=left) for left in (0.7, 0.8))
    law = candidate("", 100.0, 1000.0)
    assert ("oil_damper" in [each.effects[0] for each in on_scales(law, (general, special)).usable]) == named


@pytest.mark.parametrize(("left", "named"), [(0.16, True), (0.05, False)])
def test_a_special_case_that_leaves_something_gives_way_to_what_explains(left, named):
    """A weak gas spring had been passed over for an asymmetry that left more, and another effect was the cause."""
    general, special = candidate("gas_spring", 7.0, 90.0), candidate("asymmetry", 8.0, 100.0)
    general.lack = SimpleNamespace(p_value=0.5, share=0.02, sure_share=0.0)
    special.lack = SimpleNamespace(p_value=0.0, share=left, sure_share=left)
    law = candidate("", 100.0, 1000.0)
    law.lack = SimpleNamespace(p_value=0.0, share=0.38, sure_share=0.37)
    assert ("gas_spring" in [each.effects[0] for each in on_scales(law, (general, special)).usable]) == named


def test_beside_what_it_only_acts_like():
    """Of those the better one is named, or both where the data can't tell."""
    assert usable(candidate("gap", 7.0, 90.0), candidate("play", 8.0, 100.0)) == ["gap", "play"]


@pytest.mark.parametrize(("near", "kind"), [(True, "cause"), (False, "part")])
def test_what_explains_is_named_though_squares_prefer_what_mends_a_form(near, kind, monkeypatch):
    """Squares are in units of the noise: a form that is off in quiet harmonics can weigh more there than in N.

    Where they prefer it beyond doubt, what explains hasn't the exact form: an amplifier that gives less on one side
    had been called asymmetry.
    """
    hardening, gap = candidate("hardening", 96.0, 80.0), candidate("gap", 10.0, 90.0)
    for each, share in ((hardening, 1.6), (gap, 0.3)):
        each.lack = SimpleNamespace(p_value=0.0, share=share, sure_share=share)
    law = candidate("", 100.0, 100.0)
    law.lack = SimpleNamespace(p_value=0.0, share=1.7, sure_share=1.6)
    others = (hardening, gap)
    stand_in(monkeypatch, "rivals_of", lambda best, asked, problem: [one for one in asked if near and one in others])
    found = weighed(law, [hardening, gap])
    assert (found.verdict, found.kind, found.effects) == ("missing", kind, ("gap",))
    assert ("hardening, which leaves more in N, fits the weak harmonics clearly better" in found.reasons[0]) != near


@pytest.mark.parametrize(
    ("akaike", "expected"),
    [(80.0, ("unknown", None, ())), (95.0, ("missing", "part", ("gap",))), (120.0, ("missing", "cause", ("gap",)))],
)
def test_a_bent_channel_is_a_rival_of_every_effect(akaike, expected, monkeypatch):
    gap, law = candidate("gap", 8.0, 100.0), candidate("", 100.0, 1000.0)
    gap.lack = SimpleNamespace(p_value=0.5, share=0.0, sure_share=0.0)
    stand_in(monkeypatch, "rivals_of", lambda best, others, problem: [])
    stand_in(monkeypatch, "bent_channel", lambda problem, law: BentChannel(200.0, -0.013, 1, 0.97, akaike))
    found = weighed(law, [gap])
    assert (found.verdict, found.kind, found.effects) == expected
    words = "a force channel that gives 1.30% less of what lies beyond 200 N, in the positive direction, takes 97% of"
    assert (words in found.reasons[-1]) == (akaike < 110.0)


@pytest.mark.parametrize(("near", "named"), [(True, ()), (False, ("stiffness_frequency",))])
def test_what_does_no_better_than_the_law_as_it_is_explains_nothing(near, named, monkeypatch):
    """Hum of the mains left something that follows the conditions, and one effect of forty left less by chance."""
    effect, law = candidate("stiffness_frequency", 90.0, 98.0), candidate("", 100.0, 100.0)
    effect.lack = SimpleNamespace(p_value=0.5, share=0.0, sure_share=0.0)
    law.lack = SimpleNamespace(p_value=0.0, share=0.23, sure_share=0.0, rms=1.0)
    effect.heldout_by = law.heldout_by = {"A, f": 0.02}
    stand_in(monkeypatch, "rivals_of", lambda best, others, problem: list(others) if near else [])
    stand_in(monkeypatch, "screened", lambda *of: [])
    stand_in(monkeypatch, "pairs", lambda *of: [])
    stand_in(monkeypatch, "takes_part", lambda candidate, law, problem: False)
    found = weighed(law, [effect])
    assert found.effects == named


@pytest.mark.parametrize(
    ("left", "chance", "named"), [(0.41, 0.0, ()), (0.2, 0.0, ("gas_spring",)), (0.41, 0.5, ("gas_spring",))]
)
def test_of_what_may_be_form_an_effect_takes_half_of_the_fit_to_all_tests(left, chance, named, monkeypatch):
    """Of three rough effects, all in the law, a fourth left 0.41 times the noise of 0.43, and of next to nothing half.

    That is on left-out conditions, where the law erred by 1 % less with it: so it took a part.
    """
    effect, law = candidate("gas_spring", 99.0, 80.0), candidate("memory", 100.0, 1000.0)
    law.missing = 12.0  # of 600
    effect.lack = SimpleNamespace(p_value=chance, share=left, sure_share=0.08)
    law.lack = SimpleNamespace(p_value=0.0, share=0.43, sure_share=0.12, most_share=0.5)
    stand_in(monkeypatch, "rivals_of", lambda best, others, problem: [])
    stand_in(monkeypatch, "_form_at_most", lambda scales: verdicts.nothing_named("complete", "form"))
    found = weighed(law, [effect], tolerance=Tolerance(0.1, 0.56, 0.75))
    assert found.effects == named


@pytest.mark.parametrize("rivals", [1, 2])
def test_of_rivals_and_a_general_effect_that_fits_clearly_better_all_are_named(rivals, monkeypatch):
    """An asymmetry and another effect came as near each other as a gas spring was ahead of both.

    And of a relaxation that spreads the relaxation alone had been named, with the other in the reason.
    """
    general, special = candidate("gas_spring", 7.0, 70.0), candidate("asymmetry", 8.0, 100.0)
    rival, law = candidate("directional_damping", 8.0, 101.0), candidate("", 100.0, 1000.0)
    for each in (general, special, rival):
        each.lack = SimpleNamespace(p_value=0.5, share=0.0, sure_share=0.0)
    law.lack = SimpleNamespace(p_value=0.0, share=9.0, sure_share=9.0)
    alike = (special, rival)
    stand_in(
        monkeypatch, "rivals_of", lambda best, asked, problem: [one for one in asked if best in alike and one in alike]
    )
    others = [special, rival][:rivals]
    found = weighed(law, [general, *others])
    assert (found.verdict, found.kind) == ("ambiguous", "part")
    assert found.effects == ("gas_spring", "asymmetry", "directional_damping")[: 1 + rivals]


@pytest.mark.parametrize(
    ("chance", "of_rival", "named"),
    [
        (0.5, 0.0, ("gas_spring", "asymmetry")),
        (0.5, 0.5, ("gas_spring", "asymmetry", "directional_damping")),
        (0.0, 0.0, ("directional_damping", "asymmetry")),
    ],
)
def test_rivals_by_a_form_that_none_has_give_way_to_a_general_effect_that_has_it(chance, of_rival, named, monkeypatch):
    """A gas spring left scatter alone, far likelier than any other, and was the fourth of five not to be told apart."""
    general, special = candidate("gas_spring", 7.0, 70.0), candidate("asymmetry", 8.0, 101.0)
    rival, law = candidate("directional_damping", 8.0, 100.0), candidate("", 100.0, 1000.0)
    for each, p_value in ((general, chance), (special, 0.0), (rival, of_rival)):
        each.lack = SimpleNamespace(p_value=p_value, share=0.05, sure_share=0.05)
    alike = (special, rival)
    stand_in(
        monkeypatch, "rivals_of", lambda best, asked, problem: [one for one in asked if best in alike and one in alike]
    )
    found = causes.one_cause(rival, [rival, special], on_scales(law, [general, rival, special]))
    assert (found.verdict, found.effects) == ("ambiguous", named)


@pytest.mark.parametrize(
    ("leaves", "near", "verdict", "named"),
    [
        (0.34, False, "missing", ("inner_mass",)),
        (0.05, False, "ambiguous", ("inner_mass", "relaxation")),
        (0.34, True, "ambiguous", ("inner_mass", "relaxation")),
    ],
)
def test_a_general_effect_is_named_alone_where_its_special_case_surely_leaves_something(
    leaves, near, verdict, named, monkeypatch
):
    """What a rough asymmetry left, scatter may have made; what relaxation left beside a mass inside, it can't have."""
    general, special, law = (
        candidate(*of) for of in (("inner_mass", 7.0, 70.0), ("relaxation", 8.0, 99.0), ("", 100.0, 1e3))
    )
    other = candidate("oil_damper", 7.0, 75.0)
    for each, p_value, share in ((general, 0.9, 0.0), (special, 0.08, leaves), (other, 0.9, 0.0)):
        each.lack = SimpleNamespace(p_value=p_value, share=share, sure_share=share)
    stand_in(
        monkeypatch,
        "rivals_of",
        lambda best, asked, problem: [one for one in asked if near and best is general and one is other],
    )
    found = causes.one_cause(special, [special], on_scales(law, [general, other, special]))
    assert (found.verdict, found.kind, found.effects) == (verdict, "part", named)


@pytest.mark.parametrize(
    ("general", "special", "near", "named"),
    [
        ("relaxation_spread", "relaxation", False, ("relaxation_spread",)),
        ("relaxation_spread", "relaxation", True, ("relaxation_spread", "relaxation")),
        ("rounded_friction", "coulomb", False, ("rounded_friction",)),
        ("rounded_friction", "viscous", False, ("rounded_friction", "viscous")),
    ],
)
def test_what_is_many_of_a_special_case_and_fits_clearly_better_is_named_alone(
    general, special, near, named, monkeypatch
):
    """Two relaxation times had been one or a spread of them, and the ladder ended there; but for another near it."""
    many, one, law = (candidate(*of) for of in ((general, 7.0, 70.0), (special, 8.0, 99.0), ("", 100.0, 1e3)))
    other = candidate("oil_damper", 7.0, 75.0)
    for each, p_value in ((many, 0.9), (one, 0.08), (other, 0.9)):
        each.lack = SimpleNamespace(p_value=p_value, share=0.05, sure_share=0.0)
    stand_in(
        monkeypatch,
        "rivals_of",
        lambda best, asked, problem: [each for each in asked if near and best is many and each is other],
    )
    found = causes.one_cause(one, [one], on_scales(law, [many, other, one]))
    assert (found.verdict, found.kind, found.effects) == ("missing" if not named[1:] else "ambiguous", "part", named)


@pytest.mark.parametrize(
    ("leaves", "verdict", "named"),
    [(0.48, "missing", ("directional_slip",)), (0.24, "ambiguous", ("slip_lock", "directional_slip"))],
)
def test_a_general_effect_that_takes_of_a_form_that_neither_has_must_leave_less_in_newtons(
    leaves, verdict, named, monkeypatch
):
    """Two slips, one early and one late, had been `slip_lock` or `directional_slip`, and the former left more."""
    general, special, law = (
        candidate(*of) for of in (("slip_lock", 7.0, 70.0), ("directional_slip", 8.0, 99.0), ("", 100.0, 1e3))
    )
    for each, share in ((general, leaves), (special, 0.34), (law, 9.0)):
        each.lack = SimpleNamespace(p_value=0.0, share=share, sure_share=share)
    stand_in(monkeypatch, "rivals_of", lambda best, asked, problem: asked if best is special else [])
    found = causes.one_cause(special, [special], on_scales(law, [general, special]))
    assert (found.verdict, found.kind, found.effects) == (verdict, "part", named)
    assert ("slip_lock, which leaves more in N, fits the weak harmonics clearly better" in found.reasons[0]) == (
        verdict == "missing"
    )


def test_where_a_special_case_has_rivals_its_general_effect_is_one_too(monkeypatch):
    """Of a weak gas spring, first of all, an asymmetry and another effect had been named, and it not."""
    general, special = candidate("gas_spring", 7.0, 90.0), candidate("asymmetry", 8.0, 100.0)
    rival, law = candidate("directional_damping", 8.0, 91.0), candidate("", 100.0, 1000.0)
    for each in (general, special, rival):
        each.lack = SimpleNamespace(p_value=0.5, share=0.0, sure_share=0.0)
    law.lack = SimpleNamespace(p_value=0.0, share=9.0, sure_share=9.0)
    stand_in(monkeypatch, "rivals_of", lambda best, asked, problem: [one for one in asked if one not in (best, law)])
    found = weighed(law, [general, special, rival])
    assert (found.verdict, found.kind) == ("ambiguous", "cause")
    assert sorted(found.effects) == ["asymmetry", "directional_damping", "gas_spring"]


@pytest.mark.parametrize(("left", "names"), [(0.31, ("end_stop", "gap")), (0.5, ("end_stop",))])
def test_what_leaves_as_much_of_a_form_as_the_best_is_a_rival(left, names, monkeypatch):
    """A gap with round corners was called an end stop: neither had the form, and squares preferred the one by that."""
    best, other, law = candidate("end_stop", 6.0, 80.0), candidate("gap", 6.2, 95.0), candidate("", 100.0, 1000.0)
    for each, share in ((best, 0.3), (other, left), (law, 2.5)):
        each.lack = SimpleNamespace(p_value=0.0, share=share, sure_share=share)
    stand_in(monkeypatch, "rivals_of", lambda best, asked, problem: [])
    found = weighed(law, [best, other])
    assert (found.kind if names[1:] else "cause", found.effects) == ("cause", names)


@pytest.mark.parametrize(
    ("leaves", "other_takes", "kind", "told"),
    [
        (0.3, 0.90, "cause", "self_centring explains it and no rival comes near"),
        (0.3, 0.98, "part", "hardening, which fits the weak harmonics worse, takes more of it in N"),
        (0.67, 0.90, "part", "0.67 times the noise still follows the conditions"),
    ],
)
def test_no_cause_is_named_whose_form_does_not_fit(leaves, other_takes, kind, told, monkeypatch):
    """A spring that is steeper in the middle had been called self_centring, as the cause: 0.67 times the noise left."""
    best, law = candidate("self_centring", 6.0, 80.0), candidate("", 100.0, 1000.0)
    other = candidate("hardening", 100.0 * (1 - other_takes), 95.0)
    for each, share in ((best, leaves), (other, 1.5), (law, 2.5)):
        each.lack = SimpleNamespace(p_value=0.0, share=share, sure_share=share)
    stand_in(monkeypatch, "rivals_of", lambda one, asked, problem: asked if one is other else [])
    found = weighed(law, [best, other])
    assert (found.verdict, found.kind, found.effects) == ("missing", kind, ("self_centring",))
    assert told in found.reasons[0]


@pytest.mark.parametrize(
    ("left", "likelier", "part", "named"),
    [
        (14.0, True, True, "bouc_wen"),
        (14.0, False, True, "slip_lock"),
        (14.0, True, False, "slip_lock"),
        (17.0, True, True, "slip_lock"),
    ],
)
def test_where_neither_has_the_exact_form_the_fit_says_which_takes_the_part(left, likelier, part, named, monkeypatch):
    """A rough bouc_wen left 0.57 times the noise and was passed over for a slip_lock, 350 less likely, that left 0.48.

    And a viscous damper, better by each measure of left-out conditions and of the fit, for a dry friction.
    """
    best, other, law = (
        candidate(*of) for of in (("slip_lock", 11.0, 90.0), ("bouc_wen", left, 50.0), ("", 100.0, 999.0))
    )
    other.akaike = 50.0 if likelier else 95.0
    for each, share in ((best, 0.46), (other, 0.57), (law, 1.57)):
        each.lack = SimpleNamespace(p_value=0.0, share=share, sure_share=share)
    stand_in(monkeypatch, "rivals_of", lambda one, asked, problem: asked if one is best and other in asked else [])
    stand_in(monkeypatch, "takes_part", lambda candidate, law, problem: part)
    stand_in(monkeypatch, "rests_on", lambda *of: None)
    found = weighed(law, [other, best])
    assert (found.verdict, found.kind, found.effects) == ("missing", "part", (named,))
    assert found.named.effects == (named,)
    words = (
        "bouc_wen takes 86% of what is missing" if named == "bouc_wen" else "slip_lock leaves little over, but bouc_wen"
    )
    assert found.reasons[0].startswith(words) and found.reasons[0].endswith("neither has the exact form")


@pytest.mark.parametrize(("left", "kind"), [(45.0, "cause"), (55.0, "part")])
def test_no_cause_is_named_that_does_not_foretell_half_of_what_is_missing(left, kind, monkeypatch):
    """Four runs of a measured structural member were fitted by `memory`, which foretold 48 % of what was missing."""
    best, law = candidate("memory", left, 80.0), candidate("", 100.0, 1000.0)
    best.lack = SimpleNamespace(p_value=0.5, share=0.2, sure_share=0.0)
    stand_in(monkeypatch, "rivals_of", lambda one, asked, problem: [])
    found = weighed(law, [best])
    assert (found.verdict, found.kind, found.effects) == ("missing", kind, ("memory",))
    words = "on left-out conditions it takes only 45% of the law's error, scatter included"
    assert (words in found.reasons[0]) == (kind == "part")


def test_what_lies_under_scatter_is_taken_by_a_part(monkeypatch):
    """It takes 90 % of what is missing beyond scatter, a third of the error: static friction had been `memory`."""
    best, law = candidate("memory", 64.0, 80.0), candidate("", 100.0, 1000.0)
    law.missing = 6 * 40.0
    best.lack = SimpleNamespace(p_value=0.5, share=0.2, sure_share=0.0)
    stand_in(monkeypatch, "rivals_of", lambda one, asked, problem: [])
    found = weighed(law, [best])
    assert (found.verdict, found.kind, found.effects) == ("missing", "part", ("memory",))


def test_one_that_explains_it_is_nearer_than_two_though_others_are_first(monkeypatch):
    """A further condition left nothing over, but was third by what scatter leaves to tell of left-out conditions."""
    first, second, last = (
        candidate(*of) for of in (("stribeck", 80.0, 90.0), ("memory", 82.0, 95.0), ("gap", 70.0, 97.0))
    )
    law = candidate("", 100.0, 100.0)
    for each, left in ((first, 0.6), (second, 0.6), (last, 0.0)):
        each.lack = SimpleNamespace(p_value=0.5 if not left else 0.0, share=left, sure_share=left)
    law.lack = SimpleNamespace(p_value=0.0, share=0.79, sure_share=0.7)
    stand_in(monkeypatch, "rivals_of", lambda best, asked, problem: [])
    found = weighed(law, [first, second, last])
    assert (found.verdict, found.effects) == ("missing", ("gap",))


def weighed_part(monkeypatch, *, same):
    """Give the reason for which the better of two effects is a part, where the other comes near."""
    stand_in(monkeypatch, "_same_part", lambda other, best, promises, pairs, scales: same)
    stand_in(monkeypatch, "takes_part", lambda candidate, law, problem: True)
    best, other, law = (candidate(*of) for of in (("viscous", 60.0, 80.0), ("memory", 65.0, 90.0), ("", 100.0, 100.0)))
    best.reservations = ()
    law.lack = SimpleNamespace(share=9.0)
    scales = on_scales(law, [best, other])
    return one_part([best, other], [other], [], [], scales)


def test_a_rival_that_comes_near_with_another_part_is_told(monkeypatch):
    """The table beside the words shows 40 % and 35 %: "no rival comes near" would be false."""
    apart = weighed_part(monkeypatch, same=False)
    assert (apart.verdict, apart.effects) == ("missing", ("viscous",))
    assert "no rival comes near" not in apart.reasons[0]
    assert "memory comes near: it takes another part" in apart.reasons[0]
    alike = weighed_part(monkeypatch, same=True)
    assert alike.verdict == "ambiguous"
    assert [other.effects for other in alike.others] == [("memory",)], "a ladder may go its way too"


@pytest.mark.parametrize(
    ("left", "told"),
    [
        (46.0, "clearly more than memory, which takes 54%"),
        (40.0, "and memory 60%, but clearly less where errors are counted in units of the noise"),
        (75.0, "and no rival comes near"),
    ],
)
def test_what_takes_nearly_as_much_and_is_no_rival_is_told(left, told, monkeypatch):
    """The table beside the words showed 57 % and 54 %: "no rival comes near" was what nobody could see there."""
    stand_in(monkeypatch, "takes_part", lambda candidate, law, problem: True)
    best, other, law = candidate("viscous", 43.0, 80.0), candidate("memory", left, 95.0), candidate("", 100.0, 100.0)
    best.reservations = ()
    law.lack = SimpleNamespace(share=9.0)
    found = one_part([best, other], [], [], [], on_scales(law, [best, other]))
    assert found.reasons[0].startswith("viscous takes 57% of what is missing") and found.reasons[0].endswith(told)


@pytest.mark.parametrize(("together", "verdict"), [(19.0, "missing"), (55.0, "ambiguous")])
def test_two_fitted_together_tell_whether_they_take_the_same_part(together, verdict, monkeypatch):
    """One step held a band's tension and a slip for rivals, and together they took more than both take alone."""
    stand_in(monkeypatch, "takes_part", lambda candidate, law, problem: True)
    law = candidate("", 100.0, 100.0)
    best, other = candidate("memory:2", 66.0, 80.0), candidate("viscous", 68.0, 90.0)
    pair = candidate("viscous", together, 70.0)
    pair.effects = ("viscous", "memory")
    best.reservations = other.reservations = ()
    law.lack = SimpleNamespace(share=9.0)
    found = one_part([best, other], [other], [], [pair], on_scales(law, [best, other]))
    assert found.verdict == verdict


def test_rivals_for_a_part_are_fitted_together_with_the_best_where_no_pair_was(monkeypatch):
    """Near five times the noise no pairs had been fitted, and a band's tension was called a slip's rival."""
    stand_in(monkeypatch, "takes_part", lambda candidate, law, problem: True)
    stand_in(monkeypatch, "rivals_of", lambda best, asked, problem: [each for each in asked if each is not best])
    stand_in(monkeypatch, "screened", lambda *of: [])
    stand_in(monkeypatch, "pairs", lambda *of: [])
    stand_in(monkeypatch, "rests_on", lambda *of: None)
    law = candidate("", 100.0, 100.0)
    best, other = candidate("memory:2", 66.0, 80.0), candidate("viscous", 68.0, 90.0)
    for each in (law, best, other):
        each.lack = SimpleNamespace(p_value=0.0, share=9.0, sure_share=9.0, excess=9.0, most_share=9.0)
    best.reservations = other.reservations = ()
    pair = candidate("viscous", 19.0, 70.0)
    pair.effects = ("memory", "viscous")
    asked = []

    def fitted(first, others, *of):
        asked.append((first.effects[0], [each.effects[0] for each in others]))
        return [pair]

    stand_in(monkeypatch, "together_with_each", fitted)
    found = weighed(law, [best, other])
    assert asked == [("memory:2", ["viscous"])]
    assert (found.verdict, found.effects, found.pair) == ("missing", ("memory:2",), None)
    assert "viscous comes near: it takes another part" in found.reasons[0]


def test_what_takes_more_in_the_mean_than_what_is_named_is_told_beside_it(monkeypatch):
    best, more, law = (candidate(*of) for of in (("viscous", 60.0, 80.0), ("memory", 40.0, 90.0), ("", 100.0, 100.0)))
    for each in (best, more, law):
        each.heldout_by, each.reservations = {"A, f": 0.1}, ()
    law.lack = SimpleNamespace(share=9.0)
    stand_in(monkeypatch, "takes_part", lambda candidate, law, problem: candidate is best)
    scales = on_scales(law, [best, more])
    found = one_part([best], [], [], [], scales)
    assert (found.kind, found.effects) == ("part", ("viscous",))
    assert "memory takes most, 60% of what is missing" in found.reasons[0]
    assert "no rival" not in found.reasons[0]


@pytest.mark.parametrize(("left", "told"), [(8.0, True), (70.0, False)])
def test_what_two_would_take_together_is_told_where_none_is_named(left, told, monkeypatch):
    alone, pair, law = candidate("viscous", 95.0, 90.0), candidate("viscous", left, 50.0), candidate("", 100.0, 100.0)
    pair.effects = ("viscous", "offset")
    for each, share in ((alone, 8.0), (pair, 3.6), (law, 9.0)):
        each.lack = SimpleNamespace(p_value=0.0, share=share, sure_share=share, rms=4.7 * share)
        each.heldout_by = {"A, f": share}
    stand_in(monkeypatch, "screened", lambda *of: [])
    stand_in(monkeypatch, "pairs", lambda *of: [pair])
    stand_in(monkeypatch, "takes_part", lambda candidate, law, problem: False)
    found = weighed(law, [alone])
    assert (found.verdict, found.effects) == ("unknown", ())
    words = "viscous and offset together would take 92% of it, but leave 16.9 N (3.6 times the force noise)"
    assert any(words in reason for reason in found.reasons) == told


@pytest.mark.parametrize(("left", "kind"), [(0.0, "cause"), (0.3, "part")])
def test_what_all_likely_pairs_share_is_missing_whatever_stands_beside_it(left, kind, monkeypatch):
    """An inertia and an asymmetry were missing; that a gas spring could be the second left open which comes first.

    Where two leave something of a form they are parts: of one stop "two effects are missing" had been said.
    """
    asymmetry, gas, inertia = (
        candidate("asymmetry", 60.0, 60.0),
        candidate("gas_spring", 58.0, 55.0),
        candidate("inertia", 70.0, 70.0),
    )
    law = candidate("", 100.0, 100.0)
    for each, excess in ((asymmetry, 60.0), (gas, 58.0), (inertia, 70.0), (law, 100.0)):
        each.lack = SimpleNamespace(p_value=0.0, share=3.0, sure_share=3.0, excess=excess)
    pairs = []
    for place, other in enumerate(("asymmetry", "gas_spring", "pressed_slip")):
        pairs.append(candidate("inertia", 1.0, 10.0 + 20.0 * (place == 2)))
        lack = SimpleNamespace(p_value=0.0 if left else 0.5, share=left, sure_share=left)
        pairs[-1].effects, pairs[-1].lack = (other, "inertia"), lack
    stand_in(monkeypatch, "rivals_of", lambda best, asked, problem: [])
    stand_in(monkeypatch, "screened", lambda *of: [])
    stand_in(monkeypatch, "pairs", lambda *of: pairs)
    stand_in(monkeypatch, "twins", lambda *of: [])
    stand_in(monkeypatch, "takes_part", lambda candidate, law, problem: False)
    found = weighed(law, [gas, asymmetry, inertia])
    assert (found.verdict, found.kind, found.effects) == ("missing", kind, ("inertia",))
    assert ("two effects are missing" in found.reasons[0]) == (kind == "cause")
    assert "with asymmetry or gas_spring beside it 99% is explained" in found.reasons[0]


@pytest.mark.parametrize(("takes", "named"), [(0.66, "stiffness_frequency"), (0.4, "memory:2")])
def test_of_two_what_takes_half_in_force_is_named_first_and_as_it_was_judged(takes, named, monkeypatch):
    """A bolts' torque took 66 % and slip 20 %; `memory:3` was named, of which the words told what `memory:2` does."""
    slip, other = candidate("memory:2", 80.0, 60.0), candidate("stiffness_frequency", 100.0 * (1 - takes), 70.0)
    law, pair = candidate("", 100.0, 100.0), candidate("memory:3", 8.0, 10.0)
    for each, excess in ((slip, 60.0), (other, 40.0), (law, 100.0)):
        each.lack = SimpleNamespace(p_value=0.0, share=3.0, sure_share=3.0, excess=excess)
    pair.effects = ("memory:3", "stiffness_frequency")
    pair.lack = SimpleNamespace(p_value=0.5, share=0.0, sure_share=0.0)
    stand_in(monkeypatch, "rivals_of", lambda best, asked, problem: [])
    stand_in(monkeypatch, "screened", lambda *of: [])
    stand_in(monkeypatch, "pairs", lambda *of: [pair])
    stand_in(monkeypatch, "twins", lambda *of: [])
    stand_in(monkeypatch, "takes_part", lambda candidate, law, problem: False)
    found = weighed(law, [slip, other])
    assert (found.effects, found.named.effects) == ((named,), (named,))
    assert f"{named} first, which takes" in found.reasons[0]


@pytest.mark.parametrize(
    ("akaike", "parameters", "kind"), [(9.0, 2, "part"), (11.0, 2, "part"), (40.0, 2, "cause"), (9.0, 3, "cause")]
)
def test_no_pair_is_the_cause_where_one_that_acts_alike_fits_as_well(akaike, parameters, kind):
    """Of friction by LuGre behind a spring `bouc_wen` with `slip_speed` had been the cause."""

    def pair(first, akaike, values, *reservations):
        law = SimpleNamespace(values=dict.fromkeys(range(values), 1.0))
        return SimpleNamespace(
            effects=(first, "slip_speed"), akaike=akaike, reservations=reservations, result=SimpleNamespace(law=law)
        )

    found = scales.Weighed("missing", ("bouc_wen",), "cause", None, pair("bouc_wen", 10.0, 2), ("two are missing",))
    asked = causes.unless_another_does(found, [pair("slip_spread", akaike, parameters, "chi ran into its bound")])
    assert asked.kind == kind
    told = "slip_spread and slip_speed together fit as well, though chi ran into its bound"
    assert (told in asked.reasons) == (kind == "part")


def one_relaxation_beside_a_spread(monkeypatch, left, squares, akaike):
    """Weigh a special case that leaves so much, and its general effect with these squares and this criterion."""
    special, general = candidate("relaxation", left, 100.0), candidate("relaxation_spread", left - 1.0, squares)
    general.akaike = akaike
    for each in (special, general):
        each.lack = SimpleNamespace(p_value=0.5, share=0.0, sure_share=0.0)
    law = candidate("", 100.0, 1000.0)
    law.lack = SimpleNamespace(p_value=0.0, share=9.0, sure_share=9.0)
    stand_in(monkeypatch, "rivals_of", lambda best, others, problem: [one for one in others if one not in (best, law)])
    return weighed(law, [general, special])


@pytest.mark.parametrize(("left", "kind"), [(8.0, "cause"), (55.0, "part")])
@pytest.mark.parametrize(("akaike", "told"), [(96.0, True), (104.0, False)])
def test_a_general_effect_that_the_fit_prefers_is_told_beside_its_special_case(akaike, told, left, kind, monkeypatch):
    """It is the name that stays open, though no rival comes near: a spread of relaxation times, or one."""
    found = one_relaxation_beside_a_spread(monkeypatch, left, 92.0, akaike)
    assert (found.kind, found.effects) == (kind, ("relaxation",))
    assert ("can't tell it from relaxation_spread" in found.reasons[0]) == told


@pytest.mark.parametrize(("akaike", "kind"), [(92.0, "cause"), (89.0, "part")])
def test_no_special_case_is_the_cause_where_the_fit_clearly_prefers_the_general_effect(akaike, kind, monkeypatch):
    """Of a strong spread of relaxation times one relaxation left 0.3 times the noise, and was the cause."""
    found = one_relaxation_beside_a_spread(monkeypatch, 8.0, 95.0, akaike)
    assert (found.kind, found.effects) == (kind, ("relaxation",))
    assert ("clearly prefers relaxation_spread" in found.reasons[0]) == (kind == "part")


@pytest.mark.parametrize(
    ("of_other", "of_general", "named"),
    [
        (200.0, 100.0, "relaxation_spread"),  # clearly better than what is clearly better
        (205.0, 195.0, "stiffness_frequency"),  # no better than the other
        (400.0, 295.0, "relaxation"),  # the special case is better than the other
    ],
)
def test_no_other_is_named_in_the_place_of_a_general_effect_left_aside_for_its_special_case(
    of_other, of_general, named, monkeypatch
):
    """Of a clean spread of relaxation times `stiffness_frequency` was the cause, by 140 nats behind."""
    general, special = candidate("relaxation_spread", 4.0, of_general), candidate("relaxation", 5.0, 303.0)
    other, law = candidate("stiffness_frequency", 4.5, of_other), candidate("", 100.0, 1000.0)
    for each, share in ((general, 0.0), (special, 0.08), (other, 0.03)):
        each.lack = SimpleNamespace(p_value=0.5, share=share, sure_share=share)
    near = 20.0
    stand_in(
        monkeypatch,
        "rivals_of",
        lambda best, asked, problem: [one for one in asked if one is not best and one.squares - best.squares < near],
    )
    found = weighed(law, sorted((general, special, other), key=lambda one: one.squares))
    assert (found.kind, found.effects) == ("cause", (named,))


def residuals(mean, first):
    """Residuals of six loops, N: their mean and first harmonic."""
    return np.column_stack([np.full(6, mean), np.full(6, first), np.zeros(6)])


@pytest.mark.parametrize(("mean", "first", "objects"), [(4.0, 1.0, False), (4.0, 5.5, True), (9.0, 1.0, False)])
def test_an_effect_that_only_lets_mean_forces_go_is_objected_to(mean, first, objects):
    """A zero that crept with the cycles had been slip's part: of an element that never slipped, and held any mean."""
    left = {"as it is": residuals(mean, 6.0), "with slip": residuals(0.0, first)}
    law, slip = (
        Judged((), SimpleNamespace(law_force=name), None, None, None, 0.0, 0.1, {}, {}, (), (), 0.0) for name in left
    )  # fmt: skip
    problem = SimpleNamespace(
        harmonics=SimpleNamespace(open_means=lambda force: np.full(6, force == "with slip")),
        noise=SimpleNamespace(total_variance=lambda: np.full((6, 3), 0.01)),
        plain_residual=lambda force: left[force].copy(),
    )
    assert any("leaves open" in words for words in with_means_counted(slip, law, problem).objections) == objects
    assert not with_means_counted(law, slip, problem).objections


@pytest.mark.parametrize(
    ("proved", "off", "verdict"), [(False, 0.9, "unknown"), (False, 0.5, "complete"), (True, 0.9, "complete")]
)
def test_no_law_is_complete_of_which_a_part_leaves_mean_forces_open(proved, off, verdict, monkeypatch):
    law = candidate("slip_lock", 1.0, 10.0)
    law.lack = SimpleNamespace(p_value=0.5, share=0.0, sure_share=0.0)
    stand_in(monkeypatch, "means_left_open", lambda law, problem: OpenMeans(5, 6, 2.0 * off, off))
    stand_in(monkeypatch, "scatter_words", lambda lack, problem: "all scatter")
    problem = SimpleNamespace(noise=SimpleNamespace(is_no_rigs=False))
    found = weighed(law, [], problem, replace(TOLERANCE, proved=proved))
    assert found.verdict == verdict
    assert ("in 5 of 6 loops an element of the law never slips" in found.reasons[0]) == (verdict == "unknown")


@pytest.mark.parametrize(("sure", "verdict"), [(0.5, "complete"), (1.1, "unknown")])
def test_what_scatter_may_have_made_is_not_complete_where_it_is_more_than_form(sure, verdict, monkeypatch):
    """A law that was 1.25 times the noise off with stiffness that scattered had been `complete` at one chance in 25."""
    law = candidate("slip_lock", 1.0, 10.0)
    law.lack = SimpleNamespace(p_value=0.04, share=1.25, sure_share=sure, rms=1.4)
    stand_in(monkeypatch, "scatter_words", lambda lack, problem: "all scatter")
    scatter = SimpleNamespace(
        is_no_rigs=False, mean_shows=False, zero_shows=False, scatter=RunScatter(stiffness=0.0017), runs=16
    )
    problem = SimpleNamespace(noise=scatter, loops=SimpleNamespace(run=range(48)))
    found = weighed(law, [], problem)
    assert found.verdict == verdict
    told = "(0.17% of stiffness) may make as much by chance, and these 16 runs are too few"
    assert (told in found.reasons[0]) == (verdict == "unknown")
