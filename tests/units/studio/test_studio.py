"""What the studio answers is what the commands answer, and what it makes are files that the commands read."""

from __future__ import annotations

import io
import json
import math
import os
import shutil
import signal
import time
import zipfile
from dataclasses import replace
from pathlib import Path

import polars as pl
import pytest

pytest.importorskip("starlette", reason="needs the extra 'studio'")
pytest.importorskip("uvicorn", reason="needs the extra 'studio'")

from studio_server import running

import pipeclamp as pc
from pipeclamp.studio import tasks
from pipeclamp.studio.bench import read_bench
from pipeclamp.studio.desk import Desk, Opened
from pipeclamp.studio.diagnosis_shown import CandidateShown, DiagnosisShown, RungShown, stamp
from pipeclamp.studio.discovering import DiscoveryShown, discovery_in
from pipeclamp.studio.on_pipe import PIPE, _example, system_text, temperatures_of
from pipeclamp.studio.project import Project, _precedes
from pipeclamp.studio.rendering import campaign_page
from pipeclamp.studio.session import SessionStep
from pipeclamp_fmu.native.compiler import default_platforms
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.workflow.auto import add_until_settled
from pipeclamp_identification.workflow.on_records import RecordTests
from pipeclamp_models.base.toml_file import parse_table
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import law_of, law_text, read_law
from pipeclamp_models.law.law import with_effect
from pipeclamp_models.pipe.beam import modes
from pipeclamp_models.pipe.description import Springs, Support, parse_pipe
from pipeclamp_models.pipe.modes import finite_elements
from pipeclamp_models.pipe.section import beam_of
from pipeclamp_system.description.system import SystemDescription

PLAN = Plan(amplitudes=(0.3, 0.9), frequencies=(1.0, 4.0), temperatures=(20.0, 250.0), rate=300.0)
JOBS = "/c/virtual/jobs"


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tests") / "virtual"
    write_campaign(folder, virtual_runs(law_of(open_law("emwm2")), PLAN), name="virtual", notes="")
    return folder


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    return tmp_path_factory.mktemp("studio") / "home"


@pytest.fixture(scope="module")
def studio(campaign, home):
    with running(home, str(campaign)) as started:
        assert started.done(started.json(JOBS, {"kind": "identify", "base": "power"}))["result"] == {"law": "law1"}
        yield started


def test_a_law_is_the_one_that_its_command_makes(studio, campaign, home):
    law, same = pc.open_law(home / "law1.json"), pc.identify(campaign)
    assert law.values == same.values
    assert law.file.command == "pipeclamp identify virtual -o law1.json"
    session = json.loads((home / "session.json").read_text())
    assert session["steps"][0]["command"] == f"pipeclamp identify {campaign} -o {home / 'law1.json'}"


def test_most_of_the_force_may_be_a_constant_load(campaign, tmp_path):
    """A share of it looks small: the page says what the law errs of the rest too, as `compare` does."""
    loaded = tmp_path / "loaded"
    shutil.copytree(campaign, loaded)
    for path in (loaded / "runs").iterdir():
        pl.read_csv(path).with_columns(pl.col("force_N") - 9e4).write_csv(path)
    project = Project(str(loaded), tmp_path / "laws")
    pc.identify(loaded, effects=["offset"]).save(project.folder / "law1.json")
    page = campaign_page(Opened("loaded", project, read_bench(str(loaded))), None, by="", beside="")
    assert "Most of the force is a constant load; of the rms of the rest the error is" in page
    assert "Of the rig, and so not in the FMU: offset (F_o = -900" in page, "the FMU that is built here lacks it"


