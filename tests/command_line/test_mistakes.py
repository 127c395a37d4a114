"""A user's mistakes: one message on stderr that names the place, status 1, no output file, no traceback."""

from __future__ import annotations

import gzip
import json
import os
import re
import shutil
import signal
import time
from pathlib import Path

import pytest
import typer
from project import EXAMPLES

from pipeclamp.cli.app import app


@pytest.fixture
def broken(small, tmp_path):
    """Give a function that copies the small campaign with one of its records replaced."""

    def make(content=None, *, name=None, table=None, description=None):
        folder = tmp_path / "broken"
        shutil.copytree(small, folder)
        first = sorted((folder / "runs").iterdir())[0]
        if content is not None:
            target = first if name is None else first.with_name(name)
            first.unlink()
            target.write_bytes(content if isinstance(content, bytes) else content.encode())
            if name is not None:
                runs = folder / "runs.csv"
                runs.write_text(runs.read_text(encoding="utf-8").replace(first.name, name), encoding="utf-8")
        if table is not None:
            (folder / "runs.csv").write_text(table, encoding="utf-8")
        if description is not None:
            (folder / "campaign.toml").write_text(description, encoding="utf-8")
        return folder, first.stem

    return make


def text_of(small: Path) -> str:
    return sorted((small / "runs").iterdir())[0].read_text(encoding="utf-8")


def half_a_gzip(small: Path) -> bytes:
    whole = gzip.compress(text_of(small).encode())
    return whole[: len(whole) // 2]


@pytest.mark.skipif(os.name == "nt", reason="names of folders are text there")
def test_a_folder_whose_name_is_no_text_is_read_and_told_as_it_is_shown(pipeclamp, small, tmp_path):
    folder = tmp_path / os.fsdecode("próba".encode("cp1250"))
    try:
        shutil.copytree(small, folder)
    except OSError:
        pytest.skip("folders are named in UTF-8 alone here")
    law, report = tmp_path / "law.json", tmp_path / "r.html"
    assert r"pipeclamp compare" in pipeclamp("identify", folder, "-o", law).stdout
    assert json.loads(law.read_text(encoding="utf-8"))["command"] == r"pipeclamp identify pr\udcf3ba -o law.json"
    pipeclamp("identify", folder, "-o", law, "--name", folder.name)
    assert json.loads(law.read_text(encoding="utf-8"))["name"] == "pr?ba"
    pipeclamp("compare", law, folder, "--report", report)
    assert r"pr\udcf3ba" in report.read_text(encoding="utf-8")


def test_a_mistake_is_status_1_with_one_message(pipeclamp, tmp_path):
    done = pipeclamp("metrics", tmp_path / "nowhere", status=1)
    assert done.stdout == ""
    assert done.stderr.startswith("pipeclamp: ")
    assert done.stderr.count("\n") == 1


def test_a_missing_folder(refused, tmp_path):
    message = refused("identify", tmp_path / "nowhere", "-o", tmp_path / "law.json")
    assert "nowhere" in message
    assert "expected" in message
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "time_s"),
        (b"time_s,displacement_mm\n0,1\n0.01,2\n", "force_N"),
        (b"time_s,displacement_mm,force_N\n0,1,abc\n0.01,1,2\n", "force_N"),
        (b"\x00\xff\xfe\x00 not a table \x00\x9c", ""),
    ],
    ids=["empty", "column-missing", "text-in-a-number", "binary"],
)
def test_a_record_that_is_no_table(refused, broken, tmp_path, content, words):
    folder, run = broken(content)
    message = refused("identify", folder, "-o", tmp_path / "law.json")
    assert run in message
    assert words in message
    assert not (tmp_path / "law.json").exists()


def test_a_gzip_that_ends_in_its_middle(refused, broken, small, tmp_path):
    folder, _ = broken(half_a_gzip(small), name="half.csv.gz")
    message = refused("metrics", folder, "--json", tmp_path / "metrics.json")
    assert "half.csv.gz" in message
    assert not (tmp_path / "metrics.json").exists()


