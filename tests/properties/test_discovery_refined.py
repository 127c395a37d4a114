"""Refined terms: each is the plain one where its new number says nothing, and creates no energy at other values."""

import numpy as np
import pytest
from test_discovery_grammar import ROUNDING, SIZES, TERMS, function, motion

from pipeclamp_identification.discovery.freeing import refinements
from pipeclamp_identification.discovery.grammar import MOST_PARAMETERS, terms
from pipeclamp_identification.discovery.joining import SHARE, joined, may_join
from pipeclamp_identification.discovery.shapes import STRENGTH
from pipeclamp_models.base.signals import REFERENCES
from pipeclamp_models.realise.sizes import number_of

SAMPLES = {"element": 600}
VARIED = (("A", "f", "T"), {"tension N": 40.0})
SOME = 7
"""Of so many terms one is refined."""


def values_of(effect, random):
    start = int(random.integers(max(len(one.starts) for one in effect.parameters)))
    return {one.name: number_of(one.starts[start % len(one.starts)], SIZES) for one in effect.parameters}


def force_of(term, known):
    """The force along a motion, its state walked twice round, and the factors of a term that adds none."""
    effect = term.effect
    if term.family == "factor":
        return np.array([np.ravel(function(factor)(**known))[0] for factor in effect.scales.values()])
    for state in effect.states:
        update, walk = function(state.update), np.zeros(len(known["y"]))
        for _ in range(2):
            walk[0] = walk[-1]
            for place in range(1, len(walk)):
                here = {"y": known["y"][place], "y_previous": known["y"][place - 1], "v": known["v"][place]}
                walk[place] = update(**{**known, **here, str(state.symbol): walk[place - 1]})
        known = {**known, str(state.symbol): walk}
    return np.broadcast_to(function(effect.force)(**known), known["y"].shape)


def works(force, known):
    """What a force takes up along a motion, and how much of it goes to and fro."""
    way, mean = np.diff(known["y"]), (force[1:] + force[:-1]) / 2
    return float(np.sum(mean * way)), float(np.sum(np.abs(mean * way)))


def refined_terms():
    random = np.random.default_rng(3)
    for term in TERMS[::SOME]:
        values = {**values_of(term.effect, random)}
        every = list(refinements(term, values, *VARIED))
        if every:
            yield term, values, *every[int(random.integers(len(every)))]


@pytest.mark.parametrize("family", ["spring", "damper", "element", "factor"])
def test_a_refined_term_is_the_plain_one_where_its_new_number_says_nothing(family):
    random, samples = np.random.default_rng(5), SAMPLES.get(family, 2000)
    seen = 0
    for term, values, refined, _ in refined_terms():
        new = refined.declaration.parameters[-1]
        if term.family != family or new.unit != "-":
            continue
        assert len(refined.declaration.parameters) == len(term.declaration.parameters) + 1 <= MOST_PARAMETERS
        nothing = 0.0 if new.neutral == 0.0 else new.start[0]
        known = {**REFERENCES, **motion(random, samples), **values}
        plain, freed = force_of(term, known), force_of(refined, {**known, new.symbol: nothing})
        assert freed == pytest.approx(plain, abs=0.02 * np.max(np.abs(plain)) + 1e-12), refined.declaration.id
        seen += 1
    assert seen > 5


@pytest.mark.parametrize("family", ["spring", "damper", "element", "factor"])
def test_no_refined_term_creates_energy(family):
    random, samples = np.random.default_rng(7), SAMPLES.get(family, 20_000)
    for term, values, refined, starts in refined_terms():
        if term.family != family:
            continue
        new = refined.declaration.parameters[-1]
        share = random.choice([0.6, 1.7])
        value = share * starts[-1] if new.neutral is None else random.choice([-1.5, 1.5])
        known = {**REFERENCES, **motion(random, samples), **values, new.symbol: value}
        if family == "factor":
            assert np.all(force_of(refined, known) > 0), refined.declaration.id
            continue
        known[STRENGTH] = 100.0
        force = force_of(refined, known)
        work, moved = works(force, known)
        assert work >= -ROUNDING * moved, refined.declaration.id
        if family == "spring":
            assert abs(work) <= ROUNDING * moved, refined.declaration.id
        if family == "damper":
            assert np.all(force * known["v"] >= 0), refined.declaration.id


