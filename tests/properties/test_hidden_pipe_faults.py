"""What is hidden in a virtual shaker test, integrated in time, is named: the pipe's parameter, the clamp's, or none."""

from __future__ import annotations

from dataclasses import replace

import pytest
from project import PIPE_TRUTH

from pipeclamp_identification.attribution.compared import compare_measured
from pipeclamp_identification.attribution.verdict import attribute


@pytest.fixture(autouse=True)
def trials_on_path(monkeypatch):
    monkeypatch.syspath_prepend(PIPE_TRUTH)


@pytest.mark.parametrize("hidden", ["nothing", "clamp 0.6 times as damped"])
def test_what_is_hidden_is_named(hidden, tmp_path):
    from designs import DESIGNS, TRIALS, sines
    from pipe_rig import describe, measure

    trial = next(trial for trial in TRIALS if (trial.design, trial.hidden) == ("cantilever", hidden))
    design = replace(DESIGNS[trial.design], sines=sines(6.0, 10.0, 4, (0.5, 2.0)))
    stated = design.write(tmp_path, {}, {})
    true = design.write(tmp_path / "true", trial.fields, trial.laws)
    files = measure(true, design.sensors, design.sines, tmp_path / "measured", trial.noise, seed=5)
    describe(tmp_path / "measured", design.sensors, files)
    found = attribute(compare_measured(stated, tmp_path / "measured"))
    assert found is not None
    named = {suspect.id for suspect in found.suspects}
    if trial.truth:
        assert found.verdict in ("wrong", "ambiguous")
        assert set(trial.truth) <= named
    else:
        assert found.verdict == "complete"


def test_sensors_out_of_calibration_are_named_and_no_part_of_the_pipe(tmp_path):
    from designs import sines
    from measuring_trials import MEASURING_DESIGNS
    from pipe_rig import describe, measure

    design = replace(MEASURING_DESIGNS["line strong"], sines=sines(13.0, 21.0, 5, (2.0,)))
    stated = design.write(tmp_path, {}, {})
    wrong = tuple(replace(sensor, gain=1.1) for sensor in design.sensors)
    files = measure(stated, wrong, design.sines, tmp_path / "measured", 0.01, seed=5)
    describe(tmp_path / "measured", design.sensors, files)
    found = attribute(compare_measured(stated, tmp_path / "measured"))
    assert found is not None
    assert found.verdict in ("wrong", "ambiguous")
    assert {suspect.side for suspect in found.suspects} == {"measurement"}
    assert "sensors.gain" in {suspect.id for suspect in found.suspects}
