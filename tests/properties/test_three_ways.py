"""Co-simulation, monolithic integration and harmonic balance give the same steady state."""

from __future__ import annotations

from collections.abc import Callable
from math import log, pi
from pathlib import Path

import control
import numpy as np
import pytest
from cantilever import cantilever, shaken
from scipy.signal import find_peaks

from pipeclamp.pages.system.response import response_picture
from pipeclamp_fmu.build import build_clamp, build_pipe
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import law_of, read_law
from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_models.pipe.modes import ReducedPipe, reduce
from pipeclamp_system.cosim.result import CosimResult
from pipeclamp_system.cosim.run import run_described
from pipeclamp_system.description.system import read_system
from pipeclamp_system.response.curves import Curve, FrequencyResponse
from pipeclamp_system.response.summary import response_summary
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.clamp import SteadyClamp
from pipeclamp_system.steady.states import half_range
from pipeclamp_system.transient.monolithic import clamp_equations, solve_monolithic

PIPE_STIFFNESS = 20.23
"""N/mm, static, at clamp1."""

PIPES = {
    "pipe": cantilever(ratio=0.01, up_to_Hz=200, probes={"tip": 3.0}),
    "flowing": cantilever(ratio=0.01, up_to_Hz=200, probes={"tip": 3.0}, flow_m_s=25.0),
}

LAWS = {
    "soft": {"k10": 0.2 * PIPE_STIFFNESS, "k30": 0.3, "c0": 1.5, "alpha0": 0.6, "k1_T": -0.3, "c_T1": -0.5},
    "stiff": {"k10": 10 * PIPE_STIFFNESS, "k30": 40.0, "c0": 8.0, "alpha0": 0.6, "k1_T": -0.3, "c_T1": -0.5},
}
ACCELERATION = 3.0
CYCLES_KEPT = 4
STEPS = 100


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory, write_law: Callable[..., None]) -> Path:
    folder = tmp_path_factory.mktemp("three_ways")
    for name, text in PIPES.items():
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
        build_pipe(reduce(parse_pipe(text)), folder / f"{name}.fmu")
    for name, values in LAWS.items():
        write_law(folder / f"{name}.json", values, "power", ("damping_temperature",))
        build_clamp(read_law(folder / f"{name}.json"), folder / f"{name}.fmu")
    return folder


def steady(bench: Path, pipe: ReducedPipe, law: str, temperature: float, amplitude: float | None) -> SteadySystem:
    file = read_law(bench / f"{law}.json")
    clamp = SteadyClamp(law_of(file), temperature + 273.15, amplitude, None, (0.01, 5.0), (1.0, 60.0))
    return SteadySystem(pipe, [(0, clamp)], lambda frequency: ACCELERATION)


def coupled_motion(file: Path) -> CosimResult:
    """Co-simulate once: what its steps err is asked by test_trust_of_steps.py, what makes it beat by test_beats.py."""
    return run_described(read_system(file), file.parent, str(file), checked=False)


def resonance(pipe: ReducedPipe, law: str, temperature: float) -> float:
    """Give the first natural frequency of the pipe with the clamp's k1 as a spring, Hz."""
    k1 = LAWS[law]["k10"] * ((temperature + 273.15) / 293.15) ** -0.3
    shape = np.array(pipe.clamp_shapes[0])
    values = np.linalg.eigvals(pipe.stiffness_matrix + 1e3 * k1 * np.outer(shape, shape))
    return float(np.sqrt(values.real.min()) / (2 * pi))


