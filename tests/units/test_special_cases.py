"""A general effect is named only where it takes half of what its special case leaves."""

from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp_identification.diagnosis.weighing import Scales
from pipeclamp_models.law.law import Structure


def candidate(effect, left, squares, structure="power"):
    """Give a law with an effect that leaves these mean squares on left-out conditions."""
    law = SimpleNamespace(structure=Structure(structure, (effect,) if effect else ()))
    score = SimpleNamespace(mean_squares=np.full(6, left))
    return SimpleNamespace(
        effects=(effect,), result=SimpleNamespace(law=law), score=score, squares=squares, akaike=squares,
        objections=(), may_be_cause=True,
    )  # fmt: skip


def usable(*candidates):
    law = candidate("", 100.0, 1000.0)
    scales = Scales(law.result.law.structure, None, law, candidates, None, 1, print)
    return [each.effects[0] for each in scales.usable]


@pytest.mark.parametrize(("general", "special"), [("inner_mass", "inertia"), ("gas_spring", "asymmetry")])
@pytest.mark.parametrize(("left", "named"), [(7.0, False), (3.0, True)])
def test_beside_its_special_case(general, special, left, named):
    found = usable(candidate(general, left, 90.0), candidate(special, 8.0, 100.0))
    assert found == ([general, special] if named else [special])


def test_beside_what_it_only_acts_like():
    """Of those the better one is named, or both where the data can't tell."""
    assert usable(candidate("gap", 7.0, 90.0), candidate("play", 8.0, 100.0)) == ["gap", "play"]
