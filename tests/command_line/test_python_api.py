"""The Python API: the commands' answers to rounding, light to import, clear where it can't serve."""

import copy
import doctest
import html
import inspect
import json
import pickle
import re
import shutil
import subprocess
import sys
import warnings
from contextlib import nullcontext
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from few_effects import few_effects
from rounding import to_rounding

import pipeclamp as pc
from pipeclamp_identification.fitting.observations import loop_motion
from pipeclamp_models.law.file import law_of
from pipeclamp_models.realise.force import force_of_law
from pipeclamp_models.realise.motion import sinusoids

DOCUMENTED_ELSEWHERE = {
    "Cosimulation", "Diagnosis", "Discovery", "LawsComparison", "LoopTests", "PipeComparison", "PlannedCampaign",
    "Response", "Rig", "Sweep", "SystemPackage", "UserError",
}  # fmt: skip
"""What the example of another public name makes and shows."""


@pytest.fixture(scope="module")
def law(tests):
    return pc.identify(tests)


def answered(pipeclamp, folder, *words):
    """What a command writes with --json."""
    pipeclamp(*words, "--json", folder / "answer.json")
    return json.loads((folder / "answer.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("options", [{}, {"effects": ["damping_temperature"], "base": "memory"}])
def test_identify_gives_the_commands_law(pipeclamp, small, tests, tmp_path, options):
    words = [word for name, value in options.items() for word in (f"--{name}", value if name == "base" else value[0])]
    pipeclamp("identify", small, "-o", tmp_path / "law.json", "--reproducible", *words)
    ours = pc.identify(tests, **options).to_dict()
    theirs = json.loads((tmp_path / "law.json").read_text(encoding="utf-8"))
    assert ours.pop("command") != theirs.pop("command")
    assert ours == to_rounding(theirs)


def test_answers_are_the_commands(pipeclamp, small, tests, law, tmp_path):
    path = law.save(tmp_path / "law.json")
    assert pc.compare(law, tests).to_dict() == to_rounding(answered(pipeclamp, tmp_path, "compare", path, small))
    assert pc.diagnose(law, tests).to_dict() == to_rounding(answered(pipeclamp, tmp_path, "diagnose", path, small))
    assert tests.to_dict() == to_rounding(answered(pipeclamp, tmp_path, "metrics", small))
    both = pc.compare_laws([path, law], tests).to_dict()
    assert both == to_rounding(answered(pipeclamp, tmp_path, "compare", path, path, small))
    assert [one["comparison"] for one in both["laws"]] == [pc.compare(law, tests).to_dict()] * 2


def test_laws_of_one_name_are_told_apart_by_their_files(pipeclamp, small, tests, law, tmp_path):
    paths = [law.save(tmp_path / "first.json"), law.save(tmp_path / "second.json")]
    both = pc.compare_laws([pc.open_law(path) for path in paths], tests)
    names = [f"{law.file.name} ({path})" for path in paths]
    assert both.to_frame()["law"].to_list() == names
    assert both.to_dict() == to_rounding(answered(pipeclamp, tmp_path, "compare", *paths, small))
    assert all(name in " ".join(both.page()[:2]) for name in names)


def test_add_gives_the_commands_law(pipeclamp, small, tests, law, tmp_path):
    path = law.save(tmp_path / "law.json")
    pipeclamp("add", path, "damping_temperature", small, "-o", tmp_path / "law2.json", "--reproducible")
    ours = pc.add(path, "damping_temperature", tests).to_dict()
    theirs = json.loads((tmp_path / "law2.json").read_text(encoding="utf-8"))
    assert ours.pop("command") != theirs.pop("command")
    assert ours == to_rounding(theirs)
    back = pc.remove(tmp_path / "law2.json", "damping_temperature", tests)
    assert back.effects == ()
    assert back.nrmse == pytest.approx(law.nrmse, rel=1e-6)


def test_an_addition_that_does_not_help_says_so(tmp_path):
    worse = pc.add(pc.identify("emwm2_tables"), "gap", "emwm2_tables")
    before, after = [step.refitted_nrmse for step in worse.file.history]
    vain = f"The law got worse: the error on left-out conditions rises with gap ({before:.2%} -> {after:.2%}); "
    assert f"{vain}keep the law without it." in str(worse).splitlines()
    assert html.escape(vain) in worse._repr_html_()
    page = worse.report(tmp_path / "law.html").read_text(encoding="utf-8")
    assert html.escape(vain) in page
    assert '<p class="subtitle">power + gap</p>' in page
    assert vain in str(pc.open_law(worse.save(tmp_path / "law.json")))


def without_two_runs(campaign, folder):
    """A campaign in which the last two runs weren't made yet."""
    earlier = Path(shutil.copytree(campaign, folder / "earlier"))
    rows = (earlier / "runs.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    (earlier / "runs.csv").write_text("".join(rows[:-2]), encoding="utf-8")
    return earlier


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"freeze": {"k10": "stiff"}}, r"freeze\['k10'\]: got 'stiff'; expected a finite number"),
        ({"freeze": {"k10": float("nan")}}, "expected a finite number"),
        ({"freeze": ["k10"]}, "expected numbers by name, such as"),
        ({"freeze": {"c0": -1.0}}, "freeze: got c0=-1; expected at least 0"),
        ({"method": "both"}, "method: got 'both'; expected joint or surfaces"),
        ({"base": None}, "base: got None; expected text such as 'power'"),
    ],
)
def test_what_a_fit_is_told_is_checked(tests, given, told):
    with pytest.raises(pc.UserError, match=told):
        pc.identify(tests, **given)