@pytest.mark.parametrize("bad", ["", "NaN", "inf", "1e300"])
def test_a_run_with_a_sample_that_is_none_is_left_out_and_named(pipeclamp, refused, broken, small, tmp_path, bad):
    lines = text_of(small).splitlines()
    lines[200] = ",".join([*lines[200].split(",")[:2], bad])
    folder, run = broken("\n".join(lines) + "\n")
    law = tmp_path / "law.json"
    done = pipeclamp("identify", folder, "-o", law)
    assert f"warning: run {run!r} is left out: " in done.stderr
    assert "row 201" in done.stderr
    left_out = json.loads(law.read_text(encoding="utf-8"))["data"]["left_out"]
    assert [entry["run"] for entry in left_out] == [run]
    law.unlink()
    assert run in refused("identify", folder, "-o", law, "--strict")
    assert not law.exists()


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("run,file\n", "run"),
        ("run\nA\n", "file"),
        ("run,file,temperature_C\nA,runs/none.csv,20\n", "none.csv"),
        ("run,file,temperature_C\nA,runs/A0p3_f1_T20.csv,warm\n", "temperature_C"),
        ("run,file,temperature_C\nA,runs/A0p3_f1_T20.csv,-300\n", "temperature_C"),
        ("run,file\nA,runs/A0p3_f1_T20.csv\nA,runs/A0p3_f1_T20.csv\n", "A"),
    ],
    ids=["no-runs", "column-missing", "record-missing", "text", "below-absolute-zero", "twice"],
)
def test_a_wrong_table(refused, broken, tmp_path, table, words):
    folder, _ = broken(table=table)
    message = refused("compare", "emwm2", folder, "--json", tmp_path / "compare.json")
    assert words in message
    assert not (tmp_path / "compare.json").exists()


@pytest.mark.parametrize("description", ["", "name = 3\n", "name = \n", 'name = "x"\nnots = "y"\n'])
def test_a_wrong_description(refused, broken, tmp_path, description):
    folder, _ = broken(description=description)
    assert "campaign.toml" in refused("metrics", folder, "--json", tmp_path / "metrics.json")


def changed(law: Path, **entries) -> dict:
    return {**json.loads(law.read_text(encoding="utf-8")), **entries}


def coefficients(law: Path, **entries) -> dict:
    file = json.loads(law.read_text(encoding="utf-8"))
    return {**file, "coefficients": {**file["coefficients"], **entries}}


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda law: "", "JSON"),
        (lambda law: "{", "JSON"),
        (lambda law: "[1, 2]", "law.json"),
        (lambda law: "{}", "schema"),
        (lambda law: json.dumps(changed(law, schema="pipeclamp-law-99")), "schema"),
        (lambda law: json.dumps(changed(law, base="cubic")), "cubic"),
        (lambda law: json.dumps(changed(law, effects=["memroy"])), "did you mean 'memory'"),
        (lambda law: json.dumps(changed(law, effects=["viscous"])), "c1"),
        (lambda law: json.dumps(coefficients(law, k99={"value": 1, "unit": "N", "state": "given"})), "k99"),
        (lambda law: json.dumps(coefficients(law, k10={"value": 1e6, "unit": "N/m", "state": "given"})), "'N/mm'"),
        (lambda law: json.dumps(coefficients(law, k10={"value": None, "unit": "N/mm", "state": "given"})), "k10"),
        (lambda law: json.dumps(coefficients(law, k10={"value": 1e400, "unit": "N/mm", "state": "given"})), "k10"),
        (
            lambda law: json.dumps(coefficients(law, k10={"value": "soft", "unit": "N/mm", "state": "given"})),
            "law.json: coefficients.k10.value: got 'soft'; expected a number; correct it (pipeclamp-law-1), or fit",
        ),
        (lambda law: json.dumps(changed(law, smoothing={"v_r": 0.0, "y_r": 1.0})), "v_r"),
        (lambda law: json.dumps(changed(law, further=1)), "further"),
        (lambda law: b"\xff\xfe\x00".decode("latin-1"), "law.json"),
    ],
)
@pytest.mark.parametrize("what", ["compare", "build-fmu"])
def test_a_wrong_law(refused, law, small, tmp_path, make, words, what):
    path = tmp_path / "law.json"
    path.write_text(make(law), encoding="utf-8")
    output = tmp_path / "output.fmu"
    arguments = (path, small, "--json", output) if what == "compare" else (path, "-o", output)
    assert words in refused(what, *arguments)
    assert not output.exists()


