"""`pipeclamp import` as a user calls it: from a folder of exports to a law and a verdict in two commands."""

from __future__ import annotations

import contextlib
import dataclasses
import html
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from exports import assert_same_campaign, loop, ten_runs, write_texts
from format_writers import write_sheets
from typer.testing import CliRunner

import pipeclamp as pc
from pipeclamp.cli.app import app
from pipeclamp_models.base.shell import shell_line

PATTERN = "A{amplitude_mm}_f{frequency_Hz}_T{temperature_C}"
GERMAN = {
    "names": "Zeit [s];Kolbenweg/µm;Last [kN]",
    "scales": (1, 1e3, 1e-3),
    "digits": (6, 3, 7),
    "encoding": "latin-1",
    "header": "Prüfung 12\n\n",
}


def contents(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def exports(tmp_path_factory):
    return write_texts(tmp_path_factory.mktemp("machine") / "exports", ten_runs(), **GERMAN)


def test_from_exports_to_a_law_and_a_verdict(pipeclamp, exports, tmp_path):
    campaign, law = tmp_path / "clamp_7", tmp_path / "law.json"
    told = pipeclamp("import", exports, "-o", campaign, "--pattern", "T{temperature_C}", "--json", tmp_path / "i.json")
    assert "10 runs of 10 files" in told.stdout
    assert f"Next: pipeclamp identify {campaign} -o law.json" in told.stdout.replace("\n", "")
    assert "no temperature" not in told.stdout
    assert "Kolbenweg/µm" in told.stdout
    assert_same_campaign(campaign, ten_runs())
    pipeclamp("identify", campaign, "-o", law)
    found = pipeclamp("diagnose", law, campaign, "--json", tmp_path / "d.json")
    assert json.loads((tmp_path / "d.json").read_text())["verdict"] in ("complete", "missing", "ambiguous", "unknown")
    assert found.stdout
    answer = json.loads((tmp_path / "i.json").read_text())
    assert answer["written"]
    assert len(answer["runs"]) == 10
    page = (campaign / "import.html").read_text(encoding="utf-8")
    assert all(run.name in page for run in ten_runs())
    described = (campaign / "campaign.toml").read_text(encoding="utf-8")
    assert re.search(r'channel = "Last \[kN\]", unit = "kN", factor = 1000', described)
    assert len(re.findall(r'sha256 = "[0-9a-f]{64}"', described)) == 10


def test_sheets_of_a_workbook_name_runs_and_state_what_was_set(pipeclamp, tmp_path):
    write_sheets(tmp_path / "clamp 7.xlsx", ten_runs()[:4])
    plain = tmp_path / "with a blank and an ä" / "plain"
    plain.parent.mkdir()
    told = pipeclamp("import", tmp_path / "clamp 7.xlsx", "-o", plain).stdout
    assert "pipeclamp identify" not in told, "without the temperatures that the names state"
    *_, sentence, unknown, following = told.splitlines()
    assert "no temperature is known" in unknown
    line = following.removeprefix("Next: pipeclamp ")
    assert sentence.endswith("the line below takes them")
    assert f"pipeclamp {line}</code>" in html.unescape((plain / "import.html").read_text(encoding="utf-8"))
    told = pipeclamp(*shlex.split(line)).stdout
    assert told.splitlines()[-1] == f'Next: pipeclamp identify "{plain}_2" -o law.json'
    assert {run.setup.temperature_C for run in pc.read_campaign(f"{plain}_2").tests.campaign.runs} == {20.0}
    campaign = tmp_path / "clamp_7"
    pipeclamp("import", tmp_path / "clamp 7.xlsx", "-o", campaign, "--pattern", "T{temperature_C}")
    runs = {run.name: run for run in pc.read_campaign(campaign).tests.campaign.runs}
    assert {name: run.setup.temperature_C for name, run in runs.items()} == {
        f"clamp 7_{run.name}": run.temperature for run in ten_runs()[:4]
    }


def test_where_no_run_is_a_sine_what_parts_cycles_is_said(pipeclamp, tmp_path):
    """A wall's cycles, each farther than the last, had been imported without a next step or a word on one."""
    rows = [f"{0.1 * place:.2f}\t{30 * place / (10 + place):.2f}" for place in range(60)]
    (tmp_path / "wall.txt").write_text("u [mm]\tFh [kN]\n" + "\n".join(rows) + "\n")
    told = pipeclamp("import", tmp_path / "wall.txt", "-o", tmp_path / "wall", "--rate", "none").stdout
    assert "no run is a sine" in " ".join(told.split()) and "--columns segment=" in " ".join(told.split())
    assert "Next:" not in told


def test_names_that_state_no_temperature_hinder_no_next_step(pipeclamp, tmp_path):
    folder = write_texts(tmp_path / "e", ten_runs()[:4])
    for number, file in enumerate(sorted(folder.iterdir()), 1):
        file.rename(folder / f"bush_{number:02}_A{number}_f2{file.suffix}")
    told = pipeclamp("import", folder, "-o", tmp_path / "c").stdout.replace("\n", "")
    assert "no temperature is known" in told
    assert "{current_A}" not in told, "the A of 01_A1 is no unit of the 01"
    assert f"Next: pipeclamp identify {tmp_path / 'c'} -o law.json" in told


def test_importing_twice_changes_nothing_and_later_files_join(pipeclamp, exports, tmp_path):
    campaign = tmp_path / "clamp_7"
    pipeclamp("import", exports, "-o", campaign)
    (campaign / "runs.csv").write_text((campaign / "runs.csv").read_text().replace("0.3,", "0.31,", 1))
    before = contents(campaign)
    again = " ".join(pipeclamp("import", exports, "-o", campaign, "--pattern", "T{temperature_C}").stdout.split())
    assert "nothing to do" in again and "name another folder by -o" in again
    assert again.endswith(f"Next: {shell_line('identify', str(campaign), '-o', 'law.json')}")
    assert contents(campaign) == before
    later = write_texts(tmp_path / "later", [loop(0.6, 2.0)], **GERMAN)
    assert "1 run of 1 file, 10 more" in pipeclamp("import", exports, later, "-o", campaign).stdout
    after = contents(campaign)
    changed = {name for name in before if after[name] != before[name]}
    assert changed == {"runs.csv", "campaign.toml", "import.html"}
    assert after["runs.csv"].startswith(before["runs.csv"])
    assert len(pc.read_campaign(campaign).tests.campaign.runs) == 11
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]


