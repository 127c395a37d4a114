"""A measured friction device with backlash, which lacks several effects at once: each takes a part."""

import json
import os
from pathlib import Path

import pytest

from pipeclamp_models.law.file import read_law

FOLDER = Path(os.environ.get("PIPECLAMP_DATA", "no data")) / "friction_device"


@pytest.mark.skipif(not FOLDER.is_dir(), reason="PIPECLAMP_DATA has no friction_device")
def test_each_effect_takes_a_part(pipeclamp, tmp_path):
    """A fit by hand of ten parameters, clearance in series with slip that follows the tension, errs by 19.0 %."""
    law, answer = tmp_path / "law.json", tmp_path / "answer.json"
    pipeclamp("identify", FOLDER, "-o", law)
    pipeclamp("diagnose", law, FOLDER, "--json", answer)
    found = json.loads(answer.read_text(encoding="utf-8"))
    assert found["verdict"] in ("missing", "ambiguous")
    assert found["kind"] == "part"
    assert found["remains"]["noise_share"] > 3
    pipeclamp("add", law, "memory:2", FOLDER, "-o", tmp_path / "memory.json")
    pipeclamp("add", tmp_path / "memory.json", "condition:tension_lb", FOLDER, "-o", tmp_path / "tension.json")
    base, memory, tension = (step.refitted_nrmse for step in read_law(tmp_path / "tension.json").history)
    assert base > 0.35 > memory
    assert tension < 0.26
