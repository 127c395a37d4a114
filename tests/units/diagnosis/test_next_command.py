"""The command that a diagnosis ends with can be run as it stands."""

import shlex
from dataclasses import dataclass, field
from types import SimpleNamespace

import pytest
from typer.main import get_command

from pipeclamp.cli.app import app
from pipeclamp_identification.workflow.next_command import after_discovery, after_vain_addition, next_command


@dataclass
class Found:
    verdict: str
    effects: tuple[str, ...] = ()
    proposal: str | None = None
    calls_for_a_term: bool = False
    kind: str | None = "cause"
    together: tuple[str, ...] = ()
    values: dict[str, float] = field(default_factory=dict)


def searched(verdict, effects=(), *, term=False, spare=(), instead=""):
    search = SimpleNamespace(diagnosed=Found(verdict, effects, calls_for_a_term=verdict == "unknown"))
    return SimpleNamespace(search=search, proposed=term, spare=spare, instead=instead)


@pytest.mark.parametrize(
    ("found", "law", "expected"),
    [
        (Found("missing", ("memory:2",)), "law.json", "pipeclamp add law.json memory:2 tests -o law_2.json"),
        (Found("missing", ("memory",)), "law_2.json", "pipeclamp add law_2.json memory tests -o law_3.json"),
        (Found("missing", ("gap",)), "clamp7.json", "pipeclamp add clamp7.json gap tests -o clamp7_2.json"),
        (Found("missing", ("gap",)), "emwm2", "pipeclamp add emwm2 gap tests -o emwm2_2.json"),
        (Found("missing", ("bracket",)), "law.json", "pipeclamp add law.json my/bracket.toml tests -o law_2.json"),
        (
            Found("missing", ("gap",), kind="part"),
            "law.json",
            "pipeclamp add law.json gap tests -o law_2.json --as part",
        ),
        (
            Found("missing", ("gap",), together=("gap", "bracket")),
            "law.json",
            "pipeclamp add law.json gap,my/bracket.toml tests -o law_2.json",
        ),
        (Found("complete"), "clamp.json", "pipeclamp build-fmu clamp.json -o clamp.fmu --track"),
        (Found("complete", values={"k10": 2.0}), "clamp.json", "pipeclamp refit clamp.json tests -o clamp_2.json"),
        (Found("ambiguous", proposal="a sine"), "law.json", "pipeclamp diagnose law.json tests --drive next_test.csv"),
        (Found("ambiguous"), "law.json", "pipeclamp compare law.json tests --report compare.html"),
        (Found("unknown"), "law.json", "pipeclamp compare law.json tests --report compare.html"),
        (
            Found("unknown", calls_for_a_term=True),
            "law_2.json",
            "pipeclamp discover law_2.json tests -o law_2_term.toml --auto law_3.json",
        ),
    ],
)
def test_the_next_command(found, law, expected):
    line = next_command(found, law, "tests", {"bracket": "my/bracket.toml"})
    assert line == expected
    name, *words = shlex.split(line)[1:]
    command = get_command(app).commands[name]
    command.make_context(name, words, resilient_parsing=True)


def test_after_a_search_that_the_catalogue_made_needless_its_effect_is_added():
    line = after_discovery(searched("missing", ("memory:2",)), "law.json", "tests", "term.toml", None)
    assert line == "pipeclamp add law.json memory:2 tests -o law_2.json"
    line = after_discovery(searched("unknown"), "law.json", "tests", "term.toml", None)
    assert line == "pipeclamp compare law.json tests --report compare.html"


def test_after_a_search_that_gave_an_effect_this_is_added_as_a_part():
    search = (searched("unknown", instead="bouc_wen"), "law.json", "tests", "term.toml")
    line = after_discovery(*search, None)
    assert line == "pipeclamp add law.json bouc_wen tests -o law_2.json --as part"
    assert after_discovery(*search, "mine.json") == line.replace("law_2.json", "mine.json")


def test_a_term_that_stands_in_the_place_of_effects_is_not_added_beside_them():
    replacing = searched("unknown", term=True, spare=("gap",))
    line = after_discovery(replacing, "law.json", "tests", "term.toml", None)
    assert line == "pipeclamp discover law.json tests -o term.toml --auto law_2.json"


def test_a_test_that_is_run_is_joined_to_those_so_far():
    line = next_command(Found("ambiguous", proposal="a sine"), "law.json", "a/tests", driven=True)
    assert line == "pipeclamp join a/tests next_test -o tests_and_next_test"


def test_spaces_are_quoted():
    line = next_command(Found("missing", ("gap",)), "my law.json", "my tests")
    assert shlex.split(line) == ["pipeclamp", "add", "my law.json", "gap", "my tests", "-o", "my law_2.json"]


@pytest.mark.parametrize(
    ("changed", "line"),
    [
        ("worse.json", "pipeclamp diagnose law.json tests --auto law_2.json"),
        ("law.json", "pipeclamp remove law.json memory tests -o law.json"),
    ],
)
def test_after_an_addition_that_does_not_help_the_ladder_goes_on_from_the_law_before(changed, line):
    assert after_vain_addition("law.json", changed, ["memory"], "tests") == line
