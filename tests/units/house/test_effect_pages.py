"""The pages of effects on the site: made from effects alone, with links that hold and pictures that show the effect."""

from __future__ import annotations

import re
import sys

import numpy as np
import pytest
from project import BUILD_SCRIPTS

from pipeclamp_models.base.units import unit_shown
from pipeclamp_models.law.catalogue import find_effect, listed
from pipeclamp_models.realise.effect_loops import SEEN_SHARE, loops_with_and_without

pytest.importorskip("matplotlib", reason="needs the extra docs")
pytest.importorskip("sphinx", reason="needs the extra docs")
sys.path.append(str(BUILD_SCRIPTS / "site"))
from effect_loops import draw  # type: ignore[import-not-found]
from effect_pages import page  # type: ignore[import-not-found]

EFFECTS = listed()


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.id)
def test_a_page_tells_all_that_the_effect_states(effect):
    text = page(effect, f"{effect.id}.svg", 5)
    assert text.startswith(f"# {effect.id}\n")
    links = re.findall(r"\]\((\w+)\.md\)", text)
    assert tuple(links) == effect.imitated_by
    assert set(links) <= {one.id for one in EFFECTS}
    for words in (effect.looks_like, effect.told_apart_by, "drawn 5 times"):
        assert words in text
    for parameter in effect.parameters:
        assert f"| `{parameter.name}` | {unit_shown(parameter.unit)} | {parameter.meaning}" in text.replace("\\|", "|")
    for stage in effect.stages:
        assert f"\n{stage.symbol}, {stage.meaning}:\n" in text
    assert text.count("$$") >= 2


def test_a_doi_is_a_link():
    assert "[doi 10.3390/sym12081283](https://doi.org/10.3390/sym12081283)" in page(find_effect("memory"), "m.svg", 1)


@pytest.mark.parametrize(
    "name", ["memory", "delay", "contact_growth", "offset", "condition:u", "power_damping", "density"]
)
def test_a_picture_shows_the_effect(name):
    loops = loops_with_and_without(find_effect(name))
    difference = np.max(np.abs(loops.with_it - loops.without)) / np.max(np.abs(loops.without))
    assert difference > SEEN_SHARE / 2
    assert np.isfinite(loops.with_it).all()


def test_slip_that_is_pressed_is_drawn_where_it_is_pressed_more_and_less():
    """Small cycles about several means: the loop that the effect adds is the wider the further out it is."""
    loops = loops_with_and_without(find_effect("pressed_slip"))
    widths = [
        abs(np.trapezoid(np.append(loop, loop[0]), np.append(y, y[0])))
        for loop, y in zip(loops.with_it - loops.without, loops.displacement, strict=True)
    ]
    assert min(widths[0], widths[2]) > 1.5 * widths[1]


def test_a_difference_is_as_many_times_as_large_as_is_said():
    """An offset is the same at every place: what is drawn is its typical size so many times over."""
    loops = loops_with_and_without(find_effect("offset"))
    drawn = loops.with_it - loops.without
    assert loops.times > 1
    np.testing.assert_allclose(drawn, drawn[0, 0], rtol=1e-9)
    assert drawn[0, 0] / loops.times == pytest.approx(0.02 * np.median(np.ptp(loops.without, axis=1) / 2), rel=0.3)


def test_the_same_effect_gives_the_same_picture(tmp_path):
    for name in ("one.svg", "two.svg"):
        draw(find_effect("coulomb"), tmp_path / name)
    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "two.svg").read_bytes()
