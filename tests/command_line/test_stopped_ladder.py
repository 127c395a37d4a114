"""`diagnose --auto` that is stopped in the middle keeps what it has climbed, and says how far it had come."""

import json
import os
import re
import signal

import pytest


@pytest.mark.skipif(os.name != "posix", reason="stops with a signal")
def test_a_ladder_that_is_stopped_keeps_the_law_so_far(monkeypatch, started, pipeclamp, tmp_path):
    law, better = tmp_path / "law.json", tmp_path / "law2.json"
    pipeclamp("identify", "clamp_a", "-o", law)
    monkeypatch.setenv("FORCE_COLOR", "1")  # it tells what it does, as on a terminal
    monkeypatch.setenv("COLUMNS", "200")
    with started("diagnose", law, "clamp_a", "--auto", better) as process:
        told = ""
        while "on left-out conditions;" not in told:
            read = process.stderr.read(1)
            assert read, f"it ended before it could be stopped: {told}"
            told += read
        process.send_signal(signal.SIGINT)
        told, next_line = told + process.stderr.read(), process.stdout.read()
    assert "Traceback" not in told
    assert " s: rung 1: + " in told
    kept = json.loads(better.read_text(encoding="utf-8"))
    (effect,) = kept["effects"]
    assert f"holds the law so far, with {effect}: " in told
    assert next_line == f"Next: pipeclamp diagnose {better} clamp_a --auto {better}\n"
    pipeclamp("compare", better, "clamp_a")


def test_a_ladder_that_is_killed_leaves_the_law_of_its_last_rung(started, pipeclamp, tmp_path):
    """Nothing is a terminal here; each rung is a line, and once it is told its law is on disk."""
    law, better = tmp_path / "law.json", tmp_path / "law2.json"
    pipeclamp("identify", "clamp_a", "-o", law)
    with started("diagnose", law, "clamp_a", "--auto", better) as process:
        told = next((line for line in process.stderr if " rung 1: " in line), "")
        process.kill()
    assert re.fullmatch(r"\d+ s: rung 1: \+ \S+ \(\w+\): error on left-out conditions \S+% -> \S+%\n", told)
    kept = json.loads(better.read_text(encoding="utf-8"))
    added = kept["history"][-1]["step"]
    assert f" rung 1: {added} (" in told
    assert kept["effects"] == [added.removeprefix("+ ")]
    assert "diagnosis" not in kept  # nobody has found yet what it lacks
    pipeclamp("compare", better, "clamp_a")
