"""What the grammar can imitate: springs and dampers by their force, to a few percent, with values of their own."""

from types import SimpleNamespace

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import minimize

from pipeclamp_identification.discovery import discover
from pipeclamp_identification.discovery.freeing import refinements
from pipeclamp_identification.discovery.grammar import terms
from pipeclamp_identification.discovery.shapes import PERIOD_STARTS, RATE, STRENGTH
from pipeclamp_models.base.signals import REFERENCES
from pipeclamp_models.law.declared import effect_of
from pipeclamp_models.realise.array_source import ArrayPrinter

Y, V = (axis.ravel() for axis in np.meshgrid(np.linspace(-1.0, 1.0, 41), np.linspace(-40.0, 40.0, 41)))
SIDE, SPEED = np.sign(V), np.abs(V)
IMITATED = {
    "a film of oil that is squeezed out": (V / (1 - Y / 1.75) ** 3, "damper", "closing_positive"),
    "a film on the other side": (V / (1 + Y / 1.75) ** 3, "damper", "closing_negative"),
    "oil that thins by a power": (SIDE * SPEED**0.4, "damper", "thinning"),
    "a paste beyond its yield": (V * (1 + (V / 6) ** 2) ** -0.4, "damper", "thinning"),
    "a spring that softens for ever": (np.sign(Y) * np.log1p(np.abs(Y) / 0.2), "spring", "softening"),
    "magnets": ((1 - Y / 2.5) ** -4 - (1 + Y / 2.5) ** -4, "spring", "closing_spring_both"),
    "a bumper on the negative side": (1 - np.exp(-Y / 0.3), "spring", "growing_negative"),
}
"""Force, family, and a word of the terms that are held against it."""
CLOSELY = 0.1
"""Share of a force (rms) by which a term may differ: a third of what counts as another form."""
KNOWN = {**REFERENCES, "y": Y, "v": V, "y_r": 0.002, "v_r": 0.01}


def function(expression):
    free = sorted(expression.free_symbols, key=str)
    compiled = sp.lambdify(free, expression, modules="numpy", printer=ArrayPrinter)
    return lambda **known: compiled(*(known[str(symbol)] for symbol in free))


def misses(force, values):
    """The share of the first that no multiple of the second reaches."""
    if not np.all(np.isfinite(values)) or not np.any(values):
        return 1.0
    return float(np.linalg.norm(force - values * (values @ force) / (values @ values)) / np.linalg.norm(force))


@pytest.mark.parametrize("name", IMITATED)
def test_the_grammar_imitates(name):
    wanted, family, word = IMITATED[name]
    best = 1.0
    for term in terms((), {}):
        if term.family != family or word not in term.declaration.id or len(term.declaration.parameters) != 2:
            continue
        effect = effect_of(term.declaration)
        force = function(effect.force)
        (own,) = (str(one.symbol) for one in effect.parameters if str(one.symbol) != STRENGTH)

        def miss(log, force=force, own=own):
            return misses(wanted, force(**KNOWN, **{STRENGTH: 1.0, own: np.exp(log[0])}))

        best = min(best, *(minimize(miss, [np.log(start)], method="Nelder-Mead").fun for start in (0.3, 1.5, 8.0)))
    assert best < CLOSELY


def bent(expression, starts, wanted, **signals):
    """The share of a force that no values of an expression's own parameters reach."""
    values = function(expression)

    def miss(log):
        return misses(wanted, values(**REFERENCES, **signals, **dict(zip(starts, np.exp(log), strict=True))))

    return minimize(miss, np.log(list(starts.values())), method="Nelder-Mead", options={"maxfev": 2000}).fun


@pytest.mark.parametrize(
    "wanted", [V / (1 + (V / 10) ** 2), V * (1 + (V / 6) ** 2) ** -0.2, SIDE * -np.expm1(-SPEED / 6)],
    ids=["a brake whose own currents push its field away", "a melt", "a paste"],
)  # fmt: skip
def test_one_damping_bends_by_any_power(wanted):
    """Beyond a speed its force may fall, as an eddy-current brake's does: no term of the grammar had."""
    term = next(one for one in terms((), {}) if one.declaration.id == "found_bent_damping")
    force = term.effect.force.subs(sp.Symbol(STRENGTH, real=True), 1)
    assert bent(force, {"v_x": 5.0, "p_x": 1.0}, wanted, v=V) < CLOSELY


