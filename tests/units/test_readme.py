"""The README says what is: its examples are read, its commands and variables exist."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from typer.main import get_command

from pipeclamp.declaration import Declaration, effect_of
from pipeclamp.pipe_description import parse_pipe
from pipeclamp.toml_file import parse_table
from pipeclamp_fmu import clamp_slave
from pipeclamp_identification.cli import app
from pipeclamp_identification.description import CampaignDescription
from pipeclamp_identification.pipe_measurement import MeasurementDescription
from pipeclamp_identification.system import SystemDescription

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
EFFECT, CAMPAIGN, PIPE, SYSTEM, MEASUREMENT = re.findall(r"```toml\n(.*?)```", TEXT, re.S)
COMMANDS = get_command(app).commands  # type: ignore[attr-defined]


def with_optional_lines(text: str) -> str:
    """The example with the lines that it shows as comments."""
    return re.sub(r"^# (\w+ = )", r"\1", re.sub(r"^(# \w+ = [^ ]+) +[a-z].*$", r"\1", text, flags=re.M), flags=re.M)


def test_the_examples_are_read():
    assert len(effect_of(parse_table(EFFECT, Declaration, "README")).parameters) == 2
    assert parse_table(CAMPAIGN, CampaignDescription, "README").columns.force_N is not None
    for text in (PIPE, with_optional_lines(PIPE)):
        assert parse_pipe(text, "README").clamps[0].name == "clamp1"
    for text in (SYSTEM, with_optional_lines(SYSTEM)):
        assert parse_table(text, SystemDescription, "README").run.scheme == "iterated"
    for text in (MEASUREMENT, with_optional_lines(MEASUREMENT)):
        assert parse_table(text, MeasurementDescription, "README").probes[0].name == "midspan"
    assert "added_mass_kg_m = 2.0\n" in with_optional_lines(PIPE)


@pytest.mark.parametrize("end", ["&& pytest", "&& pipeclamp demo"])
def test_the_two_commands_stand_alone(end):
    assert len(re.findall(rf"^pip install .*{end}$", TEXT, re.M)) == 1


def test_every_command_is_named_and_every_named_command_exists():
    named = set(re.findall(r"^\| `pipeclamp ([\w-]+)", TEXT, re.M))
    assert named == set(COMMANDS)


def test_the_commands_shown_are_accepted():
    shown = re.findall(r"^pipeclamp (.*)$", TEXT, re.M)
    assert len(shown) >= 4
    for line in shown:
        name, *words = shlex.split(line)
        assert COMMANDS[name].make_context(name, words) is not None


def test_the_clamps_variables_are_named():
    names = (
        *clamp_slave.INPUTS, *clamp_slave.PARAMETERS, *clamp_slave.OUTPUTS, *clamp_slave.BOOLEAN_PARAMETERS,
        *clamp_slave.BOOLEAN_OUTPUTS,
    )  # fmt: skip
    for name in names:
        assert f"`{name}`" in TEXT


def test_what_it_links_to_is_there():
    for target in re.findall(r"\]\(([^)h][^)]*)\)", TEXT):
        assert (ROOT / target).is_file()
    for script in re.findall(r"`python (build_scripts/[\w/.]+)`", TEXT):
        assert (ROOT / script).is_file()
    assert (ROOT / "docs" / "law_grows.png").stat().st_size < 300e3
