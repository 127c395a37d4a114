"""To which moment a tool's force belongs: in fmpy, as the page on it says, to the moment that stands beside it."""

import math
import re

import numpy as np
import pytest
from native_driver import NativeDriver
from project import ROOT

from pipeclamp_fmu.build import build_clamp, build_native_clamp
from pipeclamp_fmu.native.compiler import system_compiler
from pipeclamp_models.law.bundled import open_law

PAGE = (ROOT / "docs" / "howto" / "fmu-in-fmpy.md").read_text(encoding="utf-8")
PROGRAM = next(text for text in re.findall(r"```python\n(.*?)```", PAGE, re.S) if "simulate_fmu" in text)
STEP = 1e-3


@pytest.fixture(scope="module")
def native(tmp_path_factory):
    if system_compiler() is None:
        pytest.skip("there is no C compiler (cc, gcc or clang) on the path")
    path = tmp_path_factory.mktemp("native") / "clamp.fmu"
    build_native_clamp(open_law("emwm2"), path)
    return path


@pytest.fixture(scope="module")
def forces(native, tmp_path_factory):
    """Forces that belong to the times 0, STEP and so on of the page's motion, stepped by hand."""
    folder = tmp_path_factory.mktemp("by_hand")
    clamp = NativeDriver(native, folder, "CoSimulation", {"A": 0.5e-3, "f": 3.0, "T": 293.15})
    omega, found = 2 * math.pi * 3.0, []
    for n in range(1901):
        clamp.step(STEP, 0.5e-3 * math.sin(omega * STEP * n), 0.5e-3 * omega * math.cos(omega * STEP * n))
        found += clamp.get("flange.f")
    clamp.free()
    return np.array(found)


def run_of_the_page(folder, *changes):
    program = PROGRAM
    for old, new in changes:
        assert old in program
        program = program.replace(old, new)
    names = {}
    exec(program.replace('"clamp.fmu"', repr(str(folder / "clamp.fmu"))), names)
    return names["result"]


@pytest.mark.parametrize("kind", ["native", "python"])
def test_the_pages_run_gives_the_force_at_each_time(request, forces, tmp_path, kind):
    if kind == "python":
        build_clamp(open_law("emwm2"), tmp_path / "clamp.fmu")
    result = run_of_the_page(tmp_path if kind == "python" else request.getfixturevalue("native").parent)
    np.testing.assert_allclose(result["time"], STEP * np.arange(len(forces)), atol=1e-9)
    np.testing.assert_allclose(result["flange.f"][1:], forces[1:], atol=1e-7)


def test_it_is_as_late_as_the_page_says_where_the_motion_is_not_handed_over_early(native, forces):
    result = run_of_the_page(native.parent, ("time - step, displacement", "time, displacement"))
    np.testing.assert_allclose(result["flange.f"][1:], forces[:-1], atol=1e-7)
    assert f"| {np.abs(np.diff(forces)).max():.0f} |" in PAGE


def test_model_exchange_takes_the_motion_as_it_is(native, forces):
    as_it_is = ("time - step, displacement", "time, displacement")
    result = run_of_the_page(native.parent, as_it_is, ("stop_time=1.9", 'fmi_type="ModelExchange", stop_time=1.9'))
    np.testing.assert_allclose(result["flange.f"][1:], forces[1:], atol=1e-7)


def test_a_loop_over_what_the_force_belongs_to_has_the_heat_for_its_area(native):
    """In a tool that is late, too."""
    late = ("time - step, displacement", "time, displacement"), ('["flange.f", ', '["flange.f", "memory.s", ')
    result = run_of_the_page(native.parent, *late)
    two_cycles = result[(result["time"] > 1.0 - 0.5 * STEP) & (result["time"] < 5 / 3 + 0.5 * STEP)]
    force, place = two_cycles["flange.f"], two_cycles["memory.s"]
    area = np.sum((force[1:] + force[:-1]) / 2 * np.diff(place))
    assert area == pytest.approx(np.ptp(two_cycles["energyDissipated"]), rel=2e-3)
