"""Files without a time that a column parts: pieces of one curve, whose steps are lost to none of them."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import pipeclamp as pc
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.importing.records.planner import plan_import
from pipeclamp_identification.importing.samples.untimed import cycles_of, shares_before
from pipeclamp_identification.importing.stated import stated_options

STIFFNESS, FRICTION = 900.0, 150.0


def corners(*blocks):
    """Corner points of a spring with friction, block by block: rows of block, displacement in mm and force in N."""
    rows, before = [], None
    for block, ys in blocks:
        for y in ys:
            dry = 0.0 if before is None or y == before else FRICTION * np.sign(y - before)
            rows.append((block, y, STIFFNESS * y + dry))
            before = y
    return rows


def imported(folder, rows, names="Block,Displacement [mm],Force [N]", segment="Block"):
    lines = [names, *(",".join(f"{x:.5f}" if isinstance(x, float) else str(x) for x in row) for row in rows)]
    (folder / "a.csv").write_text("\n".join(lines) + "\n")
    pc.import_files(folder / "a.csv", folder / "c", rate="none", columns=f"segment={segment}")
    return read_campaign(folder / "c").runs


def test_steps_of_a_program_lose_none_of_their_cycles(tmp_path):
    """Of corner points, the way into a block and the one out of it were in no run: of two cycles one was left."""
    amplitudes = (0.5, 1.0, 1.5, 2.0)
    program = [(n, ([0.0] if n == 0 else []) + [a, -a] * 2) for n, a in enumerate(amplitudes)]
    runs = imported(tmp_path, corners(*program, (4, [0.0, 0.2])))
    assert [run.cycles.count for run in runs[:4]] == [2, 2, 2, 2]
    assert [run.setup.first_cycle for run in runs[:4]] == pytest.approx([0, 2, 4, 6], abs=1e-6)
    for run, a in zip(runs, amplitudes, strict=False):
        assert np.ptp(run.record.displacement_mm) / 2 == pytest.approx(a, rel=1e-6)


def test_where_runs_lie_is_drawn_side_by_side(tmp_path):
    """The points that runs share lie between the rows that they are of."""
    program = [(n, [0.0, a, -a, a, -a][n > 0 :]) for n, a in enumerate((0.5, 1.0, 1.5))]
    imported(tmp_path, corners(*program))
    stated = stated_options("segment=Block", "", None, "none", leave_out=lambda files: False)
    (tmp_path / "r").mkdir()
    (drawn,) = plan_import([tmp_path / "a.csv"], stated, tmp_path / "r").overviews
    assert np.all(np.diff(drawn.time) >= 0)
    spans = [one[1:] for one in drawn.runs]
    assert all(first[1] <= second[0] for first, second in itertools.pairwise(spans))


def test_a_cycle_ends_where_the_next_one_was_measured_to_begin(tmp_path):
    """Not at the force that it began with: the first cycle begins unloaded, and comes back under friction."""
    program = [(n, [0.0, a, 0.2 * a, -a, -0.5 * a]) for n, a in enumerate((1.0, 1.1, 1.2, 1.3))]
    first, *others = imported(tmp_path, corners(*program))
    assert (first.record.displacement_mm[-1], first.record.force_N[-1]) == pytest.approx((0.0, FRICTION))
    assert [run.setup.first_cycle for run in others] == pytest.approx([1, 2, 3], abs=1e-6)


def test_a_run_that_begins_unloaded_or_under_another_name_begins_anew(tmp_path):
    cycle = [0.0, 0.6, 1.0, 0.2, -1.0, -0.5, 0.3, 1.0, -1.0, -0.4]
    rows = corners((1, cycle), (2, [0.1, *cycle[1:]]))
    rows += [(3, y, force) for _, y, force in corners((3, cycle))]
    rows = [(block, y, force, ("", "", "B")[block - 1]) for block, y, force in rows]
    rows += [(4, y, force, "C") for _, y, force in corners((4, cycle))[2:]]
    runs = imported(tmp_path, rows, names="Block,Displacement [mm],Force [N],Specimen")
    before = [run.setup.first_cycle for run in runs]
    assert before[1] > 1 and [before[0], *before[2:]] == [0, 0, 0]
    assert all(np.ptp(run.record.displacement_mm) == pytest.approx(2.0) for run in runs)


@pytest.mark.parametrize("rate", ["none", "50"])
@pytest.mark.parametrize("begins", [0, 1])
def test_a_machines_count_of_the_cycles_says_how_many_were_before(tmp_path, rate, begins):
    """Of cycles that it caught, one in 500, four had been counted; and the step between two was a part of both."""
    phase = np.linspace(0.0, 2 * np.pi, 51)[:50]
    counts = [begins, 500, 1000, 1500]
    rows = [
        (n, a * np.sin(p), STIFFNESS * a * np.sin(p))
        for n, a in zip(counts, (1, 1.2, 1.4, 1.6), strict=True)
        for p in phase
    ]
    lines = ["Machine_N_cycles,Displacement [mm],Force [N]", *(f"{n},{y:.6f},{force:.4f}" for n, y, force in rows)]
    (tmp_path / "a.csv").write_text("\n".join(lines) + "\n")
    pc.import_files(tmp_path / "a.csv", tmp_path / "c", rate=rate, columns="segment=Machine_N_cycles")
    runs = read_campaign(tmp_path / "c").runs
    assert [run.setup.first_cycle for run in runs] == [0, 500 - begins, 1000 - begins, 1500 - begins]
    assert [np.ptp(run.record.displacement_mm) / 2 for run in runs] == pytest.approx([1, 1.2, 1.4, 1.6], rel=1e-2)


def test_conditions_are_those_of_a_runs_own_samples(tmp_path):
    rows = [(*row, 2.0 * row[0]) for row in corners(*[(n, [a, 0.0, -a, -0.1] * 2) for n, a in enumerate((1.0, 2.0))])]
    names = "Block,Displacement [mm],Force [N],current [A]"
    runs = imported(tmp_path, rows, names, "Block,current_A=current [A]")
    assert [run.setup.conditions["current_A"] for run in runs] == [0.0, 2.0]


def test_a_step_is_shared_where_the_loop_before_it_closes():
    y = np.array([0.0, 1, -1, 2, -2, 3])
    assert shares_before(y, y, (0, 3, 5, 6)) == pytest.approx([1 / 3, 2 / 5], rel=1e-5)
    # ended where it began, away from it, not yet there; a blank beside it
    for ends, share in [((0.0, 2.0), 0.0), ((0.5, 2.0), 0.0), ((-1.0, -0.5), 1.0), ((-1.0, np.nan), np.nan)]:
        curve = np.array([0.0, 1, -1, *ends])
        assert shares_before(curve, curve, (0, 4, 5)) == pytest.approx([share], nan_ok=True)


@pytest.mark.parametrize(
    ("y", "cycles"),
    [
        ([0, 1, -1, 1, -1, 0], 2.0),
        ([0, 2, -2, 2, -2, 2], 2.25),
        ([0, 1, -1], 0.75),
        ([0, 1], 0.5),
        ([1, 1], 0),
        ([1], 0),
    ],
)
def test_cycles_are_counted_by_turns(y, cycles):
    assert cycles_of(np.array(y, dtype=float)) == pytest.approx(cycles)


def test_texts_in_a_column_called_cycle_count_none(tmp_path):
    """The halves of a cycle, as a machine names them, had been a cycle each: 0, 1, 2, 3."""
    rows, time = ["Cycle,Time [s],Displacement [mm],Force [N]"], 0.0
    for number, half in itertools.product((1, 2), ("Stretch", "Recover")):
        for share in np.linspace(0.0, 1.0, 20):
            y = share if half == "Stretch" else 1.0 - share
            rows.append(f"{number}-{half},{time:.3f},{y:.4f},{3 * y:.4f}")
            time += 0.1
    (tmp_path / "a.csv").write_text("\n".join(rows) + "\n")
    pc.import_files(tmp_path / "a.csv", tmp_path / "c", columns="segment=Cycle")
    header, *runs = (tmp_path / "c" / "runs.csv").read_text().splitlines()
    assert [run.split(",")[0] for run in runs] == ["1-Stretch", "1-Recover", "2-Stretch", "2-Recover"]
    assert "first_cycle" not in header
