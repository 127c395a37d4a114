"""The truth table of discovery: its laws are what their equations say, and answers are judged by their force."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from project import TRUTH_TABLE, imported
from scipy.integrate import solve_ivp

SHAPE = {"tau": 0.06, "limit": 0.2, "speed": 1.0, "stop": 0.7, "sign": 1.0, "contact": 420.0, "cycles": 100.0}
STEP_ERROR = 2e-3
"""Share of the force (rms) by which the fine steps of the truth err: half of the least noise."""
LAWS = (
    "detents", "bimetal_stop", "bumpers", "thickening_paste", "melting_wax", "cavitating_film", "barrel",
    "jammed_paste", "struck_pad", "shifted_flow", "gliding_arm", "viscoplastic", "elastic_bristles", "flag",
    "hardening_plastic", "wire_rope", "setting_paste", "ageing_contacts", "warm_arm", "rubber_friction",
    "overshooting_friction", "glass_transition", "payne", "moving_peak", "running_in", "field_friction",
)  # fmt: skip


def base_law():
    from cases import draw_base

    return draw_base(np.random.default_rng(3))


def sines(f=3.0, A=0.9):
    """Pure sines at two temperatures."""
    from truth import Motion, drive

    tones = {1: np.full(2, A * np.exp(-0.5j * np.pi))}
    time, y, v, a = drive(tones, f, 1000.0, round(3000 / f))
    column = np.ones((2, 1))
    return Motion(
        time, y, v, a, tuple(tones.items()), A * column, np.array([[300.0], [450.0]]), 2.3 * column, 10 * column,
        50 * column, f, np.zeros((2, 4)),
    )  # fmt: skip


def test_the_laws_are_not_the_packages_and_share_no_code_with_it():
    from beyond import registry

    from pipeclamp_models.law.catalogue import identifiers

    assert set(registry.LAWS) == set(LAWS)
    assert not set(registry.LAWS) & set(identifiers())
    for module in ("plain", "states", "factors", "registry"):
        names = {name.split(".")[0] for name in imported(TRUTH_TABLE / "beyond" / f"{module}.py")}
        assert not any(name.startswith("pipeclamp") for name in names), module


@pytest.mark.parametrize("law", LAWS)
def test_no_law_creates_energy_and_springs_lose_none(law):
    from beyond import registry
    from truth import force

    motion, base = sines(), base_law()
    hidden = registry.LAWS[law]
    with_it = force(base, motion, (hidden.kind.part(motion, base, False, 0.05, SHAPE),))
    added = with_it - force(base, motion, ())
    assert np.any(added)
    cycle = slice(-round(1 / (3.0 * motion.step)) - 1, None)
    y, f = motion.y[:, cycle], added[:, cycle]
    work = np.sum((f[:, 1:] + f[:, :-1]) / 2 * np.diff(y), axis=1)
    moved = np.sum(np.abs(f[:, 1:] * np.diff(y)), axis=1)
    if "factor" not in hidden.families:
        assert np.all(work > -1e-4 * moved)
    if hidden.families == {registry.SPRING}:
        assert np.all(np.abs(work) < 1e-4 * moved)


def held_at(v):
    """What elastic bristles hold at a speed, over what they hold when fast."""
    return 1 + 0.8 * np.exp(-((v / 8.0) ** 2))


def slides(q, v):
    """The share of a way by which they slide: none up to 0.6 of what they hold when fast, all at what they hold."""
    if q * v <= 0 or abs(q) < 0.6:
        return 0.0
    middle, width = (held_at(v) + 0.6) / 2, held_at(v) - 0.6
    return 1.0 if abs(q) > held_at(v) else (1 + np.sin(np.pi * (abs(q) - middle) / width)) / 2


STATES = {
    "gliding_arm": (
        lambda q, v: 15 * (v - 60 * np.sign(q) * np.exp(-1 / max(abs(q), 0.025))), lambda q, y: q, 0.0,
    ),
    "viscoplastic": (lambda q, v: 5 * (v - 5.0 * np.sign(q) * max(abs(q) - 1, 0.0)), lambda q, y: q, 0.0),
    "elastic_bristles": (
        lambda q, v: v / 0.08 * (1 - slides(q, v) * abs(q) / held_at(v)), lambda q, y: q, 0.0,
    ),
    "wire_rope": (lambda q, v: (v - abs(v) * q) / 0.2, lambda q, y: np.exp(y / 0.7) * q, 0.0),
    "warm_arm": (
        lambda q, v: v / 0.8 - q / (0.3 * np.exp(1000 / 300.0 - 1000 / 293.15)), lambda q, y: q, None,
    ),
}  # fmt: skip
"""Rate of a state, force over `typical` of state and displacement, and the state at first; None: as the force is."""


@pytest.mark.parametrize("law", STATES)
def test_states_follow_their_equations(law):
    """Another integrator, another state: the equation as the registry writes it."""
    from beyond import registry
    from hidden import typical

    motion, base, size = sines(), base_law(), 0.05
    rate, force, first = STATES[law]
    w = 2 * np.pi * 3.0
    span = motion.time[0], motion.time[-1]
    shown = registry.LAWS[law].kind.part(motion, base, False, size, SHAPE).force[0] / (size * typical(base))
    solved = solve_ivp(
        lambda t, q: [rate(q[0], w * 0.9 * np.cos(w * t))], span, [shown[0] if first is None else first],
        t_eval=motion.time, rtol=1e-8, atol=1e-6, method="LSODA", max_step=1e-3,
    )  # fmt: skip
    expected = force(solved.y[0], motion.y[0])
    assert np.sqrt(np.mean((shown - expected) ** 2) / np.mean(shown**2)) < STEP_ERROR


def test_structure_and_age_follow_their_equations():
    """Of friction that shear breaks down, and of contacts that are renewed: steady cycles, by another integrator."""
    from beyond import registry
    from hidden import typical

    motion, base = sines(), base_law()
    w = 2 * np.pi * 3.0

    def speed(t):
        return w * 0.9 * np.cos(w * t)

    def steady(rate, first):
        return solve_ivp(
            lambda t, q: [rate(q[0], speed(t))], (motion.time[0], motion.time[-1]), [first], t_eval=motion.time,
            rtol=1e-8, atol=1e-8, method="LSODA", max_step=1e-3,
        ).y[0]  # fmt: skip

    v = motion.v[0]
    near = np.hypot(v, 0.2)
    built = steady(lambda q, v: 1 / 0.18 - q * np.hypot(v, 0.2) / 0.6, 0.3)
    aged = steady(lambda q, v: 1 - np.hypot(v, 0.2) * q / 0.06, 0.01)
    strength = 1 + 0.06 * np.log(near / 20) + 0.2 * np.log(20 / 0.06 * aged)
    last = slice(-round(1 / (3.0 * motion.step)), None)
    flow = np.tanh(v / 0.2)
    for law, wanted in (
        ("setting_paste", v / 20 * (1 + built**1.5)), ("ageing_contacts", np.maximum(strength, 0.0) * flow),
    ):  # fmt: skip
        shown = registry.LAWS[law].kind.part(motion, base, False, 1.0, SHAPE).force[0] / typical(base)
        assert np.sqrt(np.mean((shown - wanted)[last] ** 2) / np.mean(wanted[last] ** 2)) < STEP_ERROR, law


def test_rubber_friction_nears_its_most_along_a_hyperbola():
    """Between reversals y_r, F_r: F = F_r + (y - y_r) (F_m - F_r) / (x (1 - F_r/F_m) + y - y_r) (Berg 1998)."""
    from beyond import registry
    from hidden import typical

    motion, base = sines(), base_law()
    shown = registry.LAWS["rubber_friction"].kind.part(motion, base, False, 1.0, SHAPE).force[0] / typical(base)
    y = motion.y[0]
    turns = np.flatnonzero(np.diff(np.sign(np.diff(y)))) + 1
    low, high = (next(t for t in turns[2:] if np.sign(y[t]) == side) for side in (-1, 1))
    low = max(t for t in turns if t < high) if low > high else low
    up = slice(low, high + 1)
    gone = y[up] - y[low]
    wanted = shown[low] + gone * (1 - shown[low]) / (0.1 * (1 - shown[low]) + gone)
    assert shown[up] == pytest.approx(wanted, abs=1e-6)


def test_a_flag_is_at_rest_in_the_middle_and_yields_within_its_bounds():
    from beyond import registry

    motion, base = sines(), base_law()
    shown = registry.LAWS["flag"].kind.part(motion, base, False, 1.0, SHAPE).force[0] / base.k10
    y = motion.y[0]
    assert np.max(np.abs(shown)) == pytest.approx(0.2, rel=1e-6)
    assert np.all(np.abs(shown[np.abs(y) < 0.05]) <= np.abs(y[np.abs(y) < 0.05]) + 1e-9)
    giving_back = (y > 0.3) & (y < 0.6) & (motion.v[0] < 0) & (motion.time > 0)
    assert shown[giving_back] == pytest.approx(0.35 * 0.2, rel=1e-6)


@pytest.fixture(scope="module")
def jammed():
    """A case that hides jammed paste, and its loops."""
    from cases import Case, draw, measure

    from pipeclamp_identification.loops.loops import loops_of

    drawn = draw(Case("beyond", ("jammed_paste",), "clean", "strong", "low", "A"), seed=2)
    data = measure(drawn)
    return drawn, data.sizes, loops_of(data.campaign)


SHARE = "(v / (8 * v_0) * A_0 / y_x)"
JAMMED, LEVELS_OFF = f"v / v_0 * (1 + 6 * {SHARE}**2 / (1 + {SHARE}**4))", "tanh(y / y_x)"


def with_term(force):
    """A law's structure with a term of this force."""
    from pipeclamp_models.law.declaration import Declaration
    from pipeclamp_models.law.law import Structure

    strength = {"symbol": "F_x", "unit": "N", "meaning": "force", "start": "0.05 * F_typical"}
    length = {"symbol": "y_x", "unit": "mm", "meaning": "length", "start": "1.5 * A_typical", "lower": 0.05,
              "upper": 3.0}  # fmt: skip
    words = {"id": "found_one", "title": "a term", "looks_like": "a term"}
    declared = Declaration.model_validate({**words, "force": f"F_x * {force}", "parameters": (strength, length)})
    return Structure("power", ("found_one",), declared=(declared,))


