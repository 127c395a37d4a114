"""A campaign before any test: its order against drift, what it tells, and the files that the rig and readers take."""

from __future__ import annotations

import csv

import numpy as np
import pytest

from pipeclamp_identification.diagnosis.limits import parse_limits
from pipeclamp_identification.planning.campaign import Asked, plan_campaign
from pipeclamp_identification.planning.schedule import RigTimes, hours_of, read_plan, scheduled, table_text
from pipeclamp_identification.planning.telling import NAMED, power, scene, true_law
from pipeclamp_models.base.errors import UsageError, UserError
from pipeclamp_models.law.bundled import open_law

CONDITIONS = [(A, f) for A in (0.2, 0.5, 1.0) for f in (1.0, 3.0, 9.0)]


@pytest.fixture(scope="module")
def seen():
    """What tests of a coarse grid tell."""
    every = np.array([(A, f, T) for A, f in CONDITIONS for T in (293.15, 423.15)])
    return scene(open_law("emwm2"), dict(zip("AfT", every.T, strict=True)), 3.0, 1000.0, 0.003)


@pytest.mark.parametrize("repeats", [2, 4])
def test_even_drift_is_the_same_for_all_conditions(repeats):
    runs = scheduled(CONDITIONS, [20.0, 150.0], repeats, RigTimes(), 3)
    for block in (1, 2):
        own = [run for run in runs if run.block == block and run.kind == "test"]
        places = {condition: [] for condition in CONDITIONS}
        for place, run in enumerate(own):
            places[run.amplitude_mm, run.frequency_Hz].append(place)
        assert {len(one) for one in places.values()} == {repeats}
        assert len({float(np.mean(one)) for one in places.values()}) == 1
        assert [run.kind for run in runs if run.block == block][:: len(own) + 1] == ["reference"] * 2
    assert [run.temperature_C for run in runs] == [20.0] * (len(own) + 2) + [150.0] * (len(own) + 2) + [20.0]


def test_heating_and_cycles_are_counted():
    times = RigTimes(heating=2.0, soak_min=10.0, pause_s=20.0)
    runs = scheduled([(0.5, 2.0)], [20.0, 120.0], 1, times, 0)
    waits = {run.start_min: run.wait_min for run in runs if run.wait_min}
    assert list(waits.values()) == [60.0, 60.0]
    assert [run.first_cycle for run in runs] == list(range(0, 70, 10))
    assert hours_of(runs, times) == pytest.approx((7 * (10 / 2.0 + 20.0) + 2 * 3600) / 3600)


def test_more_runs_tell_more(seen):
    once, thrice = (power(seen, np.full(len(seen.grid["A"]), count)) for count in (1.0, 3.0))
    assert thrice.apart == pytest.approx(np.sqrt(3) * once.apart)
    assert np.all(thrice.sizes <= 1.001 * once.sizes)
    assert thrice.from_newtons <= once.from_newtons
    for place, newtons in enumerate(once.sizes):
        if np.isfinite(newtons):
            assert once.chance(1.001 * newtons)[place] >= NAMED - 1e-3
    assert np.mean(once.chance(once.from_newtons)[once.told]) == pytest.approx(NAMED, abs=0.05)


def test_what_follows_temperature_is_told_at_several_alone(seen):
    cold = seen.grid["T"] < 300.0
    names = np.array(seen.effects)
    several = power(seen, np.full(len(cold), 2.0))
    one = power(seen, 2.0 * cold)
    place = int(np.flatnonzero(names == "damping_temperature")[0])
    assert several.told[place]
    assert not one.told[place]
    assert {"density", "condition", "loosening"} <= set(seen.not_reckoned)


@pytest.mark.parametrize("effect", ["memory", "gap", "quadratic_damping"])
def test_a_law_has_the_effect_in_the_size_that_was_asked(seen, effect):
    from pipeclamp_identification.planning.telling import bare_law
    from pipeclamp_models.realise.force import force_of_law
    from pipeclamp_models.realise.motion import sinusoids

    law = true_law(open_law("emwm2"), seen, effect, 6.0)
    motion = sinusoids(*(seen.grid[name] for name in "AfT"))
    beyond = force_of_law(law, motion).force - force_of_law(bare_law(open_law("emwm2")), motion).force
    assert np.sqrt(np.mean(beyond**2)) == pytest.approx(6.0, rel=0.05)


def test_a_plan_keeps_its_hours_and_its_limits():
    limits = parse_limits("A=0.2..1,f=1..6,T=20..20,v=..25")
    plan = plan_campaign(open_law("emwm2"), limits, Asked(hours=0.5))
    assert plan.hours <= 0.5
    assert all(2 * np.pi * run.amplitude_mm * run.frequency_Hz <= 25 for run in plan.runs)
    assert len(plan.stages) == 1
    assert plan.stages[-1].newtons == pytest.approx(plan.power.from_newtons)
    with pytest.raises(UsageError, match="no campaign fits into that; the shortest takes"):
        plan_campaign(open_law("emwm2"), limits, Asked(hours=0.01))


def test_the_table_is_read_back(tmp_path):
    runs = scheduled(CONDITIONS, [20.0, 150.0], 2, RigTimes(), 0)
    (tmp_path / "plan.csv").write_text(table_text(runs), encoding="utf-8")
    assert [run.run for run in read_plan(tmp_path)] == [run.run for run in runs]
    rows = list(csv.DictReader(table_text(runs).splitlines()))
    rows[3]["amplitude_mm"] = "much"
    text = ",".join(rows[0]) + "\n" + "".join(",".join(row.values()) + "\n" for row in rows)
    (tmp_path / "plan.csv").write_text(text, encoding="utf-8")
    with pytest.raises(UserError, match="row 5, column 'amplitude_mm': got 'much'"):
        read_plan(tmp_path / "plan.csv")
