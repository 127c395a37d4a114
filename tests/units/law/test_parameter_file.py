"""The parameter file: what is written reads back the same, what can't be a law is refused with its place."""

from __future__ import annotations

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeclamp_identification.workflow.schemas import schema_text
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.bundled import bundled_laws, open_law
from pipeclamp_models.law.file import LawFile, law_of, law_text, parse_law, read_law, write_law

finite = st.floats(allow_nan=False, allow_infinity=False)


@pytest.mark.parametrize("name", bundled_laws())
def test_a_law_reads_back_the_same(name, tmp_path):
    file = open_law(name)
    write_law(file, tmp_path / "law.json")
    assert read_law(tmp_path / "law.json") == file
    assert law_text(read_law(tmp_path / "law.json")) == law_text(file)


@settings(max_examples=60, deadline=None)
@given(value=finite, error=st.floats(0, 1e300) | st.none(), notes=st.text(), minimum=finite, width=st.floats(0, 1e9))
def test_any_finite_value_and_any_text_reads_back(value, error, notes, minimum, width):
    content = json.loads(law_text(open_law("emwm2")))
    content["coefficients"]["k10"] |= {"value": value, "standard_error": error}
    content["notes"] = notes
    content["range"]["u_current_A"] = {"minimum": minimum, "maximum": max(minimum + width, minimum), "unit": "A"}
    file = LawFile.model_validate(content)
    again = parse_law(law_text(file), "again")
    assert again == file
    assert again.coefficients["k10"].value == value
    assert law_of(again).values["k10"] == value


def test_the_text_is_whole_lines_in_one_order():
    file = open_law("emwm2")
    text = law_text(file)
    assert text.endswith("}\n")
    assert text == law_text(LawFile.model_validate(json.loads(text)))
    assert list(json.loads(text))[:3] == ["schema", "name", "notes"]


def test_the_schema_says_what_is_needed():
    schema = json.loads(schema_text("law"))
    assert {"schema", "base", "coefficients", "range", "data", "software", "command"} <= set(schema["required"])
    assert schema["additionalProperties"] is False


AT_REST = {
    "A": {"minimum": 0.0, "maximum": 1.0, "unit": "mm"},
    "f": {"minimum": 1.0, "maximum": 9.0, "unit": "Hz"},
}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"schema": "pipeclamp-law-2"}, ["schema", "pipeclamp-law-1"]),
        ({"colour": "red"}, ["colour"]),
        ({"range": {"A": {"minimum": 0.2, "maximum": 1.0, "unit": "mm"}}}, ["range lacks f"]),
        ({"range": {"A": {"minimum": 2.0, "maximum": 1.0, "unit": "mm"}}}, ["range.A", "above maximum"]),
        ({"range": AT_REST}, ["range.A", "minimum 0 mm", "above 0"]),
        ({"smoothing": {"v_r": 0.1}}, ["smoothing lacks y_r"]),
        ({"smoothing": {"v_r": -0.1, "y_r": 0.1}}, ["smoothing.v_r"]),
        ({"covariance": {"names": ["a", "b"], "matrix": [[1.0]]}}, ["covariance", "2 x 2"]),
        ({"coefficients": {}}, ["missing", "k10"]),
        ({"effects": ["coulomb"]}, ["F_c"]),
        ({"effects": ["colomb"]}, ["here.json", "'colomb' is not in the catalogue", "coulomb"]),
        ({"base": "series:3"}, ["series:3", "expected one of"]),
    ],
)
def test_what_cannot_be_a_law_is_refused_with_its_place(change, words):
    content = json.loads(law_text(open_law("emwm2"))) | change
    with pytest.raises(UserError) as refused:
        parse_law(json.dumps(content), "here.json")
    for word in words:
        assert word in str(refused.value)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "[]",
        "null",
        '"law"',
        "{}",
        '{"schema": NaN}',
        "\ud800".encode("utf-8", "surrogatepass").decode("latin-1"),
    ],
)
def test_what_is_no_file_of_the_schema_names_the_file(text):
    with pytest.raises(UserError, match="here"):
        parse_law(text, "here.json")


def test_held_parameters_stay_held():
    content = json.loads(law_text(open_law("emwm2")))
    content["coefficients"]["k1_T"]["state"] = "held"
    law = law_of(parse_law(json.dumps(content), "held"))
    assert law.structure.held()["k1_T"] == content["coefficients"]["k1_T"]["value"]


def test_a_law_is_opened_by_name_or_by_path(tmp_path):
    assert open_law("emwm2").name == "emwm2"
    with pytest.raises(UserError, match="did you mean 'published_R1'"):
        open_law("publishd_R1")
    with pytest.raises(UserError, match="no such file; expected a law"):
        open_law(str(tmp_path / "none.json"))
    with pytest.raises(UserError, match="is a folder; expected a law"):
        open_law(str(tmp_path))


@pytest.mark.parametrize(("name", "unit"), [("A", "m"), ("f", "kHz"), ("T", "degC")])
def test_a_range_in_another_unit_is_refused(name, unit):
    content = json.loads(law_text(open_law("emwm2")))
    content["range"][name]["unit"] = unit
    with pytest.raises(UserError, match=f"range.{name}: unit '{unit}'; expected"):
        parse_law(json.dumps(content), "law.json")


@pytest.mark.parametrize(
    ("matrix", "words"),
    [
        ([[-1.0, 0.0], [0.0, 1.0]], "-1 as the variance of k10; expected 0 or more"),
        ([[4.0, 7.0], [7.0, 9.0]], "has 7 for c0 and k10; expected 6 at most"),
        ([[4.0, 1.0], [-1.0, 9.0]], "-1 and 1 for c0 and k10; expected the same"),
    ],
)
def test_a_matrix_that_is_no_covariance_is_refused(matrix, words):
    content = json.loads(law_text(open_law("emwm2")))
    content["covariance"] = {"names": ["k10", "c0"], "matrix": matrix}
    with pytest.raises(UserError, match=words):
        parse_law(json.dumps(content), "law.json")
    content["covariance"]["matrix"] = [[4.0, 6.0], [6.0, 9.0]]
    assert parse_law(json.dumps(content), "law.json").covariance is not None
