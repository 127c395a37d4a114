"""The Modelica example compiles and moves as its equation says; the library's parts that it uses are stubs here."""

from pathlib import Path

import numpy as np
import pytest
from project import ROOT

rumoca = pytest.importorskip("rumoca", reason="rumoca isn't installed: pip install rumoca")

HERE = Path(__file__).parent
EXAMPLE = ROOT / "docs" / "modelica" / "ClampOnMass.mo"
M, C, D, START = 20.0, 1.2e6, 300.0, 1e-3


def test_the_example_swings_on_the_stand_in_clamp():
    session = rumoca.Session(roots=[str(HERE / "modelica" / "Modelica.mo")])
    model = session.load(str(EXAMPLE), model="ClampOnMass.Example")
    assert model.structure().is_balanced
    result = model.simulate(t=(0, 0.2), dt=1e-4)
    time, s = np.asarray(result.time), np.asarray(result["mass.s"])
    decay = D / (2 * M)
    omega = np.sqrt(C / M - decay**2)
    expected = START * np.exp(-decay * time) * (np.cos(omega * time) + decay / omega * np.sin(omega * time))
    assert np.abs(s - expected).max() < 1e-3 * START
    assert np.asarray(result["clamp.f"])[0] == pytest.approx(C * START)
