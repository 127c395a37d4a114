"""PathSim runs the clamp as a block: at its communication points, co-simulation's force; so it does integrated."""

import math

import numpy as np
import pytest
from native_driver import NativeDriver

from pipeclamp_fmu.build import build_native_clamp
from pipeclamp_fmu.contents.clamp_model import ClampStart

pytest.importorskip("pathsim_fmi", reason="PathSim isn't installed: pip install pathsim-fmi")

from pathsim import Connection, Simulation
from pathsim.blocks import Scope, Source
from pathsim.solvers import RK4
from pathsim_fmi import CoSimulationFMU, ModelExchangeFMU

A, F, STEP, STEPS = 5e-4, 3.0, 1e-3, 500
START = {"A": A, "f": F, "T": 350.0}


def displacement(t):
    return A * math.sin(2 * math.pi * F * t)


def velocity(t):
    return A * 2 * math.pi * F * math.cos(2 * math.pi * F * t)


def run(block, step, **options):
    """Give a run's times and the forces of a clamp that is moved."""
    s, v, scope = Source(displacement), Source(velocity), Scope()
    wires = [(s, block["flange.s"]), (v, block["flange.v"]), (block["flange.f"], scope[0])]
    Simulation([s, v, block, scope], [Connection(*wire) for wire in wires], dt=step, log=False, **options).run(
        STEP * STEPS
    )
    times, (forces,) = scope.read()
    return times, forces


@pytest.fixture
def own(native_fmus, tmp_path):
    """Give forces that belong to the times 0, STEP and so on."""
    clamp = NativeDriver(native_fmus[2], tmp_path / "own", "CoSimulation", START)
    forces = []
    for n in range(STEPS + 1):
        clamp.step(STEP, displacement(n * STEP), velocity(n * STEP))
        forces += clamp.get("flange.f")
    clamp.free()
    return np.array(forces)


@pytest.mark.parametrize("fmi", [2, 3])
def test_co_simulation_gives_the_force_at_its_points(native_fmus, own, fmi):
    times, forces = run(CoSimulationFMU(str(native_fmus[fmi]), dt=STEP, start_values=START), STEP)
    np.testing.assert_allclose(times, STEP * np.arange(STEPS + 1), atol=1e-9)
    np.testing.assert_allclose(forces, own, atol=1e-7)


def test_integrated_memory_gives_co_simulations_force(law_with_memory, native_fmus, own, tmp_path):
    fmu = tmp_path / "states.fmu"
    build_native_clamp(law_with_memory, fmu, start=ClampStart(memory_as_states=True))
    times, forces = run(ModelExchangeFMU(str(fmu), start_values=START), STEP, Solver=RK4)
    theirs = np.interp(STEP * np.arange(STEPS + 1), times, forces)
    np.testing.assert_allclose(theirs[1:], own[1:], atol=1e-3 * np.abs(own).max())