def test_text_is_asked_for_as_text(law, tests, tmp_path):
    with pytest.raises(pc.UserError, match=r"limits: got \{'A': 2\}; expected text such as 'A="):
        pc.diagnose(law, tests, limits={"A": 2})
    with pytest.raises(pc.UserError, match="limits: got 5; expected text such as 'A="):
        pc.plan_campaign(limits=5)
    with pytest.raises(pc.UserError, match="columns: got 5; expected text such as 'time="):
        pc.import_files(tmp_path, tmp_path / "c", columns=5)


def test_a_law_made_of_a_name_says_what_reads_it():
    with pytest.raises(pc.UserError, match=r"Law: got 'law\.json'; expected .* open_law reads it"):
        pc.Law("law.json")


def test_no_campaign_is_written_in_a_format_that_isnt_read(law, tmp_path):
    with pytest.raises(pc.UserError, match=r"format: got .xls.; expected csv, csv\.gz, parquet"):
        pc.rig(law, tmp_path / "c", amplitudes=[0.5], frequencies=[3], temperatures=[20], format="xls")
    assert list(tmp_path.iterdir()) == []


def test_a_refit_is_the_law_of_all_tests(pipeclamp, small, tests, law, tmp_path):
    """A law of some runs, fitted anew to all, is the law of all; what is held stays held, and its history goes on."""
    some = pc.identify(without_two_runs(small, tmp_path), freeze={"alpha_A": 0.25})
    path = some.save(tmp_path / "some.json")
    pipeclamp("refit", path, small, "-o", tmp_path / "all.json", "--reproducible")
    anew, theirs = pc.refit(path, tests), json.loads((tmp_path / "all.json").read_text(encoding="utf-8"))
    ours = anew.to_dict()
    assert ours.pop("command") != theirs.pop("command")
    assert ours == to_rounding(theirs)
    assert anew.file.coefficients["alpha_A"].state == "held"
    whole = pc.identify(tests, freeze={"alpha_A": 0.25})
    assert anew.values == pytest.approx(whole.values, rel=2e-3, abs=2e-3)
    assert anew.file.data.fingerprint == law.file.data.fingerprint != some.file.data.fingerprint
    assert [step.step for step in anew.file.history] == ["power", "a refit"]
    assert anew.nrmse < anew.file.history[0].nrmse or anew.nrmse == pytest.approx(whole.nrmse, rel=1e-3)


def test_add_takes_what_a_diagnosis_names(tests, law):
    answer = pc.diagnose(law, tests)
    if answer.verdict == "missing":
        assert pc.add(law, answer, tests).effects == answer.effects
    else:
        with pytest.raises(pc.UserError, match="names no single effect"):
            pc.add(law, answer, tests)


