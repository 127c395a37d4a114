"""A scaled term in other forms of following its condition: the same term, by a factor >= 0 that goes where it says."""

from types import SimpleNamespace

import numpy as np
import pytest
from test_discovery_grammar import SIZES, function, motion
from test_discovery_refined import VARIED, force_of, values_of

from pipeclamp_identification.discovery.conditions import LEVEL, STEEPNESS
from pipeclamp_identification.discovery.following import followed_otherwise
from pipeclamp_identification.discovery.freeing import refinements
from pipeclamp_identification.discovery.grammar import MOST_PARAMETERS, terms
from pipeclamp_identification.discovery.refining import Refining
from pipeclamp_models.base.processes import ALONE
from pipeclamp_models.base.signals import REFERENCES
from pipeclamp_models.realise.sizes import number_of

BY_ID = {term.declaration.id.removeprefix("found_"): term for term in terms(*VARIED)}
FORMS = {"exponential", "beyond", "below", "levelling", "setting_in", "fading"}


def forms_of(name):
    return {
        each.declaration.id.removeprefix(f"found_{name}_"): each for each in followed_otherwise(BY_ID[name], *VARIED)
    }


@pytest.mark.parametrize(
    ("name", "missing"),
    [
        ("dry_damping_by_a", set()), ("slip_by_f", set()), ("dry_damping_by_t", {"levelling"}),
        ("slip_by_tension_n", {"exponential"}),  # as it was found
        ("bent_damping_by_f", {"setting_in", "fading"}),  # too many numbers
        ("slip", FORMS), ("damping_step_t", FORMS), ("warm_relaxing", FORMS),
    ],
)  # fmt: skip
def test_a_scaled_term_is_asked_in_each_other_form(name, missing):
    """Of a friction that is gone above a temperature a power of it had been told, 56 % off."""
    assert set(forms_of(name)) == FORMS - missing
    for each in forms_of(name).values():
        assert len(each.declaration.parameters) <= MOST_PARAMETERS
        assert each.shorter == BY_ID[name].shorter
        assert all(np.isfinite(number_of(at, SIZES)) for one in each.effect.parameters for at in one.starts)


SCALED_BY = ("dry_damping_by_a", "slip_by_f", "dry_damping_by_t", "slip_by_tension_n")
STEPPING = {name: term for name, term in BY_ID.items() if "_step_" in name}
STEPPING |= {f"{name}_{form}": forms_of(name)[form] for name in SCALED_BY for form in ("setting_in", "fading")}


def test_nothing_steps_about_a_level_beyond_the_tests():
    """Of a measured device's friction it had been told that it steps at 3.54 Hz, where the tests end at 2 Hz."""
    assert {name.rpartition("_")[2] for name in STEPPING} >= {"a", "f", "t", "n", "fading"}
    for name, term in STEPPING.items():
        (level,) = (one for one in term.effect.parameters if one.name == LEVEL)
        lower, upper = (None if bound is None else number_of(bound, SIZES) for bound in (level.lower, level.upper))
        ends = [size for key, size in SIZES.items() if key.endswith("_highest")] + [*VARIED[1].values()]
        assert upper in ends, name
        assert all(number_of(start, SIZES) < upper for start in level.starts)
        if name.endswith("_t") or "_by_t_" in name:
            assert lower == SIZES["T_lowest"]


@pytest.mark.parametrize(("signal", "low", "level", "high"), [("a", 0.0, 0.4, 5.0), ("t", 150.0, 400.0, 2000.0)])
def test_each_form_goes_where_it_says(signal, low, level, high):
    plain = BY_ID["viscous_damping"]
    known = {
        **REFERENCES,
        "v": 7.0,
        "F_x": 1.0,
        LEVEL: level,
        STEEPNESS: 100 * (100.0 if signal == "t" else 1.0) / level,
    }
    whole = float(function(plain.effect.force)(**known))
    ends = {"beyond": (0.0, None), "below": (None, 0.0), "setting_in": (0.0, 1.0), "fading": (1.0, 0.0)}
    for name, shares in ends.items():
        force = function(forms_of(f"viscous_damping_by_{signal}")[name].effect.force)
        for at, share in zip((low, high), shares, strict=True):
            found = float(force(**known, **{signal.upper(): at})) / whole
            assert found > 0.1 if share is None else found == pytest.approx(share, abs=1e-3)


def test_no_form_drives_the_motion():
    random = np.random.default_rng(4)
    scaled = [name for name in BY_ID if name.endswith(("_by_a", "_by_t", "_by_tension_n"))]
    dampers = [name for name in scaled if BY_ID[name].family == "damper"][::9]
    for name in dampers:
        for form in forms_of(name).values():
            known = {**REFERENCES, **motion(random, 400), **values_of(form.effect, random), "F_x": 50.0}
            assert np.all(force_of(form, known) * known["v"] >= 0), form.declaration.id


def test_a_level_does_not_move_with_its_own_condition():
    (form,) = (each for name, each in forms_of("dry_damping_by_t").items() if name == "fading")
    values = {one.symbol: 1.0 for one in form.declaration.parameters}
    refined = [each.acts_like for each, _ in refinements(form, values, *VARIED)]
    assert any(words.endswith("scaled with the frequency") for words in refined)
    assert not any(words.endswith("scaled with the temperature") for words in refined)


def test_each_form_is_fitted_from_two_levels_with_the_rest_as_it_was():
    term = BY_ID["thinning_damping_by_t"]
    values = {"k10": 1800.0, "F_x": 76.0, "v_x": 0.7, "s_x": -1.0}
    one = SimpleNamespace(term=term, judged=SimpleNamespace(result=SimpleNamespace(law=SimpleNamespace(values=values))))
    forms = Refining(VARIED, ALONE)._following(one, SimpleNamespace(sizes=SIZES))
    starts = {form.declaration.id.rpartition("_")[2]: given for form, given in forms}
    low, high = (SIZES["T_lowest"] + share * (SIZES["T_highest"] - SIZES["T_lowest"]) for share in (0.3, 0.6))
    assert [start["l_x"] for start in starts["fading"]] == pytest.approx([low, high])
    assert [start["s_x"] for start in starts["exponential"]] == [-0.5, 0.5]
    assert all(start.items() >= {"k10": 1800.0, "F_x": 76.0, "v_x": 0.7}.items() for start in starts["fading"])
