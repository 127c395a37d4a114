"""A measured friction device with backlash, which lacks several effects at once: the ladder goes on."""

import json
import os
from pathlib import Path

import pytest

FOLDER = Path(os.environ.get("PIPECLAMP_DATA", "no data")) / "friction_device"


@pytest.mark.skipif(not FOLDER.is_dir(), reason="PIPECLAMP_DATA has no friction_device")
def test_the_ladder_goes_on_by_parts(pipeclamp, tmp_path):
    """A fit by hand of ten parameters, clearance in series with slip that follows the tension, errs by 19.0 %."""
    law, answer = tmp_path / "law.json", tmp_path / "answer.json"
    pipeclamp("identify", FOLDER, "-o", law)
    pipeclamp("diagnose", law, FOLDER, "--auto", tmp_path / "end.json", "--json", answer)
    found = json.loads(answer.read_text(encoding="utf-8"))
    errors = [found["ladder"][0]["heldout_before"], *(rung["heldout_after"] for rung in found["ladder"])]
    assert errors[0] > 0.35
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] <= 0.2
    assert "condition:tension_lb" in [rung["effect"] for rung in found["ladder"]]
    assert found["verdict"] != "complete"
