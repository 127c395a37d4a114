"""The pipe FMU in fmpy, of Python and native: its motion against scipy, its energies, its states, its guards."""

import math

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from scipy.signal import StateSpace, lsim

from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_models.pipe.modes import reduce

H = 2e-3
STEPS = 400
PIPES = ["pipe", "forced_pipe", "loaded_pipe"]


@pytest.fixture(params=["python", "native"])
def paths(request, fmus):
    """Give the pipes' FMUs by name, of each kind."""
    return fmus if request.param == "python" else request.getfixturevalue("native_pipes")


@pytest.fixture
def drive(drive, paths):
    """Give the function that makes an instance of one of the pipes, of each kind."""
    return lambda name, start=None: drive(paths[name], start)


@pytest.mark.parametrize("name", PIPES)
def test_fmpy_finds_nothing_to_object_to(paths, name):
    assert validate_fmu(str(paths[name])) == []


def modal_system(pipe):
    """Give the reduced pipe as a state space: inputs excitation and clamps' forces; outputs s and v at the clamps."""
    n = len(pipe.omega)
    load = np.column_stack([pipe.excitation_participation, *(-np.array(shape) for shape in pipe.clamp_shapes)])
    a = np.block([[np.zeros((n, n)), np.eye(n)], [-pipe.stiffness_matrix, -pipe.damping_matrix]])
    b = np.vstack([np.zeros_like(load), load])
    shapes = np.array(pipe.clamp_shapes)
    none = np.zeros_like(shapes)
    c = np.block([[shapes, none], [none, shapes]])
    return StateSpace(a, b, c, np.zeros((c.shape[0], b.shape[1])))


@pytest.fixture(scope="module")
def loads():
    """Inputs that change at every communication point, (STEPS + 1, 3)."""
    rng = np.random.default_rng(1)
    return rng.normal(size=(STEPS + 1, 3)) * [5.0, 20.0, 20.0]


@pytest.mark.parametrize("at_end", [False, True])
@pytest.mark.parametrize("name", PIPES)
def test_steps_are_exact(drive, pipe_text, loads, name, at_end):
    excitation = "excitation__f" if name == "forced_pipe" else "base__a"
    pipe = drive(name, {
        "inputsAtStepEnd": at_end, excitation.replace("__", "."): loads[0, 0],
        "clamp1.f": loads[0, 1], "clamp2.f": loads[0, 2],
    })  # fmt: skip
    motion = []
    for n in range(STEPS):
        u, f1, f2 = loads[n + 1 if at_end else n].tolist()
        pipe.step(H, clamp1__f=f1, clamp2__f=f2, **{excitation: u})
        motion.append([pipe.get(f"clamp{i}.{kind}") for kind in "sv" for i in (1, 2)])
    system = modal_system(reduce(parse_pipe(pipe_text(name))))
    _, expected, _ = lsim(system, loads, H * np.arange(STEPS + 1), interp=at_end)
    error = np.abs(np.array(motion) - expected[1:]).max(axis=0) / np.abs(expected).max(axis=0)
    assert error.max() < 1e-9


@pytest.mark.parametrize("name", PIPES)
def test_energies_balance_and_damping_takes_its_share(drive, name):
    excitation = "excitation__f" if name == "forced_pipe" else "base__a"
    h = H / 20
    pipe = drive(name, {"inputsAtStepEnd": True})
    clamps_work = s_before = f_before = 0.0
    dissipated = []
    for n in range(3000):
        u, f = 5.0 * math.sin(2 * math.pi * 10 * n * h), 40.0 * math.sin(2 * math.pi * 23 * n * h)
        pipe.step(h, clamp1__f=f, **{excitation: u})
        s = pipe.get("clamp1.s")
        clamps_work += (f + f_before) / 2 * (s - s_before)
        s_before, f_before = s, f
        dissipated.append(pipe.get("energyDissipated"))
    assert pipe.get("workClamps") == pytest.approx(clamps_work, rel=1e-3)
    work, stored = pipe.get("workExcitation"), pipe.get("energyPipe")
    assert work == pytest.approx(pipe.get("workClamps") + stored + dissipated[-1], rel=1e-12)
    assert np.diff(dissipated).min() > -1e-12 * work, "damping only takes"
    assert stored > 0


@pytest.mark.parametrize("name", PIPES)
def test_a_probe_gives_the_absolute_acceleration(drive, name):
    excitation = "excitation__f" if name == "forced_pipe" else "base__a"
    h = H / 20
    pipe = drive(name, {"inputsAtStepEnd": True})
    base, v, a = [], [], []
    for n in range(3000):
        u = 5.0 * math.sin(2 * math.pi * 10 * n * h)
        pipe.step(h, **{excitation: u})
        base.append(0.0 if name == "forced_pipe" else u)
        v.append(pipe.get("middle.v"))
        a.append(pipe.get("middle.a"))
    expected = (np.array(v[2:]) - np.array(v[:-2])) / (2 * h) + base[1:-1]
    assert np.abs(expected - a[1:-1]).max() < 1e-2 * np.abs(expected).max()


