"""The other devices: their laws are integrated soundly, by code of their own, and counted in the issue's words."""

import numpy as np
import pytest
from project import TRUTH_TABLE, imported

LAWS = (
    "bouc_wen", "dahl", "iwan", "power_law", "friction_pendulum", "drag", "zener_slip", "loose_hanger", "baber_noori",
    "slip_lock", "play_and_slip", "relief_damper", "rubber", "mr_damper", "memory_alloy", "wire_rope", "lugre",
    "air_spring", "hydraulic_mount", "ring_spring", "eddy_current", "sliding_bearing", "warm_rubber",
)  # fmt: skip
MOST_STEP_ERROR = 3e-4
"""Rms by which the force may depend on the step, as a share of its rms: a tenth of the least sensor noise."""


def test_every_law_is_tried_here():
    from devices.registry import DEVICES

    assert set(DEVICES) == set(LAWS)
    assert sum(not device.effects for device in DEVICES.values()) >= 10  # outside, whatever the catalogue gains
    assert len(DEVICES) >= 12


def test_a_device_is_inside_when_the_catalogue_has_all_that_it_holds(monkeypatch):
    from devices import cases

    monkeypatch.setattr(cases, "identifiers", lambda: ("memory", "gap"))
    assert cases.DeviceCase("power_law", 0).truth == {"memory"}
    assert cases.DeviceCase("play_and_slip", 0).truth == frozenset()
    monkeypatch.setattr(cases, "identifiers", lambda: ("memory", "play"))
    assert cases.DeviceCase("play_and_slip", 0).truth == {"memory", "play"}
    assert cases.DeviceCase("rubber", 0).truth == frozenset()


def test_the_laws_share_no_code_with_the_package():

    for module in ("drive", "hysteresis", "flow", "registry", "rigs"):
        names = {name.split(".")[0] for name in imported(TRUTH_TABLE / "devices" / f"{module}.py")}
        assert not any(name.startswith("pipeclamp") for name in names), module


def driven(law, share, seed):
    """The smallest and the largest amplitude at the highest frequency on a rig, with this share of a law's own steps.

    Gives the drive, the force, steps between two samples and samples a cycle.
    """
    from devices.registry import DEVICES
    from devices.rigs import RIGS, Set, driven, habits

    device = DEVICES[law]
    rig = RIGS[device.rigs[0]]
    random = np.random.default_rng(seed)
    p = device.draw(random, rig.largest, 1000.0, rig.turn)
    plan, f = rig.campaign, max(rig.campaign.f)
    current = max(plan.current) if plan.current else None
    runs = [Set(A, f, plan.T[0], current) for A in (plan.A[0], plan.A[-1])]
    steps, fastest = round(share * device.steps), share * device.fastest(p)
    drive, every = driven(runs, rig.rate, habits(random), random, steps, fastest, device.run_in)
    return drive, device.force(drive, p), every, round(rig.rate / f)


@pytest.mark.parametrize("law", LAWS)
def test_loops_close_dissipate_and_do_not_depend_on_the_step(law):
    drive, force, every, samples = driven(law, 1.0, seed=5)
    _, coarser, coarser_every, _ = driven(law, 0.5, seed=5)
    shown, shown_coarser = force[::every], coarser[::coarser_every]
    assert np.all(np.isfinite(force))
    assert np.sqrt(np.mean((shown - shown_coarser) ** 2) / np.mean(shown**2)) < MOST_STEP_ERROR

    cycle = samples * every
    last, before = force[-cycle - 1 :], force[-2 * cycle - 1 : -cycle]
    y = drive.y[::2]
    work = np.trapezoid(last, y[-cycle - 1 :], axis=0)
    size = np.ptp(last, axis=0) * np.ptp(y, axis=0)
    assert np.all(work > 0)
    assert np.all(work < size)
    assert work[-1] > 0.03 * size[-1]  # the largest loop is one to be seen
    drift = np.sqrt(np.mean((last - before) ** 2) / np.mean(last**2))
    assert drift < (0.02 if law == "baber_noori" else 0.005)  # that one degrades


