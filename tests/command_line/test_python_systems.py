"""Python's systems, virtual tests and catalogue: what the commands give, and clear where it can't serve."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import polars as pl
import pytest
import typer
from banded import banded
from few_effects import few_effects
from project import EXAMPLES, ROOT
from rounding import to_rounding

import pipeclamp as pc
from pipeclamp.cli.app import app, main
from pipeclamp_models.realise import catalogue_answer

PLAN = {"amplitudes": [0.3, 0.9], "frequencies": [1, 4], "temperatures": [20], "rate": 300, "seed": 3}
STUDY = """name = "hot"
system = "system.toml"
vary = { "system.clamps.clamp1.temperature_C" = [20.0, 150.0] }
"""


@pytest.fixture
def system(tmp_path):
    """A cantilever's SYSTEM.toml."""
    return banded(tmp_path, 0.3)


def contents(folder: Path) -> dict[str, bytes]:
    """What a folder's files hold, all but its description, which names the command."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and path.name != "campaign.toml"
    }


def test_every_command_has_a_call_or_a_reason():
    """The table in the reference names each command once, and calls that there are."""
    page = (ROOT / "docs" / "reference" / "api.md").read_text(encoding="utf-8")
    table = page.partition("## Commands and calls")[2].partition("\n## ")[0]
    rows = [line.split("|")[1:3] for line in table.splitlines() if line.startswith("| `")]
    commands = [row[0].split("`")[1].split()[0] for row in rows]
    assert sorted(set(commands)) == sorted(typer.main.get_command(app).commands)
    for _, call in rows:
        if "`pc." in call:
            assert call.split("`pc.")[1].split("(")[0] in pc.__all__, call


def test_tests_have_a_length_and_go_through_their_runs(small, tests):
    names = pl.read_csv(small / "runs.csv")["run"].to_list()
    assert len(tests) == len(names) == 8
    assert sorted(tests) == sorted(names)
    assert all(tests.record(run).height > 100 for run in tests)


def test_metrics_are_saved_as_the_command_writes_them(pipeclamp, small, tests, tmp_path):
    pipeclamp("metrics", small, "-o", tmp_path / "theirs")
    ours = tests.save_metrics(tmp_path / "ours")
    assert contents(ours) == contents(tmp_path / "theirs")
    law = pc.identify(ours)
    assert law.file.fit.of_metrics
    with pytest.raises(pc.UserError, match="exists already"):
        tests.save_metrics(tmp_path / "ours")


def test_the_catalogue_is_the_commands(pipeclamp, tmp_path):
    listed = pipeclamp("effects").stdout
    catalogue = pc.effects()
    assert len(catalogue) == len(list(catalogue)) > 40
    assert all(name.partition(":")[0] in listed for name in catalogue)
    assert "<table" in catalogue._repr_html_()
    one = catalogue["memory:2"]
    done = pipeclamp("effects", "memory:2", "--json", tmp_path / "one.json").stdout
    assert one.to_dict() == json.loads((tmp_path / "one.json").read_text(encoding="utf-8"))
    assert one.names == ("memory:2",)
    assert all(line in done for line in str(one).splitlines())
    assert one.parameters()["symbol"].to_list() == ["k_s1", "z_s1", "k_s2", "z_s2"]
    declaration = next((ROOT / "tests" / "effects" / "declared").glob("*.toml"))
    own = pc.effects(declared=[declaration])
    assert len(own) == len(catalogue) + 1
    assert pc.effects(declaration).names[0] in own
    assert pc.schema("effects")["title"] == "CatalogueAnswer"


def test_frames_of_the_catalogue_typeset_no_equation(monkeypatch):
    """They had taken 5 s for equations that they don't hold."""
    one = pc.effects("memory:2")
    (row,) = one.to_dict()["effects"]
    frame, parameters = one.to_frame(), one.parameters()
    assert frame.to_dicts() == [
        {**{name: row[name] for name in frame.columns}, "imitated_by": ", ".join(row["imitated_by"])}
    ]
    assert parameters.to_dicts() == [{"effect": "memory:2", **each} for each in row["parameters"]]

    def typeset(effect):
        raise AssertionError(effect.name)

    monkeypatch.setattr(catalogue_answer, "effect_statements", typeset)
    again = pc.effects("memory:2")
    assert again.to_frame().equals(frame)
    assert again.parameters().equals(parameters)