@pytest.mark.parametrize("name", ["pipe", "loaded_pipe"])
def test_damping_takes_what_the_modes_lose(drive, pipe_text, name):
    """Independent of the balance: the integral of q' C q' as scipy has it; between held ends the flow takes nothing."""
    reduced = reduce(parse_pipe(pipe_text(name)))
    pipe = drive(name, {"inputsAtStepEnd": True})
    h = 2e-4
    time = h * np.arange(5001)
    u = 5.0 * np.sin(2 * np.pi * 10 * time)
    _, _, states = lsim(modal_system(reduced), np.column_stack([u, 0 * u, 0 * u]), time)
    speed = states[:, len(reduced.omega) :]
    power = np.einsum("ti,ij,tj->t", speed, reduced.damping_matrix, speed)
    for load in u[1:].tolist():
        pipe.step(h, base__a=load)
    assert pipe.get("energyDissipated") == pytest.approx(np.sum((power[1:] + power[:-1]) / 2) * h, rel=1e-4)


def shaken(pipe, begin, end):
    """Step the pipe along loads of its own and give what a clamp sees."""
    motion = []
    for n in range(begin, end):
        pipe.step(H, base__a=math.sin(0.11 * n), clamp1__f=9 * math.sin(0.3 * n), clamp2__f=5 * math.cos(0.2 * n))
        motion.append((pipe.get("clamp1.s"), pipe.get("clamp2.v")))
    return motion


@pytest.mark.parametrize("at_end", [False, True])
@pytest.mark.parametrize("name", ["pipe", "loaded_pipe"])
def test_a_state_comes_back_exactly_in_the_middle_of_an_iterated_step(drive, name, at_end):
    untouched, iterated = drive(name, {"inputsAtStepEnd": at_end}), drive(name, {"inputsAtStepEnd": at_end})
    assert shaken(untouched, 0, 50) == shaken(iterated, 0, 50)
    state = iterated.save()
    for wild in (1e3, -1e5):
        iterated.step(H / 3, clamp1__f=wild)
        iterated.restore(state)
    iterated.time = untouched.time
    assert shaken(untouched, 50, 100) == shaken(iterated, 50, 100)
    assert untouched.all() == iterated.all()


def test_a_state_goes_into_another_instance_as_bytes(drive):
    first, second = drive("pipe", {"inputsAtStepEnd": True}), drive("pipe")
    shaken(first, 0, 50)
    second.deserialise(first.serialised())
    assert first.all() == second.all()
    assert shaken(first, 50, 100) == shaken(second, 50, 100)
    assert first.all() == second.all()


@pytest.mark.parametrize(
    ("bad", "h", "word"),
    [
        ({"base.a": math.nan}, H, "base.a is nan"),
        ({"clamp2.f": -math.inf}, H, "clamp2.f is -inf"),
        ({"clamp1.f": 1e308}, H, "finite"),
        ({}, 0.0, "above 0 s"),
        ({}, -H, "above 0 s"),
        ({}, math.inf, "above 0 s"),
    ],
)
def test_what_cannot_be_is_discarded_and_leaves_the_state_untouched(drive, bad, h, word):
    pipe, twin = drive("pipe"), drive("pipe")
    assert shaken(pipe, 0, 50) == shaken(twin, 0, 50)
    pipe.set(bad)
    assert word in pipe.discarded(h)
    assert pipe.all() == twin.all()
    assert shaken(pipe, 50, 100) == shaken(twin, 50, 100)


def test_fmpy_ends_a_run_at_an_impossible_value(paths):
    """And goes on for ever where a discarded step doesn't say that the run should end."""
    calls = []

    def step_finished(time, recorder):
        calls.append(time)
        return len(calls) < 100

    result = fmpy.simulate_fmu(
        str(paths["pipe"]), fmi_type="CoSimulation", stop_time=1.0, start_values={"base.a": math.nan},
        step_finished=step_finished,
    )  # fmt: skip
    assert calls == []
    assert result["time"][-1] == 0.0


def test_reset_gives_a_fresh_instance(drive):
    pipe, fresh = drive("pipe", {"inputsAtStepEnd": True}), drive("pipe")
    shaken(pipe, 0, 50)
    pipe.slave.reset()
    pipe.start({})
    assert pipe.all() == fresh.all()
    assert shaken(pipe, 0, 50) == shaken(fresh, 0, 50)
