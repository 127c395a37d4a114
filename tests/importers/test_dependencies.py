"""What descriptions say that outputs and derivatives depend on, against what changes when one variable does."""

from itertools import product

import fmpy
import numpy as np
import pytest
from native_driver import NativeDriver
from test_pipe_fmu import PIPES

from pipeclamp_fmu.build import build_clamp, build_native_clamp, build_native_excitation
from pipeclamp_fmu.contents.clamp_model import ClampStart
from pipeclamp_fmu.contents.excitation import Samples

STEP = {"flange.s": 1e-4, "flange.v": -0.01, "T_in": 20.0, "A": 1e-4, "f": 0.5, "T": 15.0}


def declared(unknowns):
    return {unknown.variable.name: {known.name for known in unknown.dependencies} for unknown in unknowns}


def changing(values, known):
    """Give which unknowns change when one of the known ones does, as a set for each unknown.

    Args:
        values: gives the unknowns' values, by name, where a variable has changed, None for no variable.
        known: names of variables.
    """
    here = values(None)
    found = {name: set() for name in here}
    for changed in known:
        for name, value in values(changed).items():
            if value != here[name]:
                found[name].add(changed)
    return found


@pytest.mark.parametrize("name", PIPES)
def test_a_pipe_in_model_exchange_depends_on_what_its_matrices_hold(native_pipes, tmp_path, name):
    pipe = NativeDriver(native_pipes[name], tmp_path, "ModelExchange", {})
    inputs = [entry.name for entry in pipe.description.modelVariables if entry.causality == "input"]
    states = [entry.name for entry in pipe.description.modelVariables if f"der({entry.name})" in pipe.references]
    said = declared(pipe.description.outputs) | declared(pipe.description.derivatives)
    at = dict(zip((*inputs, *states), np.random.default_rng(3).normal(size=len(inputs) + len(states)), strict=True))
    assert len(states) > 10

    def values(changed):
        pipe.set(at | ({changed: at[changed] + 0.5} if changed else {}))
        return dict(zip(said, pipe.get(*said), strict=True))

    found = changing(values, [*inputs, *states])
    if name == "loaded_pipe":  # whose matrices are full, with couplings of no more than rounding
        assert all(found[unknown] <= said[unknown] for unknown in said)
    else:
        assert found == said
    loops = [unknown for unknown in said if said[unknown] & set(inputs) and not unknown.startswith("der(")]
    assert loops == ["middle.a"]
    pipe.free()


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_clamp_in_model_exchange_depends_on_its_motion(law_with_memory, tmp_path, fmi):
    build_native_clamp(law_with_memory, tmp_path / "clamp.fmu", fmi, start=ClampStart(connected_temperature=True))
    found = {}
    for track in (False, True):
        clamp = NativeDriver(tmp_path / "clamp.fmu", tmp_path / str(track), "ModelExchange", {"track": track})
        said = declared(clamp.description.outputs)
        for n in range(1, 300):
            clamp.step(1e-3, 5e-4 * np.sin(0.02 * n), 0.01 * np.cos(0.02 * n))
        at = {"flange.s": -2e-4, "flange.v": 0.02, "T_in": 400.0}

        def values(changed, clamp=clamp, said=said, at=at):
            clamp.fmu.setTime(clamp.time + (2e-3 if changed == "time" else 1e-3))
            clamp.set(at | ({changed: at[changed] + STEP[changed]} if changed in at else {}))
            return dict(zip(said, clamp.get(*said), strict=True))

        for name, known in changing(values, [*at, *(["time"] if fmi == 3 else [])]).items():
            found.setdefault(name, set()).update(known)
        clamp.free()
    assert found.pop("forceDeviation") <= said.pop("forceDeviation")
    assert found == said
    assert said["T_used"] == {"T_in"}


@pytest.mark.parametrize("kind", ["python", "native"])
def test_a_clamp_starts_with_what_it_is_told(drive, law_with_memory, tmp_path, kind):
    path = tmp_path / "clamp.fmu"
    {"python": build_clamp, "native": build_native_clamp}[kind](law_with_memory, path)
    description = fmpy.read_model_description(str(path))
    said = declared(description.initialUnknowns)
    settable = [entry.name for entry in description.modelVariables if entry.start is not None]
    assert "law.k10" in settable
    found = {name: set() for name in said}
    # Beyond the law's range, in which tracking holds A and f.
    at = {"flange.s": 3e-4, "flange.v": 0.02, "A": 2e-3, "f": 9.0, "T": 400.0, "T_in": 350.0}
    at |= {f"law.{name}": entry.value for name, entry in law_with_memory.coefficients.items()}
    at |= {"law.v_r": 0.0126, "law.y_r": 0.002}
    clamp = drive(path)
    for track, use in product((False, True), (False, True)):

        def values(changed, track=track, use=use):
            clamp.slave.reset()
            start = at | {"track": track, "useTemperatureInput": use}
            if isinstance(start.get(changed), bool):
                start[changed] = not start[changed]
            elif changed:
                start[changed] += STEP.get(changed, 0.1 * at[changed] + 0.01)
            clamp.start(start)
            return {name: clamp.get(name) for name in said}

        for name, known in changing(values, settable).items():
            found[name].update(known)
    assert found["flange.f"] <= said["flange.f"]
    assert {"A", "T", "T_in", "track", "law.k10", "law.c0", "flange.s"} <= found["flange.f"]
    assert {name: known for name, known in found.items() if name != "flange.f"} == {
        name: known for name, known in said.items() if name != "flange.f"
    }


@pytest.mark.parametrize("kind", ["python", "native"])
def test_a_pipe_starts_at_rest(fmus, native_pipes, reduced_pipe, kind):
    path = fmus["pipe"] if kind == "python" else native_pipes["pipe"]
    said = declared(fmpy.read_model_description(str(path)).initialUnknowns)
    assert said["middle.a"] == {"base.a", "clamp1.f", "clamp2.f"}
    loads = zip(reduced_pipe.excitation_participation, *reduced_pipe.clamp_shapes, strict=True)
    loaded = {f"der(mode.p[{number}])" for number, load in enumerate(loads, 1) if any(load)}
    modes = {name for name in said if name.startswith("der(mode.p")}
    assert loaded & modes <= {name for name in said if said[name]} - {"middle.a"} <= modes


def test_an_excitation_depends_on_the_time_alone(tmp_path):
    build_native_excitation(Samples(0.1, [0.0, 2.0, 1.0], "m/s2"), tmp_path / "excitation.fmu", 3)
    assert declared(fmpy.read_model_description(str(tmp_path / "excitation.fmu")).outputs) == {"signal": {"time"}}
