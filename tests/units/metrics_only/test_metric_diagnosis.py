"""Diagnosis on metrics alone: virtual campaigns whose truth is known, and the parts it is made of."""

from dataclasses import replace

import numpy as np
import pytest
from few_effects import few_effects

from pipeclamp_identification.campaign.runs_table import Setup
from pipeclamp_identification.diagnosis.further_test.limits import parse_limits
from pipeclamp_identification.fitting.joint.not_fitted import ONE_AMPLITUDE
from pipeclamp_identification.fitting.least_squares import fit, unfitted
from pipeclamp_identification.loops.energies import loop_energies
from pipeclamp_identification.metrics_only.campaign import MetricCampaign, MetricRun, metric_observations
from pipeclamp_identification.metrics_only.diagnosed import MetricDiagnosed
from pipeclamp_identification.metrics_only.evidence import judge_metrics, metric_scatter_of
from pipeclamp_identification.metrics_only.law import MetricComparison
from pipeclamp_identification.metrics_only.next_test import next_metric_test
from pipeclamp_identification.metrics_only.screen import look
from pipeclamp_identification.metrics_only.verdict import diagnose_metrics
from pipeclamp_identification.metrics_only.weighing import chance_words
from pipeclamp_models.law.law import Law, Structure
from pipeclamp_models.realise.force import force_of_law
from pipeclamp_models.realise.motion import sinusoids

BASE = {
    "k10": 1450.0, "k1_A": -0.22, "k1_T": -0.1, "k30": 250.0, "k3_A": -0.9, "k3_T": -0.1,
    "c0": 80.0, "c_A": 0.05, "c_f": -0.15, "alpha0": 0.45, "alpha_A": 0.2, "alpha_f": 0.01,
}  # fmt: skip
CROSS = [(0.8, f, 20.0) for f in (1.0, 2.0, 3.0, 4.0, 5.0)]
CROSS += [(A, 3.0, 20.0) for A in (0.2, 0.5, 1.0)] + [(0.8, 3.0, T) for T in (100.0, 200.0, 300.0)]


def metrics(effects=(), scatter=0.003, seed=0, conditions=CROSS, **values):
    """Metrics of a law at a cross of conditions, as a paper prints them."""
    A, f, T = np.array(conditions).T
    motion = sinusoids(A, f, T + 273.15)
    law = Law(Structure("power", effects), {**BASE, **values}, 0.0126, 0.002)
    random = np.random.default_rng(seed)
    energies = np.stack(loop_energies(motion, force_of_law(law, motion).force), axis=1)
    energies *= np.exp(scatter * random.standard_normal(energies.shape))
    runs = tuple(
        MetricRun(f"r{row}", Setup(temperature_C=T), A, f, *(float(f"{one:.4f}") for one in pair), (1e-4, 1e-4))
        for row, ((A, f, T), pair) in enumerate(zip(conditions, energies, strict=True))
    )
    return MetricCampaign("virtual", "", "none", runs, (), ())


@pytest.fixture(scope="module")
def quiet():
    """The base law, nothing hidden: law and observations."""
    observations = metric_observations(metrics())
    return judge_metrics((), Structure("power"), {}, observations), observations


def test_at_one_amplitude_nothing_is_fitted_or_named_that_only_a_shape_would_show():
    """A polymer's stiffness over temperature had been followed by a cubic stiffness, and by a gas spring."""
    strip = [(0.8, f, T) for f in (1.0, 3.0, 9.0) for T in (20.0, 60.0, 100.0, 140.0)]
    observations = metric_observations(metrics(conditions=strip))
    law = judge_metrics((), Structure("power"), {}, observations)
    assert {law.result.frozen[name] for name in ("k30", "k3_A", "k3_T")} == {ONE_AMPLITUDE}
    assert law.result.law.values["k30"] == 0.0
    for name in ("gas_spring", "hardening", "end_stop"):
        assert look(law, observations, name).hidden == ONE_AMPLITUDE
    assert not look(law, observations, "damping_temperature").hidden


