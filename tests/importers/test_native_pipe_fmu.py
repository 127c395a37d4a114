"""The native pipe FMU in model exchange: states, their derivatives and outputs are those of the modal equations."""

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import fmi2Real
from native_driver import NativeDriver
from scipy.signal import lsim
from test_pipe_fmu import PIPES, modal_system

from pipeclamp.pipe import reduce
from pipeclamp.pipe_description import parse_pipe
from pipeclamp_fmu.build import build_native_pipe

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
