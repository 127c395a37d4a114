"""The clamp FMU in fmpy, of Python and native: its force, its states, its guards, its range, its tracking."""

import math
from dataclasses import replace

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

from pipeclamp_fmu.build import build_clamp
from pipeclamp_fmu.contents.clamp import clamp_content
from pipeclamp_fmu.contents.clamp_of_law import clamp_model
from pipeclamp_fmu.python.packing import write_fmu

H = 1e-3


@pytest.fixture(params=["python", "native"])
def memory(request, fmus):
    """Give the path of a clamp with memory, of each kind."""
    return fmus["memory"] if request.param == "python" else request.getfixturevalue("native_fmus")[2]


@pytest.fixture
def model(memory, fmus, stand_in, law_with_memory):
    """Give the law of that clamp."""
    return stand_in if memory == fmus["memory"] else clamp_model(law_with_memory)


@pytest.mark.parametrize("name", ["memory", "emwm2"])
def test_fmpy_finds_nothing_to_object_to(fmus, name):
    assert validate_fmu(str(fmus[name])) == []


def test_the_description_says_what_importers_need(fmus):
    description = fmpy.read_model_description(str(fmus["memory"]))
    for variable in description.modelVariables:
        assert variable.description
        if variable.type == "Real" and not variable.name.startswith("law."):
            assert None not in (variable.unit, variable.min, variable.max, variable.nominal), variable.name
            assert variable.start is None or float(variable.min) < float(variable.start) < float(variable.max)
        assert variable.displayUnit == {"m": "mm", "m/s": "mm/s", "K": "degC"}.get(variable.unit), variable.name
    units = {unit.name: unit for unit in description.unitDefinitions}
    (celsius,) = units["K"].displayUnits
    assert (celsius.name, float(celsius.factor), float(celsius.offset)) == ("degC", 1.0, -273.15)
    assert all(unknown.dependencies == [] for unknown in description.outputs)
    ability = description.coSimulation
    assert not ability.needsExecutionTool
    assert ability.canGetAndSetFMUstate
    assert ability.canSerializeFMUstate


def law_forces(model, A, f, T, motion):
    """Give the forces of the law's own source along a motion from rest, (s, v) in m and m/s."""
    law = model.law
    k, state, y_before, forces = law.coefficients(A, f, T), tuple(start for _, start in law.states), 0.0, []
    for s, v in motion:
        force, _, state = law.step(k, state, y_before, 1000.0 * s, 1000.0 * v, H)
        y_before = 1000.0 * s
        forces.append(force)
    return forces


def test_the_force_is_that_of_the_law(drive, memory, model):
    clamp = drive(memory, {"A": 4e-4, "f": 2.0, "T": 350.0})
    theta = 2 * math.pi * 2.0 * H * np.arange(1, 1500)
    motion = list(zip((4e-4 * np.sin(theta)).tolist(), (4e-4 * 4 * math.pi * np.cos(theta)).tolist(), strict=True))
    forces = []
    for s, v in motion:
        clamp.step(H, flange__s=s, flange__v=v)
        forces.append(clamp.get("flange.f"))
    expected = law_forces(model, 1000.0 * 4e-4, 2.0, 350.0, motion)
    assert np.allclose(forces, expected, rtol=1e-12, atol=0)
    assert (clamp.get("A_used"), clamp.get("f_used"), clamp.get("T_used")) == pytest.approx((4e-4, 2.0, 350.0))


def test_fmpy_simulates_it_and_the_energy_is_the_loop_area(memory):
    f, A = 2.0, 5e-4
    time = np.arange(0, 3.0 + H / 2, H)
    signals = np.rec.fromarrays(
        [time, A * np.sin(2 * np.pi * f * time), A * 2 * np.pi * f * np.cos(2 * np.pi * f * time)],
        names=["time", "flange.s", "flange.v"],
    )
    result = fmpy.simulate_fmu(
        str(memory),
        stop_time=3.0,
        step_size=H,
        output_interval=H,
        input=signals,
        start_values={"A": A, "f": f},
        output=["flange.f", "energyDissipated", "inRange"],
    )
    cycle = slice(-501, None)
    force = result["flange.f"][cycle]
    s = np.interp(result["time"][cycle] - H, time, signals["flange.s"])  # fmpy sets the values at the step's start
    area = float(np.sum((force[1:] + force[:-1]) / 2 * np.diff(s)))
    assert area > 0
    assert np.ptp(result["energyDissipated"][cycle]) == pytest.approx(area, rel=1e-3)
    assert result["inRange"].all()


