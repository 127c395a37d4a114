"""The studio in a real browser: files, refusals and several effects at once, wide and narrow."""

from __future__ import annotations

import math
import re

import pytest
from project import DATA
from studio_in_browser import LOOP, NARROW, A_JOB_ms, soon_no_wider_than_the_window, studio_of

pytest.importorskip("starlette", reason="needs the extra 'studio'")
pytest.importorskip("uvicorn", reason="needs the extra 'studio'")

import pipeclamp as pc
from pipeclamp.studio.diagnosis_shown import CandidateShown, DiagnosisShown, RungShown, stamp
from pipeclamp_models.law.catalogue import find_effect
from pipeclamp_models.law.file import read_law


def test_what_is_refused_stays_in_view_beside_the_jobs(page, url):
    """A running job tells often what it does: neither it nor why another was refused is lost by that.

    A tab that didn't start it says where the law is, and stays.
    """
    page.goto(url)
    page.goto(re.sub(r"/\?.*", "/c/clamp_a_heldout/", url))
    page.wait_for_selector(LOOP)
    other = page.context.new_page()
    page.evaluate("""async () => {
        const { complain, start } = await import("/static/ask.js");
        // a series takes seconds, in which the other tab opens
        await start("/c/clamp_a_heldout/jobs", { kind: "identify", base: "series" }, "clamp_a_heldout", () => {});
        complain("2 jobs are running");
    }""")
    cancel = page.wait_for_selector(".job.running button")
    other.goto(page.url)
    page.wait_for_selector(".job.running .says:not(:text('starting'))", timeout=A_JOB_ms)
    assert page.is_visible(".job.refused:has-text('2 jobs are running')")
    assert cancel.evaluate("button => button.isConnected"), "a click that takes its time finds the button still there"
    page.wait_for_selector(".job.running", state="detached", timeout=A_JOB_ms)
    page.click(".job.refused >> text=Close")
    assert page.locator(".job").count() == 0
    law = other.get_attribute(".job >> text=Open it", "href")
    assert law.endswith("/c/clamp_a_heldout/laws/law1") and other.inner_text("#answer-title") == "No law yet"
    told = page.evaluate("""async () => {
        const { ask } = await import("/static/ask.js");
        window.fetch = () => Promise.reject(new TypeError("Failed to fetch"));
        return ask("/").catch((error) => error.message);
    }""")
    assert told.startswith("The studio doesn't answer."), "it was killed"


def test_two_effects_are_added_at_once(page, violations, tmp_path):
    """Their names, and what they would do, stay in view in a wide window and in a narrow one."""
    home, both = tmp_path / "home", ("memory", "damping_temperature")
    with studio_of("clamp_a_heldout", home) as url:
        page.goto(url)
        page.click("text=Fit the law")
        page.wait_for_selector("text=Find what is missing", timeout=A_JOB_ms)
        page.wait_for_selector(LOOP)
        told = told_both(read_law(home / "law1.json"), both, pc.identify("clamp_a_heldout", effects=both).values)
        (home / "law1.told.json").write_text(told.json_text(), encoding="utf-8")
        page.reload()
        page.wait_for_selector(LOOP)
        table = page.locator("#candidates .scroll")
        assert table.evaluate("box => box.scrollWidth <= box.clientWidth")
        page.set_viewport_size(NARROW)
        assert soon_no_wider_than_the_window(page)
        assert table.evaluate("box => box.scrollWidth <= box.clientWidth"), "what speaks against it is in view"
        assert violations(page) == []
        add = page.locator(".answer button:has-text('Add memory and damping_temperature')")
        box = add.bounding_box()
        assert box["x"] >= 0 and box["x"] + box["width"] <= NARROW["width"]
        add.click()
        page.wait_for_selector(".chip[aria-current]:has-text('law2 + memory + damping_temperature')", timeout=A_JOB_ms)
        page.wait_for_selector("#waterfall .main-svg")
        waterfall = page.inner_text("#waterfall")
        assert "+ memory" in waterfall and "+ damping_temperature" in waterfall
        assert soon_no_wider_than_the_window(page)
        assert violations(page) == []