def sine(A, f, cycles=12, steps=2000):
    """A ramped sine of one amplitude without distortion."""
    from devices.drive import Drive, ramped

    step = 1 / (f * steps)
    channels = ramped({1: np.array([-1j * A])}, f, step, cycles * steps, 1.0)
    return Drive(step, *channels, f, np.array([20.0]), np.zeros(1))


def last_work(drive, force, steps=2000):
    """Energy of the last cycle, N mm."""
    return float(np.trapezoid(force[-steps - 1 :, 0], drive.y[::2][-steps - 1 :, 0]))


def test_velocity_and_acceleration_are_the_displacement_s_slopes():
    drive = sine(2.0, 3.0, cycles=2)
    h = drive.step / 2
    assert np.gradient(drive.y[:, 0], h)[1:-1] == pytest.approx(drive.v[1:-1, 0], abs=1e-4 * np.ptp(drive.v))
    smooth = np.gradient(drive.v[:, 0], h)[1:-1]  # the acceleration steps where a raised cosine begins and ends
    assert smooth == pytest.approx(drive.a[1:-1, 0], abs=0.02 * np.ptp(drive.a))
    assert drive.y[0, 0] == drive.v[0, 0] == 0.0


def test_energies_known_in_closed_form():
    """Jenkins: 4 F (A - D); Maxwell: pi k A^2 w tau / (1 + (w tau)^2); drag: pi c w A^2 + 8/3 c2 w^2 A^3."""
    from devices.flow import drag, zener_slip
    from devices.hysteresis import friction_pendulum

    A, f = 2.0, 3.0
    w, drive = 2 * np.pi * f, sine(A, f)
    pendulum = friction_pendulum(drive, {"W": 1000.0, "radius": 30.0, "mu": 0.08, "limit": 0.1})
    assert last_work(drive, pendulum) == pytest.approx(4 * 80.0 * (A - 0.1), rel=1e-4)
    tau = 0.04
    arm = zener_slip(drive, {"k": 50.0, "k_m": 70.0, "tau": tau, "F": 0.0, "limit": 1.0})
    assert last_work(drive, arm) == pytest.approx(np.pi * 70.0 * A**2 * w * tau / (1 + (w * tau) ** 2), rel=1e-4)
    flow = drag(drive, {"x": 2.0, "k": 50.0, "k3": 0.3, "k5": 0.2, "c": 0.5, "c2": 0.03})
    assert last_work(drive, flow) == pytest.approx(np.pi * 0.5 * w * A**2 + 8 / 3 * 0.03 * w**2 * A**3, rel=1e-4)


def rung(verdict, kind="", *effects):
    from devices.judge import Rung

    return Rung(verdict, kind, effects, 0.1, (), 1.0)


@pytest.mark.parametrize(
    ("truth", "rungs", "ratio", "expected"),
    [
        (set(), [("missing", "cause", "memory"), ("unknown",)], 2.0, "wrong"),
        (set(), [("missing", "part", "memory"), ("unknown",)], 9.0, "unknown"),
        ({"memory"}, [("missing", "cause", "memory"), ("complete",)], 1.1, "complete"),
        ({"memory"}, [("missing", "cause", "memory"), ("complete",)], 1.4, "falsely complete"),
        ({"memory"}, [("missing", "cause", "gap"), ("complete",)], 1.1, "wrong"),
        (set(), [("unknown",), ("missing", "part", "memory")], 9.0, "part"),
        ({"memory"}, [("ambiguous", "", "gap", "memory")], 3.0, "ambiguous"),
    ],
)
def test_how_a_device_came_out(truth, rungs, ratio, expected):
    from devices.judge import counted

    assert counted(frozenset(truth), [rung(*one) for one in rungs], ratio) == expected