def test_an_addition_that_does_not_help_is_told_with_the_way_back(campaign, tmp_path):
    project, law = Project(str(campaign), tmp_path / "laws"), pc.identify(campaign)
    law.save(project.folder / "law1.json")
    added = pc.add(law, "damping_temperature", campaign).file
    for after, said in ((0.01, False), (0.09, True)):
        first, last = added.history
        history = (
            first.model_copy(update={"refitted_nrmse": 0.06}), last.model_copy(update={"refitted_nrmse": after})
        )  # fmt: skip
        (project.folder / "law2.json").write_text(law_text(added.model_copy(update={"history": history})))
        page = campaign_page(Opened("virtual", project, read_bench(str(campaign))), "law2", by="", beside="")
        words = "rises with damping_temperature (6.00% -&gt; 9.00%); keep the law without it."
        assert (words in page) is said
        assert ('<a class="button primary" href="/c/virtual/laws/law1">Step back to law1' in page) is said


def test_a_run_errs_as_compare_says(studio, campaign, home):
    answer = pc.compare(home / "law1.json", campaign).to_dict()
    for expected in answer["runs"]:
        run = studio.json(f"/c/virtual/runs/{expected['run']}?laws=law1")
        (told,) = run["by_law"]
        assert told["nrmse"] == pytest.approx(expected["nrmse"])
        assert told["noise_nrmse"] == pytest.approx(expected["noise_nrmse"])
        assert len(run["y"]) == len(run["measured"]) == len(run["laws"][0])


def test_the_page_says_what_compare_says(studio, campaign, home):
    nrmse = pc.compare(home / "law1.json", campaign).nrmse
    page = studio.ask("/c/virtual/laws/law1")[2].decode()
    assert f'<span class="big">{100 * nrmse:.2f}%</span>' in page
    assert page.count('class="cell') == 8


def test_a_slider_gives_the_law_with_that_value(studio, campaign, home):
    law = pc.open_law(home / "law1.json")
    name = studio.desk.open("virtual").bench.loops.run[3]
    stiffer = {"k10": 1.2 * law.values["k10"]}
    moved = studio.json("/c/virtual/moved", {"law": "law1", "run": name, "values": stiffer})
    coefficients = {
        key: entry.model_copy(update={"value": stiffer.get(key, entry.value)})
        for key, entry in law.file.coefficients.items()
    }
    other = pc.Law(law.file.model_copy(update={"coefficients": coefficients}))
    expected = {run["run"]: run["nrmse"] for run in pc.compare(other, campaign).to_dict()["runs"]}
    assert moved["by_law"]["nrmse"] == pytest.approx(expected[name])
    assert moved["by_law"]["nrmse"] > 0.05


def test_a_slider_beyond_all_reason_is_told(studio):
    name = studio.desk.open("virtual").bench.loops.run[3]
    status, _, content = studio.ask("/c/virtual/moved", "POST", {"law": "law1", "run": name, "values": {"k10": -1e300}})
    assert status == 400
    assert "beyond all reason" in json.loads(content)["error"]