def test_a_virtual_campaign_is_the_commands(pipeclamp, tmp_path):
    words = ["--amplitudes", "0.3,0.9", "--frequencies", "1,4", "--temperatures", "20", "--rate", "300", "--seed", "3"]
    pipeclamp("rig", "emwm2", "-o", tmp_path / "theirs", "--effects", "viscous,coulomb", "--set", "c1=2", *words)
    made = pc.rig("emwm2", tmp_path / "ours", effects=["viscous", "coulomb"], values={"c1": 2.0}, **PLAN)
    assert contents(made.folder) == contents(tmp_path / "theirs")
    frame = {row["parameter"]: row for row in made.to_frame().to_dicts()}
    assert (frame["c1"]["value"], frame["c1"]["from"]) == (2.0, "given")
    assert {frame["F_c"]["from"], frame["k10"]["from"]} == {"typical size", "law"}
    assert "pc.rig('emwm2', effects=('viscous', 'coulomb'), values={'c1': 2.0}" in made.tests().tests.notes
    assert "Beside the law's file: c1 = 2 N s/mm (given), F_c = " in str(made)
    assert len(made.tests()) == made.to_dict()["runs"] == 4
    assert "Beyond the law's data: A = 3 mm" in str(
        pc.rig("emwm2", tmp_path / "far", amplitudes=3, frequencies=[2], temperatures=[20], rate=100)
    )


def test_campaigns_are_joined_as_by_the_command(pipeclamp, small, tests, tmp_path):
    other = pc.rig("emwm2", tmp_path / "next", **PLAN).folder
    pipeclamp("join", small, other, "-o", tmp_path / "theirs")
    both = pc.join([tests, other], tmp_path / "ours")
    assert contents(tmp_path / "ours") == contents(tmp_path / "theirs")
    assert len(both) == 12


def test_a_response_is_the_commands(pipeclamp, system, tmp_path):
    text = system.read_text(encoding="utf-8")
    few = text.replace("to_Hz = 24.0", "to_Hz = 17.0").replace("dots = 0", "dots = 0, harmonics = 1")
    system.write_text(few, encoding="utf-8")
    done = pipeclamp("response", system, "-o", tmp_path / "theirs.csv")
    found = pc.response(system)
    assert found.save(tmp_path / "ours.csv").read_bytes() == (tmp_path / "theirs.csv").read_bytes()
    assert found.to_frame().columns == pl.read_csv(tmp_path / "ours.csv").columns
    told = done.stdout + done.stderr  # what isn't to be trusted stands there
    assert all(line in told for line in str(found).splitlines() if not line.startswith("Next"))
    assert "Displacement at tip" in found.report(tmp_path / "page.html").read_text(encoding="utf-8")
    json.dumps(found.to_dict(), allow_nan=False)
    banded = pc.response(system, bands=95, limits={"tip": 0.01})
    assert '"95% band"' in banded.report(tmp_path / "banded.html").read_text(encoding="utf-8"), "its key in the legend"
    assert "above 0.01 mm with a probability of" in str(banded)
    assert "clamp1.s_high [mm]" in banded.to_frame().columns
    peak = banded.peaks().row(0, named=True)
    assert peak["point"] == "clamp1"
    assert peak["amplitude_low_mm"] < peak["amplitude_mm"] < peak["amplitude_high_mm"]
    states = found.to_frame()
    assert peak["amplitude_mm"] == states["clamp1.s [mm]"].max()


def test_a_run_with_other_values_is_that_of_files_which_state_them(system, tmp_path):
    """A warmer clamp on a pipe of thicker wall, of values and of files."""
    values = {"system.clamps.clamp1.temperature_C": 150.0, "pipe.pipe.wall_mm": 5.0}
    varied = pc.cosim(system, values=values)
    told = varied._told()[1]
    assert told[0] == "With system.clamps.clamp1.temperature_C = 150, pipe.pipe.wall_mm = 5."
    assert told[-1].startswith("Next, once system.clamps.clamp1.temperature_C = 150")
    before = pc.cosim(system)
    for path, old, new in (
        (system, "temperature_C = 20.0", "temperature_C = 150.0"),
        (system.with_name("pipe.toml"), "wall_mm = 3.91", "wall_mm = 5.0"),
    ):
        text = path.read_text(encoding="utf-8")
        assert old in text
        path.write_text(text.replace(old, new), encoding="utf-8")
    written = pc.cosim(system)
    assert varied.to_dict() == to_rounding(written.to_dict())
    assert varied.amplitude("tip") != before.amplitude("tip")