POINTS, PARTS = 48, 40
"""Of a cycle, and of each step of it where what is wanted is integrated."""
A, F = (axis.ravel() for axis in np.meshgrid((0.2, 0.5, 1.0), (1.0, 5.0)))
CYCLE = np.tile(2 * np.pi * np.arange(POINTS) / POINTS, 3)[:, None]
PLACE, PACE = A * np.sin(CYCLE), 2 * np.pi * F * A * np.cos(CYCLE)
"""Sines of some amplitudes and frequencies, three cycles each, (points, sines): mm and mm/s."""
BESIDE, _ = np.linalg.qr(np.stack([PLACE[:POINTS].ravel(), PACE[:POINTS].ravel()], axis=1))


def last_cycle(step, held=lambda z, y, v: z):
    """What an element does, beside what stiffness and damping can do; its step takes z, y_previous, y and v."""
    strain, found = np.zeros(len(A)), []
    for y_previous, y, v in zip(np.roll(PLACE, 1, axis=0), PLACE, PACE, strict=True):
        strain = step(strain, y_previous, y, v)
        found.append(held(strain, y, v))
    force = np.array(found[-POINTS:]).ravel()
    return force - BESIDE @ (BESIDE.T @ force)


def nearest(term, wanted, **starts):
    """The share of an element's force that no values of a term's own parameters reach."""
    update = function(term.effect.states[0].update)
    force = function(term.effect.force.subs(sp.Symbol(STRENGTH, real=True), 1))
    slow = {**REFERENCES, "h": 1 / POINTS / F, "f": F, "v_r": 0.01}

    def miss(log):
        own = {name: np.copysign(np.exp(one), starts[name]) for name, one in zip(starts, log, strict=True)}

        def step(z, y_previous, y, v):
            return update(**slow, **own, z_x=z, y_previous=y_previous, y=y, v=v)

        def held(z, y, v):
            return force(**slow, **own, z_x=z, y=y, v=v)

        return misses(wanted, last_cycle(step, held))

    first = np.log(np.abs(list(starts.values())))
    return minimize(miss, first, method="Nelder-Mead", options={"maxfev": 200}).fun


def term_of(name):
    (term,) = (one for one in terms((), {}) if one.declaration.id == name)
    return term


def test_a_spring_may_creep_in_proportion_at_first_and_far_faster_when_strained():
    """Of activated flow, as polymers have, a power of the force came no nearer than 18 %, for it has no beginning."""

    def flows(z, old, y, v):
        for _ in range(PARTS):
            way, time = (y - old) / PARTS, 1 / POINTS / F / PARTS
            z = 0.07 * 2 * np.arctanh(np.tanh((z + way) / 0.14) * np.exp(-time / 0.044))
        return z

    activated = last_cycle(flows)
    assert nearest(term_of("found_activated_relaxing"), activated, t_x=0.05, q_x=0.1) < 0.2 * CLOSELY
    for name, start in (("found_relaxing_1", 0.01), ("found_relaxing_2", 0.002)):
        assert nearest(term_of(name), activated, t_x=start) > 1.5 * CLOSELY


def test_friction_may_weaken_as_it_moves_and_recover_at_rest():
    """Grease's structure: no term of the grammar had one, and the nearest left half."""

    def structure(q, old, y, v):
        for _ in range(PARTS):
            time = 1 / POINTS / F / PARTS
            q = q + (1 - q) * np.abs(y - old) / PARTS / 0.6 - q * time / 0.2
        return q

    wanted = last_cycle(structure, lambda q, y, v: (1 - q) * np.tanh(v / 0.4))
    own = {"t_x": 0.1, "q_x": 1.0, "v_x": 0.3}
    assert nearest(term_of("found_thixotropic_saturating"), wanted, **own) < 0.2 * CLOSELY
    assert nearest(term_of("found_smooth_slip"), wanted, w_x=0.05) > 2 * CLOSELY


