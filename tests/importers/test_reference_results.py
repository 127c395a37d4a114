"""The reference results inside an FMU are what the FMU gives for the stimuli beside them; its icon is a picture."""

import io
import struct
import zipfile
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest

FOLDER = "extra/org.fmi-standard.fmi-ls-ref/"

FMUS = {
    "python clamp": lambda fixture: fixture("fmus")["memory"],
    "native clamp": lambda fixture: fixture("native_fmus")[2],
    "native clamp, FMI 3": lambda fixture: fixture("native_fmus")[3],
    "python pipe": lambda fixture: fixture("fmus")["loaded_pipe"],
    "native pipe": lambda fixture: fixture("native_pipes")["loaded_pipe"],
}


def table(archive, name):
    text = io.BytesIO(archive.read(FOLDER + name))
    return np.genfromtxt(text, delimiter=",", names=True, deletechars="")


@pytest.mark.parametrize("name", FMUS)
@pytest.mark.parametrize("interface", ["CoSimulation", "ModelExchange"])
def test_fmpy_replays_them(request, name, interface):
    """As its experiment says and no otherwise: inputs set at a row's time, steps from row to row."""
    path = FMUS[name](request.getfixturevalue)
    if interface == "ModelExchange" and name.startswith("python"):
        pytest.skip("Python FMUs are for co-simulation alone")
    own = interface == "ModelExchange" and "clamp" in name
    with zipfile.ZipFile(path) as archive:
        manifest = ElementTree.fromstring(archive.read(FOLDER + "fmi-ls-manifest.xml"))
        assert {FOLDER + entry.get("source") for entry in manifest.iter("Related")} <= set(archive.namelist())
        said = archive.read(FOLDER + ("experiments_model_exchange.exp" if own else "experiments.exp"))
        (experiment,) = ElementTree.fromstring(said)
        times, *files = experiment
        stimuli, results = (table(archive, entry.get("source")) for entry in files)
    outputs = list(results.dtype.names[1:])
    run = fmpy.simulate_fmu(
        str(path), fmi_type=interface, input=stimuli, output=outputs, stop_time=float(times.get("stopTime")),
        step_size=float(times.get("stepSize")), output_interval=float(times.get("stepSize")),
        relative_tolerance=float(experiment.get("tolerance")),
    )  # fmt: skip
    # In model exchange, fmpy ends steps at reversals too, and doesn't begin anew where a pipe's inputs jump.
    most = 1e-9 if interface == "CoSimulation" else 1e-4 if "clamp" in name else 5e-3
    for output in outputs:
        size = np.abs(results[output]).max()
        assert size > 0
        theirs = np.interp(results["time"], run["time"], run[output])
        assert np.abs(theirs - results[output]).max() < most * size, output


@pytest.mark.parametrize(("fmi", "name"), [(2, "model.png"), (3, "terminalsAndIcons/icon.png")])
def test_the_icon_is_a_picture(native_fmus, fmi, name):
    with zipfile.ZipFile(native_fmus[fmi]) as archive:
        picture = archive.read(name)
    assert picture.startswith(b"\x89PNG\r\n\x1a\n")
    assert struct.unpack(">II", picture[16:24]) == (128, 128)


def test_no_rounding_shows_in_units_and_bounds(native_fmus):
    description = fmpy.read_model_description(str(native_fmus[2]))
    numbers = [unit.baseUnit.factor for unit in description.unitDefinitions if unit.baseUnit]
    numbers += [getattr(entry, bound) for entry in description.modelVariables for bound in ("min", "max", "nominal")]
    assert "1000000000.0" in map(str, numbers)
    assert all(len(str(number).lstrip("-0.").split("e")[0]) < 15 for number in numbers if number is not None)
