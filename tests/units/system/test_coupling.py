"""The coupling schemes on plain Python participants: order, stiffness, stopping."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from math import pi, sin
from typing import Any

import numpy as np
import pytest
from cantilever import cantilever

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.pipe import step as pipe_step
from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_models.pipe.modes import ReducedPipe, reduce
from pipeclamp_system.coupling.broyden import SolverTolerance
from pipeclamp_system.coupling.implicit import LinearlyImplicit
from pipeclamp_system.coupling.iterated import Iteration
from pipeclamp_system.coupling.march import Point, System, march
from pipeclamp_system.coupling.schemes import advance_of
from pipeclamp_system.coupling.step_control import energy_error, march_controlled
from pipeclamp_system.description.scheme import ORDER, ROLLS_BACK, Scheme
from pipeclamp_system.transient.monolithic import ClampEquations, solve_monolithic

coefficients = cache(pipe_step.coefficients)


@cache
def reduced(clamps: int) -> ReducedPipe:
    places = {"first": 2.0, "second": 3.0} if clamps == 2 else {"first": 2.0}
    return reduce(parse_pipe(cantilever(ratio=0.01, up_to_Hz=200, clamps=places)))


class Plain:
    """A participant whose state can be saved; it gives no slopes of its own."""

    state: Any
    saved: Any

    def save(self) -> None:
        self.saved = self.state

    def restore(self) -> None:
        self.state = self.saved

    def slopes(self) -> None:
        return None


class PlainPipe(Plain):
    """A reduced pipe as a participant."""

    def __init__(self, pipe: ReducedPipe, clamps: int, at_end: bool) -> None:
        self.pipe, self.at_end = pipe, at_end
        self.shapes = pipe.clamp_shapes[:clamps]
        self.state = ([0.0] * len(pipe.omega), [0.0] * len(pipe.omega), (0.0,) * (clamps + 1))
        self.saved = self.state
        self.inputs: tuple[float, ...] = self.state[2]

    def set_inputs(self, values: Sequence[float]) -> None:
        self.inputs = tuple(values)

    def load(self, mode: int, inputs: Sequence[float]) -> float:
        given = self.pipe.excitation_participation[mode] * inputs[0]
        return given - sum(shape[mode] * force for shape, force in zip(self.shapes, inputs[1:], strict=True))

    def step(self, time: float, h: float) -> None:
        q, p, before = self.state
        first = before if self.at_end else self.inputs
        moved = [
            pipe_step.step(
                coefficients(omega, damping, h),
                q[i],
                p[i],
                self.load(i, first),
                self.load(i, self.inputs),
            )
            for i, (omega, damping) in enumerate(zip(self.pipe.omega, self.pipe.damping, strict=True))
        ]
        self.state = ([entry[0] for entry in moved], [entry[1] for entry in moved], self.inputs)

    def outputs(self) -> list[float]:
        q, p, _ = self.state
        return [float(np.dot(shape, q)) for shape in self.shapes] + [float(np.dot(shape, p)) for shape in self.shapes]


class PlainClamp(Plain):
    """A clamp's equations as a participant."""

    def __init__(self, equations: ClampEquations) -> None:
        self.equations = equations
        self.state = self.saved = (equations.start, 0.0, equations.force(equations.start, 0.0, 0.0))
        self.inputs = (0.0, 0.0)

    def set_inputs(self, values: Sequence[float]) -> None:
        self.inputs = (1e3 * values[0], 1e3 * values[1])

    def step(self, time: float, h: float) -> None:
        own, before, _ = self.state
        y, v = self.inputs
        force, _, after = self.equations.step(self.equations.coefficients, own, before, y, v, h)
        self.state = (after, y, force)

    def outputs(self) -> tuple[float]:
        return (self.state[2],)


def smooth(k1: float, k3: float, c: float) -> ClampEquations:
    """Spring, cubic spring and dashpot: N/mm, N/mm3, N s/mm."""

    def step(k, state, y_previous, y, v, h):  # type: ignore[no-untyped-def]
        return k1 * y + k3 * y**3 + c * v, 0.0, ()

    return ClampEquations((), (), step)