def test_a_file_that_is_not_there_is_said_without_the_systems_numbers(refused, law, small, tmp_path):
    for words in (
        ("compare", tmp_path / "none.json", small),
        ("metrics", tmp_path),
        ("add", law, tmp_path / "none.toml", small, "-o", tmp_path / "x.json"),
        ("compare", EXAMPLES / "system.toml", tmp_path),
    ):
        message = refused(*words)
        assert "no such file; expected" in message
        assert "Errno" not in message


def test_a_file_where_a_campaign_is_expected(refused, small):
    assert "runs.csv: is a file; expected a campaign's folder" in refused("metrics", small / "runs.csv")


def test_a_declaration_where_a_law_or_system_is_expected(refused, small, tmp_path):
    (tmp_path / "bracket.toml").write_text('id = "bracket"\n[[parameters]]\nsymbol = "k"\n', encoding="utf-8")
    assert "declares the effect 'bracket'; expected a law" in refused("compare", tmp_path / "bracket.toml", small)
    told = refused("plan", "-o", tmp_path / "plan", "--law", tmp_path / "bracket.toml")
    assert "declares the effect 'bracket'; expected a law" in told


def test_an_output_that_is_a_folder(refused, law, small, tmp_path):
    (tmp_path / "there").mkdir()
    message = refused("metrics", small, "--json", tmp_path / "there")
    assert "there: is a folder; expected the name of a file" in message
    assert [path.name for path in tmp_path.iterdir()] == ["there"]


def test_a_dash_is_no_file_to_write(refused, law, small, tmp_path, monkeypatch):
    """Who means stdout had got a file of that name, which few commands of a shell take away again."""
    monkeypatch.chdir(tmp_path)
    for words in (("compare", law, small, "--json", "-"), ("identify", small, "-o", "-")):
        assert "-: stands for no stdout here; expected the name of a file" in refused(*words)
    assert list(tmp_path.iterdir()) == []


OUTPUTS = [
    (name, option.opts[0], len([entry for entry in command.params if entry.param_type_name == "argument"]))
    for name, command in typer.main.get_command(app).commands.items()
    for option in command.params
    if {"-o", "--json", "--report", "--auto"} & set(option.opts)
]


@pytest.mark.parametrize(("command", "option", "arguments"), OUTPUTS)
def test_an_output_that_cannot_be_written_is_refused_before_any_work(refused, tmp_path, command, option, arguments):
    """The input isn't there either: it was not looked at."""
    further = ["-o", tmp_path / "o"] if option != "-o" and (command, "-o", arguments) in OUTPUTS else []
    words = (command, *["absent"] * arguments, *further, option)
    assert "none doesn't exist); expected an existing folder" in refused(*words, tmp_path / "none" / "file")
    if command != "studio":  # which goes on in the folder where it stopped
        assert re.search("is a folder|exists already", refused(*words, tmp_path))
    assert list(tmp_path.iterdir()) == []


def test_a_law_of_a_newer_program_is_used_with_a_note(pipeclamp, law, small, tmp_path):
    newer = tmp_path / "newer.json"
    newer.write_text(json.dumps(changed(law, software="pipeclamp 9.9.9")), encoding="utf-8")
    assert "newer.json was made by pipeclamp 9.9.9" in pipeclamp("compare", newer, small).stderr
    assert "made by" not in pipeclamp("compare", law, small).stderr


def test_a_law_that_is_not_there(refused, small, tmp_path):
    assert "did you mean 'emwm2'" in refused("compare", "emwm", small)


def test_an_effect_that_is_not_known(refused, law, small, tmp_path):
    for words in (
        ("identify", small, "-o", tmp_path / "x.json", "--effects", "damping_temprature"),
        ("add", law, "damping_temprature", small, "-o", tmp_path / "x.json"),
        ("rig", law, "-o", tmp_path / "virtual", "--effects", "damping_temprature"),
    ):
        assert "did you mean 'damping_temperature'" in refused(*words)
    assert list(tmp_path.iterdir()) == []


