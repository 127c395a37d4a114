"""Measured loops of a device that is no metal-mesh clamp: what the tool finds in them by itself."""

import json
import os
from pathlib import Path

import pytest

from pipeclamp_models.law.catalogue import effect_id

FOLDER = Path(os.environ.get("PIPECLAMP_DATA", "no data")) / "mr_damper"
WITH_A_SLIPPING_STATE = {"memory", "directional_slip", "slip_spread", "bouc_wen"}


@pytest.mark.skipif(not FOLDER.is_dir(), reason="PIPECLAMP_DATA has no mr_damper")
def test_current_then_memory_are_found_and_the_error_falls(pipeclamp, tmp_path):
    """Independent fits err by 20.7 % with the current, 13.0 % with memory, 11.8 % with a third effect."""
    law, answer = tmp_path / "law.json", tmp_path / "answer.json"
    identified = pipeclamp("identify", FOLDER, "-o", law)
    assert "moving average (displacement over 10.2% of the period, force over 10.2%" in identified.stderr
    pipeclamp("diagnose", law, FOLDER, "--auto", tmp_path / "end.json", "--json", answer)
    found = json.loads(answer.read_text(encoding="utf-8"))
    current, memory, *_ = found["ladder"]
    assert current["effect"] == "condition:current_A"
    assert current["heldout_before"] > 0.3
    assert effect_id(memory["effect"]) in WITH_A_SLIPPING_STATE
    # no effect of the catalogue is a damper's fluid: what takes most of it takes a part
    assert {current["kind"], memory["kind"]} == {"part"}
    assert found["ladder"][-1]["heldout_after"] < 0.066
    # what remains is more than the scatter, and is not called complete
    assert found["verdict"] != "complete"