def dry(k1: float, slip: float, alpha: float = 0.3) -> ClampEquations:
    """Spring and |v|^alpha sgn v, steep at v = 0: N/mm, N."""

    def step(k, state, y_previous, y, v, h):  # type: ignore[no-untyped-def]
        return k1 * y + slip * v * (v * v + 0.1**2) ** ((alpha - 1) / 2), 0.0, ()

    return ClampEquations((), (), step)


def elastic_slip(k_s: float, slip: float) -> ClampEquations:
    """A Jenkins element: N/mm, N."""

    def step(k, state, y_previous, y, v, h):  # type: ignore[no-untyped-def]
        z = min(slip, max(-slip, state[0] + k_s * (y - y_previous)))
        return z, 0.0, (z,)

    return ClampEquations((0.0,), (), step)


def excitation(frequency: float) -> Callable[[float], float]:
    return lambda t: 2.0 * sin(2 * pi * frequency * t)


def coupled(clamps: Sequence[ClampEquations], scheme: Scheme, frequency: float) -> System:
    pipe = PlainPipe(reduced(len(clamps)), len(clamps), scheme in ROLLS_BACK)
    return System(pipe, tuple(PlainClamp(clamp) for clamp in clamps), excitation(frequency))


def error(clamps: Sequence[ClampEquations], scheme: Scheme, end: float, steps: int, frequency: float) -> float:
    """Give the largest error of a displacement against the monolithic solution, as a share of the largest one."""
    h = end / steps
    system = coupled(clamps, scheme, frequency)
    points = list(march(system, advance_of(scheme, system, SolverTolerance(1e-9, 200)), h, steps))
    ours = np.array([point.displacement for point in points])
    time = np.arange(steps + 1) * h
    exact = solve_monolithic(reduced(len(clamps)), clamps, excitation(frequency), time, 1e-10).displacement
    return float(np.abs(ours - exact).max() / np.abs(exact).max())


LAWS = {
    "two smooth clamps": ([smooth(2.0, 0.5, 0.05), smooth(1.0, 0.0, 0.02)], 0.4, 9.0),
    "one, 15 times as stiff as the pipe": ([smooth(300.0, 0.0, 0.05)], 0.2, 30.0),
}


@pytest.mark.parametrize("scheme", ORDER)
@pytest.mark.parametrize("laws", LAWS)
def test_error_falls_with_the_macro_step_at_the_stated_order(laws: str, scheme: Scheme) -> None:
    clamps, end, frequency = LAWS[laws]
    coarse, fine = (error(clamps, scheme, end, steps, frequency) for steps in (1200, 2400))
    assert np.log2(coarse / fine) == pytest.approx(ORDER[scheme], abs=0.15)
    assert fine < {1: 0.12, 2: 2e-4}[ORDER[scheme]]


@pytest.mark.parametrize("scheme", ["implicit", "iterated"])
@pytest.mark.parametrize(
    ("clamps", "limit"),
    [
        ([dry(20.0, 10.0)], 2e-4),
        ([dry(300.0, 30.0), dry(100.0, 30.0)], 2e-4),
        ([elastic_slip(300.0, 10.0)], 5e-4),
        ([elastic_slip(300.0, 10.0), dry(30.0, 10.0)], 6e-4),
        ([smooth(20_000.0, 0.0, 0.1)], 0.02),  # a thousand times as stiff as the pipe
    ],
)
def test_steep_and_stiff_laws_converge(clamps: list[ClampEquations], limit: float, scheme: Scheme) -> None:
    assert error(clamps, scheme, 0.3, 900, 15.0) < {"implicit": 1.5, "iterated": 1.0}[scheme] * limit