@pytest.mark.parametrize(
    ("law", "name", "share", "temperature"),
    [
        *((law, "pipe", *case) for law in LAWS for case in ((0.7, 300.0), (1.0, 20.0), (1.4, 300.0))),
        ("stiff", "flowing", 1.0, 20.0),
    ],
)
def test_three_ways_agree(bench: Path, law: str, name: str, temperature: float, share: float) -> None:
    pipe = reduce(parse_pipe(PIPES[name]))
    frequency = round(share * resonance(pipe, law, temperature), 3)
    state = steady(bench, pipe, law, temperature, 0.5).at(frequency)
    assert state is not None
    assert state.stable
    balanced = [half_range(state.clamps)[0], half_range(state.probes)[0]]

    cycles = round(frequency * log(1000) / -state.growth) + CYCLES_KEPT
    time = np.arange(cycles * STEPS + 1) / (STEPS * frequency)
    equations = clamp_equations(law_of(read_law(bench / f"{law}.json")), 0.5, frequency, temperature + 273.15)
    moved = solve_monolithic(
        pipe, [equations], lambda t: ACCELERATION * np.sin(2 * pi * frequency * t), time, relative_tolerance=1e-6
    )
    last = slice(-CYCLES_KEPT * STEPS - 1, None)
    whole = [1e3 * np.ptp(values[last, 0]) / 2 for values in (moved.displacement, moved.probes)]

    file = bench / "system.toml"
    file.write_text(
        f'[pipe]\nfmu = "{name}.fmu"\n[[clamps]]\nat = "clamp1"\nfmu = "{law}.fmu"\n'
        f"temperature_C = {temperature}\namplitude_mm = 0.5\n"
        f'[excitation]\nkind = "sine"\nacceleration_m_s2 = {ACCELERATION}\nfrequency_Hz = {frequency}\n'
        f"[run]\nstop_s = {float(time[-1])!r}\nstep_s = {float(time[1])!r}\n",
        encoding="utf-8",
    )
    result = coupled_motion(file)
    coupled = [1e3 * result.amplitude(f"{point}.s", CYCLES_KEPT / cycles) for point in ("clamp1", "tip")]
    assert balanced == pytest.approx(whole, rel=0.01)
    assert coupled == pytest.approx(whole, rel=0.01)


def test_a_clearance_before_a_clamp_moves_as_in_co_simulation(bench: Path, write_law: Callable[..., None]) -> None:
    frequency, cycles, steps = 9.0, 25, 200
    write_law(bench / "loose.json", LAWS["soft"] | {"g_p": 0.05}, "power", ("damping_temperature", "play"))
    build_clamp(read_law(bench / "loose.json"), bench / "loose.fmu")
    pipe = reduce(parse_pipe(PIPES["pipe"]))
    state = steady(bench, pipe, "loose", 20.0, 0.5).at(frequency)
    assert state is not None
    assert state.stable
    balanced = [half_range(state.clamps)[0], half_range(state.probes)[0]]
    file = bench / "loose.toml"
    file.write_text(
        '[pipe]\nfmu = "pipe.fmu"\n[[clamps]]\nat = "clamp1"\nfmu = "loose.fmu"\n'
        "temperature_C = 20.0\namplitude_mm = 0.5\n"
        f'[excitation]\nkind = "sine"\nacceleration_m_s2 = {ACCELERATION}\nfrequency_Hz = {frequency}\n'
        f"[run]\nstop_s = {cycles / frequency!r}\nstep_s = {1 / (steps * frequency)!r}\n",
        encoding="utf-8",
    )
    result = coupled_motion(file)
    coupled = [1e3 * result.amplitude(f"{point}.s", CYCLES_KEPT / cycles) for point in ("clamp1", "tip")]
    assert balanced == pytest.approx(coupled, rel=0.01)


def hardening(bench: Path, write_law: Callable[..., None], alpha: float = 1.0, c0: float = 0.02) -> SteadySystem:
    write_law(bench / "hard.json", {"k10": 4.0, "k30": 4.0, "c0": c0, "alpha0": alpha})
    file = read_law(bench / "hard.json")
    clamp = SteadyClamp(law_of(file), 293.15, 1.0, 9.0, (0.01, 5.0), (1.0, 60.0))
    return SteadySystem(reduce(parse_pipe(PIPES["pipe"])), [(0, clamp)], lambda frequency: 0.5)


