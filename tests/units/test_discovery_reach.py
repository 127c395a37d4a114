"""What the grammar can imitate: springs and dampers by their force, to a few percent, with values of their own."""

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import minimize

from pipeclamp_identification.discovery.grammar import RATE, STRENGTH, terms
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


def test_each_term_is_known_by_what_is_left_without_its_scaling_and_its_place():
    by_id = {term.declaration.id: term for term in terms(("A", "f", "T"), {"load": 1.0})}
    left = by_id["found_viscous_damping_closing_both_by_f"].shorter
    assert set(left) == {"found_viscous_damping", "found_viscous_damping_by_f", "found_viscous_damping_closing_both"}
    assert by_id["found_slip_beyond"].shorter == ("found_slip",)
    assert by_id["found_viscous_damping"].shorter == ()
    for term in by_id.values():
        assert all(len(by_id[name].declaration.parameters) <= len(term.declaration.parameters) for name in term.shorter)