def test_a_linear_clamp_takes_two_trials_however_stiff() -> None:
    system = coupled([smooth(300.0, 0.0, 0.1)], "implicit", 15.0)
    points = list(march(system, LinearlyImplicit(system), 1e-3, 200))
    assert {point.trials for point in points[1:]} == {2}
    peak = max(abs(point.force[0]) for point in points)
    assert max(abs(point.told[0] - point.force[0]) for point in points[1:]) < 1e-6 * peak


@pytest.mark.parametrize("scheme", ["implicit", "iterated"])
def test_steps_follow_the_energy_that_the_coupling_makes(scheme: Scheme) -> None:
    clamps, stop = [dry(300.0, 30.0)], 0.4
    errors, counts = [], []
    for tolerance in (1e-3, 1e-4):
        system = coupled(clamps, scheme, 15.0)
        advance = advance_of(scheme, system, SolverTolerance(1e-9, 200))
        points = list(march_controlled(system, advance, 4e-3, stop, tolerance))
        time = np.array([point.time for point in points])
        assert time[-1] == pytest.approx(stop, rel=1e-12)
        steps = np.diff(time)
        assert steps.max() >= 4 * steps[:-1].min()  # short where the friction turns
        exact = solve_monolithic(reduced(1), clamps, excitation(15.0), time, 1e-9).displacement[:, 0]
        ours = np.array([point.displacement[0] for point in points])
        errors.append(np.abs(ours - exact).max() / np.abs(exact).max())
        counts.append(len(points))
    assert errors[0] < 0.005
    assert errors[1] < 0.6 * errors[0]
    assert counts[0] < counts[1] < 5 * counts[0]


def test_the_energy_error_of_a_step_is_what_pipe_and_clamp_don_t_agree_on() -> None:
    start = Point(0, 0.0, 0.0, (0.0,), (0.01,), (5.0,), (5.0,), 0)
    end = Point(1, 1e-3, 0.0, (1e-5,), (0.01,), (6.0,), (6.0,), 2)
    assert energy_error(start, end) == (pytest.approx(0.0, abs=1e-18), pytest.approx(0.06))
    late = Point(1, 1e-3, 0.0, (1e-5,), (0.01,), (6.0,), (4.0,), 2)
    assert energy_error(start, late)[0] == pytest.approx((6.0 - 4.0) / 2 * 1e-5)


def test_few_trials_are_needed_where_plain_repetition_would_diverge() -> None:
    """Over one step the clamp is stiffer than the pipe, so that f := clamps(pipe(f)) would grow."""
    clamps = [smooth(20_000.0, 0.0, 0.1)]
    system = coupled(clamps, "iterated", 15.0)
    points = list(march(system, Iteration(system, SolverTolerance(1e-6, 60)), 1e-3, 200))
    assert np.mean([point.trials for point in points[1:]]) < 4

    system = coupled(clamps, "iterated", 15.0)
    force, answers = 1.0, []
    system.clamps[0].save()
    system.pipe.save()
    for _ in range(10):
        system.pipe.restore()
        system.clamps[0].restore()
        system.pipe.set_inputs((0.0, force))
        system.pipe.step(0.0, 1e-3)
        system.clamps[0].set_inputs(system.pipe.outputs())
        system.clamps[0].step(0.0, 1e-3)
        answers.append(force := system.clamps[0].outputs()[0])
    assert abs(answers[-1]) > 5 * abs(answers[0])


def test_a_step_that_does_not_converge_is_named() -> None:
    system = coupled([smooth(-30_000.0, 0.0, 0.0)], "iterated", 15.0)  # it pushes: no force is enclosed
    with pytest.raises(UserError, match=r"step \d+ \(t = .* s\).*2 secants.*smaller step_s"):
        list(march(system, Iteration(system, SolverTolerance(1e-12, 2)), 1e-3, 300))


def test_no_clamps_is_the_bare_pipe() -> None:
    pipe = reduced(2)
    for scheme in ORDER:
        system = System(PlainPipe(pipe, 0, scheme in ROLLS_BACK), (), excitation(10.0))
        assert list(march(system, advance_of(scheme, system, SolverTolerance(1e-6, 60)), 1e-3, 5))[-1].force == ()
