"""Native clamps whose memory is continuous states: hosts that complete no integrator steps get the right force."""

import ctypes
import math
import zipfile
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu
from native_driver import NativeDriver

from pipeclamp_fmu.build import build_native_clamp
from pipeclamp_fmu.contents.clamp_model import ClampStart
from pipeclamp_fmu.native.compiler import system_compiler
from pipeclamp_fmu.set_parameters import set_parameters
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.file import CoefficientEntry

A, F = 4e-4, 3.0
CONDITIONS = {"A": A, "f": F, "T": 400.0}
STEPS = 1000
"""Of a cycle."""
FINER = 10
"""Times these, steps of the co-simulation that the force is held against."""


def motion(t):
    theta = 2 * math.pi * F * t
    s = A * (math.sin(theta) + 0.3 * math.sin(3 * theta))
    return s, A * 2 * math.pi * F * (math.cos(theta) + 0.9 * math.cos(3 * theta))


@pytest.fixture(scope="module")
def law_of_many(law_with_memory):
    """A law with elements that slip and relax."""
    further = {"k_m": 80.0, "tau": 0.02}
    given = {name: CoefficientEntry(value=value, unit="", state="given") for name, value in further.items()}
    return law_with_memory.model_copy(
        update={
            "effects": (*law_with_memory.effects, "relaxation"),
            "coefficients": {**law_with_memory.coefficients, **given},
        }
    )


@pytest.fixture(scope="module")
def fmus(law_of_many, tmp_path_factory):
    if system_compiler() is None:
        pytest.skip("there is no C compiler (cc, gcc or clang) on the path")
    folder = tmp_path_factory.mktemp("states")
    for fmi in (2, 3):
        told = ClampStart(A=A, f=F, memory_as_states=True, events=fmi == 3)
        build_native_clamp(law_of_many, folder / f"fmi{fmi}.fmu", fmi, start=told)
    return {fmi: folder / f"fmi{fmi}.fmu" for fmi in (2, 3)}


class Integrated(NativeDriver):
    """An instance that is only ever told time, inputs and states."""

    def rates(self, t, states):
        self.at(t, states)
        rates = (ctypes.c_double * len(states))()
        (self.fmu.getDerivatives if self.fmi == 2 else self.fmu.getContinuousStateDerivatives)(rates, len(states))
        return np.array(rates)

    def at(self, t, states):
        self.fmu.setContinuousStates((ctypes.c_double * len(states))(*states), len(states))
        self.place(t, *motion(t))

    def step_on(self, t, h, x):
        """A step of Runge and Kutta's fourth order."""
        first = self.rates(t, x)
        second = self.rates(t + h / 2, x + h / 2 * first)
        third = self.rates(t + h / 2, x + h / 2 * second)
        return x + h / 6 * (first + 2 * second + 2 * third + self.rates(t + h, x + h * third))


def heated(n):
    return {"T": 350.0} if n == STEPS else {}


@pytest.mark.parametrize("fmi", [2, 3])
def test_an_integrator_that_completes_no_steps_gives_what_co_simulation_gives(fmus, tmp_path, fmi):
    """At a fixed step too, over reversals, yields and a change of temperature."""
    moving = CONDITIONS | {"flange.v": motion(0.0)[1]}
    stepped = NativeDriver(fmus[fmi], tmp_path / "stepped", "CoSimulation", moving)
    clamp = Integrated(fmus[fmi], tmp_path / "integrated", "ModelExchange", CONDITIONS)
    h = 1 / (F * STEPS)
    x, rows = np.zeros(3), []
    for n in range(2 * STEPS):
        clamp.set(heated(n))
        x = clamp.step_on(n * h, h, x)
        clamp.at((n + 1) * h, x)
        for part in range(1, FINER + 1):
            stepped.step(h / FINER, *motion((n + part / FINER) * h), **heated(n))
        rows.append([*clamp.get("flange.f", "energyDissipated"), *stepped.get("flange.f", "energyDissipated")])
    force, energy, true_force, true_energy = np.array(rows).T
    assert np.abs(force - true_force).max() < 3e-5 * np.abs(true_force).max()
    assert np.abs(energy - true_energy).max() < 2e-4 * true_energy.max()
    shown = ("memory.dissipated", "der(memory.q)", "memory.z", "memory.q", "flange.f")
    for one, other in zip(clamp.get(*shown), stepped.get(*shown), strict=True):
        assert one == pytest.approx(other, rel=2e-3, abs=1e-6)
    clamp.free(), stepped.free()


