"""One law in every realisation: arrays, plain Python, the Python slave, native FMI 2.0 and 3.0, both interfaces.

What wraps the law's C differs by version of FMI, not by effect: laws of one effect are built for either version in
turn, composed laws for both. These are compiled as users' are, laws of one effect without optimisation.
"""

import math
import random
from contextlib import contextmanager

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from native_driver import INTERFACES, NativeDriver
from test_effect_contract import SMOOTHING, STRUCTURES, name_of, sound_values

from pipeclamp_fmu.build import native_clamp_content
from pipeclamp_fmu.contents import passivity
from pipeclamp_fmu.contents.clamp import clamp_module, clamp_variables, quantities
from pipeclamp_fmu.contents.clamp_of_law import clamp_model
from pipeclamp_fmu.contents.continuous_memory import parts_of_step
from pipeclamp_fmu.describe.variables import numbers_of
from pipeclamp_fmu.native import compiler
from pipeclamp_fmu.native.compiler import default_platforms
from pipeclamp_fmu.native.packing import write_native_fmu
from pipeclamp_fmu.slaves.loading import instance_of
from pipeclamp_fmu.slaves.values_file import values_text
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import CoefficientEntry, Interval
from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import Motion
from pipeclamp_models.steps.within_step import walk

CLAMP = ("base", "clamp")
IN_AN_FMU = [
    structure for structure in STRUCTURES if not any(effect.part == "rig" for effect in structure.all_effects())
]
COMPOSED = [
    Structure("power", ("memory:2", "relaxation", "gap", "directional_damping", "damping_temperature")),
    Structure("series:5:2", ("hardening", "coulomb", "contact_growth", "memory")),
    Structure("memory", ("end_stop", "asymmetry", "stiffness_frequency", "viscous", "play")),
    Structure("power", ("bouc_wen", "slip_speed", "slip_temperature", "relaxation", "gap", "directional_damping")),
    Structure("power", ("slip_spread", "slip_speed", "self_centring", "pressed_slip", "slip_lock", "oil_damper")),
]
OPTIMISED = COMPOSED[3]
"""Compiled as users' are, which takes most of the time; so is the first, for random motions."""
CONDITIONS = {"A": 0.6, "f": 3.0, "T": 400.0}
FURTHER = {"N": 40.0, "rho": 2.5, "u_current_A": 0.6}
IN_THE_FMU = {"N": ("firstCycle", 1.0), "rho": ("rho", 1000.0), "u_current_A": ("condition.current_A", 1.0)}
RANGE = {
    "A": (0.2, 1.0), "f": (1.0, 5.0), "T": (293.15, 573.15), "N": (0.0, 500.0), "rho": (2.0, 3.0),
    "current_A": (-1.0, 1.0),
}  # fmt: skip
H = 2e-3
SAME = {"rtol": 1e-10, "atol": 1e-9}


def law_file(structure, values):
    """A law as a parameter file, over the usual range."""
    names = structure.equations_without_rig.names
    return open_law("emwm2").model_copy(
        update={
            "name": name_of(structure),
            "base": structure.base,
            "effects": structure.effects,
            "declared": structure.declared,
            "smoothing": {"v_r": SMOOTHING[0], "y_r": SMOOTHING[1]},
            "coefficients": {name: CoefficientEntry(value=values[name], unit="", state="given") for name in names},
            "range": {name: Interval(minimum=low, maximum=high, unit="") for name, (low, high) in RANGE.items()},
        }
    )


def wandering(seed, count=60):
    """A motion from rest that turns round within steps, y in mm and v in mm/s as of the straight way."""
    rng = random.Random(seed)
    y = [0.0]
    for _ in range(count):
        y.append(min(max(y[-1] + rng.gauss(0.0, 0.2), -1.0), 1.0))
    return np.array(y[1:]), np.diff(y) / H


def turning_at_points(y, v):
    """The same motion, at rest for a moment where it turns round."""
    return y, np.where(np.append(v[1:] * v[:-1] < 0.0, False), 0.0, v)


def by_arrays(structure, values, y, v):
    """Force from the vectorised realisation."""
    equations = structure.equations_without_rig
    slow = {name: np.array([[value]]) for name, value in (CONDITIONS | FURTHER).items()}
    # Load cycles when each step began, four amplitudes of way each.
    way = np.concatenate([[0.0], np.abs(np.diff(y, prepend=0.0))[:-1]])
    slow["N"] = FURTHER["N"] + np.cumsum(way)[None] / (4 * CONDITIONS["A"])
    motion = Motion(y[None], v[None], 0 * y[None], slow, np.array([[H]]), periodic=False)
    return force_of_equations(equations, [values[name] for name in equations.names], SMOOTHING, motion).force[0]