def test_a_copy_of_a_file_is_left_aside_and_told(pipeclamp, exports, tmp_path):
    folder = tmp_path / "exports"
    shutil.copytree(exports, folder)
    shutil.copy(min(exports.iterdir()), folder / "copy.txt")
    told = pipeclamp("import", folder, "-o", tmp_path / "c")
    assert "10 runs of 10 files" in told.stdout
    assert "has the same content as" in told.stderr
    assert len(pc.read_campaign(tmp_path / "c").tests.campaign.runs) == 10


def test_a_dry_run_writes_nothing(pipeclamp, exports, tmp_path):
    told = pipeclamp("import", exports, "-o", tmp_path / "c", "--dry-run", "--report", tmp_path / "r.html")
    assert "nothing is written" in told.stdout
    report = ["--report", tmp_path / "r.html"]
    again = shell_line("import", str(exports), "-o", str(tmp_path / "c"), *map(str, report), "--pattern", PATTERN)
    assert again in told.stdout.splitlines()[-1]
    assert [path.name for path in tmp_path.iterdir()] == ["r.html"]


def test_the_ready_option_of_an_error_serves(refused, pipeclamp, tmp_path):
    folder = write_texts(tmp_path / "e", [loop()], names="Zeit;Weg [mm];Kraft [kN]")
    message = refused("import", folder, "-o", tmp_path / "c")
    assert not (tmp_path / "c").exists()
    option = re.search(r'--columns "([^"]*)"', message)[1]
    pipeclamp("import", folder, "-o", tmp_path / "c", "--columns", option)


@pytest.mark.parametrize(
    ("answers", "written"), [(("1", "2", "y"), True), (("1", "force=Kraft [kN]", "y"), True), (("1", "2", "n"), False)]
)
def test_at_a_terminal_what_is_open_is_asked_and_all_is_confirmed(tmp_path, monkeypatch, answers, written):
    monkeypatch.setattr("pipeclamp.cli.importing._at_a_terminal", lambda: True)
    folder = write_texts(tmp_path / "e", [loop(), loop(0.3)], names="Zeit;Weg [mm];Kraft", scales=(1, 1, 1e-3))
    done = CliRunner().invoke(app, ["import", str(folder), "-o", str(tmp_path / "c")], input="\n".join(answers) + "\n")
    assert "no unit is stated of 'Zeit'" in done.output
    assert "Are these channels and units right?" in done.output
    assert (tmp_path / "c").exists() is written
    if written:
        assert_same_campaign(tmp_path / "c", [loop(), loop(0.3)])


