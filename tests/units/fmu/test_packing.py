"""Making one module of a slave, and packing it: the same bytes, nothing left behind, the standard library alone."""

import ast
import subprocess
import sys
import zipfile
from xml.etree import ElementTree

import pytest
from fmpy import read_model_description

from pipeclamp_fmu.build import build_clamp, build_pipe
from pipeclamp_fmu.describe.model_description import ModelText, completed
from pipeclamp_fmu.slaves.one_module import body_of, content_hash, with_inlined
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_models.pipe.modes import reduce

PIPE = """
name = "short"
[pipe]
outer_diameter_mm = 60.3
wall_mm = 3.91
length_m = 2.0
material = "316L"
[ends]
left = "pinned"
right = "pinned"
[[clamps]]
name = "clamp1"
position_m = 0.7
[damping]
ratio = 0.01
[modes]
up_to_Hz = 200
"""


def test_a_body_has_neither_docstring_nor_future_import():
    source = '"""About.\n\nMore."""\n\nfrom __future__ import annotations\n\nimport math\n\n"""A note."""\nx = 1\n'
    assert body_of(source) == 'import math\n\n"""A note."""\nx = 1\n'
    assert body_of("x = 1\n") == "x = 1\n"


def test_an_import_is_replaced_by_what_it_imports_from():
    source = "import math\nfrom a.b import (\n    x,\n    y,\n)\nfrom c import z\nprint(x + y + z)\n"
    assert with_inlined(source, {"a.b": "x = 1\ny = 2\n", "c": "z = 3\n"}) == (
        "import math\n# a.b\nx = 1\ny = 2\n# c\nz = 3\nprint(x + y + z)\n"
    )
    with pytest.raises(ValueError, match="one import from each"):
        with_inlined(source, {"d": "w = 1\n"})


def test_the_hash_tells_texts_apart():
    assert content_hash("a", "bc") != content_hash("ab", "c")
    assert content_hash("a", "bc") == content_hash("a", "bc")


def builders():
    law = open_law("emwm2")
    return {
        "clamp": lambda path: build_clamp(law, path),
        "pipe": lambda path: build_pipe(reduce(parse_pipe(PIPE)), path),
    }


@pytest.mark.parametrize("kind", ["clamp", "pipe"])
def test_the_same_content_gives_the_same_bytes_and_nothing_stays_behind(tmp_path, kind):
    build = builders()[kind]
    path, modules = list(sys.path), set(sys.modules)
    identifier = build(tmp_path / "first.fmu")
    assert build(tmp_path / "second.fmu") == identifier
    assert (tmp_path / "first.fmu").read_bytes() == (tmp_path / "second.fmu").read_bytes()
    assert sys.path == path
    assert not {name for name in set(sys.modules) - modules if name.startswith(f"{kind}_")}
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["first.fmu", "second.fmu"]


@pytest.mark.parametrize("kind", ["clamp", "pipe"])
def test_an_fmu_holds_one_module_of_its_own_on_the_standard_library(tmp_path, kind):
    identifier = builders()[kind](tmp_path / "a.fmu")
    with zipfile.ZipFile(tmp_path / "a.fmu") as archive:
        names = archive.namelist()
        own = [name for name in names if name.startswith("resources/") and "/pythonfmu/" not in name]
        values = ["resources/values.txt"] if kind == "clamp" else []
        assert sorted(own) == [f"resources/{identifier}.py", "resources/slavemodule.txt", *values]
        assert f"binaries/linux64/{identifier}.so" in names
        assert f"binaries/win64/{identifier}.dll" in names
        assert all(entry.date_time == (1980, 1, 1, 0, 0, 0) for entry in archive.infolist())
        source = archive.read(f"resources/{identifier}.py").decode()
        text = archive.read("documentation/licenses/pythonfmu.txt").decode()
        assert "NTNU" in text
        assert "MIT License" in archive.read("documentation/licenses/license.txt").decode()
        assert "standard library" in archive.read("documentation/externalDependencies.txt").decode()
        assert "resources/pythonfmu/csvbuilder.py" not in names
    imported = {
        alias.name for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Import) for alias in node.names
    }
    imported |= {node.module for node in ast.walk(ast.parse(source)) if isinstance(node, ast.ImportFrom)}
    assert {name.split(".")[0] for name in imported} - {"pythonfmu"} <= sys.stdlib_module_names
    assert f"class {identifier}(Fmi2Slave):" in source
    assert "stand-in" not in source


