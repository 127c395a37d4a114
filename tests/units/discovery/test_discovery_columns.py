"""What terms add to a law's residuals, at the few points of a cycle at which they are screened."""

import numpy as np
import pytest

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.diagnosis.problem import judge, prepare, weighed_again
from pipeclamp_identification.discovery.columns import Evaluation, all_columns, beside_another_law, weighed_anew
from pipeclamp_identification.discovery.grammar import terms
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import law_of
from pipeclamp_models.law.law import Structure


def test_a_law_whose_elements_never_slip_leaves_the_mean_of_such_runs_open(tmp_path):
    """An element that never slips keeps whatever mean force it began with: a term can't explain it."""
    plan = Plan((0.2, 0.6, 1.0), (1.0, 4.0), (20.0,), seed=1)
    write_campaign(tmp_path / "campaign", virtual_runs(law_of(open_law("emwm2")), plan), name="virtual", notes="")
    structure = Structure("power", ("memory",))
    # a slip force beyond what all motions raise
    problem, fitted = prepare(structure, loops_of(read_campaign(tmp_path / "campaign")))
    law = judge((), structure, [{**fitted.law.values, "k_s": 30.0, "z_s": 3000.0}], problem)
    evaluation = Evaluation(problem, law)
    assert problem.coarse.loops.transforms.shape != problem.observations.loops.transforms.shape
    offset = next(term for term in terms(("A", "f"), {}) if term.declaration.id == "found_one_way_power")
    changes = np.array([column.change for column in evaluation.columns(offset)])
    adrift = evaluation.law_force.adrift
    assert np.any(adrift)
    assert np.all(changes[:, adrift, 0] == 0.0)
    assert np.any(changes)


def test_what_relaxes_slowly_is_walked_until_it_repeats(tmp_path):
    """After two cycles it had been taken for settled, with the force of rest at the start still in it."""
    plan = Plan((0.2, 0.6, 1.0), (1.0, 4.0), (20.0,), seed=1)
    write_campaign(tmp_path / "campaign", virtual_runs(law_of(open_law("emwm2")), plan), name="virtual", notes="")
    structure = Structure("power")
    problem, fitted = prepare(structure, loops_of(read_campaign(tmp_path / "campaign")))
    evaluation = Evaluation(problem, judge((), structure, [fitted.law.values], problem))
    (slow,) = (term for term in terms(("T",), {}) if term.declaration.id == "found_warm_relaxing")
    (state,) = evaluation._states(slow.effect, {"t_x": 0.5, "s_x": 0.0}).values()
    assert np.all(np.abs(state.mean(axis=1)) < 0.02 * np.max(np.abs(state), axis=1))


def test_columns_in_other_weights_are_what_they_would_be_evaluated_there(tmp_path):
    """Most of a search's time goes into them; weighed again they needn't be evaluated again."""
    plan = Plan((0.2, 0.6, 1.0), (1.0, 4.0), (20.0, 150.0), seed=1)
    truth = law_of(open_law("emwm2"))
    write_campaign(tmp_path / "campaign", virtual_runs(truth, plan), name="virtual", notes="")
    structure = Structure("power")
    problem, fitted = prepare(structure, loops_of(read_campaign(tmp_path / "campaign")))
    law = judge((), structure, [fitted.law.values], problem)
    whole = judge((), truth.structure, [truth.values], problem)
    granted, weighed_law = weighed_again(problem, structure, law.result, [law.result])
    fewer, less_law = weighed_again(granted, structure, whole.result, [law.result])
    assert fewer.discrepancy < 0.5 * granted.discrepancy
    before, after = Evaluation(granted, weighed_law), Evaluation(fewer, less_law)
    chosen = [one for one in terms(("A", "f", "T"), {}) if one.family != "factor"][::60]
    columns = [column for term in chosen for column in before.columns(term)]
    direct = [column.change for term in chosen for column in after.columns(term)]
    assert len(columns) > 30
    for column, change in zip(weighed_anew(columns, before, after), direct, strict=True):
        np.testing.assert_allclose(column.change, change, rtol=1e-6, atol=1e-9 * np.max(np.abs(change)))


def test_what_adds_a_force_is_evaluated_once_for_all_laws_that_it_is_put_into(tmp_path, monkeypatch):
    """In the place of a law's effects the same terms are sought on the same tests, up to seven times."""
    plan = Plan((0.2, 0.6, 1.0), (1.0, 4.0), (20.0, 150.0), seed=1)
    write_campaign(tmp_path / "campaign", virtual_runs(law_of(open_law("emwm2")), plan), name="virtual", notes="")
    structure = Structure("power", ("damping_temperature", "asymmetry"))
    problem, fitted = prepare(structure, loops_of(read_campaign(tmp_path / "campaign")))
    law = judge((), structure, [fitted.law.values], problem)
    without = Structure("power")
    less = judge((), without, [without.own(fitted.law.values)], problem)
    before, after = Evaluation(problem, law), Evaluation(problem, less)
    chosen = list(terms(("A", "f", "T"), {}))[::60]
    assert {one.family for one in chosen} >= {"factor", "element"}
    columns, direct = (all_columns(one, chosen, lambda words: None) for one in (before, after))
    monkeypatch.setattr(Evaluation, "_force", lambda *given: pytest.fail("a force is evaluated again"))
    beside = beside_another_law(columns, before, after, chosen, lambda words: None)
    for column, own in zip(beside, direct, strict=True):
        assert column.term is own.term
        assert column.values == own.values
        np.testing.assert_allclose(column.change, own.change, rtol=1e-9, atol=1e-9 * np.max(np.abs(own.change)))
