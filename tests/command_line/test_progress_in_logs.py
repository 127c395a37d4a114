"""What is being done, where nobody looks at a terminal: logs stay clean, but are told once in a minute."""

from __future__ import annotations

from pipeclamp.cli.terminal import each_minute


def test_a_log_is_told_what_is_being_done_once_in_a_minute(capsys):
    seconds = iter([0.0, 20.0, 59.0, 61.0, 90.0, 121.5, 400.0])
    tell = each_minute("diagnose", lambda: next(seconds))
    for what in ("law as it is", "memory", "play", "drag", "bouc_wen", "gap"):
        tell(what)
    assert capsys.readouterr().err.splitlines() == ["61 s: diagnose: play", "122 s: diagnose: bouc_wen",
                                                    "400 s: diagnose: gap"]  # fmt: skip
