"""Diagnosis on virtual campaigns whose truth is known; the truth table in build_scripts does this at large."""

import json
from dataclasses import replace

import numpy as np
import pytest
from bump import BUMP
from few_effects import few_effects

from pipeclamp.pages.diagnosis import promised
from pipeclamp.pages.page import render, specification_of
from pipeclamp.pages.sections import diagnosis_page
from pipeclamp.show.diagnosis_views import diagnosis_view
from pipeclamp.studio.bench import with_candidate
from pipeclamp.studio.diagnosis_shown import shown_diagnosis
from pipeclamp.studio.overview import waterfall_of
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.diagnosis import problem
from pipeclamp_identification.diagnosis.diagnosed import diagnosed
from pipeclamp_identification.diagnosis.further_test.limits import Limits, parse_limits
from pipeclamp_identification.diagnosis.further_test.next_test import next_test
from pipeclamp_identification.diagnosis.problem import judge, prepare, roughly
from pipeclamp_identification.diagnosis.revision import (
    ask_again,
    better_structures,
    simpler_structure,
    without_spare_powers,
)
from pipeclamp_identification.diagnosis.screen import screened
from pipeclamp_identification.diagnosis.verdict import diagnose
from pipeclamp_identification.fitting.identify import identify, law_file
from pipeclamp_identification.fitting.joint.points import starting_points
from pipeclamp_identification.fitting.observations import SAMPLES_PER_CYCLE, points_enough
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_identification.workflow import on_records
from pipeclamp_identification.workflow.auto import add_until_settled
from pipeclamp_identification.workflow.change import add_effect, exchange, remove_effect, with_powers_back
from pipeclamp_identification.workflow.on_records import RecordTests
from pipeclamp_models.base.errors import UsageError, UserError
from pipeclamp_models.base.processes import ALONE
from pipeclamp_models.base.progress import silent
from pipeclamp_models.law.declaration_files import read_declaration
from pipeclamp_models.law.file import InVain, LastDiagnosis, Provenance, law_text
from pipeclamp_models.law.law import Law, Structure, with_effect

BASE = {
    "k10": 1450.0, "k1_A": -0.22, "k1_T": -0.1, "k30": 250.0, "k3_A": -0.9, "k3_T": -0.1,
    "c0": 80.0, "c_A": 0.05, "c_f": -0.15, "alpha0": 0.45, "alpha_A": 0.2, "alpha_f": 0.01,
}  # fmt: skip
PLAN = Plan(rate=500.0, seed=3)
TWO_TEMPERATURES = replace(PLAN, temperatures=(20.0, 200.0))
"""Enough for what doesn't follow the temperature."""
LOPSIDED = ("asymmetry", "offset", "gas_spring", "unilateral_contact", "directional_damping", "gap", "memory")
"""What acts like a force that is stiffer on one side, and something else."""
SLIPPING = (
    "memory", "slip_temperature", "slip_speed", "damping_temperature", "bouc_wen", "play", "coulomb", "relaxation",
)  # fmt: skip
"""What acts like an element that slips, and what scales it."""
OVER_FREQUENCY = ("stiffness_frequency", "inertia", "inner_mass", "relaxation", "oil_damper", "delay")
"""What makes stiffness and damping follow the frequency."""
ANSWER_FIELDS = {"verdict", "effects", "candidates", "nrmse", "next_test"}


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    """Give a virtual campaign of the base law with effects."""

    def made(effects=(), plan=PLAN, declared=(), **values):
        folder = tmp_path_factory.mktemp("diagnose") / "campaign"
        law = Law(Structure("power", effects, declared=declared), {**BASE, **values}, 0.0126, 0.002)
        write_campaign(folder, virtual_runs(law, plan), name="virtual", notes="")
        return read_campaign(folder)

    return made


@pytest.fixture(scope="module")
def lopsided(campaign):
    """Tests of a clamp that is stiffer on one side, and the base law of them."""
    tests = campaign(("asymmetry",), TWO_TEMPERATURES, k2=20.0)
    return tests, law_file(identify(tests), tests, name="law", provenance=Provenance("test"))