def by_scalars(model, y, v, straight=False):
    """Force, dissipated energy (J) and states from the plain source; as the FMU walks, or as arrays do."""
    law = model.law
    further = [FURTHER[name] for name in further_of(model)]
    state, y_before, v_before = tuple(start for _, start in law.states), 0.0, 0.0
    rows, lost, parts = [], 0.0, 1 if straight else parts_of_step(model)
    for place, speed in zip(y.tolist(), v.tolist(), strict=True):
        k = law.coefficients(*CONDITIONS.values(), *further)
        begun = law.step(k, state, y_before, y_before, v_before, 0.0)[:2]
        force, _, state, heat, way = walk(law.step, k, state, (y_before, v_before, place, speed), H, begun, parts)
        lost += 1e-3 * heat
        if model.counted >= 0:
            further[model.counted] += way / (4 * CONDITIONS["A"])
        y_before, v_before = place, speed
        rows.append((force, lost, *state))
    return np.array(rows)


class SlaveDriver:
    """An instance of the Python FMU's own module, by variable names."""

    def __init__(self, model, start):
        variables = clamp_variables(model, quantities(model))
        values = values_text("", model.name, numbers_of(variables, model.ranges))
        self.slave = instance_of(clamp_module(model), "ClampSlave", values)
        self.references = {variable.name: reference for reference, variable in self.slave.vars.items()}
        self.booleans = {variable.name for variable in variables.booleans}
        self.set(start)
        self.slave.exit_initialization_mode()

    def set(self, values):
        for name, value in values.items():
            put = self.slave.set_boolean if name in self.booleans else self.slave.set_real
            put([self.references[name]], [value])

    def get(self, *names):
        return self.slave.get_real([self.references[name] for name in names])

    def flag(self, name):
        return self.slave.get_boolean([self.references[name]])[0]


def by_slave(driver, y, v):
    """Force and dissipated energy from the Python FMU's own module."""
    rows = []
    for index, (place, speed) in enumerate(zip(y.tolist(), v.tolist(), strict=True)):
        driver.set({"flange.s": 1e-3 * place, "flange.v": 1e-3 * speed})
        assert driver.slave.do_step(index * H, H)
        rows.append(driver.get("flange.f", "energyDissipated"))
    return np.array(rows)


def further_of(model):
    """Names of the law's further conditions, in the order in which it takes them."""
    by_name = {name: condition for condition, (name, _) in IN_THE_FMU.items()}
    return [by_name[entry.name] for entry in model.further]


def native_start(model=None, **coefficients):
    """Conditions as the FMU has them, in the order of its parameters."""
    names = further_of(model) if model else ()
    further = {IN_THE_FMU[name][0]: IN_THE_FMU[name][1] * FURTHER[name] for name in names}
    return {"A": 1e-3 * CONDITIONS["A"], "f": CONDITIONS["f"], "T": CONDITIONS["T"], **further, **coefficients}


def by_native(driver, states, y, v):
    """Force, dissipated energy and states from a native FMU."""
    rows = []
    for place, speed in zip(y.tolist(), v.tolist(), strict=True):
        driver.step(H, 1e-3 * place, 1e-3 * speed)
        rows.append(driver.get("flange.f", "energyDissipated", *(f"memory.{name}" for name in states)))
    return np.array(rows)


@pytest.fixture(scope="module", autouse=True)
def no_cycle_sought():
    """Leave the seeking of a cycle that feeds energy in to units/fmu/test_passivity.py; the ranges' ends are tried."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(passivity, "_sought", lambda *_: ())
        patch.setattr(passivity, "GRID_POINTS", {"A": 2, "f": 2, "T": 2})
        yield


@contextmanager
def native(file, folder, versions=(2, 3), optimisation="-O2"):
    """Build a law's native FMUs; give a function that makes an instance for a version and an interface."""
    platforms = {fmi: default_platforms(fmi) for fmi in versions}
    if not all(platforms.values()):
        pytest.skip("there is no C compiler (cc, gcc or clang) on the path")
    content = native_clamp_content(file)
    assert "-O2" in compiler.FLAGS
    flags = tuple(optimisation if flag == "-O2" else flag for flag in compiler.FLAGS)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compiler, "FLAGS", flags)
        for fmi in versions:
            write_native_fmu(content, folder / f"{fmi}.fmu", fmi, platforms[fmi])
    made = []

    def make(fmi, kind, start):
        made.append(NativeDriver(folder / f"{fmi}.fmu", folder / str(len(made)), kind, start))
        return made[-1]

    try:
        yield make
    finally:
        for driver in made:
            driver.free()


