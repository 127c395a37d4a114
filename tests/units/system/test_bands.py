"""Bands: derivatives against responses that are solved anew, and what a law's file brings."""

from __future__ import annotations

import json

import numpy as np
import pytest
from banded import FORM, SPREAD, banded

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.bundled import open_law
from pipeclamp_system.bands.band import Band, band_of, beside_words, ends_words, steps_of
from pipeclamp_system.bands.quantities import unknown_of_clamps
from pipeclamp_system.bands.response import BandedSystem, banded_system, response_bands
from pipeclamp_system.bands.varied import varied
from pipeclamp_system.response.run import run_response
from pipeclamp_system.steady.states import amplitudes_of


def of_curve(curve):
    """The peaks of clamp and probe, and the frequencies at which a curve turns back, from many states about them."""
    states = curve.states
    frequency = np.array([state.frequency for state in states])
    amplitude = np.array([amplitudes_of(state) for state in states])
    found = []
    for values in (amplitude[:, 0], amplitude[:, 1]):
        at = int(values.argmax())
        own = slice(at - 1, at + 2)
        found.append(float(np.polyval(fit := np.polyfit([-1, 0, 1], values[own], 2), -fit[1] / (2 * fit[0]))))
    turns = np.flatnonzero(np.diff(np.sign(np.diff(frequency)))) + 1
    for at in turns.tolist():
        fit = np.polyfit([-1, 0, 1], frequency[at - 1 : at + 2], 2)
        found.append(float(np.polyval(fit, -fit[1] / (2 * fit[0]))))
    return np.array(found)


@pytest.mark.parametrize(("level", "hard"), [(2.0, 0.0), (4.0, 200.0)])
def test_derivatives_are_those_of_responses_solved_anew(tmp_path, level, hard):
    """Of peaks at clamp and probe, and of turning points, along a direction of all that isn't known."""
    path = banded(tmp_path, level, hard=hard, spread=SPREAD.model_copy(update={"beyond": {}}))
    response = run_response(path)
    (curve,) = response.curves
    solver = banded_system(path, response)
    sizes = np.sqrt(np.diag(solver.unknown.covariance))
    direction = sizes * np.random.default_rng(1).choice([-1.0, 1.0], len(sizes))
    direction[solver.unknown.of_kind("solution")] = 0.0  # what a solver leaves out is no law's
    pieces = [of_point[0] for of_point in solver.moving(curve)]
    told = [float(piece.peak_moves(sizes)[1] @ direction) for piece in pieces]
    told += [float(pieces[0].turn_moves(at) @ direction) for at in pieces[0].turns()]
    assert len(told) == (4 if hard else 2)
    above, below = (of_curve(solver.solved(curve, sign * direction, apart=False)) for sign in (1, -1))
    anew = (above - below) / 2
    assert told[:2] == pytest.approx(anew[:2], rel=0.02)
    assert told[2:] == pytest.approx(anew[2:], rel=0.1)  # their states are far apart


def test_a_band_is_as_wide_as_what_is_known_says(tmp_path, monkeypatch):
    """By its width in first order, which is there though no motion is found at its ends."""

    def lost(*_, apart=True):
        raise UserError("no steady state is found")

    monkeypatch.setattr(BandedSystem, "solved", lost)
    path = banded(tmp_path, 1.0)
    response = run_response(path)
    wide = response_bands(path, response, 95.0, {"clamp1": 1e3}).curves[0].peaks[0].amplitude
    banded(tmp_path, 1.0, spread=None)
    narrow = response_bands(path, response, 95.0)
    assert narrow.curves[0].peaks[0].amplitude.deviation < 0.75 * wide.deviation
    said = " ".join(narrow.words())
    assert "doesn't tell what its tests scatter" in said
    assert "no motion is found with the law at the low end of its band" in said


def test_beyond_its_tests_a_law_is_less_sure():
    file = open_law("emwm2").model_copy(update={"spread": SPREAD})
    law = varied(file)
    highest = file.range["A"].maximum
    inside, near, far = (law.form({"A": factor * highest} if factor > 1 else {}) for factor in (1.0, 1.5, 3.0))
    assert inside == FORM
    assert inside.damping < near.damping < far.damping
    assert law.form({"nothing_known_of": 3.0}) == FORM


def test_normal_steps_and_shares():
    assert steps_of(95.0) == pytest.approx(1.95996, rel=1e-5)
    assert json.loads(SPREAD.model_dump_json())["runs"] == {"stiffness": 0.01, "damping": 0.03}
    law = varied(open_law("emwm2").model_copy(update={"spread": SPREAD}))
    what = unknown_of_clamps([law, law], ["one", "other"], solved=False)
    slopes = np.ones(len(what.quantities))
    band = band_of(10.0, slopes, what, 2.0, 1.0)
    assert band.deviation**2 == pytest.approx(float(what.covariance.sum()) + 1.0)
    assert band.beyond(band.high, 2.0) == pytest.approx(0.02275, rel=1e-3)


@pytest.mark.parametrize(
    ("ends", "told"),
    [
        ((4.3601, 4.36004, 4.36016), "4.3601 Hz (95%: 4.36 to 4.3602)"),
        ((4.3601, 4.351, 4.369), "4.36 Hz (95%: 4.351 to 4.369)"),
        ((4.3601, 4.3601, 4.3601), "4.36 Hz (95%: 4.36 to 4.36)"),
    ],
)
def test_the_ends_of_a_narrow_band_are_told_apart(ends, told):
    """Of a peak's frequency "4.36 Hz (95%: 4.36 to 4.36)" had been said."""
    assert ends_words(Band(*ends, ends[0], 0.0, {}, ()), "Hz", 95.0) == told


@pytest.mark.parametrize(
    ("ends", "told"), [((5.993, 5.286, 5.919), True), ((5.9, 5.286, 5.919), False), ((4.36, 4.36000001, 4.36), False)]
)
def test_a_number_outside_of_its_own_band_says_why(ends, told):
    """A peak of "5.993 mm (95%: 5.286 to 5.919)" had stood there without a word."""
    assert ("tests near that motion lie beside the law" in beside_words(Band(*ends, ends[1], 0.1, {}, ()))) is told