def test_at_the_start_the_force_is_that_of_the_inputs(drive, memory, model):
    clamp = drive(memory, {"flange.s": 3e-4, "flange.v": 0.01, "A": 3e-4})
    law = model.law
    y = 1000.0 * 3e-4
    k = law.coefficients(y, clamp.get("f_used"), clamp.get("T_used"))
    assert clamp.get("flange.f") == pytest.approx(law.step(k, (0.0,), y, y, 10.0, 0.0)[0], rel=1e-14)


@pytest.mark.parametrize("track", [False, True])
def test_a_state_comes_back_exactly_in_the_middle_of_an_iterated_step(drive, memory, shaken, track):
    untouched, iterated = drive(memory, {"track": track}), drive(memory, {"track": track})
    assert shaken(untouched, 0, 300) == shaken(iterated, 0, 300)
    state = iterated.save()
    for wild in (9e-4, -8e-4, 1e-4):  # trials that slip the memory
        iterated.step(H, flange__s=wild, flange__v=wild)
        iterated.restore(state)
    iterated.time = untouched.time
    assert shaken(untouched, 300, 500) == shaken(iterated, 300, 500)
    assert untouched.all() == iterated.all()


@pytest.mark.parametrize("track", [False, True])
def test_a_state_goes_into_another_instance_as_bytes(drive, memory, shaken, track):
    first, second = drive(memory, {"track": track, "T": 400.0}), drive(memory)
    shaken(first, 0, 300)
    shaken(second, 0, 77)
    second.deserialise(first.serialised())
    assert first.all() == second.all()
    assert shaken(first, 300, 500) == shaken(second, 300, 500)
    assert first.all() == second.all()


BAD = [
    ({"flange.s": math.nan}, H, ["flange.s is nan"]),
    ({"flange.v": math.inf}, H, ["flange.v is inf"]),
    ({"T_in": math.nan}, H, ["T_in is nan"]),
    ({"A": 0.0}, H, ["A is 0 m", "above 0"]),
    ({"A": math.nan}, H, ["A is nan"]),
    ({"f": -1.0}, H, ["f is -1 Hz", "above 0"]),
    ({"T": 0.0}, H, ["T is 0 K", "above 0"]),
    ({"T_in": -5.0, "useTemperatureInput": True}, H, ["T_in is -5 K", "above 0"]),
    ({}, 0.0, ["expected a finite step above 0 s"]),
    ({}, -H, ["expected a finite step above 0 s"]),
    ({}, math.nan, ["expected a finite step above 0 s"]),
    ({"flange.s": 1e300}, H, ["flange.s is 1e+300", "between -1e+27 and 1e+27"]),
]


@pytest.mark.parametrize(("bad", "h", "words"), BAD)
def test_what_cannot_be_is_discarded_and_leaves_the_state_untouched(drive, memory, shaken, bad, h, words):
    good = {"flange.s": 0.0, "flange.v": 0.0, "T_in": 350.0, "A": 4e-4, "f": 2.0, "T": 350.0}
    good |= {"useTemperatureInput": False}
    clamp, twin = drive(memory, good), drive(memory, good)
    assert shaken(clamp, 0, 200) == shaken(twin, 0, 200)
    clamp.set(bad)
    said = clamp.discarded(h)
    assert all(word in said for word in (*words, "discarded")), said
    assert clamp.all() == twin.all()
    clamp.set({name: good[name] for name in bad})
    assert shaken(clamp, 200, 400) == shaken(twin, 200, 400)
    assert clamp.all() == twin.all()