def test_scatter_alone_is_complete(campaign):
    diagnosis = diagnose(Structure("power"), campaign())
    assert (diagnosis.verdict, diagnosis.effects) == ("complete", ())
    assert " 0.00%" not in diagnosis.reasons[0]


def test_too_few_runs_are_refused_with_what_makes_more(campaign):
    tests = campaign()
    few = replace(tests, runs=tests.runs[:3])
    with pytest.raises(UserError, match=r"3 runs can't .* at least 4: `pipeclamp plan` .*--columns segment="):
        diagnose(Structure("power"), few)


def test_a_condition_that_no_test_varies_is_told(campaign):
    tests = campaign(plan=replace(PLAN, amplitudes=(0.5,), temperatures=(20.0, 100.0)))
    found = diagnosed(law_file(identify(tests), tests, name="law", provenance=Provenance("test")), tests)
    told = "all tests are at one amplitude, 0.5 mm: what the law does at others, nothing here shows"
    assert (found.untested(), found.words()[-1]) == ((told,), told)


def test_what_passes_for_form_is_never_told_as_nothing(campaign):
    """A complete law that leaves something which follows the conditions says so in all places."""
    tests = campaign(("viscous",), TWO_TEMPERATURES, c1=2.0)
    file = law_file(identify(tests), tests, name="law", provenance=Provenance("test"))
    with few_effects("viscous", "quadratic_damping", "damping_temperature", "relaxation", "memory"):
        found = diagnosed(file, tests)
    assert not found.diagnosis.is_adequate(found.diagnosis.law)
    weighed = replace(
        found.diagnosis.found, verdict="complete", effects=(), kind=None, named=None, reasons=("it follows them",)
    )
    passing = replace(found, diagnosis=replace(found.diagnosis, found=weighed))
    page = render("", "", diagnosis_page(file, passing, "next"))
    assert f"{found.diagnosis.law.lack.rms:.3g} N that follow the conditions" in page
    assert "Complete: what is left is scatter" not in page
    assert "Nothing that follows the conditions" not in page


def test_a_page_of_what_cannot_be_named_says_nowhere_that_nothing_is_left(campaign):
    """As of a law that leaves mean forces open: they don't follow the conditions, and aren't nothing."""
    tests = campaign()
    file = law_file(identify(tests), tests, name="law", provenance=Provenance("test"))
    found = diagnosed(file, tests)
    assert not found.left_over()
    unnamed = replace(found.diagnosis.found, verdict="unknown", reasons=("it leaves mean forces open",))
    page = render(
        "", "", diagnosis_page(file, replace(found, diagnosis=replace(found.diagnosis, found=unnamed)), "next")
    )
    assert "It leaves mean forces open" in page
    assert "Nothing that follows the conditions" not in page


def test_a_law_that_ages_is_prepared_at_as_many_points_as_its_tests(campaign):
    """Noisy records of few samples: each is seen through its own sampling, at few points of the cycle."""
    plan = Plan((0.3, 0.8), (1.0, 3.0), (20.0,), rate=100.0, cycles=3, force_noise=10.0, seed=5)
    loops = loops_of(campaign(plan=plan))
    assert points_enough(loops) < SAMPLES_PER_CYCLE
    structure = Structure("power", ("loosening",))
    problem, fitted = prepare(structure, loops)
    law = judge((), structure, [fitted.law.values], problem)
    assert len(law.fitted.residual) == len(problem.loops.run) == 3 * len(loops.run)


@pytest.mark.parametrize(
    ("effect", "plan", "values"),
    [
        ("contact_growth", PLAN, {"beta": 2e-4, "T_c": 450.0}),
        ("offset", TWO_TEMPERATURES, {"F_o": 5.0}),
        ("relaxation", TWO_TEMPERATURES, {"k_m": 100.0, "tau": 0.05}),
        ("end_stop", TWO_TEMPERATURES, {"k_e": 150.0, "y_e": 0.75}),
    ],
)
def test_a_missing_effect_is_named(campaign, effect, plan, values):
    _is_named(diagnose(Structure("power"), campaign((effect,), plan, **values)), effect)