@pytest.mark.parametrize(
    ("options", "told", "status"),
    [
        (["--columns", "force=Last [kN],force=Zeit [s]"], "force stands there twice", 2),
        (["--pattern", "B{amplitude_mm}"], "doesn't follow --pattern", 1),
        (["--rate", "-5"], "--rate: got -5", 2),
        (["--conditions", "nowhere.csv"], "nowhere.csv: can't be read", 1),
        (["--columns", "force=-Last [kN]"], "the force of all runs has the wrong sign", 1),
    ],
)
def test_mistakes_are_one_message(refused, exports, tmp_path, options, told, status):
    assert told in refused("import", exports, "-o", tmp_path / "c", *options, status=status)
    assert not list(tmp_path.iterdir())


def test_what_is_there_is_left_alone(refused, exports, clamp_a, tmp_path):
    (tmp_path / "notes").mkdir()
    assert "exists already" in refused("import", exports, "-o", tmp_path / "notes")
    assert "wasn't imported" in refused("import", exports, "-o", clamp_a)
    assert "no such file" in refused("import", tmp_path / "nowhere.csv", "-o", tmp_path / "c")


def test_python_gives_the_same_answer(pipeclamp, exports, tmp_path):
    pipeclamp("import", exports, "-o", tmp_path / "c")
    other = pc.import_files(exports, tmp_path / "d", name="c")
    mine, theirs = contents(tmp_path / "c"), contents(other.folder)
    assert {name for name in mine if mine[name] != theirs[name]} <= {"import.html"}
    assert len(other.to_frame()) == 10
    assert len(pc.identify(other.tests()).values) > 2


@pytest.fixture
def some_damaged(exports, tmp_path):
    """A folder of exports as one comes across: one of nothing, one cut, and the list of results beside them."""
    folder = tmp_path / "exports"
    shutil.copytree(exports, folder)
    (folder / "B_empty.csv").write_bytes(b"")
    write_sheets(folder / "C_cut.xlsx", [loop()])
    (folder / "C_cut.xlsx").write_bytes((folder / "C_cut.xlsx").read_bytes()[:3000])
    (folder / "D_results.csv").write_text("No;k [N/mm];eta\n1;1200;0.1\n2;1201;0.2\n3;1300;0.2\n4;1300;0.2\n")
    return folder


UNUSABLE = {"B_empty.csv": "is empty", "C_cut.xlsx": "is no whole", "D_results.csv": "no channel is called a force"}


def test_all_files_that_cant_be_used_are_told_in_one_message(refused, pipeclamp, some_damaged, tmp_path):
    campaign = tmp_path / "c"
    first, *lines, remedy = refused("import", some_damaged, "-o", campaign).splitlines()
    assert "3 of 13 files can't be used; nothing was written" in first
    for line, (name, why) in zip(lines, UNUSABLE.items(), strict=True):
        assert name in line and why in line
    assert "the other 10: --skip-unusable" in remedy
    assert [path.name for path in tmp_path.iterdir()] == ["exports"]
    told = pipeclamp("import", some_damaged, "-o", campaign, remedy.split()[-1], "--json", tmp_path / "i.json")
    assert "3 files left out" in told.stdout
    assert_same_campaign(campaign, ten_runs())
    page = (campaign / "import.html").read_text(encoding="utf-8")
    described = (campaign / "campaign.toml").read_text(encoding="utf-8").partition("[[imported.left_out]]")[2]
    answered = json.loads((tmp_path / "i.json").read_text())["left_out_files"]
    for name, why in UNUSABLE.items():
        assert name in page and why in page.replace("&#39;", "'")
        assert name in described and why in described
        assert name in told.stderr and why in told.stderr
    assert [one["file"] for one in answered] == list(UNUSABLE)