@pytest.mark.parametrize("start", [{"T": -5.0}, {"flange.s": math.nan}])
def test_fmpy_ends_a_run_at_an_impossible_value(memory, start):
    """And goes on for ever where a discarded step doesn't say that the run should end."""
    calls = []

    def step_finished(time, recorder):
        calls.append(time)
        return len(calls) < 100

    result = fmpy.simulate_fmu(
        str(memory), fmi_type="CoSimulation", stop_time=1.0, start_values=start, step_finished=step_finished,
    )  # fmt: skip
    assert calls == []
    assert result["time"][-1] == 0.0


def test_coefficients_are_fixed_parameters_alike_in_both_kinds(fmus, native_fmus, law_with_memory, tmp_path):
    build_clamp(law_with_memory, tmp_path / "clamp.fmu")
    described = [
        [
            (entry.name, entry.unit, entry.start, entry.variability, entry.causality, entry.description)
            for entry in fmpy.read_model_description(str(path)).modelVariables
            if entry.name.startswith("law.")
        ]
        for path in (tmp_path / "clamp.fmu", native_fmus[2])
    ]
    assert described[0] == described[1]
    assert {entry[3] for entry in described[0]} == {"fixed"}
    assert {entry[0].removeprefix("law.") for entry in described[0]} == {*law_with_memory.coefficients, "v_r", "y_r"}


def test_a_coefficient_can_be_set_until_initialization_ends(drive, memory):
    clamp, stiffer = drive(memory), drive(memory, {"law.k10": 2400.0})
    assert (clamp.get("law.k10"), stiffer.get("law.k10")) == (1200.0, 2400.0)
    forces = []
    for each in (clamp, stiffer):
        each.step(H, flange__s=1e-4)
        forces.append(each.get("flange.f"))
    assert forces[1] - forces[0] == pytest.approx(1200.0 * 0.6**-0.2 * 0.1)
    with pytest.raises(FMICallException):
        clamp.set({"law.k10": 2400.0})
    assert "law.k10 is fixed after initialization; the value is ignored" in clamp.messages.errors[-1]
    assert clamp.get("law.k10") == 1200.0
    stiffer.slave.reset()
    stiffer.start({})
    assert stiffer.get("law.k10") == 1200.0


def test_an_impossible_coefficient_discards_every_step_in_the_same_words(drive, memory):
    clamp = drive(memory, {"law.k10": math.nan})
    assert "start values: the law has no value at A = 0.6 mm, f = 3 Hz" in clamp.messages.errors[-1]
    assert "discarded: the law has no value at A = 0.6 mm, f = 3 Hz" in clamp.discarded(H, flange__s=1e-4)


@pytest.mark.parametrize(("name", "words"), [("flange.f", "no input"), ("law.k10", "fixed"), (None, "no input")])
def test_a_call_that_sets_what_may_not_be_set_fails_and_sets_nothing(drive, memory, shaken, name, words):
    """Whatever else it sets; and the FMU goes on, and is freed, as if it hadn't been called."""
    clamp, twin = drive(memory), drive(memory)
    assert shaken(clamp, 0, 20) == shaken(twin, 0, 20)
    told, *others = clamp.fmu.references(["A", "flange.s", *([name] if name else [])])
    with pytest.raises(FMICallException):
        clamp.slave.setReal([told, *others, *([] if name else [0])], [9e-4, 9e-4, 5.0])
    assert f"{name or 'value reference 0'} is {words}" in clamp.messages.errors[-1]
    (track,) = clamp.fmu.references(["track"])
    with pytest.raises(FMICallException):
        clamp.slave.setBoolean([track, *clamp.fmu.references(["inRange"])], [True, False])
    assert "inRange is no input" in clamp.messages.errors[-1]
    assert clamp.all() == twin.all()
    assert clamp.get("A") == twin.get("A")
    assert shaken(clamp, 20, 40) == shaken(twin, 20, 40)


OUTSIDE = [
    ({"A": 2e-3}, "A = 2 mm"),
    ({"f": 0.5}, "f = 0.5 Hz"),
    ({"T": 700.0}, "T = 700 K"),
    ({"flange.s": 1.5e-3}, "|flange.s| = 1.5 mm"),
]