def test_the_kind_of_a_diagnosis_is_recorded_where_it_has_one():
    from types import SimpleNamespace

    from devices.judge import kind_of

    assert kind_of(SimpleNamespace(verdict="missing", diagnosis=SimpleNamespace())) == "cause"
    assert kind_of(SimpleNamespace(verdict="missing", diagnosis=SimpleNamespace(kind="part"))) == "part"
    assert kind_of(SimpleNamespace(verdict="missing", kind="part")) == "part"
    assert kind_of(SimpleNamespace(verdict="unknown")) == ""


def test_written_tests_are_read_as_a_campaign(tmp_path):
    from devices.cases import DeviceCase, write_device

    from pipeclamp_identification.campaign.reading import read_campaign

    write_device(DeviceCase("drag", 0), 3, tmp_path)
    campaign, held_out = (read_campaign(tmp_path / name, strict=True) for name in ("campaign", "held_out"))
    assert len(campaign.runs) == 16
    assert not {run.frequency_Hz for run in campaign.runs} & {run.frequency_Hz for run in held_out.runs}
    assert not {run.amplitude_mm for run in campaign.runs} & {run.amplitude_mm for run in held_out.runs}


def test_what_scatters_from_cycle_to_cycle_is_the_sensor(tmp_path):
    """Rubber that still settles would raise the floor that errors are counted over."""
    from devices.cases import DeviceCase, write_device
    from devices.rigs import rms

    from pipeclamp_identification.campaign.reading import read_campaign
    from pipeclamp_identification.loops.loops import loops_of

    tests = write_device(DeviceCase("rubber", 0), 1, tmp_path)
    sensor = tests.noise * rms(tests.campaign) / rms(tests.held_out)
    assert loops_of(read_campaign(tmp_path / "held_out")).noise_nrmse == pytest.approx(sensor, rel=0.1)


def test_a_device_is_put_to_the_package_as_a_user_would(monkeypatch):
    """Read, identified, compared and counted for real; the diagnosis alone is stood in for, to be fast."""
    from types import SimpleNamespace

    from devices import judge
    from devices.cases import DeviceCase

    class Tests:
        def __init__(self, campaign):
            assert len(campaign.runs) == 16

        def without_spare_powers(self, *_):
            return None

        def diagnose(self, file, **_):
            return SimpleNamespace(
                verdict="complete", effects=(), values={}, diagnosis=SimpleNamespace(reasons=("it fits",))
            )

    monkeypatch.setattr(judge, "RecordTests", Tests)
    outcome = judge.judged_device(DeviceCase("drag", 0), 1)
    assert outcome.error == ""
    assert outcome.counted == "falsely complete"  # the base law lacks its quadratic drag
    assert outcome.before == outcome.after > judge.FALSELY_COMPLETE * outcome.floor
    assert outcome.truth == ("hardening", "quadratic_damping", "viscous")
    assert 0.5 * outcome.noise < outcome.floor < 2 * outcome.noise


def test_the_table_says_what_was_missed():
    from devices.table import device_markdown, devices_sound

    rows = [
        {
            "name": "rubber/mount/0", "truth": [], "before": 0.1, "after": after, "floor": 0.005, "counted": counted,
            "seconds": 3.0, "identify_seconds": 0.5, "error": "",
            "rungs": [{"verdict": "missing", "kind": "part", "effects": ["relaxation"], "held_out": 0.1, "seconds": 2},
                      {"verdict": "complete", "kind": "", "effects": [], "held_out": 0.02, "seconds": 1}],
        }
        for after, counted in ((0.01, "falsely complete"), (0.02, "unknown"), (0.03, "unknown"))
    ]  # fmt: skip
    text = device_markdown(rows, "the command")
    assert "| held-out error over the floor after --auto (median) | 3 | 4.00 | <= 2.50 | **missed** |" in text
    assert "10.0% relaxation (part); 2.0% complete" in text
    assert "| time of a ladder's step over that of identify (median) | 3 | 3.00 | <= 10.00 | met |" in text
    assert not devices_sound(rows)
    assert devices_sound(rows[1:])