def test_friction_that_fades_within_records_is_named(campaign):
    """Every test begins with a fresh specimen: what its cycles have in common shows that the damping falls."""
    with few_effects("fade", "loosening", "damping_temperature", "slip_temperature", "viscous", "contact_growth"):
        found = diagnose(Structure("power"), campaign(("fade",), d_N=-0.2, N_d=3.0))
    assert (found.verdict, found.effects, found.kind) == ("missing", ("fade",), "cause")
    assert found.candidates[0].result.law.values["d_N"] == pytest.approx(-0.2, rel=0.1)


def test_several_elements_that_slip_are_named_as_many(campaign):
    tests = campaign(("memory:2",), TWO_TEMPERATURES, k_s1=650.0, z_s1=68.0, k_s2=650.0, z_s2=218.0)
    with few_effects(*SLIPPING):
        _is_named(diagnose(Structure("power"), tests), "memory:2")


def _is_named(diagnosis, effect):
    assert (diagnosis.verdict, diagnosis.effects) == ("missing", (effect,))
    named = diagnosis.found.named
    assert named.effects == diagnosis.effects
    assert named.squares < diagnosis.law.squares
    assert named.heldout_nrmse < 1.05 * diagnosis.problem.loops.noise_nrmse


def test_a_weak_effect_with_a_shape_of_its_own_is_found_from_starts_of_any_size(campaign):
    """Its stated starts are some hundred times as large; rough fits from them came to 0.07 of the cost without it."""
    oil = {"k_oil": 600.0, "F_oil": 20.0, "v_oil": 15.0, "a_oil": 0.6, "p_oil": 0.24}
    tests = campaign(("oil_damper",), plan=Plan((0.3, 0.5, 0.8), (1.0, 3.0, 6.0), (20.0,), force_noise=0.3), **oil)
    problem, fitted = prepare(Structure("power"), loops_of(tests))
    law = judge((), Structure("power"), [fitted.law.values], problem)
    (promise,) = screened(Structure("power"), problem, law, ALONE, ["oil_damper"])
    found = [
        roughly(with_effect(Structure("power"), "oil_damper"), [start.values], problem) for start in promise.starts
    ]
    assert max(each.cost for each in found) < law.result.cost
    assert min(each.cost for each in found) < 0.02 * law.result.cost


def test_what_scales_an_effect_of_the_law_is_tried_with_that_begun_anew(campaign):
    """Fitted to warm and cold tests alike, relaxation times come to a valley of their own."""
    arms = {"k_m": 400.0, "tau": 0.05, "r_T1": -4.0, "w_T": 150.0, "T_r": 293.15}
    tests = campaign(("relaxation", "relaxation_temperature"), **arms)
    structure = Structure("power", ("relaxation",))
    problem, fitted = prepare(structure, loops_of(tests))
    law = judge((), structure, [fitted.law.values], problem)
    (promise,) = screened(structure, problem, law, ALONE, ["relaxation_temperature"])
    times = {start.values["tau"] for start in promise.starts}
    assert law.result.law.values["tau"] in times
    begun_anew = starting_points(with_effect(Structure("power"), "relaxation"), problem.observations, {})
    assert {start["tau"] for start in begun_anew} < times, "and times that only the hottest tests would show"
    (promise,) = screened(structure, problem, law, ALONE, ["damping_temperature"])
    assert {start.values["tau"] for start in promise.starts} == {law.result.law.values["tau"]}


def test_what_follows_a_condition_that_no_test_varies_promises_nothing(campaign):
    """A friction wedge at one temperature: the law's own fit went on, and `slip_temperature` seemed to take 6 %."""
    tests = campaign(("memory",), replace(PLAN, temperatures=(20.0,)), k_s=900.0, z_s=120.0)
    structure = Structure("power", ("memory",))
    problem, fitted = prepare(structure, loops_of(tests))
    law = judge((), structure, [fitted.law.values], problem)
    short_of_its_end = replace(law, result=replace(law.result, cost=1.2 * law.result.cost))
    ids = ["slip_temperature", "damping_temperature", "viscous"]
    gains = {one.name: one.gain for one in screened(structure, problem, short_of_its_end, ALONE, ids)}
    assert gains.pop("viscous") > 0
    assert gains == {"slip_temperature": 0.0, "damping_temperature": 0.0}


