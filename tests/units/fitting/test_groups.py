"""Groups of runs that differ: put in by plain arithmetic, found beside what conditions do, told with their errors."""

from __future__ import annotations

import gzip
import shutil
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from pipeclamp_identification.campaign.bundled import bundled_campaign
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.diagnosis.left_out import WithoutGroups, whitened
from pipeclamp_identification.diagnosis.problem import judge, prepare
from pipeclamp_identification.fitting.group_factors import Poolings, mixed
from pipeclamp_identification.fitting.groups import factors_of, find_groups, strangest_run
from pipeclamp_identification.fitting.groups_answer import groups_answer
from pipeclamp_identification.fitting.identify import fit_structure
from pipeclamp_identification.fitting.least_squares import fit
from pipeclamp_identification.fitting.observations import loop_observations
from pipeclamp_identification.loops.loops import Loops, loops_of
from pipeclamp_models.law.law import Structure

FACTORS = {"S1": 1.0, "S2": 1.08, "S3": 0.95}
OFFSETS = {"S1": 0.0, "S2": 12.0, "S3": 0.0}
LAW = Structure("power", ("damping_temperature",))


def _copy(source: Path, target: Path, said, true=None, change=None, further=None) -> Path:
    """Copy a campaign: a column of specimens as said; the force as change(y, F) of the true one makes it."""
    target.mkdir()
    shutil.copy(source / "campaign.toml", target)
    table = pl.read_csv(source / "runs.csv")
    for place, row in enumerate(table.iter_rows(named=True)):
        content = (source / row["file"]).read_bytes()
        record = pl.read_csv(gzip.decompress(content))
        force = record["force_N"].to_numpy()
        name = (true or said)[place]
        changed = force * FACTORS.get(name, 1.0) + OFFSETS.get(name, 0.0) if change is None else change(name, force)
        record.with_columns(pl.Series("force_N", changed)).write_parquet(target / f"{place}.parquet")
    columns = {"file": [f"{place}.parquet" for place in range(len(table))], "specimen": list(said), **(further or {})}
    table.with_columns(*(pl.Series(name, values) for name, values in columns.items())).write_csv(target / "runs.csv")
    return target


def _drawn(count=48, seed=0):
    return np.random.default_rng(seed).choice(["S1", "S2", "S3"], count).tolist()


def _fitted(folder):
    loops = loops_of(read_campaign(folder))
    return fit_structure(LAW, loops), loops


@pytest.fixture(scope="module")
def differing(tmp_path_factory):
    folder = _copy(bundled_campaign("clamp_a"), tmp_path_factory.mktemp("groups") / "differing", _drawn())
    return (*_fitted(folder), folder)


def test_specimens_that_differ_are_told_by_how_much_and_in_what(differing):
    (found,) = differing[0].groups
    assert (found.column, found.names, found.strangers, found.confounded) == ("specimen", ("S1", "S2", "S3"), (), ())
    assert set(found.differ) == {"stiffness", "damping", "mean_force"}
    for quantity, within in (("stiffness", 0.005), ("damping", 0.015)):
        factors, errors = found.factors(quantity)
        assert factors[1] / factors[0] == pytest.approx(1.08, abs=within)
        assert factors[2] / factors[0] == pytest.approx(0.95, abs=within)
        assert np.all(errors < within)
    forces, errors = found.factors("mean_force")
    assert forces[1] - forces[0] == pytest.approx(12.0, abs=3 * np.hypot(errors[0], errors[1]))
    assert np.all(errors < 1.5)


def test_the_law_beside_differing_specimens_is_that_of_alike_ones(differing):
    """Its error, what the groups' factors explain left aside, is that on the campaign without specimens."""
    result = differing[0]
    plain = fit_structure(LAW, loops_of(read_campaign(bundled_campaign("clamp_a"))))
    # common factors are the middle one's: the geometric mean of the three, within a percent
    middle = np.cbrt(np.prod(list(FACTORS.values())))
    for name in ("k1_A", "k1_T", "alpha0", "c_f"):
        assert result.law.values[name] == pytest.approx(plain.law.values[name], abs=0.02)
    assert result.law.values["k10"] == pytest.approx(middle * plain.law.values["k10"], rel=0.02)


