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
    added = pipeclamp("add", law, "condition:tension_lb", FOLDER, "-o", tmp_path / "tension.json")
    # loops have mean forces of up to -3.7 kN, and the device rests without force before each test
    assert "F_u_tension_lb1 (at rest before the tests there is no such force)" in added.stdout
    pipeclamp("add", tmp_path / "tension.json", "slip_lock", FOLDER, "-o", tmp_path / "slip.json")
    base, tension, slip = (step.refitted_nrmse for step in read_law(tmp_path / "slip.json").history)
    assert base > 0.35 > tension
    assert slip < 0.19
    pipeclamp("compare", tmp_path / "slip.json", FOLDER / "other_motions", "--json", tmp_path / "motions.json")
    # a law with a constant force errs by 84%
    assert json.loads((tmp_path / "motions.json").read_text(encoding="utf-8"))["nrmse"] < 0.45
