"""Density, further conditions and load cycles as parameters of the clamp FMU, of Python and native."""

import math

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from pipeclamp_fmu.build import build_clamp, build_native_clamp
from pipeclamp_fmu.contents.clamp_of_law import clamp_model
from pipeclamp_fmu.native.compiler import system_compiler
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.file import write_law
from pipeclamp_models.steps.within_step import walk
from pipeclamp_system.cosim.run import run_system
from pipeclamp_system.cosim.variables import clamp_parameters
from pipeclamp_system.description.system import read_system
from pipeclamp_system.fmus.variables import read_model_description, variables_of
from pipeclamp_system.steady.described import steady_clamp

H = 1e-3
SECOND_CLAMP = '[[clamps]]\nname = "clamp2"\nposition_m = 5.0\n'
SET = {"A": 5e-4, "f": 3.0, "T": 350.0, "rho": 2500.0, "condition.current_A": 1.5, "firstCycle": 20.0}


@pytest.fixture(scope="module", params=["python", "native"])
def further(request, fmus, law_with_further_conditions, tmp_path_factory):
    """Give the path of a clamp that follows them, of each kind."""
    if request.param == "python":
        return fmus["further"]
    if system_compiler() is None:
        pytest.skip("there is no C compiler (cc, gcc or clang) on the path")
    path = tmp_path_factory.mktemp("further") / "further.fmu"
    build_native_clamp(law_with_further_conditions, path)
    return path


def test_they_are_tunable_parameters_with_unit_start_and_range(further):
    assert validate_fmu(str(further)) == []
    variables = {variable.name: variable for variable in fmpy.read_model_description(str(further)).modelVariables}
    rho, current, cycles = (variables[name] for name in ("rho", "condition.current_A", "firstCycle"))
    assert {entry.variability for entry in (rho, current, cycles)} == {"tunable"}
    assert (rho.unit, rho.displayUnit, float(rho.start)) == ("kg/m3", "g/cm3", 2300.0)
    assert float(rho.min) == 200.0
    assert "law's range 2 to 2.6 g/cm3" in rho.description
    assert (float(current.start), float(cycles.start), float(cycles.min)) == (0.5, 0.0, 0.0)
    assert float(current.min) < -1.0


def test_the_force_follows_them_and_the_cycles_are_counted(drive, further, law_with_further_conditions):
    clamp = drive(further, SET)
    law = clamp_model(law_with_further_conditions).law
    state, y_before, v_before, seen = (0.0,), 0.0, 0.0, 20.0
    rho, current = 2.5, 1.5
    for n in range(3000):
        if n == 1500:
            rho, current = 2.2, -0.5
            clamp.set({"rho": 1000.0 * rho, "condition.current_A": current})
        theta = 2 * math.pi * 3.0 * H * (n + 1)
        y, v = 0.5 * math.sin(theta), 0.5 * 6 * math.pi * math.cos(theta)
        clamp.step(H, flange__s=1e-3 * y, flange__v=1e-3 * v)
        k = law.coefficients(0.5, 3.0, 350.0, seen, rho, current)
        force, _, state, _, way = walk(law.step, k, state, (y_before, v_before, y, v), H, (0.0, 0.0), 1)
        assert clamp.get("flange.f") == pytest.approx(force, rel=1e-10, abs=1e-9)
        seen += way / (4 * 0.5)
        y_before, v_before = y, v
    assert seen - 20.0 == pytest.approx(9.0, abs=1e-6), "nine cycles in 3 s"
    assert clamp.get("inRange")


def test_a_clamp_loosens_as_it_runs_and_with_cycles_that_it_has_seen_before(drive, further, shaken):
    fresh, old = drive(further, {**SET, "firstCycle": 0.0}), drive(further, {**SET, "firstCycle": 190.0})
    first, later, worn = shaken(fresh, 0, 1000), shaken(fresh, 1000, 2000), shaken(old, 0, 1000)
    assert max(worn) < 0.97 * max(later) < 0.97 * max(first)


@pytest.mark.parametrize("track", [False, True])
def test_cycles_and_conditions_roll_back_exactly(drive, further, shaken, track):
    untouched, iterated = drive(further, {**SET, "track": track}), drive(further, {**SET, "track": track})
    assert shaken(untouched, 0, 300) == shaken(iterated, 0, 300)
    saved = iterated.save()
    for wild in (9e-4, -8e-4, 1e-4):
        iterated.set({"rho": 2100.0, "condition.current_A": 0.1})
        iterated.step(H, flange__s=wild, flange__v=wild)
        iterated.restore(saved)
    iterated.time = untouched.time
    elsewhere = drive(further)
    elsewhere.deserialise(iterated.serialised())
    elsewhere.time = untouched.time
    expected = shaken(untouched, 300, 600)
    assert shaken(iterated, 300, 600) == expected
    assert shaken(elsewhere, 300, 600) == expected
    assert untouched.all() == iterated.all() == elsewhere.all()


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("rho", 3000.0, "rho = 3"),
        ("condition.current_A", -2.0, "condition.current_A = -2"),
        ("firstCycle", 300.0, "300"),
    ],
)
def test_beyond_the_laws_range_it_warns_and_inrange_is_false(drive, further, shaken, name, value, words):
    clamp = drive(further, {**SET, "condition.current_A": -1.0})
    shaken(clamp, 0, 3)
    assert clamp.get("inRange"), "the end of the range is in it, below zero too"
    clamp.set({name: value})
    shaken(clamp, 3, 6)
    assert not clamp.get("inRange")
    (warning,) = clamp.messages.warnings
    assert words in warning and "is outside" in warning


