"""A user's declared effects: what is refused, and a law file that carries them by itself."""

from __future__ import annotations

import json
import pickle
import sys

import pytest
from project import DECLARED_EFFECTS

from pipeclamp_identification.diagnosis.screen import fits_beside
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.kept import FOLDER_VARIABLE
from pipeclamp_models.base.toml_file import parse_table
from pipeclamp_models.equations.symbols import condition_symbol
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.declaration import Declaration, merged
from pipeclamp_models.law.declaration_files import read_declaration, read_effects
from pipeclamp_models.law.declared import effect_of
from pipeclamp_models.law.file import law_of, law_text, parse_law
from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise import bounded
from pipeclamp_models.realise.c import c_source
from pipeclamp_models.realise.scalar import python_source

GOOD = """
id = "stop"
title = "A stop"
looks_like = "a kink"
force = "k_b * max(y - y_b, 0)"
parameters = [
  { symbol = "k_b", unit = "N/mm", meaning = "stiffness", start = 100, lower = 0 },
  { symbol = "y_b", unit = "mm", meaning = "place", start = ["0.5 * A_highest", 0.6], upper = "A_highest" },
]
"""


def declared(text: str) -> Declaration:
    declaration = parse_table(text, Declaration, "stop.toml")
    effect_of(declaration)
    return declaration


def test_a_good_one_is_read():
    effect = effect_of(declared(GOOD))
    assert [parameter.name for parameter in effect.parameters] == ["k_b", "y_b"]
    assert len(effect.parameters[1].starts) == 2
    assert effect.part == "clamp"


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('id = "stop"', 'id = "A stop"', ["id", "letters, digits and _"]),
        ('title = "A stop"', "", ["title", "is missing"]),
        ('force = "', 'forse = "', ["forse", "did you mean 'force'"]),
        ("max(y - y_b, 0)", "max(y - yb, 0)", ["'stop', force, character 15", "did you mean 'y_b'"]),
        ("max(y - y_b, 0)", "max(y - y_b, 0", ["force, character", "never closed"]),
        ("max(y - y_b, 0)", "max(a - y_b, 0)", ["name 'a'"]),
        ("max(y - y_b, 0)", "y", ["'y_b' is declared but no force"]),
        ("y_b", "T", ["is the temperature of the specimen"]),
        ("y_b", "sin", ["is a word of expressions"]),
        ("y_b", "lambda", ["is reserved", "lambda0"]),
        ("y_b", "u_x", ["is reserved"]),
        ("y_b", "_y", ["a letter first"]),
        ("y_b", "y_", ["letters, digits and _"]),
        ("k_b", "y_b", ["'y_b' is used twice"]),
        ('"0.5 * A_highest"', '"0.5 * A_highst"', ["y_b, start, character 7", "did you mean 'A_highest'"]),
        ('"0.5 * A_highest"', "true", ["expected a number or an expression"]),
        ("lower = 0", "lower = nan", ["finite"]),
        ("lower = 0", "lower = 200", ["k_b", "200.0", "expected rising numbers"]),
        ("lower = 0", "lower = 0, neutral = -1", ["k_b", "[0.0, -1.0", "lower, neutral, upper", "rising numbers"]),
        ("lower = 0", 'follows = ["T"]', ["no neutral value"]),
        ("lower = 0", 'follows = ["y"], neutral = 0', ["got 'y'; expected one of A, f, T, N, rho"]),
        ('force = "', 'lag = "k_b"\nforce = "', ['expected part = "rig"']),
        ('force = "', 'conditions = ["T"]\nforce = "', ["'T' can't stand in an expression"]),
        ('force = "', 'path = "y - v"\nforce = "', ["path, character 5", "name 'v'"]),
        ('force = "k_b * max(y - y_b, 0)"', 'energy = "k_b * y_b"', ["it does nothing"]),
        ("N/mm", r"N\nmm", ["unit", "in one line"]),
        ("N/mm", r"N\u2028mm", ["unit", "in one line"]),
        ("N/mm", " ", ["unit", "in one line"]),
        ("id =", "id ==", ["not valid TOML"]),
    ],
)  # fmt: skip
def test_what_cannot_serve_is_refused_with_its_place(old, new, words):
    assert old in GOOD
    with pytest.raises(UserError) as refused:
        declared(GOOD.replace(old, new))
    for word in words:
        assert word in str(refused.value)


@pytest.mark.parametrize("stated", ["start = 1, neutral = 0", "start = 0", "start = [1, 0]"])
@pytest.mark.parametrize(
    ("part", "force", "energy"),
    [
        ("force", "y / s", ""),
        ("force", "s * log(s) * y", ""),
        ("force", "where(y < 1 / s, y, 0)", ""),
        ("energy", "s * y", "y**2 / (2 * s)"),
    ],
)
def test_where_a_parameter_is_neutral_or_begins_the_effect_has_values(stated, part, force, energy):
    text = f"""
    id = "soft"
    title = "A soft one"
    looks_like = "a kink"
    force = "{force}"
    {f'energy = "{energy}"' if energy else ""}
    parameters = [{{ symbol = "s", unit = "mm/N", meaning = "softness", %s }}]
    """
    with pytest.raises(
        UserError, match=f"'soft': parameters, s, (neutral|start): got 0, where the {part} has no value"
    ):
        declared(text % stated)
    declared(text % "start = 1")


