"""CasADi imports the native clamp for model exchange: outputs and their Jacobian are ours."""

import fmpy
import numpy as np
import pytest
from native_driver import NativeDriver

casadi = pytest.importorskip("casadi", reason="CasADi isn't installed: pip install casadi")

INPUTS = ("flange.s", "flange.v", "T_in")
OUTPUTS = ("flange.f", "A_used", "f_used", "T_used", "energyDissipated")
MOTION = (1e-4, 0.02, 400.0)


def test_outputs_and_jacobian_are_ours(native_fmus, tmp_path):
    fmpy.extract(str(native_fmus[2]), unzipdir=str(tmp_path / "casadi"))
    builder = casadi.DaeBuilder("clamp", str(tmp_path / "casadi"))
    builder.set_y(list(OUTPUTS))  # CasADi 3.8 reads Boolean outputs as Real ones
    imported = builder.create("imported", ["u"], ["y"])
    theirs = np.array(imported(MOTION)).ravel()
    their_jacobian = np.array(imported.jacobian()(MOTION, theirs))

    own = NativeDriver(native_fmus[2], tmp_path / "own", "ModelExchange", {})
    own.place(0.0, *MOTION[:2])
    own.set({"T_in": MOTION[2]})
    np.testing.assert_allclose(theirs, own.get(*OUTPUTS), rtol=1e-12)
    np.testing.assert_allclose(their_jacobian, own.jacobian(OUTPUTS, INPUTS), rtol=1e-9, atol=1e-9)
    assert their_jacobian[0, 0] > 0
    own.free()