def test_what_is_carried_beyond_the_slip_force_counts_in_no_force_and_fades(fmus, tmp_path):
    clamp = Integrated(fmus[2], tmp_path / "one", "ModelExchange", CONDITIONS)
    forces = []
    for beyond in (0.0, 5.0):
        rates = clamp.rates(0.0, [60.0 + beyond, 0.0, 0.0])  # at s = 0 with v > 0
        forces += clamp.get("flange.f")
        fading = beyond * motion(0.0)[1] / (0.1 * A)
        assert rates[0] == pytest.approx(-fading, rel=1e-6, abs=1e-3)
    assert forces[0] == forces[1]
    clamp.free()


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_description_says_so(fmus, law_of_many, tmp_path, fmi):
    """And another law's parameters leave it so."""
    path = tmp_path / "clamp.fmu"
    set_parameters(fmus[fmi], law_of_many, path)
    assert path.read_bytes() == fmus[fmi].read_bytes()
    assert validate_fmu(str(path)) == []
    description = fmpy.read_model_description(str(path))
    assert description.numberOfContinuousStates == 3
    assert description.numberOfEventIndicators == int(fmi == 3)
    assert not description.modelExchange.needsCompletedIntegratorStep
    name = "providesDirectionalDerivative" + "s" * (fmi == 3)
    with zipfile.ZipFile(path) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    assert [root.find(kind).get(name) for kind in ("ModelExchange", "CoSimulation")] == ["false", "true"]
    (force,) = (entry for entry in description.outputs if entry.variable.name == "flange.f")
    assert {entry.name for entry in force.dependencies} >= {"memory.z", "memory.q", "flange.s"}


def test_tracking_is_refused_in_model_exchange(fmus, tmp_path):
    clamp = Integrated(fmus[2], tmp_path / "one", "ModelExchange", {**CONDITIONS, "track": True})
    clamp.place(1e-3, *motion(1e-3))
    with pytest.raises(FMICallException):
        clamp.get("flange.f")
    clamp.set({"track": False})
    assert clamp.get("flange.f")
    clamp.free()


def test_what_cannot_be_states_is_refused_by_name(law_with_memory, law_with_further_conditions, tmp_path):
    g_p = {"g_p": CoefficientEntry(value=0.05, unit="", state="given")}
    loose = law_with_memory.model_copy(
        update={
            "effects": (*law_with_memory.effects, "play"),
            "coefficients": {**law_with_memory.coefficients, **g_p},
        }
    )
    for law, told, words in (
        (loose, {}, "memory F_p, L_p jumps at reversals"),
        (law_with_further_conditions, {}, "firstCycle"),
        (law_with_memory, {"track": True}, "track A and f"),
    ):
        with pytest.raises(UserError, match=words):
            build_native_clamp(law, tmp_path / "a.fmu", start=ClampStart(memory_as_states=True, **told))
    assert list(tmp_path.iterdir()) == []


def test_casadi_integrates_it_beside_its_own_states(fmus, tmp_path):
    """CVODES over a sinusoid that CasADi integrates itself: with memory in completed steps it erred by per cents."""
    casadi = pytest.importorskip("casadi", reason="CasADi isn't installed: pip install casadi")
    fmpy.extract(str(fmus[2]), unzipdir=str(tmp_path / "casadi"))
    builder = casadi.DaeBuilder("clamp", str(tmp_path / "casadi"))
    for name, value in CONDITIONS.items():
        builder.set(name, value)
    imported = builder.create("imported", ["x", "u"], ["ode", "y"])
    omega, count = 2 * math.pi * F, 50
    moving, memory = casadi.MX.sym("moving", 2), casadi.MX.sym("memory", builder.nx())
    rates, _ = imported(memory, moving)
    dae = {
        "x": casadi.vertcat(moving, memory),
        "ode": casadi.vertcat(moving[1], -(omega**2) * moving[0], rates),
    }
    times = np.linspace(0.0, 2 / F, 2 * count + 1)[1:]
    integrator = casadi.integrator("i", "cvodes", dae, 0.0, times.tolist(), {"reltol": 1e-8, "abstol": 1e-11})
    path = np.array(integrator(x0=[0.0, A * omega, *[0.0] * builder.nx()])["xf"])
    forces = np.array([float(imported(state[2:], state[:2])[1][0]) for state in path.T])
    stepped = NativeDriver(fmus[2], tmp_path / "stepped", "CoSimulation", CONDITIONS)
    expected = []
    for time in np.linspace(0.0, 2 / F, 2 * count * 100 + 1)[1:]:
        theta = omega * time
        stepped.step(1 / (F * count * 100), A * math.sin(theta), A * omega * math.cos(theta))
        expected += stepped.get("flange.f")
    expected = np.array(expected[99::100])
    assert np.abs(forces - expected).max() < 3e-4 * np.abs(expected).max()
    stepped.free()