def test_a_term_is_judged_by_its_force(jammed):
    """The hidden term itself, fitted, is right; a spring beside the same law isn't."""
    from beyond.form import RIGHT_FORM, difference

    from pipeclamp_identification.fitting.identify import fit_structure
    from pipeclamp_models.law.law import Structure

    drawn, sizes, loops = jammed
    before = fit_structure(Structure("power"), loops).law
    for force, right in ((JAMMED, True), (LEVELS_OFF, False)):
        found = difference(drawn, sizes, before, fit_structure(with_term(force), loops).law)
        assert (found <= RIGHT_FORM) == right, found


def test_effects_in_whose_place_a_term_stands_leave_nothing_to_it(jammed):
    """What an effect that is gone could do had been taken out of both forces, so that a right term looked wrong."""
    from beyond.form import difference

    from pipeclamp_identification.fitting.identify import fit_structure
    from pipeclamp_models.law.law import Structure

    drawn, sizes, loops = jammed
    after = fit_structure(with_term(JAMMED), loops).law
    bare, parts = (fit_structure(Structure("power", own), loops).law for own in ((), ("quadratic_damping",)))
    assert difference(drawn, sizes, parts, after) == pytest.approx(difference(drawn, sizes, bare, after))


def test_what_was_put_in_first_of_all_is_held_against_what_is_hidden(jammed, monkeypatch):
    """Also in the place of an effect of the catalogue, where that had to be reckoned by hand; not beside it."""
    from beyond import judge

    from pipeclamp_identification.fitting.identify import fit_structure
    from pipeclamp_models.law.law import Structure

    drawn, sizes, loops = jammed
    before, after, gap = (
        fit_structure(one, loops).law for one in (Structure("power"), with_term(JAMMED), Structure("power", ("gap",)))
    )
    monkeypatch.setattr(judge, "law_of", lambda law: law)
    nothing, first = SimpleNamespace(before=before, after=None), SimpleNamespace(before=before, after=after)
    expected = pytest.approx(judge.difference(drawn, sizes, before, after), abs=1e-4)
    assert judge.how_far_off("coulomb", drawn, sizes, [nothing, first]) == expected
    beside = [SimpleNamespace(before=before, after=gap)]
    assert np.isnan(judge.how_far_off("gap", drawn, sizes, beside))
    assert np.isnan(judge.how_far_off("", drawn, (), [first]))
    assert np.isnan(judge.how_far_off("coulomb", drawn, sizes, [nothing]))