def test_scatter_alone_is_complete():
    diagnosis = diagnose_metrics(Structure("power"), metrics())
    assert (diagnosis.verdict, diagnosis.effects) == ("complete", ())
    likeliest = diagnosis.candidates[0]
    _, hint, _ = diagnosis.reasons
    assert hint.startswith(f"no effect gains more than scatter does; of the likeliest, {likeliest.name}, scatter alone")
    assert " 100% " not in hint
    assert diagnosis.explained(likeliest) == 0.0  # nothing is missing of which it could explain a share


@pytest.fixture(scope="module")
def named():
    """Metrics of a clamp whose damping follows the temperature, and their diagnosis among effects of several kinds."""
    tests = metrics(("damping_temperature",), c_T1=-0.15, c_T2=0.05, c_T3=0.0)
    with few_effects(
        "damping_temperature", "viscous", "quadratic_damping", "stiffness_frequency", "hardening", "memory",
        "relaxation", "offset", "delay",
    ):  # fmt: skip
        return tests, diagnose_metrics(Structure("power"), tests)


def test_a_missing_effect_is_named_with_its_caution(named):
    tests, diagnosis = named
    assert (diagnosis.verdict, diagnosis.effects) == ("missing", ("damping_temperature",))
    assert diagnosis.tested_once == ("T",)
    answer = MetricDiagnosed(diagnosis, tests, MetricComparison(tests, np.zeros((len(CROSS), 2)), {}), None)
    assert any("rests on one row" in caution for caution in answer.cautions())


def test_a_fit_isnt_held_up_by_what_the_data_doesnt_show(quiet):
    """A small k2 shows in no dW and no W: its step went to its bound, and shortened all others to nothing. So laws were
    said to foretell left-out conditions as well as what they were fitted to."""
    observations = quiet[1].with_scatter(0.01)
    start = BASE | {"k10": 1300.0, "c0": 100.0}
    plain = fit(Structure("power"), observations, start=start)
    beside = fit(Structure("power", ("asymmetry",)), observations, start=start | {"k2": 0.03})
    assert beside.cost == pytest.approx(plain.cost, rel=0.01)
    starts = [unfitted(Structure("power"), observations, start).cost, plain.cost]
    assert starts[0] > 2 * starts[1]


def test_what_was_tried_in_vain_rests_on_no_row(named):
    """It had been warned of an effect without a name: " rests on one row"."""
    tests, diagnosis = named
    found = replace(diagnosis, rests_on=(0,))
    answer = MetricDiagnosed(found, tests, MetricComparison(tests, np.zeros((len(CROSS), 2)), {}), None)
    assert any("damping_temperature rests on one row" in caution for caution in answer.cautions())
    nothing = answer.naming_nothing("it didn't help")
    assert nothing.diagnosis.rests_on == () and not any("warning:  rests" in one for one in nothing.cautions())


def test_a_condition_that_no_test_varies_is_told(named):
    tests, diagnosis = named
    alike = diagnosis.observations.rows(np.flatnonzero(np.array(CROSS)[:, 0] == 0.8))
    told = [
        MetricDiagnosed(one, tests, MetricComparison(tests, np.zeros((len(CROSS), 2)), {}), None).words()
        for one in (diagnosis, replace(diagnosis, observations=alike))
    ]
    line = "all tests are at one amplitude, 0.8 mm: what the law does at others, nothing here shows"
    assert [line in words for words in told] == [False, True]


@pytest.mark.parametrize(("levels", "told"), [((0.0, 4.0), True), ((0.0, 1.0, 2.0, 3.0, 4.0), False)])
def test_what_a_law_does_between_few_levels_is_said_to_be_untested(levels, told):
    law, loops = Structure("power", ("condition:current_A",)), metrics(conditions=CROSS * 2)
    runs = tuple(
        replace(run, setup=replace(run.setup, conditions={"current_A": levels[row % len(levels)]}))
        for row, run in enumerate(loops.runs)
    )
    tests = replace(loops, runs=runs, condition_columns=("current_A",))
    with few_effects("viscous"):
        diagnosis = diagnose_metrics(law, tests)
    assert diagnosis.verdict in ("complete", "unknown"), "the law stays"
    answer = MetricDiagnosed(diagnosis, tests, MetricComparison(tests, np.zeros((len(runs), 2)), {}), None)
    words = [word for word in answer.words() if f"the tests have {len(levels)} levels of current_A" in word]
    assert len(words) == told