REFUSED = {
    "no run of that name": ("/c/virtual/runs/none?laws=law1", None),
    "no law of that name": ("/c/virtual/laws/law7", None),
    "a law by its path": ("/c/virtual/runs/x?laws=../law1", None),
    "no campaign": ("/c/other/", None),
    "no JSON": (JOBS, b"{"),
    "no object": (JOBS, b"[]"),
    "a nest": (JOBS, b"[" * 60000),
    "no such job": (JOBS, {"kind": "rm"}),
    "no such base": (JOBS, {"kind": "identify", "base": "../x"}),
    "an effect that no diagnosis named": (JOBS, {"kind": "add", "law": "law1", "effect": "memory"}),
    "no number": ("/c/virtual/moved", {"law": "law1", "run": "x", "values": {"k10": "1"}}),
    "no finite number": ("/c/virtual/moved", b'{"law": "law1", "run": "x", "values": {"k10": NaN}}'),
    "no parameter": ("/c/virtual/moved", {"law": "law1", "run": "", "values": {"zz": 1}}),
    "an unsafe campaign": ("/import/jobs", {"batch": "0123456789abcdef", "name": "../x"}),
    "no number of samples": ("/import/jobs", {"batch": "0123456789abcdef", "name": "x", "rate": "many"}),
    "no batch": ("/import/jobs", {"batch": "../../etc", "name": "x"}),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_cannot_serve_is_told_in_a_sentence(studio, what):
    path, body = REFUSED[what]
    status, _, content = studio.ask(path, "GET" if body is None else "POST", body)
    assert status == 400
    assert json.loads(content)["error"]


def test_a_job_that_is_cancelled_leaves_nothing_and_keeps_nobody_waiting(studio, home):
    before = sorted(path.name for path in home.iterdir())
    job = studio.json(JOBS, {"kind": "diagnose", "law": "law1"})
    assert job["state"] == "running"
    begin = time.monotonic()
    assert studio.ask("/c/virtual/laws/law1")[0] == 200
    assert time.monotonic() - begin < 2.0
    studio.json(f"{JOBS}/{job['number']}/cancel", {})
    ended = studio.done(job)
    assert ended["state"] == "cancelled"
    assert sorted(path.name for path in home.iterdir()) == before


def power_law(campaign, **effects):
    """The base law as it is fitted to a campaign, with effects of stated parameters."""
    law = law_of(pc.identify(campaign).file)
    for name, values in effects.items():
        law = replace(law, structure=with_effect(law.structure, name), values={**law.values, **values})
    return law


@pytest.fixture(scope="module")
def hiding(campaign, tmp_path_factory):
    """A campaign of a clamp whose two halves are pressed unequally."""
    folder = tmp_path_factory.mktemp("hiding") / "hiding"
    write_campaign(folder, virtual_runs(power_law(campaign, asymmetry={"k2": 200.0}), PLAN), name="hiding", notes="")
    return folder


def test_what_is_missing_is_added_until_nothing_helps(hiding, tmp_path):
    """At the end stand the law that the function makes, and the diagnosis that it ended with."""
    said, (first, last) = [], (str(tmp_path / f"law{number}.json") for number in (1, 2))
    law = pc.identify(hiding)
    law.save(first)
    given = {"campaign": str(hiding), "limits": "", "command": "pipeclamp diagnose"}
    assert tasks.climb(said.append, of=first, law=last, **given) == {"law": "law2"}
    climbed, same = read_law(Path(last)), add_until_settled(law.file, RecordTests(read_campaign(hiding)), command="")
    assert climbed.effects == ("asymmetry",)
    assert law_of(climbed).values == law_of(same.file).values
    told = DiagnosisShown.model_validate_json((tmp_path / "law2.told.json").read_text())
    assert (told.verdict, told.law_command) == ("complete", stamp(climbed))
    assert any(words.startswith("+ asymmetry\n") and "on left-out conditions; " in words for words in said)


def test_a_ladder_that_adds_nothing_leaves_the_diagnosis_of_the_law(campaign, tmp_path):
    tests = tmp_path / "plain"
    write_campaign(tests, virtual_runs(power_law(campaign), PLAN), name="plain", notes="")
    first, last = (tmp_path / f"law{number}.json" for number in (1, 2))
    pc.identify(tests).save(first)
    given = {"campaign": str(tests), "limits": "", "command": "pipeclamp diagnose"}
    assert tasks.climb(lambda _: None, of=str(first), law=str(last), **given) == {"verdict": "complete"}
    assert (tmp_path / "law1.told.json").exists()
    assert not last.exists()


def test_a_ladder_that_is_stopped_leaves_the_law_so_far(hiding, tmp_path):
    with running(tmp_path / "home", str(hiding)) as studio:
        studio.done(studio.json("/c/hiding/jobs", {"kind": "identify", "base": "power"}))
        job = studio.json("/c/hiding/jobs", {"kind": "climb", "law": "law1"})
        while not (tmp_path / "home" / "law2.json").exists() and studio.desk.jobs.running("hiding"):
            time.sleep(0.02)
        assert b"/laws/law2" not in studio.ask("/c/hiding/")[2], "it is another law after each rung"
        status, _, refused = studio.ask("/c/hiding/laws/law2")
        assert (status, b"law2: is being made" in refused) == (400, True)
        studio.json(f"/c/hiding/jobs/{job['number']}/cancel", {})
        ended = studio.done(job)
        assert (ended["state"], ended["result"]) == ("cancelled", {"law": "law2"})
        assert ended["says"] == "stopped; law2 holds what was added until then"
        assert read_law(tmp_path / "home" / "law2.json").effects
        assert studio.desk.open("hiding").project.parent("law2") == "law1"
        told = studio.ask("/c/hiding/")[2].decode()
        assert "# stopped on the way: law2 holds what had been added until then\npipeclamp diagnose" in told
        assert not json.loads((tmp_path / "home" / "session.json").read_text())["begun"]


def test_a_law_that_comes_to_nothing_leaves_its_name_to_the_next(studio, home):
    project = studio.desk.open("virtual").project
    before = project.upcoming
    job = studio.json(JOBS, {"kind": "identify", "base": "series"})
    assert f"{before}.json" in job["command"]
    assert project.upcoming != before, "nobody else is given it"
    studio.json(f"{JOBS}/{job['number']}/cancel", {})
    assert studio.done(job)["state"] == "cancelled"
    assert project.upcoming == before


def test_two_that_help_only_together_are_added_in_one_click(studio, campaign, home):
    """Each is a step of its own in the law's history, and remembered as a part, as on the command line."""
    law, both = read_law(home / "law1.json"), ("viscous", "asymmetry")
    fitted = pc.identify(campaign, effects=both)
    of_both = CandidateShown(
        name="viscous,asymmetry", does="one; other", looks_like="this", told_apart_by="that", heldout_nrmse=0.004,
        explained=0.9, against=(), effects=both, values=fitted.values,
    )  # fmt: skip
    promised = RungShown(label="+ viscous + asymmetry", heldout_nrmse=0.004, explained=0.9)
    told = DiagnosisShown(
        law_command=stamp(law), verdict="missing", kind="part", effects=both[:1], together=both, headline="Part",
        words=("both",), rung=("both",), lines=(), heldout_nrmse=0.01, candidates=(of_both,), promised=(promised,),
        next_test="", drive=False,
    )  # fmt: skip
    (home / "law1.told.json").write_text(told.json_text(), encoding="utf-8")
    page = studio.ask("/c/virtual/laws/law1")[2].decode()
    assert '<button class="primary" type="button" data-start="add" data-effect="viscous,asymmetry">Add' in page
    assert "pipeclamp add" in page and "viscous,asymmetry" in page and "--as part" in page
    assert "Tests have joined since" not in page
    assert "the tests hold 4 groups of amplitude and frequency, and a search needs 6" in page
    assert 'data-start="discover"' not in page and "pipeclamp discover" not in page, "they can't serve one"
    fewer = told.model_copy(update={"runs": 5})
    (home / "law1.told.json").write_text(fewer.json_text(), encoding="utf-8")
    page = studio.ask("/c/virtual/laws/law1")[2].decode()
    assert "what follows rests on 5 runs, and there are 8 now" in page, "the verdict is that of the tests then"
    before = set(home.glob("law*.json"))
    done = studio.done(studio.json(JOBS, {"kind": "add", "law": "law1", "effect": "viscous,asymmetry"}))
    assert done["title"] == "Add viscous and asymmetry and fit everything again"
    made = home / f"{done['result']['law']}.json"
    assert made not in before
    added = read_law(made)
    assert added.effects == both
    assert [(step.step, step.kind) for step in added.history[-2:]] == [(f"+ {name}", "part") for name in both]
    assert Project("virtual", home).parent(made.stem) == "law1"
    chips = studio.ask(f"/c/virtual/laws/{made.stem}")[2].decode().split('aria-label="Laws of this campaign"')[1]
    assert f"<b>{made.stem}</b> + viscous + asymmetry" in chips
    assert _precedes(law, added) and not _precedes(added, law)
    made.unlink()
    (home / "law1.told.json").unlink()


def test_a_law_of_other_tests_is_fitted_anew_in_one_click(studio, home):
    """Where tests have joined, the law on the page is that of fewer."""
    law = read_law(home / "law1.json")
    assert "Its tests have changed since" not in studio.ask("/c/virtual/laws/law1")[2].decode()
    data = law.data.model_copy(update={"fingerprint": "of six runs", "runs_used": 6})
    once = law.model_copy(update={"name": "once", "data": data})
    (home / "law1.json").write_text(law_text(once), encoding="utf-8")
    page = studio.ask("/c/virtual/laws/law1")[2].decode()
    assert "the law was fitted to 6 runs, and there are 8 now" in page
    assert 'data-start="refit" title="pipeclamp refit ' in page
    done = studio.done(studio.json(JOBS, {"kind": "refit", "law": "law1"}))
    made = home / f"{done['result']['law']}.json"
    anew = read_law(made)
    assert (anew.data.fingerprint, anew.effects) == (law.data.fingerprint, law.effects)
    assert anew.history[-1].step == "a refit"
    assert "Its tests have changed since" not in studio.ask(f"/c/virtual/laws/{made.stem}")[2].decode()
    made.unlink()
    (home / "law1.json").write_text(law_text(law), encoding="utf-8")


def test_a_search_for_a_term_that_tests_cannot_serve_is_told(studio, home):
    """Four groups of A and f are too few; the law that was reserved for the term isn't there, nor in the session."""
    files = {path.name: path.read_bytes() for path in [*home.glob("law*"), home / "session.json"]}
    ended = studio.done(studio.json(JOBS, {"kind": "discover", "law": "law1"}))
    assert ended["state"] == "refused"
    assert "groups of amplitude and frequency: 4" in ended["says"]
    assert {path.name: path.read_bytes() for path in [*home.glob("law*"), home / "session.json"]} == files


def test_what_a_search_found_is_shown(studio, home):
    law = pc.open_law(home / "law1.json").file
    words, guards = ("Nothing is proposed: noise.",), (("asked", False, "why"),)
    told = DiscoveryShown(law_command=stamp(law), proposed=False, words=words, guards=guards, law=None)
    (home / "law1.discovery_told.json").write_text(told.json_text(), encoding="utf-8")
    assert discovery_in(Project("virtual", home), "law1", law) == told
    assert discovery_in(Project("virtual", home), "law1", law.model_copy(update={"date": "another"})) is None


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="kills a process by a signal")
def test_a_job_whose_process_dies_is_told(studio):
    job = studio.json(JOBS, {"kind": "diagnose", "law": "law1"})
    (process,) = studio.desk.jobs._processes.values()
    os.kill(process.pid, signal.SIGKILL)
    assert studio.done(job)["state"] == "failed"