@pytest.mark.parametrize(("column", "name"), [("Öldruck bar", "Öldruck_bar"), ("µ_x", "µ_x"), ("p-oil", "p_oil")])
def test_columns_of_other_scripts_stand_in_expressions(column, name):
    """Letters beyond ASCII had been refused there, and the column had no other name; µ is read as μ."""
    text = GOOD.replace('force = "k_b', f'conditions = ["{column}"]\nforce = "{name} / 2 * k_b')
    assert condition_symbol(column) in effect_of(declared(text)).force.free_symbols
    with pytest.raises(UserError, match=r"force, character 5: name 'Drück'"):
        declared(text.replace(f"{name} / 2", f"1 * Drück * {name}"))


def test_a_choice_that_has_a_value_there_is_read():
    declared(
        GOOD.replace("k_b * max(y - y_b, 0)", "where(k_b > 0, y / k_b, 0) + sqrt(k_b) * y_b").replace(
            "lower = 0", "lower = 0, neutral = 0"
        )
    )


def test_an_id_of_the_catalogue_is_refused(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(GOOD.replace('"stop"', '"viscous"'), encoding="utf-8")
    with pytest.raises(UserError, match="effect of the catalogue"):
        read_declaration(path)


def test_paths_stand_in_place_of_names(tmp_path):
    (tmp_path / "one.toml").write_text(GOOD, encoding="utf-8")
    (tmp_path / "two.toml").write_text(GOOD.replace("a kink", "another kink"), encoding="utf-8")
    names, declarations = read_effects(["memory", str(tmp_path / "one.toml")], [tmp_path / "one.toml"])
    assert names == ("memory", "stop")
    assert [declaration.id for declaration in declarations] == ["stop"]
    with pytest.raises(UserError, match="declared twice"):
        read_effects([str(tmp_path / "one.toml")], [tmp_path / "two.toml"])
    with pytest.raises(UserError, match=r"none\.toml: no such file"):
        read_effects([str(tmp_path / "none.toml")], [])


def test_equal_declarations_are_one():
    one, same = declared(GOOD), declared(GOOD)
    assert merged((one,), (same,)) == (one,)
    assert effect_of(one) is effect_of(same)
    assert pickle.loads(pickle.dumps(one)) == one
    first, second = (Structure(effects=("stop",), declared=(entry,)) for entry in (one, same))
    assert first.equations is second.equations


def test_a_symbol_of_the_law_is_refused():
    clash = declared(GOOD.replace("k_b", "k10"))
    with pytest.raises(UserError, match="'linear_stiffness' and 'stop' both use the symbol k10"):
        _ = Structure(effects=("stop",), declared=(clash,)).equations


def test_a_second_effect_in_series_is_refused():
    second = declared(GOOD.replace('force = "k_b * max(y - y_b, 0)"', 'path = "k_b * max(y - y_b, 0)"'))
    with pytest.raises(UserError, match="'gap' and 'stop' both stand in series"):
        _ = Structure(effects=("gap", "stop"), declared=(second,)).equations


def law_with(declaration: Declaration) -> dict:
    """The bundled law's file with an effect that the reader has to find in the file itself."""
    content = json.loads(law_text(open_law("emwm2")))
    base = Structure(content["base"]).equations.names
    content["coefficients"] = {name: content["coefficients"][name] for name in base}
    content["effects"] = [declaration.id]
    content["declared"] = [declaration.model_dump(mode="json", exclude_none=True)]
    for table in declaration.parameters:
        content["coefficients"][table.symbol] = {"value": 0.5, "unit": table.unit, "state": "fitted"}
    return content


@pytest.mark.parametrize("path", sorted(DECLARED_EFFECTS.glob("*.toml")), ids=lambda path: path.stem)
def test_a_law_file_travels_alone(path):
    file = parse_law(json.dumps(law_with(read_declaration(path))), "alone")
    assert file.declared == (read_declaration(path),)
    again = parse_law(law_text(file), "again")
    assert again == file
    assert law_of(again).structure.equations is law_of(file).structure.equations


def test_reading_a_law_executes_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    content = law_with(declared(GOOD))
    for force in ("__import__('pathlib').Path('made').touch()", "k_b*y_b*(9**9**9)", "k_b * y_b.__class__"):
        content["declared"][0]["force"] = force
        with pytest.raises(UserError, match="effect 'stop', force, character"):
            parse_law(json.dumps(content), "hostile")
    assert not list(tmp_path.iterdir())


def test_a_second_effect_of_the_same_symbols_is_no_partner():
    """A pair of candidates is fitted only where the two can stand in one law."""
    copy = read_declaration(DECLARED_EFFECTS / "contact_growth_copy.toml")
    with_copy = Structure(effects=(copy.id,), declared=(copy,))
    assert not fits_beside(with_copy, "contact_growth")
    assert fits_beside(with_copy, "viscous")


@pytest.mark.parametrize("write", [c_source, python_source])
def test_what_is_derived_of_expressions_has_a_bound_of_time(write, monkeypatch):
    def forever(structure):
        while True:
            pass

    monkeypatch.setattr(bounded, "MOST_SECONDS_DERIVING", 0.2)
    monkeypatch.setattr(sys.modules[write.__module__], "stepping", forever)
    monkeypatch.setenv(FOLDER_VARIABLE, "")  # what was kept isn't derived
    with pytest.raises(UserError, match=r"more than 0\.2 s to be worked out"):
        write(law_of(open_law("emwm2")).structure)
