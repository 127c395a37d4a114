"""An effect of a user's own, from its declaration on its page to a law that travels alone, and its FMU."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
import pytest
from project import ROOT

from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import law_of
from pipeclamp_models.realise.force import force_of_law
from pipeclamp_models.realise.motion import sinusoids

PAGE = (ROOT / "docs" / "howto" / "own-effect.md").read_text(encoding="utf-8")
PLAN = ("--amplitudes", "0.3,0.6,1", "--frequencies", "1,4", "--temperatures", "20,250", "--rate", "400")
Run = Callable[..., object]


def declaration(name: str) -> str:
    """Give a declaration of the page."""
    return next(text for text in re.findall(r"```toml\n(.*?)```", PAGE, re.S) if text.startswith(f'id = "{name}"'))


@pytest.fixture(scope="module")
def folder(pipeclamp: Run, law: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page's declaration, a campaign of a clamp that has this effect, and a law without it."""
    folder = tmp_path_factory.mktemp("declared")
    (folder / "notch.toml").write_text(declaration("notch"), encoding="utf-8")
    values = ("--set", "k_b=400,y_b=0.45")
    pipeclamp("rig", law, "-o", "notched", "--effects", "notch.toml", *values, *PLAN, cwd=folder)
    pipeclamp("identify", "notched", "-o", "law.json", "--reproducible", cwd=folder)
    return folder


def test_diagnose_names_it_where_the_catalogue_has_nothing(pipeclamp: Run, folder: Path):
    pipeclamp("diagnose", "law.json", "notched", "--declared", "notch.toml", "--json", "found.json", cwd=folder)
    found = json.loads((folder / "found.json").read_text(encoding="utf-8"))
    assert (found["verdict"], found["effects"]) == ("missing", ["notch"])


@pytest.fixture(scope="module")
def with_notch(pipeclamp: Run, folder: Path) -> Path:
    """The law with the effect added; from here on the declaration's file is gone."""
    pipeclamp("add", "law.json", "notch.toml", "notched", "-o", "law2.json", cwd=folder)
    alone = folder / "alone"
    alone.mkdir()
    return (folder / "law2.json").rename(alone / "law2.json")


def test_adding_it_brings_the_error_down_to_the_scatter(with_notch: Path):
    file = open_law(str(with_notch))
    assert file.effects == ("notch",)
    before, after = file.history[-2:]
    assert after.refitted_nrmse < 0.6 * before.refitted_nrmse
    assert file.fit.nrmse < 1.1 * file.fit.noise_nrmse
    assert abs(file.coefficients["k_b"].value - 400) < 5 * file.coefficients["k_b"].standard_error
    assert abs(file.coefficients["y_b"].value - 0.45) < 5 * file.coefficients["y_b"].standard_error


def test_the_law_serves_alone(pipeclamp: Run, folder: Path, with_notch: Path):
    pipeclamp("compare", with_notch, folder / "notched", "--json", "error.json", cwd=with_notch.parent)
    error = json.loads((with_notch.parent / "error.json").read_text(encoding="utf-8"))
    assert error["nrmse"] < 1.1 * error["noise_nrmse"]
    pipeclamp("remove", with_notch, "notch", folder / "notched", "-o", "bare.json", cwd=with_notch.parent)
    bare = open_law(str(with_notch.parent / "bare.json"))
    assert bare.effects == bare.declared == ()