def test_a_sweep_is_the_commands(pipeclamp, system, tmp_path):
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    pipeclamp("sweep", tmp_path / "study.toml", "-o", tmp_path / "theirs.parquet", "--jobs", "1")
    told: list[str] = []
    found = pc.sweep(tmp_path / "study.toml", tmp_path / "ours.parquet", jobs=1, progress=told.append)
    theirs = pl.read_parquet(tmp_path / "theirs.parquet").drop("seconds")
    assert found.to_frame().drop("seconds").equals(theirs)
    assert len(found) == 2
    assert told[-1] == "2 of 2 cases"
    assert "moves most at" in str(found)
    assert "Vibration level" in found.report(tmp_path / "page.html").read_text(encoding="utf-8")
    assert found.to_dict()["varied"] == {"system.clamps.clamp1.temperature_C": [20.0, 150.0]}


def test_a_system_is_packaged_as_by_the_command(pipeclamp, system, tmp_path):
    done = pipeclamp("system", system, "-o", tmp_path / "theirs.ssp", "--kind", "python").stdout
    made = pc.build_system(system, tmp_path / "ours.ssp")
    assert Path(made).stat().st_size == (tmp_path / "theirs.ssp").stat().st_size
    assert str(made).splitlines()[1] in done
    assert made.step_s > 0


def test_parameters_are_put_into_an_fmu_as_by_the_command(pipeclamp, tmp_path):
    fmu = pc.build_fmu("published_R1", tmp_path / "clamp.fmu")
    pipeclamp("set-parameters", fmu, "published_R2", "-o", tmp_path / "theirs.fmu")
    ours = pc.set_parameters(fmu, "published_R2", tmp_path / "ours.fmu")
    assert ours.read_bytes() == (tmp_path / "theirs.fmu").read_bytes()
    assert pc.set_parameters(fmu, "published_R2") == fmu
    assert fmu.read_bytes() == ours.read_bytes()


def test_a_pipe_is_held_against_what_was_measured_as_by_the_command(pipeclamp, tmp_path):
    for name in ("pipe.toml", "system.toml"):
        text = (EXAMPLES / name).read_text(encoding="utf-8").replace("clamp_a.json", "emwm2")
        (tmp_path / name).write_text(text, encoding="utf-8")
    measured = tmp_path / "measured"
    measured.mkdir()
    text = '[[probes]]\nname = "midspan"\nunit = "mm"\n[[responses]]\nfile = "sines.csv"\n'
    (measured / "measurement.toml").write_text(text, encoding="utf-8")
    rows = [f"{f},0.5,{a}" for f, a in ((3.0, 2.2), (3.4, 3.6), (3.8, 8.1), (4.2, 10.2), (4.6, 4.0))]
    header = "frequency_Hz,acceleration_m_s2,midspan_amplitude"
    (measured / "sines.csv").write_text("\n".join([header, *rows, ""]), encoding="utf-8")
    done = pipeclamp("compare", tmp_path / "system.toml", measured, "--json", tmp_path / "answer.json")
    found = pc.compare_pipe(tmp_path / "system.toml", measured)
    theirs = json.loads((tmp_path / "answer.json").read_text(encoding="utf-8"))
    assert found.to_dict() == to_rounding(theirs)
    assert all(line in done.stdout for line in str(found).splitlines())
    assert repr(found).endswith(f"error {found.nrmse:.2%}>")
    assert found.verdict is None, "five values are too few to ask"
    with pytest.raises(pc.UserError, match="too little was measured"):
        found.candidates()
    assert found.to_frame()["frequency_Hz"].to_list() == [3.0, 3.4, 3.8, 4.2, 4.6]
    assert "Response at midspan" in found.report(tmp_path / "page.html").read_text(encoding="utf-8")