def test_where_no_file_holds_the_law_the_next_step_says_how_to_make_it(tests, tmp_path):
    law = pc.identify(tests)
    assert str(pc.diagnose(law, tests)).splitlines()[-1].strip().startswith("law.save('virtual.json') writes the law")
    law.save(tmp_path / "law.json")
    assert str(pc.diagnose(law, tests)).splitlines()[-1].startswith("Next: pipeclamp ")


@pytest.mark.parametrize("name", ["emwm2", "published_R1"])
def test_force_is_that_of_the_law_on_its_loops(name):
    law = pc.open_law(name)
    motion = sinusoids([0.5], [3.0], [393.15])
    expected = force_of_law(law_of(law.file), motion).force
    force = law.force(motion.y, motion.v, A=0.5, f=3.0, T=120.0)
    assert force.shape == motion.y.shape
    # where a periodic motion turns, the sample stands for its interval
    assert np.median(np.abs(force - expected)) < 1e-9
    one = law.force(0.3, -2.0, A=0.5, f=3.0, T=120.0)
    assert np.ndim(one) == 0


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"A": [0.5, 9.0], "f": 3.0, "T": 20.0}, "A = 9 mm lies beyond the law's tests, 0.2 to 1 mm"),
        ({"A": 0.5, "f": 3.0, "T": -40.0}, "T = -40 °C lies beyond the law's tests, 20 to 300 °C"),
    ],
)
def test_force_beyond_the_tests_is_told(given, words):
    law = pc.open_law("emwm2")
    with pytest.warns(UserWarning, match=re.escape(words)):
        law.force([0.5, 0.5], [0.0, 0.0], **given)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        law.force(0.5, 0.0, A=1.003, f=5.0, T=301.0)  # drives miss their set points by as much


def test_force_with_memory_follows_the_motion_from_rest(tests):
    law = pc.identify(tests, effects=["memory"])
    loops = tests.tests.loops
    motion = loop_motion(loops, 256)
    y, v = (np.tile(values[0], 6) for values in (motion.y, motion.v))
    given = {"A": loops.amplitude_mm[0], "f": loops.frequency_Hz[0], "T": loops.temperature_K[0] - 273.15}
    force = law.force(y, v, **given)
    settled = force_of_law(law_of(law.file), motion).force[0]
    assert np.median(np.abs(force[-256:] - settled)) < 1e-6 * np.abs(settled).max()
    backwards = law.force(y[::-1], v[::-1], **given)[::-1]
    assert np.abs(force - backwards).max() > 1e-2 * np.abs(settled).max()


@pytest.mark.parametrize(
    ("effect", "values", "straight"), [("memory", {"k_s": 700.0, "z_s": 120.0}, 5e-3), ("play", {"g_p": 0.05}, 0.0)]
)
def test_force_at_coarse_samples_unloads_where_the_motion_turned(effect, values, straight, tmp_path, write_law):
    """Some twelve samples a cycle, against 400 between each two of them. Play lets go right in straight moves too."""
    write_law(
        tmp_path / "law.json", {"k10": 900.0, "k30": 40.0, "c0": 2.0, "alpha0": 1.0, **values}, "power", (effect,)
    )
    law, h, omega, given = pc.open_law(tmp_path / "law.json"), 1 / 37.0, 6 * np.pi, {"A": 0.6, "f": 3.0, "T": 20.0}

    def motion(each):
        theta = omega * (0.02 + np.arange(72 * each) * h / each)
        return 0.6 * np.sin(theta), 0.6 * omega * np.cos(theta)

    fine = law.force(*motion(400), **given)[::400]
    rough, walked = law.force(*motion(1), **given), law.force(*motion(1), h=h, **given)
    size = np.sqrt(np.mean(fine[12:] ** 2))
    off = [np.sqrt(np.mean((force - fine)[12:] ** 2)) / size for force in (rough, walked)]
    assert off[0] > straight
    assert off[1] < 2e-4


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"y": 0.1, "v": 1.0, "A": 0.5, "f": 1.0}, "follows T, which isn't given"),
        ({"y": 0.1, "v": 1.0, "A": 0.5, "f": 1.0, "T": 20.0, "current_A": 2.0}, "doesn't follow 'current_A'"),
        ({"y": float("nan"), "v": 1.0, "A": 0.5, "f": 1.0, "T": 20.0}, "y: got nan; expected finite"),
        ({"y": "far", "v": 1.0, "A": 0.5, "f": 1.0, "T": 20.0}, "expected numbers"),
        ({"y": 0.1, "v": 1.0, "A": "0.5", "f": 1.0, "T": 20.0}, "A: got '0.5'; expected numbers"),
        ({"y": np.array(["2026-03-02"], "M8[s]"), "v": 1.0, "A": 0.5, "f": 1.0, "T": 20.0}, "expected numbers"),
        ({"y": 0.1 + 0.2j, "v": 1.0, "A": 0.5, "f": 1.0, "T": 20.0}, "expected numbers"),
        ({"y": np.ma.masked_greater([0.1, 9.9], 9.0), "v": 1.0, "A": 0.5, "f": 1.0, "T": 20.0}, "got nan at index 1"),
        ({"y": [0.1, 0.2], "v": [1.0, 2.0, 3.0], "A": 0.5, "f": 1.0, "T": 20.0}, "shapes"),
        ({"y": 0.1, "v": 1.0, "A": 0.5, "f": 1.0, "T": -300.0}, "above 0 K"),
        ({"y": 0.1, "v": 1.0, "A": [0.5, 0.0], "f": 1.0, "T": 20.0}, "A: got 0; expected numbers above 0"),
        ({"y": 0.1, "v": 1.0, "A": 0.5, "f": -3.0, "T": 20.0}, "f: got -3"),
    ],
)
def test_force_that_cant_be_told_is_refused(given, expected):
    with pytest.raises(pc.UserError, match=expected):
        pc.open_law("emwm2").force(given.pop("y"), given.pop("v"), **given)


