"""The README and the pages in docs/ say what is: examples are read, commands, options, variables and links exist."""

from __future__ import annotations

import ast
import re
import shlex
import tomllib

import pytest
from project import ROOT
from typer.main import get_command

from pipeclamp.cli.app import app
from pipeclamp_fmu.slaves import clamp as clamp_slave
from pipeclamp_identification.campaign.description import CampaignDescription
from pipeclamp_identification.on_pipe.measurement import MeasurementDescription
from pipeclamp_models.base.toml_file import parse_table
from pipeclamp_models.equations import literature
from pipeclamp_models.equations.effect import Effect
from pipeclamp_models.law import catalogue
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.declared import effect_of
from pipeclamp_models.law.law import Structure
from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_system.description.system import SystemDescription
from pipeclamp_system.study.description import StudyDescription

README = ROOT / "README.md"
PAGES = [README, *sorted((ROOT / "docs").rglob("*.md"))]
COMMANDS = get_command(app).commands  # type: ignore[attr-defined]
OF_ALL = {"--help", "--version", "--install-completion", "--show-completion"}
OF_OTHERS = {
    "--keep-going", "--check", "--narrow", "--metrics", "--devices", "--discover", "--write", "--share", "--seed",
    "--cases", "--only", "--benchmark-only",
}  # fmt: skip
"""Options of scripts and other programs that pages name."""


def text_of(page):
    return page.read_text(encoding="utf-8")


def named(page):
    return page.relative_to(ROOT).as_posix()


def blocks(language):
    """Every fenced block of a language, with its page."""
    return [
        pytest.param(block, id=f"{named(page)}-{place}")
        for page in PAGES
        for place, block in enumerate(re.findall(rf"^```{language}\n(.*?)^```", text_of(page), re.S | re.M))
    ]


def with_optional_lines(text: str) -> str:
    """The example with the lines that it shows as comments."""
    return re.sub(r"^# (\w+ = )", r"\1", re.sub(r"^(# \w+ = [^ ]+) +[a-z].*$", r"\1", text, flags=re.M), flags=re.M)


READ = {
    r"^force = ": lambda text: effect_of(parse_table(text, Declaration, "page")).parameters,
    r"^\[columns\]": lambda text: parse_table(text, CampaignDescription, "page").columns.force_N,
    r"^outer_diameter_mm": lambda text: parse_pipe(text, "page").clamps,
    r"^\[run\]": lambda text: parse_table(text, SystemDescription, "page").clamps,
    r"^\[\[responses\]\]": lambda text: parse_table(text, MeasurementDescription, "page").probes,
    r"^\[vary\]": lambda text: parse_table(text, StudyDescription, "page").vary,
}
"""How an example is known, and what reads it."""


@pytest.mark.parametrize("text", blocks("toml"))
def test_the_examples_are_read(text):
    (read,) = (reader for sign, reader in READ.items() if re.search(sign, text, re.M))
    assert read(text)
    assert read(with_optional_lines(text))


def test_each_kind_of_file_has_an_example():
    examples = [block.values[0] for block in blocks("toml")]
    for sign in READ:
        assert any(re.search(sign, text, re.M) for text in examples), sign
    assert any("added_mass_kg_m = 2.0\n" in with_optional_lines(text) for text in examples)


@pytest.mark.parametrize("text", blocks("python"))
def test_the_python_shown_is_python(text):
    ast.parse(text)


@pytest.mark.parametrize("end", ["&& pytest", "&& pipeclamp demo"])
def test_the_two_commands_stand_alone(end):
    assert len(re.findall(rf"^pip install .*{end}$", text_of(README), re.M)) == 1


def test_the_readme_is_short():
    assert len(text_of(README).splitlines()) <= 200


def test_every_command_is_named_and_every_named_command_exists():
    overview = text_of(ROOT / "docs" / "reference" / "commands.md")
    assert set(re.findall(r"^\| `pipeclamp ([\w-]+)", overview, re.M)) == set(COMMANDS)


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_the_commands_shown_are_accepted(page, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    for line in re.findall(r"^pipeclamp (.*)$", text_of(page), re.M):
        name, *words = shlex.split(line, comments=True)
        if name in OF_ALL:
            continue
        assert COMMANDS[name].make_context(name, words) is not None


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_the_commands_and_options_named_exist(page):
    for words in re.findall(r"`pipeclamp ([a-z][^`]*)`", text_of(page)):
        name, *rest = words.split()
        options = {option for parameter in COMMANDS[name].params for option in parameter.opts} | OF_ALL
        for option in re.findall(r"(?<!\S)--[\w-]+", " ".join(rest)):
            assert option in options, f"{named(page)}: pipeclamp {words}"
    every = {option for command in COMMANDS.values() for parameter in command.params for option in parameter.opts}
    for option in re.findall(r"`(--[a-z][\w-]+)", text_of(page)):
        assert option in every | OF_ALL | OF_OTHERS, f"{named(page)}: {option}"


def test_the_clamps_variables_are_named():
    text = text_of(ROOT / "docs" / "reference" / "fmu-variables.md")
    names = (
        *clamp_slave.INPUTS, *clamp_slave.PARAMETERS, *clamp_slave.OUTPUTS, *clamp_slave.BOOLEAN_PARAMETERS,
        *clamp_slave.BOOLEAN_LOCALS,
    )  # fmt: skip
    for name in names:
        assert f"`{name}`" in text


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_what_it_links_to_is_there(page):
    text = text_of(page)
    for target in re.findall(r"\]\(<?([^)#>]+)(?:#[^)]*)?>?\)", re.sub(r"`[^`]*`", "", text)):
        if not target.startswith("http"):
            assert (page.parent / target).is_file(), f"{named(page)}: {target}"
    for path in re.findall(r"(?<![\w/.])((?:build_scripts|tests|docs|models|fmu_src|identification)/[\w/.-]+)", text):
        assert (ROOT / path.rstrip(".")).exists(), f"{named(page)}: {path}"


def test_pictures_are_small():
    for picture in (ROOT / "docs" / "pictures").iterdir():
        assert picture.stat().st_size < 300e3


def test_the_effect_that_is_added_on_its_page_is_one(monkeypatch):
    publication, file = re.findall(
        r"^```python\n(.*?)^```", text_of(ROOT / "docs/develop/add-an-effect.md"), re.S | re.M
    )
    cited: dict[str, str] = {}
    exec(publication, cited)
    monkeypatch.setattr(literature, "WOUTERSE", cited["WOUTERSE"], raising=False)
    monkeypatch.setenv("PIPECLAMP_CACHE", "")  # it isn't in the sources that what is kept is named after
    written: dict[str, Effect] = {}
    exec(file, written)
    find = catalogue.find_entry
    own = {"eddy_current": written["EFFECT"]}
    monkeypatch.setattr(catalogue, "find_entry", lambda name: own.get(name) or find(name))
    equations = Structure("power", ("eddy_current",)).equations
    assert {"F_m", "v_m"} < set(equations.names)


def test_the_version_to_cite_is_the_packages():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    cited = re.search(r"^version: (.*)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.M)
    assert cited and cited[1] == project["version"]


def test_the_site_begins_with_the_same_five_commands_as_the_readme():
    """The site's had built an FMU that doesn't follow its own motion, as the README's does."""

    def five(page):
        return text_of(page).partition("## The loop in five commands\n\n```\n")[2].partition("```")[0].splitlines()

    assert len(five(README)) == 5
    assert five(ROOT / "docs" / "index.md") == five(README)