@pytest.mark.parametrize("kind", ["clamp", "pipe"])
def test_an_fmu_runs_without_any_installed_package(tmp_path, kind):
    identifier = builders()[kind](tmp_path / "a.fmu")
    with zipfile.ZipFile(tmp_path / "a.fmu") as archive:
        archive.extractall(tmp_path)
    program = (
        f"import sys; sys.path.insert(0, {str(tmp_path / 'resources')!r}); import {identifier} as module\n"
        f"slave = module.{identifier}(instance_name='a', resources=sys.path[0]); slave.exit_initialization_mode()\n"
        "slave.set_real([1, 2], [1e-4, 1e-3]); print(slave.do_step(0.0, 1e-3), 'numpy' in sys.modules)"
    )
    run = subprocess.run([sys.executable, "-I", "-S", "-c", program], capture_output=True, text=True, check=False)
    assert run.stdout.split() == ["True", "False"], run.stderr


def test_the_documentation_says_equations_parameters_and_range(tmp_path):
    law = open_law("emwm2")
    build_clamp(law, tmp_path / "a.fmu")
    with zipfile.ZipFile(tmp_path / "a.fmu") as archive:
        page = archive.read("documentation/index.html").decode()
    assert "F = " in page
    for name, entry in law.coefficients.items():
        assert f"<td>{name}</td><td>{entry.value:.6g}</td>" in page
    assert f"<td>T</td><td>{law.range['T'].minimum:g}</td><td>{law.range['T'].maximum:g}</td><td>K</td>" in page
    assert "{{" not in page


def test_a_date_in_the_law_file_changes_nothing(tmp_path):
    law = open_law("emwm2")
    build_clamp(law, tmp_path / "a.fmu")
    build_clamp(law.model_copy(update={"date": "2001-01-01", "command": "another"}), tmp_path / "b.fmu")
    assert (tmp_path / "a.fmu").read_bytes() == (tmp_path / "b.fmu").read_bytes()


def test_another_value_gives_another_token_and_the_same_program(tmp_path):
    law = open_law("emwm2")
    name = next(iter(law.coefficients))
    entry = law.coefficients[name].model_copy(update={"value": 1.01 * law.coefficients[name].value})
    other = law.model_copy(update={"coefficients": {**law.coefficients, name: entry}})
    assert build_clamp(law, tmp_path / "a.fmu") == build_clamp(other, tmp_path / "b.fmu")
    assert len({read_model_description(str(tmp_path / file)).guid for file in ("a.fmu", "b.fmu")}) == 2


def test_a_law_that_creates_energy_is_not_written(tmp_path):
    law = open_law("emwm2")
    entry = law.coefficients["c0"].model_copy(update={"value": -law.coefficients["c0"].value})
    bad = law.model_copy(update={"coefficients": {**law.coefficients, "c0": entry}})
    with pytest.raises(UserError, match="would create energy"):
        build_clamp(bad, tmp_path / "a.fmu")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_missing_is_named(tmp_path):
    with pytest.raises(UserError, match=r"nowhere.*can't write"):
        build_clamp(open_law("emwm2"), tmp_path / "nowhere" / "a.fmu")


def test_every_variable_must_be_described():
    written = '<fmiModelDescription><ModelVariables><ScalarVariable name="a"/></ModelVariables></fmiModelDescription>'
    with pytest.raises(ValueError, match="without a description"):
        completed(ElementTree.fromstring(written), "guid", ModelText("name", "text", "0", 1.0), {}, (), {})
