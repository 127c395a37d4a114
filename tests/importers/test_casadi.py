"""CasADi imports the native clamp and pipe for model exchange: residuals, outputs and their Jacobian are ours."""

import fmpy
import numpy as np
import pytest
from native_driver import NativeDriver
from test_pipe_fmu import PIPES, modal_system

from pipeclamp_fmu.build import build_native_clamp
from pipeclamp_fmu.contents.clamp_model import ClampStart
from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_models.pipe.modes import reduce

casadi = pytest.importorskip("casadi", reason="CasADi isn't installed: pip install casadi")

INPUTS = ("flange.s", "flange.v", "T_in")
OUTPUTS = ("flange.f", "A_used", "f_used", "T_used", "energyDissipated", "forceDeviation")
MOTION = (1e-4, 0.02, 400.0)


def test_outputs_and_jacobian_are_ours(law_with_memory, native_fmus, tmp_path):
    fmu = tmp_path / "clamp.fmu"
    build_native_clamp(law_with_memory, fmu, start=ClampStart(connected_temperature=True))
    fmpy.extract(str(fmu), unzipdir=str(tmp_path / "casadi"))
    builder = casadi.DaeBuilder("clamp", str(tmp_path / "casadi"))
    imported = builder.create("imported", ["u"], ["y"])
    theirs = np.array(imported(MOTION)).ravel()
    their_jacobian = np.array(imported.jacobian()(MOTION, theirs))

    own = NativeDriver(fmu, tmp_path / "own", "ModelExchange", {})
    own.place(0.0, *MOTION[:2])
    own.set({"T_in": MOTION[2]})
    np.testing.assert_allclose(theirs, own.get(*OUTPUTS), rtol=1e-12)
    np.testing.assert_allclose(their_jacobian, own.jacobian(OUTPUTS, INPUTS), rtol=1e-9, atol=1e-9)
    assert their_jacobian[0, 0] > 0
    own.free()


@pytest.mark.parametrize("name", PIPES)
def test_the_pipes_residual_and_jacobian_are_those_of_its_matrices(native_pipes, pipe_text, tmp_path, name):
    system = modal_system(reduce(parse_pipe(pipe_text(name))))
    count = system.A.shape[0]
    fmpy.extract(str(native_pipes[name]), unzipdir=str(tmp_path))
    builder = casadi.DaeBuilder("pipe", str(tmp_path))
    clamped = [f"clamp{index}.{kind}" for kind in "sv" for index in (1, 2)]
    builder.set_y(clamped)
    imported = builder.create("imported", ["x", "u"], ["ode", "y"])
    rng = np.random.default_rng(0)
    x, u = rng.normal(size=count + 2) * 1e-3, rng.normal(size=3) * 10.0
    ode, y = (np.array(part).ravel() for part in imported(x, u))
    rates = system.A @ x[:count] + system.B @ u
    np.testing.assert_allclose(ode[:count], rates, rtol=1e-12, atol=1e-12 * np.abs(rates).max())
    np.testing.assert_allclose(y, system.C @ x[:count], rtol=1e-12)
    by_x, by_u, outputs_by_x, outputs_by_u = map(np.array, imported.jacobian()(x, u, ode, y))
    np.testing.assert_allclose(by_x[:count, :count], system.A, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(by_u[:count], system.B, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(outputs_by_x[:, :count], system.C, rtol=1e-9, atol=1e-12)
    assert not outputs_by_u.any()
    shapes = system.C[:2, : count // 2]
    np.testing.assert_allclose(by_u[count + 1], [0.0, *(shapes @ x[count // 2 : count])], rtol=1e-9)
