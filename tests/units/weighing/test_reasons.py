"""What is said where no effect is named: that it is so, and in sentences that can be followed."""

from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp_identification.diagnosis.diagnosed import RecordDiagnosed
from pipeclamp_identification.diagnosis.named import few_levels_words
from pipeclamp_identification.diagnosis.run_scatter import RunScatter
from pipeclamp_identification.diagnosis.weighing.reasons import hidden_words, immaterial_words, pair_words
from pipeclamp_models.law.law import Structure

SCATTER = SimpleNamespace(
    scatter=RunScatter(stiffness=0.004, mean_N=12.0, zero_mm=0.0123), mean_shows=True, zero_shows=True, runs=24
)
PROBLEM = SimpleNamespace(loops=SimpleNamespace(run=range(72)), groups=np.arange(2), noise=SCATTER)


def judged(*effects, left_N=2.1, squares=(50.0, 50.0), likelihood=100.0, on_temperature=0.05):
    """Give a law with these mean squares on left-out conditions, and what it leaves when fitted to all tests."""
    return SimpleNamespace(
        effects=effects,
        akaike=likelihood,
        heldout_by={"temperature": on_temperature},
        lack=SimpleNamespace(rms=left_N, share=left_N / 0.5, most_share=left_N / 0.5 + 0.1),
        score=SimpleNamespace(mean_squares=np.array(squares), axes=None, squares=np.array(squares)),
        missing=sum(squares),
        result=SimpleNamespace(equations=SimpleNamespace(names=()), fitted_parameters=()),
    )


LAW = judged()


def test_what_steadies_a_law_and_explains_nothing_is_told_as_such():
    """It takes 78 % on left-out conditions, and nothing of what the fit to all tests leaves."""
    steadying = judged("memory", squares=(11.0, 11.0), likelihood=101.0, on_temperature=0.04)
    words = immaterial_words(steadying, LAW, PROBLEM)
    assert words.startswith("memory takes most, 78% of what is missing on left-out A and f, but fitted to all tests")
    assert "leaves 2.1 N that follow the conditions with it, and 2.1 N without it" in words


def test_forces_are_told_without_powers_of_ten():
    """Of a measured friction device a law left "2.86e+03 N"."""
    large = judged("play", "gap", left_N=2861.4, squares=(10.0, 10.0))
    assert "leave 2860 N (" in pair_words(large, LAW, LAW, PROBLEM)[0]


@pytest.mark.parametrize(
    ("missing", "after", "said"),
    [
        (100.0, 0.1515, ("refitted without these conditions it takes 22% of that: the estimate promised too much",)),
        (100.0, 0.1, ()),
        # most of the error is scatter, of which no effect can take anything
        (25.0, 0.1515, ()),
    ],
)
def test_a_rung_that_takes_much_less_than_was_estimated_is_told(missing, after, said):
    """Of a concrete column in five steps slip_spread was to take 72 %, and took the error from 17.17 to 15.15 %."""
    law = SimpleNamespace(score=LAW.score, missing=missing)
    found = RecordDiagnosed(SimpleNamespace(explained=0.72, law=law), comparison=None)
    assert found.refitted(0.1717, after) == said


def test_an_effect_of_no_help_is_not_called_the_one_that_takes_most():
    words = immaterial_words(judged("play", squares=(50.0, 49.9)), LAW, PROBLEM)
    assert "play" not in words
    assert "none takes as much as 1%" in words


@pytest.mark.parametrize(
    ("squares", "best", "said"),
    [
        (
            (40.0, 36.0),
            (50.0, 50.0),
            "play and gap together would take 24% of it, but on left-out temperature the error",
        ),
        ((10.0, 10.0), (50.0, 50.0), "play and gap together would take 80% of it, but leave 2.1 N"),
        ((40.0, 36.0), (35.0, 35.0), ""),
        ((50.0, 50.0), (50.0, 50.0), ""),
    ],
)
def test_why_two_effects_in_the_table_are_not_named_is_said(squares, best, said):
    pair = judged("play", "gap", squares=squares, on_temperature=0.07)
    told = "".join(pair_words(pair, judged("memory", squares=best), LAW, PROBLEM))
    assert told.startswith(said)
    assert bool(told) == bool(said)


def test_what_scatter_may_hide_is_told_in_times_of_the_noise():
    words = hidden_words(LAW.lack, PROBLEM)
    assert "(0.40% of stiffness, 12 N of the mean force and 0.012 mm of the displacement's zero) may hide" in words
    assert "that it is up to 4.3 times the force noise, and these 24 runs" in words


@pytest.mark.parametrize("verdict", ["complete", "unknown", "missing", "ambiguous"])
def test_of_a_law_that_stays_it_is_told_where_it_is_farthest_off(verdict):
    """A law with no force in the smallest loops had been told by the error of all runs alone."""
    far = "at A = 0.05 mm the law errs by 99.99% of the force there (7 runs)"
    found = RecordDiagnosed(SimpleNamespace(verdict=verdict), SimpleNamespace(farthest_off=far))
    assert found.farthest_off() == ((far,) if verdict in ("complete", "unknown") else ())
    assert RecordDiagnosed(found.diagnosis, SimpleNamespace(farthest_off="")).farthest_off() == ()


@pytest.mark.parametrize(("time_measured", "conditions"), [(True, ["amplitude", "frequency"]), (False, ["amplitude"])])
def test_no_frequency_is_missed_where_no_time_was_measured(time_measured, conditions):
    """Of tests without a time it had been said that all are at 1 Hz, which is what a cycle counts for."""
    slow = {"A": np.full((4, 1), 0.5), "f": np.full((4, 1), 1.0), "T": np.array([[293.0], [330.0], [360.0], [400.0]])}
    problem = SimpleNamespace(
        observations=SimpleNamespace(motion=SimpleNamespace(slow=slow)),
        loops=SimpleNamespace(time_measured=time_measured),
    )
    told = RecordDiagnosed(SimpleNamespace(problem=problem), SimpleNamespace()).untested()
    assert [words.split(",")[0].removeprefix("all tests are at one ") for words in told] == conditions


@pytest.mark.parametrize(
    ("levels", "told"), [((0.0, 5.0), True), ((0.0, 5.0, 10.0), True), ((0.0, 5.0, 8.0, 10.0), False)]
)
def test_what_a_law_does_between_few_levels_is_said_to_be_untested(levels, told):
    """A law that followed three levels of a bolt's torque was complete, and erred by half of the noise between them."""
    equations = Structure("power", ("condition:bolt_torque_Nm",)).equations
    conditions = {"bolt_torque_Nm": np.repeat(levels, 4), "current_A": np.repeat(levels, 4)}
    shown = [one for one in equations.parameters if one.levels <= len(levels)]
    words = few_levels_words(shown, conditions)
    assert [f"the tests have {len(levels)} levels of bolt_torque_Nm" in one for one in words] == [True] * told