def told_both(law, both, values):
    """Give a diagnosis that names two effects which help only together."""
    known = [find_effect(name) for name in both]
    words = {
        name: "; ".join(getattr(effect, name) for effect in known) for name in ("does", "looks_like", "told_apart_by")
    }
    candidate = CandidateShown(
        name=",".join(both), heldout_nrmse=0.006, explained=0.9, against=(), effects=both, values=values, **words
    )
    promised = RungShown(label=" ".join(f"+ {name}" for name in both), heldout_nrmse=0.006, explained=0.9)
    return DiagnosisShown(
        law_command=stamp(law), verdict="missing", kind="part", effects=both[:1], together=both, headline="Part.",
        words=("They help only together.",), rung=("Both.",), lines=(), heldout_nrmse=0.02, candidates=(candidate,),
        promised=(promised,), next_test="", drive=False,
    )  # fmt: skip


def test_what_a_file_leaves_open_is_stated_with_a_click(page, url, violations):
    """A refusal keeps its lines, the option that it ends with is taken over; samples without time get their rate."""
    time = [place / 500 for place in range(3000)]
    y = [0.5 * math.sin(6 * math.pi * t) for t in time]
    force = [0.9 * each + 0.1 * math.cos(6 * math.pi * t) for t, each in zip(time, y, strict=True)]
    rows = [f"{one:.4f};{two:.5f};{three:.6f}" for one, two, three in zip(time, y, force, strict=True)]
    text = "\n".join(["Ch1;Ch2;Ch3", *rows]).replace(".", ",")
    page.goto(url)
    page.click(".brand")
    page.set_input_files("#files", [{"name": "export.csv", "mimeType": "text/csv", "buffer": text.encode()}])
    page.wait_for_selector(".job.refused", timeout=A_JOB_ms)
    assert len(page.inner_text(".job.refused .says").splitlines()) > 3
    page.click("text=Take the proposal over")
    assert page.input_value("#columns") == "time=Ch1 [s],displacement=Ch2 [mm],force=Ch3 [N]"
    assert violations(page) == []
    page.fill("#columns", "time=none,displacement=Ch2 [mm],force=Ch3 [kN]")
    page.fill("#rate", "500,0")
    page.click("text=Look into them")
    page.wait_for_selector("#write:enabled", timeout=A_JOB_ms)
    page.wait_for_selector("#loops .main-svg")
    assert "--rate 500.0" in page.inner_text("#line")
    assert "0.5\t3\t" in page.inner_text("#found table:last-of-type >> nth=-1")


def test_a_file_that_is_not_taken_is_told_until_the_next(page, url):
    """Also where a look at the others goes well."""
    path = next(iter((DATA / "campaigns" / "clamp_a_heldout" / "runs").iterdir()))
    file = {"name": path.name, "mimeType": "text/csv", "buffer": path.read_bytes()}
    page.goto(url)
    other = page.context.new_page()  # whose console may tell of the refusal
    other.goto(re.sub(r"/\?.*", "/campaigns", url))
    other.set_input_files("#files", [file])
    other.wait_for_selector("#write:enabled", timeout=A_JOB_ms)
    other.set_input_files("#files", [file])
    other.wait_for_selector("#taken:has-text('is there already')")
    other.wait_for_selector("#write:enabled", timeout=A_JOB_ms)
    assert "is there already" in other.inner_text("#taken")


def test_what_files_names_state_is_taken_over_with_a_click(page, url):
    """A look says that names state settings, and one click takes them."""
    folder = DATA / "campaigns" / "clamp_a_heldout" / "runs"
    page.goto(url)
    page.click(".brand")
    page.set_input_files("#files", [
        {"name": path.name.replace("p", "."), "mimeType": "text/csv", "buffer": path.read_bytes()}
        for path in sorted(folder.iterdir())[:4]
    ])  # fmt: skip
    page.wait_for_selector("#write:enabled", timeout=A_JOB_ms)
    page.click("#proposed-pattern")
    assert page.input_value("#pattern") == "A{amplitude_mm}_f{frequency_Hz}_T{temperature_C}"
    page.click("text=Look into them")
    page.wait_for_selector("#write:enabled", timeout=A_JOB_ms)
    assert "--pattern" in page.inner_text("#line")
    assert page.is_hidden("#proposed-pattern")


