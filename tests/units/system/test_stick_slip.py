"""Dry friction in the iterated coupling: where the force steps within a macro step, the step is taken in parts.

The truth is event-located stick-slip of the same modes with sgn v as it is, `stick_slip.integrate`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import pi, sin

import numpy as np
import pytest
from cantilever import cantilever, shaken
from stick_slip import Modal, Rubbing, integrate
from test_coupling import PlainClamp, PlainPipe

from pipeclamp_fmu.build import build_clamp
from pipeclamp_models.law.file import read_law
from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_models.pipe.modes import ReducedPipe, reduce
from pipeclamp_system.cosim.run import run_system
from pipeclamp_system.coupling.broyden import SolverTolerance
from pipeclamp_system.coupling.iterated import Iteration
from pipeclamp_system.coupling.march import System, march
from pipeclamp_system.fmus.participant import FmuParticipant, opened
from pipeclamp_system.transient.monolithic import ClampEquations

ACCELERATION, END = 3.0, 1.0
ONE = {2.0: Rubbing(stiffness=20e3, damping=20.0, friction=20.0)}
TWO = {1.5: Rubbing(20e3, 20.0, 20.0), 2.5: Rubbing(5e3, 20.0, 10.0)}


def as_it_is(v: float) -> float:
    return float(np.sign(v))


def smooth(v: float) -> float:
    return float(v / np.hypot(v, 0.05))


def rubbing(clamp: Rubbing, sign: Callable[[float], float]) -> PlainClamp:
    """Give such a clamp with its own sgn v."""

    def step(k, state, y_previous, y, v, h):  # type: ignore[no-untyped-def]
        return clamp.stiffness * y / 1e3 + clamp.damping * v / 1e3 + clamp.friction * sign(v), 0.0, ()

    return PlainClamp(ClampEquations((), (), step))


def truth(pipe: ReducedPipe, clamps: Sequence[Rubbing], frequency: float, time: np.ndarray) -> np.ndarray:
    """Give the displacement of the clamps, m, (clamps, n)."""
    modal = Modal.of(pipe)
    motion = integrate(modal, clamps, ACCELERATION, frequency, time)
    return modal.clamps @ motion[: len(pipe.omega)]


def off(found: np.ndarray, exact: np.ndarray) -> float:
    """Give the rms error over the last fifth as a share of the motion's rms, where it is largest."""
    late = slice(4 * exact.shape[1] // 5, None)
    return float((np.std(found[:, late] - exact[:, late], axis=1) / np.std(exact[:, late], axis=1)).max())


@pytest.mark.parametrize(
    ("frequency", "clamps", "sign"),
    [(9.0, ONE, as_it_is), (7.0, ONE, as_it_is), (7.0, ONE, smooth), (8.0, TWO, smooth)],
)
def test_friction_that_turns_or_holds_within_a_step(
    frequency: float, clamps: Mapping[float, Rubbing], sign: Callable[[float], float]
) -> None:
    places = {f"clamp{index}": at for index, at in enumerate(clamps)}
    pipe = reduce(parse_pipe(cantilever(0.01, 60.0, clamps=places)))
    steps = round(END / 1e-3)
    exact = truth(pipe, list(clamps.values()), frequency, np.linspace(0.0, END, steps + 1))
    errors = []
    for locates in (False, True):
        system = System(
            PlainPipe(pipe, len(clamps), True),
            tuple(rubbing(clamp, sign) for clamp in clamps.values()),
            lambda t: ACCELERATION * sin(2 * pi * frequency * t),
        )
        points = march(system, Iteration(system, SolverTolerance(1e-6, 60), locates=locates), END / steps, steps)
        errors.append(off(np.array([point.displacement for point in points]).T, exact))
    assert errors[1] < 0.005
    assert errors[1] < 0.5 * errors[0]


@pytest.mark.parametrize("frequency", [7.0, 9.0])
def test_a_run_of_fmus_with_friction_is_right_and_knows_how_far(frequency, tmp_path, write_law) -> None:
    write_law(tmp_path / "law.json", {"k10": 20.0, "c0": 0.02, "alpha0": 1.0, "F_c": 20.0}, "power", ("coulomb",))
    (tmp_path / "pipe.toml").write_text(cantilever(0.01, 60.0), encoding="utf-8")
    file = tmp_path / "system.toml"
    text = shaken(1.0, frequency, ACCELERATION).replace("step_s = 0.001", "step_s = 0.002")
    file.write_text(text, encoding="utf-8")
    result = run_system(file)
    pipe = reduce(parse_pipe(cantilever(0.01, 60.0)))
    error = off(result.columns["clamp1.s"][None], truth(pipe, [*ONE.values()], frequency, result.time))
    assert error < 0.005
    assert error < result.step_error < 0.02
    assert result.energy.coupling_share < 0.01


def test_a_reversal_within_the_clamp_fmu_s_own_step_costs_no_heat(tmp_path, write_law) -> None:
    """The step is walked to where the motion turned round, and back; slip itself is exact.

    A Jenkins element of stiffness k that slips at S dissipates 4 S (A - S/k) a cycle of amplitude A.
    """
    stiffness, slip, amplitude, frequency = 200e3, 8.0, 1e-3, 7.0
    write_law(tmp_path / "law.json", {"k_s": stiffness / 1e3, "z_s": slip, "alpha0": 1.0}, "memory")
    build_clamp(read_law(tmp_path / "law.json"), tmp_path / "clamp.fmu")
    exact = 4 * slip * (amplitude - slip / stiffness)
    errors = []
    for parts in (25, 50, 100):
        with opened([(tmp_path / "clamp.fmu", "clamp")]) as (fmu,):
            fmu.initialise({"A": amplitude, "f": frequency, "T": 293.15})
            clamp = FmuParticipant(fmu, ["flange.s", "flange.v"], ["flange.f"], ("energyDissipated",))
            heat, omega, h = [], 2 * pi * frequency, 1 / (frequency * parts)
            for index in range(1, 3 * parts + 1):
                phase = omega * h * (index + 0.3)
                clamp.set_inputs((amplitude * np.sin(phase), amplitude * omega * np.cos(phase)))
                clamp.step((index - 1) * h, h)
                heat.append(clamp.watched()[0])
        errors.append(1 - (heat[-1] - heat[-1 - 2 * parts]) / 2 / exact)
    assert np.abs(errors).max() < 1e-3, (
        "a way on which it begins to slip; 1.5 % in 25 steps a cycle where it isn't seen"
    )
