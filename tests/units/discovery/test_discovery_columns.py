"""What terms add to a law's residuals, at the few points of a cycle at which they are screened."""

import numpy as np

from pipeclamp_identification.campaign import rig
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.diagnosis.problem import judge, prepare
from pipeclamp_identification.discovery.columns import Evaluation
from pipeclamp_identification.discovery.grammar import terms
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import law_of
from pipeclamp_models.law.law import Structure


def test_a_law_whose_elements_never_slip_leaves_the_mean_of_such_runs_open(tmp_path):
    """An element that never slips keeps whatever mean force it began with: a term can't explain it."""
    plan = rig.TestPlan((0.2, 0.6, 1.0), (1.0, 4.0), (20.0,), seed=1)
    write_campaign(tmp_path / "campaign", rig.virtual_runs(law_of(open_law("emwm2")), plan), name="virtual", notes="")
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
    plan = rig.TestPlan((0.2, 0.6, 1.0), (1.0, 4.0), (20.0,), seed=1)
    write_campaign(tmp_path / "campaign", rig.virtual_runs(law_of(open_law("emwm2")), plan), name="virtual", notes="")
    structure = Structure("power")
    problem, fitted = prepare(structure, loops_of(read_campaign(tmp_path / "campaign")))
    evaluation = Evaluation(problem, judge((), structure, [fitted.law.values], problem))
    (slow,) = (term for term in terms(("T",), {}) if term.declaration.id == "found_warm_relaxing")
    (state,) = evaluation._states(slow.effect, {"t_x": 0.5, "s_x": 0.0}).values()
    assert np.all(np.abs(state.mean(axis=1)) < 0.02 * np.max(np.abs(state), axis=1))