@pytest.mark.parametrize(("name", "value"), [("rho", 0.0), ("rho", math.nan), ("condition.current_A", math.inf)])
def test_impossible_values_discard_the_step(drive, further, shaken, name, value):
    clamp = drive(further, SET)
    before = shaken(clamp, 0, 3)[-1]
    clamp.set({name: value})
    assert name in clamp.discarded(H, flange__s=1e-4, flange__v=0.0)
    assert clamp.get("flange.f") == before


def test_a_law_whose_range_lacks_a_condition_is_refused(law_with_further_conditions, tmp_path):
    file = law_with_further_conditions
    narrow = file.model_copy(update={"range": {key: value for key, value in file.range.items() if key != "rho"}})
    with pytest.raises(UserError, match="depends on rho, but its range doesn't hold it"):
        build_clamp(narrow, tmp_path / "no.fmu")


def test_a_law_that_creates_energy_at_an_end_of_a_condition_is_refused(law_with_further_conditions, tmp_path):
    entries = law_with_further_conditions.coefficients
    worse = {**entries, "l_N": entries["l_N"].model_copy(update={"value": 0.0})}
    worse["c0"] = entries["c0"].model_copy(update={"value": -1.0})
    with pytest.raises(UserError, match=r"create energy.*further conditions"):
        build_clamp(law_with_further_conditions.model_copy(update={"coefficients": worse}), tmp_path / "no.fmu")


SYSTEM = """
name = "further"
[pipe]
file = "pipe.toml"
[[clamps]]
at = "clamp1"
law = "further.json"
temperature_C = 77.0
amplitude_mm = 0.5
frequency_Hz = 3.0
conditions = { %s }
[excitation]
kind = "sine"
acceleration_m_s2 = 5.0
frequency_Hz = 3.0
[run]
stop_s = 2.0
step_s = 0.002
"""
CONDITIONS = "density_g_cm3 = 2.5, current_A = 1.5, first_cycle = 190"


@pytest.fixture
def system(tmp_path, pipe_text, law_with_further_conditions):
    """Give a function that writes a system with conditions of its clamp."""
    (tmp_path / "pipe.toml").write_text(pipe_text().replace(SECOND_CLAMP, ""), encoding="utf-8")
    write_law(law_with_further_conditions, tmp_path / "further.json")

    def write(conditions):
        (tmp_path / "SYSTEM.toml").write_text(SYSTEM % conditions, encoding="utf-8")
        return tmp_path / "SYSTEM.toml"

    return write


def test_a_system_gives_its_clamps_conditions_by_column(system, tmp_path, law_with_further_conditions):
    file = law_with_further_conditions
    path = system(CONDITIONS)
    (source,) = read_system(path).clamps
    build_clamp(file, tmp_path / "further.fmu")
    variables = variables_of(read_model_description(tmp_path / "further.fmu"))
    given = clamp_parameters(source, read_system(path), variables)
    assert (given["rho"], given["condition.current_A"], given["firstCycle"]) == (2500.0, 1.5, 190.0)
    steady = steady_clamp(source, tmp_path, None, "here")
    assert steady.further == {"N": 190.0, "rho": 2.5, "u_current_A": 1.5}
    law = clamp_model(file).law
    k = law.coefficients(0.5, 3.0, 350.15, 190.0, 2.5, 1.5)
    spring = law.step(k, (0.0,), 0.0, 1e-3, 0.0, 1.0)[0] / 1e-3
    moved = steady.forces(np.array([[0.0, 1e-3 + 0j]]), np.array([1e-4]))[0, 1].real / 1e-3
    assert moved == pytest.approx(spring, rel=1e-3)
    result = run_system(path)
    other = run_system(system("density_g_cm3 = 2.0"))
    assert np.ptp(result.columns["clamp1.s"][-300:]) < 0.9 * np.ptp(other.columns["clamp1.s"][-300:])


def test_a_condition_that_the_law_does_not_follow_is_refused(system, tmp_path):
    path = system("bolt_torque_Nm = 3.0")
    refused = "conditions: bolt_torque_Nm: .* doesn't follow it"
    with pytest.raises(UserError, match=refused):
        run_system(path)
    with pytest.raises(UserError, match=refused):
        steady_clamp(read_system(path).clamps[0], tmp_path, None, "here")