def answered(proposed, family="damper"):
    """Of a search: whether a term was proposed, or the name of an effect that joined in its place."""
    from beyond.judge import Answered

    instead = proposed if isinstance(proposed, str) else ""
    return Answered(proposed is True, family, "", "", (), 0, 0.0, instead)


@pytest.mark.parametrize(
    ("changed", "truth", "expected"),
    [
        ({"kind": "none", "found": False}, (), "right"),
        ({"kind": "none", "found": True}, (), "false alarm"),
        ({"kind": "none", "found": "memory"}, (), "false alarm"),
        ({"kind": "effect", "ladder": ("memory:2",), "found": False}, ("memory",), "right"),
        ({"kind": "effect", "ladder": (), "found": "memory:2"}, ("memory",), "right"),
        ({"kind": "effect", "ladder": ("memory",), "found": "gap"}, ("memory",), "false alarm"),
        ({"kind": "effect", "ladder": ("memory",), "found": False, "first": "gap"}, ("memory",), "false alarm"),
        ({"kind": "effect", "ladder": ("memory:2",), "found": True}, ("memory",), "false alarm"),
        ({"kind": "effect", "ladder": (), "found": True}, ("memory",), "displaced"),
        ({"kind": "effect", "ladder": ("memory",), "found": False, "first": True}, ("memory",), "displaced"),
        ({"found": False, "diagnosed": 1.04}, (), "nothing left"),
        ({"found": False, "diagnosed": 1.30}, (), "nothing proposed"),
        ({"found": True, "difference": 0.1}, (), "right form"),
        ({"found": True, "difference": 0.5}, (), "wrong form"),
        ({"found": True, "difference": 0.1, "law": "detents"}, (), "wrong kind"),
        ({"kind": "beside", "ladder": ("memory",), "found": True, "difference": 0.1}, ("memory",), "right form"),
    ],
)
def test_how_a_case_came_out(changed, truth, expected):
    from beyond.judge import BeyondOutcome, counted

    outcome = BeyondOutcome("", "beyond", "clean", "strong", "low", "A", "cavitating_film", (1.0,), 0.01, diagnosed=1.3)
    given = {key: answered(value) if key in ("first", "found") else value for key, value in changed.items()}
    assert counted(replace(outcome, **given), frozenset(truth)) == expected


