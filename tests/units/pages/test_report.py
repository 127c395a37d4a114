"""Reports: one file that needs nothing from outside, and that says what was given, whatever it is."""

from __future__ import annotations

import re
from html import unescape
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest

from pipeclamp.pages.alternative import words_of
from pipeclamp.pages.error_pictures import ConditionsMap, conditions_picture
from pipeclamp.pages.page import MOST_ROWS, Section, render, specification_of, write_report
from pipeclamp.pages.pictures import (
    LoopPanel,
    curves_picture,
    loops_picture,
    overlay_picture,
    surface_picture,
    thinned,
)
from pipeclamp.pages.waterfall import LEFT_OUT, RungBars, waterfall_picture
from pipeclamp.show.law import coefficient_table, doubts
from pipeclamp.show.table import Table, cell
from pipeclamp_models.base.errors import UsageError, UserError
from pipeclamp_models.base.units import celsius_of, unit_shown
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import FitQuality
from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.reading.text import law_statements

THETA = np.linspace(0, 2 * np.pi, 64, endpoint=False)
PANEL = LoopPanel("run", np.cos(THETA), np.sin(THETA), None)
CELLS = np.array([[[1.0], [np.nan]]])
FIGURES = [
    loops_picture([PANEL] * 5, "loops"),
    overlay_picture([("one", np.cos(THETA), np.sin(THETA))] * 2, "overlay"),
    curves_picture("x", "y", [("a", [1, 2], [3, 4], "lines"), ("published a", [1], [2], "markers")], "curves"),
    surface_picture("x", "y", np.arange(4.0), np.arange(3.0), np.ones((3, 4)), "z", "surface"),
    conditions_picture(
        ConditionsMap(["0.2", "0.5"], ["1"], ["20 °C"], np.array([[[1.0], [np.nan]]]), np.full((1, 2, 1), np.nan)),
        "map",
    ),
    waterfall_picture([RungBars("base", {LEFT_OUT: 0.03}), RungBars("+ memory", {LEFT_OUT: 0.01})], 0.005, "falling"),
]


class Outside(HTMLParser):
    """Collects what a page would fetch, and its balance of tags."""

    def __init__(self) -> None:
        super().__init__()
        self.fetched: list[str] = []
        self.depth = 0

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("src", "href", "srcset", "data", "action") and value and not value.startswith("#"):
                self.fetched.append(f"{tag} {name}={value}")
        self.depth += tag == "div"

    def handle_endtag(self, tag):
        self.depth -= tag == "div"


@pytest.fixture(scope="module")
def page():
    sections = [
        Section("One", ["words"], [Table(("a", "b"), [(1.23456789, None), ("text", 2.0)], "caption")], FIGURES),
        Section("Two"),
    ]
    return render("Title", "subtitle", sections)


def test_nothing_is_fetched(page):
    parser = Outside()
    parser.feed(page)
    assert parser.fetched == []
    assert parser.depth == 0
    styles = "".join(re.findall(r"<style>(.*?)</style>", page, re.S))
    assert "url(" not in styles
    assert "@import" not in styles
    assert "plotly.js (cartesian" in page, "the script must be inside"


def test_every_picture_and_table_is_there(page):
    for column in range(len(FIGURES)):
        assert words_of(FIGURES[column]) in unescape(page)
    assert "<caption><span>caption</span></caption>" in page
    assert "1.235" in page
    assert "1.23456789" not in page


def test_text_is_text():
    nasty = "<script>alert('x')</script> & \"quotes\" {{ 7*7 }}"
    page = render(nasty, nasty, [Section(nasty, [nasty], [Table((nasty,), [(nasty,)], nasty)])])
    assert "<script>alert" not in page
    assert "{{ 7*7 }}" in page
    assert page.count("&lt;script&gt;") >= 6


def test_without_pictures_nothing_is_drawn():
    assert "plotly.js (cartesian" not in render("Title", "", [Section("One", ["words"])])


def test_a_picture_is_told_in_words():
    assert words_of(FIGURES[-1]) == (
        "falling. on left-out conditions, bars, RMS error / % of rms force: base 3, "
        "+ memory squared error above scatter \N{MINUS SIGN}91% 1."
    )


def test_a_report_is_a_page(tmp_path):
    with pytest.raises(UsageError, match=r"report\.pdf: .*\.html"):
        write_report(tmp_path / "report.pdf", "", "", [])


def test_the_same_content_gives_the_same_page():
    sections = [Section("One", (), (), FIGURES)]
    assert render("a", "b", sections) == render("a", "b", sections)


@pytest.mark.parametrize(
    ("value", "text"), [(None, "–"), ("x", "x"), (0.000123456, "0.0001235"), (28000.4, "28000"), (1e7, "1e+07")]
)
def test_cells(value, text):
    assert cell(value) == text


def test_a_report_that_cannot_be_written_says_where(tmp_path):
    with pytest.raises(UserError, match="nowhere"):
        write_report(tmp_path / "nowhere" / "r.html", "", "", [])


