"""Branches that leave a curve where its symmetric motion becomes unstable."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from cantilever import FOUR_METRES

from pipeclamp_identification.on_pipe.sines import compare_pipe
from pipeclamp_models.law.law import Law, Structure
from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_models.pipe.modes import reduce
from pipeclamp_system.response.curves import Curve, FrequencyResponse
from pipeclamp_system.response.run import curve_of
from pipeclamp_system.response.summary import response_summary
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.clamp import SteadyClamp
from pipeclamp_system.steady.described import ResponseTable
from pipeclamp_system.steady.detached import leaving_branches
from pipeclamp_system.steady.states import SteadyState, half_range

FIRST, LAST = 1.8, 4.0

SHOT = {2.25: [(0.91997, 0.03841)], 2.6: [(1.1113, 0.0683), (1.22480, 0.01528)], 2.7: [(1.10644, 0.00749)]}
"""Stable motions, half range and mean at the clamp in mm, by Hz: Newton on a cycle of 8000 Runge-Kutta steps of the
pipe's modes, a code of its own; from random starts. At none of these the symmetric motion is stable."""


def system(effects: tuple[str, ...] = ("gap",), **values: float) -> SteadySystem:
    structure = Structure("power", effects)
    known = {"k10": 14.0, "c0": 0.004, "alpha0": 1.0, "g": 0.3} | values
    law = Law(structure, {name: known.get(name, 0.0) for name in structure.equations.names}, 1e-6, 1e-6)
    clamp = SteadyClamp(law, 293.15, 1.0, 6.0, (0.01, 9.0), (0.5, 60.0))
    return SteadySystem(reduce(parse_pipe(FOUR_METRES)), [(0, clamp)], lambda frequency: 0.5)


def amplitude(state: SteadyState) -> float:
    return float(half_range(state.clamps)[0])


@pytest.fixture(scope="module")
def curve() -> Curve:
    return curve_of(system(), ResponseTable(from_Hz=FIRST, to_Hz=LAST), None, 1.0, "")


@pytest.mark.parametrize("frequency", SHOT)
def test_stable_motions_behind_a_gap_are_found_where_the_symmetric_one_is_unstable(
    curve: Curve, frequency: float
) -> None:
    balance = system()
    (branch,) = curve.leaving
    (symmetric,) = balance.crossings(curve.followed.states, frequency)
    assert not symmetric.stable
    found = [
        (amplitude(state), abs(state.clamps[0, 0])) for state in balance.crossings(branch, frequency) if state.stable
    ]
    assert found == [pytest.approx(shot, rel=2e-3, abs=1e-4) for shot in SHOT[frequency]]


def test_the_branch_joins_the_curve_at_both_ends_and_its_mirror_image_is_left_out(curve: Curve) -> None:
    (branch,) = curve.leaving
    along = [(state.frequency, amplitude(state)) for state in curve.followed.states]
    for end in (branch[0], branch[-1]):  # where they meet no solver tells them apart
        assert amplitude(end) == pytest.approx(np.interp(end.frequency, *zip(*along, strict=True)), rel=0.01)
    means = np.array([state.clamps[0, 0].real for state in branch[1:-1]])
    assert np.all(means > 0) or np.all(means < 0)
    assert curve.detached == ()
    summary = response_summary(FrequencyResponse("gap", ("c",), (), "", (curve,), (), ({},)))
    assert "a less symmetric branch from 2.1" in summary
    assert "off the middle by up to 0.07 mm" in summary


MEASUREMENT = """
name = "measured"
[[probes]]
name = "c"
position_m = 3.2
unit = "mm"
[[responses]]
file = "sines.csv"
"""
SYSTEM = """
pipe = { file = "pipe.toml" }
clamps = [{ at = "c", law = "law.json", temperature_C = 20.0, amplitude_mm = 1.0, frequency_Hz = 6.0 }]
excitation = { kind = "sine", acceleration_m_s2 = 0.5, frequency_Hz = 2.6 }
run = { stop_s = 1.0, step_s = 0.001 }
"""


def test_what_was_measured_is_compared_with_a_branch_that_leaves(
    tmp_path: Path, write_law: Callable[..., None]
) -> None:
    """Where the symmetric motion is unstable a pipe settles on the other one: there had been nothing to compare."""
    write_law(tmp_path / "law.json", {"k10": 14.0, "c0": 0.004, "alpha0": 1.0, "g": 0.3}, "power", ("gap",), 1e-6)
    (tmp_path / "pipe.toml").write_text(FOUR_METRES, encoding="utf-8")
    (tmp_path / "system.toml").write_text(SYSTEM, encoding="utf-8")
    folder = tmp_path / "measured"
    folder.mkdir()
    (folder / "measurement.toml").write_text(MEASUREMENT, encoding="utf-8")
    sines = "".join(f"{f},0.5,1.0,0.0\n" for f in (FIRST, *SHOT, LAST))
    (folder / "sines.csv").write_text("frequency_Hz,acceleration_m_s2,c_real,c_imag\n" + sines, encoding="utf-8")
    compared = compare_pipe(tmp_path / "system.toml", folder)
    assert compared.compared.all()
    found = {}
    for group in compared.prediction.groups:
        for row, unknowns in zip(group.rows.tolist(), group.solved.unknowns, strict=True):
            frequency = float(compared.measurement.steady.frequency[row])
            state = system().state(unknowns, frequency)
            found[frequency] = amplitude(state), abs(float(state.clamps[0, 0].real))
    for frequency, shot in SHOT.items():
        assert any(found[frequency] == pytest.approx(one, rel=2e-3, abs=2e-4) for one in shot)


def test_a_folded_curve_without_symmetry_is_left_by_none() -> None:
    balance = system(("gap", "asymmetry"), k2=6.0, k10=12.0, k30=2.0, g=0.2)
    followed = balance.followed(FIRST, 9.0)
    assert np.any(np.diff([state.frequency for state in followed.states]) < 0)
    assert leaving_branches(balance, followed.pieces, FIRST, 9.0) == ()