def test_the_next_tests_drive_signal_is_saved_and_run(tmp_path):
    """Two frequencies are too few to tell a stiffness that follows them from a mass."""
    plan = {"amplitudes": [0.3, 0.6, 1.0], "frequencies": [3, 4], "temperatures": [20], "cycles": 3, "rate": 240}
    tests = pc.rig("emwm2", tmp_path / "narrow", force_noise=8, **plan).tests()
    law, limits = pc.identify(tests), "A=0.1..1.5,f=0.5..20,T=20..20"
    with few_effects("stiffness_frequency", "inertia"):
        answer = pc.diagnose(law, tests, limits=limits)
    assert answer.verdict == "ambiguous"
    path = answer.save_drive(tmp_path / "next.csv")
    signal = pl.read_csv(path)
    assert signal["displacement_mm"].abs().max() == pytest.approx(answer.next_test["peak_displacement_mm"], rel=1e-3)
    assert str(answer).endswith("answer.save_drive('next_test.csv') writes the drive signal from here")
    with pytest.raises(pc.UserError, match=r"expected a name that ends in \.csv or \.parquet"):
        answer.save_drive(tmp_path / "next.txt")
    # the rig runs it
    made = pc.rig("emwm2", tmp_path / "next", drive=path, temperatures=[20], rate=1000)
    assert made.tests().to_frame()["amplitude_mm"][0] == pytest.approx(answer.next_test["amplitude_mm"], rel=0.05)


def test_a_ladder_is_the_commands(small, tests, tmp_path, monkeypatch):
    """Of a catalogue of few effects, and in this process, to be quick."""
    path = pc.identify(tests).save(tmp_path / "law.json")
    files = ["--auto", tmp_path / "law2.json", "--json", tmp_path / "answer.json"]
    monkeypatch.setattr(sys, "argv", ["pipeclamp", "diagnose", str(path), str(small), *map(str, files), "--jobs", "1"])
    with few_effects("damping_temperature", "coulomb"):
        with pytest.raises(SystemExit):
            main()
        answer = pc.diagnose(path, tests, auto=True)
    theirs = json.loads((tmp_path / "answer.json").read_text(encoding="utf-8"))
    assert answer.ladder == to_rounding(theirs["ladder"]) != []
    assert (answer.verdict, list(answer.effects)) == (theirs["verdict"], theirs["effects"])
    assert answer.law.values == to_rounding(pc.open_law(tmp_path / "law2.json").values)
    assert answer.law.file.diagnosis.verdict == answer.verdict
    assert f"{answer.ladder[0]['heldout_after']:.2%}" in str(answer).splitlines()[0]