@pytest.mark.parametrize(
    ("name", "follows", "number"),
    [
        ("at_speed", lambda x: (1 + 1.5 * x**2) / (1 + x**2), {"r_x": 0.5}),
        ("at_speed", lambda x: (1 + 0.4 * x**2) / (1 + x**2), {"r_x": -0.5}),
        ("past_speed", lambda x: 0.4 + 0.6 * np.exp(-(x**2)), {"r_x": -0.5}),
        ("by_speed", lambda x: 1 + np.sqrt(x), {"p_x": 0.4}),
        ("by_speed", lambda x: 1 / (1 + x), {"p_x": -0.4}),
    ],
    ids=[
        "a sliding bearing", "bristles", "bristles as a bell", "a metal that yields the later", "a seal that floats up",
    ],
)  # fmt: skip
def test_dry_friction_may_rise_or_fall_with_the_speed_of_sliding(name, follows, number):
    """What held an element had followed the place, never the velocity."""

    def slides(z, old, y, v):
        held, way = follows(np.abs(v) / 6), np.sign(y - old)
        return way * held + (z - way * held) * np.exp(-np.abs(y - old) / (0.1 * held))

    wanted = last_cycle(slides)
    at_speed, plain = (term_of(f"found_smooth_slip{place}") for place in (f"_{name}", ""))
    assert nearest(at_speed, wanted, w_x=0.1, v_x=5.0, **number) < CLOSELY
    assert nearest(plain, wanted, w_x=0.1) > 1.2 * CLOSELY


def test_dry_friction_may_near_what_holds_it_by_a_power():
    """Dahl's exponent was fixed at one: of filled rubber's, which nears its most along a hyperbola, 16 % were left."""

    def hyperbola(z, old, y, v):
        way, left = np.sign(y - old), 1 - np.sign(y - old) * z
        return way * (1 - left / (1 + left * np.abs(y - old) / 0.1))

    wanted, plain = last_cycle(hyperbola), term_of("found_smooth_slip")
    (bent,) = (one for one, _ in refinements(plain, {"w_x": 0.1}, (), {}) if "left to yield" in one.acts_like)
    assert nearest(bent, wanted, w_x=0.1, e_x=1.6) < 0.1 * CLOSELY
    assert nearest(plain, wanted, w_x=0.1) > CLOSELY


def test_damping_may_be_larger_on_the_way_out_than_on_the_way_back():
    """A magnetorheological damper's force has two branches over the velocity; no damping had."""
    y, v = PLACE[:POINTS], PACE[:POINTS]

    def beside(force):
        return force.ravel() - BESIDE @ (BESIDE.T @ force.ravel())

    def of(name, **starts):
        force = function(term_of(name).effect.force.subs(sp.Symbol(STRENGTH, real=True), 1))

        def miss(log):
            own = dict(zip(starts, np.exp(log), strict=True))
            return misses(wanted, beside(force(**REFERENCES, **own, y=y, v=v, y_r=0.002, v_r=0.01)))

        return minimize(miss, np.log(list(starts.values())), method="Nelder-Mead").fun

    wanted = beside(np.tanh(v / 6 + 0.7 * np.tanh(y / 0.03)))
    assert of("found_shifted_damping", v_x=5.0, r_x=0.3) < CLOSELY
    assert min(of(name, v_x=5.0) for name in ("found_saturating_damping", "found_thinning_damping")) > 4 * CLOSELY


def test_a_stiffness_may_fall_by_a_step_over_the_temperature():
    T = np.linspace(290.0, 570.0, 30)
    wanted = 1 / (1 + np.exp(-(T - 420.0) / 20.0))
    (step,) = (one for one in terms(("T",), {}) if one.declaration.id == "found_stiffness_step_t")
    (factor,) = step.effect.scales.values()
    slope = sp.diff(sp.log(factor), sp.Symbol(RATE, real=True))
    assert bent(slope, {"l_x": 400.0, "a_x": 3.0}, wanted, T=T) < CLOSELY


