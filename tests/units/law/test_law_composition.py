"""Laws composed of a base and effects, and the catalogue that they come from."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
import sympy as sp

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.equations import symbols
from pipeclamp_models.law.catalogue import entries, find_effect
from pipeclamp_models.law.law import BASES, Law, Structure, bare_for, find_base, smoothing, with_effect
from pipeclamp_models.realise.force import force_of_law
from pipeclamp_models.realise.motion import sinusoids

CONTRACT = [
    "memory",
    "directional_slip",
    "slip_spread",
    "bouc_wen",
    "play",
    "coulomb",
    "stribeck",
    "displacement_friction",
    "self_centring",
    "pressed_slip",
    "slip_speed",
    "slip_temperature",
    "viscous",
    "quadratic_damping",
    "directional_damping",
    "asymmetry",
    "hardening",
    "exponential_stiffening",
    "gas_spring",
    "end_stop",
    "unilateral_contact",
    "gap",
    "relaxation",
    "relaxation_spread",
    "oil_damper",
    "inner_mass",
    "damping_temperature",
    "contact_growth",
    "stiffness_frequency",
    "loosening",
    "density",
    "condition",
    "offset",
    "inertia",
    "delay",
]
RIG = {"offset", "inertia", "delay"}


def test_every_effect_of_the_contract_is_there_and_in_its_part():
    assert set(CONTRACT) <= set(entries())
    for name in CONTRACT:
        effect = find_effect("condition:x" if name == "condition" else name)
        assert effect.part == ("rig" if name in RIG else "clamp")


def test_no_two_effects_share_a_symbol():
    seen: dict[str, str] = {}
    for name in entries():
        effect = find_effect("condition:x" if name == "condition" else name)
        for parameter in effect.parameters:
            assert parameter.name not in seen, f"{parameter.name} in {name} and {seen[parameter.name]}"
            seen[parameter.name] = name


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("memroy", "did you mean 'memory'"),
        ("xyzzy", "not in the catalogue"),
        ("viscous:2", "takes no argument"),
        ("memory:0", "1 to 6"),
        ("condition", "after a colon"),
        ("condition:", "expected"),
        ("memory:__import__('os')", "1 to 6"),
    ],
)
def test_a_name_that_is_not_known_is_refused(name, words):
    with pytest.raises(UserError, match=words):
        find_effect(name)


def test_bases():
    assert set(BASES) == {"power", "memory", "series", "published"}
    assert find_base("series:5:2").terms == ("elastic_series:5", "damping_series:2")
    for name in ("powr", "power:2", "series:3", "series:3:2:1", ""):
        with pytest.raises(UserError, match="expected one of"):
            find_base(name)
    assert Structure("memory", frozen=(("c_A", 0.1),)).held() == {
        "alpha0": 1.0,
        "alpha_A": 0.0,
        "alpha_f": 0.0,
        "c_A": 0.1,
    }


@pytest.mark.parametrize(
    ("structure", "words"),
    [
        (Structure("power", ("viscous", "viscous")), "twice"),
        (Structure("power", ("memory", "memory")), "twice"),
        (Structure("memory", ("memory",)), "twice"),
        (Structure("power", ("memory:2", "memory:3")), "one effect with different numbers"),
        (Structure("power", ("memory", "memory:2")), "one effect with different numbers"),
    ],
)
def test_what_does_not_fit_together_is_refused(structure, words):
    with pytest.raises(UserError, match=words):
        _ = structure.equations


def test_a_modifier_reaches_every_term_of_its_role_whatever_the_order():
    first, last = (
        Structure("power", order) for order in (("contact_growth", "viscous"), ("viscous", "contact_growth"))
    )
    values = {parameter.name: 0.3 for parameter in first.equations.parameters} | {"T_c": 400.0, "k10": 100.0, "c0": 5.0}
    motion = sinusoids([0.5, 0.5], 2.0, [300.0, 500.0])
    one, other = (
        force_of_law(Law(structure, values, *smoothing(0.5, 2.0)), motion).force for structure in (first, last)
    )
    np.testing.assert_allclose(one, other, rtol=1e-13)


def test_rig_effects_stay_out_of_the_clamp():
    structure = Structure("power", ("inertia", "offset", "delay"))
    clamp, whole = structure.equations_without_rig, structure.equations
    assert set(whole.names) - set(clamp.names) == {p.name for name in RIG for p in find_effect(name).parameters}
    assert clamp.composed.lag == 0
    assert not clamp.outline.late
    assert symbols.a not in clamp.composed.force.free_symbols


def test_the_base_law_is_the_equation():
    """F = k1 y + k3 y^3 + c |v/v0|^alpha sgn v with power surfaces, far from v = 0."""
    values = {
        "k10": 1500.0, "k1_A": -0.2, "k1_T": -0.1, "k30": 300.0, "k3_A": -1.0, "k3_T": 0.2,
        "c0": 60.0, "c_A": 0.1, "c_f": -0.3, "alpha0": 0.5, "alpha_A": 0.4, "alpha_f": 0.05,
    }  # fmt: skip
    law = Law(Structure("power"), values, 1e-9, 1e-9)
    A, f, T = 0.4, 3.0, 450.0
    motion = sinusoids(A, f, T, 64)
    y, v = motion.y[0], motion.v[0]
    k1 = 1500 * A**-0.2 * (T / 293.15) ** -0.1
    k3 = 300 * A**-1.0 * (T / 293.15) ** 0.2
    c, alpha = 60 * A**0.1 * f**-0.3, 0.5 * A**0.4 * f**0.05
    expected = k1 * y + k3 * y**3 + c * np.abs(v) ** alpha * np.sign(v)
    moving = np.abs(v) > 1e-3
    np.testing.assert_allclose(force_of_law(law, motion).force[0][moving], expected[moving], rtol=1e-12)


@pytest.mark.parametrize("alpha", [0.0, 0.2, 0.5, 1.0, 2.0])
def test_smoothing_costs_less_than_a_thousandth_of_the_dissipation(alpha):
    """At the smallest amplitude and lowest frequency of the range, where it is largest."""
    values = dict.fromkeys(Structure("power").equations.names, 0.0) | {"c0": 100.0, "alpha0": alpha}
    motion = sinusoids(0.2, 1.0, 300.0, 8192)
    lost = []
    for smooth in (smoothing(0.2, 1.0), (1e-12, 1e-12)):
        force = force_of_law(Law(Structure("power"), values, *smooth), motion).force
        lost.append(np.sum(force * motion.v))
    assert abs(lost[0] / lost[1] - 1) < 1e-3


def test_composed_equations_are_sympy_and_complete():
    for base in BASES:
        equations = Structure(base).equations.composed
        known = {p.symbol for p in equations.parameters} | {c.symbol for c in equations.coefficients}
        known |= {state.symbol for state in equations.states} | {signal.symbol for signal in symbols.FAST}
        left = equations.force.free_symbols - known - set(symbols.REFERENCES) - {symbols.v_r, symbols.y_r}
        assert isinstance(equations.force, sp.Expr)
        assert not left - {signal.symbol for signal in symbols.SLOW}


@pytest.mark.parametrize("base", ["power", "series"])
@pytest.mark.parametrize("effect", ["damping_temperature", "directional_damping"])
def test_damping_is_scaled_in_every_base_law_that_has_it(base, effect):
    plain = Structure(base).equations
    assert set(Structure(base, (effect,)).equations.names) > set(plain.names)


def test_memory_that_does_not_settle_is_marked(monkeypatch):
    structure = Structure("power", ("relaxation",))
    values = dict.fromkeys(structure.equations.names, 0.0) | {"k10": 5.0, "c0": 0.01, "k_m": 3.0, "tau": 0.2}
    law = Law(structure, values, 1e-2, 1e-3)
    motion = sinusoids([0.2, 0.5], 3.0, 300.0, 64)
    assert not force_of_law(law, motion).unsettled.any()
    monkeypatch.setattr("pipeclamp_models.realise.states.SETTLED_SHARE", -1.0)  # no change is small enough
    assert force_of_law(law, motion).unsettled.all()


def test_a_condition_changes_slip_on_the_way_down_by_a_factor_of_its_own():
    law = Structure("power", ("directional_slip", "condition:x")).equations.composed
    own = {str(each.symbol): each.expression.free_symbols for each in law.coefficients}
    apart, both = sp.symbols("zn_u_x1 z_u_x1", real=True)
    assert {apart, both} & own["slip_n"] == {apart, both}
    assert {apart, both} & own["slip_p"] == {both}
    assert "zn_u_x1" not in Structure("power", ("memory", "condition:x")).equations.names


@pytest.mark.parametrize("name", sorted(entries()))
def test_only_a_constant_force_is_there_at_rest(name):
    effect = find_effect("condition:x" if name == "condition" else name)
    bare = bare_for(effect)
    law = bare if effect.name in {one.name for one in bare.all_effects()} else with_effect(bare, effect.name)
    at_rest = {each.name for each in law.equations.parameters if each.at_rest}
    assert at_rest == {"offset": {"F_o"}, "condition": {"F_u_x1"}}.get(name, set())


def test_equations_that_were_composed_here_are_sent_to_another_process():
    """The first call on a law composes it: effects whose next larger member has a start of its own are sent, too."""
    equations = Structure("power", ("memory:2", "condition:preload_N")).equations
    assert equations.composed.effects
    assert pickle.loads(pickle.dumps(equations)).names == equations.names