def test_jobs_are_followed_until_none_runs(studio):
    job = studio.json(JOBS, {"kind": "build", "law": "law1"})
    _, headers, content = studio.ask(JOBS)
    assert headers["content-type"].startswith("text/event-stream")
    *_, last = [json.loads(line.removeprefix("data: ")) for line in content.decode().split("\n\n") if line]
    (told,) = (each for each in last if each["number"] == job["number"])
    assert told["state"] == "done"
    status, headers, content = studio.ask("/c/virtual/files/law1.fmu")
    assert status == 200
    assert "attachment" in headers["content-disposition"]
    assert zipfile.ZipFile(io.BytesIO(content)).testzip() is None


def test_the_fmu_is_that_of_the_line_beside_it(studio, home):
    """It had been the one in Python, also where a compiler was found."""
    job = studio.json(JOBS, {"kind": "build", "law": "law1"})
    assert job["command"].endswith("law1.fmu --track")
    assert studio.done(job)["state"] == "done"
    _, _, content = studio.ask("/c/virtual/files/law1.fmu")
    sources = any(name.startswith("sources/") for name in zipfile.ZipFile(io.BytesIO(content)).namelist())
    assert sources == bool(default_platforms(fmi=2))


def test_the_page_of_a_law_is_written(studio, home):
    assert studio.done(studio.json(JOBS, {"kind": "report", "law": "law1"}))["state"] == "done"
    status, headers, content = studio.ask("/c/virtual/files/law1.html")
    assert status == 200
    assert "attachment" in headers["content-disposition"]
    assert b"RMS error" in content


