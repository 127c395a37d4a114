"""A clamp FMU that was told other A and f than those of its motion says so: once, with what to set, in an output."""

import math
import re
from functools import partial

import fmpy
import numpy as np
import pytest
from native_driver import INTERFACES, NativeDriver

from pipeclamp_fmu.build import build_clamp, build_native_clamp
from pipeclamp_fmu.contents.clamp_model import ClampStart
from pipeclamp_fmu.contents.clamp_of_law import clamp_model
from pipeclamp_fmu.native.compiler import system_compiler
from pipeclamp_fmu.set_parameters import set_parameters
from pipeclamp_models.base.errors import UserError

A, F = 3e-4, 4.0
STEPS = 100
H = 1 / (F * STEPS)
BUILD = {
    "python": build_clamp,
    "native": build_native_clamp,
    "native_3": lambda file, path, start: build_native_clamp(file, path, 3, start=start),
}


@pytest.fixture(scope="module")
def built(tmp_path_factory, law_with_memory):
    """Give a function that builds an FMU of the law with memory, of a kind."""
    if system_compiler() is None:
        pytest.skip("there is no C compiler (cc, gcc or clang) on the path")
    folder = tmp_path_factory.mktemp("built")
    made = {}

    def make(kind, **told):
        key = (kind, *sorted(told.items()))
        if key not in made:
            made[key] = folder / f"{len(made)}.fmu"
            BUILD[kind](law_with_memory, made[key], start=ClampStart(**told))
        return made[key]

    return make


def sinusoid(amplitude=A, frequency=F, mean=0.0, steps=STEPS):
    """Give s (m) and v (m/s) after n steps."""

    def at(n):
        theta = 2 * math.pi * n / steps
        return mean + amplitude * math.sin(theta), 2 * math.pi * frequency * amplitude * math.cos(theta)

    return at


def moved(clamp, motion, begin, end, h=H):
    """Move a clamp along a motion and give the deviations that it shows."""
    seen = []
    for n in range(begin + 1, end + 1):
        s, v = motion(n)
        clamp.step(h, flange__s=s, flange__v=v)
        seen.append(clamp.get("forceDeviation"))
    return seen


def loop(model, amplitude, frequency, used_A, used_f, mean=0.0):
    """Give the law's forces over the second cycle of a sinusoid, evaluated at an A (mm) and an f (Hz)."""
    law = model.law
    k, state, before, forces = law.coefficients(used_A, used_f, model.temperature), (0.0,), mean, []
    for n in range(1, 2 * STEPS + 1):
        theta = 2 * math.pi * n / STEPS
        y, v = mean + amplitude * math.sin(theta), 2 * math.pi * frequency * amplitude * math.cos(theta)
        force, _, state = law.step(k, state, before, y, v, 1 / (frequency * STEPS))
        before = y
        forces.append(force)
    return np.array(forces[STEPS:])


def off(model, amplitude=0.3, frequency=4.0, told=(0.6, 3.0), mean=0.0):
    """Give the share of the force, of the whole law with its memory, by which the told A and f are off."""
    own = loop(model, amplitude, frequency, amplitude, frequency, mean)
    return float(np.sqrt(np.mean((loop(model, amplitude, frequency, *told, mean) - own) ** 2) / np.mean(own**2)))


@pytest.mark.parametrize("kind", ["python", "native"])
def test_as_built_it_says_once_that_the_motion_is_another(drive, built, law_with_memory, kind):
    clamp = drive(built(kind))
    share = off(clamp_model(law_with_memory))
    seen = moved(clamp, sinusoid(), 0, 6 * STEPS)
    assert share > 0.05
    assert seen[STEPS - 1] == 0.0  # nothing is said of a cycle that isn't whole
    assert seen[-1] == pytest.approx(share, rel=0.05)
    assert clamp.get("inRange")
    (said,) = clamp.messages.warnings
    told = r"law stand-in is told A = 0\.6 mm, f = 3 Hz, and the motion has A = 0\.3 mm, f = 4 Hz: "
    off_by = r"the force is off by (.*) percent; set A = 0\.0003 m and f = 4 Hz, or track = true"
    (percent,) = re.fullmatch(told + off_by, said).groups()
    assert float(percent) == pytest.approx(100 * share, rel=0.05)


