"""A level that the law's own curve over a condition can't foretell tells of no effect whether it helps."""

from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp.show.diagnosis import against
from pipeclamp_identification.diagnosis.foretold import takes_part

SAYS_WORSE = "on left-out temperature"


def parameter(name, follows=(), levels=2):
    return SimpleNamespace(name=name, follows=follows, levels=levels)


K, SLOPE, BEND = parameter("k10"), parameter("c_T1", ("T",)), parameter("c_T2", ("T",), 3)


def judged(names, fitted, squares, on_temperature, akaike):
    score = SimpleNamespace(mean_squares=np.full(8, squares), squares=np.full(8, squares))
    return SimpleNamespace(
        effects=("viscous",), result=SimpleNamespace(fitted_parameters=fitted, equations=SimpleNamespace(names=names)),
        score=score, missing=8 * squares, heldout_nrmse=squares, heldout_by={"temperature": on_temperature},
        akaike=akaike, lack=SimpleNamespace(share=2.0, rms=2.0), objections=(), reservations=(),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("temperatures", "curve", "brought", "asked"),
    [
        (3, [SLOPE, BEND], parameter("c1"), False),
        (4, [SLOPE, BEND], parameter("c1"), True),
        (3, [SLOPE], parameter("c1"), True),
        (3, [SLOPE, BEND], parameter("beta", ("T",)), True),
    ],
)
def test_an_effect_is_asked_for_levels_that_are_foretold(temperatures, curve, brought, asked, monkeypatch):
    """Quadratic damping, right to four digits, took 92 % beside damping that follows three temperatures.

    `unknown` had been said: without one of the three, the curve of the latter had foretold it worse.
    """
    kelvin = np.repeat(np.linspace(293.0, 453.0, temperatures), 4)
    loops = SimpleNamespace(temperature_K=kelvin, density_g_cm3=np.full(len(kelvin), np.nan), conditions={})
    names = [K.name, SLOPE.name, BEND.name]
    law = judged(names, [K, *curve[1:]], 10.0, 0.03, 100.0)  # the slope at its bound
    better = judged([*names, brought.name], [K, *curve, brought], 1.0, 0.05, 50.0)
    problem = SimpleNamespace(loops=loops, groups=np.arange(8))
    assert takes_part(better, law, problem) is not asked
    monkeypatch.setattr("pipeclamp.show.diagnosis.simpler_words", lambda *_: ())
    monkeypatch.setattr("pipeclamp.show.diagnosis.left_out_at_once", lambda loops: "A, f")
    said = against(better, SimpleNamespace(law=law, loops=loops, candidates=[better], tolerance=1.0))
    assert any(SAYS_WORSE in words for words in said) is asked