def test_two_that_help_only_together_are_a_part_and_are_added_together(campaign, tmp_path):
    """Over frequency it rises and falls as nothing in the catalogue: two fit it against each other, neither alone."""
    (tmp_path / "bump.toml").write_text(BUMP)
    tests = campaign(("bump",), TWO_TEMPERATURES, declared=(read_declaration(tmp_path / "bump.toml"),), s_b=0.01)
    file = law_file(identify(tests), tests, name="law", provenance=Provenance("test"))
    seen = []
    with few_effects(*OVER_FREQUENCY):
        settled = add_until_settled(file, RecordTests(tests), command="test", seen=lambda one, _: seen.append(one))
    found = seen[0]
    assert (found.verdict, found.kind, found.effects) == ("missing", "part", found.together[:1])
    assert f"Part of what is missing: {' with '.join(found.together)}." == found.headline()
    on_page = specification_of(diagnosis_page(file, found, "")[0].figures[0])["data"]
    in_studio = json.loads(waterfall_of(file, shown_diagnosis(found, file)).specification)["data"]
    assert in_studio == on_page, "the studio promises what the page does"
    told, both = shown_diagnosis(found, file), " + ".join(found.together)
    assert not any("Next: " in line for line in told.lines), "the studio's buttons have commands of their own"
    assert [rung.label for rung in told.promised] == [f"+ {both}"], "neither is promised anything alone"
    pair = replace(found.diagnosis.law, effects=("bouc_wen", "slip_speed"))
    idle = replace(found.diagnosis, found=replace(found.diagnosis.found, pair=pair))
    assert all("slip_speed" not in rung.label for rung in promised(idle)), "two that do nothing are no step"
    nothing = found.naming_nothing("tried in vain").diagnosis
    assert [rung.label for rung in promised(nothing)] == ["law as it is"], "what isn't named promises nothing"
    assert told.offered == (",".join(found.together),)
    (candidate,) = (each for each in told.candidates if each.name in told.offered)
    assert candidate.heldout_nrmse == told.promised[0].heldout_nrmse
    assert with_candidate(file, candidate.effects, candidate.values).structure.effects[-2:] == found.together
    assert told.meant(candidate.name) == "part"
    first, second = settled.ladder
    added = [(str(rung.change.step), rung.kind) for rung in (first, second)]
    assert added == [(f"+ {name}", "part") for name in found.together]
    assert second.change.heldout.after < 0.7 * first.change.heldout.before
    assert f"{found.together[0]} needs it beside it" in second.words
    # by itself the first may have done harm
    assert [", with the next one)" in rung.said() for rung in (first, second)] == [True, False]


def test_what_no_rig_scatters_is_not_called_complete(campaign):
    """Four runs are followed by any trend: its size tells that it is physics."""
    four = replace(PLAN, amplitudes=(0.3, 0.9), frequencies=(1.0, 4.0), temperatures=(20.0,))
    diagnosis = diagnose(Structure("power"), campaign(("stiffness_frequency",), plan=four, k_f=-0.04))
    assert diagnosis.verdict in ("missing", "ambiguous")
    assert "stiffness_frequency" in diagnosis.effects


def test_what_nobody_stated_is_no_effect(campaign):
    """Temperatures that runs.csv doesn't state, the slow runs colder: what follows f was called the cause."""
    plan = replace(PLAN, amplitudes=(0.3, 0.6, 1.0), frequencies=(1.0, 3.0, 5.0), temperatures=(20.0, 150.0, 300.0))
    stated = campaign(plan=plan, k1_T=-0.2)
    runs = [
        replace(run, setup=replace(run.setup, temperature_C=None))
        for run in stated.runs
        if not (run.frequency_Hz < 2.0 and run.setup.temperature_C > 250.0)
        and not (run.frequency_Hz > 4.0 and run.setup.temperature_C < 50.0)
    ]
    diagnosis = diagnose(Structure("power"), replace(stated, runs=tuple(runs)))
    assert (diagnosis.verdict, diagnosis.effects) == ("unknown", ())
    assert "21 runs are at the same stated conditions" in diagnosis.reasons[0]
    assert "temperature" in diagnosis.reasons[0]


