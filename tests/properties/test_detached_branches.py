"""Branches of a frequency response that nothing joins to the rest in its range."""

from __future__ import annotations

from collections.abc import Callable
from math import log, pi
from pathlib import Path

import numpy as np
import pytest
from cantilever import cantilever

from pipeclamp.pages.system.response import response_picture
from pipeclamp_models.law.file import law_of, read_law
from pipeclamp_models.law.law import Law
from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_models.pipe.modes import reduce
from pipeclamp_system.response.curves import Curve, FrequencyResponse
from pipeclamp_system.response.summary import response_summary
from pipeclamp_system.steady import detached
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.clamp import SteadyClamp
from pipeclamp_system.steady.detached import detached_branches, leaving_branches
from pipeclamp_system.steady.states import half_range
from pipeclamp_system.transient.monolithic import clamp_equations, solve_monolithic

FIRST, LAST = 3.0, 12.0
ACCELERATION = 0.2


def hard_law(folder: Path, write_law: Callable[..., None], c_A: float) -> Law:
    write_law(folder / "hard.json", {"k10": 4.0, "k30": 4.0, "c0": 0.008, "c_A": c_A, "alpha0": 1.0})
    return law_of(read_law(folder / "hard.json"))


def system_of(law: Law) -> SteadySystem:
    pipe = reduce(parse_pipe(cantilever(ratio=0.01, up_to_Hz=200)))
    clamp = SteadyClamp(law, 293.15, None, None, (0.05, 3.0), (1.0, 60.0))
    return SteadySystem(pipe, [(0, clamp)], lambda frequency: ACCELERATION)


def test_damping_that_falls_with_amplitude_closes_a_branch(tmp_path: Path, write_law: Callable[..., None]) -> None:
    """Small motions are damped too much to resonate; large ones, once there, are not."""
    law = hard_law(tmp_path, write_law, c_A=-2.0)
    system = system_of(law)
    followed = system.followed(FIRST, LAST)
    assert followed.whole
    (branch,) = detached_branches(system, followed.pieces, FIRST, LAST)
    amplitudes = [half_range(state.clamps)[0] for state in branch]
    assert branch[0].frequency == branch[-1].frequency
    assert amplitudes[0] == pytest.approx(amplitudes[-1], rel=1e-3)
    assert min(amplitudes) > 2 * max(half_range(state.clamps)[0] for state in followed.states)
    frequencies = np.array([state.frequency for state in branch])
    assert FIRST < frequencies.min() < frequencies.max() < LAST

    # Where it has but one stable state, a motion with the damping of that state's amplitude comes to it from rest.
    frequency, steps = 5.5, 80
    (state,) = [state for state in system.crossings(branch, frequency) if state.stable]
    amplitude, own = state.conditions[0]
    cycles = round(frequency * log(1000) / -state.growth)
    time = np.arange(cycles * steps + 1) / (steps * frequency)
    shaken = solve_monolithic(
        reduce(parse_pipe(cantilever(ratio=0.01, up_to_Hz=200))), [clamp_equations(law, amplitude, own, 293.15)],
        lambda t: ACCELERATION * np.sin(2 * pi * frequency * t), time, 1e-6,
    )  # fmt: skip
    assert 1e3 * np.ptp(shaken.displacement[-steps - 1 :, 0]) / 2 == pytest.approx(
        half_range(state.clamps)[0], rel=0.01
    )

    response = FrequencyResponse("hard", ("clamp1",), (), "", (Curve(None, 1.0, followed, (branch,)),), (), ({},))
    assert f"a branch apart from {frequencies.min():.4g} to {frequencies.max():.4g} Hz" in response_summary(response)
    drawn = [y for line in response_picture(response, 0).data for y in line.y if y is not None]
    assert max(drawn) == pytest.approx(max(amplitudes))


def test_a_folded_curve_has_no_branch_apart(tmp_path: Path, write_law: Callable[..., None]) -> None:
    system = system_of(hard_law(tmp_path, write_law, c_A=0.0))
    followed = system.followed(FIRST, LAST)
    frequencies = np.array([state.frequency for state in followed.states])
    assert followed.whole
    assert np.any(np.diff(frequencies) < 0)
    assert detached_branches(system, followed.pieces, FIRST, LAST) == ()
    assert leaving_branches(system, followed.pieces, FIRST, LAST) == ()


def test_what_a_path_left_out_is_found(tmp_path: Path, write_law: Callable[..., None]) -> None:
    """Of a curve that was given up in its fold, the part behind."""
    system = system_of(hard_law(tmp_path, write_law, c_A=0.0))
    whole = system.curve(FIRST, LAST)
    begun = whole[: len(whole) // 3]
    (branch,) = detached_branches(system, [begun], FIRST, LAST)
    assert max(state.frequency for state in branch) == pytest.approx(LAST)
    largest = [max(half_range(state.clamps)[0] for state in states) for states in (branch, whole)]
    assert largest[0] == pytest.approx(largest[1], rel=0.01)


def rubbing_system(folder: Path, write_law: Callable[..., None], acceleration: float, **values: float) -> SteadySystem:
    write_law(folder / "rubs.json", {"c0": 0.008, "alpha0": 1.0, **values}, effects=("coulomb",))
    clamp = SteadyClamp(law_of(read_law(folder / "rubs.json")), 293.15, None, None, (0.05, 3.0), (1.0, 60.0))
    pipe = reduce(parse_pipe(cantilever(ratio=0.01, up_to_Hz=200)))
    return SteadySystem(pipe, [(0, clamp)], lambda frequency: acceleration)


def test_beyond_a_clamp_that_sticks_nothing_is_sought_in_many_harmonics(
    tmp_path: Path, write_law: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """At 1.7 times the level it lets go: 64 harmonics had been followed there, 85 s on a curve of 1 s."""
    system = rubbing_system(tmp_path, write_law, 3.0, k10=20.0, F_c=60.0)
    known = system.followed(8.0, 9.0).pieces
    monkeypatch.setattr(detached, "FREQUENCIES_SOUGHT", 2)
    sizes, linearised = [], system.linearised

    def counted(unknowns, *others, **more):
        sizes.append(unknowns.size)
        return linearised(unknowns, *others, **more)

    monkeypatch.setattr(system, "linearised", counted)
    assert detached_branches(system, known, 8.0, 9.0) == ()
    assert max(sizes) <= 2 * system.coarsely + 1 < 2 * system.most_harmonics + 1


def test_a_branch_beyond_a_clamp_that_sticks_is_found(
    tmp_path: Path, write_law: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Small motions stick for most of a cycle; a large one, once there, is hardly held."""
    system = rubbing_system(tmp_path, write_law, ACCELERATION, k10=4.0, k30=4.0, c_A=-2.0, F_c=0.1)
    known = system.followed(5.65, 5.75).pieces
    monkeypatch.setattr(detached, "FREQUENCIES_SOUGHT", 3)
    found = detached_branches(system, known, 5.65, 5.75)
    largest = [max(half_range(state.clamps)[0] for one in some for state in one) for some in (known, found)]
    assert largest[1] > 10 * largest[0]