def test_force_asks_for_no_temperature_where_the_tests_told_none(tmp_path):
    told = pc.open_law("emwm2").to_dict()
    del told["range"]["T"]
    (tmp_path / "law.json").write_text(json.dumps(told), encoding="utf-8")
    law, given = pc.open_law(tmp_path / "law.json"), {"A": 0.5, "f": 1.0}
    assert law.force(0.1, 1.0, **given) == law.force(0.1, 1.0, **given, T=20.0)


def test_one_effect_may_be_named_by_itself(tests):
    law = pc.identify(tests, effects="damping_temperature")
    assert law.values == pc.identify(tests, effects=["damping_temperature"]).values


def test_mistakes_are_user_errors(tests, tmp_path):
    for mistake in (
        lambda: pc.read_campaign(tmp_path / "nowhere"),
        lambda: pc.open_law("emwm3"),
        lambda: pc.identify(tests, effects=["memry"]),
        lambda: pc.build_fmu("emwm2", tmp_path / "clamp.fmu", kind="java"),
        lambda: pc.build_fmu("emwm2", tmp_path / "nowhere" / "clamp.fmu"),
        lambda: pc.cosim(tmp_path / "system.toml"),
        lambda: pc.diagnose("emwm2", tests, limits="A=3"),
        lambda: pc.compare(tests, pc.open_law("emwm2")),
        lambda: pc.add("emwm2", 3, tests),
        lambda: pc.add("emwm2", pc.open_law("emwm2"), tests),
        lambda: pc.identify([]),
        lambda: pc.read_campaign(None),
        lambda: pc.read_campaign("clampa"),
        lambda: pc.open_law(None),
        lambda: pc.cosim(None),
    ):
        with pytest.raises(pc.UserError):
            mistake()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (
            lambda law, tests, at: pc.build_fmu(law, at, amplitude="0.5"),
            "amplitude: got '0.5'; expected a finite number",
        ),
        (lambda law, tests, at: pc.build_fmu(law, at, frequency=[3.0]), r"frequency: got \[3.0\]; expected a finite"),
        (lambda law, tests, at: pc.build_fmu(law, at, track="no"), "track: got 'no'; expected True or False"),
        (lambda law, tests, at: pc.diagnose(law, tests, auto="no"), "auto: got 'no'; expected True or False"),
        (lambda law, tests, at: pc.diagnose(law, tests, declared=3), "got 3; expected a declaration"),
        (
            lambda law, tests, at: pc.diagnose(law, tests, declared=str(at)),
            r"clamp.fmu: no such file; expected the dec",
        ),
        (lambda law, tests, at: pc.add(law, "coulomb", tests, kind="Cause"), "kind: got 'Cause'; expected 'cause' or"),
        (lambda law, tests, at: pc.identify(tests, name=3), "name: got 3; expected text"),
        (lambda law, tests, at: pc.identify_per(tests, 3), "column: got 3; expected text"),
        (lambda law, tests, at: pc.schema(3), "name: got 3; expected text"),
        (lambda law, tests, at: pc.import_files(at.parent, at, pattern=3), "pattern: got 3; expected text"),
        (lambda law, tests, at: law.save(None), "got None; expected a file or folder to write"),
        (lambda law, tests, at: pc.compare(law, tests).report(3), "got 3; expected a file or folder to write"),
    ],
)
def test_what_is_stated_in_another_type_is_told(call, told, law, tests, tmp_path):
    """Each had ended in a TypeError or a ValidationError, or `"no"` had counted as yes."""
    with pytest.raises(pc.UserError, match=told):
        call(law, tests, tmp_path / "clamp.fmu")
    assert list(tmp_path.iterdir()) == []