def test_the_pipe_is_described_at_the_ends_of_the_tests_temperatures(studio, home):
    T = temperatures_of(studio.desk.open("virtual").bench.loops)
    known = studio.desk.open("virtual").bench.loops.temperature_K - CELSIUS
    assert pytest.approx((known.min(), known.max()), abs=0.1) == T
    system = system_of(read_pipe_text(), home, T)
    (clamp,) = system.clamps
    assert clamp.law == "law1.json"
    assert system.response.temperatures_C == T


def test_tests_of_one_temperature_show_the_pipe_there_alone(studio):
    loops = studio.desk.open("virtual").bench.loops
    first = loops.temperature_K[0]
    alike = replace(loops, rows=tuple(row for row in loops.rows if abs(row.temperature_K - first) < 1))
    assert temperatures_of(alike) == (pytest.approx(first - CELSIUS, abs=0.1),)


@pytest.mark.parametrize("stiffness", [1.0, 1e6])  # N/mm
def test_the_response_holds_the_pipes_resonance_whatever_its_clamps_are(home, stiffness):
    """With clamps of any number and name, on another pipe than the example's, shaken by a force."""
    text = read_pipe_text().replace("length_m = 10.0", "length_m = 4.0").replace("position_m = 5.5", "position_m = 2.2")
    text = text.replace('kind = "base"', 'kind = "force"\nposition_m = 2.0')
    text = text.replace('name = "clamp1"\n', 'name = "left"\n') + CLAMP_RIGHT
    system = system_of(text, home, ())
    assert [clamp.at for clamp in system.clamps] == ["left", "right"]
    assert system.excitation.force_N and not system.response.temperatures_C
    pipe = parse_pipe(text)
    spring = Springs(stiffness_N_mm=stiffness, rotational_stiffness_Nm_rad=0.0)
    springs = tuple(Support(position_m=clamp.position_m, condition=spring) for clamp in pipe.clamps)
    sprung = pipe.model_copy(update={"supports": springs, "clamps": ()})
    first = modes(beam_of(sprung), finite_elements(sprung))[0][0] / (2 * math.pi)
    assert 1.05 * system.response.from_Hz < first < system.response.to_Hz / 1.05


