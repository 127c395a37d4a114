"""The equations of all effects on the site's own pages, in a window as wide as a telephone: none has to be scrolled."""

from __future__ import annotations

import sys

import pytest
from project import BUILD_SCRIPTS, ROOT

from pipeclamp_models.law.catalogue import listed

pytest.importorskip("furo", reason="needs the extra docs")
pytest.importorskip("latex2mathml", reason="needs the extra docs")
pytest.importorskip("matplotlib", reason="needs the extra docs")
pytest.importorskip("myst_parser", reason="needs the extra docs")
sys.path.append(str(BUILD_SCRIPTS / "site"))
from effect_pages import page as effect_page  # type: ignore[import-not-found]
from sphinx.application import Sphinx

STYLES = ROOT / "docs" / "_static"
EFFECTS = [effect.id for effect in listed()]
WIDTH = 420
SETTINGS = {
    "extensions": ["myst_parser", "mathml"],
    "html_css_files": ["site.css"],
    "html_math_renderer": "mathml",
    "html_static_path": [str(STYLES)],
    "html_theme": "furo",
    "master_doc": EFFECTS[0],
    "myst_enable_extensions": ["dollarmath"],
}
CUT = "[...document.querySelectorAll('.formula')].filter((one) => one.scrollWidth > one.clientWidth)"


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The effects' pages, built as the site is, without their pictures."""
    folder = tmp_path_factory.mktemp("site")
    for effect in listed():
        (folder / f"{effect.id}.md").write_text(effect_page(effect, "", 1), encoding="utf-8")
    built = folder / "built"
    Sphinx(folder, None, built, folder / "doctrees", "html", confoverrides=SETTINGS, status=None, warning=None).build()
    return built


def test_no_equation_has_to_be_scrolled(site, page):
    page.set_viewport_size({"width": WIDTH, "height": 900})
    cut, wide = {}, []
    for effect in EFFECTS:
        page.goto((site / f"{effect}.html").as_uri())
        page.wait_for_function("document.fonts.ready.then(() => document.fonts.check('16px \"STIX Two Math\"'))")
        assert page.locator(".formula").count() > 0
        if found := page.evaluate(f"{CUT}.map((one) => one.querySelector('math').getAttribute('alttext'))"):
            cut[effect] = found
        if page.evaluate("document.documentElement.scrollWidth") > WIDTH:
            wide.append(effect)
    assert (cut, wide) == ({}, [])
