"""Every command explains itself, with an example that it would accept."""

from __future__ import annotations

import re
import shlex

import pytest
from typer.main import get_command

from pipeclamp.cli.app import app

COMMANDS = get_command(app).commands  # type: ignore[attr-defined]


def test_the_contracts_commands_are_there():
    named = "metrics identify compare add effects rig build-fmu build-pipe cosim response sweep demo"
    assert set(named.split()) <= set(COMMANDS)


def test_help_names_every_command(pipeclamp):
    text = pipeclamp("--help").stdout
    for name in COMMANDS:
        assert re.search(rf"\b{name}\b", text)
    assert "Example: pipeclamp" in text


def test_help_tells_each_commands_whole_sentence(pipeclamp):
    told = " ".join(pipeclamp("--help").stdout.split())
    for command in COMMANDS.values():
        assert " ".join(command.help.removesuffix(".").split()) in told


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_help_with_an_example(name):
    command = COMMANDS[name]
    assert command.help
    found = re.search(r"Example: pipeclamp (.*)", command.epilog or "")
    assert found, "no example"
    words = shlex.split(found[1].partition(" > ")[0])
    assert words.pop(0) == name
    # parsed but not run: a name that the example misspells would be refused here
    assert command.make_context(name, words) is not None


@pytest.mark.parametrize("name", ["identify", "build-fmu"])
def test_help_is_shown(pipeclamp, name):
    text = pipeclamp(name, "--help").stdout
    assert f"pipeclamp {name}" in text
    assert "Example: pipeclamp" in text


@pytest.mark.parametrize(
    "words",
    [
        ["nonsense"],
        ["identify"],
        ["identify", "somewhere"],
        ["identify", "somewhere", "-o", "law.json", "--base", "cubic"],
        ["compare", "law.json", "somewhere", "--jason", "x"],
        ["rig", "emwm2", "-o", "virtual", "--cycles", "many"],
        ["rig", "emwm2", "-o", "virtual", "--seed", "-1"],
        ["diagnose", "emwm2", "somewhere", "--jobs", "0"],
    ],
)
def test_a_wrong_usage_is_status_2(pipeclamp, words):
    done = pipeclamp(*words, status=2)
    assert "Usage: pipeclamp" in done.stderr


def test_no_command_at_all_shows_the_help(pipeclamp):
    done = pipeclamp(status=2)
    assert "identify" in done.stdout + done.stderr


def test_the_version_is_told(pipeclamp):
    assert re.fullmatch(r"pipeclamp \d+\.\d+\.\d+\n", pipeclamp("--version").stdout)


@pytest.mark.parametrize("name", COMMANDS)
def test_a_flag_takes_no_value(name):
    flags = [option for option in COMMANDS[name].params if getattr(option, "is_flag", False)]
    assert all(option.metavar == "" for option in flags)