def test_every_number_that_is_freed_stands_in_a_formula_that_can_be_read():
    """A power of a root had become one of `abssqrt`, which ended a search."""
    for term in terms(("A",), {}):
        values = {one.symbol: 1.0 for one in term.declaration.parameters}
        for refined, _ in refinements(term, values, (), {}):
            assert refined.effect.parameters[-1].name == refined.declaration.parameters[-1].symbol


@pytest.mark.parametrize("role", ["stiffness", "damping", "slip"])
def test_no_level_of_a_condition_moves_with_that_condition(role):
    """A level "of 777 K that falls with the power 7.6 of the temperature" had been a damping's from 55 °C on."""
    moved = {}
    for term in terms(*VARIED):
        if term.family == "factor" and term.declaration.id.startswith(f"found_{role}_step_"):
            values = {one.symbol: 1.0 for one in term.declaration.parameters}
            every = [refined.acts_like for refined, _ in refinements(term, values, *VARIED)]
            moved[term.declaration.id.rpartition("_step_")[2]] = {
                name for name in ("amplitude", "frequency", "temperature", "tension N")
                if any(words.endswith(f" {name}") and "scaled with" in words for words in every)
            }  # fmt: skip
    assert moved == {
        "a": {"frequency", "temperature", "tension N"}, "f": {"amplitude", "temperature", "tension N"},
        "t": {"amplitude", "frequency", "tension N"}, "tension_n": {"amplitude", "frequency", "temperature"},
    }  # fmt: skip


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_two_terms_as_one_are_their_sum(sign):
    random = np.random.default_rng(9)
    by_name = {term.declaration.id.removeprefix("found_"): term for term in TERMS}
    for one, other in (
        ("stop_positive_1", "stop_negative_2"), ("saturating_spring", "viscous_damping_negative_side"),
        ("square_damping", "slip"), ("slip", "dry_damping"),
    ):  # fmt: skip
        first, second = by_name[one], by_name[other]
        if sign < 0 and first.declaration.parameters[0].lower == 0.0:
            continue  # a strength that is never negative
        strengths = sign * 30.0, 12.0
        both = joined(first, second, sign)
        known = {**REFERENCES, **motion(random, 600)}
        own, others = values_of(first.effect, random), values_of(second.effect, random)
        alone = [
            force_of(term, {**known, **values, STRENGTH: strength})
            for term, values, strength in zip((first, second), (own, others), strengths, strict=True)
        ]
        renamed = {f"{name.removesuffix('_x')}_b_x": value for name, value in others.items() if name != STRENGTH}
        known |= {**own, **renamed, STRENGTH: strengths[0], SHARE: strengths[1] / abs(strengths[0])}
        assert force_of(both, known) == pytest.approx(sum(alone)), both.declaration.id
        bounds = both.declaration.parameters[0]
        assert (bounds.upper if sign < 0 else bounds.lower) == 0.0


def test_two_terms_have_four_numbers_and_one_state_at_most():
    by_name = {term.declaration.id.removeprefix("found_"): term for term in TERMS}
    assert may_join(by_name["slip"], by_name["stop_positive_1"])
    pair = joined(by_name["dry_damping"], by_name["viscous_damping"], 1.0)
    assert not may_join(pair, by_name["square_damping"])
    assert not may_join(by_name["slip"], by_name["smooth_slip"])
    assert not may_join(by_name["bent_damping"], by_name["stop_positive_1"])
    assert not may_join(by_name["slip"], by_name["stiffness_power_a"])