def test_files_that_were_left_out_stay_out_until_they_can_be_used(refused, pipeclamp, some_damaged, tmp_path):
    campaign = tmp_path / "c"
    pipeclamp("import", some_damaged, "-o", campaign, "--skip-unusable")
    before = contents(campaign)
    assert "nothing to do" in " ".join(pipeclamp("import", some_damaged, "-o", campaign).stdout.split())
    assert contents(campaign) == before
    (some_damaged / "C_cut.xlsx").write_bytes(b"PK\x03\x04 cut elsewhere")
    assert "1 of 13 files can't be used" in refused("import", some_damaged, "-o", campaign)
    (some_damaged / "C_cut.xlsx").unlink()
    write_sheets(some_damaged / "C_cut.xlsx", [loop(0.6)])
    assert "1 run of 1 file, 10 more" in pipeclamp("import", some_damaged, "-o", campaign).stdout
    described = (campaign / "campaign.toml").read_text(encoding="utf-8")
    left_out = described.partition("[[imported.left_out]]")[2]
    assert "B_empty.csv" in left_out and "C_cut.xlsx" not in left_out


def test_where_no_file_can_be_used_nothing_is_offered(refused, tmp_path):
    (tmp_path / "e").mkdir()
    (tmp_path / "e" / "a.csv").write_bytes(b"")
    (tmp_path / "e" / "b.csv").write_bytes(b"no numbers")
    told = refused("import", tmp_path / "e", "-o", tmp_path / "c", "--skip-unusable")
    assert "2 of 2 files can't be used" in told
    assert "--skip-unusable" not in told


def test_where_all_files_lack_a_channel_it_is_asked_for_after_some_of_them(refused, tmp_path, monkeypatch):
    from pipeclamp_identification.importing.records import taking

    names = "Zeit [s];Wert A;Wert B"
    folder = write_texts(tmp_path / "e", [loop(0.3 + number / 100) for number in range(25)], names=names)
    looked = []
    take = taking.take_file
    monkeypatch.setattr(taking, "take_file", lambda path, *rest: looked.append(path) or take(path, *rest))
    told = refused("import", folder, "-o", tmp_path / "c")
    assert "no channel is called a displacement" in told and '--columns "' in told
    assert len(looked) == 20


@pytest.mark.parametrize(("answers", "written"), [("y\ny\n", True), ("n\n", False)])
def test_at_a_terminal_files_that_cant_be_used_are_left_out_if_one_says_so(
    some_damaged, tmp_path, monkeypatch, answers, written
):
    monkeypatch.setattr("pipeclamp.cli.importing._at_a_terminal", lambda: True)
    done = CliRunner().invoke(app, ["import", str(some_damaged), "-o", str(tmp_path / "c")], input=answers)
    assert "3 of 13 files can't be used" in done.output
    assert "Leave them out, and import the other 10?" in done.output
    assert (tmp_path / "c").exists() is written


def test_python_leaves_out_what_it_may(some_damaged, tmp_path):
    with pytest.raises(pc.UserError, match="3 of 13 files can't be used"):
        pc.import_files(some_damaged, tmp_path / "c")
    found = pc.import_files(some_damaged, tmp_path / "c", skip_unusable=True)
    assert len(found.to_frame()) == 10
    assert any("B_empty.csv" in note and "is empty" in note for note in found.notes)


KILLED = """
import os, sys
from pathlib import Path
rename = Path.rename
def killed(path, target):
    if path.name.endswith(".part"):
        os._exit(9)
    return rename(path, target)
Path.rename = killed
import pipeclamp as pc
pc.import_files(sys.argv[1:-1], sys.argv[-1])
"""


def test_a_campaign_survives_a_kill_while_it_is_replaced(pipeclamp, refused, exports, tmp_path):
    campaign = tmp_path / "clamp_7"
    pipeclamp("import", exports, "-o", campaign)
    before = contents(campaign)
    later = write_texts(tmp_path / "later", [loop(0.6, 2.0)], **GERMAN)
    rooms = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    killed = subprocess.run(
        [sys.executable, "-c", KILLED, str(exports), str(later), str(campaign)], env=rooms, check=False
    )
    assert killed.returncode == 9
    assert not campaign.exists()
    assert list(tmp_path.glob(".clamp_7.*.part"))
    told = refused("metrics", campaign)
    assert "ended while it replaced this campaign" in told
    assert len(told.splitlines()) == 1
    pipeclamp("import", exports, "-o", campaign)
    assert contents(campaign) == before
    joined = pipeclamp("import", exports, later, "-o", campaign)
    assert "1 run of 1 file, 10 more" in joined.stdout
    assert not [path.name for path in tmp_path.iterdir() if path.name.startswith(".")]