@pytest.mark.parametrize(("outside", "word"), OUTSIDE)
def test_outside_its_range_it_warns_once(drive, memory, outside, word):
    clamp = drive(memory)
    clamp.step(H)
    assert clamp.get("inRange")
    before = {name: clamp.get(name) for name in outside}
    clamp.set(outside)
    for _ in range(3):
        clamp.step(H)
        assert not clamp.get("inRange")
    clamp.set(before)
    clamp.step(H)
    assert clamp.get("inRange")
    clamp.set(outside)
    clamp.step(H)
    (warning,) = clamp.messages.warnings
    assert word in warning
    assert "stand-in" in warning


def test_the_ends_of_the_range_are_inside(drive, memory):
    clamp = drive(memory, {"A": 1e-3, "f": 5.0, "T": 293.15})
    clamp.step(H, flange__s=-1e-3)
    assert clamp.get("inRange")
    assert clamp.messages.warnings == []


def test_the_temperature_comes_from_the_input_where_told(drive, memory):
    clamp = drive(memory, {"T": 400.0, "useTemperatureInput": True, "T_in": 300.0})
    assert clamp.get("T_used") == 300.0
    clamp.step(H, T_in=350.0)
    assert clamp.get("T_used") == 350.0
    clamp.set({"useTemperatureInput": False})
    clamp.step(H)
    assert clamp.get("T_used") == 400.0


@pytest.mark.parametrize("offset", [0.0, 2e-4])
@pytest.mark.parametrize(("A", "f"), [(3e-4, 1.3), (7e-4, 4.0)])
def test_tracking_finds_amplitude_and_frequency(drive, memory, A, f, offset):
    clamp = drive(memory, {"track": True, "A": 6e-4, "f": 3.0})
    seen = []
    for n in range(1, round(12 / f / H)):
        theta = 2 * math.pi * f * n * H
        clamp.step(H, flange__s=offset + A * math.sin(theta), flange__v=A * 2 * math.pi * f * math.cos(theta))
        seen.append((clamp.get("A_used"), clamp.get("f_used")))
    last = np.array(seen[-round(1 / f / H) :])
    assert np.abs(last / [A, f] - 1).max() < 0.01
    assert clamp.get("inRange")


def test_a_followed_sine_at_the_end_of_the_range_is_inside(drive, memory):
    """A and f go to and fro by the averages' ripple: tests at one frequency made a range that no such motion was in."""
    clamp = drive(memory, {"track": True, "A": 5e-4, "f": 5.0})
    for n in range(1, 1500):
        theta = 2 * math.pi * 5.0 * n * H
        clamp.step(H, flange__s=5e-4 * math.sin(theta), flange__v=5e-4 * 2 * math.pi * 5.0 * math.cos(theta))
        assert clamp.get("inRange")
    assert clamp.messages.warnings == []


def test_tracking_is_held_inside_the_range(drive, memory):
    clamp = drive(memory, {"track": True})
    for n in range(1, 1500):
        theta = 2 * math.pi * 8.0 * n * H
        clamp.step(H, flange__s=5e-4 * math.sin(theta), flange__v=5e-4 * 2 * math.pi * 8.0 * math.cos(theta))
    assert clamp.get("f_used") == 5.0
    assert not clamp.get("inRange")
    assert len(clamp.messages.warnings) == 1


def test_tracking_of_no_motion_keeps_the_frequency(drive, memory):
    clamp = drive(memory, {"track": True, "f": 2.0})
    for _ in range(20000):
        clamp.step(H)
    assert clamp.get("A_used") == pytest.approx(2e-4)
    assert 1.0 <= clamp.get("f_used") <= 5.0
    assert clamp.get("flange.f") == 0.0


def test_a_changed_parameter_dissipates_nothing(drive, memory, shaken):
    clamp = drive(memory)
    shaken(clamp, 0, 333)
    energy = clamp.get("energyDissipated")
    clamp.set({"A": 9e-4, "flange.v": 0.0})
    clamp.step(H)
    assert clamp.get("A_used") == pytest.approx(9e-4)
    assert clamp.get("energyDissipated") == energy


