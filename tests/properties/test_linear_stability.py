"""Where laws are linear, stability by Floquet is that of the eigenvalues of pipe and clamps together."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from cantilever import cantilever

from pipeclamp_models.law.file import law_of, read_law
from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_models.pipe.modes import ReducedPipe, reduce
from pipeclamp_models.steps.tracker import AVERAGING
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.clamp import SteadyClamp, samples_of_law
from pipeclamp_system.steady.detached import detached_branches

RELAXING = {"k10": 4.0, "c0": 0.02, "alpha0": 1.0, "k_m": 6.0, "tau": 0.03}
PLAIN = {"k10": 7.0, "c0": 0.005, "alpha0": 1.0}


def pipe_of(left: str, clamps: dict[str, float], ratio: float = 0.002) -> ReducedPipe:
    text = cantilever(ratio=ratio, up_to_Hz=200, clamps=clamps, probes={"tip": 3.0})
    return reduce(parse_pipe(text.replace('left = "clamped"', f'left = "{left}"')))


def largest_rate(pipe: ReducedPipe, k: list[float], c: list[float], k_m: float, tau: float) -> float:
    """Give the largest real part of the eigenvalues that aren't 0, 1/s; the first clamp has a Maxwell arm besides."""
    shapes, modes = 1e3 * np.array(pipe.clamp_shapes), len(pipe.omega)
    stiffness = pipe.stiffness_matrix + 1e-3 * shapes.T @ np.diag(k) @ shapes
    damping = pipe.damping_matrix + 1e-3 * shapes.T @ np.diag(c) @ shapes
    arm = shapes[:1]
    matrix = np.block(
        [
            [np.zeros((modes, modes)), np.eye(modes), np.zeros((modes, 1))],
            [-stiffness, -damping, -1e-3 * arm.T],
            [np.zeros((1, modes)), k_m * arm, np.full((1, 1), -1 / tau)],
        ]
    )
    rates = np.linalg.eigvals(matrix)
    return float(rates.real[np.abs(rates) > 1e-3].max())


@pytest.mark.parametrize("left", ["clamped", "pinned", "free"])
@pytest.mark.parametrize("amplitude", [1.0, None])
def test_two_clamps_one_with_memory(
    tmp_path: Path, write_law: Callable[..., None], left: str, amplitude: float | None
) -> None:
    """The pipe alone moves as a rigid body but where it is clamped."""
    pipe, frequency = pipe_of(left, {"clamp1": 2.0, "clamp2": 1.2}), 11.0
    write_law(tmp_path / "relaxing.json", RELAXING, "power", ("relaxation",))
    write_law(tmp_path / "plain.json", PLAIN)
    laws = [law_of(read_law(tmp_path / f"{name}.json")) for name in ("relaxing", "plain")]
    clamps = [SteadyClamp(law, 293.15, amplitude, frequency, (0.01, 5.0), (1.0, 60.0)) for law in laws]
    state = SteadySystem(pipe, list(enumerate(clamps)), lambda frequency: 0.5).at(frequency)
    assert state is not None
    expected = largest_rate(pipe, [RELAXING["k10"], PLAIN["k10"]], [RELAXING["c0"], PLAIN["c0"]], 6.0, 0.03)
    assert state.growth == pytest.approx(expected, rel=2e-3)


def test_what_nothing_holds_is_neither_stable_nor_unstable(tmp_path: Path, write_law: Callable[..., None]) -> None:
    """A free pipe turns about its one clamp: what else it does decides."""
    pipe = pipe_of("free", {"clamp1": 2.0})
    write_law(tmp_path / "plain.json", PLAIN)
    clamp = SteadyClamp(law_of(read_law(tmp_path / "plain.json")), 293.15, 1.0, 9.0, (0.01, 5.0), (1.0, 60.0))
    followed = SteadySystem(pipe, [(0, clamp)], lambda frequency: 0.5).followed(4.0, 10.0)
    assert followed.whole
    expected = largest_rate(pipe, [PLAIN["k10"]], [PLAIN["c0"]], k_m=0.0, tau=1e-3)
    assert [state.growth for state in followed.states] == pytest.approx(len(followed.states) * [expected], rel=2e-3)


