"""Every term that may be proposed is a declaration that can be read, and creates no energy whatever its parameters."""

import tomllib

import numpy as np
import pytest
import sympy as sp

from pipeclamp_identification.discovery.grammar import MOST_PARAMETERS, MOST_TERM_STARTS, RATE, STRENGTH, terms
from pipeclamp_identification.discovery.proposal import toml_of
from pipeclamp_models.base.signals import REFERENCES
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.declared import effect_of
from pipeclamp_models.realise.array_source import ArrayPrinter
from pipeclamp_models.realise.sizes import number_of

TERMS = list(terms(("A", "f", "T", "N"), {"tension N": 40.0}))
SIZES = {
    "A_typical": 0.5, "A_highest": 1.0, "F_typical": 900.0, "f_typical": 3.0, "f_lowest": 1.0, "f_highest": 10.0,
    "T_lowest": 293.15, "T_highest": 573.15, "N_lowest": 1.0, "N_highest": 2000.0, **REFERENCES,
}  # fmt: skip
SAMPLES = {"element": 600}
"""Of a cycle; an element is walked sample by sample."""
ROUNDING = 0.01
"""Share of the work to and fro by which samples err where a force has a kink."""


def motion(random, samples):
    """A closed path of three harmonics about a mean, one cycle of 1 to 10 Hz."""
    turns = np.arange(samples + 1) / samples
    f = random.uniform(1.0, 10.0)
    parts = [
        random.uniform(0.0, 0.6) * np.exp(2j * np.pi * (order * turns + random.uniform())) / order
        for order in (1, 2, 3)
    ]
    y = sum(parts).real + random.uniform(-0.3, 0.3)
    v = sum(2j * np.pi * f * order * part for order, part in zip((1, 2, 3), parts, strict=True)).real
    A = float(np.ptp(y)) / 2
    return {"y": y, "v": v, "h": 1 / (f * samples), "A": A, "f": f, "T": random.uniform(293.15, 573.15), "N": 100.0,
            "rho": 2.3, "u_tension_N": 30.0, "v_r": 0.01, "y_r": 0.002}  # fmt: skip


def function(expression):
    free = sorted(expression.free_symbols, key=str)
    compiled = sp.lambdify(free, expression, modules="numpy", printer=ArrayPrinter)
    names = [symbol.name for symbol in free]
    return lambda **known: compiled(*(known[name] for name in names))


def test_there_are_hundreds_of_terms_with_few_parameters():
    assert len({term.declaration.id for term in TERMS}) == len(TERMS) > 300
    assert max(len(term.declaration.parameters) for term in TERMS) <= MOST_PARAMETERS
    assert {term.family for term in TERMS} == {"spring", "damper", "element", "factor"}


def test_a_term_that_follows_a_condition_is_screened_with_its_strength_rising_and_falling():
    following = [
        [one.start for one in term.declaration.parameters if one.symbol == RATE and term.family != "factor"]
        for term in TERMS
    ]
    assert {len(set(start)) for starts in following for start in starts} == {2}
    assert max(len(one.start) for term in TERMS for one in term.declaration.parameters) <= MOST_TERM_STARTS


@pytest.mark.parametrize("family", ["spring", "damper", "element", "factor"])
def test_no_term_creates_energy(family):
    random, samples = np.random.default_rng(7), SAMPLES.get(family, 20_000)
    for term in (one for one in TERMS if one.family == family):
        assert Declaration.model_validate(tomllib.loads(toml_of(term.declaration))) == term.declaration
        effect = effect_of(term.declaration)
        known = {**REFERENCES, **motion(random, samples)}
        count = max(len(one.starts) for one in effect.parameters)
        start = int(random.integers(count))
        known |= {one.name: number_of(one.starts[start % len(one.starts)], SIZES) for one in effect.parameters}
        if family == "factor":
            assert all(np.all(function(factor)(**known) > 0) for factor in effect.scales.values()), term.declaration.id
            continue
        known[STRENGTH] = 100.0
        for state in effect.states:
            update = function(state.update)
            walk, name = np.zeros(samples + 1), state.symbol.name
            for _ in range(2):
                walk[0] = walk[-1]
                for place in range(1, samples + 1):
                    here = {"y": known["y"][place], "y_previous": known["y"][place - 1], "v": known["v"][place]}
                    walk[place] = update(**known | here | {name: walk[place - 1]})
            known[name] = walk
        force = np.broadcast_to(function(effect.force)(**known), (samples + 1,))
        way = np.diff(known["y"])
        work = float(np.sum((force[1:] + force[:-1]) / 2 * way))
        moved = float(np.sum(np.abs(force[1:] + force[:-1]) / 2 * np.abs(way)))
        assert work >= -ROUNDING * moved, term.declaration.id
        if family == "spring":
            assert abs(work) <= ROUNDING * moved, term.declaration.id
        if family == "damper":
            assert np.all(force * known["v"] >= 0), term.declaration.id