def test_an_effect_that_is_there_already(refused, small, tmp_path):
    message = refused("add", "emwm2", "contact_growth", small, "-o", tmp_path / "x.json")
    assert "contact_growth" in message
    assert "already" in message
    assert "(" not in message


def test_a_value_that_no_input_could_make_sense_of_is_usage(refused, law, small, tmp_path):
    """Status 2, a mistake in the call; what depends on a law or on tests is 1."""
    for words, expected in (
        (("diagnose", law, small, "--limits", "A=2..1,f=1..2,T=20..30"), "lower end first"),
        (("diagnose", law, small, "--limits", "wide"), "expected A=0.1..2"),
        (("diagnose", law, small, "--drive", tmp_path / "drive.txt"), "ends in .csv or .parquet"),
        (("rig", law, "-o", tmp_path / "x", "--drive", "drive.csv", "--riding", "0.2"), "got --riding as well"),
        (("rig", law, "-o", tmp_path / "x", "--repeats", "0"), "0 repeats"),
        (("rig", law, "-o", tmp_path / "x", "--amplitudes", "0,3;1"), "--amplitudes"),
        (("rig", law, "-o", tmp_path / "x", "--set", "c1"), "name=value"),
        (("build-fmu", law, "-o", tmp_path / "x.fmu", "--kind", "python", "--fmi", "3"), "--kind native"),
        (("build-fmu", law, "-o", tmp_path / "x.fmu", "--kind", "native", "--platforms", "amiga"), "'amiga'"),
    ):
        assert expected in refused(*words, status=2)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("--freeze", "k1_T"), "name=value"),
        (("--freeze", "k1_T=soft"), "expected numbers"),
        (("--freeze", "k1_T=nan"), "expected finite numbers"),
        (("--freeze", "k1_T=0,k1_T=-1"), "--freeze: k1_T is given twice in 'k1_T=0,k1_T=-1'; expected each name once"),
        (("--freeze", "c0=-1"), "--freeze: got c0=-1; expected at least 0, where a fit may take it"),
        (("--freeze", "alpha0=1e30"), "--freeze: got alpha0=1e+30; expected at most 2.5, where"),
        (("--freeze", "k1T=0"), "--freeze: parameter 'k1T' is not known; did you mean 'k1_T'"),
        (("--method", "surfaces", "--effects", "viscous"), "without effects"),
    ],
)
def test_options_that_never_serve(refused, small, tmp_path, words, expected):
    assert expected in refused("identify", small, "-o", tmp_path / "x.json", *words, status=2)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("--freeze", "k10=1e300"), "beyond all reason"),
        (("--effects", "viscous,viscous"), "twice"),
        (("--effects", "condition:current_A"), "current_A"),
        (("--effects", "memory:many"), "memory:2"),
    ],
)
def test_options_that_cannot_serve(refused, small, tmp_path, words, expected):
    assert expected in refused("identify", small, "-o", tmp_path / "x.json", *words)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("--amplitudes", "-1"), "amplitude"),
        (("--frequencies", "0"), "frequency"),
        (("--temperatures", "-300"), "-273.15"),
        (("--cycles", "0.5"), "cycle"),
        (("--cycles", "1e12"), "samples"),
        (("--rate", "10"), "samples per cycle"),
        (("--force-noise", "-1"), "force_noise"),
    ],
)
def test_a_test_plan_that_cannot_be_run(refused, tmp_path, words, expected):
    assert expected in refused("rig", "emwm2", "-o", tmp_path / "virtual", *words, status=2)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("--amplitudes", "1e300"), "no finite force"),
        (("--set", "k99=1"), "k99"),
        (("--effects", "memory", "--set", "k_S=1"), "did you mean 'k_s'? it has"),
        (("--effects", "density"), "state a value for each: --set density_g_cm3="),
        (("--effects", "viscous", "--set", "c1=-1"), "c1 = -1 N s/mm (viscous coefficient); expected at least 0"),
    ],
)
def test_a_test_plan_that_cannot_be_run_with_this_law(refused, tmp_path, words, expected):
    assert expected in refused("rig", "emwm2", "-o", tmp_path / "virtual", *words)
    assert list(tmp_path.iterdir()) == []