def test_tests_and_answers_travel_to_other_processes(tests, law):
    tables = pc.read_campaign("emwm2_tables")
    for held in (pc.compare(law, tests), pc.compare("emwm2", tables)):
        assert pickle.loads(pickle.dumps(held)).to_dict() == held.to_dict()
    assert pc.compare(law, copy.deepcopy(tests)).to_dict() == to_rounding(pc.compare(law, tests).to_dict())


def test_no_motion_has_no_force(law):
    assert law.force([], [], A=0.5, f=3.0, T=20.0).shape == (0,)
    assert law.force(np.zeros((0, 3)), 0.0, A=0.5, f=3.0, T=20.0).shape == (0, 3)


def test_one_law_may_be_given_by_itself(law, tests):
    alone = pc.compare_laws(law, tests)
    assert len(alone.to_frame()) == 1
    assert "errs least" not in str(alone)


def test_tests_may_be_named_where_they_are_wanted(small, tests, law):
    assert pc.compare(law, small).to_dict() == to_rounding(pc.compare(law, tests).to_dict())
    with pytest.raises(pc.UserError, match="did you mean 'clamp_a'"):
        pc.read_campaign("clampa")


def test_results_are_shown(tests, law, tmp_path):
    held = pc.compare(law, tests)
    assert repr(held).startswith("<comparison of virtual with virtual: error ")
    assert "<table" in held._repr_html_()
    assert held.to_frame().shape[0] == tests.to_frame().shape[0] == 8
    assert law.to_frame().columns[0] == "parameter"
    for number, shown in enumerate((tests, law, held)):
        page = shown.report(tmp_path / f"{number}.html").read_text(encoding="utf-8")
        assert "virtual" in page


def test_public_names_are_documented_with_examples_that_run():
    for name in pc.__all__:
        public = getattr(pc, name)
        assert inspect.getdoc(public), name
        if name in DOCUMENTED_ELSEWHERE:
            continue
        assert ">>>" in inspect.getdoc(public), f"{name} has no example"
        if inspect.isfunction(public):
            assert "Raises:" in inspect.getdoc(public), name


@pytest.mark.parametrize(
    "module",
    [
        "catalogue", "comparison", "diagnosis", "fmu", "importing", "law", "laws", "planning", "response", "study",
        "system", "tests", "virtual",
    ],
)  # fmt: skip
def test_examples_run(module):
    """Diagnoses and plans ask few effects here, and all of the catalogue elsewhere in this folder."""
    asks = module in ("diagnosis", "planning")
    with few_effects("coulomb", "damping_temperature", "memory") if asks else nullcontext():
        ran = doctest.testmod(import_module(f"pipeclamp.api.{module}"))
    assert ran.attempted > 0
    assert ran.failed == 0


def test_the_front_doors_example_runs():
    assert doctest.testmod(pc).failed == 0


def test_importing_loads_nothing_before_it_is_needed():
    code = "import sys, pipeclamp; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not {"numpy", "polars", "pydantic", "sympy", "scipy", "pipeclamp_models"} & set(loaded)
