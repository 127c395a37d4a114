"""A clamp FMU in fmpy along a measured free motion: its force is the one that `compare` holds against the record.

Between its samples too: where the motion turns, memory unloads, and where a clearance lets go.
"""

import numpy as np
import pytest

from pipeclamp_fmu.build import build_clamp
from pipeclamp_fmu.contents.clamp_of_law import condition_parameter
from pipeclamp_identification.campaign.free_motion import FreeRun, free_motion
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.runs_table import Setup
from pipeclamp_identification.fitting.free_misfit import free_misfits
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import CoefficientEntry

T, FIRST_CYCLE = 350.0, 20.0
CONDITIONS = {"density_g_cm3": 2.3, "current_A": 0.7, "first_cycle": FIRST_CYCLE}


def shaken(time):
    """From 0.3 mm, beyond the law's range of A and f for a while, with a rest in between; cut off where it moves, so
    that there is no force at rest to tell of a past, which FMUs don't have."""
    time = time + 1.0
    draw = np.random.default_rng(8)
    window = np.sin(np.pi * np.clip(time / 6, 0, 1)) ** 2 + 1.5 * np.sin(np.pi * np.clip((time - 8) / 12, 0, 1)) ** 2
    lines = ((f, draw.uniform(0, 2 * np.pi), draw.normal()) for f in np.arange(0.8, 7.0, 0.4))
    return 0.3 + 0.2 * window * sum(a / f * np.sin(2 * np.pi * f * time + phase) for f, phase, a in lines)


@pytest.mark.parametrize(
    ("kind", "rate"), [("emwm2", 250.0), ("memory", 250.0), ("memory", 40.0), ("further", 250.0), ("play", 250.0)]
)
def test_its_force_is_that_of_compare(kind, rate, drive, law_with_memory, law_with_further_conditions, tmp_path):
    play = CoefficientEntry(value=0.05, unit="mm", state="given")
    with_play = law_with_memory.model_copy(
        update={
            "effects": (*law_with_memory.effects, "play"),
            "coefficients": {**law_with_memory.coefficients, "g_p": play},
        }
    )
    laws = {"memory": law_with_memory, "play": with_play, "further": law_with_further_conditions}
    file = laws.get(kind) or open_law("emwm2")
    path = tmp_path / "clamp.fmu"
    build_clamp(file, path)
    time = np.arange(round(20 * rate)) / rate
    record = Record(time, shaken(time), 1e3 * shaken(time))
    setup = Setup(None, T - 273.15, 2.3, FIRST_CYCLE, {"current_A": 0.7})
    run = FreeRun("run", setup, record, free_motion(record))
    (held,) = free_misfits(file, [run])
    assert np.ptp(held.amplitude) > 0.3
    assert np.ptp(held.frequency) > 1.0
    told = dict(condition_parameter(column, value) for column, value in CONDITIONS.items()) if kind == "further" else {}
    clamp = drive(path, {"track": True, "T": T, "flange.s": held.y[0] / 1000, "flange.v": held.v[0] / 1000} | told)
    seen = []
    for y, v in zip(held.y[1:], held.v[1:], strict=True):
        clamp.step(1 / rate, flange__s=y / 1000, flange__v=v / 1000)
        seen.append([clamp.get(name) for name in ("flange.f", "A_used", "f_used")])
    force, A, f = np.array(seen).T
    assert np.sqrt(np.mean((force - held.computed[1:]) ** 2) / np.mean(held.computed**2)) < 1e-12
    for values, motion, interval in ((1000 * A, held.amplitude, held.ranges[0]), (f, held.frequency, held.ranges[1])):
        assert np.allclose(values, np.clip(motion[1:], *interval), rtol=1e-12)