def test_targets_count_what_the_issue_speaks_of():
    from beyond.table import beyond_markdown, beyond_sound, beyond_targets

    def row(kind, counted, **further):
        return {
            "name": f"{kind}/x", "kind": kind, "form": "clean", "law": "flag" if kind == "beyond" else "", "ladder": [],
            "strengths": [1.0], "identified": 2.0, "diagnosed": 1.5, "discovered": 1.02, "difference": 0.1,
            "first": None, "found": None, "counted": counted, "error": "", "seconds": 1.0, **further,
        }  # fmt: skip

    weak = row("beyond", "nothing proposed", strengths=[0.2], discovered=1.5)
    taken = row("beyond", "nothing left", diagnosed=1.0)
    effect = row("effect", "displaced", law="condition", ladder=["condition:bolt_torque_Nm"])
    rows = [row("beyond", "right form"), row("beyond", "wrong form", discovered=1.4), weak, taken, effect]
    found = {entry["target"]: entry for entry in beyond_targets([*rows, row("none", "right")])}
    assert found["clean: held-out error near the floor"]["value"] == pytest.approx(2 / 3)
    assert found["clean: left over by the ladder: right form"]["value"] == pytest.approx(0.5)
    assert found["clean: nothing is missing: something proposed"]["cases"] == 2
    assert not found["clean: an effect of the catalogue displaced"]["met"]
    assert not beyond_sound(rows)
    assert "**missed**" in beyond_markdown(rows, "command")
    former = {"proposed": False, "formula": "", "reason": "none passes", "family": ""}  # as drawn before effects joined
    joined = [row("none", "false alarm", found=found) for found in (former, {**former, "instead": "memory"})]
    assert beyond_markdown(joined, "command").count("memory of the catalogue joins; none passes") == 1
    beside = [row("beside", "right form", law="flag"), row("beside", "wrong form", law="flag", discovered=1.3)]
    found = {entry["target"]: entry for entry in beyond_targets([*rows, *beside])}
    assert found["clean: beside an effect of the catalogue: held-out error near the floor"]["value"] == 0.5
    assert found["clean: beside an effect, left over by the ladder: right form"]["cases"] == 2
    assert found["clean: held-out error near the floor"]["cases"] == 3


