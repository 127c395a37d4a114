"""Conditions beside A, f and T: a law's file names them by columns, its equations by signals; both mean the same."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp_identification.planning.loop_tests import with_tests
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import (
    CoefficientEntry,
    Foretold,
    Interval,
    KrigedShare,
    LawFile,
    LocalForm,
    Shares,
    Spread,
    write_law,
)
from pipeclamp_models.law.range import beyond_tests
from pipeclamp_system.bands.ensemble import _conditions
from pipeclamp_system.bands.varied import varied
from pipeclamp_system.description.system import ClampSource
from pipeclamp_system.steady.described import steady_clamp

VALUES = {"k10": 1200.0, "k1_A": -0.2, "k1_T": 0.0, "k30": 150.0, "k3_A": 0.0, "k3_T": 0.0, "c0": 180.0, "c_A": 0.0}
VALUES |= {"c_f": 0.0, "alpha0": 0.47, "alpha_A": 0.0, "alpha_f": 0.012, "l_N": -0.2, "N_l": 8.0}
VALUES |= {f"{letter}_u_current_A{order}": 0.1 for letter in "kcz" for order in (1, 2)} | {"F_u_current_A1": 0.0}
SMALL = Shares(stiffness=0.01, damping=0.01)
TESTED = KrigedShare(deviation=0.1, lengths={"current_A": 0.3}, shares=(-0.1, 0.1), variances=(1e-6, 1e-6))


@pytest.fixture
def law() -> LawFile:
    """A law that follows a current, tested from -1 to 2 A, and load cycles."""
    known = open_law("emwm2")
    return known.model_copy(
        update={
            "effects": ("condition:current_A", "loosening"),
            "coefficients": {
                name: CoefficientEntry(value=value, unit="", state="given") for name, value in VALUES.items()
            },
            "range": {
                **known.range,
                "current_A": Interval(minimum=-1.0, maximum=2.0, unit="in its name"),
                "N": Interval(minimum=0.5, maximum=200.0, unit="cycles"),
            },
            "spread": Spread(
                runs=SMALL,
                form=SMALL,
                beyond={"current_A": Foretold(step=0.5, error=Shares(stiffness=0.1, damping=0.2))},
                local=LocalForm(at={"current_A": (-1.0, 2.0)}, stiffness=TESTED, damping=TESTED),
            ),
        }
    )


def test_a_band_knows_a_current_beyond_its_tests_and_next_to_them(law):
    own = varied(law)
    assert own.form({"u_current_A": 4.0}).stiffness == pytest.approx(0.4, rel=1e-2)
    assert own.form({"u_current_A": 4.0}) == own.form({"current_A": 4.0})
    assert own.form({}, {"u_current_A": 2.0}).stiffness < 0.01 < own.form({}, {"u_current_A": 0.5}).stiffness
    assert own.lean({"u_current_A": 2.0})["stiffness"] == pytest.approx(0.1, rel=1e-2)
    assert own.form_at({"u_current_A": 4.0}) == own.form_at({"current_A": 4.0})
    told = [own.form_told({name: 2.0}, {name: 4.0}) for name in ("u_current_A", "current_A")]
    assert told[0] == told[1]
    assert told[0]["stiffness"][1] > 0.0


def test_a_clamp_that_is_new_is_within_the_load_cycles_of_its_tests(law, tmp_path: Path):
    write_law(law, tmp_path / "law.json")
    source = ClampSource(at="c1", law="law.json", temperature_C=20.0, amplitude_mm=0.5, conditions={"current_A": 4.0})
    clamp = steady_clamp(source, tmp_path, None, "system")
    motion = np.array([0.0, 0.5], dtype=np.complex128)
    assert clamp.beyond(motion, 3.0, 0.5) == {"u_current_A": 4.0}


def test_bands_of_a_run_are_taken_at_the_current_that_a_clamp_is_given(law):
    source = ClampSource(at="c1", law="law.json", temperature_C=20.0, amplitude_mm=0.5, conditions={"current_A": 4.0})
    columns = {"c1.s": np.array([-5e-4, 5e-4]), "c1.f_used": np.array([3.0])}
    result = SimpleNamespace(system=SimpleNamespace(clamps=(source,)), columns=columns)
    assert _conditions(result, 0, law, "system") == {"A": 0.5, "f": 3.0, "T": 293.15, "u_current_A": 4.0, "N": 0.0}


def test_a_planned_test_widens_the_range_of_its_current(law):
    wider = with_tests(law, [{"A": 0.5, "f": 3.0, "T": 300.0, "u_current_A": 3.0}])
    assert wider.range["current_A"].maximum == 3.0
    assert wider.spread.local.at["current_A"] == (-1.0, 2.0, 3.0)


def test_a_force_at_a_current_beyond_the_tests_is_told(law):
    assert beyond_tests(law, {"A": 0.5, "current_A": 1.0, "first_cycle": 1.0}) == ()
    (words,) = beyond_tests(law, {"A": 0.5, "current_A": 50.0})
    assert words == "current_A = 50 lies beyond the law's tests, -1 to 2"
