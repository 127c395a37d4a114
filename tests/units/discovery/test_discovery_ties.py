"""What counts as one where terms do equally well: laws that come to the same, forms that draws take, lengths."""

from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp_identification.discovery import hearing
from pipeclamp_identification.discovery.columns import TermColumn
from pipeclamp_identification.discovery.grammar import terms
from pipeclamp_identification.discovery.guards import comes_back, not_in_the_catalogue
from pipeclamp_identification.discovery.hearing import Hearing, Hurdle, RefittedTerm
from pipeclamp_models.base.errors import UserError

TERMS = {term.declaration.id: term for term in terms(("A", "f"), {})}
GROUPS = np.repeat(np.arange(8), 4)
TURNS = np.where(GROUPS % 2, 20.0, -20.0)
"""Squares of runs that make one term better in some groups and another one in the others."""


def judged(squares, effects=("oil_damper",), **further):
    return SimpleNamespace(
        effects=effects, objections=(), squares=float(np.sum(squares)), score=SimpleNamespace(squares=squares),
        **further,
    )  # fmt: skip


def refitted(name, squares, residual=None):
    """A term that was fitted together with a law."""
    residual = np.sqrt(squares)[:, None] if residual is None else residual
    one = judged(squares, (name,), fitted=SimpleNamespace(residual=residual), akaike=float(np.sum(squares)))
    return RefittedTerm(one, TERMS[name], TermColumn(TERMS[name], {}, np.zeros((len(GROUPS), 5)), True))


def heard(every, residual=None, **further):
    """What they are asked with."""
    law = SimpleNamespace(fitted=SimpleNamespace(residual=residual))
    return Hearing(SimpleNamespace(law=law, problem=SimpleNamespace(groups=GROUPS)), [], every, **further)


@pytest.mark.parametrize(
    ("effect", "named", "passes", "told"),
    [
        (100.0, (), True, "no effect that may be named does as well"),
        (100.0, ("oil_damper",), False, "beside all effects of the law, does as well; `add` it instead"),
        (50.0, (), False, "beside all effects of the law, does better"),
    ],
)
def test_an_effect_beside_those_that_a_term_stands_for_wins_no_tie(effect, named, passes, told):
    """One term in the place of an element had been refused for a law with that element and another one beside it."""
    found, longer = judged(100.0 + TURNS), judged(effect - TURNS)
    guard = not_in_the_catalogue(found, [], SimpleNamespace(groups=GROUPS), named=named, longer=[longer])
    assert guard.passed == passes
    assert told in guard.words


def test_in_the_place_of_effects_the_catalogue_is_asked_there(monkeypatch):
    """Without the effects that the term does without, too; what only modifies one of them is none."""
    asked = []

    def without(structure, gone, near, problem):
        asked.append((structure, gone))
        if structure == "modifies":
            raise UserError("slip: no term has it")
        return SimpleNamespace(effects=(), near=near)

    monkeypatch.setattr(hearing, "fitted_without", without)
    monkeypatch.setattr(hearing, "replace", lambda judged, effects: (effects, judged.near))
    listed = [
        SimpleNamespace(effects=(name,), result=SimpleNamespace(law=SimpleNamespace(structure=name)))
        for name in ("adds", "modifies")
    ]
    bar = Hurdle(None, listed, None, ())
    assert heard([], bar=bar).catalogue == listed
    assert heard([], bar=bar, gone=("memory",)).catalogue == [(("adds",), listed[0])]
    assert asked == [("adds", ("memory",)), ("modifies", ("memory",))]


@pytest.mark.parametrize(("other", "passes"), [(0.1, True), (1.0, False)])
def test_terms_with_which_a_law_comes_to_the_same_come_back_as_one(other, passes, monkeypatch):
    """Two that slip took the same half of the squares in turns, and neither came back in 80 % of draws.

    What is left of them beyond the tangents of a law whose parts stand for most of it looked different.
    """
    taken, apart = np.random.default_rng(2).standard_normal((2, len(GROUPS), 5))
    one, same = refitted("found_slip", 50.0 + TURNS), refitted("found_smooth_slip", 50.0 - TURNS)
    in_turns = [one.judged, same.judged]
    one = refitted("found_slip", 50.0 + TURNS, np.zeros_like(taken))
    same = refitted("found_smooth_slip", 50.0 - TURNS, other * apart)
    asked = heard([one, same], taken, bar=None)
    monkeypatch.setattr(Hearing, "alike", lambda self, place: np.arange(2) == place)
    assert asked.returning(0).tolist() == [True, passes]
    guard = comes_back(in_turns, asked.returning(0), GROUPS)
    assert guard.passed == passes


def test_a_form_that_draws_of_the_conditions_take_is_a_rival():
    """One whose squares lay 60 apart of 1,600 wasn't told of, though it did better in a third of the draws."""
    best = refitted("found_saturating_damping", 50.0 + TURNS)
    turn = refitted("found_bent_damping", 52.0 - TURNS)
    longer = refitted("found_bent_damping_by_f", 51.9 - TURNS)
    never = refitted("found_viscous_damping", 90.0 + TURNS)
    asked = heard([longer, best, never, turn], bar=None)
    assert turn.squares > best.squares + 50
    assert asked.rivals_of(best, []) == [turn]
    assert asked.rivals_of(best, [turn]) == [turn]
    assert heard([best, never], bar=None).rivals_of(best, []) == []