def test_what_is_locked_to_time_is_no_scatter_whoever_asks(campaign):
    """One place decides: the verdict of `diagnose` is the command's, and the sentence says at which frequency."""
    tests = campaign()
    hum = {run.name: 6.0 * np.sin(2 * np.pi * 37.3 * run.record.time_s) for run in tests.runs}
    noisy = replace(
        tests,
        runs=tuple(
            replace(run, record=replace(run.record, force_N=run.record.force_N + hum[run.name])) for run in tests.runs
        ),
    )
    assert diagnose(Structure("power"), noisy).verdict == "unknown"
    file = law_file(identify(noisy), noisy, name="law", provenance=Provenance("test"))
    answer = diagnosed(file, noisy)
    assert answer.verdict == "unknown"
    assert any("37.3" in line for line in answer.words())


def test_answer_and_report(lopsided):
    tests, file = lopsided
    answer = diagnosed(file, tests)
    content = json.loads(diagnosis_view(answer, (), "pipeclamp add").answer.json_text())
    assert content.keys() >= ANSWER_FIELDS
    assert content["verdict"] == "missing"
    assert content["effects"] == ["asymmetry"]
    assert content["candidates"][0]["effect"] == "asymmetry"
    assert content["nrmse"]["noise"] < content["nrmse"]["best"] < content["nrmse"]["law"]
    page = render("t", "s", diagnosis_page(file, answer, "pipeclamp add"))
    assert "asymmetry" in page
    with few_effects(*LOPSIDED):
        settled = add_until_settled(file, RecordTests(tests), command="test")
    assert settled.found.verdict == "complete"
    assert (answer.left_over(), settled.found.left_over()) == ((), ())  # asymmetry leaves scatter alone
    assert settled.file.effects == ("asymmetry",)
    assert [step.step for step in settled.file.history][-1] == "+ asymmetry"
    assert law_text(settled.file)


def test_what_was_tried_in_vain_on_the_same_tests_is_not_named_again(lopsided):
    tests, file = lopsided
    tried = InVain(effect="asymmetry", refitted_nrmse=(0.05, 0.06))
    last = LastDiagnosis(verdict="unknown", tests="tests", in_vain=(tried,))
    remembering = file.model_copy(update={"diagnosis": last})
    repeated = replace(tests, fingerprint="of other tests")
    with few_effects(*LOPSIDED):
        found, anew = diagnosed(remembering, tests), diagnosed(remembering, repeated)
    assert (found.verdict, found.effects) == ("unknown", ())
    assert found.words()[0].startswith("asymmetry was tried and not added")
    assert "5.00% -> 6.00%" in found.words()[0]
    assert anew.effects == ("asymmetry",)


@pytest.mark.parametrize(("slip", "bend", "stiffness"), [(-0.25, 0.05, 0.0), (-0.1, 0.0, -0.1)])
def test_what_slips_and_follows_the_temperature_is_named(slip, bend, stiffness, campaign):
    """By its slip force alone; or as a whole, as where a modulus falls."""
    values = {"k_s": 900.0, "z_s": 120.0, "z_T1": slip, "z_T2": bend, "k_zT": stiffness}
    tests = campaign(("memory", "slip_temperature"), **values)
    with few_effects(*SLIPPING):
        diagnosis = diagnose(Structure("power", ("memory",)), tests)
    assert (diagnosis.verdict, diagnosis.kind, diagnosis.effects) == ("missing", "cause", ("slip_temperature",))


@pytest.mark.parametrize("values", [{"k_s": 650.0, "z_s": 68.0}, {"k_s": 4000.0, "z_s": 40.0}])
def test_what_slips_is_named_with_what_only_it_brings(campaign, values):
    """Slip forces that fall to a twentieth when hot: damping that falls alone takes most, memory alone nothing."""
    tests = campaign(("memory", "slip_temperature"), **values, z_T1=-1.1, z_T2=0.0, k_zT=0.0)
    with few_effects(*SLIPPING):
        diagnosis = diagnose(Structure("power"), tests)
    assert diagnosis.candidates[0].effects == ("damping_temperature",)
    assert (diagnosis.verdict, diagnosis.kind, diagnosis.effects) == ("missing", "cause", ("memory",))
    assert diagnosis.pair.effects == ("memory", "slip_temperature")