def test_specimens_that_differ_by_chance_are_not_told(tmp_path):
    result, _ = _fitted(_copy(bundled_campaign("clamp_a"), tmp_path / "c", _drawn(), change=lambda name, force: force))
    plain = fit_structure(LAW, loops_of(read_campaign(bundled_campaign("clamp_a"))))
    assert result.groups == ()
    # and nothing changes, bit by bit
    assert result.law.values == plain.law.values


def test_labels_that_hardly_repeat_are_remarks(tmp_path):
    result, _ = _fitted(_copy(bundled_campaign("clamp_a"), tmp_path / "c", [f"run {place}" for place in range(48)]))
    assert result.groups == ()


def test_a_specimen_for_each_temperature_cant_be_told_from_it(tmp_path):
    temperatures = pl.read_csv(bundled_campaign("clamp_a") / "runs.csv")["temperature_C"]
    result, _ = _fitted(_copy(bundled_campaign("clamp_a"), tmp_path / "c", [f"S{T:.0f}" for T in temperatures]))
    (found,) = result.groups
    assert (found.differ, found.confounded) == ((), ("T",))
    assert "can't be told from T" in groups_answer(result.groups)[0].words[0]


def test_a_condition_that_is_the_specimens_own_goes_first(tmp_path):
    said = _drawn()
    density = {"S1": 2.2, "S2": 2.2 + 0.08 * 5, "S3": 2.2 - 0.05 * 5}
    folder = _copy(
        bundled_campaign("clamp_a"), tmp_path / "c", said,
        change=lambda name, force: FACTORS[name] * force, further={"density_g_cm3": [density[name] for name in said]},
    )  # fmt: skip
    (found,) = _fitted(folder)[0].groups
    assert found.explained_by == ("density_g_cm3",)
    assert "left to the effect that follows it" in groups_answer((found,))[0].words[-1]


def test_what_a_specimens_density_does_is_left_to_its_effect_where_it_is_no_line_either(tmp_path):
    """A cube of the density is no line in it: specimens differ beside one, and had been given all of it."""
    said = _drawn()
    density = {"S1": 2.2, "S2": 3.1, "S3": 1.6}
    folder = _copy(
        bundled_campaign("clamp_a"), tmp_path / "c", said,
        change=lambda name, force: (density[name] / 2.2) ** 3 * force,
        further={"density_g_cm3": [density[name] for name in said]},
    )  # fmt: skip
    problem, first = prepare(LAW, loops_of(read_campaign(folder)))
    (found,) = first.groups
    assert "stiffness" in found.differ
    assert found.contrasts.T @ [density[name] for name in found.names] == pytest.approx(0.0, abs=1e-12)
    assert found.contrasts.shape == (3, 1)
    assert judge((), LAW, [first.law.values], problem).lack.share > 3.0


def test_a_run_of_another_specimen_is_told(tmp_path):
    true = _drawn()
    said = true.copy()
    place = true.index("S2", 10)
    said[place] = "S3"
    (found,) = _fitted(_copy(bundled_campaign("clamp_a"), tmp_path / "c", said, true))[0].groups
    (stranger,) = found.strangers
    name = pl.read_csv(bundled_campaign("clamp_a") / "runs.csv")["run"][place]
    assert (stranger.run, stranger.said, stranger.behaves_like) == (name, "S3", "S2")


def test_columns_that_part_the_runs_alike_are_told_as_one(differing):
    """Whatever the alphabetical order of their texts."""
    result, loops, _ = differing
    valve = {"S1": "z", "S2": "y", "S3": "x"}
    rows = (replace(row, labels={**row.labels, "valve": valve[row.labels["specimen"]]}) for row in loops.rows)
    (found,) = find_groups(Loops(tuple(rows), loops.force_average), loop_observations(loops), result.law_force)
    assert (found.column, found.alike) == ("specimen", ("valve",))


def test_runs_that_alone_are_at_their_conditions_are_no_strangers():
    """Nothing tells their scatter; of the others one that is of another group is told all the same."""
    said, alone, other = ["a", "b"] * 15, 18, 25
    levels = np.concatenate([np.ones((30, 1)), np.eye(30)[:, :alone]], axis=1)
    fixed = np.linalg.qr(levels)[0]
    scatter = np.random.default_rng(2).standard_normal(30)
    scatter[:alone] += np.arange(alone)
    differ = np.array([float(name == "b") for name in said])
    near, far = scatter + 3 * differ, scatter + 1000 * differ
    far[other] -= 1000
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert strangest_run(said, ["a", "b"], {"stiffness": near}, fixed, 0.1) is None
        assert strangest_run(said, ["a", "b"], {"stiffness": far}, fixed, 0.1) == (other, "a")