def test_a_stop_may_be_nearer_when_hot():
    """A clearance that a hot pipe takes up; a stop that is only scaled with the temperature is another."""
    y, T = (axis.ravel() for axis in np.meshgrid(np.linspace(-1.0, 1.0, 41), np.linspace(293.15, 573.15, 5)))
    wanted = np.sign(y) * np.maximum(np.abs(y) - 0.7 * (1 - (T - 293.15) / 400), 0.0)
    by_id = {term.declaration.id: term for term in terms(("T",), {})}
    known = {"y": y, "T": T, "y_r": 0.002}
    for name, others, near in (
        ("found_moved_stop_both_1", {"y_x": 0.5, "m_x": 0.05}, True),
        ("found_stop_both_1_by_t", {"y_x": 0.5, "s_x": 0.5}, False),
    ):
        force = by_id[name].effect.force.subs(sp.Symbol(STRENGTH, real=True), 1)
        assert (bent(force, others, wanted, **known) < CLOSELY) == near


def test_a_stop_may_go_from_one_place_to_another_about_a_temperature():
    """As a bimetal moves it, or what melts: it had been moved in proportion alone, which missed half between levels."""
    levels = np.array([293.15, 373.15, 473.15, 573.15])
    y, T = (axis.ravel() for axis in np.meshgrid(np.linspace(-1.0, 1.0, 41), levels))
    wanted = np.sign(y) * np.maximum(np.abs(y) - 0.8 + 0.5 / (1 + np.exp(-(T - 440.0) / 20)), 0.0)
    by_id = {term.declaration.id: term for term in terms(("T",), {}, span_K=float(np.ptp(levels)))}
    known = {"y": y, "T": T, "y_r": 0.002}
    for name, others, near in (
        ("found_snapped_stop_both_1", {"y_x": 0.7, "m_x": 0.3, "l_x": 420.0}, True),
        ("found_moved_stop_both_1", {"y_x": 0.7, "m_x": 0.1}, False),
    ):
        force = by_id[name].effect.force.subs(sp.Symbol(STRENGTH, real=True), 1)
        assert (bent(force, others, wanted, **known) < CLOSELY) == near


def test_a_further_column_may_scale_a_term_by_a_power():
    """A field's force rises steeply at first, then less and less; an exponential of the field rises the other way."""
    field = np.linspace(2.0, 20.0, 19)
    wanted = np.tanh(field / 12)
    by_id = {term.declaration.id: term for term in terms((), {"field": 20.0})}
    term = by_id["found_viscous_damping_by_field_power"]
    assert term.declaration.conditions == ("field",)
    force = term.effect.force.subs(sp.Symbol(STRENGTH, real=True), 1)
    assert bent(force, {"s_x": 0.5}, wanted, v=1.0, u_field=field) < CLOSELY


def test_a_factor_may_have_a_peak():
    """As damping of a relaxation has over the frequency: a power and what levels off have none."""
    f = np.geomspace(0.5, 20.0, 30)
    wanted = np.log(1 + 2 * (f / 3) / (1 + (f / 3) ** 2))
    (peak,) = (one for one in terms(("f",), {}) if one.declaration.id == "found_damping_peak_f")
    (factor,) = effect_of(peak.declaration).scales.values()
    slope = function(sp.diff(sp.log(factor), sp.Symbol(RATE, real=True)))
    values = slope(**REFERENCES, f=f, l_x=3.0)
    assert misses(wanted, values) < CLOSELY
    assert 0 < np.argmax(values) < len(f) - 1


def test_heat_may_move_the_frequency_of_a_peak():
    """As a relaxation's times fall with the temperature (Arrhenius, 60 kJ/mol); a peak that stays is another."""
    f, T = (axis.ravel() for axis in np.meshgrid(np.geomspace(0.5, 20.0, 9), np.linspace(283.0, 343.0, 5)))
    share = f / 3 * np.exp(7200.0 * (1 / T - 1 / 310.0))
    wanted = 2 * share / (1 + share**2)
    by_id = {term.declaration.id: term for term in terms(("f", "T"), {})}
    for name, others, near in (
        ("found_damping_peak_f_shifted_by_t", {"l_x": 2.0, "m_x": 5.0}, True),
        ("found_damping_peak_f", {"l_x": 3.0}, False),
    ):
        (factor,) = by_id[name].effect.scales.values()
        slope = sp.diff(sp.log(factor), sp.Symbol(RATE, real=True))
        assert (bent(slope, others, wanted, f=f, T=T) < 2 * CLOSELY) == near