def test_a_campaign_is_never_overwritten(refused, small):
    before = {path.name: path.read_bytes() for path in small.iterdir() if path.is_file()}
    assert "exists already" in refused("rig", "emwm2", "-o", small)
    assert before == {path.name: path.read_bytes() for path in small.iterdir() if path.is_file()}


def test_an_output_folder_that_is_missing(refused, law, small, tmp_path):
    nowhere = tmp_path / "nowhere"
    for words in (
        ("identify", small, "-o", nowhere / "law.json"),
        ("metrics", small, "--json", nowhere / "metrics.json"),
        ("compare", law, small, "--report", nowhere / "compare.html"),
        ("build-fmu", law, "-o", nowhere / "clamp.fmu"),
        ("rig", law, "-o", nowhere / "virtual"),
    ):
        assert str(nowhere) in refused(*words)
    assert not nowhere.exists()


@pytest.mark.parametrize("name", ["pipe.toml", "system.toml"])
def test_a_wrong_description_of_pipe_or_system(refused, tmp_path, name):
    path = tmp_path / name
    what, output = ("build-pipe", "p.fmu") if name == "pipe.toml" else ("cosim", "result.csv")
    for text in ("", "name = \n", "[pipe]\nouter_diametre_mm = 3\n"):
        path.write_text(text, encoding="utf-8")
        assert name in refused(what, path, "-o", tmp_path / output)
    assert not (tmp_path / output).exists()
    assert "none.toml" in refused(what, tmp_path / "none.toml", "-o", tmp_path / output)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (('law = "clamp_a.json"', 'fmu = "clamp.fmu"'), ["'clamp1'", "law's equations"]),
        (('file = "pipe.toml"', 'fmu = "pipe.fmu"'), ["pipe's equations", "PIPE.toml"]),
        (('kind = "sine"', 'kind = "record"\nfile = "base.csv"'), ["record has no frequency response"]),
        (('at = "clamp1"', 'at = "clmp1"'), ["did you mean 'clamp1'"]),
        (("[run]", "[response]\nfrom_Hz = 5.0\nto_Hz = 4.0\n[run]"), ["response", "isn't below to_Hz = 4"]),
        (("[run]", "[response]\nfrom_Hz = 5.0\nto_Hz = 6.0\nlevel = [1.0]\n[run]"), ["did you mean 'levels'"]),
    ],
)
def test_a_system_without_a_frequency_response(refused, tmp_path, change, words):
    for name in ("pipe.toml", "system.toml"):
        text = (EXAMPLES / name).read_text(encoding="utf-8")
        if "record" in change[1] and name == "system.toml":
            text = text.replace("acceleration_m_s2 = 1.0\nfrequency_Hz = 3.9\n\n[run]", "[run]")
        (tmp_path / name).write_text(text.replace(*change), encoding="utf-8")
    message = refused("response", tmp_path / "system.toml", "-o", tmp_path / "response.csv")
    assert all(word in message for word in words), message
    assert not (tmp_path / "response.csv").exists()


def test_a_response_of_nothing_that_moves(refused, tmp_path):
    pipe = (EXAMPLES / "pipe.toml").read_text(encoding="utf-8")
    system = (EXAMPLES / "system.toml").read_text(encoding="utf-8")
    (tmp_path / "pipe.toml").write_text(pipe.replace(table_of(pipe, "[[probes]]"), ""), encoding="utf-8")
    (tmp_path / "system.toml").write_text(system.replace(table_of(system, "[[clamps]]"), ""), encoding="utf-8")
    message = refused("response", tmp_path / "system.toml", "-o", tmp_path / "response.csv")
    assert "neither a clamp nor a probe" in message


def table_of(text, header):
    """Give a table's lines of a TOML text, up to the next table's."""
    return text[text.index(header) :].partition("\n[")[0]


def test_reading_a_law_never_executes_anything(refused, law, small, tmp_path):
    """Code in every text of the file is text: names, effects, arguments, notes, units."""
    mark = tmp_path / "executed"
    code = f"__import__('pathlib').Path({str(mark)!r}).touch()"
    places = [
        changed(law, base=code),
        changed(law, effects=[code]),
        changed(law, effects=[f"condition:{code}"]),
        changed(law, effects=[f"memory:{code}"]),
        coefficients(law, **{code: {"value": 1, "unit": code, "state": "given"}}),
        coefficients(law, k10={"value": code, "unit": "N/mm", "state": "given"}),
        changed(law, smoothing={"v_r": code, "y_r": 1.0}),
    ]
    for number, content in enumerate(places):
        path = tmp_path / f"{number}.json"
        path.write_text(json.dumps(content), encoding="utf-8")
        refused("compare", path, small)
    assert not mark.exists()


