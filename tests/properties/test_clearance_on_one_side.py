"""Frequency responses of clamps that act on one side alone, against shooting."""

from __future__ import annotations

from pathlib import Path

import pytest
from cantilever import FOUR_METRES

from pipeclamp_models.law.declaration_files import read_declaration
from pipeclamp_models.law.law import Law, Structure
from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_models.pipe.modes import reduce
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.clamp import SteadyClamp
from pipeclamp_system.steady.states import half_range

CLEARANCE = """
id = "one_sided"
title = "Clearance on one side"
looks_like = "a flat on one side"
path = "PATH"
[[parameters]]
symbol = "g"
unit = "mm"
meaning = "clearance"
start = ["0.05 * A_typical"]
lower = 0
upper = "A_typical"
neutral = 0
"""


def one_sided(folder: Path, path: str, k10: float, g: float) -> SteadySystem:
    (folder / "one_sided.toml").write_text(CLEARANCE.replace("PATH", path), encoding="utf-8")
    structure = Structure("power", ("one_sided",), declared=(read_declaration(folder / "one_sided.toml"),))
    known = {"k10": k10, "c0": 0.004, "alpha0": 1.0, "g": g}
    law = Law(structure, {name: known.get(name, 0.0) for name in structure.equations.names}, 1e-6, 1e-6)
    clamp = SteadyClamp(law, 293.15, 1.0, 6.0, (0.01, 9.0), (0.5, 60.0))
    return SteadySystem(reduce(parse_pipe(FOUR_METRES)), [(0, clamp)], lambda frequency: 0.5)


def test_a_small_peak_beside_a_large_one_is_not_stepped_over(tmp_path: Path) -> None:
    """Half the resonance's frequency, where the clamp moves by a twentieth of it and the curve is folded."""
    system = one_sided(tmp_path, "min(y, 0) + max(y - g, 0)", 14.0, 0.3)
    met = system.crossings(system.followed(2.0, 9.0).states, 2.74)
    assert [state.stable for state in met] == [True, False, True]
    # 8000 Runge-Kutta steps a cycle
    assert [half_range(state.clamps)[0] for state in met] == pytest.approx([1.00399, 1.15769, 1.02529], rel=1e-3)


def test_a_support_that_bears_on_the_pipe_at_rest_has_a_response(tmp_path: Path) -> None:
    """It lifts off where the pipe moves by more than 0.2 mm; at rest its force was flat to Newton's method."""
    system = one_sided(tmp_path, "max(y + g, 0)", 20.0, 0.2)
    state = system.at(3.3)
    assert state is not None
    assert half_range(state.clamps)[0] == pytest.approx(1.90225, rel=2e-3)
