"""Steps of a law's history are read as they were written."""

import pytest

from pipeclamp_models.law.step import LawStep, read_step

STEPS = {
    "+ memory:2": LawStep(("memory:2",)),
    "- condition:current_A": LawStep(gone=("condition:current_A",)),
    "bouc_wen -> oil_damper": LawStep(("oil_damper",), ("bouc_wen",)),
    "memory and play -> slip_spread": LawStep(("slip_spread",), ("memory", "play")),
    "base series:1:3": LawStep(base="series:1:3"),
    "base series alone": LawStep(base="series", alone=True),
    "without k1_A and k3_A": LawStep(held=("k1_A", "k3_A")),
    "with k1_A and k3_A": LawStep(freed=("k1_A", "k3_A")),
}


@pytest.mark.parametrize("text", STEPS)
def test_a_step_is_read_as_it_was_written(text):
    assert str(STEPS[text]) == text
    assert read_step(text) == STEPS[text]


@pytest.mark.parametrize("text", ["a refit", "power", "power + memory + damping_temperature", "clamp_a"])
def test_what_changes_nothing_is_read_as_nothing(text):
    assert read_step(text) == LawStep()


def test_a_refit_is_told_so():
    assert str(LawStep()) == "a refit"
    assert not LawStep().adds
    assert LawStep(("memory",)).adds
    assert not LawStep(("oil_damper",), ("bouc_wen",)).adds
