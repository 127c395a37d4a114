"""What an FMU tells of its law's certainty: parameter sets that importers apply, and a record."""

import hashlib
import io
import json
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from fmpy.ssp import ssd
from lxml import etree

from pipeclamp_fmu.build import build_clamp
from pipeclamp_fmu.contents.clamp_model import ClampStart
from pipeclamp_fmu.set_parameters import set_parameters
from pipeclamp_models.law.file import Covariance, LastDiagnosis, Shares, Spread

FOLDER = "extra/org.fmi-standard.fmi-ls-ref/"
NAMES = ["nominal", "lower_response", "upper_response", "softest", "stiffest"]
SCATTER = Shares(stiffness=0.03, damping=0.08)
ERRORS = np.array([20.0, 6.0, 3.0])
"""Standard errors of k10, c0 and z_s."""
EXACT = Shares(stiffness=0.0, damping=0.0)


@pytest.fixture(scope="module")
def uncertain(law_with_memory):
    """The law with memory, as if it had been fitted."""
    names = ("k10", "c0", "z_s")
    correlation = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, -0.6], [0.0, -0.6, 1.0]])
    covariance = (correlation * np.outer(ERRORS, ERRORS)).tolist()
    entries = {
        name: law_with_memory.coefficients[name].model_copy(update={"state": "fitted", "standard_error": float(error)})
        for name, error in zip(names, ERRORS, strict=True)
    }
    return law_with_memory.model_copy(
        update={
            "coefficients": {**law_with_memory.coefficients, **entries},
            "covariance": Covariance.model_validate({"names": names, "matrix": covariance}, strict=False),
            "spread": Spread(runs=SCATTER, form=EXACT),
            "diagnosis": LastDiagnosis(verdict="missing", effects=("gap",), tests="bench"),
        }
    )


@pytest.fixture(scope="module")
def fmu(uncertain, tmp_path_factory):
    path = tmp_path_factory.mktemp("behind") / "clamp.fmu"
    build_clamp(uncertain, path, ClampStart(T=433.15))
    return path


@pytest.fixture(scope="module")
def inside(fmu):
    with zipfile.ZipFile(fmu) as archive:
        return {name.removeprefix(FOLDER): archive.read(name) for name in archive.namelist()}


@pytest.fixture(scope="module")
def record(inside):
    return json.loads(inside["credibility.json"])


def values(inside, name):
    root = ElementTree.fromstring(inside[f"{name}.ssv"])
    return {
        entry.get("name"): float(entry[0].get("value")) for entry in root.iter() if entry.tag.endswith("}Parameter")
    }


def test_the_sets_are_valid_ssv(inside):
    schema = etree.XMLSchema(etree.parse(Path(ssd.__file__).parent / "schema" / "SystemStructureParameterValues.xsd"))
    for name in NAMES:
        schema.assertValid(etree.parse(io.BytesIO(inside[f"{name}.ssv"])))


def test_the_manifest_names_every_file_by_its_role(inside):
    related = {entry.get("source"): entry for entry in ElementTree.fromstring(inside["fmi-ls-manifest.xml"])}
    roles = {name: entry.get("role") for name, entry in related.items()}
    assert [roles[f"{name}.ssv"] for name in NAMES] == ["parameter"] * 5
    assert (roles["credibility.json"], roles["experiments.exp"]) == ("meta-data", "experiment/smoke-test")
    for name, entry in related.items():
        assert entry.get("checksum") == hashlib.sha3_256(inside[name]).hexdigest()


def test_a_set_applied_in_fmpy_gives_the_loop_that_it_says(fmu, inside, record):
    """Over the cycle in the middle of the range: 0.6 mm, 3 Hz."""
    A, f, count = 6e-4, 3.0, 400
    time = np.arange(2 * count + 1) / (f * count)
    ahead = time + 1 / (f * count)  # inputs are those of the step's end
    s, v = A * np.sin(2 * np.pi * f * ahead), A * 2 * np.pi * f * np.cos(2 * np.pi * f * ahead)
    motion = np.rec.fromarrays([time, s, v], names=["time", "flange.s", "flange.v"])
    for entry in record["parameter_sets"]:
        run = fmpy.simulate_fmu(
            str(fmu), start_values=values(inside, entry["name"]), input=motion, stop_time=2 / f,
            step_size=1 / (f * count), output_interval=1 / (f * count), output=["flange.s", "flange.f"],
        )[-count - 1 :]  # fmt: skip
        force, way = run["flange.f"], np.diff(run["flange.s"])
        loss = 1e3 * float(np.sum((force[1:] + force[:-1]) / 2 * way))
        assert loss == pytest.approx(entry["dissipated_energy_mJ"], rel=2e-3), entry["name"]


def test_the_ends_are_where_the_covariance_and_the_scatter_put_them(record, inside, uncertain):
    sets = {entry["name"]: entry for entry in record["parameter_sets"]}
    losses = [sets[name]["dissipated_energy_mJ"] for name in ("upper_response", "nominal", "lower_response")]
    assert losses == sorted(losses)
    nominal, soft, stiff = (values(inside, name) for name in ("nominal", "softest", "stiffest"))
    assert nominal["law.k10"] == uncertain.coefficients["k10"].value
    assert soft["law.k30"] < nominal["law.k30"] < stiff["law.k30"], "the scatter scales the whole stiffness"
    # The likeliest combination at the end: as far from the law, in standard deviations, as the band's end.
    by_share = np.log(stiff["law.k30"] / nominal["law.k30"]) / SCATTER.stiffness
    by_k10 = (stiff["law.k10"] / np.exp(by_share * SCATTER.stiffness) - nominal["law.k10"]) / ERRORS[0]
    assert 1.8 < np.hypot(by_share, by_k10) < 1.961, "the rest comes from the memory and the damping"


def test_the_record_says_where_everything_comes_from(record, uncertain):
    assert record["data"]["fingerprint"] == uncertain.data.fingerprint
    assert record["coefficients"]["k10"]["evidence"] == "measured"
    assert record["coefficients"]["alpha0"]["evidence"] == "given"
    assert record["diagnosis"] == {"verdict": "missing", "effects": ["gap"], "tests": "bench", "in_vain": []}
    assert record["cautions"] == []


def test_nothing_is_made_up_where_nothing_is_known(native_fmus):
    with zipfile.ZipFile(native_fmus[3]) as archive:
        record = json.loads(archive.read(f"{FOLDER}credibility.json"))
        page = archive.read("documentation/index.html").decode()
    assert [entry["name"] for entry in record["parameter_sets"]] == ["nominal"]
    assert record["diagnosis"] == {"verdict": "never diagnosed"}
    assert len(record["cautions"]) == 2
    assert "never diagnosed" in page


def test_parameter_sets_of_another_law_go_with_it(fmu, law_with_memory, tmp_path):
    """As of a law that tells less of how sure it is, which has fewer."""
    set_parameters(fmu, law_with_memory, tmp_path / "changed.fmu")
    build_clamp(law_with_memory, tmp_path / "anew.fmu", ClampStart(T=433.15))
    assert (tmp_path / "changed.fmu").read_bytes() == (tmp_path / "anew.fmu").read_bytes()