def test_a_folder_of_exports_that_is_taken_for_a_campaign(refused, pipeclamp, exports, tmp_path):
    folder = tmp_path / ("ein sehr langer Name " * 10) / "Prüfstand 3"
    shutil.copytree(exports, folder)
    *_, line = refused("identify", folder, "-o", tmp_path / "law.json").splitlines()
    pipeclamp(*shlex.split(line)[1:])
    assert (folder.parent / "Prüfstand 3_campaign" / "runs.csv").is_file()


def test_a_file_without_a_unit_is_asked_for_that_of_the_others(refused, pipeclamp, tmp_path):
    """N had been proposed where all other files state kN; stated so, these were called unusable, to be left out."""
    folder = write_texts(tmp_path / "e", ten_runs()[:3], **GERMAN)
    last = max(folder.iterdir())
    last.write_bytes(last.read_bytes().replace(b"Last [kN]", b"Last"))
    message = refused("import", folder, "-o", tmp_path / "c")
    assert "no unit is stated of 'Last'; other files state kN" in message
    wrong = refused("import", folder, "-o", tmp_path / "c", "--columns", "force=Last [N]")
    assert "got 'Last [N]' (for force), but the file says 'Last [kN]'" in wrong
    assert "--skip-unusable" not in wrong
    option = re.search(r'--columns "([^"]*)"', message)[1]
    pipeclamp("import", folder, "-o", tmp_path / "c", "--columns", option)
    assert len(pc.read_campaign(tmp_path / "c").tests.campaign.runs) == 3


def test_a_run_that_is_left_out_lacks_no_temperature(pipeclamp, tmp_path):
    runs = ten_runs()[:4]
    runs[2] = dataclasses.replace(runs[2], force=-runs[2].force)
    folder = write_texts(tmp_path / "e", runs)
    told = pipeclamp("import", folder, "-o", tmp_path / "c", "--pattern", "T{temperature_C}")
    assert "has the wrong sign" in told.stderr
    assert "4 runs of 4 files, 1 of which can't be used" in told.stdout
    page = (tmp_path / "c" / "import.html").read_text(encoding="utf-8")
    assert page.count('<td class="text">left out</td>') == 1
    assert "Left out: run" not in page
    assert "no temperature" not in told.stdout
    turning = re.search(r"the force of 1 of 4 runs has the wrong sign .* (--columns \"[^\"]*\")", told.stderr)[1]
    assert "force=-" in turning, "and the others are imported without it"


@pytest.mark.skipif(sys.platform == "win32", reason="needs a pseudo-terminal")
@pytest.mark.parametrize("answer", ["n", "y"])
def test_at_a_terminal_results_are_asked_for_as_records_are(tmp_path, answer):
    import pty

    rows = "\n".join(f"{f};0.5;{900 * f**0.1};{150 * f**0.2}" for f in (1, 5, 20))
    (tmp_path / "mount.csv").write_text(f"Frequency;Amplitude;K';K\"\nHz;mm;N/mm;N/mm\n{rows}\n")
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "pipeclamp", "import", "mount.csv", "-o", "c"]
    with subprocess.Popen(
        command, cwd=tmp_path, stdin=theirs, stdout=theirs,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}, stderr=subprocess.PIPE, encoding="utf-8",
    ) as process:  # fmt: skip
        os.close(theirs)
        shown = b""
        while b"right?" not in shown:
            shown += os.read(ours, 4096)
        os.write(ours, f"{answer}\n".encode())
        with contextlib.suppress(OSError):  # the terminal is closed from the other side
            while more := os.read(ours, 4096):
                shown += more
        errors = process.stderr.read()
    os.close(ours)
    assert "Are these channels and units right?" in shown.decode() and "storage_stiffness" in shown.decode()
    assert (process.returncode, (tmp_path / "c").exists()) == ((0, True) if answer == "y" else (1, False))
    assert ("nothing was written: the import wasn't confirmed" in errors) == (answer == "n")
