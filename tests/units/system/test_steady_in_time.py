"""Dry friction behind a clearance: steady motions are marched in time, and what doesn't repeat is told as such.

The truth is an integrator of its own: the cantilever's modes by Dormand-Prince of order 8 to 1e-9; the clamp free,
sliding out or back or stuck, each change located as an event. Half the peak-to-peak displacement of clamp and tip,
40 to 80 cycles from rest. That of the slip element is a leapfrog of 40000 steps a cycle with the clamp's place as such.
"""

from __future__ import annotations

import numpy as np
import polars as pl
import pytest
from cantilever import cantilever, shaken
from stick_slip import Modal, Rubbing, integrate

from pipeclamp.pages.system.response import IN_TIME, response_picture
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.file import law_of, read_law
from pipeclamp_models.pipe.description import parse_pipe, read_pipe
from pipeclamp_models.pipe.modes import reduce
from pipeclamp_models.realise.scalar_law import scalar_law
from pipeclamp_system.bands.response import banded_system
from pipeclamp_system.description.system import read_system
from pipeclamp_system.response.run import run_response
from pipeclamp_system.response.summary import response_summary
from pipeclamp_system.response.table import write_response
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.cycles import machine_clamps
from pipeclamp_system.steady.described import steady_clamps
from pipeclamp_system.steady.start import settled
from pipeclamp_system.steady.states import half_range

DRY = {"k10": 80.0, "c0": 0.02, "alpha0": 1.0, "F_c": 10.0, "g_p": 0.1}
TRUTH = {3.0: (0.396757, 0.783533), 4.6: (0.519309, 1.012269), 8.6: (0.754550, 1.574535)}
HELD = [
    ({"k10": 74.0, "c0": 0.006, "F_c": 7.4, "g_p": 0.2}, 2.0, 4.1, (0.645442, 1.266878)),
    ({"k10": 168.0, "c0": 0.004, "F_c": 26.0, "g_p": 0.35}, 1.8, 5.35, (0.486052, 1.194848)),
    ({"k10": 264.0, "c0": 0.025, "F_c": 11.8, "g_p": 0.347}, 4.74, 4.3, (0.683158, 1.679890)),
]
SLIP = {"k10": 20.0, "c0": 0.02, "alpha0": 1.0, "k_s": 100.0, "z_s": 20.0, "g_p": 0.3}
THRICE = {"k10": 158.5369, "c0": 0.01511474, "alpha0": 1.0, "F_c": 1.210632, "g_p": 0.3835742}


def files(folder, write_law, values, effects, acceleration=3.0, ratio=0.01, clamps=("clamp1",), response=""):
    write_law(folder / "law.json", values, "power", effects)
    places = {name: 2.0 - 0.5 * index for index, name in enumerate(clamps)}
    (folder / "pipe.toml").write_text(cantilever(ratio, 60.0, places, {"tip": 3.0}), encoding="utf-8")
    (folder / "system.toml").write_text(shaken(1.0, 3.0, acceleration) + response, encoding="utf-8")
    return folder / "system.toml"


def system(file, acceleration=3.0):
    pipe = reduce(read_pipe(file.parent / "pipe.toml"))
    clamps = steady_clamps(read_system(file), pipe, file.parent, None, "test")
    return SteadySystem(pipe, clamps, lambda frequency: acceleration)


@pytest.mark.parametrize("frequency", sorted(TRUTH))
def test_dry_friction_behind_a_clearance_has_its_steady_motion(tmp_path, write_law, frequency):
    state = system(files(tmp_path, write_law, DRY, ("coulomb", "play"))).at(frequency)
    assert state is not None
    assert np.concatenate([half_range(state.clamps), half_range(state.probes)]) == pytest.approx(
        TRUTH[frequency], rel=3e-3
    )
    assert state.stable
    assert state.truncated < 2e-3
    assert state.cycles > 0


@pytest.mark.parametrize(("values", "acceleration", "frequency", "truth"), HELD)
def test_a_pipe_that_turns_within_the_clearance_leaves_the_clamp_where_friction_holds_it(
    tmp_path, write_law, values, acceleration, frequency, truth
):
    """Where the clamp slipped back as the pipe's speed passed zero, they were up to 8 % off."""
    file = files(tmp_path, write_law, values | {"alpha0": 1.0}, ("coulomb", "play"), acceleration)
    marched = system(file, acceleration).marched(frequency)
    assert marched.round == 1
    assert half_range(marched.points) == pytest.approx(truth, rel=2e-3)


def test_a_march_from_rest_is_done_once(tmp_path, write_law, monkeypatch):
    """A curve's beginning had been marched for the balance, for its own motion, and as the first of those between."""
    built = system(files(tmp_path, write_law, DRY, ("coulomb", "play")))
    begun: list[float] = []
    march = type(built.in_time)._in_steps_enough
    monkeypatch.setattr(
        type(built.in_time),
        "_in_steps_enough",
        lambda self, frequency, *rest: begun.append(frequency) or march(self, frequency, *rest),
    )
    settled(built, 4.6)
    state, marched = built.at(4.6), built.marched(4.6)
    assert begun == [4.6]
    np.testing.assert_array_equal(state.clamps, marched.points[:1])
    assert built.marched(4.6, marched.end) is not marched
    assert begun == [4.6, 4.6]


