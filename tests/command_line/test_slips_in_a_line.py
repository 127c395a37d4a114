"""Slips of somebody who types a line: a comma for a point, an order of arguments, one file for another."""

import sys

import pytest
from project import EXAMPLES, ROOT

from pipeclamp.__main__ import main

LAW_FILE = ROOT / "models" / "pipeclamp_models" / "data" / "laws" / "emwm2.json"


@pytest.fixture
def usage(monkeypatch, capsys):
    """Give what is said of a line that can't be read."""

    def run(*words):
        monkeypatch.setattr(sys, "argv", ["pipeclamp", *map(str, words)])
        with pytest.raises(SystemExit) as ended:
            main()
        assert ended.value.code == 2
        return capsys.readouterr().err

    return run


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("plan", "-o", "x", "--hours", "0,5"), "'--hours': got '0,5'; expected a number, with a point: 0.5"),
        (("build-fmu", "emwm2", "-o", "x.fmu", "--amplitude", "half"), "got 'half'; expected a number, with a point\n"),
        (("rig", "emwm2", "-o", "x", "--repeats", "1.5"), "got '1.5'; expected a whole number"),
        (("identify", "clamp_a", "-o", "x", "--base", "Power"), "'--base': 'Power' is not one of"),
    ],
)
def test_an_options_value_is_told_with_what_was_expected(usage, words, said):
    assert said in usage(*words)


@pytest.mark.parametrize("words", [("law.json",), ("--json", "x.json", "law.json")])
def test_of_a_comparison_without_tests_the_tests_are_missing(usage, words):
    assert "Missing argument 'CAMPAIGN|MEASURED'" in usage("compare", *words)


def test_of_a_comparison_of_nothing_the_law_is_missing(usage):
    assert "Missing argument 'LAW...|SYSTEM.toml'" in usage("compare")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("identify", "clamp_a", "-o", "x", "--freeze", "c_A=0,5"), "--freeze: got '5' in 'c_A=0,5'; expected"),
        (("rig", "emwm2", "-o", "x", "--set", "c0=soft"), "--set: c0: got 'soft'"),
    ],
)
def test_an_option_of_named_values_is_named(refused, monkeypatch, tmp_path, words, said):
    monkeypatch.chdir(tmp_path)
    assert said in refused(*words, status=2)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("add", "memory:2", "emwm2", "clamp_a", "-o", "x"), "memory:2: an effect; expected a law there"),
        (("add", "emwm2", "clamp_a", "viscous", "-o", "x"), "viscous: an effect; expected a campaign there"),
        (("build-fmu", ".", "-o", "x.fmu"), ".: a folder; expected a law's file"),
        (("build-fmu", "clamp_a", "-o", "x.fmu"), "clamp_a: a campaign; expected a law there"),
        (("build-fmu", EXAMPLES / "system.toml", "-o", "x.fmu"), "describes a system; expected a law there"),
        (("cosim", EXAMPLES / "pipe.toml", "-o", "x"), "describes a pipe; expected a system there"),
        (("cosim", LAW_FILE, "-o", "x"), "is JSON, as a law's file is; expected a system there"),
        (("build-pipe", EXAMPLES / "system.toml", "-o", "x.fmu"), "describes a system; expected a pipe there"),
        (("sweep", EXAMPLES / "system.toml", "-o", "x"), "describes a system; expected a study there"),
        (("sweep", EXAMPLES / "pipe.toml", "-o", "x"), "describes a pipe; expected a study there"),
    ],
)
def test_one_thing_in_the_place_of_another_is_told_by_what_it_is(refused, monkeypatch, tmp_path, words, said):
    monkeypatch.chdir(tmp_path)
    assert said in refused(*words)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "ending"),
    [
        (("build-fmu", "emwm2", "-o", "clamp"), ".fmu"),
        (("build-fmu", "emwm2", "-o", "clamp.zip"), ".fmu"),
        (("build-pipe", EXAMPLES / "pipe.toml", "-o", "clamp.json"), ".fmu"),
        (("set-parameters", "old.fmu", "emwm2", "-o", "clamp"), ".fmu"),
        (("system", EXAMPLES / "system.toml", "-o", "clamp.fmu"), ".ssp"),
    ],
)
def test_a_name_by_which_no_tool_knows_what_it_holds_is_refused(refused, monkeypatch, tmp_path, words, ending):
    monkeypatch.chdir(tmp_path)
    assert f"ends in {ending}, by which tools know it; expected clamp{ending}" in refused(*words, status=2)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "words",
    [
        ("identify", "clamp_a", "MORE", "-o", "x"),
        ("diagnose", "emwm2", "clamp_a", "MORE"),
        ("metrics", "clamp_a", "MORE"),
    ],
)
def test_several_campaigns_are_pointed_to_join(usage, small, words):
    told = usage(*(str(small) if word == "MORE" else word for word in words))
    assert f"of several campaigns one is made by: pipeclamp join clamp_a {small} -o all_tests" in " ".join(told.split())


def test_what_is_over_and_no_campaign_is_not_pointed_to_join(usage):
    assert "join" not in usage("identify", "clamp_a", "law.json", "-o", "x")


def test_a_law_of_which_half_was_copied_is_told_as_that(refused, law, small, tmp_path):
    text = law.read_text(encoding="utf-8")
    half = tmp_path / "half.json"
    half.write_text(text[: len(text) // 2], encoding="utf-8")
    assert "the JSON breaks off in line" in refused("compare", half, small)


def test_temperatures_beyond_a_laws_data_are_told_as_they_were_given(pipeclamp, tmp_path):
    plan = ("--amplitudes", "0.5", "--frequencies", "2", "--temperatures", "400", "--rate", "200")
    assert "T = 400 °C, law: 20" in pipeclamp("rig", "emwm2", "-o", tmp_path / "hot", *plan).stderr
