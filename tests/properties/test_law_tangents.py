"""What a law's tangents make of small changes of a motion is what the law itself makes of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipeclamp_models.law.file import law_of, read_law
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_system.steady.clamp import SteadyClamp
from pipeclamp_system.steady.tangents import linearised

PLAIN = {"k10": 4.0, "k30": 1.0, "c0": 0.05, "alpha0": 1.0, "k1_A": -0.3}
LAWS = {
    "plain": (PLAIN, ()),
    "slipping": (PLAIN | {"k_s1": 6.0, "z_s1": 0.5, "k_s2": 3.0, "z_s2": 1.2}, ("memory:2",)),
    "one sticks": (PLAIN | {"k_s1": 6.0, "z_s1": 0.5, "k_s2": 3.0, "z_s2": 1e3}, ("memory:2",)),
    "relaxing": (PLAIN | {"k_m": 6.0, "tau": 0.03}, ("relaxation",)),
    "frequency": (PLAIN | {"k1_f": 0.4}, ("stiffness_frequency",)),
}
MOTION = np.array([0.05, 1.0 + 0.2j, 0.03, 0.1 - 0.05j, 0.01j])
FREQUENCY, NUDGE = 6.0, 1e-5


def clamp_of(folder: Path, write_law: Callable[..., None], name: str) -> SteadyClamp:
    values, effects = LAWS[name]
    write_law(folder / "law.json", values, "power", effects)
    return SteadyClamp(law_of(read_law(folder / "law.json")), 293.15, None, None, (0.01, 5.0), (1.0, 60.0))


@pytest.mark.parametrize("name", LAWS)
def test_changes_of_harmonics_and_frequency(tmp_path: Path, write_law: Callable[..., None], name: str) -> None:
    clamp = clamp_of(tmp_path, write_law, name)
    parts = np.eye(MOTION.size)
    motions = MOTION + NUDGE * np.vstack([0 * parts[:1], parts, 1j * parts[1:], 0 * parts[:1]])
    frequencies = np.full(len(motions), FREQUENCY)
    frequencies[-1] *= 1 + NUDGE
    force, changes = linearised(clamp, motions, frequencies)
    expected = clamp.forces(motions, frequencies)
    assert force == pytest.approx(expected[0], rel=1e-12, abs=1e-12)
    differences = expected[1:] - expected[0]
    assert np.abs(changes - differences).max() < 2e-3 * np.abs(differences).max()
    assert np.abs(changes[-1] - differences[-1]).max() < 0.02 * np.abs(differences[-1]).max()


@pytest.mark.parametrize("name", ["slipping", "one sticks", "relaxing"])
def test_one_motion_steps_as_it_does_among_others(tmp_path: Path, write_law: Callable[..., None], name: str) -> None:
    """In plain numbers, as many do in arrays; periodic and from rest."""
    clamp = clamp_of(tmp_path, write_law, name)
    equations = clamp.law.structure.equations_without_rig
    cycles = clamp.cycle(np.array([MOTION, 2 * MOTION]), np.array([FREQUENCY, 2 * FREQUENCY]))
    for motions in (cycles, replace(cycles, periodic=False)):
        whole = force_of_equations(equations, clamp.law.vector(equations), (0.05, 1e-3), motions)
        for row in range(2):
            one = force_of_equations(
                equations, clamp.law.vector(equations), (0.05, 1e-3), motions.rows(np.array([row]))
            )
            for alone, among in zip(one.states, whole.states, strict=True):
                assert alone[0] == pytest.approx(among[row], rel=1e-12, abs=1e-12)
