"""Another law's parameters in a finished FMU: the same as if it had been built with them."""

import shutil
import zipfile

import fmpy
import pytest
from fmpy.validation import validate_fmu

from pipeclamp_fmu.build import build_clamp, build_native_clamp
from pipeclamp_fmu.set_parameters import set_parameters
from pipeclamp_models.base.errors import UserError


@pytest.fixture
def softer(law_with_memory):
    """The law with memory, softer and over another range."""
    coefficients = dict(law_with_memory.coefficients)
    coefficients["k10"] = coefficients["k10"].model_copy(update={"value": 700.123456789})
    wider = law_with_memory.range | {"T": law_with_memory.range["T"].model_copy(update={"maximum": 650.0})}
    return law_with_memory.model_copy(update={"name": "softer", "coefficients": coefficients, "range": wider})


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_native_fmu_becomes_the_one_built_anew(native_fmus, softer, tmp_path, fmi):
    build_native_clamp(softer, tmp_path / "anew.fmu", fmi)
    shutil.copy(native_fmus[fmi], tmp_path / "changed.fmu")
    set_parameters(tmp_path / "changed.fmu", softer, tmp_path / "changed.fmu")
    assert (tmp_path / "changed.fmu").read_bytes() == (tmp_path / "anew.fmu").read_bytes()
    assert validate_fmu(str(tmp_path / "changed.fmu")) == []


def test_it_runs_with_the_new_values_whether_or_not_start_values_are_set(native_fmus, drive, softer, tmp_path):
    set_parameters(native_fmus[2], softer, tmp_path / "changed.fmu")
    clamp, before = drive(tmp_path / "changed.fmu"), drive(native_fmus[2])
    assert (clamp.get("law.k10"), before.get("law.k10")) == (700.123456789, 1200.0)
    (start,) = [
        variable.start
        for variable in fmpy.read_model_description(str(tmp_path / "changed.fmu")).modelVariables
        if variable.name == "law.k10"
    ]
    assert float(start) == 700.123456789
    clamp.step(1e-3, flange__s=1e-4)
    before.step(1e-3, flange__s=1e-4)
    middle = 0.6**-0.2 * 0.1
    assert before.get("flange.f") - clamp.get("flange.f") == pytest.approx((1200.0 - 700.123456789) * middle)
    clamp.set({"T": 640.0})
    clamp.step(1e-3)
    assert clamp.get("inRange")


def test_a_python_fmu_becomes_the_one_built_anew(law_with_memory, softer, tmp_path):
    build_clamp(law_with_memory, tmp_path / "clamp.fmu")
    build_clamp(softer, tmp_path / "anew.fmu")
    set_parameters(tmp_path / "clamp.fmu", softer, tmp_path / "clamp.fmu")
    assert (tmp_path / "clamp.fmu").read_bytes() == (tmp_path / "anew.fmu").read_bytes()
    assert validate_fmu(str(tmp_path / "clamp.fmu")) == []


def test_python_fmus_of_one_program_keep_their_own_values_in_one_process(drive, law_with_memory, softer, tmp_path):
    """They share a module, as all Python FMUs of a process share one interpreter."""
    build_clamp(law_with_memory, tmp_path / "before.fmu")
    set_parameters(tmp_path / "before.fmu", softer, tmp_path / "after.fmu")
    before, after = drive(tmp_path / "before.fmu"), drive(tmp_path / "after.fmu")
    assert (before.get("law.k10"), after.get("law.k10")) == (1200.0, 700.123456789)
    for clamp in (before, after):
        clamp.step(1e-3, flange__s=1e-4)
    difference = (1200.0 - 700.123456789) * 0.6**-0.2 * 0.1
    assert before.get("flange.f") - after.get("flange.f") == pytest.approx(difference)
    after.slave.reset()
    after.start({"T": 640.0})
    after.step(1e-3, flange__s=1e-4)
    assert after.get("inRange")
    assert after.get("law.k10") == 700.123456789


@pytest.mark.parametrize("kind", ["python", "native"])
def test_other_equations_are_refused_and_the_file_left_alone(native_fmus, law_with_memory, tmp_path, kind):
    if kind == "python":
        build_clamp(law_with_memory, tmp_path / "clamp.fmu")
    else:
        shutil.copy(native_fmus[2], tmp_path / "clamp.fmu")
    content = (tmp_path / "clamp.fmu").read_bytes()
    kept = {name: entry for name, entry in law_with_memory.coefficients.items() if name not in ("k_s", "z_s")}
    other = law_with_memory.model_copy(update={"effects": ("damping_temperature",), "coefficients": kept})
    with pytest.raises(UserError, match=r"other equations.*same base and effects"):
        set_parameters(tmp_path / "clamp.fmu", other, tmp_path / "clamp.fmu")
    assert (tmp_path / "clamp.fmu").read_bytes() == content


def test_what_is_no_clamp_is_refused(fmus, law_with_memory, tmp_path):
    (tmp_path / "text.fmu").write_text("nothing", encoding="utf-8")
    with zipfile.ZipFile(tmp_path / "empty.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", "<a/>")
    for path in (tmp_path / "text.fmu", tmp_path / "empty.fmu", tmp_path / "none.fmu", fmus["pipe"]):
        with pytest.raises(UserError, match=r"expected (one|a clamp FMU) made by `pipeclamp build-fmu`"):
            set_parameters(path, law_with_memory, tmp_path / "out.fmu")
    assert not (tmp_path / "out.fmu").exists()
