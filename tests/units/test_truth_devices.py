"""The other devices: their laws are integrated soundly, by code of their own, and counted in the issue's words."""

from pathlib import Path

import numpy as np
import pytest

FOLDER = Path(__file__).parents[2] / "build_scripts" / "truth_table"
LAWS = (
    "bouc_wen", "dahl", "iwan", "power_law", "friction_pendulum", "drag", "zener_slip", "loose_hanger", "baber_noori",
    "slip_lock", "play_and_slip", "relief_damper", "rubber", "mr_damper", "memory_alloy", "wire_rope", "lugre",
    "air_spring", "hydraulic_mount",
)  # fmt: skip
MOST_STEP_ERROR = 3e-4
"""Rms by which the force may depend on the step, as a share of its rms: a tenth of the least sensor noise."""


@pytest.fixture(autouse=True)
def rig_on_path(monkeypatch):
    monkeypatch.syspath_prepend(FOLDER)


def test_every_law_is_tried_here():
    from devices.registry import DEVICES

    assert set(DEVICES) == set(LAWS)
    assert 2 * sum(not device.inside for device in DEVICES.values()) >= len(DEVICES)


def test_the_laws_share_no_code_with_the_package():
    from test_imports import imported

    for module in ("drive", "hysteresis", "flow", "registry", "rigs"):
        names = {name.split(".")[0] for name in imported(FOLDER / "devices" / f"{module}.py")}
        assert not any(name.startswith("pipeclamp") for name in names), module


def driven(law, finer, seed):
    """The drive (largest and smallest amplitude, fastest frequency) and the force of a drawn device at the samples."""
    from devices.registry import DEVICES
    from devices.rigs import RIGS, Set, driven, habits

    device = DEVICES[law]
    rig = RIGS[device.rigs[0]]
    random = np.random.default_rng(seed)
    p = device.draw(random, rig.largest, 1000.0, rig.turn)
    plan = rig.campaign
    current = max(plan.current) if plan.current else None
    runs = [Set(A, max(plan.f), plan.T[0], current) for A in (plan.A[0], plan.A[-1])]
    drive, every = driven(
        runs, rig.rate, habits(random), random, round(finer * device.steps), finer * device.fastest(p)
    )
    force = device.force(drive, p)
    return drive, force, every, round(rig.rate / max(plan.f))


@pytest.mark.parametrize("law", LAWS)
def test_loops_close_dissipate_and_do_not_depend_on_the_step(law):
    drive, force, every, samples = driven(law, 1.0, seed=5)
    _, finer, finer_every, _ = driven(law, 2.0, seed=5)
    assert np.all(np.isfinite(force))
    shown, shown_finer = force[::every], finer[::finer_every]
    error = np.sqrt(np.mean((shown - shown_finer) ** 2) / np.mean(shown**2))
    assert error < MOST_STEP_ERROR

    cycle = samples * every
    last, before = force[-cycle - 1 :], force[-2 * cycle - 1 : -cycle]
    y = drive.y[::2]
    work = np.trapezoid(last, y[-cycle - 1 :], axis=0)
    size = np.ptp(last, axis=0) * np.ptp(y, axis=0)
    assert np.all(work > 0.005 * size)
    assert np.all(work < size)
    drift = np.sqrt(np.mean((last - before) ** 2) / np.mean(last**2))
    assert drift < (0.02 if law in ("baber_noori", "rubber") else 0.005)  # one degrades, one has arms slower than a run


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


def test_the_table_says_what_was_missed():
    from devices.table import device_markdown, devices_sound

    rows = [
        {
            "name": "rubber/mount/0", "truth": [], "before": 0.1, "after": after, "floor": 0.005, "counted": counted,
            "seconds": 3.0, "error": "",
            "rungs": [{"verdict": "missing", "kind": "part", "effects": ["relaxation"]},
                      {"verdict": "complete", "kind": "", "effects": []}],
        }
        for after, counted in ((0.01, "falsely complete"), (0.02, "unknown"), (0.03, "unknown"))
    ]  # fmt: skip
    text = device_markdown(rows, "the command")
    assert "| held-out error over the floor after --auto (median) | 3 | 4.00 | <= 2.50 | **missed** |" in text
    assert "relaxation (part); complete" in text
    assert not devices_sound(rows)
    assert devices_sound(rows[1:])