def test_reset_gives_a_fresh_instance(drive, memory, shaken):
    clamp, fresh = drive(memory, {"T": 500.0, "track": True}), drive(memory)
    shaken(clamp, 0, 100)
    clamp.slave.reset()
    clamp.start({})
    assert clamp.all() == fresh.all()
    assert shaken(clamp, 0, 200) == shaken(fresh, 0, 200)


def test_two_laws_and_a_rebuilt_one_each_give_their_own_force(drive, shaken, stand_in, tmp_path):
    """All Python FMUs of a process share one table of modules."""
    path = tmp_path / "clamp.fmu"
    write_fmu(clamp_content(stand_in, "0"), path)
    before = drive(path)
    softer = replace(
        stand_in, coefficients=(replace(stand_in.coefficients[0], value=600.0), *stand_in.coefficients[1:])
    )
    write_fmu(clamp_content(softer, "0"), path)
    rebuilt, other = drive(path), drive("emwm2")
    forces = [shaken(clamp, 0, 50)[-1] for clamp in (before, rebuilt, other, drive("stiffer"), drive("memory"))]
    s = 1000.0 * clamp_displacement(before)
    stiffness = s * 0.6**-0.2
    assert forces[0] == forces[4]
    assert forces[0] - forces[1] == pytest.approx(600.0 * stiffness)
    assert forces[3] - forces[0] == pytest.approx(1200.0 * stiffness)
    assert len(set(forces)) == 4


def clamp_displacement(clamp):
    """Give flange.s as it was set, m."""
    return clamp.slave.getReal(clamp.fmu.references(["flange.s"]))[0]


@pytest.mark.parametrize("foreign", ["stiffer", "pipe", "bytes"])
def test_a_foreign_state_is_refused(drive, shaken, foreign):
    """By discarded steps: an exception would make pythonfmu free the instance twice."""
    clamp, twin = drive("memory"), drive("memory")
    assert shaken(clamp, 0, 50) == shaken(twin, 0, 50)
    state = clamp.save()
    clamp.deserialise(b"no state" if foreign == "bytes" else drive(foreign).serialised())
    assert "is not one of clamp_" in clamp.messages.errors[-1]
    assert clamp.all() == twin.all()
    assert "is not one of clamp_" in clamp.discarded(H)
    clamp.restore(state)
    assert shaken(clamp, 50, 100) == shaken(twin, 50, 100)


def test_wrong_value_references_fail_and_do_no_harm(drive, memory):
    clamp = drive(memory)
    last = clamp.fmu.variables["inRange"].reference
    for _ in range(50):
        for call, *arguments in (
            (clamp.slave.getReal, [1, last]),
            (clamp.slave.getReal, [0]),
            (clamp.slave.getReal, [2**32 - 1]),
            (clamp.slave.getBoolean, [0]),
            (clamp.slave.setReal, [99], [1.0]),
            (clamp.slave.setReal, [0], [1.0]),
        ):
            with pytest.raises(FMICallException):
                call(*arguments)
        clamp.step(H)
        assert clamp.get("inRange")
    clamp.slave.reset()
    clamp.start({})
    clamp.step(H)


@pytest.mark.parametrize("fmi", [2, 3])
def test_names_and_numbers_are_such_as_every_importer_takes(fmus, native_fmus, native_pipes, fmi):
    """Names that are identifiers, value references from 1 in the order of the variables, no output but of type Real."""
    paths = (fmus["memory"], fmus["pipe"], native_fmus[2], native_pipes["pipe"]) if fmi == 2 else (native_fmus[3],)
    for path in paths:
        description = fmpy.read_model_description(str(path))
        variables = description.modelVariables
        assert description.modelName.isidentifier()
        assert description.description.startswith(("Pipe clamp, law stand-in: ", "Pipe bench: "))
        assert [variable.valueReference for variable in variables] == list(range(1, len(variables) + 1))
        assert {entry.type for entry in variables if entry.causality == "output"} == {"Real" if fmi == 2 else "Float64"}
        assert {entry.name for entry in variables if entry.type == "Boolean" and entry.causality == "local"} <= {
            "inRange"
        }
        if fmi == 3:
            assert (variables[-1].name, variables[-1].causality) == ("time", "independent")