def test_each_term_is_known_by_what_is_left_without_its_scaling_and_its_place():
    by_id = {term.declaration.id: term for term in terms(("A", "f", "T"), {"load": 1.0})}
    left = by_id["found_viscous_damping_closing_both_by_f"].shorter
    assert set(left) == {"found_viscous_damping", "found_viscous_damping_by_f", "found_viscous_damping_closing_both"}
    assert by_id["found_slip_beyond"].shorter == ("found_slip",)
    assert by_id["found_viscous_damping"].shorter == ()
    for term in by_id.values():
        assert all(len(by_id[name].declaration.parameters) <= len(term.declaration.parameters) for name in term.shorter)


def test_what_grows_linearly_is_fitted_beside_what_grows_exponentially(monkeypatch):
    """They are one where a search screens them, so that one stands for both; a damping three times as large isn't."""
    monkeypatch.setattr(discover, "with_effect", lambda structure, name: structure)
    by_id = {term.declaration.id: term for term in terms(("T",), {"field": 20.0})}
    pairs = [(one, by_id[name]) for one in by_id.values() for name in one.grown]
    assert {len(one.grown) for one in by_id.values()} == {0, 1}
    assert len(pairs) == 2 * 3 * 2  # both ways, roles, signals
    varied = {**REFERENCES, "T": np.linspace(290.0, 400.0, 40), "u_field": np.linspace(0.0, 20.0, 40)}
    structure = SimpleNamespace(with_declared=lambda declared: structure, own=dict)
    law = SimpleNamespace(result=SimpleNamespace(law=SimpleNamespace(structure=structure)))
    for one, other in pairs:
        ours, others = (function(next(iter(effect_of(each.declaration).scales.values()))) for each in (one, other))
        known = {**varied, "l_x": 12.0 if "field" in one.acts_like else 340.0}
        assert ours(**known, s_x=1e-3) == pytest.approx(others(**known, s_x=1e-3), rel=1e-6)
        assert np.max(np.abs(ours(**known, s_x=4.0) - others(**known, s_x=4.0))) > 1.0
        values = {"s_x": 0.7, "l_x": 340.0}
        fitted = SimpleNamespace(result=SimpleNamespace(law=SimpleNamespace(values=values)))
        (also,) = discover._related(law, [SimpleNamespace(term=one, squares=1.0, judged=fitted)], by_id)
        assert also.effects == (other.declaration.id,)
        assert also.starts == [values]


@pytest.mark.parametrize("length", np.geomspace(0.033, 0.4, 12))
def test_a_period_is_in_step_with_one_that_it_is_sought_from(length):
    """Between the starts of short periods lay some that none showed: a second sine of half the length was missed."""
    y = np.linspace(-1.0, 1.0, 401)
    wanted = np.sin(y / length)
    alike = [np.corrcoef(wanted, np.sin(y / start))[0, 1] for start in PERIOD_STARTS]
    assert max(alike) > 0.4


def test_valleys_of_detents_may_be_broader_than_the_tops_between_them():
    """Two sines did as much only where the second one's length, half of the first one's, was among the starts."""
    y = np.linspace(-1.0, 1.0, 801)
    wanted = np.sin(y / 0.043) / (1.8 - np.cos(y / 0.043))
    plain = term_of("found_periodic_spring")
    every = [one for one, _ in refinements(plain, {"F_x": 1.0, "y_x": 0.043}, (), {})]
    (with_overtone,) = (one for one in every if "overtone" in one.acts_like)
    forces = [one.effect.force.subs(sp.Symbol(STRENGTH, real=True), 1) for one in (plain, with_overtone)]
    assert bent(forces[0], {"y_x": 0.043}, wanted, y=y) > 2 * CLOSELY
    assert bent(forces[1], {"y_x": 0.043, "b_x": 0.3}, wanted, y=y) < CLOSELY