def test_a_hardening_clamp_folds_and_the_middle_branch_is_unstable(bench: Path, write_law: Callable[..., None]) -> None:
    system = hardening(bench, write_law)
    curve = system.curve(4.0, 14.0)
    frequencies = np.array([state.frequency for state in curve])
    turns = np.flatnonzero(np.diff(np.sign(np.diff(frequencies))) != 0)
    assert len(turns) == 2
    top, bottom = frequencies[turns[0] + 1], frequencies[turns[1] + 1]
    states = system.crossings(curve, (top + bottom) / 2)
    assert [state.stable for state in states] == [True, False, True]
    amplitudes = [half_range(state.clamps)[0] for state in states]
    assert amplitudes[0] > amplitudes[1] > amplitudes[2]
    outside = [state.stable for state in curve if not bottom - 0.05 < state.frequency < top + 0.05]
    assert all(outside)


def test_a_response_that_is_given_up_keeps_its_pieces_apart(
    bench: Path, write_law: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    system = hardening(bench, write_law)
    whole = system.followed(6.0, 11.0)
    assert whole.whole
    follow = SteadySystem.curve
    monkeypatch.setattr(SteadySystem, "curve", lambda self, first, last, _: follow(self, first, last)[:9])
    # What is missing is marched, up and down: in the fold each way has a motion of its own, stable both.
    up, down = system.followed(6.0, 11.0).in_time
    upper, _, lower = system.crossings(whole.pieces[0], 8.0)
    for way, state in ((up, upper), (down, lower)):
        found = np.interp(8.0, [one.frequency for one in way], [half_range(one.clamps)[0] for one in way])
        assert found == pytest.approx(half_range(state.clamps)[0], rel=0.01)
    monkeypatch.setattr(SteadySystem, "marched", lambda *_: None)
    followed = system.followed(6.0, 11.0)
    assert not followed.whole
    lower, upper = followed.pieces
    assert (lower[0].frequency, upper[-1].frequency) == (6.0, 11.0)
    low, high = lower[-1].frequency, upper[0].frequency
    assert f"followed from 6 to {low:.4g} Hz and from {high:.4g} to 11 Hz only" in followed.reach()
    response = FrequencyResponse("hard", ("clamp1",), ("tip",), "", (Curve(None, 1.0, followed),), (), ({},))
    assert followed.reach() in response_summary(response)
    drawn = [line.x for line in response_picture(response, 0).data if line.x[0] is not None]  # the legend's have none
    assert not any(min(x) < (low + high) / 2 < max(x) for x in drawn)
    # Given up from below alone: what comes from above is whole.
    monkeypatch.setattr(
        SteadySystem, "curve", lambda self, first, last, _: follow(self, first, last)[: 9 if first < last else None]
    )
    assert system.followed(6.0, 11.0).whole


def test_time_integration_ends_on_a_stable_branch(bench: Path, write_law: Callable[..., None]) -> None:
    system = hardening(bench, write_law)
    pipe = reduce(parse_pipe(PIPES["pipe"]))
    upper, middle, lower = system.crossings(system.curve(4.0, 14.0), 8.0)
    equations = clamp_equations(law_of(read_law(bench / "hard.json")), 1.0, 9.0, 293.15)
    assert middle.growth > 0 > max(upper.growth, lower.growth)
    cycles = round(8.0 * log(1000) / -max(upper.growth, lower.growth))
    time = np.arange(cycles * 80 + 1) / (80 * 8.0)
    moved = solve_monolithic(pipe, [equations], lambda t: 0.5 * np.sin(2 * pi * 8.0 * t), time, 1e-6)
    ends = 1e3 * np.ptp(moved.displacement[-81:, 0]) / 2
    assert min(abs(ends / half_range(state.clamps)[0] - 1) for state in (upper, lower)) < 0.02
    assert abs(ends / half_range(middle.clamps)[0] - 1) > 0.1


WATER_LINE = """
name = "water line"
[pipe]
outer_diameter_mm = 323.9
wall_mm = 8.0
length_m = 18.0
material = "carbon steel"
fluid = "water"
[ends]
left = "pinned"
right = "pinned"
[[clamps]]
name = "clamp1"
position_m = 5.0
[damping]
ratio = 0.005
[modes]
up_to_Hz = 100
"""
"""Shaken near its first mode with 0.2 m/s2 the clamp moves with a third harmonic of a third of the fundamental."""


def test_higher_harmonics_take_part_in_stability() -> None:
    pipe, law = reduce(parse_pipe(WATER_LINE)), law_of(open_law("emwm2"))
    clamp = SteadyClamp(law, 293.15, 1.0, 5.0, (0.01, 1.0), (1.0, 60.0))
    system = SteadySystem(pipe, [(0, clamp)], lambda frequency: 0.2)
    curve = system.curve(3.5, 4.5)
    frequencies, stable = np.array([s.frequency for s in curve]), np.array([s.stable for s in curve])
    turns = np.flatnonzero(np.diff(np.sign(np.diff(frequencies))) != 0) + 1
    changes = np.flatnonzero(np.diff(stable.astype(int)))
    assert len(turns) == len(changes) == 2
    assert all(turn in (change, change + 1) for turn, change in zip(turns, changes, strict=True))

    frequency, steps, cycles = 3.98, 64, 60
    [state] = system.crossings(curve, frequency)
    assert abs(state.clamps[0, 3]) > 0.3 * abs(state.clamps[0, 1])
    time = np.arange(cycles * steps + 1) / (steps * frequency)
    moved = solve_monolithic(
        pipe, [clamp_equations(law, 1.0, 5.0, 293.15)], lambda t: 0.2 * np.sin(2 * pi * frequency * t), time, 1e-6
    )
    motion = 1e3 * moved.displacement[:-1, 0].reshape(cycles, steps)
    assert np.ptp(motion[-1]) / 2 == pytest.approx(half_range(state.clamps)[0], rel=0.01)
    off = np.abs(motion - motion[-1]).max(axis=1)
    peaks = find_peaks(off)[0]
    peaks = peaks[(off[peaks] < 0.2 * off[0]) & (off[peaks] > 1e-3 * off[0])]
    decay = np.polyfit(peaks / frequency, np.log(off[peaks]), 1)[0]
    assert len(peaks) > 2
    assert decay == pytest.approx(state.growth, rel=0.05)


@pytest.mark.parametrize("frequency", [4.5, 7.5])
def test_a_law_with_memory_comes_to_rest_as_fast_as_said(
    bench: Path, write_law: Callable[..., None], frequency: float
) -> None:
    """Below and above resonance, once the disturbance is small."""
    write_law(bench / "slip.json", {"k10": 5.0, "c0": 0.01, "alpha0": 1.0, "k_s": 20.0, "z_s": 3.0}, "memory")
    pipe, law = reduce(parse_pipe(PIPES["pipe"])), law_of(read_law(bench / "slip.json"))
    clamp = SteadyClamp(law, 293.15, 1.0, frequency, (0.01, 5.0), (1.0, 60.0))
    state = SteadySystem(pipe, [(0, clamp)], lambda frequency: 0.5).at(frequency)
    assert state is not None
    assert state.stable
    steps, cycles = 64, round(12 * frequency)
    time = np.arange(cycles * steps + 1) / (steps * frequency)
    moved = solve_monolithic(
        pipe, [clamp_equations(law, 1.0, frequency, 293.15)],
        lambda t: 0.5 * np.sin(2 * pi * frequency * t), time, 1e-8,
    )  # fmt: skip
    motion = 1e3 * moved.displacement[:-1, 0].reshape(cycles, steps)
    assert np.ptp(motion[-1]) / 2 == pytest.approx(half_range(state.clamps)[0], rel=0.01)
    off = np.abs(motion - motion[-1]).max(axis=1)
    cycle = np.arange(cycles)[(off < 0.05 * off[0]) & (off > 1e-3 * off[0])]
    assert np.polyfit(cycle / frequency, np.log(off[cycle]), 1)[0] == pytest.approx(state.growth, rel=0.06)


@pytest.mark.parametrize(("frequency", "stable", "cycles"), [(5.5, True, 150), (6.5, False, 90)])
def test_a_motion_beats_where_its_amplitude_is_tracked_too_late(
    tmp_path: Path, write_law: Callable[..., None], frequency: float, stable: bool, cycles: int
) -> None:
    """Of a clamp whose stiffness is in proportion to A."""
    write_law(tmp_path / "law.json", {"k10": 2.0, "k1_A": 1.0, "c0": 0.004, "alpha0": 1.0})
    (tmp_path / "pipe.toml").write_text(PIPES["pipe"], encoding="utf-8")
    clamp = SteadyClamp(law_of(read_law(tmp_path / "law.json")), 293.15, None, None, (0.01, 5.0), (1.0, 60.0))
    pipe = reduce(parse_pipe(PIPES["pipe"]))
    state = SteadySystem(pipe, [(0, clamp)], lambda frequency: 1.0).at(frequency)
    assert state is not None
    assert state.stable == stable

    steps = 64
    text = shaken(half_range(state.clamps)[0], frequency, clamp="track = true")
    text = text.replace("stop_s = 1.0", f"stop_s = {cycles / frequency!r}")
    text = text.replace("step_s = 0.001", f"step_s = {1 / (steps * frequency)!r}")
    (tmp_path / "system.toml").write_text(text, encoding="utf-8")
    result = coupled_motion(tmp_path / "system.toml")
    motion = 1e3 * result.columns["clamp1.s"][:-1].reshape(cycles, steps)
    amplitudes = np.ptp(motion[-20:], axis=1) / 2 / half_range(state.clamps)[0]
    assert (np.abs(amplitudes - 1).max() < 0.01) == stable
    assert np.ptp(amplitudes) > 0.5 or stable


def test_the_fundamental_is_control_s_describing_function(bench: Path, write_law: Callable[..., None]) -> None:
    """For k1 y + k3 y^3: python-control's own integral of it."""
    hardening(bench, write_law)
    clamp = SteadyClamp(law_of(read_law(bench / "hard.json")), 293.15, 1.0, 9.0, (0.01, 5.0), (1.0, 60.0))
    for amplitude in (0.1, 1.0, 3.0):
        force = clamp.forces(np.array([[0, amplitude, 0, 0]], dtype=complex), np.array([9.0]))[0, 1]
        expected = control.describing_function(lambda y: 4.0 * y + 4.0 * y**3, amplitude, num_points=400)
        assert force.real / amplitude == pytest.approx(expected.real, rel=1e-4)
        assert force.imag == pytest.approx(0.02 * 2 * pi * 9.0 * amplitude, rel=1e-4)


SHOT = {11.875: [(1.4039, 3.9042), (1.1769, 2.9049), (0.6093, 1.1952)]}


@pytest.mark.parametrize("frequency", [11.875])
def test_harmonics_are_as_many_as_a_gap_asks_for(bench: Path, write_law: Callable[..., None], frequency: float) -> None:
    """Amplitudes (mm) at clamp and tip by shooting: the cantilever's own modes, Runge-Kutta, Newton on the cycle."""
    write_law(bench / "gap.json", {"k10": 400.0, "c0": 0.02, "alpha0": 1.0, "g": 1.0}, "power", ("gap",))
    clamp = SteadyClamp(law_of(read_law(bench / "gap.json")), 293.15, 1.0, 9.0, (0.01, 5.0), (1.0, 60.0))
    pipe = reduce(parse_pipe(PIPES["pipe"]))
    system = SteadySystem(pipe, [(0, clamp)], lambda frequency: ACCELERATION)
    curve = system.followed(9.0, 14.0)
    states = system.crossings(curve.states, frequency)
    found = [(half_range(state.clamps)[0], half_range(state.probes)[0]) for state in states]
    assert found == [pytest.approx(shot, rel=2e-3) for shot in SHOT[frequency]]
    assert [state.stable for state in states] == [True, False, True]
    assert max(state.truncated for state in states) < 1e-3
    assert states[0].harmonics > 7 > states[2].harmonics  # the last one stays inside the gap: it is linear
    few = SteadySystem(pipe, [(0, clamp)], lambda frequency: ACCELERATION, harmonics=7)
    worst = max(few.crossings(few.followed(9.0, 14.0).states, frequency), key=lambda state: state.truncated)
    assert worst.truncated > 0.01
    response = FrequencyResponse("gap", ("clamp1",), ("tip",), "", (Curve(None, 1.0, curve),), (), ({},))
    assert "harmonics balanced: 3 to " in response_summary(response)
