"""The native clamp FMU beyond what it shares with the Python one: model exchange, derivatives, statuses, its files."""

import math
import shutil
import sys
import zipfile
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from fmpy.build import build_platform_binary
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import fmi2LastSuccessfulTime, fmi2Terminated
from fmpy.model_description import read_build_description
from fmpy.validation import validate_fmu
from native_driver import NativeDriver

from pipeclamp_fmu.build import build_clamp, build_native_clamp
from pipeclamp_fmu.contents.clamp_model import ClampStart
from pipeclamp_fmu.native.compiler import compile_sources, system_compiler
from pipeclamp_fmu.set_parameters import set_parameters
from pipeclamp_models.base.errors import UserError

H = 1e-3
DISCARD, ERROR = 2, 3


@pytest.fixture
def native(native_fmus, tmp_path):
    """Give a function that makes a clamp for a version of FMI and an interface."""
    made = []

    def make(fmi, kind, **start):
        made.append(NativeDriver(native_fmus[fmi], tmp_path / str(len(made)), kind, start))
        return made[-1]

    yield make
    for clamp in made:
        clamp.free()


def waves(count):
    theta = 2 * math.pi * 3.0 * H * np.arange(1, count + 1)
    s = 5e-4 * (np.sin(theta) + 0.3 * np.sin(3 * theta))
    v = 5e-4 * 6 * math.pi * (np.cos(theta) + 0.9 * np.cos(3 * theta))
    return list(zip(s.tolist(), v.tolist(), strict=True))


@pytest.mark.parametrize("way_on", ["step", "state", "reset"])
def test_a_discarded_step_says_that_the_run_should_end_until_it_goes_on(native, way_on):
    clamp = native(2, "CoSimulation")
    clamp.step(H, 1e-4, 0.0)
    saved = clamp.fmu.getFMUstate()
    assert not clamp.fmu.getBooleanStatus(fmi2Terminated)
    with pytest.raises(FMICallException) as refused:
        clamp.step(H, math.nan, 0.0)
    assert refused.value.status == DISCARD
    assert clamp.fmu.getBooleanStatus(fmi2Terminated)
    assert clamp.fmu.getRealStatus(fmi2LastSuccessfulTime) == H
    if way_on == "step":
        clamp.set({"flange.s": 1e-4})
        clamp.fmu.doStep(H, H)
    elif way_on == "state":
        clamp.fmu.setFMUstate(saved)
    else:
        clamp.fmu.reset()
        clamp.start({})
    assert not clamp.fmu.getBooleanStatus(fmi2Terminated)


OUTPUTS = ("flange.f", "A_used", "f_used", "T_used", "energyDissipated", "memory.z")


@pytest.mark.parametrize("fmi", [2, 3])
def test_fmpy_finds_nothing_to_object_to(native_fmus, fmi):
    assert validate_fmu(str(native_fmus[fmi])) == []