def test_text_in_a_law_reaches_the_fmu_as_text(pipeclamp, law, tmp_path):
    """What may be any text goes into the FMU's source and XML without ending a string or a tag there."""
    nasty = "\"\"\"'''</name>&<![CDATA[ \\n {{ 1/0 }} #"
    path = tmp_path / "law.json"
    path.write_text(json.dumps(changed(law, name="nasty", notes=nasty, command=nasty)), encoding="utf-8")
    pipeclamp("build-fmu", path, "-o", tmp_path / "clamp.fmu")


@pytest.mark.skipif(os.name != "posix", reason="kills with signals")
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL], ids=lambda sent: sent.name)
@pytest.mark.parametrize(
    ("words", "in_the_middle"),
    [
        (("identify", "clamp_a", "--effects", "memory:3"), "fit from start"),
        (("rig", "emwm2", "--cycles", "40", "--rate", "2500"), "rig: A0"),
    ],
    ids=["identify", "rig"],
)
def test_killed_in_the_middle_leaves_no_partial_output(monkeypatch, started, tmp_path, sent, words, in_the_middle):
    monkeypatch.setenv("FORCE_COLOR", "1")  # it tells what it does, as on a terminal
    output = tmp_path / "output.fmu"
    with started(*words, "-o", output) as process:
        told = ""
        while in_the_middle not in told:
            read = process.stderr.read(1)
            assert read, f"it ended before it could be killed: {told}"
            told += read
        process.send_signal(sent)
        told = process.stderr.read()
    assert process.returncode != 0
    assert not output.exists()
    if sent != signal.SIGKILL:
        assert list(tmp_path.iterdir()) == []
        # A shell says 130 of both: where the signal fell into `exec` of a text, Python 3.11 ends by the signal itself.
        how, status = ("terminated", 143) if sent == signal.SIGTERM else ("interrupted", 130)
        assert process.returncode in (status, -signal.SIGINT)
        assert f"pipeclamp: {how}" in told
        assert "Traceback" not in told


@pytest.mark.skipif(os.name != "posix", reason="a shell script stands for the compiler")
def test_terminated_while_it_compiles_leaves_nothing(monkeypatch, started, tmp_path):
    """The compiler's own children are ended, too."""
    beside, scratch, tools = (tmp_path / name for name in ("beside", "scratch", "tools"))
    for folder in (beside, scratch, tools):
        folder.mkdir()
    compiler = tools / "cc"
    compiler.write_text(
        f"#!/bin/sh\nsleep 60 &\necho $! > {beside}/child.part\nmv {beside}/child.part {beside}/child\nwait\n"
    )
    compiler.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tools}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("TMPDIR", str(scratch))
    with started("build-fmu", "emwm2", "--kind", "native", "-o", tmp_path / "clamp.fmu") as process:
        while not (beside / "child").exists():
            assert process.poll() is None
            time.sleep(0.01)
        process.send_signal(signal.SIGTERM)
        told = process.stderr.read()
    assert process.returncode == 143
    assert told == "pipeclamp: terminated: the same command begins anew\n"
    assert list(scratch.iterdir()) == []
    assert not (tmp_path / "clamp.fmu").exists()
    child = int((beside / "child").read_text())
    for _ in range(500):
        try:
            os.kill(child, 0)
        except ProcessLookupError:
            return
        time.sleep(0.01)
    pytest.fail("the compiler's child still runs")


def test_interrupted_while_it_still_loads(started, tmp_path):
    """On a cold disk that takes seconds."""
    (tmp_path / "typer.py").write_text("raise KeyboardInterrupt\n", encoding="utf-8")
    with started("effects", modules=[tmp_path]) as process:
        told = process.stderr.read()
    assert process.returncode == 130
    assert told == "pipeclamp: interrupted: the same command begins anew\n"
