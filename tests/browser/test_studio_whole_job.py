"""The studio in a real browser: the whole job on the bundled campaign, wide and narrow, with keys alone once.

In a file of its own: another core takes what else is asked of the studio meanwhile.
"""

from __future__ import annotations

import re

import pytest
from studio_in_browser import LOOP, NARROW, A_JOB_ms, no_wider_than_the_window

pytest.importorskip("starlette", reason="needs the extra 'studio'")
pytest.importorskip("uvicorn", reason="needs the extra 'studio'")


def tab_to(page, text):
    """Press Tab until what has the focus says `text`."""
    for _ in range(200):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.textContent.trim()").startswith(text):
            return
    raise AssertionError(f"no way to {text!r} by Tab")


def test_the_whole_job(page, url, violations, home):
    page.goto(url)
    page.wait_for_selector(LOOP)
    assert page.locator(".map .cell").count() == 48
    assert "in the cells: number of runs" in page.inner_text(".axes")
    tall = "box => box.getBoundingClientRect().height"
    assert page.locator("#loop .nsewdrag").first.evaluate(tall) > 400, "no law, no difference: the loop has the room"
    assert violations(page) == []

    tab_to(page, "Fit the law")  # the first step with keys alone
    page.keyboard.press("Enter")
    page.wait_for_selector("text=Find what is missing", timeout=A_JOB_ms)
    page.wait_for_selector(LOOP)
    assert page.inner_text(".big") == "2.55%"

    page.locator(".map .cell").nth(4).focus()
    page.keyboard.press("ArrowRight")
    (run,) = {page.evaluate("document.activeElement.dataset.runs")}
    page.wait_for_function("run => document.getElementById('run-title').textContent === run", arg=run)
    assert f"run={run}" in page.url

    page.click("text=Find what is missing")
    page.wait_for_selector(".job progress")
    page.locator(".map .cell").nth(0).click()  # it answers while the diagnosis runs
    page.wait_for_function("document.getElementById('run-title').textContent !== ''")
    page.wait_for_selector("#candidates", timeout=A_JOB_ms)
    assert page.inner_text("#answer-title") == "Missing: damping_temperature."
    assert "with memory:2 beside it" in page.inner_text(".answer"), "two are missing, as the terminal says"
    page.wait_for_selector(LOOP)
    page.check("input[name=candidate][value=damping_temperature]")
    page.wait_for_selector("#errors :text('law1 + damping_temperature')")
    page.locator("input[data-candidate=damping_temperature]").first.focus()
    page.keyboard.press("PageUp")
    page.wait_for_selector("#errors :text('damping_temperature, moved')")
    assert violations(page) == []

    page.click(".answer button:has-text('Add damping_temperature')")
    page.wait_for_selector(".chip[aria-current]:has-text('law2')", timeout=A_JOB_ms)
    page.wait_for_selector("#waterfall .main-svg")
    assert page.inner_text(".big") == "1.29%"
    assert "above scatter\N{MINUS SIGN}79%" in page.inner_text("#waterfall").replace("\n", "")
    page.wait_for_timeout(1600)  # the map fades
    before = page.evaluate("[...document.querySelectorAll('.cell')].filter(c => c.dataset.before).length")
    assert before == 48
    assert {"law1.json", "law2.json", "law1.diagnosis.json"} <= {path.name for path in home.iterdir()}

    slider = page.locator("input[data-parameter=c_T1]")
    slider.focus()
    for _ in range(3):
        page.keyboard.press("PageUp")
    page.wait_for_selector("#errors :text('moved')")

    page.select_option("#with", "law1")
    page.wait_for_selector("#errors :text('law1')")
    assert page.locator(".map .cell").count() == 96
    page.set_viewport_size(NARROW)
    page.wait_for_timeout(300)
    assert no_wider_than_the_window(page)
    assert page.evaluate("document.querySelector('#loop .main-svg').getBoundingClientRect().height") > 400
    assert violations(page) == []

    other = page.context.new_page()  # another tab has its own law
    other.goto(re.sub(r"/\?.*", "/c/clamp_a/laws/law1", url))
    other.wait_for_selector(LOOP)
    page.reload()
    page.wait_for_selector(LOOP)
    assert (page.inner_text(".big"), other.inner_text(".big")) == ("1.29%", "2.55%")

    page.click("text=Step back to law1")
    page.wait_for_selector(".chip[aria-current]:has-text('law1')")
    page.wait_for_selector(LOOP)
    assert no_wider_than_the_window(page)