@pytest.mark.parametrize("track", [False, True])
@pytest.mark.parametrize("fmi", [2, 3])
def test_model_exchange_gives_what_co_simulation_gives(native, fmi, track):
    """Where integrator steps end at the communication points; whatever the integrator tries between leaves no trace."""
    stepped, clamp = native(fmi, "CoSimulation", track=track), native(fmi, "ModelExchange", track=track)
    for n, (s, v) in enumerate(waves(800)):
        stepped.step(H, s, v)
        for share in (0.3, 1.7):
            clamp.place((n + 0.5 * share) * H, share * s, -v)
            clamp.get("flange.f")
        clamp.place((n + 1) * H, s, v)
        expected = stepped.get(*OUTPUTS)
        np.testing.assert_allclose(clamp.get(*OUTPUTS), expected, rtol=1e-9, atol=1e-12)
        assert clamp.fmu.completedIntegratorStep() == (0, 0)
        np.testing.assert_allclose(clamp.get(*OUTPUTS), expected, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_time_that_differs_by_rounding_is_the_same(native, fmi):
    """Steps that end at (n - 1) h + h, and again, or a sum of steps later, at n h, which often lies before that."""
    stepped, clamp = native(fmi, "CoSimulation"), native(fmi, "ModelExchange")
    earlier, summed = 0, 0.0
    for n, (s, v) in enumerate(waves(5000), start=1):
        stepped.step(H, s, v)
        summed += H
        for time in ((n - 1) * H + H, n * H, summed, n * H):
            earlier += time < clamp.time
            clamp.time = time
            clamp.place(time, s, v)
            assert clamp.get("flange.f") == pytest.approx(stepped.get("flange.f"), rel=1e-9, abs=1e-9)
            assert clamp.fmu.completedIntegratorStep() == (0, 0)
    assert earlier > 5000
    clamp.place(clamp.time - H, s, v)
    with pytest.raises(FMICallException):
        clamp.get("flange.f")


@pytest.mark.parametrize("fmi", [2, 3])
def test_fmpy_integrates_it_and_the_energy_is_the_loop_area(native_fmus, fmi):
    f, A = 2.0, 5e-4
    time = np.linspace(0.0, 2.0, 4001)
    signals = np.rec.fromarrays(
        [time, A * np.sin(2 * np.pi * f * time), A * 2 * np.pi * f * np.cos(2 * np.pi * f * time)],
        names=["time", "flange.s", "flange.v"],
    )
    outputs = ["flange.s", "flange.f", "energyDissipated"]
    result = fmpy.simulate_fmu(
        str(native_fmus[fmi]), fmi_type="ModelExchange", stop_time=2.0, output_interval=5e-4, input=signals,
        start_values={"A": A, "f": f}, output=outputs,
    )  # fmt: skip
    cycle = result[result["time"] >= 1.5]
    area = float(np.sum((cycle["flange.f"][1:] + cycle["flange.f"][:-1]) / 2 * np.diff(cycle["flange.s"])))
    assert area > 0
    assert np.ptp(cycle["energyDissipated"]) == pytest.approx(area, rel=2e-3)


def test_a_reversal_is_an_event(native):
    clamp = native(2, "ModelExchange")
    indicators = (fmpy.fmi2.fmi2Real * 1)()
    for v in (0.02, -0.03):
        clamp.place(H, 1e-4, v)
        clamp.fmu.getEventIndicators(indicators, 1)
        assert list(indicators) == [v]
        assert clamp.get("memory.v") == [v]


@pytest.mark.parametrize("fmi", [2, 3])
def test_without_events_a_reversal_is_seen_at_the_step_s_end(native, law_with_memory, tmp_path, fmi):
    """And another law's parameters leave it so."""
    path = tmp_path / "clamp.fmu"
    build_native_clamp(law_with_memory, path, fmi, start=ClampStart(events=False))
    set_parameters(path, law_with_memory, path)
    clamp = NativeDriver(path, tmp_path / "unpacked", "ModelExchange", {})
    assert not clamp.description.numberOfEventIndicators
    assert clamp.fmu.getNumberOfEventIndicators() == 0 if fmi == 3 else True
    assert validate_fmu(str(path)) == []
    with_events = native(fmi, "ModelExchange")
    for s, v in waves(500):
        clamp.step(H, s, v)
        with_events.step(H, s, v)
        assert clamp.get("flange.f") == with_events.get("flange.f")
    clamp.free()


KNOWN = ("flange.s", "flange.v", "T_in", "A", "f", "T")
WIDTHS = (1e-9, 1e-7, 1e-3, 1e-9, 1e-6, 1e-3)
UNKNOWN = ("flange.f", "A_used", "f_used", "T_used", "energyDissipated")


@pytest.mark.parametrize("switches", [{}, {"track": True}, {"useTemperatureInput": True}])
@pytest.mark.parametrize("steps", [37, 80, 301])
@pytest.mark.parametrize("fmi", [2, 3])
def test_directional_derivatives_are_those_of_the_step(native, fmi, switches, steps):
    """Against differences of the step's outcome, made by going back to before it."""
    conditions = {"A": 5e-4, "f": 3.0, "T": 400.0, "T_in": 350.0}
    clamp = native(fmi, "CoSimulation", **conditions, **switches)
    *path, end = waves(steps + 1)
    for s, v in path:
        clamp.step(H, s, v)
    before = clamp.fmu.getFMUstate() if fmi == 2 else clamp.fmu.getFMUState()
    base = dict(zip(KNOWN[:2], end, strict=True)) | conditions

    def outcome(values):
        (clamp.fmu.setFMUstate if fmi == 2 else clamp.fmu.setFMUState)(before)
        clamp.set(values)
        clamp.fmu.doStep(0.0, H)
        return np.array(clamp.get(*UNKNOWN))

    here = outcome(base)
    exact = np.array(clamp.jacobian(UNKNOWN, KNOWN))
    for index, (name, width) in enumerate(zip(KNOWN, WIDTHS, strict=True)):
        ahead, behind = (outcome(base | {name: base[name] + aside}) for aside in (width, -width))
        numeric = (ahead - behind) / (2 * width)
        rounding = 1e-13 * (np.abs(here) + 1e-3) / width
        assert (np.abs(exact[:, index] - numeric) <= 1e-5 * np.abs(numeric) + rounding).all(), name


def test_adjoint_derivatives_are_the_transposed_ones(native):
    clamp = native(3, "CoSimulation", track=True)
    for s, v in waves(50):
        clamp.step(H, s, v)
    jacobian = np.array(clamp.jacobian(UNKNOWN, KNOWN))
    seed = [1.0, -2.0, 0.5, 3.0, 7.0]
    rows, columns = ([clamp.references[name] for name in names] for names in (UNKNOWN, KNOWN))
    adjoint = clamp.fmu.getAdjointDerivative(rows, columns, seed, nSensitivity=len(KNOWN))
    np.testing.assert_allclose(adjoint, np.array(seed) @ jacobian, rtol=1e-14)


def test_fmi_3_has_time_a_flange_and_no_event_mode_in_co_simulation(native, native_fmus):
    clamp = native(3, "CoSimulation")
    clamp.step(H, 1e-4, 0.0)
    assert clamp.get("time") == [H]
    with pytest.raises(Exception, match="instantiate"):
        clamp.fmu.instantiate(eventModeUsed=True)
    with zipfile.ZipFile(native_fmus[3]) as archive:
        (terminal,) = ElementTree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml")).iter("Terminal")
    assert terminal.get("terminalKind") == "Modelica.Mechanics.Translational.Interfaces.Flange_a"
    assert {member.get("variableName") for member in terminal} <= set(clamp.references)


def refused(call, *arguments):
    with pytest.raises(FMICallException) as error:
        call(*arguments)
    return error.value.status


def test_wrong_value_references_are_errors_and_do_no_harm(drive, native_fmus, shaken):
    clamp, twin = drive(native_fmus[2]), drive(native_fmus[2])
    shaken(clamp, 0, 20), shaken(twin, 0, 20)
    slave = clamp.slave
    assert refused(slave.getReal, [999]) == refused(slave.getBoolean, [0]) == ERROR
    assert refused(slave.setReal, [999], [1.0]) == refused(slave.setBoolean, [999], [True]) == ERROR
    assert refused(slave.setReal, [0], [1.0]) == refused(slave.getReal, [0]) == ERROR
    assert refused(slave.setReal, clamp.fmu.references(["flange.f"]), [5.0]) == ERROR
    assert "flange.f is no input or parameter" in clamp.messages.errors[-1]
    assert refused(slave.setReal, clamp.fmu.references(["law.k10"]), [5.0]) == ERROR
    assert "law.k10 is fixed after initialization" in clamp.messages.errors[-1]
    assert refused(slave.getInteger, [0]) == refused(slave.setInteger, [0], [1]) == ERROR
    assert clamp.all() == twin.all()
    assert shaken(clamp, 20, 40) == shaken(twin, 20, 40)


def test_calls_in_the_wrong_order_are_errors_and_do_no_harm(drive, native_fmus, native):
    model = native(2, "ModelExchange").fmu
    for call in (model.newDiscreteStates, model.enterContinuousTimeMode, model.exitInitializationMode):
        assert refused(call) == ERROR
    clamp = drive(native_fmus[2])
    slave = clamp.slave
    assert refused(slave.enterInitializationMode) == refused(slave.exitInitializationMode) == ERROR
    clamp.step(H)
    slave.terminate()
    assert refused(slave.doStep, H, H) == refused(slave.setReal, [0], [0.0]) == ERROR
    assert clamp.get("inRange")
    slave.reset()
    clamp.start({})
    clamp.step(H)


def test_states_of_others_are_refused(drive, native_fmus, native):
    clamp = drive(native_fmus[2])
    data = clamp.serialised()
    state = clamp.save()
    for bad in (b"", b"no state", data[:-1], bytes(len(data)), b"\xff" + data[1:]):
        assert refused(clamp.slave.deSerializeFMUstate, bad) == ERROR
        assert "not a state" in clamp.messages.errors[-1]
    assert refused(native(2, "ModelExchange").fmu.deSerializeFMUstate, data) == ERROR
    clamp.restore(state)


def test_equal_models_have_equal_states(drive, native_fmus):
    """Whatever was called between: nothing of the stack gets into a state."""
    one, other = drive(native_fmus[2]), drive(native_fmus[2])
    outputs, inputs = other.fmu.references(["flange.f"]), other.fmu.references(["flange.s", "flange.v"])
    for n, (s, v) in enumerate(waves(5)):
        for clamp in (one, other):
            if clamp is other:
                clamp.slave.getDirectionalDerivative(outputs, inputs, [1.0 + n, -3.0])
            clamp.step(H, flange__s=s, flange__v=v, T=300.0 + n)
        assert one.serialised() == other.serialised()


def test_every_unit_of_a_coefficient_is_defined(native_fmus):
    description = fmpy.read_model_description(str(native_fmus[2]))
    units = {unit.name: unit.baseUnit for unit in description.unitDefinitions}
    stiffness = units["N/mm"]
    assert (stiffness.kg, stiffness.m, stiffness.s, float(stiffness.factor)) == (1, 0, -2, 1000.0)
    cubic = units["N/mm3"]
    assert (cubic.kg, cubic.m, cubic.s) == (1, -2, -2)
    assert float(cubic.factor) == pytest.approx(1e9)


@pytest.mark.parametrize("kind", ["native", "python"])
def test_files_of_another_fmu_are_refused(drive, native_fmus, law_with_memory, tmp_path, kind):
    build_clamp(law_with_memory, tmp_path / "python.fmu")
    path = native_fmus[2] if kind == "native" else tmp_path / "python.fmu"
    changes = {
        "line": (lambda text: text.replace("law.k10", "law.k11"), "values.txt: expected law.k10"),
        "digits": (lambda text: text.replace("law.k10 4", "law.k10 "), "expected 16 hexadecimal digits after law.k10"),
        "short": (lambda text: text[:300], "values.txt: expected"),
        "gone": (lambda text: None, "can't be instantiated"),
    }
    if kind == "native":  # pythonfmu doesn't hand the token on
        changes["token"] = (lambda text: "token 0" + text[text.index("\n") :], "model description was read as")
    for name, (change, words) in changes.items():
        with zipfile.ZipFile(path) as archive:
            files = {entry: archive.read(entry) for entry in archive.namelist()}
        text = change(files["resources/values.txt"].decode())
        files["resources/values.txt"] = (text or "").encode()
        with zipfile.ZipFile(tmp_path / f"{name}.fmu", "w") as archive:
            for entry, content in files.items():
                if text is not None or entry != "resources/values.txt":
                    archive.writestr(entry, content)
        with pytest.raises(UserError, match=words):
            drive(tmp_path / f"{name}.fmu")


def test_it_is_built_the_same_twice_and_its_sources_compile_as_they_are(
    monkeypatch, native_fmus, law_with_memory, tmp_path
):
    monkeypatch.setenv("PIPECLAMP_CACHE", "")  # where what was compiled is kept
    build_native_clamp(law_with_memory, tmp_path / "again.fmu")
    assert (tmp_path / "again.fmu").read_bytes() == native_fmus[2].read_bytes()
    build_native_clamp(law_with_memory, tmp_path / "sources.fmu", platforms=())
    with zipfile.ZipFile(tmp_path / "sources.fmu") as archive:
        names = archive.namelist()
        assert not [name for name in names if name.startswith("binaries/")]
        sources = {
            name.removeprefix("sources/"): archive.read(name).decode() for name in names if name.endswith((".c", ".h"))
        }
    (platform,) = {"linux64", "win64", "darwin64"} & {fmpy.platform}
    assert compile_sources(sources, [platform])[platform]


def test_what_says_how_to_build_it_is_valid_in_both_versions(native_fmus):
    for fmi, path in native_fmus.items():
        (configuration,) = read_build_description(str(path))
        (files,) = configuration.sourceFileSets
        assert (files.language, files.sourceFiles) == ("C99", ["fmu.c"])
        assert [entry.name for entry in files.preprocessorDefinitions] == [f"FMI{fmi}_OVERRIDE_FUNCTION_PREFIX"]


def test_an_unknown_platform_is_named(law_with_memory, tmp_path):
    with pytest.raises(UserError, match=r"'amiga'.*linux64"):
        build_native_clamp(law_with_memory, tmp_path / "a.fmu", platforms=["amiga"])
    assert list(tmp_path.iterdir()) == []


def test_a_compiler_s_message_in_another_encoding_is_told(monkeypatch):
    says = "import sys; sys.stderr.buffer.write(b'fmu.c:1: error: ung\\xfcltig\\n'); sys.exit(1)"
    monkeypatch.setattr("pipeclamp_fmu.native.compiler._compiler", lambda name: [sys.executable, "-c", says])
    with pytest.raises(UserError, match=r"failed for linux64: fmu\.c:1: error: ung.ltig"):
        compile_sources({"fmu.c": ""}, ["linux64"])


@pytest.mark.parametrize("fmi", [2, 3])
def test_fmpy_compiles_the_sources_into_the_same_clamp(native_fmus, law_with_memory, tmp_path, fmi):
    """With the standard's own headers, which hold every function to its type."""
    if shutil.which("cmake") is None or system_compiler() is None:
        pytest.skip("CMake or a C compiler is missing: apt-get install cmake gcc")
    build_native_clamp(law_with_memory, tmp_path / "sources.fmu", fmi, platforms=())
    unpacked = fmpy.extract(str(tmp_path / "sources.fmu"), unzipdir=str(tmp_path / "unpacked"))
    build_platform_binary(unpacked, all_warnings=True)
    runs = [
        fmpy.simulate_fmu(str(fmu), start_values={"flange.s": 3e-4}, stop_time=0.1, output=["flange.f"])["flange.f"]
        for fmu in (unpacked, native_fmus[fmi])
    ]
    np.testing.assert_allclose(runs[0], runs[1], rtol=1e-12)
    assert runs[0][-1] > 0
