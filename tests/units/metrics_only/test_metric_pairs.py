"""Effects that come together, fits that leave poor valleys, and parts, on virtual metrics of a rubber over f and T."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from few_effects import few_effects

from pipeclamp_identification.campaign.runs_table import Setup
from pipeclamp_identification.fitting.joint.not_fitted import STATED
from pipeclamp_identification.fitting.least_squares import fit
from pipeclamp_identification.loops.energies import loop_energies
from pipeclamp_identification.metrics_only.campaign import MetricCampaign, MetricRun, metric_observations
from pipeclamp_identification.metrics_only.diagnosed import MetricDiagnosed
from pipeclamp_identification.metrics_only.diagnosis_answer import metric_diagnosis_answer
from pipeclamp_identification.metrics_only.law import MetricComparison, identify_metrics, metric_law_file
from pipeclamp_identification.metrics_only.observations import as_seen_at_few
from pipeclamp_identification.metrics_only.valleys import fit_to_metrics
from pipeclamp_identification.metrics_only.verdict import diagnose_metrics
from pipeclamp_identification.workflow.auto import add_until_settled
from pipeclamp_identification.workflow.next_command import next_command
from pipeclamp_identification.workflow.on_metrics import MetricTests
from pipeclamp_models.law.file import Provenance
from pipeclamp_models.law.law import Law, Structure
from pipeclamp_models.realise.force import force_of_law
from pipeclamp_models.realise.motion import sinusoids

SOFT = {
    "k10": 40.0, "k1_A": 0.0, "k1_T": 0.0, "k30": 0.0, "k3_A": 0.0, "k3_T": 0.0,
    "c0": 2.0, "c_A": 0.0, "c_f": 0.0, "alpha0": 0.5, "alpha_A": 0.0, "alpha_f": 0.0,
}  # fmt: skip
RUBBER = {"k_m": 800.0, "tau": 0.1, "r_T1": -10.0, "w_T": 120.0, "T_r": 293.15}
SPREAD = {"k_r": 800.0, "tau_r": 0.02, "beta_r": 0.6, "r_T1": -12.0, "w_T": 150.0, "T_r": 293.15}
FREQUENCIES, TEMPERATURES = (0.1, 1.0, 10.0), (-20.0, 0.0, 20.0, 40.0)
GRID = [(1.0, f, T) for f, T in itertools.product(FREQUENCIES, TEMPERATURES)] + [(0.5, 1.0, 20.0), (0.5, 10.0, 0.0)]
TOGETHER = ("relaxation", "relaxation_temperature")
RIVALS = (*TOGETHER, "damping_temperature", "stiffness_frequency", "unilateral_contact", "delay", "hardening")
"""What takes most by itself here, of several kinds."""


def metrics(effects, values, scatter=0.003, warmer=0.0):
    """Metrics of a soft law with relaxation that each temperature moves elsewhere, tested so much warmer."""
    A, f, T = np.array(GRID).T + np.array([[0.0], [0.0], [warmer]])
    motion = sinusoids(A, f, T + 273.15)
    force = force_of_law(Law(Structure("power", effects), {**SOFT, **values}, 0.0126, 0.002), motion).force
    energies = np.stack(loop_energies(motion, force), axis=1)
    energies *= np.exp(scatter * np.random.default_rng(0).standard_normal(energies.shape))
    runs = tuple(
        MetricRun(f"r{row}", Setup(temperature_C=T), A, f, *(float(f"{one:.4g}") for one in pair), (1e-4, 1e-4))
        for row, ((A, f, T), pair) in enumerate(zip(zip(A, f, T, strict=True), energies, strict=True))
    )
    return MetricCampaign("virtual", "", "none", runs, (), ())


@pytest.fixture(scope="module")
def climbed():
    """A ladder on a rubber's metrics: where it ended, and its diagnoses."""
    tests, found = metrics(TOGETHER, RUBBER), []
    file = metric_law_file(identify_metrics(tests), tests, name="law", provenance=Provenance(""))
    with few_effects(*RIVALS, "relaxation_spread"):
        end = add_until_settled(file, MetricTests(tests), command="", seen=lambda one, _: found.append(one))
    return end, found


def test_what_relaxes_no_more_at_20_degrees_is_described_from_the_coldest_test():
    """A polymer that is glass up to 30 degC, tested from 100 degC on."""
    tests = metrics(TOGETHER, {"k_m": 800.0, "tau": 0.3, "r_T1": -15.0, "w_T": 70.0, "T_r": 373.15}, warmer=120.0)
    found = identify_metrics(tests, Structure("power", TOGETHER))
    values = found.law.values
    assert (values["r_T1"], values["w_T"]) == pytest.approx((-15.0, 70.0), rel=0.1)
    assert values["T_r"] == pytest.approx(373.15)
    assert found.frozen["T_r"] == STATED
    warm = replace(tests, runs=tuple(run for run in tests.runs if run.setup.temperature_C > 100.0))
    again = fit(Structure("power", TOGETHER), metric_observations(warm), start=values)
    assert again.law.values["T_r"] == values["T_r"], "what is fitted to some of the tests is stated there as well"


