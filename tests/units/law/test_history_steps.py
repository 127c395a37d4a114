"""Steps of a law's history are read as they were written."""

import pytest

from pipeclamp_models.law.step import Step, read_step

STEPS = {
    "+ memory:2": Step(("memory:2",)),
    "- condition:current_A": Step(gone=("condition:current_A",)),
    "bouc_wen -> oil_damper": Step(("oil_damper",), ("bouc_wen",)),
    "memory and play -> slip_spread": Step(("slip_spread",), ("memory", "play")),
    "base series:1:3": Step(base="series:1:3"),
    "base series alone": Step(base="series", alone=True),
}


@pytest.mark.parametrize("text", STEPS)
def test_a_step_is_read_as_it_was_written(text):
    assert str(STEPS[text]) == text
    assert read_step(text) == STEPS[text]


@pytest.mark.parametrize("text", ["a refit", "power", "power + memory + damping_temperature", "clamp_a"])
def test_what_changes_nothing_is_read_as_nothing(text):
    assert read_step(text) == Step()


def test_a_refit_is_told_so():
    assert str(Step()) == "a refit"
    assert not Step().adds
    assert Step(("memory",)).adds
    assert not Step(("oil_damper",), ("bouc_wen",)).adds