def test_a_pipe_without_clamps_is_refused(home):
    text = read_pipe_text()
    with pytest.raises(pc.UserError, match="the pipe has no clamp; expected"):
        system_of(text[: text.index("[[clamps]]")] + text[text.index("[[probes]]") :], home, ())


CLAMP_RIGHT = """
[[clamps]]
name = "right"
position_m = 2.9
"""


def read_pipe_text():
    return _example(PIPE)


def system_of(pipe, home, temperatures):
    file = pc.open_law(home / "law1.json").file
    return parse_table(system_text(parse_pipe(pipe), file, "law1.json", temperatures), SystemDescription, "studio")


def test_a_studio_that_was_killed_finds_all_again(studio, campaign, home, tmp_path):
    later = tmp_path / "home"
    shutil.copytree(home, later)
    (later / ".law2.json.abc.part").write_text("cut")
    with running(later, str(campaign)) as again:
        assert 'aria-current="page"><b>law1</b>' in again.ask("/")[2].decode()
        assert again.desk.open("virtual").project.reserve() == "law2"
    assert not list(later.glob(".*.part"))


def test_what_was_being_done_when_the_studio_was_killed_is_told_where_it_left_a_law(studio, campaign, home, tmp_path):
    later = tmp_path / "home"
    shutil.copytree(home, later)
    project = Project(str(campaign), later)
    done = len(project.steps)
    for law, stopped in (("law2", True), ("law3", True), ("law4", False)):
        project.begin(SessionStep(command=f"pipeclamp makes {law}", law=law, of="law1", stopped=stopped))
    for law in ("law2", "law4"):
        shutil.copy(later / "law1.json", later / f"{law}.json")
    again = Project(str(campaign), later)
    assert [step.shell_lines() for step in again.steps[done:]] == [
        "# stopped on the way: law2 holds what had been added until then\npipeclamp makes law2",
        "pipeclamp makes law4",
    ]
    assert Project(str(campaign), later).steps == again.steps
    assert not json.loads((later / "session.json").read_text())["begun"]


