"""A law that fits all levels tested and goes wrong between them isn't complete; one whose level only it tells is."""

from dataclasses import replace

import numpy as np
import pytest
from bump import BUMP
from few_effects import few_effects

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.diagnosis import elsewhere
from pipeclamp_identification.diagnosis.diagnosed import RecordDiagnosed
from pipeclamp_identification.diagnosis.foretold import takes_part
from pipeclamp_identification.diagnosis.problem import judge, prepare
from pipeclamp_identification.diagnosis.thresholds import FORM_NOISE_SHARE
from pipeclamp_identification.diagnosis.verdict import diagnose
from pipeclamp_identification.diagnosis.weighing import between_levels
from pipeclamp_identification.diagnosis.weighing.between_levels import LeftOutLevel, rests_on, worst_level
from pipeclamp_identification.fitting.least_squares import fit
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.law.declaration_files import read_declaration
from pipeclamp_models.law.law import Law, Structure
from pipeclamp_models.realise.force import force_of_law

BASE = {
    "k10": 1450.0, "k1_A": -0.22, "k1_T": -0.1, "k30": 250.0, "k3_A": -0.9, "k3_T": -0.1,
    "c0": 80.0, "c_A": 0.05, "c_f": -0.15, "alpha0": 0.45, "alpha_A": 0.2, "alpha_f": 0.01,
}  # fmt: skip
PLAN = Plan(
    amplitudes=(0.3, 0.6, 1.0), frequencies=(1.0, 2.0, 4.0, 8.0), temperatures=(20.0, 150.0, 300.0), rate=500.0, seed=3
)
SHARP = {"k_i": 40.0, "f_i": 2.0, "zeta_i": 0.05, "b_i": 0.0}
"""A mass inside that rings at one frequency of the plan, and hardly shows at the others."""
WITH_MASS = Structure("power", ("inner_mass",))


@pytest.fixture
def tested(tmp_path):
    """Give a virtual campaign of the base law with effects."""

    def made(effects, values, plan=PLAN, declared=(), others=()):
        law = Law(Structure("power", effects, declared=declared), {**BASE, **values}, 0.0126, 0.002)
        runs = [*virtual_runs(law, plan)]
        for changed, further in others:
            runs += virtual_runs(replace(law, values={**law.values, **changed}), further)
        write_campaign(tmp_path / "campaign", runs, name="virtual", notes="")
        return read_campaign(tmp_path / "campaign")

    return made


@pytest.fixture
def bump(tmp_path):
    """Give what nothing in the catalogue is, and an inner mass imitates at the frequencies tested."""
    (tmp_path / "bump.toml").write_text(BUMP)
    return read_declaration(tmp_path / "bump.toml")


def judged(campaign, structure, start=None):
    problem, first = prepare(structure, loops_of(campaign), start)
    return judge((), structure, [first.law.values], problem), problem


def test_a_law_that_goes_wrong_between_the_levels_is_not_complete(tested, bump):
    found = diagnose(WITH_MASS, tested(("bump",), {"s_b": 0.02}, declared=(bump,)))
    assert found.law.lack.share < 0.1, "at the levels tested nothing is left"
    assert found.verdict == "unknown"
    assert "f = 2 Hz" in found.reasons[0]
    assert "test at values of f in between" in found.reasons[0]
    headline = RecordDiagnosed(found, comparison=None).headline()
    assert "can't be called complete" in headline, "that something is missing would be more than these tests show"


def test_no_part_is_made_up_between_the_levels(tested, bump):
    """An inner mass that takes all at one frequency would have to take some of it when fitted to the others."""
    campaign = tested(("bump",), {"s_b": 0.1}, declared=(bump,))
    law, problem = judged(campaign, Structure("power"))
    with_mass, _ = judged(campaign, WITH_MASS)
    assert takes_part(with_mass, law, problem), "by groups of one amplitude and one frequency it takes it"
    assert rests_on(with_mass, law, problem).label == "2 Hz"
    with few_effects("inner_mass", "stiffness_frequency", "inertia", "relaxation", "oil_damper"):
        found = diagnose(Structure("power"), campaign)
    assert (found.verdict, found.effects) == ("unknown", ())
    assert "test at values of f in between" in found.reasons[0]


def test_a_mass_that_rings_at_one_level_may_take_what_is_there(tested):
    """The other levels don't contradict it, though they don't show it."""
    campaign = tested(("inner_mass",), SHARP)
    law, problem = judged(campaign, Structure("power"))
    with_mass, _ = judged(campaign, WITH_MASS, {**BASE, **SHARP})
    assert rests_on(with_mass, law, problem) is None


