"""The reference results inside an FMU are what the FMU gives for the stimuli beside them; its icon is a picture."""

import csv
import io
import struct
import zipfile
from xml.etree import ElementTree

import pytest

from pipeclamp_fmu.build import build_clamp

FOLDER = "extra/org.fmi-standard.fmi-ls-ref/"


def table(archive, name):
    return list(csv.DictReader(io.StringIO(archive.read(FOLDER + name).decode("utf-8"))))


@pytest.mark.parametrize("kind", ["python", "native"])
def test_the_fmu_gives_its_reference_results(request, drive, law_with_memory, tmp_path, kind):
    if kind == "python":
        path = tmp_path / "clamp.fmu"
        build_clamp(law_with_memory, path)
    else:
        path = request.getfixturevalue("native_fmus")[2]
    with zipfile.ZipFile(path) as archive:
        related = ElementTree.fromstring(archive.read(FOLDER + "fmi-ls-manifest.xml")).iter("Related")
        assert {FOLDER + entry.get("source") for entry in related} <= set(archive.namelist())
        (experiment,) = ElementTree.fromstring(archive.read(FOLDER + "experiments.xml")).iter("Experiment")
        stimuli, results = table(archive, "stimuli.csv"), table(archive, "results.csv")
    h = float(experiment.get("stepSize"))
    clamp = drive(path)
    for stimulus, result in zip(stimuli, results, strict=True):
        clamp.step(h, **{name.replace(".", "__"): float(stimulus[name]) for name in ("flange.s", "flange.v")})
        assert clamp.time == pytest.approx(float(result["time"]))
        for name in ("flange.f", "energyDissipated"):
            assert clamp.get(name) == pytest.approx(float(result[name]), rel=1e-9, abs=1e-9)
    assert float(results[-1]["energyDissipated"]) > 0


@pytest.mark.parametrize(("fmi", "name"), [(2, "model.png"), (3, "terminalsAndIcons/icon.png")])
def test_the_icon_is_a_picture(native_fmus, fmi, name):
    with zipfile.ZipFile(native_fmus[fmi]) as archive:
        picture = archive.read(name)
    assert picture.startswith(b"\x89PNG\r\n\x1a\n")
    assert struct.unpack(">II", picture[16:24]) == (128, 128)
