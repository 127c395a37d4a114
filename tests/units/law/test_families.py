"""Members of one family of effects: which replaces which, and how the next larger one begins."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest

import pipeclamp_identification
from pipeclamp_identification.campaign.bundled import campaign_folder
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.diagnosis.screen import candidate_names, fits_beside
from pipeclamp_identification.fitting.observations import loop_observations
from pipeclamp_identification.fitting.refinement import refined_starts
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.catalogue import effect_id, entries, find_effect, member_number
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.law import Structure, with_effect

SUPPORT = Declaration.model_validate(
    {
        "id": "support",
        "title": "The support's own spring beside the clamp",
        "looks_like": "a loop that is steeper as a whole",
        "force": "k_support * y",
        "parameters": [{"symbol": "k_support", "unit": "N/mm", "meaning": "its stiffness", "start": 10.0}],
    }
)


@pytest.mark.parametrize(
    ("before", "added", "after"),
    [
        (Structure("power", ("memory",)), "memory:2", ("memory:2",)),
        (Structure("power", ("memory:2", "viscous")), "memory:3", ("viscous", "memory:3")),
        (Structure("power", ("condition:i",)), "condition:pressure", ("condition:i", "condition:pressure")),
        (Structure("memory"), "memory:2", ("memory:2",)),
    ],
)  # fmt: skip
def test_a_larger_member_takes_the_smaller_ones_place(before, added, after):
    structure = with_effect(before, added)
    assert structure.effects == after
    assert len(structure.equations.states) == sum(member_number(name) for name in after)


@pytest.mark.parametrize(
    ("before", "added", "words"),
    [
        (Structure("power", ("memory",)), "memory", "in the law already"),
        (Structure("power", ("memory",)), "memory:1", "in the law already"),
        (Structure("power", ("memory:2",)), "memory", "the law has 'memory:2' already.*remove 'memory:2' first"),
        (Structure("power", ("memory:3",)), "memory:2", "the law has 'memory:3' already"),
        (Structure("memory"), "memory", "in the law already"),
        (Structure("power", ("condition:current_A",)), "condition:current_A", "in the law already"),
    ],
)
def test_a_member_no_larger_than_the_laws_own_is_refused(before, added, words):
    with pytest.raises(UserError, match=words):
        with_effect(before, added)


def test_candidates_are_what_the_law_lacks_and_the_next_larger_members():
    names = candidate_names(Structure("power", ("memory:2", "offset", "condition:pressure")), ("pressure", "current_A"))
    assert {"memory:3", "condition:current_A", "viscous"} <= set(names)
    assert not {"memory", "memory:2", "offset", "condition:pressure", "linear_stiffness", "elastic_series"} & set(names)
    assert "memory:2" in candidate_names(Structure("memory"), ())
    assert not [name for name in candidate_names(Structure("power", ("memory:6",)), ()) if effect_id(name) == "memory"]


def test_a_further_element_splits_the_strongest():
    memory = find_effect("memory:2").refinement
    assert memory is not None
    assert memory.name == "memory:3"
    assert memory.start({"k_s1": 300.0, "z_s1": 90.0, "k_s2": 100.0, "z_s2": 20.0}) == {
        "k_s1": 100.0, "z_s1": 20.0, "k_s2": 150.0, "z_s2": 22.5, "k_s3": 150.0, "z_s3": 67.5,
    }  # fmt: skip
    assert find_effect("memory:6").refinement is None


@pytest.mark.parametrize("name", [name for name, entry in entries().items() if getattr(entry, "numbered", False)])
def test_refinements_lead_to_larger_members_with_a_start_for_each_parameter(name):
    effect = find_effect(name)
    while effect.refinement:
        larger = find_effect(effect.refinement.name)
        start = effect.refinement.start({parameter.name: 2.0 for parameter in effect.parameters})
        assert set(start) == {parameter.name for parameter in larger.parameters}
        assert effect_id(larger.name) == effect_id(effect.name)
        assert member_number(larger.name) > member_number(effect.name)
        effect = larger


def test_a_users_own_parameter_is_kept_whatever_its_name():
    observations = loop_observations(loops_of(read_campaign(campaign_folder(Path("clamp_a")))))
    structure = Structure("power", ("support", "memory"), declared=(SUPPORT,))
    values = dict.fromkeys(structure.equations.names, 3.0) | {"k_support": 123.0}
    starts = refined_starts(with_effect(structure, "memory:2"), structure.effect("memory"), observations, values)
    assert len(starts) > 1
    assert {start["k_support"] for start in starts} == {123.0}
    assert {start["k10"] for start in starts} == {3.0}
    assert starts[-1]["k_s1"] == starts[-1]["k_s2"] == 1.5
    assert all(np.isfinite(list(start.values())).all() for start in starts)


def test_two_memories_that_imitate_each_other_are_no_pair():
    remembering = Structure("power", ("memory:2",))
    assert not fits_beside(remembering, "slip_spread")
    assert not fits_beside(remembering, "bouc_wen")
    assert fits_beside(remembering, "play")
    assert fits_beside(remembering, "coulomb"), "it imitates memory, but remembers nothing"


ALSO_A_CONDITION = {"density"}
"""What tests vary may have an effect's name."""


@pytest.mark.parametrize("room", ["fitting", "comparison", "diagnosis", "metrics_only", "workflow"])
def test_no_effect_is_special_outside_its_file(room):
    """No text of these rooms is an effect's name or parameter; published.py states laws, as a user would."""
    effects = [find_effect(name) for name, entry in entries().items() if getattr(entry, "default", "") is not None]
    special = {effect.id for effect in effects if effect.part != "base"} - ALSO_A_CONDITION
    special |= {symbol.name for effect in effects for symbol in effect.parameters if "_" in symbol.name}
    special |= {f"{name}:" for name in entries()} | set(entries()) - ALSO_A_CONDITION
    for path in (Path(pipeclamp_identification.__file__).parent / room).glob("*.py"):
        if path.name == "published.py":
            continue
        texts = {
            node.value
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            if isinstance(node, ast.Constant) and isinstance(node.value, str)
        }
        assert not texts & special, f"{path.name} knows {texts & special}"


def test_members_of_families_are_built_once():
    """A diagnosis asks for the same few many hundred times, and their mathematics takes milliseconds."""
    assert find_effect("memory:2") is find_effect("memory:2")
    assert find_effect("memory") is find_effect("memory:1")
