"""`diagnose --auto` that ends in the middle keeps what it has climbed, and says how far it had come."""

import json
import os
import re
import signal

import pytest


@pytest.mark.skipif(os.name != "posix", reason="stops with a signal")
def test_a_ladder_that_is_stopped_or_killed_keeps_the_law_of_its_last_rung(started, pipeclamp, half, tmp_path):
    """Nothing is a terminal here; each rung is a line. Once it is told its law is on disk, whatever ends the ladder."""
    law, better = tmp_path / "law.json", tmp_path / "law2.json"
    pipeclamp("identify", half, "-o", law)
    with started("diagnose", law, half, "--auto", better) as process:
        told = next((line for line in process.stderr if " rung 1: " in line), "")
        left = better.read_text(encoding="utf-8")
        process.send_signal(signal.SIGINT)
        ended, next_line = process.stderr.read(), process.stdout.read()
    assert re.fullmatch(r"\d+ s: rung 1: \+ \S+ \(\w+\): error on left-out conditions \S+% -> \S+%\n", told)
    kept = json.loads(left)
    added = kept["history"][-1]["step"]
    assert f" rung 1: {added} (" in told
    (effect,) = kept["effects"]
    assert effect == added.removeprefix("+ ")
    assert "diagnosis" not in kept  # nobody has found yet what it lacks
    assert "Traceback" not in ended
    assert f"holds the law so far, with {effect}: " in " ".join(ended.split())
    assert next_line.split() == f"Next: pipeclamp diagnose {better} {half} --auto {better}".split()
    assert better.read_text(encoding="utf-8") == left
    pipeclamp("compare", better, half)