def test_its_fmu_steps_in_fmpy_and_rolls_back(pipeclamp: Run, with_notch: Path):
    fmu = with_notch.with_suffix(".fmu")
    pipeclamp("build-fmu", with_notch, "-o", fmu)
    law = law_of(open_law(str(with_notch)))
    A, f, T = 0.8, 3.0, 400.0
    motion = sinusoids([A], [f], [T], samples=256)
    expected = force_of_law(law, motion).force[0]
    description = fmpy.read_model_description(str(fmu))
    place = {variable.name: variable.valueReference for variable in description.modelVariables}
    instance = fmpy.instantiate_fmu(fmpy.extract(str(fmu), str(fmu.with_suffix(""))), description)
    instance.setupExperiment()
    instance.setReal([place[name] for name in ("A", "f", "T")], [A / 1000, f, T])
    instance.enterInitializationMode()
    instance.exitInitializationMode()

    def step(index: int) -> float:
        values = [motion.y[0, index] / 1000, motion.v[0, index] / 1000]
        instance.setReal([place["flange.s"], place["flange.v"]], values)
        instance.doStep(float(index * motion.h[0, 0]), float(motion.h[0, 0]))
        return instance.getReal([place["flange.f"]])[0]

    first = [step(index) for index in range(128)]
    saved = instance.getFMUState()
    second = [step(index) for index in range(128, 256)]
    instance.setFMUState(saved)
    assert [step(index) for index in range(128, 256)] == second
    np.testing.assert_allclose(first + second, expected, rtol=1e-9, atol=1e-6)
    instance.freeFMUState(saved)
    instance.terminate()
    instance.freeInstance()


def test_the_catalogue_shows_it(pipeclamp: Run, folder: Path):
    shown = pipeclamp("effects", "--declared", folder / "notch.toml").stdout  # type: ignore[attr-defined]
    assert "notch" in shown
    whole = pipeclamp("effects", folder / "notch.toml").stdout
    assert "force added, N" in whole
    assert "declared by a user" in whole


def test_mistakes_in_a_declaration_are_one_message(refused: Callable[..., str], folder: Path, clamp_a: Path):
    bad = folder / "bad.toml"
    bad.write_text((folder / "notch.toml").read_text(encoding="utf-8").replace("exp(", "expp("), encoding="utf-8")
    for words in (
        ("effects", "--declared", bad),
        ("identify", clamp_a, "-o", folder / "no.json", "--effects", bad),
        ("add", folder / "law.json", bad, clamp_a, "-o", folder / "no.json"),
        ("diagnose", folder / "law.json", clamp_a, "--declared", bad),
        ("rig", "emwm2", "-o", folder / "no", "--effects", bad),
    ):
        message = refused(*words)
        assert "bad.toml" in message and "did you mean 'exp'" in message
    assert not (folder / "no.json").exists()


def test_an_effect_without_a_value_where_the_clamp_moves_is_told(refused: Callable[..., str], folder: Path):
    """The diagnosis had left it out without a word; `add` had ended in a traceback."""
    rooted = folder / "rooted.toml"
    text = (folder / "notch.toml").read_text(encoding="utf-8").replace("exp(", "y**0.5 * exp(")
    rooted.write_text(text, encoding="utf-8")
    law, tests = folder / "law.json", folder / "notched"
    for words in (
        ("add", law, rooted, tests, "-o", folder / "no.json"),
        ("diagnose", law, tests, "--declared", rooted),
    ):
        assert "effect 'notch': has no finite force on these tests" in refused(*words)
    assert not (folder / "no.json").exists()


def test_a_constant_force_is_left_out_of_the_fmu_with_a_word_unless_it_is_declared_the_clamps(
    pipeclamp: Run, law: Path, tmp_path: Path
):
    """The force of a preload or a gas had gone without a word: the catalogue's `offset` is the rig's."""
    (tmp_path / "preload.toml").write_text(declaration("preload"), encoding="utf-8")
    pipeclamp("rig", law, "-o", "held", "--effects", "preload.toml", "--set", "F_pre=150", *PLAN, cwd=tmp_path)
    told = {}
    for effect in ("offset", "preload.toml"):
        fitted, fmu = tmp_path / f"{Path(effect).stem}.json", tmp_path / f"{Path(effect).stem}.fmu"
        pipeclamp("identify", "held", "-o", fitted, "--effects", effect, cwd=tmp_path)
        told[effect] = " ".join(
            pipeclamp("build-fmu", fitted, "-o", fmu, "--kind", "python", cwd=tmp_path).stderr.split()
        )
    assert "not in the FMU: offset (F_o = 150 N)" in told["offset"] and "not in the FMU" not in told["preload.toml"]
    force = fmpy.simulate_fmu(str(fmu), stop_time=0.01, output=["flange.f"])["flange.f"]
    assert force == pytest.approx(150.0, abs=1.0)