@pytest.mark.parametrize("kind", BUILD)
@pytest.mark.parametrize("told", [{"track": True}, {"A": A, "f": F}], ids=["track", "A and f"])
def test_told_rightly_it_says_nothing_and_the_force_is_right(built, law_with_memory, capfd, kind, told):
    cycles = 20
    time = np.arange(cycles * STEPS + 1) * H
    s, v = np.array([sinusoid()(n) for n in range(time.size)]).T
    signals = np.rec.fromarrays([time, s, v], names=["time", "flange.s", "flange.v"])
    path, names = str(built(kind, **told)), ["flange.f", "forceDeviation", "flange.s"]
    result = fmpy.simulate_fmu(
        path, fmi_type="CoSimulation", stop_time=time[-1], step_size=H, output_interval=H, input=signals,
        output=names, debug_logging=True,
    )  # fmt: skip
    shown = capfd.readouterr().out
    assert "WARNING" not in shown
    assert "missing input" not in shown
    assert result["forceDeviation"].max() < 2e-3
    expected = loop(clamp_model(law_with_memory), 0.3, F, 0.3, F)
    expected, force = np.roll(expected, 1), result["flange.f"][-STEPS:]  # fmpy sets a step's values at its start
    assert np.sqrt(np.mean((force - expected) ** 2) / np.mean(expected**2)) < 0.02


@pytest.mark.parametrize("kind", BUILD)
def test_fmpy_misses_no_input_where_s_and_v_are_given(built, capfd, kind):
    signals = np.array([(0.0, 0.0, 0.0), (0.1, 1e-4, 1e-3)], [(n, float) for n in ("time", "flange.s", "flange.v")])
    fmpy.simulate_fmu(str(built(kind)), fmi_type="CoSimulation", stop_time=0.1, input=signals)
    shown = capfd.readouterr()
    assert "missing input" not in shown.out + shown.err


@pytest.mark.parametrize("kind", BUILD)
def test_the_temperature_is_an_input_where_asked_for(built, kind):
    for asked, causality in ((False, "parameter"), (True, "input")):
        description = fmpy.read_model_description(str(built(kind, T=350.0, connected_temperature=asked)))
        variables = {variable.name: variable for variable in description.modelVariables}
        assert variables["T_in"].causality == causality
        assert float(variables["T_in"].start) == 350.0
        assert variables["useTemperatureInput"].start == str(asked).lower()


@pytest.mark.parametrize(("fmi", "kind"), INTERFACES)
def test_every_native_interface_shows_the_same(built, tmp_path, fmi, kind):
    path = built("native" if fmi == 2 else "native_3")
    clamps = [NativeDriver(path, tmp_path / which, which, {}) for which in sorted({"CoSimulation", kind})]
    for n in range(1, 4 * STEPS):
        for clamp in clamps:
            clamp.step(H, *sinusoid()(n))
    shown = [clamp.get("forceDeviation")[0] for clamp in clamps]
    assert shown == pytest.approx([shown[0]] * len(shown), rel=1e-9)
    assert shown[0] > 0.05
    for clamp in clamps:
        assert clamp.jacobian(["forceDeviation"], ["flange.s", "flange.v", "A"]) == [[0.0, 0.0, 0.0]]
        clamp.free()


def test_both_kinds_show_the_same(drive, built):
    """Over a motion of two frequencies about a mean, with a change of what the clamp is told, rest, and a reset."""
    clamps = [drive(built(kind)) for kind in ("python", "native")]
    slow, fast = sinusoid(2e-4, 2.0, 1e-4, 2 * STEPS), sinusoid(5e-5, 18.0, 0.0, STEPS / 4.5)
    both = [tuple(map(sum, zip(slow(n), fast(n), strict=True))) for n in range(10 * STEPS)]
    shown = []
    for clamp in clamps:
        seen = moved(clamp, both.__getitem__, 0, 8 * STEPS)
        clamp.set({"A": 4e-4})
        seen += moved(clamp, sinusoid(), 0, 4 * STEPS)
        seen += moved(clamp, lambda n: (0.0, 0.0), 0, STEPS)
        seen += moved(clamp, sinusoid(2e-4), 0, 4 * STEPS)
        clamp.set({"track": True})
        seen += moved(clamp, sinusoid(), 0, 2 * STEPS)
        assert seen[-1] == 0.0
        clamp.set({"track": False})
        seen += moved(clamp, sinusoid(), 0, 4 * STEPS)
        shown.append(seen)
    np.testing.assert_allclose(shown[1], shown[0], rtol=1e-9, atol=1e-12)
    assert clamps[0].messages.warnings == clamps[1].messages.warnings
    assert len(clamps[0].messages.warnings) == 1


@pytest.mark.parametrize("kind", ["python", "native"])
def test_it_is_rolled_back_with_the_state_and_new_after_reset(drive, built, kind):
    clamp, twin = drive(built(kind)), drive(built(kind))
    motion = sinusoid()
    whole = moved(twin, motion, 0, 5 * STEPS)
    first = moved(clamp, motion, 0, STEPS + 30)
    state, time = clamp.save(), clamp.time
    data = clamp.serialised()
    moved(clamp, sinusoid(8e-4), 0, 3 * STEPS)
    clamp.restore(state)
    clamp.time = time
    assert first + moved(clamp, motion, STEPS + 30, 5 * STEPS) == whole
    clamp.deserialise(data)
    assert moved(clamp, motion, STEPS + 30, 5 * STEPS) == whole[STEPS + 30 :]
    said = len(clamp.messages.warnings)
    clamp.slave.reset()
    clamp.start({})
    assert clamp.get("forceDeviation") == 0.0
    assert moved(clamp, motion, 0, 5 * STEPS) == whole
    assert len(clamp.messages.warnings) == said + 1