def test_an_effect_is_named_with_the_one_that_scales_only_it(climbed):
    found = climbed[1][0]
    assert (found.verdict, found.kind, found.effects, found.together) == ("missing", "cause", TOGETHER[:1], TOGETHER)
    assert found.headline() == "Missing: relaxation with relaxation_temperature."
    assert "relaxation_temperature scales what only relaxation brings, so they come together" in found.words()
    line = next_command(found, "law.json", "tests")
    assert line == "pipeclamp add law.json relaxation,relaxation_temperature tests -o law_2.json"
    answer = metric_diagnosis_answer(found, (), line)
    assert answer.together == TOGETHER
    pair = answer.pairs[0]
    assert pair.effect == "relaxation + relaxation_temperature"
    assert set(pair.parameters) == set(RUBBER)
    assert pair.heldout_nrmse < 0.1 < answer.heldout_nrmse.law
    assert not set(TOGETHER) & set(answer.not_visible), "what was found isn't told as neither found nor refuted"
    alone = [one.heldout_nrmse for one in answer.candidates]
    assert all(map(math.isfinite, alone)), "also of laws that make energy where conditions are left out"
    assert min(alone) > 10 * pair.heldout_nrmse, "by itself no effect comes near"


def test_a_ladder_climbs_by_both(climbed):
    end, found = climbed
    assert end.file.effects == TOGETHER
    assert [str(rung.change.step) for rung in end.ladder] == ["+ relaxation", "+ relaxation_temperature"]
    assert end.heldout < 0.1
    assert found[-1].verdict == "complete"
    values = {name: end.file.coefficients[name].value for name in RUBBER}
    assert values == pytest.approx(RUBBER, rel=0.1)


def test_a_part_is_named_where_much_remains():
    """Every other condition differs by a fifth, as no law does: relaxation takes nearly all, and is no cause."""
    clean = metrics(TOGETHER, RUBBER)

    def differing(run: MetricRun) -> MetricRun:
        odd = (-1) ** (FREQUENCIES.index(run.frequency_Hz) + TEMPERATURES.index(run.setup.temperature_C))
        dissipated, elastic = (math.exp(share * odd) for share in (0.15, -0.1))
        return replace(
            run,
            dissipated_energy_J=run.dissipated_energy_J * dissipated,
            max_elastic_energy_J=run.max_elastic_energy_J * elastic,
        )

    tests = replace(clean, runs=tuple(map(differing, clean.runs)))
    with few_effects(*RIVALS):
        diagnosis = diagnose_metrics(Structure("power"), tests)
    found = MetricDiagnosed(diagnosis, tests, MetricComparison(tests, np.zeros((len(GRID), 2)), {}), None)
    assert found.verdict in ("missing", "ambiguous")
    assert found.kind == "part"
    assert all(law.effects[1:] == TOGETHER[1:] for law in diagnosis.found.laws)
    assert diagnosis.explained(diagnosis.named) > 0.8
    assert "leave more than scatter" in " ".join(found.words())


def test_a_fit_leaves_a_poor_valley():
    """From the law as it is the logs alone lead to errors of thousands of times the scatter."""
    observations = metric_observations(metrics(("relaxation_spread", TOGETHER[1]), SPREAD), samples=64)
    law = fit(Structure("power"), observations, tolerance=1e-4).law.values
    larger = Structure("power", ("relaxation_spread", TOGETHER[1]))
    assert fit(larger, observations, start=law, tolerance=1e-4).cost > 1e3
    assert fit_to_metrics(larger, observations, law, 1e-4).cost < 5.0


def test_slopes_of_shares_match_differences():
    shares = metric_observations(metrics(TOGETHER, RUBBER)).as_shares()
    result = fit(Structure("power", TOGETHER), shares.rows(np.arange(len(GRID))), start={**SOFT, **RUBBER})
    assert shares.are_linear
    slopes = shares.residual_slopes(result.law_force, result.places)
    for place, name in enumerate(result.fitted):
        step = 1e-5 * max(abs(result.law.values[name]), 0.1)
        ways = [{**result.law.values, name: result.law.values[name] + way * step} for way in (1, -1)]
        laws = (Law(result.law.structure, values, result.law.v_r, result.law.y_r) for values in ways)
        up, down = (shares.residual(force_of_law(law, shares.motion)) for law in laws)
        difference = (up - down) / (2 * step)
        assert np.allclose(slopes[place], difference, atol=2e-2 * np.abs(difference).max() + 1e-9)


def test_a_law_without_energy_has_no_slopes_beyond_all_numbers():
    observations = metric_observations(metrics(TOGETHER, RUBBER))
    nothing = {**SOFT, "k10": 0.0, "c0": 0.0}
    result = fit(Structure("power", frozen=tuple(nothing.items())), observations.as_shares())
    assert not np.isinf(observations.residual_slopes(result.law_force, np.arange(3))).any()


def test_few_points_of_the_cycle_show_what_many_do_as_a_law_has_it():
    many, few = (metric_observations(metrics(("memory",), {"k_s": 60.0, "z_s": 0.3}), samples=n) for n in (256, 32))
    law = Law(Structure("power", ("memory",)), {**SOFT, "k_s": 60.0, "z_s": 0.3}, 0.0126, 0.002)
    plain = few.logs(force_of_law(law, few.motion).force) - many.logs(force_of_law(law, many.motion).force)
    assert np.max(np.abs(plain)) > 1e-4, "else nothing is shown"
    seen = as_seen_at_few(few, many, law)
    assert seen.logs(force_of_law(law, few.motion).force) == pytest.approx(
        many.logs(force_of_law(law, many.motion).force), abs=1e-12
    )
