"""A system as an SSP gives in fmpy, Ecos and libcosim what our own parallel scheme gives."""

import zipfile
from xml.etree import ElementTree

import foreign_ssp
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from masters import assert_the_same, told_by

from pipeclamp_fmu.native.compiler import system_compiler
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import write_law
from pipeclamp_system.cosim.building import NATIVE, PYTHON
from pipeclamp_system.cosim.run import run_system
from pipeclamp_system.cosim.ssp import write_system

STEP_NS, STEPS = 20_000, 1500
SYSTEM = """
name = "two clamps"
[pipe]
file = "pipe.toml"
[[clamps]]
at = "clamp1"
law = "emwm2"
temperature_C = 50.0
amplitude_mm = 0.5
[[clamps]]
at = "clamp2"
law = "softer.json"
temperature_C = 80.0
amplitude_mm = 0.5
[excitation]
kind = "sine"
acceleration_m_s2 = 2.0
frequency_Hz = 10.0
[run]
stop_s = {stop}
step_s = {step}
scheme = "parallel"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory, pipe_text):
    """Give a folder with a described pipe and system, its clamps of the same equations with different values."""
    made = tmp_path_factory.mktemp("system")
    law = open_law("emwm2")
    coefficients = dict(law.coefficients)
    coefficients["k10"] = coefficients["k10"].model_copy(update={"value": 0.4 * coefficients["k10"].value})
    write_law(law.model_copy(update={"name": "softer", "coefficients": coefficients}), made / "softer.json")
    (made / "pipe.toml").write_text(pipe_text("pipe"), encoding="utf-8")
    text = SYSTEM.format(stop=1e-9 * STEP_NS * STEPS, step=1e-9 * STEP_NS)
    (made / "system.toml").write_text(text, encoding="utf-8")
    return made


@pytest.fixture(scope="module", params=["python", "native"])
def ssp(request, folder):
    """Give the system as an SSP, all of one kind."""
    if request.param == "native" and system_compiler() is None:
        pytest.skip("there is no C compiler (cc, gcc or clang) on the path")
    build = {"python": PYTHON, "native": NATIVE}[request.param]
    write_system(folder / "system.toml", folder / f"{request.param}.ssp", build)
    return folder / f"{request.param}.ssp"


@pytest.fixture(scope="module")
def own(folder):
    """Our parallel scheme's displacement and forces, (STEPS, 3)."""
    columns = run_system(folder / "system.toml").columns
    return np.array([columns["clamp1.s"], columns["clamp1.f"], columns["clamp2.f"]]).T[1:]


@pytest.mark.parametrize("master", ["fmpy", "ecos", "libcosim"])
def test_it_gives_what_our_parallel_scheme_gives(ssp, own, master, tmp_path):
    assert_the_same(told_by(master, foreign_ssp, ssp, tmp_path, STEP_NS, STEPS), own)


def test_it_holds_every_part(ssp, tmp_path):
    with zipfile.ZipFile(ssp) as archive:
        names = set(archive.namelist())
        archive.extractall(tmp_path)
    system = ElementTree.parse(tmp_path / "SystemStructure.ssd").getroot()
    assert (system.get("name"), system.get("description")) == ("two_clamps", "two clamps")
    kinds = {entry.tag.split("}")[1] for entry in system}
    assert kinds == {"System", "Units", "DefaultExperiment"}
    units = {entry.get("name"): entry[0].attrib for entry in system.iter() if entry.tag.endswith("}Unit")}
    assert units["N"] == {"kg": "1", "m": "1", "s": "-2"}
    connectors = [entry for entry in system.iter() if entry.tag.endswith("}Connector")]
    assert {entry[0].get("unit") for entry in connectors if entry.get("name") == "flange.s"} == {"m"}
    assert {entry[0].get("unit") for entry in connectors} <= {*units, None}
    parts = {f"resources/{name}.fmu" for name in ("excitation", "pipe", "clamp1", "clamp2")}
    assert names == {"SystemStructure.ssd", "resources/clamp1.ssv", "resources/clamp2.ssv", *parts}
    assert [validate_fmu(str(tmp_path / part)) for part in sorted(parts)] == [[], [], [], []]


def test_too_long_a_run_is_refused(folder, tmp_path):
    text = SYSTEM.format(stop=100.0, step=1e-4).replace("pipe.toml", str(folder / "pipe.toml"))
    (tmp_path / "system.toml").write_text(text, encoding="utf-8")
    with pytest.raises(UserError, match="1000000 steps; expected at most 200000"):
        write_system(tmp_path / "system.toml", tmp_path / "system.ssp", PYTHON)
    assert not (tmp_path / "system.ssp").exists()


def test_clamps_may_be_called_as_the_pipe_and_the_excitation(folder, pipe_text, tmp_path):
    text = pipe_text("pipe").replace('"clamp1"', '"Pipe"').replace('"clamp2"', '"pipe_"')
    (tmp_path / "pipe.toml").write_text(text, encoding="utf-8")
    system = SYSTEM.format(stop=0.001, step=1e-4).replace('"clamp1"', '"Pipe"').replace('"clamp2"', '"pipe_"')
    system = system.replace("softer.json", str(folder / "softer.json"))
    (tmp_path / "system.toml").write_text(system, encoding="utf-8")
    write_system(tmp_path / "system.toml", tmp_path / "system.ssp", PYTHON)
    with zipfile.ZipFile(tmp_path / "system.ssp") as archive:
        names = [name.casefold() for name in archive.namelist()]
        description = ElementTree.fromstring(archive.read("SystemStructure.ssd"))
    assert len(set(names)) == len(names) == 7
    elements = [entry.get("name") for entry in description.iter() if entry.tag.endswith("}Component")]
    assert elements == ["excitation", "pipe__", "Pipe", "pipe_"]
    ends = {(entry.get("startElement"), entry.get("endElement")) for entry in description.iter()}
    assert {("excitation", "pipe__"), ("pipe__", "Pipe"), ("pipe_", "pipe__")} <= ends


def test_clamps_whose_names_are_alike_on_windows_have_files_of_their_own(folder, pipe_text, tmp_path):
    """`a` and `A` are one file there, and `con` is none."""
    text = pipe_text("pipe").replace('"clamp1"', '"con"').replace('"clamp2"', '"Con"')
    (tmp_path / "pipe.toml").write_text(text, encoding="utf-8")
    system = SYSTEM.format(stop=0.001, step=1e-4).replace('"clamp1"', '"con"').replace('"clamp2"', '"Con"')
    (tmp_path / "system.toml").write_text(system.replace("softer.json", str(folder / "softer.json")), encoding="utf-8")
    write_system(tmp_path / "system.toml", tmp_path / "system.ssp", PYTHON)
    with zipfile.ZipFile(tmp_path / "system.ssp") as archive:
        names = archive.namelist()
        description = ElementTree.fromstring(archive.read("SystemStructure.ssd"))
    parts = {entry.get("name"): entry.get("source") for entry in description.iter() if entry.get("source")}
    assert (parts["con"], parts["Con"]) == ("resources/con_.fmu", "resources/Con__.fmu")
    assert {"resources/con_.ssv", "resources/Con__.ssv", *filter(None, parts.values())} <= set(names)
    assert len({name.casefold() for name in names}) == len(names)
