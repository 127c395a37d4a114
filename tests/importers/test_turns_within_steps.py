"""A clamp's memory turns round where the motion did, within its own step, in either kind and version."""

import math

import numpy as np
import pytest
from native_driver import NativeDriver
from test_native_clamp_fmu import KNOWN, UNKNOWN, WIDTHS

from pipeclamp_fmu.build import build_clamp, build_native_clamp
from pipeclamp_fmu.native.compiler import system_compiler
from pipeclamp_models.law.file import CoefficientEntry

A, F = 5e-4, 3.0
CONDITIONS = {"A": A, "f": F, "T": 400.0}
COARSE, FINER = 12.37, 64
"""Steps in a cycle; by how many each is divided for what it is held against."""
CYCLES = 12


def motion(t):
    theta = 2 * math.pi * F * t
    return A * math.sin(theta), A * 2 * math.pi * F * math.cos(theta)


@pytest.fixture(params=["python", "native 2", "native 3"])
def clamp(request, drive, law_with_memory, native_fmus, tmp_path):
    """Give functions that step a clamp and that give its force and heat, and one that begins anew."""
    if request.param == "python":
        build_clamp(law_with_memory, tmp_path / "clamp.fmu")
        driver = drive(tmp_path / "clamp.fmu", CONDITIONS)
        yield (
            lambda h, s, v: driver.step(h, flange__s=s, flange__v=v),
            lambda: (driver.get("flange.f"), driver.get("energyDissipated")),
            lambda: (driver.slave.reset(), driver.start(CONDITIONS)),
        )
        return
    native = NativeDriver(native_fmus[int(request.param[-1])], tmp_path / "native", "CoSimulation", CONDITIONS)
    yield (
        native.step,
        lambda: native.get("flange.f", "energyDissipated"),
        lambda: (native.fmu.reset(), native.start(CONDITIONS)),
    )
    native.free()


def run(clamp, parts):
    """Force and heat at the ends of the coarse steps."""
    step, answer, begin = clamp
    h, rows = 1 / (F * COARSE), []
    begin()
    step(1e-9, *motion(0.0))
    for n in range(int(CYCLES * COARSE)):
        for part in range(1, parts + 1):
            step(h / parts, *motion((n + part / parts) * h))
        rows.append(answer())
    return np.array(rows).T


def test_twelve_steps_a_cycle_give_force_and_heat(clamp):
    """Straight steps err by 0.3 % in force and 4 % in heat."""
    force, heat = run(clamp, 1)
    true_force, true_heat = run(clamp, FINER)
    assert np.sqrt(np.mean((force - true_force) ** 2)) < 1e-4 * np.sqrt(np.mean(true_force**2))
    assert heat[-1] == pytest.approx(true_heat[-1], rel=1e-3)


@pytest.mark.parametrize("kind", ["python", "native"])
def test_play_lets_the_clamp_go_within_a_step(drive, law_with_memory, tmp_path, kind):
    """In 25 steps a cycle; where it does so at the end of the step, the force errs by 4 %."""
    given = CoefficientEntry(value=0.1, unit="", state="given")
    law = law_with_memory.model_copy(
        update={
            "effects": (*law_with_memory.effects, "play"),
            "coefficients": {
                **law_with_memory.coefficients,
                "g_p": given,
            },
        }
    )
    path = tmp_path / "play.fmu"
    if kind == "native" and system_compiler() is None:
        pytest.skip("there is no C compiler (cc, gcc or clang) on the path")
    (build_native_clamp if kind == "native" else build_clamp)(law, path)
    clamp = drive(path, CONDITIONS)
    forces = []
    for parts in (1, FINER):
        clamp.slave.reset()
        clamp.start(CONDITIONS)
        h = 1 / (F * 25.37)
        clamp.step(1e-9, flange__s=0.0, flange__v=motion(0.0)[1])
        forces.append([])
        for n in range(8 * 25):
            for part in range(1, parts + 1):
                s, v = motion((n + part / parts) * h)
                clamp.step(h / parts, flange__s=s, flange__v=v)
            forces[-1].append(clamp.get("flange.f"))
    force, true_force = np.array(forces)
    assert np.sqrt(np.mean((force - true_force) ** 2)) < 1e-2 * np.sqrt(np.mean(true_force**2))


@pytest.mark.parametrize("switches", [{}, {"track": True}])
@pytest.mark.parametrize("fmi", [2, 3])
def test_derivatives_across_a_turn_are_those_of_the_step(native_fmus, tmp_path, fmi, switches):
    """By the place of the turn too, which moves with the inputs and takes memory along."""
    clamp = NativeDriver(native_fmus[fmi], tmp_path / "clamp", "CoSimulation", CONDITIONS | switches)
    h = 1 / (F * COARSE)
    turn = next(n for n in range(20, 40) if motion(n * h)[1] * motion((n + 1) * h)[1] < 0)
    for n in range(1, turn + 1):
        clamp.step(h, *motion(n * h))
    before = clamp.fmu.getFMUstate() if fmi == 2 else clamp.fmu.getFMUState()
    base = dict(zip(KNOWN[:2], motion((turn + 1) * h), strict=True)) | CONDITIONS | {"T_in": 350.0}

    def outcome(values):
        (clamp.fmu.setFMUstate if fmi == 2 else clamp.fmu.setFMUState)(before)
        clamp.set(values)
        clamp.fmu.doStep(0.0, h)
        return np.array(clamp.get(*UNKNOWN))

    here = outcome(base)
    told = np.array(clamp.jacobian(UNKNOWN, KNOWN))
    for index, (name, width) in enumerate(zip(KNOWN, WIDTHS, strict=True)):
        ahead, behind = (outcome(base | {name: base[name] + aside}) for aside in (width, -width))
        numeric = (ahead - behind) / (2 * width)
        rounding = 1e-13 * (np.abs(here) + 1e-3) / width
        assert (np.abs(told[:, index] - numeric) <= 1e-5 * np.abs(numeric) + rounding).all(), name
    clamp.free()