def test_a_law_is_left_out_and_prepared_once_however_often_it_is_asked(campaign, monkeypatch):
    """Each effect that is tried begins with the same law; a diagnosis and what asks the law again share its fit."""
    asked = []

    def counted(name, function):
        return lambda *given, **named: (asked.append(name), function(*given, **named))[1]

    monkeypatch.setattr(on_records, "refitted_nrmse", counted("left out", on_records.refitted_nrmse))
    monkeypatch.setattr(problem, "prepare", counted("prepared", problem.prepare))
    runs = campaign(("asymmetry",), k2=60.0)
    tests, file = RecordTests(runs), law_file(identify(runs), runs, name="base", provenance=Provenance(""))
    first, second = (add_effect(file, name, tests, provenance=Provenance("")) for name in ("asymmetry", "offset"))
    assert first.heldout.before == second.heldout.before
    found = tests.diagnose(first.after)
    assert found.verdict == "complete"
    assert tests.superfluous(first.after, "offset", silent) is None
    assert sorted(asked) == ["left out"] * 3 + ["prepared"]


def test_what_acts_alike_is_exchanged_where_the_other_does_better(campaign):
    """A ladder that took the one for the other gets to the one that is there, and stays."""
    tests = campaign(("end_stop",), replace(TWO_TEMPERATURES, frequencies=(1.0, 4.0)), k_e=4000.0, y_e=0.6)
    loops = loops_of(tests)
    taken = identify(tests, Structure(effects=("hardening",))).fit.law
    better, *_ = better_structures(ask_again(taken, loops), None, ALONE)
    assert better == Structure("power", ("end_stop",))
    assert not better_structures(
        ask_again(identify(tests, Structure(effects=better.effects)).fit.law, loops), None, ALONE
    )


def test_a_base_that_does_better_is_tried_alone_too(tmp_path):
    """An effect may have made up for the base that the law had: here damping that falls beyond a speed."""
    values = {"a_0": 0.0, "a_1": 900.0, "b_0": 0.0, "b_1": 8.0, "b_2": -0.3, "s_A": 0.0, "s_T": 0.0}
    truth = Law(Structure("series:1:2"), {**values, "r_A": 0.0, "r_f": 0.0}, 0.0126, 0.002)
    write_campaign(tmp_path / "campaign", virtual_runs(truth, TWO_TEMPERATURES), name="virtual", notes="")
    tests = read_campaign(tmp_path / "campaign")
    taken = identify(tests, Structure(effects=("oil_damper",))).fit.law
    structures = better_structures(ask_again(taken, loops_of(tests)), None, ALONE)
    assert structures == [Structure("series:1:2", ("oil_damper",)), Structure("series:1:2")]


@pytest.mark.parametrize(
    ("hidden", "values", "expected"),
    [
        ("asymmetry", {"k2": 60.0}, "asymmetry"),
        ("gas_spring", {"F_g": 300.0, "q_g": 0.7, "n_g": 1.4}, None),
    ],
)
def test_a_simpler_effect_takes_the_place_of_one_that_does_no_better(campaign, hidden, values, expected):
    tests, taken = campaign((hidden,), TWO_TEMPERATURES, **values), "gas_spring"
    asked = ask_again(identify(tests, Structure(effects=(taken,))).fit.law, loops_of(tests))
    assert simpler_structure(asked, (), ALONE) is None
    assert simpler_structure(asked, (taken,), ALONE) == (expected and Structure("power", (expected,)))


POWERS = {"k1_A": 0.0, "k3_A": 0.0, "c_A": 0.0, "alpha_A": 0.0}
"""Of the amplitude, in the base law."""


