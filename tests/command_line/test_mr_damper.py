"""Measured loops of a device that is no metal-mesh clamp: what the tool finds in them by itself."""

import json
import os
from pathlib import Path

import pytest

from pipeclamp_models.law.file import read_law

FOLDER = Path(os.environ.get("PIPECLAMP_DATA", "no data")) / "mr_damper"


@pytest.mark.skipif(not FOLDER.is_dir(), reason="PIPECLAMP_DATA has no mr_damper")
def test_current_then_memory_are_found_and_the_error_falls(pipeclamp, tmp_path):
    """Independent fits err by 20.7 % with the current, 13.0 % with memory, 11.8 % with a third effect."""
    law, answer = tmp_path / "law0.json", tmp_path / "answer.json"
    identified = pipeclamp("identify", FOLDER, "-o", law)
    assert "moving average (displacement over 10.2% of the period, force over 10.2%" in identified.stderr

    def diagnosed():
        pipeclamp("diagnose", law, FOLDER, "--json", answer)
        found = json.loads(answer.read_text(encoding="utf-8"))
        return found["verdict"], found["effects"]

    for number, effect in enumerate(("condition:current_A", "memory:2"), 1):
        assert diagnosed() == ("missing", [effect])
        after = tmp_path / f"law{number}.json"
        pipeclamp("add", law, effect, FOLDER, "-o", after)
        law = after
    base, current, memory = (step.heldout_nrmse for step in read_law(law).history)
    assert base > 0.3
    assert current < 0.207
    assert memory < 0.118
    # what remains is three times the scatter: more than an effect's form may leave over
    assert diagnosed() == ("unknown", [])
