"""Shell completion: each shell's script is offered, and what it asks for is answered."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

SHELLS = ("bash", "zsh", "fish", "powershell")


def asked(what, **environment):
    """What the program answers to a shell."""
    known = os.environ | {"_PIPECLAMP_COMPLETE": what} | environment
    words = [sys.executable, "-c", "from pipeclamp.__main__ import main; main()"]
    return subprocess.run(words, env=known, capture_output=True, text=True, check=True, timeout=60).stdout


@pytest.mark.parametrize("shell", SHELLS)
def test_a_shells_script_names_the_program(shell):
    script = asked(f"source_{shell}")
    assert "pipeclamp" in script
    assert "_PIPECLAMP_COMPLETE" in script


def test_commands_and_options_are_completed():
    assert "identify" in asked("complete_bash", COMP_WORDS="pipeclamp iden", COMP_CWORD="1").split()
    options = asked("complete_bash", COMP_WORDS="pipeclamp identify --fr", COMP_CWORD="2").split()
    assert options == ["--freeze"]


def test_help_tells_of_it(pipeclamp):
    assert "--install-completion" in pipeclamp("--help").stdout