def test_laws_that_differ_in_values_alone_are_compiled_once(tmp_path, write_law):
    def machine(values, *effects):
        write_law(tmp_path / "law.json", values, "power", effects)
        return machine_clamps([scalar_law(law_of(read_law(tmp_path / "law.json")))])

    first = machine(DRY, "coulomb", "play")
    assert machine(DRY | {"F_c": 20.0}, "coulomb", "play") is first
    assert machine(DRY, "coulomb") is not first


def test_its_phase_is_that_of_the_sine(tmp_path, write_law):
    """Of a clamp without friction or clearance the balance knows the harmonics and the rate."""
    values = {"k10": 5.0, "c0": 0.1, "alpha0": 1.0}
    made = system(files(tmp_path, write_law, values, ()))
    balanced, marched = made.at(4.0), made.marched(4.0)
    np.testing.assert_allclose(marched.points[0, :4], balanced.clamps[0, :4], atol=2e-4 * abs(balanced.clamps[0, 1]))
    np.testing.assert_allclose(marched.forces[0, :4], balanced.forces[0, :4], atol=1e-3 * abs(balanced.forces[0, 1]))
    assert marched.decay == pytest.approx(balanced.growth, rel=0.1)


def test_a_slip_element_behind_a_clearance_is_marched_as_by_fine_steps(tmp_path, write_law):
    marched = system(files(tmp_path, write_law, SLIP, ("memory", "play"))).marched(3.0)
    assert half_range(marched.points) == pytest.approx((0.744166, 1.396330), rel=1e-3)


def test_several_clamps_that_rub_are_marched_together(tmp_path, write_law):
    """The truth is event-located stick-slip."""
    values = {"k10": 20.0, "c0": 0.02, "alpha0": 1.0, "F_c": 10.0}
    file = files(tmp_path, write_law, values, ("coulomb",), clamps=("clamp1", "clamp2"))
    one = file.read_text(encoding="utf-8")
    table = one[one.index("[[clamps]]") : one.index("[excitation]")]
    file.write_text(one.replace(table, table + table.replace("clamp1", "clamp2")), encoding="utf-8")
    marched = system(file).marched(7.0)
    pipe = reduce(parse_pipe(cantilever(0.01, 60.0, {"clamp1": 2.0, "clamp2": 1.5}, {"tip": 3.0})))
    modal, time = Modal.of(pipe), (40 + np.arange(513) / 512) / 7.0
    motion = integrate(modal, [Rubbing(20e3, 20.0, 10.0)] * 2, 3.0, 7.0, time)[: len(pipe.omega)]
    truth = 1e3 * np.ptp(modal.clamps @ motion, axis=1) / 2
    assert half_range(marched.points[:2]) == pytest.approx(truth, rel=3e-3)


def test_a_motion_that_comes_round_in_three_cycles_is_no_steady_one(tmp_path, write_law):
    """By events located in time the clamp moves by 1.0828, 1.1085 and 1.3958 mm in turn."""
    made = system(files(tmp_path, write_law, THRICE, ("coulomb", "play"), 6.0, 0.005), 6.0)
    marched = made.marched(8.656849)
    assert marched.round == 3
    assert (marched.low[0], marched.high[0]) == pytest.approx((1.0828, 1.3958), rel=2e-3)
    assert made.at(8.656849) is None


def test_a_response_is_marched_where_nothing_is_balanced(tmp_path, write_law):
    file = files(
        tmp_path, write_law, DRY, ("coulomb", "play"), response="[response]\nfrom_Hz = 2.9\nto_Hz = 3.3\ndots = 0\n"
    )
    found = run_response(file)
    (curve,) = found.curves
    assert curve.followed.complete
    assert not curve.pieces
    frequencies = [state.frequency for state in curve.states]
    amplitudes = [half_range(state.clamps)[0] for state in curve.states]
    assert np.interp(3.0, frequencies, amplitudes) == pytest.approx(TRUTH[3.0][0], rel=5e-3)
    assert (
        f"found in time from 2.9 to 3.3 Hz, where nothing is balanced: {len(frequencies)} motions"
        in response_summary(found)
    )
    write_response(found, tmp_path / "r.csv")
    table = pl.read_csv(tmp_path / "r.csv")
    assert set(table["kind"]) == {"in time"}
    assert table["clamp1.s [mm]"].to_list() == pytest.approx(amplitudes)
    picture = response_picture(found, 0)
    assert any(trace.name == IN_TIME for trace in picture.data)
    assert any(trace.x == tuple(frequencies) for trace in picture.data)
    with pytest.raises(UserError, match=r"from 2\.9 to 3\.3 Hz a motion was found in time, and bands follow"):
        banded_system(file, found)


def test_a_response_says_where_no_motion_repeats(tmp_path, write_law):
    response = "[response]\nfrom_Hz = 8.6\nto_Hz = 8.7\ndots = 0\n"
    file = files(tmp_path, write_law, THRICE, ("coulomb", "play"), 6.0, 0.005, response=response)
    with pytest.raises(UserError, match=r"no motion repeats, and they go as far as [\d.]+ mm; run its sines in time"):
        run_response(file)