def test_files_are_dropped_and_looked_into(page, url, violations, home, tmp_path):
    folder = DATA / "campaigns" / "clamp_a_heldout" / "runs"
    page.goto(url)
    page.click(".brand")
    assert violations(page) == []
    files = [
        {"name": path.name, "mimeType": "text/csv", "buffer": path.read_bytes()} for path in sorted(folder.iterdir())
    ]
    page.set_input_files("#files", [*files[:6], {"name": "cut.csv", "mimeType": "text/csv", "buffer": b"no numbers"}])
    page.wait_for_selector('.job.refused:has-text("1 of 7 files can\'t be used")', timeout=A_JOB_ms)
    page.check("text=Leave out files that are damaged or hold no test")
    assert violations(page) == []
    page.click("text=Look into them")
    page.wait_for_selector("#write:enabled", timeout=A_JOB_ms)
    assert "cut.csv: left out" in page.inner_text("#found")
    assert "displacement_mm" in page.inner_text("#found")
    page.wait_for_selector("#loops .main-svg")
    assert page.locator("#loops .xy .scatterlayer").count() == 1
    assert page.evaluate("document.querySelectorAll('#loops .subplot').length") == 6, "a loop each"
    assert "primary" in page.get_attribute("#write", "class")
    assert violations(page) == []
    page.set_viewport_size(NARROW)
    assert soon_no_wider_than_the_window(page)
    page.fill("#name", "clamp_7")
    page.click("text=Look into them")
    page.wait_for_selector("#write:enabled", timeout=A_JOB_ms)
    other = page.context.new_page()
    other.goto(re.sub(r"/\?.*", "/campaigns", url))
    with page.expect_response("**/import/jobs"):
        page.click("#write")
    other.reload()  # a page that didn't start it says where it is, and stays
    page.wait_for_selector(LOOP, timeout=A_JOB_ms)
    assert page.inner_text("h1") == "clamp_7"
    assert other.get_attribute(".job >> text=Open it", "href") == "/c/clamp_7/"
    assert (home / "clamp_7" / "campaign.toml").is_file()


def test_results_are_imported_and_shown_without_loops(page, url, violations):
    """Tables with a row a test make a campaign of metrics, whose page has pictures and commands."""
    rows = [(f, A, 900 * f**0.1 / A**0.2, 150 * f**0.2, 20) for A in (0.1, 0.5) for f in (1, 5, 20, 100)]
    text = "\n".join(["f;A;K';K\";T", "Hz;mm;N/mm;N/mm;°C", *(";".join(map(str, row)) for row in rows)])
    page.goto(url)
    page.click(".brand")
    page.set_input_files("#files", [{"name": "mount.csv", "mimeType": "text/csv", "buffer": text.encode()}])
    page.wait_for_selector("#write:enabled", timeout=A_JOB_ms)
    page.wait_for_selector("#loops .main-svg")
    assert "8 tests of 1 file, known by stiffness and loss" in page.inner_text("#found")
    page.fill("#name", "mount")
    page.click("text=Look into them")
    page.wait_for_selector("#write:enabled", timeout=A_JOB_ms)
    page.click("#write")
    page.wait_for_url("**/c/mount/", timeout=A_JOB_ms)
    page.wait_for_selector(".picture .main-svg")
    assert page.locator(".picture").count() == 2 and "Metrics without records" in page.inner_text("main")
    assert violations(page) == []
    page.set_viewport_size(NARROW)
    assert soon_no_wider_than_the_window(page)


def test_levels_line_up_in_panels_beside_each_other(page, tmp_path):
    """A level that a panel has no test of takes as much room there; rows had been at another height in each panel."""
    campaign = tmp_path / "some"
    pc.rig("emwm2", campaign, amplitudes=(0.3, 0.6, 1.0), frequencies=(2.0,), temperatures=(20.0, 150.0), cycles=3)
    table = campaign / "runs.csv"
    lines = table.read_text(encoding="utf-8").splitlines()
    # the largest amplitude alone was tested hot
    kept = [line for line in lines if ",150" not in line or line.startswith("A1_")]
    table.write_text("\n".join(kept) + "\n", encoding="utf-8")
    with studio_of(str(campaign), tmp_path / "home") as url:
        page.goto(url)
        page.wait_for_selector(".panels .cell")
        heights = page.evaluate(
            "[...document.querySelectorAll('.panels table')].map(one => "
            "[...one.tBodies[0].rows].map(row => row.getBoundingClientRect().top))"
        )
    assert len(heights) == 2 and len(heights[0]) == 3
    assert heights[0] == heights[1]
