"""The mean force that elements which stick all the way round can hold: theirs alone, not that of those which slip."""

import numpy as np
import pytest

from pipeclamp_models.law.law import Law, Structure
from pipeclamp_models.realise.force import force_of_law
from pipeclamp_models.realise.motion import Motion

SLIPPING = {"k_s1": 700.0, "z_s1": 500.0}
AMPLITUDES = (1.0, 2.0, 4.0)


def law(sticking: float, limit: float) -> Law:
    """Give one element that slips at 500 N beside one of this stiffness and slip force."""
    base = Structure("power", ("memory:2",))
    still = dict.fromkeys(base.equations.names, 0.0) | {"alpha0": 1.0}
    return Law(base, still | SLIPPING | {"k_s2": sticking, "z_s2": limit}, 0.01, 0.001)


def sines() -> Motion:
    theta = 2 * np.pi * np.arange(256) / 256
    A = np.array(AMPLITUDES)[:, None]
    signals = {name: np.full((len(A), 1), value) for name, value in (("f", 1.0), ("T", 293.15))}
    h = np.full((len(A), 1), 1 / 256)
    y, v, a = A * np.cos(theta), -2 * np.pi * A * np.sin(theta), -((2 * np.pi) ** 2) * A * np.cos(theta)
    return Motion(y, v, a, signals | {"A": A}, h)


@pytest.mark.parametrize("sticking", [0.5, 5.0, 100.0])
def test_a_soft_element_that_never_slips_holds_no_more_than_it_was_stretched_by(sticking):
    """A small stiffness beside a large slip force had let every run have a mean force of its own, as large as the
    largest of the motions makes the slipping element's."""
    found = force_of_law(law(sticking, 1e6), sines())
    assert found.adrift.all()
    assert found.held == pytest.approx(np.full(len(AMPLITUDES), sticking * max(AMPLITUDES)), rel=0.01)


def test_where_all_slips_nothing_is_held():
    found = force_of_law(law(500.0, 100.0), sines())
    assert not found.adrift.any()
    assert not found.held.any()