@pytest.mark.parametrize("name", ["asymmetry", "offset", "directional_damping"])
def test_what_metrics_dont_show_is_hidden(quiet, name):
    assert "only a recorded loop" in look(quiet[0], quiet[1], name).hidden


@pytest.mark.parametrize(("name", "reason"), [("density", "isn't known"), ("loosening", "doesn't vary")])
def test_what_no_condition_shows_is_hidden(quiet, name, reason):
    assert reason in look(quiet[0], quiet[1], name).hidden


@pytest.mark.parametrize("name", ["damping_temperature", "stiffness_frequency", "quadratic_damping"])
def test_what_metrics_show_is_not_hidden(quiet, name):
    seen = look(quiet[0], quiet[1], name)
    assert seen.hidden == ""
    assert not seen.imitated


def test_the_scatter_lies_between_what_was_expected_and_what_is_left(quiet):
    scatter = metric_scatter_of(*quiet, 0.01)
    assert np.all(scatter.share > 0.002)
    assert np.all(scatter.share < 0.01)
    assert scatter.freedoms.sum() == pytest.approx(8 + quiet[0].freedoms, abs=1.5)


def test_slopes_of_the_metrics_match_differences(quiet):
    law, observations = quiet
    result = law.result
    slopes = observations.residual_slopes(result.law_force, result.places)
    for place, name in enumerate(result.fitted):
        step = 1e-5 * max(abs(result.law.values[name]), 0.1)
        moved = [
            observations.residual(
                force_of_law(
                    Law(result.law.structure, {**result.law.values, name: result.law.values[name] + way * step},
                        result.law.v_r, result.law.y_r), observations.motion,
                )
            )
            for way in (1, -1)
        ]  # fmt: skip
        difference = (moved[0] - moved[1]) / (2 * step)
        assert np.allclose(slopes[place], difference, atol=2e-2 * np.abs(difference).max())


@pytest.fixture(scope="module")
def rivals(named):
    """A diagnosis in which memory counts as a rival of what is hidden."""
    _, diagnosis = named
    memory = judge_metrics(("memory",), Structure("power", ("memory",)), {}, diagnosis.observations)
    laws = (*diagnosis.found.laws, memory)
    return replace(diagnosis, found=replace(diagnosis.found, verdict="ambiguous", laws=laws))


@pytest.mark.parametrize("stated", ["A=0.1..0.9,f=1..4,T=20..300", "A=..1.1,v=..12,T=100..310", "f=..6,F=..3000"])
def test_a_proposed_sine_keeps_the_rigs_limits(rivals, stated):
    limits = parse_limits(stated)
    proposal = next_metric_test(rivals, limits)
    drive = proposal.plan.signal()
    assert np.max(np.abs(drive.displacement_mm)) <= limits.amplitude[1] * (1 + 1e-6)
    assert np.max(np.abs(np.gradient(drive.displacement_mm, drive.time_s))) <= limits.velocity * (1 + 1e-6)
    assert limits.frequency[0] <= proposal.frequency_Hz <= limits.frequency[1]
    assert limits.temperature[0] <= proposal.temperature_C <= limits.temperature[1]


def test_no_sine_within_the_limits_is_said(rivals):
    told = [next_metric_test(rivals, parse_limits(stated)).words for stated in ("A=2..3,f=5..6,v=..10", "F=..5")]
    assert all("no sine keeps all of" in words for words in told)
    assert "it would take F=.." in told[1]


@pytest.mark.parametrize(
    ("chance", "said"),
    [(1.0, "100%"), (0.034, "3.4%"), (2e-5, "0.002%"), (9e-6, "less than 0.001%"), (0.0, "less than 0.001%")],
)
def test_a_chance_has_no_digits_that_mean_nothing(chance, said):
    assert chance_words(chance) == said
