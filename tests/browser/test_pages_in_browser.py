"""Pages in a real browser: any run is picked by mouse or key, laws are switched, and nobody is shut out; no network."""

from __future__ import annotations

import pytest
from exports import loop
from few_effects import few_effects

import pipeclamp as pc
from pipeclamp.pages.page import write_report
from pipeclamp.pages.sections import comparison_page, diagnosis_page
from pipeclamp_identification.campaign.bundled import bundled_campaign
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.writing import WrittenRun, write_campaign
from pipeclamp_identification.workflow.change import add_effect
from pipeclamp_identification.workflow.on_records import RecordTests
from pipeclamp_models.law.file import Provenance

PICTURE = ".chosen .main-svg"
SOME = (
    "damping_temperature", "memory", "relaxation", "relaxation_temperature", "displacement_friction",
    "exponential_stiffening", "unilateral_contact", "asymmetry", "bouc_wen", "delay",
)  # fmt: skip
"""Effects of all kinds, with the longest names."""


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Pages of a diagnosis, and of the law with the effect that it names."""
    folder = tmp_path_factory.mktemp("pages")
    tests = RecordTests(read_campaign(bundled_campaign("clamp_a")))
    law = tests.identify().file(name="law", provenance=Provenance("test"))
    with few_effects(*SOME):
        found = tests.diagnose(law)
    write_report(folder / "diagnosis.html", "Diagnosis", "clamp_a", diagnosis_page(law, found, "pipeclamp add"), "test")
    better = add_effect(law, found.effects[0], tests, provenance=Provenance("test")).after
    write_report(folder / "compare.html", "Law", "clamp_a", comparison_page([(better, tests.compare(better))]), "test")
    named = [one.model_copy(update={"name": f"the_{which}_law_of_clamp_seven_at_the_new_rig_beside_the_pump"})
             for one, which in ((law, "first"), (better, "second"))]  # fmt: skip
    command = "pipeclamp diagnose the_second_law.json a_campaign --auto the_third_law.json --report diagnosis.html"
    laws = comparison_page([(one, tests.compare(one)) for one in named], command)
    write_report(folder / "laws.html", "Laws", "clamp_a", laws, "test")
    return folder


def open_page(page, path):
    page.context.set_offline(True)
    page.goto(path.as_uri())
    page.wait_for_selector(PICTURE)


@pytest.mark.parametrize("name", ["diagnosis", "compare"])
@pytest.mark.parametrize("look", ["light", "dark"])
def test_everybody_can_read_it(pages, page, violations, name, look):
    path = pages / f"{name}.html"
    assert path.stat().st_size < 2.5e6
    page.emulate_media(color_scheme=look)
    open_page(page, path)
    assert violations(page) == []
    page.set_viewport_size({"width": 420, "height": 900})
    page.wait_for_timeout(300)
    assert page.evaluate("document.documentElement.scrollWidth") <= 420


def test_a_run_is_picked_and_laws_are_switched(pages, page):
    open_page(page, pages / "compare.html")
    traces = "document.querySelector('.chosen').data.map((trace) => trace.name)"
    assert page.evaluate(traces).count("+ damping_temperature") == 2, "the loop, and the difference"
    before = page.text_content(".chosen .gtitle")
    cell = page.locator(".map").last.locator("button").first
    cell.focus()
    page.keyboard.press("Enter")
    assert page.text_content(".chosen .gtitle") != before
    assert page.locator(".map").last.locator("button[aria-pressed=true]").count() == 1
    page.get_by_label("power:").uncheck()
    assert "power" not in page.evaluate(traces)
    assert page.locator(".map").count() == 1
    page.get_by_label("phase").check()
    assert page.evaluate("document.querySelector('.chosen').layout.xaxis.range") == [0, 360]
    page.get_by_label("measured less law").check()
    assert page.locator(".map svg path").count() == 12
    page.select_option("select >> nth=0", "0,1")
    assert page.locator(".map button").count() == 12


def test_it_prints_in_the_light_look(pages, page, tmp_path):
    page.emulate_media(color_scheme="dark")
    open_page(page, pages / "compare.html")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert page.evaluate("document.querySelector('.chosen').layout.paper_bgcolor") == "white"
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert page.evaluate("document.querySelector('.chosen').layout.paper_bgcolor") == "#161b22"
    assert len(page.pdf()) > 50_000
    page.emulate_media(media="print")
    short = "[...document.querySelectorAll('.maps table, .table:not(.long)')]"
    assert set(page.evaluate(f"{short}.map(each => getComputedStyle(each).breakInside)")) == {"avoid"}, (
        "no page's end cuts a map or a short table"
    )


@pytest.mark.parametrize("width", [420, 500, 1300])
def test_no_title_stands_below_the_buttons_that_save_a_picture(pages, page, width):
    page.set_viewport_size({"width": width, "height": 900})
    open_page(page, pages / "diagnosis.html")
    box = "const box = (one, name) => one.querySelector(name).getBoundingClientRect()"
    crossed = "(title, bar) => title.right > bar.left && title.left < bar.right && title.bottom > bar.top"
    drawn = "[...document.querySelectorAll('.picture, .chosen')].filter((one) => one.querySelector('.gtitle'))"
    named = f"({drawn}).filter((one) => ({crossed})(box(one, '.gtitle'), box(one, '.modebar-group')))"
    assert page.evaluate(f"{drawn}.length") > 8
    assert page.evaluate(f"(() => {{ {box}; return {named}.map((one) => one.textContent.slice(0, 60)); }})()") == []


def test_in_a_narrow_window_the_falling_error_is_whole_and_what_goes_on_fades(pages, page):
    page.set_viewport_size({"width": 420, "height": 900})
    open_page(page, pages / "compare.html")
    bars = page.locator("#section-1 .picture .bars .point path")
    assert bars.count() == 4, "two errors before the effect, and two with it"
    assert all(box["x"] >= 0 and box["x"] + box["width"] <= 420 for box in (bar.bounding_box() for bar in bars.all()))
    texts = page.locator("#section-1 .picture .bartext")
    assert all(box["x"] + box["width"] <= 420 for box in (text.bounding_box() for text in texts.all()))
    cut = (
        "[...document.querySelectorAll('figure, .table, .maps')].filter((one) => one.scrollWidth > one.clientWidth + 4)"
    )
    assert page.evaluate(f"{cut}.length") > 0
    assert page.evaluate(f"{cut}.every((one) => one.classList.contains('more') && one.tabIndex === 0)")
    faded = "[...document.querySelectorAll('figure.more')].map((one) => [one, one.querySelector('.gtitle')])"
    room = f"{faded}.map(([one, title]) => one.getBoundingClientRect().right - title.getBoundingClientRect().right)"
    assert page.evaluate(f"{room}.length") > 0
    assert page.evaluate(f"{room}.every((left) => left >= 48)"), "titles end where the picture begins to fade"
    entries = "[...document.querySelectorAll('figure.more .legendtext')].map((one) => one.getBoundingClientRect())"
    assert page.evaluate(f"{entries}.length") > 4
    seen = "({ left, right }) => left >= 16 && right <= 420 - 16 - 48"
    assert page.evaluate(f"{entries}.every({seen})"), "and so do legends' entries"
    left = "[...document.querySelectorAll('figure.more .picture')].map((one) => one._fullLayout._size.l)"
    assert max(page.evaluate(left)) < 100, "a legend takes no width from its picture"
    page.set_viewport_size({"width": 1300, "height": 900})
    page.wait_for_function("document.querySelector('#section-1 .picture').layout.yaxis.title?.text?.startsWith('RMS')")


def test_what_is_wrapped_in_a_narrow_window_cuts_no_picture(pages, page):
    """A title of three lines had pushed the axis' title, a legend's second line itself, below the picture's end."""
    page.set_viewport_size({"width": 480, "height": 900})
    open_page(page, pages / "diagnosis.html")
    room = """[...document.querySelectorAll('.picture')].map((one) => [
        one.querySelector('.gtitle')?.textContent.slice(0, 40),
        one.clientHeight - one.querySelector('.main-svg').getBoundingClientRect().height])"""
    found = page.evaluate(room)
    assert len(found) > 8
    assert [name for name, height in found if height < 0] == []


