"""The native pipe FMU: in model exchange its states' derivatives and its outputs are those of the modal equations."""

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import fmi2Real
from fmpy.fmi3 import fmi3Float64
from native_driver import NativeDriver
from scipy.signal import lsim
from test_pipe_fmu import PIPES, modal_system

from pipeclamp_fmu.build import build_native_excitation, build_native_pipe
from pipeclamp_fmu.contents.excitation import Samples
from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_models.pipe.modes import reduce

ARRAYS = {2: lambda *values: (fmi2Real * len(values))(*values), 3: lambda *values: (fmi3Float64 * len(values))(*values)}
CLAMPED = [f"clamp{index}.{kind}" for kind in "sv" for index in (1, 2)]


def excitation_of(name):
    return "excitation.f" if name == "forced_pipe" else "base.a"


@pytest.mark.parametrize("name", PIPES)
def test_derivatives_and_outputs_are_those_of_the_modal_equations(native_pipes, pipe_text, tmp_path, name):
    system = modal_system(reduce(parse_pipe(pipe_text(name))))
    count = system.A.shape[0]
    pipe = NativeDriver(native_pipes[name], tmp_path / "pipe", "ModelExchange", {})
    rng = np.random.default_rng(0)
    modal, loads = rng.normal(size=count) * 1e-3, rng.normal(size=3) * 10.0
    works = [0.3, 0.1]
    states, derivatives = (fmi2Real * (count + 2))(*modal, *works), (fmi2Real * (count + 2))()
    pipe.fmu.setTime(0.1)
    pipe.fmu.setContinuousStates(states, count + 2)
    pipe.set(dict(zip((excitation_of(name), "clamp1.f", "clamp2.f"), loads.tolist(), strict=True)))
    pipe.fmu.getDerivatives(derivatives, count + 2)
    rates = system.A @ modal + system.B @ loads
    np.testing.assert_allclose(derivatives[:count], rates, rtol=1e-12, atol=1e-12 * np.abs(rates).max())
    np.testing.assert_allclose(pipe.get(*CLAMPED), system.C @ modal, rtol=1e-12)
    power = pipe.get("clamp1.v")[0] * loads[1] + pipe.get("clamp2.v")[0] * loads[2]
    assert derivatives[count + 1] == pytest.approx(power, rel=1e-12)
    excited, on_clamps, stored, lost = pipe.get("workExcitation", "workClamps", "energyPipe", "energyDissipated")
    assert (excited, on_clamps) == tuple(works)
    assert excited - on_clamps == pytest.approx(stored + lost)
    names = [f"mode.{kind}[{n}]" for kind in "qp" for n in range(1, count // 2 + 1)]
    assert pipe.get(*names) == modal.tolist()
    assert pipe.get(*[f"der({entry})" for entry in names]) == derivatives[:count]
    pipe.free()


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("name", ["pipe", "loaded_pipe"])
def test_fmpy_integrates_it(pipe_text, tmp_path, name, fmi):
    reduced = reduce(parse_pipe(pipe_text(name)))
    build_native_pipe(reduced, tmp_path / "pipe.fmu", fmi)
    time = np.linspace(0.0, 0.3, 3001)
    loads = np.column_stack([3 * np.sin(40 * time), 20 * np.sin(33 * time), 0 * time])
    signals = np.rec.fromarrays([time, *loads.T], names=["time", "base.a", "clamp1.f", "clamp2.f"])
    result = fmpy.simulate_fmu(
        str(tmp_path / "pipe.fmu"), fmi_type="ModelExchange", stop_time=0.3, output_interval=1e-4, input=signals,
        output=CLAMPED, relative_tolerance=1e-8,
    )  # fmt: skip
    _, expected, _ = lsim(modal_system(reduced), loads, time, interp=False)  # fmpy holds inputs, without a new start
    for index, column in enumerate(CLAMPED):
        theirs = np.interp(result["time"], time, expected[:, index])
        assert np.abs(result[column] - theirs).max() < 1e-3 * np.abs(theirs).max()


ENERGIES = ["energyPipe", "energyDissipated", "workExcitation", "workClamps"]
OUTPUTS = [*CLAMPED, "middle.s", "middle.v", "middle.a", *ENERGIES]


@pytest.fixture(params=PIPES)
def each(request, pipe_text, tmp_path):
    """Give a function that makes one of the pipes in a version of FMI and an interface, and its reduced pipe."""
    reduced = reduce(parse_pipe(pipe_text(request.param)))
    made = []

    def make(fmi, kind, **start):
        build_native_pipe(reduced, tmp_path / "pipe.fmu", fmi)
        made.append(NativeDriver(tmp_path / "pipe.fmu", tmp_path / str(len(made)), kind, start))
        return made[-1]

    yield make, reduced, [excitation_of(request.param), "clamp1.f", "clamp2.f"]
    for pipe in made:
        pipe.free()


def adjoint(pipe, unknowns, knowns):
    """Give the derivatives, a row for each unknown, one adjoint derivative for each."""
    rows, columns = ([pipe.references[name] for name in names] for names in (unknowns, knowns))
    return [pipe.fmu.getAdjointDerivative([row], columns, [1.0], nSensitivity=len(columns)) for row in rows]


@pytest.mark.parametrize("fmi", [2, 3])
def test_derivatives_in_model_exchange_are_the_matrices(each, fmi):
    """By states and inputs, of their derivatives and of outputs; energies, which are quadratic, against differences."""
    make, reduced, loads = each
    pipe, system = make(fmi, "ModelExchange"), modal_system(reduced)
    count = system.A.shape[0]
    states = [f"mode.{kind}[{n}]" for kind in "qp" for n in range(1, count // 2 + 1)]
    works = ["work.excitation", "work.clamps"]
    rates = [f"der({name})" for name in (*states, *works)]
    rng = np.random.default_rng(1)
    at = rng.normal(size=count + 2 + 3) * [*[1e-3] * (count // 2), *[0.1] * (count // 2), 0.3, 0.1, *[10.0] * 3]

    def values(place, names):
        pipe.fmu.setContinuousStates(ARRAYS[fmi](*place[: count + 2]), count + 2)
        pipe.set(dict(zip(loads, place[count + 2 :].tolist(), strict=True)))
        return np.array(pipe.get(*names))

    values(at, rates)
    exact = np.array(pipe.jacobian([*rates, *OUTPUTS], [*states, *works, *loads]))
    if fmi == 3:
        transposed = adjoint(pipe, [*rates, *OUTPUTS], [*states, *works, *loads])
        np.testing.assert_allclose(transposed, exact, rtol=1e-12, atol=1e-300)
    matrices = np.hstack([system.A, np.zeros((count, 2)), system.B])
    np.testing.assert_allclose(exact[:count], matrices, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(exact[count + 2 : count + 6, :count], system.C, rtol=1e-12, atol=1e-15)
    for column, size in enumerate(at):
        aside = 1e-4 * abs(size) * np.eye(len(at))[column]
        ahead, behind = (values(at + sign * aside, [*rates, *OUTPUTS]) for sign in (1, -1))
        numeric = (ahead - behind) / (2 * aside[column])  # exact but for rounding: nothing is of a higher degree than 2
        rounding = 1e-11 * np.maximum(np.abs(ahead), np.abs(behind)) / aside[column]
        assert (np.abs(exact[:, column] - numeric) <= 1e-9 * np.abs(numeric) + rounding).all()


@pytest.mark.parametrize("at_end", [False, True])
@pytest.mark.parametrize("fmi", [2, 3])
def test_derivatives_in_co_simulation_are_those_of_the_step(each, fmi, at_end):
    """Against differences of the step's outcome, made by going back to before it."""
    make, _, loads = each
    pipe = make(fmi, "CoSimulation", inputsAtStepEnd=at_end)
    rng = np.random.default_rng(2)
    h = 2e-3
    for _ in range(20):
        pipe.set(dict(zip(loads, rng.normal(size=3) * [5.0, 20.0, 20.0], strict=True)))
        pipe.fmu.doStep(pipe.time, h)
    before = pipe.fmu.getFMUstate() if fmi == 2 else pipe.fmu.getFMUState()
    at = np.array([3.0, -10.0, 15.0])

    def outcome(place, step=h):
        (pipe.fmu.setFMUstate if fmi == 2 else pipe.fmu.setFMUState)(before)
        pipe.set(dict(zip(loads, place.tolist(), strict=True)))
        pipe.fmu.doStep(pipe.time, step)
        return np.array(pipe.get(*OUTPUTS))

    outcome(at)
    after = pipe.fmu.getFMUstate() if fmi == 2 else pipe.fmu.getFMUState()
    exact = np.array(pipe.jacobian(OUTPUTS, loads))
    if fmi == 3:
        np.testing.assert_allclose(adjoint(pipe, OUTPUTS, loads), exact, rtol=1e-12, atol=1e-300)
    outcome(at, 3 * h)  # a step of another length in between changes nothing
    (pipe.fmu.setFMUstate if fmi == 2 else pipe.fmu.setFMUState)(after)
    np.testing.assert_array_equal(pipe.jacobian(OUTPUTS, loads), exact)
    for column in range(3):
        aside = np.eye(3)[column]
        ahead, behind = outcome(at + aside), outcome(at - aside)
        numeric = (ahead - behind) / 2
        rounding = 1e-12 * np.maximum(np.abs(ahead), np.abs(behind))
        assert (np.abs(exact[:, column] - numeric) <= 1e-9 * np.abs(numeric) + rounding).all()
    assert np.abs(exact).max() > 0


def test_states_have_no_derivatives_in_co_simulation(each):
    make, *_ = each
    pipe = make(2, "CoSimulation")
    for unknown, known in (("der(mode.q[1])", "base.a"), ("clamp1.s", "mode.q[1]")):
        with pytest.raises(FMICallException):
            pipe.jacobian([unknown], [known if known in pipe.references else "excitation.f"])


@pytest.mark.parametrize("fmi", [2, 3])
def test_an_excitation_which_depends_on_time_alone_answers_with_no_slope(tmp_path, fmi):
    build_native_excitation(Samples(0.1, [0.0, 2.0, 1.0], "m/s2"), tmp_path / "excitation.fmu", fmi)
    excitation = NativeDriver(tmp_path / "excitation.fmu", tmp_path / "unpacked", "CoSimulation", {})
    excitation.fmu.doStep(0.0, 0.05)
    assert excitation.get("signal") == [1.0]
    assert list(excitation.fmu.getDirectionalDerivative([excitation.references["signal"]], [], [])) == [0.0]
    excitation.free()