def test_wide_pictures_scroll_in_a_narrow_window(page):
    widths = [int(width) for width in re.findall(r'style="min-width: (\d+)px"', page)]
    assert len(widths) == len(FIGURES)
    assert max(widths) > 0
    assert widths[0] == widths[1] == 0, "loops stand below each other there"


def test_loops_stand_below_each_other_in_a_narrow_window_and_their_data_once_on_the_page():
    drawn = specification_of(FIGURES[0])
    narrow = drawn["narrow"]
    assert "data" not in narrow and len(drawn["data"]) == 5
    axes = [f"xaxis{number or ''}" for number in (0, 2, 3, 4, 5)]
    assert {tuple(narrow["layout"][axis]["domain"]) for axis in axes} == {(0.0, 1.0)}
    assert len({tuple(drawn["layout"][axis]["domain"]) for axis in axes}) == 4


def test_memory_that_does_not_settle_is_said() -> None:
    law = open_law("emwm2")
    fit = FitQuality(method="joint", nrmse=0.01, unsettled=3)
    assert any(line.startswith("On 3 of the cycles") for line in doubts(law.model_copy(update={"fit": fit})))
    assert not any("periodic" in line for line in doubts(law))


def test_only_a_long_table_scrolls_within_a_box():
    for count, boxed in ((MOST_ROWS, False), (MOST_ROWS + 1, True)):
        page = render("title", "", [Section("runs", (), [Table(("run",), [("a",)] * count)])])
        assert ('<div class="table long"' in page) == boxed


def test_every_parameter_has_its_meaning():
    """Also where a file, by hand, leaves it out."""
    file = open_law("emwm2")
    bare = {name: entry.model_copy(update={"meaning": "", "reason": ""}) for name, entry in file.coefficients.items()}
    table = coefficient_table(file.model_copy(update={"coefficients": bare}))
    assert all(row[-1] for row in table.rows)


def test_a_long_history_is_drawn_from_its_beginning_to_its_end_with_its_peaks():
    time = np.linspace(0.0, 60.0, 50_000)
    values = np.sin(2 * np.pi * 83.0 * time)
    values[12_345], values[40_001] = 3.0, -2.0
    shown, drawn = thinned(time, values)
    assert len(shown) < 5000
    assert (shown[0], shown[-1]) == (0.0, 60.0)
    assert {3.0, -2.0} <= set(drawn.tolist())
    assert np.all(np.isin(np.stack([shown, drawn], axis=1), np.stack([time, values], axis=1)))
    # a sample out of thirteen would show another frequency, and every second stretch would miss its peaks
    ten_ms = (shown > 20.0) & (shown < 20.1)
    assert np.ptp(drawn[ten_ms]) > 1.9


def test_the_page_of_a_law_says_what_its_equations_hold_beside_parameters():
    from pipeclamp.pages.law import law_sections

    (*_, words) = law_sections(open_law("emwm2"))[0].paragraphs
    assert words.startswith("Here ") and "T_0 = 293.15 K (reference temperature)" in words
    assert "mm/s (velocity below which sgn v is smooth)" in words and "rho_0" not in words


def test_a_law_s_equations_are_set_without_a_script_or_a_network():
    """Each coefficient of a law with memory, behind clearance, and one whose arm has stages."""
    from pipeclamp.pages.law import law_sections

    law = open_law("emwm2")
    section = law_sections(law)[0]
    words = [one.words for one in section.formulas]
    assert words == ["force, N", "k1, N/mm", "k3, N/mm³", "c, N", "alpha"]
    page = render("law", "", [section])
    assert page.count("<math ") == len(words) and "<mfrac>" in page
    assert not re.search(r"<(script|link|img)[^>]*(src|href)=", page)
    assert "k10 (A/A_0)" not in page


@pytest.mark.parametrize(
    "effects", [("memory:2",), ("play",), ("relaxation", "relaxation_temperature"), ("oil_damper",)]
)
def test_every_statement_of_a_law_becomes_mathml(effects):
    for one in law_statements(Structure("power", effects).equations.composed):
        root = ElementTree.fromstring(one.mathml)
        assert root.get("alttext") == one.latex
        assert not [text for text in root.itertext() if "\\" in text], "LaTeX that wasn't turned"


@pytest.mark.parametrize(
    ("unit", "shown"),
    [("N/mm3", "N/mm³"), ("N s10/mm10", "N s¹⁰/mm¹⁰"), ("g/cm^3", "g/cm³"), ("degC", "°C"), ("1/K", "1/K"), ("-", "-")],
)
def test_a_unit_is_read_as_people_write_it(unit, shown):
    assert unit_shown(unit) == shown


@pytest.mark.parametrize("celsius", [63.3, 20.0, -40.1, 300.7])
def test_a_temperature_in_kelvin_comes_back_in_celsius_without_loose_bits(celsius):
    assert celsius_of(celsius + 273.15) == celsius
