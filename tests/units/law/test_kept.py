"""What is kept from one call to the next is what would be made anew, and never stands in the way."""

import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from pipeclamp_models.base import kept as kept_module
from pipeclamp_models.base.kept import kept, version_of
from pipeclamp_models.law.catalogue import listed
from pipeclamp_models.law.compose import brought_into_view
from pipeclamp_models.law.law import Structure, bare_for, with_effect
from pipeclamp_models.law.outline import WIDER_STARTS, as_json, from_json, number_in, outline_of
from pipeclamp_models.realise import array_source as array_source_module
from pipeclamp_models.realise.array_source import array_source
from pipeclamp_models.realise.arrays import realise
from pipeclamp_models.realise.sizes import number_of

STRUCTURES = [
    Structure(),
    Structure("memory"),
    Structure("series:3:2"),
    Structure("power", ("damping_temperature", "memory:2", "delay")),
    Structure("power", ("play", "condition:current_A")),
]
FUNCTIONS = (
    "coefficients", "coefficients_with_slopes", "force", "force_with_slopes", "update", "update_slopes", "walks",
    "turns", "courses", "energy", "lag", "lag_slopes",
)  # fmt: skip
SIZES = {
    **{"A_typical": 0.6, "A_highest": 1.0, "F_typical": 1500.0, "f_typical": 3.0, "f_lowest": 1.0, "f_highest": 5.0},
    **{
        "T_lowest": 293.15,
        "T_highest": 573.15,
        "N_lowest": 1.0,
        "N_highest": 500.0,
        "u_current_A_size": 2.0,
        "u_column_size": 3.0,
    },
    **{"y_middle": 0.1, "y_reach": 1.1, "A_0": 1.0, "f_0": 1.0, "T_0": 293.15, "v_0": 1.0, "rho_0": 2.286},
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("PIPECLAMP_CACHE", str(tmp_path / "kept"))
    return tmp_path / "kept"


def name_of(structure: Structure) -> str:
    return "+".join((structure.base, *structure.effects))


@pytest.mark.parametrize("structure", STRUCTURES, ids=name_of)
def test_what_is_kept_is_what_would_be_made(structure, folder, monkeypatch):
    equations = structure.equations
    first = {function: type(realise(equations))(equations).written(function) for function in FUNCTIONS}
    second = {function: type(realise(equations))(equations).written(function) for function in reversed(FUNCTIONS)}
    assert len(list(folder.glob("*/*.json"))) >= len(FUNCTIONS)
    # SymPy has written much since, which must not show in names nor in the order of terms
    monkeypatch.setenv("PIPECLAMP_CACHE", "")
    fresh = {function: array_source(equations.composed, function) for function in reversed(FUNCTIONS)}
    assert first == json.loads(json.dumps(fresh))
    assert second == first


def test_what_laws_have_in_common_is_written_once(folder, monkeypatch):
    written: list[str] = []
    write = array_source_module._written
    monkeypatch.setattr(
        array_source_module, "_written", lambda part, function: written.append(function) or write(part, function)
    )
    for structure in (Structure(), Structure("power", ("damping_temperature",)), Structure("power", ("viscous",))):
        for function in ("coefficients", "force_with_slopes"):
            array_source(structure.equations.composed, function)
        written.append("|")
    bare, warm, viscous, _ = " ".join(written).split("|")
    assert bare.split().count("force_with_slopes") == 3
    assert warm.split() == ["coefficients"]
    assert viscous.split() == ["force_with_slopes"]


@pytest.mark.parametrize("structure", STRUCTURES, ids=name_of)
def test_an_outline_comes_back_whole(structure):
    outline = outline_of(structure.equations.composed)
    assert from_json(json.loads(json.dumps(as_json(outline)))) == outline == structure.equations.outline


@pytest.mark.parametrize("effect", listed(), ids=lambda effect: effect.name)
def test_starts_and_bounds_are_those_that_the_effect_states(effect):
    bare = bare_for(effect)
    structure = bare if effect.part == "base" else with_effect(bare, effect.name)
    outlined = {parameter.name: parameter for parameter in structure.equations.parameters}
    for parameter in structure.equations.composed.parameters:
        found = outlined[parameter.name]
        further = brought_into_view(structure.all_effects(), structure.equations.composed.coefficients)
        factors = (1, *further.get(parameter.symbol, ()))
        ours = [number_in(value, SIZES) for value in (*found.starts, found.lower, found.upper, found.spread or 0.0)]
        stated = [
            *(factor * start for factor in factors for start in parameter.starts),
            parameter.lower * min(number_of(factor, SIZES) for factor in factors) ** WIDER_STARTS,
            parameter.upper * max(number_of(factor, SIZES) for factor in factors) ** WIDER_STARTS,
            parameter.spread or 0.0,
        ]
        assert ours == pytest.approx([number_of(value, SIZES) for value in stated], rel=1e-14, abs=0.0)


@pytest.mark.parametrize("spoilt", ["", "{}", "no digest\n[1]", "half"])
def test_a_spoilt_file_is_made_anew(spoilt, folder):
    assert kept("name", lambda: [1, 2]) == [1, 2]
    (file,) = folder.glob("*/*.json")
    whole = file.read_text(encoding="utf-8")
    file.write_text(whole[:-2] if spoilt == "half" else spoilt, encoding="utf-8")
    assert kept("name", lambda: [1, 2]) == [1, 2]
    assert file.read_text(encoding="utf-8") == whole
    assert kept("name", lambda: pytest.fail("made again")) == [1, 2]


def test_where_nothing_can_be_written_nothing_is_kept(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("no folder", encoding="utf-8")
    for place in (str(tmp_path / "file" / "below"), ""):
        monkeypatch.setenv("PIPECLAMP_CACHE", place)
        assert [kept("name", lambda made=made: made) for made in (1, 2)] == [1, 2]


def test_many_may_write_at_once(folder):
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(lambda _: kept("name", lambda: list(range(5000))), range(40)))
    assert found == [list(range(5000))] * 40
    assert [file.suffix for file in folder.glob("*/*")] == [".json"]


def test_other_sources_have_another_folder(tmp_path):
    for name, text in (("one", "a = 1"), ("other", "a = 2"), ("same", "a = 1")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "module.py").write_text(text, encoding="utf-8")
    one, other, same = (version_of(tmp_path / name) for name in ("one", "other", "same"))
    assert one == same != other


def test_folders_of_old_sources_go(folder, monkeypatch):
    versions = [f"{index:016x}" for index in range(kept_module.MOST_VERSIONS + 2)]
    others = [folder / name for name in ("somebody's", "else")]
    for other in others:
        other.mkdir(parents=True)
    for version in versions:
        monkeypatch.setattr(kept_module, "version_of", lambda package, version=version: version)
        kept("name", lambda: 1)
    assert versions[-1] in {entry.name for entry in folder.iterdir()}
    assert len(list(folder.iterdir())) == kept_module.MOST_VERSIONS + len(others)
    assert all(other.is_dir() for other in others)


@pytest.mark.parametrize("where", ["", "kept"])
def test_states_are_stepped_alike_whatever_became_of_the_machine_code(where, tmp_path):
    """Without a cache folder, with a new one, and with one that isn't whole."""
    script = (
        "import numpy as np\n"
        "from pipeclamp_models.law.law import Structure\n"
        "from pipeclamp_models.realise.arrays import realise\n"
        "from pipeclamp_models.realise.walks import Taken\n"
        "equations = Structure('power', ('memory',)).equations\n"
        "moving = [np.linspace(-1, 1, 8).reshape(2, 4) ** power for power in range(1, 5)] + [np.full((2, 1), 0.01)]\n"
        "count = len(equations.outline.coefficients) + len(equations.names) + 2\n"
        "held = [np.full((2, 1), 0.1 + place) for place in range(count)]\n"
        "for walk in realise(equations).walks:\n"
        "    print(walk(np.zeros((len(equations.states), 2)), Taken([*moving, *held], (2, 4))).tolist())\n"
    )
    environment = os.environ | {"PIPECLAMP_CACHE": str(tmp_path / where) if where else ""}
    printed = []
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-c", script], capture_output=True, text=True, check=True, env=environment
        )
        printed.append(done.stdout)
        for file in tmp_path.rglob("*.json"):
            file.write_bytes(file.read_bytes()[:-40])
    assert bool(list(tmp_path.rglob("*.json"))) == bool(where)
    assert printed[0] == printed[1] != ""
