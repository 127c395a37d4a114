"""A campaign before any test: its order against drift, what it tells, and the files that the rig and readers take."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from few_effects import few_effects

from pipeclamp.show.campaign_plan import campaign_plan_words
from pipeclamp_identification.diagnosis.evidence import lack_of_fit
from pipeclamp_identification.diagnosis.further_test.limits import parse_limits
from pipeclamp_identification.diagnosis.left_out import Whitened
from pipeclamp_identification.diagnosis.noise import NoiseModel
from pipeclamp_identification.diagnosis.run_scatter import Directions, RunScatter
from pipeclamp_identification.fitting.smooth_trends import smooth_functions
from pipeclamp_identification.planning.campaign import PlanRequest, plan_campaign
from pipeclamp_identification.planning.campaign_answer import plan_files
from pipeclamp_identification.planning.hidden import bare_law, law_of_size
from pipeclamp_identification.planning.rig_times import RigTimes
from pipeclamp_identification.planning.scene import scene
from pipeclamp_identification.planning.schedule import hours_of, read_plan, scheduled, table_text
from pipeclamp_identification.planning.seen import lack_of
from pipeclamp_identification.planning.telling import NAMED, power
from pipeclamp_models.base.errors import UsageError, UserError
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.realise.force import force_of_law
from pipeclamp_models.realise.motion import sinusoids

CONDITIONS = [(A, f) for A in (0.2, 0.5, 1.0) for f in (1.0, 3.0, 9.0)]
EFFECTS = (
    "memory", "bouc_wen", "slip_spread", "offset", "asymmetry", "quadratic_damping", "stiffness_frequency",
    "damping_temperature", "relaxation", "end_stop",
)  # fmt: skip
FOLLOWING_OTHER = ("density", "condition", "loosening", "fade")


@pytest.fixture(scope="module")
def seen():
    """What tests of a coarse grid tell."""
    every = np.array([(A, f, T) for A, f in CONDITIONS for T in (293.15, 423.15)])
    with few_effects(*EFFECTS, *FOLLOWING_OTHER):
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
    several = np.isfinite(once.away)
    assert thrice.away[several] == pytest.approx(3 * once.away[several], rel=1e-6, abs=1e-6)
    assert np.all(thrice.sizes <= 1.05 * once.sizes)
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
    assert set(FOLLOWING_OTHER) <= set(seen.not_reckoned)


def test_a_rival_takes_the_place_of_a_small_effect(seen):
    """Bouc and Wen's element, sharp enough, does what an element that sticks and slips does, but at its bend."""
    place = seen.effects.index("memory")
    rivals = [rival.name for rival in seen.hidden[place].rivals]
    assert "bouc_wen" in rivals
    assert "slip_spread" not in rivals, "memory is its special case, and is named in its place"
    found = power(seen, np.full(len(seen.grid["A"]), 2.0))
    every = np.geomspace(1.0, 100.0, 50)
    seen_from = next(
        one for one in every if found.lack.chance(np.full(len(seen.effects), one), seen.least)[place] > NAMED
    )
    assert seen_from * seen.sizes[place] < 0.8 * found.sizes[place] < np.inf


def test_the_lack_of_fit_is_that_of_the_diagnosis():
    """Noise is next to nothing here, and so is what is taken off for it."""
    random = np.random.default_rng(4)
    conditions = np.array([(A, f, 293.15) for A, f in CONDITIONS])
    runs, channels, noise = 2.0 * np.ones(len(conditions)), 5, 1e-6
    slopes, does = random.standard_normal((2, len(runs), channels)), random.standard_normal((1, len(runs), channels))
    grid = dict(zip("AfT", conditions.T, strict=True))
    covariance = np.tile(noise**2 * np.eye(channels), (len(runs), 1, 1))
    found = lack_of(grid, runs, covariance, slopes, does)
    every = np.repeat(np.arange(len(runs)), 2)
    columns = slopes[:, every].reshape(2, -1).T
    left = does[0, every].ravel()
    left = (left - columns @ np.linalg.lstsq(columns, left, rcond=None)[0]).reshape(len(every), channels)
    smooth = smooth_functions(*(grid[name][every] for name in "AfT"), (), [None] * len(every))
    white = Whitened(left / noise, np.moveaxis(slopes[:, every], 0, -1) / noise, np.zeros(0))
    none = np.zeros_like(left)
    model = NoiseModel(np.full_like(left, noise**2), Directions(none, none, none), RunScatter(), 0.0)
    told = lack_of_fit(white, left, model, smooth, np.ones((1, 2, *left.shape)), np.full(len(every), noise))
    assert found.excess[0] == pytest.approx(told.excess, rel=1e-6)


