"""Machine code of large laws, which is made without the best choice of instructions, gives the same numbers."""

from __future__ import annotations

import numpy as np
import pytest

from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise import machine
from pipeclamp_models.realise.arrays import realise
from pipeclamp_models.realise.walks import Along, Course, Taken


def carried(monkeypatch: pytest.MonkeyPatch, large: int) -> tuple[int, list[Along]]:
    """Give the size of the code of a law with memory behind a clearance, and what becomes of its states."""
    sizes: list[int] = []

    def measured(source: str) -> bytes:
        made = code(source)
        sizes.append(len(made))
        return made

    code = machine._machine_code
    with monkeypatch.context() as patch:
        patch.setenv("PIPECLAMP_CACHE", "")
        patch.setattr(machine, "LARGE", large)
        patch.setattr(machine, "_machine_code", measured)
        patch.setattr(machine, "machine_function", machine.machine_function.__wrapped__)
        equations = Structure("power", ("memory", "play")).equations
        rng = np.random.default_rng(1)
        states, written = len(equations.states), realise(equations).written("courses")["parts"]
        count = 1 + max(column for one in written for column in one["columns"])
        taken = Taken(list(rng.uniform(0.5, 1.5, (count, 3, 40))), (3, 40))
        courses = [Course(one["states"], one["columns"], one["index"], one["source"]) for one in written]
        found = [course(rng.uniform(-1.0, 1.0, (states, 3)), taken) for course in courses]
    return sum(sizes), found


def test_it_gives_the_same_states_and_slopes(monkeypatch: pytest.MonkeyPatch) -> None:
    (size, best), (plain_size, plain) = (carried(monkeypatch, large) for large in (10**9, 0))
    assert plain_size > size > 0, "more instructions, or the second wasn't made as large ones are"
    for one, other in zip(best, plain, strict=True):
        np.testing.assert_array_equal(one.states, other.states)
        assert one.slopes.keys() == other.slopes.keys()
        for pair, slope in one.slopes.items():
            np.testing.assert_array_equal(slope, other.slopes[pair])