def test_few_runs_pull_a_group_little_away():
    """Partial pooling: of two groups that show the same mean, the one of few runs is told nearer to none."""
    random = np.random.default_rng(0)
    member = np.repeat(np.eye(6), (2, 20, 20, 20, 20, 20), axis=0)
    truth = np.array([0.05, 0.05, 0.0, -0.05, 0.03, -0.08])
    quantity = member @ truth + 0.05 * random.standard_normal(len(member))
    for group in (0, 1):
        rows = member[:, group] > 0
        quantity[rows] += 0.05 - quantity[rows].mean()
    found = mixed(quantity, np.full((len(member), 1), len(member) ** -0.5), member)
    assert abs(found.values.sum()) < 1e-12
    assert found.values[0] < found.values[1]
    assert found.errors[0] > 2 * found.errors[1]


def test_a_left_out_group_of_conditions_doesnt_tell_its_own_factors(differing):
    """What is foretold of left-out runs is what a fit without them foretells, factors of groups included."""
    result, loops, _ = differing
    problem, _ = prepare(LAW, loops, result.law.values)
    observations = problem.observations
    assert observations.factors is not None
    law = fit(LAW, observations, start=result.law.values)
    fitted = whitened(law, observations)
    scores = WithoutGroups(law, observations, problem.coarse, fitted).score(problem.groups)
    own = problem.groups == 0
    # by plain algebra: fit law's steps and factors to all other runs, then foretell
    jacobian = fitted.jacobian[~own].reshape(-1, fitted.jacobian.shape[2])
    scale = np.linalg.norm(jacobian, axis=0)
    size = len(law.fitted)
    precision = np.concatenate([law.precision, observations.factors.precision])
    # the priors' pull at the fit: that of factors is towards none, the law's own is in balance with all runs
    pull = -(fitted.jacobian.reshape(-1, len(precision)).T @ fitted.residual.ravel())
    gradient = jacobian.T @ fitted.residual[~own].ravel() + pull
    normal = (jacobian / scale).T @ (jacobian / scale) + np.diag(precision / scale**2)
    step = -np.linalg.solve(normal, gradient / scale) / scale
    foretold = fitted.residual[own] + fitted.jacobian[own] @ step
    assert size < len(precision)
    np.testing.assert_allclose(scores.squares[own], np.sum(foretold**2, axis=1), rtol=0.02)


def test_a_left_out_specimen_counts_as_the_one_in_the_middle(differing):
    """Nothing is known of it: a law that lacks something errs by that and by what specimens differ."""
    _, loops, _ = differing
    problem, fitted = prepare(Structure("power"), loops)
    law = judge((), Structure("power"), [fitted.law.values], problem)
    assert law.heldout_by["specimen"] < law.heldout_nrmse + np.std(list(FACTORS.values()))


def test_pooling_is_the_covariance_of_noise_and_factors_together(differing):
    """(I + B S B')^-1/2 applied to residuals: their squares are those of generalised least squares."""
    result, loops, _ = differing
    observations = loop_observations(loops)
    factors = factors_of(result.groups, loops, observations)
    assert factors is not None
    pooling = Poolings(observations, factors).beside(result.law_force)
    flat = observations.residual(result.law_force).ravel()
    own = pooling.without(observations.residual(result.law_force)).ravel()
    inner = np.linalg.inv(np.diag(pooling.precision) + pooling.basis.T @ pooling.basis)
    along = pooling.basis.T @ flat
    assert own @ own == pytest.approx(flat @ flat - along @ inner @ along, rel=1e-9)


def test_specimens_put_into_a_measured_campaign_are_found(measured_data, tmp_path):
    """The base law misses most of this damper; its specimens differ all the same, and unchanged ones don't."""
    source = measured_data / "mr_damper"
    drawn = np.random.default_rng(1).permutation(["S1", "S2"] * 15).tolist()
    law = Structure("power", ("condition:current_A",))
    for name, change, told in (
        ("alike", lambda name, force: force, ()),
        ("differing", lambda name, force: force * (1.3 if name == "S2" else 1.0), ("damping",)),
    ):
        loops = loops_of(read_campaign(_copy(source, tmp_path / name, drawn, change=change)))
        found = fit_structure(law, loops).groups
        assert tuple(quantity for one in found for quantity in one.differ if quantity == "damping") == told