def test_what_a_map_means_is_whole_where_the_map_goes_on(pages, page):
    page.set_viewport_size({"width": 320, "height": 900})
    open_page(page, pages / "compare.html")
    page.get_by_label("loops").check()
    page.wait_for_function("document.querySelector('.maps').scrollWidth > document.querySelector('.maps').clientWidth")
    meaning = page.get_by_text("Each loop on its own scale")
    assert meaning.evaluate("(one) => one.closest('.maps, .more') === null")
    box = meaning.bounding_box()
    assert box["x"] >= 0
    assert box["x"] + box["width"] <= 320


def test_long_names_are_whole_in_a_narrow_window_and_commands_break_between_words(pages, page):
    """Names of laws had been cut in legends and made the page wider; "--auto" had been broken into "--" and "auto"."""
    page.set_viewport_size({"width": 420, "height": 900})
    open_page(page, pages / "laws.html")
    page.wait_for_timeout(300)
    assert page.evaluate("document.documentElement.scrollWidth") <= 420
    inside = """() => [...document.querySelectorAll('.chosen .legendtext')].map((text) =>
        text.getBoundingClientRect().right <= text.closest('.main-svg').getBoundingClientRect().right)"""
    assert page.evaluate(inside) and all(page.evaluate(inside))
    whole = "[...document.querySelectorAll('.chosen .legendtext')].map((text) => text.textContent).join(' ')"
    assert "the_first_law_of_clamp_seven_at_the_new_rig_beside_the_pump" in page.evaluate(whole).replace(" ", "")
    lines = "[...document.querySelectorAll('.command .word')].map((word) => word.getClientRects().length)"
    assert page.evaluate(lines) == [1] * 8
    assert page.inner_text(".command code").split() == page.text_content(".command code").split()
    assert page.text_content(".command code").endswith(" --auto the_third_law.json --report diagnosis.html")


def test_the_turns_of_a_loop_are_seen_whole(pages, page):
    """They had lain on the picture's edge, half of the line cut off."""
    open_page(page, pages / "compare.html")
    ends = page.evaluate("""() => {
        const { data, layout } = document.querySelector('.chosen');
        return [layout.xaxis.range, [Math.min(...data[0].x), Math.max(...data[0].x)]];
    }""")
    (low, high), (first, last) = ends
    assert low < first - 0.01 * (last - first) and high > last + 0.01 * (last - first)


@pytest.mark.parametrize(("cycles", "shown"), [(1, "error"), (2, "error over scatter")])
def test_what_the_map_shows_is_over_scatter_only_where_cycles_show_any(page, tmp_path, cycles, shown):
    runs = [
        WrittenRun({"run": f"A{one.amplitude}_f{one.frequency:g}"}, Record(one.time, one.y, one.force))
        for one in (loop(a, f, cycles=cycles) for a in (0.3, 0.6, 0.9) for f in (1.0, 2.0))
    ]
    write_campaign(tmp_path / "c", iter(runs), name="c", notes="")
    tests = pc.read_campaign(tmp_path / "c")
    pc.compare(pc.identify(tests), tests).report(tmp_path / "compare.html")
    open_page(page, tmp_path / "compare.html")
    assert page.get_by_label(shown, exact=True).is_checked()