@pytest.mark.parametrize("effect", ["memory", "gap", "quadratic_damping"])
def test_a_law_has_the_effect_in_the_size_that_was_asked(seen, effect):
    law = law_of_size(open_law("emwm2"), effect, 6.0, seen.grid)
    motion = sinusoids(*(seen.grid[name] for name in "AfT"))
    beyond = force_of_law(law, motion).force - force_of_law(bare_law(open_law("emwm2")), motion).force
    assert np.sqrt(np.mean(beyond**2)) == pytest.approx(6.0, rel=0.05)


@pytest.mark.filterwarnings("error")
def test_an_effect_that_does_nothing_when_small_has_a_size():
    """numpy's warning of its logarithm stood on the terminal of plans."""
    A, f, T = (part.ravel() for part in np.meshgrid([0.2, 1.0], [1.0, 5.0], [293.15, 313.15]))
    law = law_of_size(open_law("emwm2"), "contact_growth", 6.0, {"A": A, "f": f, "T": T})
    motion = sinusoids(A, f, T)
    beyond = force_of_law(law, motion).force - force_of_law(bare_law(open_law("emwm2")), motion).force
    assert np.sqrt(np.mean(beyond**2)) == pytest.approx(6.0, rel=0.05)


def test_a_plan_keeps_its_hours_and_its_limits():
    limits = parse_limits("A=0.2..1,f=1..6,T=20..20,v=..25")
    with few_effects("memory", "offset", "quadratic_damping", "stiffness_frequency"):
        plan = plan_campaign(open_law("emwm2"), limits, PlanRequest(hours=0.5))
    assert plan.hours <= 0.5
    assert all(2 * np.pi * run.amplitude_mm * run.frequency_Hz <= 25 for run in plan.runs)
    assert len(plan.stages) == 1
    assert plan.stages[-1].newtons == pytest.approx(plan.power.from_newtons)
    with pytest.raises(UsageError, match="no campaign fits into that; the shortest takes"):
        plan_campaign(open_law("emwm2"), limits, PlanRequest(hours=0.01))


def test_where_no_time_was_measured_no_frequency_is_varied():
    file = open_law("emwm2")
    told = {"time_measured": False, "about_mm": 85.0}
    untimed = file.model_copy(update={"data": file.data.model_copy(update=told)})
    with few_effects("relaxation", "offset"):
        plan = plan_campaign(untimed, parse_limits("A=0.3..0.6,f=1..9,v=..0.1,T=20..20"))
    assert len({run.frequency_Hz for run in plan.runs}) == 1 < len({run.amplitude_mm for run in plan.runs})
    assert plan.power.scene.effects == ("offset",)
    assert "relaxation" in plan.power.scene.not_reckoned
    words = " ".join(campaign_plan_words(plan))
    assert "moved about 85 mm, and so do these runs" in words
    assert "at any slow rate" in words and "Hz" not in words and "f=" not in words
    assert b"time_measured = false" in dict(plan_files(plan, "planned", "plan"))["campaign.toml"]


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


@pytest.mark.parametrize(
    ("column", "value", "told"),
    [
        ("first_cycle", "nan", "expected a finite number of 0 or more"),
        ("first_cycle", "-5", "expected a finite number of 0 or more"),
        ("amplitude_mm", "inf", "expected a finite number$"),
    ],
)
def test_a_number_of_a_plan_that_no_campaign_holds_is_told(tmp_path, column, value, told):
    row = {"run": "r1", "amplitude_mm": "0.5", "frequency_Hz": "3", "temperature_C": "20", "first_cycle": "0"}
    row[column] = value
    (tmp_path / "plan.csv").write_text(f"{','.join(row)}\n{','.join(row.values())}\n", encoding="utf-8")
    with pytest.raises(UserError, match=f"row 2, column '{column}': got '{value}'; {told}"):
        read_plan(tmp_path)