def test_each_law_is_hidden_beside_an_effect_too_and_its_form_is_judged_alone():
    """Alone, none of its ladder's effects is real, so that a term in the place of some of them was never asked for."""
    from beyond.cases import beyond_cases
    from beyond.form import difference
    from beyond.registry import LAWS
    from cases import Case, draw, measure

    from pipeclamp_identification.fitting.identify import fit_structure
    from pipeclamp_identification.loops.loops import loops_of
    from pipeclamp_models.law.declaration import Declaration
    from pipeclamp_models.law.law import Structure

    beside = [case for case in beyond_cases() if case.kind == "beside"]
    assert {case.hidden[0] for case in beside} == set(LAWS)
    assert all(case.truth == {case.hidden[1]} for case in beside)
    case = Case("beside", ("jammed_paste", "damping_temperature"), "clean", "strong", "low", "A")
    drawn = draw(case, seed=2)
    data = measure(drawn)
    assert min(data.strengths) > 1.4
    strength = {"symbol": "F_x", "unit": "N", "meaning": "force", "start": "0.05 * F_typical"}
    length = {"symbol": "y_x", "unit": "mm", "meaning": "length", "start": "1.5 * A_typical", "lower": 0.05}
    share = "(v / (8 * v_0) * A_0 / y_x)"
    declared = Declaration.model_validate({
        "id": "found_one", "title": "a term", "looks_like": "a term", "parameters": (strength, length),
        "force": f"F_x * v / v_0 * (1 + 6 * {share}**2 / (1 + {share}**4))",
    })  # fmt: skip
    loops = loops_of(data.campaign)
    before, after = (
        fit_structure(Structure("power", ("damping_temperature", *own), declared=(declared,)), loops).law
        for own in ((), ("found_one",))
    )
    assert difference(drawn, data.sizes, before, after) < 0.1


def test_a_case_with_nothing_hidden_goes_all_the_way():
    from beyond.judge import judged_beyond
    from cases import Case

    outcome = judged_beyond(Case("none", (), "clean", "", "high", "B", 1), seed=1)
    assert outcome.counted == "right", outcome
    assert outcome.identified == outcome.diagnosed == outcome.discovered == pytest.approx(1.0, abs=0.02)
    assert "nothing is missing" in outcome.found.reason