@pytest.mark.parametrize(
    ("structure", "versions"),
    [
        *((structure, (2 + place % 2,)) for place, structure in enumerate(IN_AN_FMU)),
        *((structure, (2, 3)) for structure in COMPOSED),
    ],
    ids=lambda value: name_of(value) if isinstance(value, Structure) else f"FMI {' and '.join(map(str, value))}",
)
def test_every_realisation_gives_the_same(structure, versions, tmp_path):
    """Forces, states and energies to 1e-10."""
    values = sound_values(structure)
    file = law_file(structure, values)
    y, v = turning_at_points(*wandering(seed=len(name_of(structure))))
    model = clamp_model(file)
    states = [state.name for state in structure.equations_without_rig.states]
    expected = by_scalars(model, y, v)
    plain = by_scalars(model, y, v, straight=True)
    np.testing.assert_allclose(by_arrays(structure, values, y, v), plain[:, 0], **SAME)
    np.testing.assert_allclose(by_slave(SlaveDriver(model, native_start(model)), y, v), expected[:, :2], **SAME)
    with native(file, tmp_path, versions, "-O2" if structure is OPTIMISED else "-O0") as make:
        for fmi, kind in (interface for interface in INTERFACES if interface[0] in versions):
            driver = make(fmi, kind, native_start(model))
            at_rest = driver.jacobian(("flange.f", "energyDissipated"), ("flange.s", "flange.v", "A", "f", "T"))
            assert np.isfinite(at_rest).all(), "a derivative where nothing moves is no number"
            np.testing.assert_allclose(by_native(driver, states, y, v), expected, **SAME, err_msg=f"{fmi} {kind}")


@pytest.fixture(scope="module")
def composed(tmp_path_factory):
    """Give an instance of every interface for a composed law, and the law's parameter file."""
    structure = COMPOSED[0]
    file = law_file(structure, sound_values(structure))
    with native(file, tmp_path_factory.mktemp("composed")) as make:
        yield structure, file, [make(fmi, kind, native_start()) for fmi, kind in INTERFACES]


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seed=st.integers(0, 10**6), shares=st.lists(st.floats(0.5, 2.0), min_size=30, max_size=30))
def test_random_laws_and_motions_give_the_same(composed, seed, shares):
    """Coefficients are set through the FMU's parameters, so that one build serves every law."""
    structure, file, drivers = composed
    values = {
        name: share * entry.value for (name, entry), share in zip(file.coefficients.items(), shares, strict=False)
    }
    y, v = wandering(seed)
    states = [state.name for state in structure.equations_without_rig.states]
    expected = by_scalars(clamp_model(law_file(structure, values)), y, v)
    start = native_start(**{f"law.{name}": value for name, value in values.items()})
    np.testing.assert_allclose(by_slave(SlaveDriver(clamp_model(file), start), y, v), expected[:, :2], **SAME)
    for driver in drivers:
        driver.fmu.reset()
        driver.start(start)
        np.testing.assert_allclose(by_native(driver, states, y, v), expected, **SAME)


bad_values = st.one_of(st.sampled_from([math.nan, math.inf, -math.inf, 0.0, -1.0, 1e300]), st.floats(1e-4, 2e-3))
names = st.sampled_from(["flange.s", "flange.v", "T_in", "A", "f", "T"])
moves = st.lists(st.tuples(names, bad_values, st.sampled_from([1e-3, 0.0, -1e-3, math.nan])), max_size=12)
coefficients = st.dictionaries(
    st.sampled_from(["law.k10", "law.k1_A", "law.z_s1", "law.tau", "law.v_r"]),
    st.sampled_from([math.nan, math.inf, -math.inf, 0.0, -1.0, 1e300, 1e-320, 2.0]),
    max_size=2,
)


@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(sequence=moves, track=st.booleans(), from_input=st.booleans(), changed=coefficients)
def test_guards_are_those_of_the_python_slave(composed, sequence, track, from_input, changed):
    """The same steps are discarded, with the same outputs after them and inRange alike."""
    _, file, drivers = composed
    start = {"useTemperatureInput": from_input, "track": track, **changed}
    slave = SlaveDriver(clamp_model(file), start)
    outputs = ("flange.f", "A_used", "f_used", "T_used", "energyDissipated")
    steppers = [driver for driver in drivers if not driver.exchanged]
    for driver in steppers:
        driver.fmu.reset()
        driver.start(start)
    for name, value, h in sequence:
        slave.set({name: value})
        done = slave.slave.do_step(0.0, h)
        for driver in steppers:
            driver.set({name: value})
            try:
                driver.fmu.doStep(0.0, h)
                status = 0
            except Exception as refusal:
                status = refusal.status
            assert status == (0 if done else 2)
            np.testing.assert_allclose(driver.get(*outputs), slave.get(*outputs), **SAME)
            assert driver.flag("inRange") == slave.flag("inRange")