MISTAKES = {
    "no number": (lambda at: pc.response(at, bands="95"), "bands: got '95'; expected a finite number of per cent"),
    "nan": (lambda at: pc.cosim(at, bands=float("nan")), "bands: got nan"),
    "no band": (lambda at: pc.response(at, bands=100), "bands: got 100; expected a number from 1 to 99.9"),
    "limits alone": (lambda at: pc.response(at, limits={"tip": 1.0}), "expected bands=95 beside it"),
    "no point": (lambda at: pc.response(at, bands=95, limits={"tipp": 1.0}), "did you mean 'tip'"),
    "no size": (lambda at: pc.response(at, bands=95, limits={"tip": 0.0}), "limits: got tip=0; expected"),
    "limits in a row": (lambda at: pc.response(at, bands=95, limits=[1.0]), 'such as {"clamp1": 0.8}'),
    "no system": (lambda at: pc.response(None), "expected the description of a system"),
    "a pipe": (lambda at: pc.response(at.with_name("pipe.toml")), "describes a pipe; expected a system"),
    "no place": (lambda at: pc.cosim(at, values={"clamps.x": 1.0}), "values 'clamps.x': expected pipe.… or system.…"),
    "no such clamp": (
        lambda at: pc.cosim(at, values={"system.clamps.clamp9.temperature_C": 1.0}), "did you mean 'clamp1'",
    ),
    "values of nothing": (lambda at: pc.cosim(at, values={"pipe.pipe.wall_mm": None}), "got None; expected a finite"),
    "values and bands": (lambda at: pc.cosim(at, bands=95, values={"pipe.pipe.wall_mm": 4.0}), "no values beside them"),
    "no study": (lambda at: pc.sweep(at, at.with_name("s.parquet")), "system.toml"),
    "no processes": (lambda at: pc.sweep(at, at.with_name("s.parquet"), jobs=0), "jobs: got 0"),
    "no effect": (lambda at: pc.effects("memry"), "did you mean 'memory'"),
    "no schema": (lambda at: pc.schema("laws"), "expected one of law, metrics"),
    "no setting": (lambda at: pc.rig("emwm2", at, noise=3.0), "setting 'noise' is not known"),
    "no count": (lambda at: pc.rig("emwm2", at.with_name("c"), repeats=1.5), "repeats: got 1.5; expected a whole"),
    "nan noise": (lambda at: pc.rig("emwm2", at.with_name("c"), force_noise=float("nan")), "force_noise: got nan"),
    "no levels": (lambda at: pc.rig("emwm2", at.with_name("c"), amplitudes=[]), "got an empty list"),
    "levels as text": (lambda at: pc.rig("emwm2", at.with_name("c"), amplitudes="0.5"), "amplitudes: got '0.5'"),
    "kelvin below 0": (lambda at: pc.rig("emwm2", at.with_name("c"), temperatures=[-300]), "temperature is -300 °C"),
    "no value": (lambda at: pc.rig("emwm2", at.with_name("c"), values={"k11": 1.0}), "values: k11 is no parameter"),
    "no density": (
        lambda at: pc.rig("emwm2", at.with_name("c"), effects="density"), "values={'density_g_cm3': ...}",
    ),
    "there": (lambda at: pc.rig("emwm2", at.parent), "exists already"),
    "stated twice": (
        lambda at: pc.rig("emwm2", at.with_name("c"), plan=at, cycles=3), "plan: got cycles as well",
    ),
    "one campaign": (lambda at: pc.join("clamp_a", at.with_name("c")), "expected several campaigns, in a list"),
    "no campaign": (lambda at: pc.join([], at.with_name("c")), "got no campaign"),
    "the same twice": (lambda at: pc.join(["clamp_a", "clamp_a"], at.with_name("c")), "has the same record as"),
    "other kind": (lambda at: pc.build_system(at, at.with_name("s.ssp"), kind="java"), "kind: got 'java'"),
    "a system for a law": (lambda at: pc.compare(at, "clamp_a"), "expected a law: pc.compare_pipe holds a system"),
    "a system for one": (lambda at: pc.identify("clamp_a", effects=at), "system.toml"),
    "no ending": (lambda at: pc.build_fmu("emwm2", at.with_name("clamp")), "expected clamp.fmu, say"),
    "a pipe's ending": (lambda at: pc.build_pipe(at.with_name("pipe.toml"), at.with_name("p.zip")), "expected p.fmu"),
    "a system's ending": (lambda at: pc.build_system(at, at.with_name("s.fmu")), "ends in .ssp"),
    "two campaigns": (lambda at: pc.identify(["clamp_a", "emwm2_tables"]), "pc.join makes one of several"),
    "no fmu": (lambda at: pc.set_parameters(at, "emwm2"), "system.toml"),
    "no measurement": (lambda at: pc.compare_pipe(at, at.parent), "measurement.toml"),
    "hours": (lambda at: pc.plan_campaign(hours=-1), "hours: got -1; expected a number above 0"),
    "seed": (lambda at: pc.plan_campaign(seed="a"), "seed: got 'a'; expected a whole number"),
    "heating": (lambda at: pc.plan_campaign(heating=0), "heating: got 0; expected a number above 0"),
}  # fmt: skip


@pytest.mark.parametrize("name", MISTAKES)
def test_mistakes_are_told_in_the_words_of_the_call(name, system):
    mistake, words = MISTAKES[name]
    before = contents(system.parent)
    with pytest.raises(pc.UserError) as raised:
        mistake(system)
    assert words in str(raised.value)
    assert "--" not in str(raised.value)
    assert contents(system.parent) == before, "nothing is written"