def test_what_is_taken_at_the_ends_rests_on_no_level_between(tested):
    campaign = tested(("end_stop",), {"k_e": 3000.0, "y_e": 0.7})
    law, problem = judged(campaign, Structure("power"))
    with_stop, _ = judged(campaign, Structure("power", ("end_stop",)), {**BASE, "k_e": 3000.0, "y_e": 0.7})
    assert rests_on(with_stop, law, problem) is None


def test_groups_that_differ_hide_nothing_of_it(tested, bump):
    plan = replace(PLAN, specimens=3, specimen_scatter=0.03)
    law, problem = judged(tested(("bump",), {"s_b": 0.02}, plan, (bump,)), WITH_MASS)
    assert problem.factors is not None
    worst = worst_level(law, problem)
    assert (worst.condition, worst.level) == ("f", "2 Hz")
    assert worst.share > FORM_NOISE_SHARE


def test_temperatures_between_others_are_asked_too(tested, tmp_path):
    text = BUMP.replace("near one frequency", "near one temperature").replace("f - 2.7) / 0.7", "T - 423.15) / 40")
    (tmp_path / "bump.toml").write_text(text)
    declared = (read_declaration(tmp_path / "bump.toml"),)
    law, problem = judged(tested(("bump",), {"s_b": 0.05}, declared=declared), Structure("power"))
    worst = worst_level(law, problem)
    assert (worst.condition, worst.level) == ("T", "150 °C")
    assert worst.share > FORM_NOISE_SHARE


def test_what_only_one_level_tells_is_no_fault_of_the_law(tested):
    """Without the level at which a mass rings a fit can't tell how strongly; the others don't contradict the law."""
    plan = replace(PLAN, seed=5)  # with others' noise the plain refit happens to be nearer
    law, problem = judged(tested(("inner_mass",), SHARP, plan), WITH_MASS, {**BASE, **SHARP})
    level = np.flatnonzero(np.abs(problem.loops.frequency_Hz - 2.0) < 0.1)
    rest = np.setdiff1d(np.arange(len(problem.loops.run)), level)
    refitted = fit(WITH_MASS, problem.observations.rows(rest), start=law.result.law.values)
    shown = problem.harmonics.rows(level)
    laws = refitted.law, law.result.law
    without, having = (np.mean(shown.mean_squares(force_of_law(one, shown.motion))) for one in laws)
    noise = np.mean(problem.loops.noise_rms_N[level] ** 2)
    assert np.sqrt((without - having) / noise) > FORM_NOISE_SHARE, "a plain refit would count it"
    assert worst_level(law, problem).share < 0.1


def test_what_chance_makes_of_a_level_is_no_disagreement(tested, monkeypatch):
    """Without the level next to it nothing shows where a growth begins: the hottest tells beta times the rest.

    A law of all runs is as good for the others, but for what noise made of the level, here of its damping; between it
    and another that the others allow, on the straight way, lie laws that they contradict.
    """
    growth = {"beta": 1.3e-3, "T_c": 474.0}
    plan = replace(PLAN, frequencies=(1.0, 4.0), temperatures=(20.0, 100.0, 300.0))
    damped = {"c0": 80.12}, replace(plan, temperatures=(200.0,))
    campaign = tested(("contact_growth",), growth, plan, others=[damped])
    law, problem = judged(campaign, Structure("power", ("contact_growth",)), {**BASE, **growth})
    values, hottest, earlier = law.result.law.values, 573.15, 410.0
    beta = values["beta"] * (hottest - values["T_c"]) / (hottest - earlier)

    def begun_elsewhere(structure, observations, *, start, tolerance):
        return fit(structure, observations, start={**start, "beta": beta, "T_c": earlier}, tolerance=tolerance)

    monkeypatch.setattr(between_levels, "fit", begun_elsewhere)
    worst = worst_level(law, problem)
    assert worst.share < 0.1, worst


def test_levels_at_the_ends_are_not_between(tested):
    plan = replace(PLAN, amplitudes=(0.3, 1.0), frequencies=(1.0, 4.0), temperatures=(20.0, 300.0))
    law, problem = judged(tested((), {}, plan), Structure("power"))
    assert worst_level(law, problem) is None


@pytest.mark.parametrize(("share", "verdict"), [(0.6, "complete"), (0.9, "unknown")])
def test_what_passes_for_form_may_be_wrong_between_levels_too(share, verdict, tested, monkeypatch):
    monkeypatch.setattr(elsewhere, "worst_level", lambda law, problem: LeftOutLevel("A", "0.6 mm", 3 * share, share))
    found = diagnose(Structure("power"), tested((), {}))
    assert found.verdict == verdict
    assert ("A = 0.6 mm" in found.reasons[0]) == (verdict == "unknown")
