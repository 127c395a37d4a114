"""The check that a law can't create energy, and the quadrature it stands on."""

import json
import math

import pytest

from pipeclamp_fmu.build import passivity, require_passive
from pipeclamp_fmu.contents.clamp_of_law import clamp_model
from pipeclamp_fmu.contents.passivity import CYCLES_ACCOUNTED, balance, conditions, require_dissipation
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.file import read_law
from pipeclamp_models.realise.scalar_law import loaded

RANGE = ((0.2, 1.0), (1.0, 5.0), (293.15, 573.15))

LAW = """
STATES = {states}
CONDITIONS = ()

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
    result = balance(VISCOUS, CYCLES_ACCOUNTED[0], (A, f, 300.0), 128)
    assert result.dissipated == pytest.approx(math.pi * 2.0 * 2 * math.pi * f * A * A, rel=1e-12)


def test_the_dissipation_of_an_elastic_slip_element_is_its_parallelogram():
    k_s, z_s, A = 500.0, 60.0, 0.5
    body = f"z = min(max(state[0] + {k_s} * (y - y_previous), -{z_s}), {z_s}); return z, z * z / {2 * k_s}, (z,)"
    result = balance(law(body, states="(('z', 0.0),)"), CYCLES_ACCOUNTED[0], (A, 1.0, 300.0), 4096)
    assert result.dissipated == pytest.approx(4 * z_s * (A - z_s / k_s), rel=1e-4)


def test_every_cycle_stays_within_its_amplitude():
    for cycle in CYCLES_ACCOUNTED:
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


NOTCHES = {
    "A": {"factor": "1 - 3*q*exp(-((A - 2.6)/0.15)**2)"},
    "f": {"factor": "1 - 3*q*exp(-((f - 17)/1.0)**2)"},
    "T": {"factor": "1 - 3*q*exp(-((T - 330)/4)**2)"},
    "A and T": {"factor": "1 - 3*q*exp(-((A - 1.1)/0.2)**2 - ((T - 400)/10)**2)"},
    "y": {"force": "-q*2*v*exp(-((y - 1.23)/0.02)**2)"},
    "the speed, whichever way it goes": {"force": "q*4*y*v**2/(4 + v**2)"},
    "A, with memory": {"factor": "1 - 30*q*exp(-((A - 2.6)/0.15)**2)", "base": "memory"},
}
"""Damping that a declared effect turns round in a part of the range that no coarse grid meets."""
SOUND = {
    "nearly none": {"factor": "1 - 0.9*q*exp(-((A - 2.6)/0.15)**2)"},
    "a step that depends on y": {"force": "q*100*sign(y - 0.3)", "c0": 0.0},
    "a hard stop": {"effects": ("end_stop",), "c0": 0.0},
    "friction": {"effects": ("coulomb",)},
}


@pytest.fixture
def declared(tmp_path, write_law):
    def declare(base="power", effects=(), factor="", force="", c0=0.5):
        values = {"k10": 40.0, "c0": c0, "alpha0": 1.0, "k_s": 50.0, "z_s": 0.5, "k_e": 1e5, "y_e": 0.7, "F_c": 5.0}
        write_law(tmp_path / "law.json", values, base, effects)
        if factor or force:
            law = json.loads((tmp_path / "law.json").read_text(encoding="utf-8"))
            symbol = {"symbol": "q", "unit": "-", "meaning": "strength", "start": 1.0}
            effect = {"id": "odd", "title": "an odd effect", "looks_like": "odd loops", "parameters": [symbol]}
            scales = [{"coefficient": "damping", "factor": factor}] if factor else []
            law["declared"] = [effect | {"scales": scales, "force": force}]
            law["effects"] = [*effects, "odd"]
            law["coefficients"]["q"] = {"value": 1.0, "unit": "-", "state": "given"}
            (tmp_path / "law.json").write_text(json.dumps(law), encoding="utf-8")
        file = read_law(tmp_path / "law.json")
        return clamp_model(file), file

    return declare


@pytest.mark.parametrize("name", NOTCHES)
def test_energy_fed_in_between_the_points_of_a_grid_is_found(declared, name):
    with pytest.raises(UserError, match="would create energy"):
        require_passive(*declared(**NOTCHES[name]))


@pytest.mark.parametrize("name", SOUND)
def test_what_dissipates_or_gives_back_is_proved(declared, name):
    law = declared(**SOUND[name])
    require_passive(*law)
    assert "proved for any motion" in passivity(*law).words()


def test_what_is_proved_needs_values_all_the_same():
    """At the highest amplitude alone there is none."""
    source = law("return c * v + (0.0 if c < 1.0 else math.inf), 0.0, ()", k="A")
    with pytest.raises(UserError, match=r"no finite force for a sinusoid within A = 1 mm"):
        require_dissipation("broken", source, *RANGE, proved=True)


def test_a_place_that_pushes_along_is_told_where_no_cycle_gains_by_it(declared):
    """What it pushes along in a window of 2 um at the highest speeds is less than what the way there costs."""
    law = declared(force="-q*2*v*exp(-((y - 1.23)/0.0003)**2)*exp(-((v - 200)/5)**2)")
    require_passive(*law)
    words = passivity(*law).words()
    assert "isn't proved" in words
    assert "pushes along" in words


def test_a_law_with_memory_is_searched(declared):
    law = declared(base="memory")
    require_passive(*law)
    assert "isn't proved" in passivity(*law).words()