def dying(n):
    """A motion of the told A and f that rings down, by 15 % a cycle."""
    share = 0.85 ** (n / STEPS)
    s, v = sinusoid(6e-4, 3.0)(n)
    return share * s, share * v


QUIET = {
    "rest": (lambda n: (0.0, 0.0), H),
    "as told": (sinusoid(6e-4, 3.0, 0.0, STEPS), 1 / (3.0 * STEPS)),
    "as told, about a mean": (sinusoid(6e-4, 3.0, 2e-4, STEPS), 1 / (3.0 * STEPS)),
    "as told, in coarse steps": (sinusoid(6e-4, 3.0, 0.0, 20.5), 1 / (3.0 * 20.5)),
    "half a cycle of another": (lambda n: sinusoid()(min(n, STEPS // 2)), H),
    "too small to matter": (sinusoid(1e-9), H),
    "rings down": (dying, 1 / (3.0 * STEPS)),
}


@pytest.mark.parametrize("which", QUIET)
def test_no_false_alarm(drive, built, which):
    motion, h = QUIET[which]
    clamp = drive(built("native"))
    seen = moved(clamp, motion, 0, 8 * STEPS, h)
    assert clamp.messages.warnings == []
    if which != "rings down":  # which shows what the force is off by all the same
        assert max(seen) < 0.01


def test_a_sweep_that_track_serves_is_no_alarm(drive, built):
    clamp = drive(built("native", track=True))
    phase = 0.0
    for n in range(1, 4000):
        frequency = 1.0 + 4.0 * n / 4000
        phase += 2 * math.pi * frequency * 2e-3
        speed = 2 * math.pi * frequency * 4e-4
        clamp.step(2e-3, flange__s=4e-4 * math.sin(phase), flange__v=speed * math.cos(phase))
        assert clamp.get("forceDeviation") == 0.0
    assert clamp.messages.warnings == []


@pytest.mark.parametrize("kind", ["python", "native"])
def test_a_law_that_does_not_depend_on_a_and_f_is_never_off(drive, built, law_with_memory, kind):
    exponents = [name for name in law_with_memory.coefficients if name.endswith(("_A", "_f"))]
    clamp = drive(built(kind), {f"law.{name}": 0.0 for name in exponents})
    assert max(moved(clamp, sinusoid(9e-4), 0, 4 * STEPS)) == 0.0
    assert clamp.messages.warnings == []


@pytest.mark.parametrize("kind", ["python", "native"])
def test_another_law_s_parameters_leave_what_the_fmu_was_told(built, law_with_memory, tmp_path, kind):
    told = {"A": 9e-4, "f": 2.0, "T": 350.0, "track": True, "connected_temperature": True}
    wider = law_with_memory.range | {"A": law_with_memory.range["A"].model_copy(update={"maximum": 1.2})}
    other = law_with_memory.model_copy(update={"name": "other", "range": wider})
    BUILD[kind](other, tmp_path / "anew.fmu", start=ClampStart(**told))
    set_parameters(built(kind, **told), other, tmp_path / "changed.fmu")
    assert (tmp_path / "changed.fmu").read_bytes() == (tmp_path / "anew.fmu").read_bytes()
    usual = tmp_path / "usual.fmu"
    set_parameters(built(kind), other, usual)
    starts = {entry.name: entry.start for entry in fmpy.read_model_description(str(usual)).modelVariables}
    assert float(starts["A"]) == pytest.approx(7e-4)
    assert starts["track"] == "false"
    narrow = law_with_memory.range | {"A": law_with_memory.range["A"].model_copy(update={"maximum": 0.8})}
    with pytest.raises(UserError, match=r"amplitude A = 0\.9 mm; expected 0\.2 to 0\.8 mm"):
        set_parameters(built(kind, **told), law_with_memory.model_copy(update={"range": narrow}), usual)


@pytest.mark.parametrize(
    ("told", "words"),
    [
        ({"A": 3e-3}, r"amplitude A = 3 mm; expected 0\.2 to 1 mm"),
        ({"f": 0.5}, r"frequency f = 0\.5 Hz; expected 1 to 5 Hz"),
        ({"T": 673.15}, r"temperature T = 400 °C; expected 20 to 300 °C"),
    ],
)
def test_start_values_beyond_the_range_are_refused(law_with_memory, tmp_path, told, words):
    for build in (build_clamp, partial(build_native_clamp, platforms=())):
        with pytest.raises(UserError, match=words):
            build(law_with_memory, tmp_path / "clamp.fmu", start=ClampStart(**told))
    assert not (tmp_path / "clamp.fmu").exists()