@pytest.mark.parametrize("left", ["clamped", "free"])
def test_a_pipe_without_clamps(left: str) -> None:
    pipe = pipe_of(left, {})
    system = SteadySystem(pipe, [], lambda frequency: 0.5)
    followed = system.followed(4.0, 10.0)
    moving = pipe.omega[0] if left == "clamped" else min(one for one in pipe.omega if one > 1.0)
    assert followed.whole
    assert followed.states[0].growth == pytest.approx(-0.002 * moving, rel=1e-6)
    assert detached_branches(system, followed.pieces, 4.0, 10.0) == ()


@pytest.mark.parametrize("amplitude", [1.0, None])
def test_disturbances_die_out_faster_than_an_amplitude_is_averaged(
    tmp_path: Path, write_law: Callable[..., None], amplitude: float | None
) -> None:
    """A law that doesn't hang on A has nothing of what a tracker keeps of it, given or tracked."""
    pipe, frequency = pipe_of("clamped", {"clamp1": 2.0}, ratio=0.2), 6.0
    write_law(tmp_path / "plain.json", PLAIN)
    clamp = SteadyClamp(law_of(read_law(tmp_path / "plain.json")), 293.15, amplitude, None, (0.01, 5.0), (1.0, 60.0))
    state = SteadySystem(pipe, [(0, clamp)], lambda frequency: 0.5).at(frequency)
    assert state is not None
    expected = largest_rate(pipe, [PLAIN["k10"]], [PLAIN["c0"]], k_m=0.0, tau=1e-3)
    assert expected < -frequency / AVERAGING
    assert state.growth == pytest.approx(expected, rel=1e-6)


def test_an_element_that_never_slips_behind_a_clearance_makes_no_motion_unstable(
    tmp_path: Path, write_law: Callable[..., None]
) -> None:
    """It keeps its force's offset for ever: neither stable nor unstable, also where the clearance has its kinks."""
    values = {"k10": 4.0, "c0": 0.001, "alpha0": 1.0, "g_p": 0.2}
    values |= {"F_S": 6.0, "K_T": 30.0, "chi": -0.3, "beta_S": 0.2}
    write_law(tmp_path / "spread.json", values, "power", ("slip_spread", "play"), 1e-6)
    law = law_of(read_law(tmp_path / "spread.json"))
    samples = samples_of_law(law, {"T": 293.15}, 9.0, 60.0)
    clamp = SteadyClamp(law, 293.15, 1.0, 6.0, (0.01, 9.0), (0.5, 60.0), samples=samples)
    pipe = reduce(parse_pipe(cantilever(ratio=0.005, up_to_Hz=200, probes={"tip": 3.0})))
    # below 4.14 Hz a branch leaves the curve, where the motion itself is at the edge of what is stable
    states = SteadySystem(pipe, [(0, clamp)], lambda frequency: 1.0).followed(4.2, 4.22).states
    assert all(state.growth < -0.005 * 2 * math.pi * state.frequency for state in states)


@pytest.mark.parametrize("k10", [1e4, 1e6])
def test_a_clamp_far_stiffer_than_the_pipe_is_stable(
    tmp_path: Path, write_law: Callable[..., None], k10: float
) -> None:
    """Its step of a cycle is many periods of what it makes with the pipe."""
    pipe = pipe_of("clamped", {"clamp1": 2.2})
    write_law(tmp_path / "stiff.json", {"k10": k10, "c0": 1e-6, "alpha0": 1.0})
    clamp = SteadyClamp(law_of(read_law(tmp_path / "stiff.json")), 293.15, 1.0, 9.0, (0.01, 5.0), (1.0, 60.0))
    state = SteadySystem(pipe, [(0, clamp)], lambda frequency: 2.5).at(5.0)
    assert state is not None
    assert state.growth == pytest.approx(largest_rate(pipe, [k10], [1e-6], 0.0, 1.0), rel=2e-3)