def test_files_become_a_campaign_once_they_are_confirmed(studio, campaign, home):
    batch, name = "00112233aabbccdd", "clamp_7"
    for path in sorted((campaign / "runs").iterdir()):
        assert studio.ask(f"/uploads/{batch}/{path.name}", "PUT", path.read_bytes())[0] == 200

    assert studio.ask(f"/uploads/{batch}/cut.csv", "PUT", b"")[0] == 200

    def asked(dry_run, skip=True):
        job = studio.json("/import/jobs", {"batch": batch, "name": name, "skip_unusable": skip, "dry_run": dry_run})
        assert ("--skip-unusable" in job["command"]) is skip
        return studio.done(job)

    refused = asked(True, skip=False)
    assert refused["state"] == "refused"
    assert "1 of 9 files can't be used" in refused["says"] and "is empty" in refused["says"]
    looked = asked(True)
    assert any("cut.csv: left out" in line for line in looked["result"]["lines"])
    assert looked["state"] == "done", looked
    assert not looked["result"]["written"]
    assert [table["header"][0] for table in looked["result"]["tables"]] == ["column", "run"]
    assert not (home / name).exists()
    assert asked(False)["state"] == "done"
    assert "8 runs" in studio.ask(f"/c/{name}/")[2].decode()
    assert name in studio.ask("/campaigns")[2].decode()
    assert not (home / "uploads" / batch).exists(), "the campaign holds what was in them"
    gone = studio.json("/import/jobs", {"batch": batch, "name": name, "dry_run": True})
    assert "drop them again" in gone["error"]


def test_files_that_were_dropped_long_ago_are_cleared(tmp_path):
    old, new, foreign = (tmp_path / "uploads" / name for name in ("00112233aabbccdd", "ffeeddccbbaa9988", "mine"))
    for folder in (old, new, foreign):
        folder.mkdir(parents=True)
        (folder / "a.csv").write_text("1")
    for folder in (old, foreign):
        os.utime(folder, (time.time() - 2 * 86400,) * 2)
    Desk(tmp_path)
    assert [folder.exists() for folder in (old, new, foreign)] == [False, True, True]


def test_metrics_without_records_are_shown_and_have_no_loops(tmp_path):
    with running(tmp_path / "home", "emwm2_tables") as studio:
        status, _, content = studio.ask("/", headers={"accept": "text/html"})
        text = content.decode()
        assert status == 200 and "11 runs" in text and "A0p8_f3_T300" in text
        assert all(f"Against {axis}" in text for axis in ("f / Hz", "A / mm", "T / °C"))
        assert "pipeclamp identify emwm2_tables -o law.json" in text
        for path in ("/c/emwm2_tables/", "/campaigns"):
            assert studio.ask(path, headers={"accept": "text/html"})[0] == 200
        for path in (
            "/c/emwm2_tables/laws/law1",
            "/c/emwm2_tables/runs/A0p8_f3_T300",
            "/c/emwm2_tables/files/law1.json",
        ):
            status, _, content = studio.ask(path)
            assert status == 400 and "holds metrics without records" in json.loads(content)["error"]
        told = studio.json("/c/emwm2_tables/jobs", {"kind": "identify", "base": "power"})
        assert "the commands on its page do" in told["error"]
