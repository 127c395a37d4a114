"""What a native FMU is told when it is made: where its files lie, as a URI, what its law is called, when it starts."""

import shutil
from ctypes import byref
from math import nan
from zipfile import ZipFile

import fmpy
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave, defaultCallbacks
from fmpy.fmi3 import FMU3Slave, fmi3LogMessageCallback

from pipeclamp_fmu.build import build_excitation, build_native_clamp, build_native_excitation
from pipeclamp_fmu.contents.excitation import Samples
from pipeclamp_fmu.native.compiler import system_compiler
from pipeclamp_models.law.bundled import open_law

LOG_MESSAGE = fmi3LogMessageCallback(lambda *_: None)
"""Kept as long as an instance may call it."""


@pytest.fixture
def takes(native_fmus, tmp_path):
    """Give a function that tells whether an FMU of FMI 2.0 finds its files by a URI."""
    folder = tmp_path / "it's 100% ünpacked"
    description = fmpy.read_model_description(str(native_fmus[2]))
    fmpy.extract(str(native_fmus[2]), unzipdir=str(folder))
    name = description.coSimulation.modelIdentifier
    slave = FMU2Slave(guid=description.guid, unzipDirectory=str(folder), modelIdentifier=name, instanceName=name)

    def tried(uri):
        guid, callbacks = description.guid.encode(), byref(defaultCallbacks)
        instance = slave.fmi2Instantiate(b"clamp", 1, guid, uri.encode(), callbacks, 0, 0)
        if instance:
            slave.fmi2FreeInstance(instance)
        return bool(instance)

    return folder / "resources", tried


def test_it_finds_its_files_by_any_form_of_a_file_s_uri(takes):
    resources, tried = takes
    uri = resources.as_uri()
    assert tried(uri)
    assert tried(f"{uri}/")
    assert tried(str(resources))
    assert tried(uri.replace("file:///", "file:/"))
    assert tried(uri.replace("file:///", "file://localhost/"))
    assert not tried(uri.replace("resources", "elsewhere"))


def test_a_drive_s_colon_may_be_encoded(takes, tmp_path, monkeypatch):
    resources, tried = takes
    shutil.copytree(resources, tmp_path / "C:" / "resources")
    monkeypatch.chdir(tmp_path)  # what is a drive on Windows is a folder here
    for uri in (
        "file:///C:/resources",
        "file:///C%3A/resources",
        "file:///C%3a/resources",
        "file://C:/resources",
        "file:\\\\\\C:/resources",
    ):
        assert tried(uri), uri


@pytest.mark.parametrize("form", ["path", "path with an end", "uri"])
def test_fmi_3_takes_a_path_and_a_uri(native_fmus, tmp_path, form):
    folder = tmp_path / "it's 100% %41 ünpacked"
    description = fmpy.read_model_description(str(native_fmus[3]))
    fmpy.extract(str(native_fmus[3]), unzipdir=str(folder))
    name, resources = description.coSimulation.modelIdentifier, folder / "resources"
    slave = FMU3Slave(
        guid=description.instantiationToken, unzipDirectory=str(folder), modelIdentifier=name, instanceName=name
    )
    given = {"path": str(resources), "path with an end": f"{resources}/", "uri": resources.as_uri()}[form]
    token = description.instantiationToken.encode()
    instance = slave.fmi3InstantiateModelExchange(b"clamp", token, given.encode(), False, False, None, LOG_MESSAGE)
    assert instance
    slave.fmi3FreeInstance(instance)


def test_a_host_stays_before_the_path(takes):
    """Windows calls a folder of another computer //host/folder; elsewhere that is /host/folder."""
    resources, tried = takes
    assert tried(resources.as_uri().replace("file:///", "file://"))
    assert tried(resources.as_uri().replace("file:///", "file:////"))


def test_a_law_with_a_long_name_is_instantiated_and_named_in_whole_characters(drive, tmp_path):
    if system_compiler() is None:
        pytest.skip("there is no C compiler (cc, gcc or clang) on the path")
    build_native_clamp(open_law("emwm2").model_copy(update={"name": "ä" * 2000}), tmp_path / "long.fmu")
    clamp = drive(tmp_path / "long.fmu")
    clamp.step(0.01, flange__s=5e-3)
    (said,) = clamp.messages.warnings
    assert said.startswith("law ä")
    assert "ä is used beyond its range: |flange.s| = 5 mm is outside 0 to 1 mm" in said


@pytest.mark.parametrize("kind", ["python", 2, 3])
def test_an_excitation_begins_with_what_it_is_when_the_run_starts(tmp_path, kind):
    if kind != "python" and system_compiler() is None:
        pytest.skip("there is no C compiler (cc, gcc or clang) on the path")
    path, samples = tmp_path / "excitation.fmu", Samples(0.1, [0.0, 2.0, 6.0], "N")
    build_excitation(samples, path) if kind == "python" else build_native_excitation(samples, path, kind)
    description = fmpy.read_model_description(str(path))
    own = FMU3Slave if kind == 3 else FMU2Slave
    signal = own(
        guid=description.guid or description.instantiationToken,
        unzipDirectory=fmpy.extract(str(path), unzipdir=str(tmp_path / "unpacked")),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="signal",
    )
    signal.instantiate()
    get = signal.getFloat64 if kind == 3 else signal.getReal
    if kind == 3:
        signal.enterInitializationMode(startTime=0.15)
    else:
        signal.setupExperiment(startTime=0.15)
        signal.enterInitializationMode()
    assert get([1]) == pytest.approx([4.0])
    signal.exitInitializationMode()
    assert get([1]) == pytest.approx([4.0])
    signal.doStep(0.15, 0.05)
    assert get([1]) == pytest.approx([6.0])
    signal.freeInstance()


def test_no_icon_is_stated_where_there_is_none(tmp_path):
    if system_compiler() is None:
        pytest.skip("there is no C compiler (cc, gcc or clang) on the path")
    build_native_excitation(Samples(0.1, [0.0, 2.0], "N"), tmp_path / "excitation.fmu", 3)
    with ZipFile(tmp_path / "excitation.fmu") as packed:
        assert not [name for name in packed.namelist() if name.startswith("terminalsAndIcons/")]


def test_only_those_categories_are_logged_that_the_importer_names(drive, native_fmus):
    clamp = drive(native_fmus[2])
    messages = clamp.messages
    clamp.slave.setDebugLogging(True, ["logStatusDiscard"])
    clamp.step(0.01, flange__s=5e-3)
    assert not clamp.get("inRange")
    assert messages.warnings == []
    with pytest.raises(FMICallException):
        clamp.step(0.01, flange__s=nan)
    (said,) = messages.errors
    assert said.startswith("step from 0.01 s by 0.01 s discarded: flange.s is nan")
    clamp.slave.setDebugLogging(True, ["logStatusWarning", "logStatusError"])
    with pytest.raises(FMICallException):
        clamp.step(0.01, flange__s=nan)
    assert messages.errors == [said]
    clamp.slave.setDebugLogging(True, [])
    with pytest.raises(FMICallException):
        clamp.step(0.01, flange__s=nan)
    assert messages.errors == [said, said]
    clamp.slave.setDebugLogging(False, ["logAll"])
    with pytest.raises(FMICallException):
        clamp.step(0.01, flange__s=nan)
    assert messages.errors == [said, said]
