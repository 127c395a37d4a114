"""The sine that tells a found term from its rival, whatever the two follow."""

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.discovery.grammar import terms
from pipeclamp_identification.discovery.telling import telling_test
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import law_of
from pipeclamp_models.law.law import Law, with_effect


def test_terms_that_follow_the_cycles_are_told_apart_at_a_number_of_them(tmp_path):
    """Two factors that follow the cycles ended the search: "the law depends on N, which the tests don't state"."""
    law = law_of(open_law("emwm2"))
    plan = Plan((0.2, 1.0), (1.0, 4.0), (20.0,), seed=1)
    write_campaign(tmp_path / "campaign", virtual_runs(law, plan), name="virtual", notes="")
    loops = loops_of(read_campaign(tmp_path / "campaign"))
    by_id = {term.declaration.id: term for term in terms(("A", "f", "N"), {})}

    def following(name, **own):
        structure = with_effect(law.structure.with_declared([by_id[name].declaration]), name)
        return Law(structure, {**law.values, **own}, law.v_r, law.y_r)

    one = following("found_damping_levelling_n", s_x=0.3, l_x=20.0)
    other = following("found_damping_growing_n", s_x=0.1, l_x=20.0)
    assert "there they differ by" in telling_test(one, other, loops)


def test_what_lies_between_the_temperatures_tested_is_told_there(tmp_path):
    """Only the lowest and the highest temperature had been asked, where both pass through what was measured."""
    law = law_of(open_law("emwm2"))
    plan = Plan((0.2, 1.0), (1.0, 4.0), (20.0, 120.0, 220.0), seed=1)
    write_campaign(tmp_path / "campaign", virtual_runs(law, plan), name="virtual", notes="")
    loops = loops_of(read_campaign(tmp_path / "campaign"))
    (step,) = (term for term in terms(("A", "f", "T"), {}) if term.declaration.id == "found_stiffness_step_t")
    structure = with_effect(law.structure.with_declared([step.declaration]), step.declaration.id)
    one, other = (
        Law(structure, {**law.values, "s_x": -0.2, "l_x": 273.15 + level, "a_x": 20.0}, law.v_r, law.y_r)
        for level in (150.0, 190.0)
    )
    assert "T = 170 °C" in telling_test(one, other, loops)


def test_terms_that_differ_by_less_than_is_material_are_told_by_no_test(tmp_path):
    """A sine on which they differ by 0.07 times the scatter had been what tells them apart."""
    law = law_of(open_law("emwm2"))
    plan = Plan((0.2, 1.0), (1.0, 4.0), (20.0,), seed=1)
    write_campaign(tmp_path / "campaign", virtual_runs(law, plan), name="virtual", notes="")
    loops = loops_of(read_campaign(tmp_path / "campaign"))
    softer, stiffer = (
        Law(law.structure, {**law.values, "k10": law.values["k10"] * by}, law.v_r, law.y_r) for by in (1.0001, 1.05)
    )
    assert telling_test(law, softer, loops) == ""
    assert "there they differ by" in telling_test(law, stiffer, loops)