@pytest.mark.parametrize(
    ("effects", "values", "held"),
    [
        (("memory",), {**POWERS, "k_s": 600.0, "z_s": 120.0}, set(POWERS)),
        (("memory",), {**POWERS, "k_s": 600.0, "z_s": 120.0, "k1_A": -0.3}, {"k3_A", "c_A", "alpha_A"}),
        (("hardening",), {**POWERS, "k5": 300.0}, None),
    ],
)
def test_a_law_with_memory_is_spared_the_powers_of_the_amplitude_that_the_device_lacks(campaign, effects, values, held):
    """What the device has stays, and a law without memory is asked for none: A is all that it knows of the past."""
    tests = campaign(effects, TWO_TEMPERATURES, **values)
    asked = ask_again(identify(tests, Structure(effects=effects)).fit.law, loops_of(tests))
    without = without_spare_powers(asked, complete=True, progress=silent)
    if held is None:
        assert without is None
    else:
        assert dict(without.frozen) == dict.fromkeys(held, 0.0)
        assert replace(without, frozen=()) == asked.structure


def test_powers_that_memory_spared_are_fitted_again_where_it_goes(campaign):
    runs = campaign(("memory",), TWO_TEMPERATURES, **POWERS, k_s=600.0, z_s=120.0)
    tests, made = RecordTests(runs), Provenance("test")
    structure = Structure(effects=("memory",))
    file = law_file(identify(runs, structure), runs, name="base", provenance=made)
    spared = exchange(file, replace(structure, frozen=(("k1_A", 0.0),)), tests, provenance=made)
    assert str(spared.step) == "without k1_A"
    entry = spared.after.coefficients["k1_A"]
    assert (entry.value, entry.state, entry.reason) == (0.0, "held", "held where it does nothing")
    with_offset = add_effect(spared.after, "offset", tests, provenance=made).after
    assert with_offset.coefficients["k1_A"].state == "held"
    assert remove_effect(with_offset, "memory", tests, provenance=made).after.coefficients["k1_A"].state == "fitted"
    back = with_powers_back(with_offset, tests, provenance=made)
    assert str(back.step) == "with k1_A"
    assert back.after.coefficients["k1_A"].state == "fitted"
    assert back.heldout.before == pytest.approx(with_offset.history[-1].refitted_nrmse)
    assert with_powers_back(file, tests, provenance=made) is None


def test_no_next_test_without_rivals(campaign):
    diagnosis = diagnose(Structure("power"), campaign())
    assert next_test(diagnosis) is None


@pytest.mark.parametrize("text", ["A=1", "A=2..1,f=1..2,T=0..1", "nonsense", "A=0..1,f=1..2,T=0..1"])
def test_limits_that_cant_serve(text):
    with pytest.raises(Exception, match="--limits"):
        parse_limits(text)


@pytest.mark.parametrize(
    ("text", "correction"),
    [
        ("A=1", "write A=..1"),
        ("A=0.1-2", "write A=0.1..2"),
        ("A=0.1..2 mm", "write A=0.1..2"),
        ("f=20..0.5", "the lower end first; write f=0.5..20"),
        ("A=0..1", "above 0 mm; write A=..1"),
        ("T=-300..30", "above -273.15 °C; write T=..30"),
        ("v=5..300", "the largest velocity alone; write v=..300"),
        ("F=300", "write F=..300"),
        ("a=1..2", "expected A=0.1..2,f=0.5..20"),
        ("f=1..2,f=3..4", "f twice"),
        ("A=..", "write A=..2"),
    ],
)
def test_the_message_has_the_limits_to_write(text, correction):
    with pytest.raises(UsageError) as refused:
        parse_limits(text)
    assert correction in str(refused.value)
    if "write " in correction:
        parse_limits(correction.split("write ")[1])


def test_limits_with_open_ends():
    limits = parse_limits("A=..1.1,v=..300,F=..5000")
    assert (limits.amplitude, limits.velocity, limits.force) == ((0.0, 1.1), 300.0, 5000.0)
    assert limits.frequency == Limits().frequency


def test_limits():
    limits = parse_limits("A=0.1..2,f=0.5..20,T=-20..300")
    assert np.allclose([*limits.amplitude, *limits.frequency, *limits.temperature], [0.1, 2, 0.5, 20, -20, 300])
