"""The check that a law can't create energy, and the quadrature it stands on."""

import math

import pytest

from pipeclamp_fmu.contents.passivity import CYCLES, balance, conditions, loaded, require_dissipation
from pipeclamp_models.base.errors import UserError

RANGE = ((0.2, 1.0), (1.0, 5.0), (293.15, 573.15))

LAW = """
STATES = {states}

def coefficients(p, A, f, T):
    return ({k},)

def step(k, state, y_previous, y, v, h):
    (c,) = k
    {body}
"""


def law(body, k="2.0", states="()"):
    return loaded(LAW.format(body=body, k=k, states=states), ())


VISCOUS = law("return 900.0 * y + 50.0 * y**3 + c * v, 450.0 * y * y + 12.5 * y**4, ()")


def test_the_dissipation_of_a_viscous_clamp_is_its_closed_form():
    A, f = 0.7, 3.0
    result = balance(VISCOUS, CYCLES[0], (A, f, 300.0), 128)
    assert result.dissipated == pytest.approx(math.pi * 2.0 * 2 * math.pi * f * A * A, rel=1e-12)


def test_the_dissipation_of_an_elastic_slip_element_is_its_parallelogram():
    k_s, z_s, A = 500.0, 60.0, 0.5
    body = f"z = min(max(state[0] + {k_s} * (y - y_previous), -{z_s}), {z_s}); return z, z * z / {2 * k_s}, (z,)"
    result = balance(law(body, states="(('z', 0.0),)"), CYCLES[0], (A, 1.0, 300.0), 4096)
    assert result.dissipated == pytest.approx(4 * z_s * (A - z_s / k_s), rel=1e-4)


def test_every_cycle_stays_within_its_amplitude():
    for cycle in CYCLES:
        for n in range(1000):
            theta = 2 * math.pi * n / 1000
            assert abs(cycle.offset + sum(a * math.sin(k * theta + p) for k, a, p in cycle.harmonics)) <= 1 + 1e-12


def test_the_grid_holds_the_ends_of_the_range():
    points = list(conditions(*RANGE))
    assert (0.2, 1.0, 293.15) in points
    assert (1.0, 5.0, 573.15) in points
    assert list(conditions((0.5, 0.5), (1.0, 1.0), (300.0, 300.0))) == [(0.5, 1.0, 300.0)]


@pytest.mark.parametrize("source", [VISCOUS, law("return 900.0 * y, 450.0 * y * y, ()")])
def test_a_law_that_creates_nothing_passes(source):
    require_dissipation("sound", source, *RANGE)


@pytest.mark.parametrize(
    ("source", "words"),
    [
        (law("return 900.0 * y - c * v, 450.0 * y * y, ()"), ["would create energy", "J per cycle"]),
        (law("return 900.0 * y + c * v, 450.0 * y * y, ()", k="T - 300.0"), ["would create energy", "T = 293.15 K"]),
        (law("return 900.0 * y + c * v, 450.0 * y * y, ()", k="0.9 - A"), ["would create energy", "A = 1 mm"]),
        # Damping that drives small motion and brakes large: only cycles smaller than A show it.
        (law("return 900.0 * y + c * v * (y * y / 0.01 - 1.0), 450.0 * y * y, ()"), ["a tenth of a sinusoid"]),
        # One that only a motion with an offset shows.
        (law("return 900.0 * y + c * v * (1.0 - 1.5 * y), 450.0 * y * y, ()"), ["a small sinusoid on a large offset"]),
        (law("return y / (y - y), 0.0, ()"), ["has no value", "division by zero"]),
        (law("return math.inf * (y + 2.0), 0.0, ()"), ["no finite force"]),
    ],
)
def test_a_law_that_creates_energy_is_refused(source, words):
    with pytest.raises(UserError) as refused:
        require_dissipation("bad", source, *RANGE)
    message = str(refused.value)
    assert "'bad'" in message
    assert all(word in message for word in words), message
