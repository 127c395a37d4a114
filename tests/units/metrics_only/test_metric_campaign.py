"""Campaigns of metrics without records: what is read, what is refused, and what writing and reading keeps."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_identification.metrics_only.campaign import metric_observations
from pipeclamp_identification.metrics_only.evidence import distinct_conditions
from pipeclamp_identification.metrics_only.verdict import _tested_once
from pipeclamp_identification.metrics_only.writing import as_metrics, metric_files, write_metrics
from pipeclamp_identification.workflow.on_metrics import MetricTests
from pipeclamp_identification.workflow.reading import read_tests
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import write_folder
from pipeclamp_models.law.law import Structure, smoothing
from pipeclamp_models.realise.force import force_of_equations

HEADER = "run,amplitude_mm,frequency_Hz,temperature_C,dissipated_energy_J,max_elastic_energy_J\n"
ROW = "A,0.8,3,20,0.9696,0.6318\n"


@pytest.fixture
def tests_of(campaign_folder):
    def read(table, strict=False):
        tests = read_tests(campaign_folder(table=table, records={}), strict)
        assert isinstance(tests, MetricTests)
        return tests.campaign

    return read


def test_a_row_without_a_record_is_known_by_its_metrics(tests_of):
    tests = tests_of(HEADER + ROW)
    run = tests.runs[0]
    assert (run.dissipated_energy_J, run.max_elastic_energy_J) == (0.9696, 0.6318)
    assert run.loss_factor == pytest.approx(0.2442, abs=1e-4)
    assert run.stiffness == pytest.approx(2e3 * 0.6318 / 0.64)
    assert run.rounding == pytest.approx((1e-4 / math.sqrt(12) / 0.9696, 1e-4 / math.sqrt(12) / 0.6318))


@pytest.mark.parametrize(
    "table",
    [
        "run,file,amplitude_mm,frequency_Hz,loss_factor,stiffness_N_mm\nA,,0.8,3,0.24425,1974.375\n",
        "run,amplitude_mm,frequency_Hz,dissipated_energy_J,loss_factor\nA,0.8,3,0.9696,0.24425\n",
        "run,amplitude_mm,frequency_Hz,dissipated_energy_J,stiffness_N_mm\nA,0.8,3,0.9696,1974.375\n",
    ],
    ids=["eta-and-k", "dW-and-eta", "dW-and-k"],
)
def test_any_two_metrics_give_both_energies(tests_of, table):
    run = tests_of(table).runs[0]
    assert run.dissipated_energy_J == pytest.approx(0.9696, rel=1e-4)
    assert run.max_elastic_energy_J == pytest.approx(0.6318, rel=1e-4)


def test_storage_and_loss_stiffness_give_both_energies(tests_of):
    """A sine's force is k' X0 in phase and k'' X0 out of it; its largest is neither's."""
    table = "run,amplitude_mm,frequency_Hz,storage_stiffness_N_mm,loss_stiffness_N_mm\nA,0.8,3,300,400\nB,0.8,3,300,\n"
    tests = tests_of(table)
    run = tests.runs[0]
    assert run.stiffness == pytest.approx(500)
    assert run.dissipated_energy_J == pytest.approx(math.pi * 400 * 0.64e-3)
    assert run.loss_factor == pytest.approx(0.8)
    assert [one.run for one in tests.left_out] == ["B"]


def test_storage_and_loss_stiffness_that_energies_contradict_are_refused(tests_of):
    table = (
        "run,amplitude_mm,frequency_Hz,storage_stiffness_N_mm,loss_stiffness_N_mm,loss_factor\nA,0.8,3,300,400,1.33\n"
    )
    with pytest.raises(UserError, match=r"'loss_factor': got 1\.33"):
        tests_of(table)


def test_energies_that_no_loop_has_are_left_out_and_told(tests_of):
    tests = tests_of(HEADER + ROW + "B,0.8,3,20,8.050,1.000\nC,0.8,4,20,9.300,1.000\n")
    assert [run.name for run in tests.runs] == ["A", "B"]
    assert "dW is 9.3 times its W" in tests.left_out[0].reason
    assert "storage_stiffness_N_mm" in tests.left_out[0].reason


def test_the_same_measurement_is_counted_once(tests_of):
    tests = tests_of(HEADER + ROW + ROW.replace("A", "B") + "C,0.8,3,20,0.9690,0.6320\n")
    assert [run.name for run in tests.runs] == ["A", "C"]
    assert "run 'B' is left out" in str(tests.left_out[0])


@pytest.mark.parametrize(
    ("row", "reason"),
    [("B,,3,20,0.9,0.6\n", "amplitude_mm"), ("B,0.5,3,20,,0.6\n", "dissipated"), ("B,0.5,3,20,0.9,\n", "elastic")],
)
def test_a_row_that_lacks_something_is_left_out(tests_of, row, reason):
    tests = tests_of(HEADER + ROW + row)
    assert len(tests.runs) == 1
    assert reason in tests.left_out[0].reason


def test_strict_refuses_it(tests_of):
    with pytest.raises(UserError, match="run 'B'"):
        tests_of(HEADER + ROW + "B,0.5,3,20,0.9,\n", strict=True)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("run,amplitude_mm,frequency_Hz,dissipated_energy_J\nA,0.8,3,0.9\n", ["_energy_J only", "expected two"]),
        ("run,amplitude_mm,frequency_Hz,max_elastic_energy_J,stiffness_N_mm\nA,0.8,3,0.6318,1974\n", ["expected two"]),
        (HEADER + "A,0.8,3,20,-0.9,0.6\n", ["row 2", "'dissipated_energy_J'", "'-0.9'", "above 0 J"]),
        (HEADER + "A,0.8,3,20,nan,0.6\n", ["row 2", "'nan'"]),
        (HEADER + "A,0.8,3,20,0.9,inf\n", ["row 2", "'max_elastic_energy_J'", "'inf'"]),
        (HEADER.replace("_J\n", "_mJ\n") + ROW, ["'max_elastic_energy_mJ'", "'max_elastic_energy_J'"]),
        (
            "run,file,amplitude_mm,frequency_Hz,dissipated_energy_J,max_elastic_energy_J\n"
            "A,runs/A.csv,0.8,3,0.9,0.6\nB,,0.5,3,0.5,0.2\n",
            ["row 3", "'file'", "row 2 has a record", "pipeclamp metrics -o"],
        ),
        (
            HEADER.replace("\n", ",loss_factor\n") + ROW.replace("\n", ",24.42\n"),
            ["row 2", "'loss_factor'", "24.42", "0.2442"],
        ),
    ],
    ids=["dW-only", "W-twice", "negative", "nan", "infinite", "other-unit", "mixed", "disagree"],
)  # fmt: skip
def test_what_is_refused(tests_of, table, words):
    with pytest.raises(UserError) as refused:
        tests_of(table)
    for word in words:
        assert word in str(refused.value)


def test_a_force_beyond_all_numbers_ends_no_fit(tests_of):
    """A stop's fit to an elastomer's metrics had ended in a traceback, others in warnings of NumPy's."""
    observations = metric_observations(tests_of(HEADER + ROW))
    equations = Structure().equations
    values = np.array([1e4 if name == "alpha0" else 1.0 for name in equations.names])
    with np.errstate(over="ignore", invalid="ignore"):
        motion = observations.motion
        beyond = force_of_equations(equations, values, smoothing(0.8, 3.0), motion, derivatives=True)
        assert not np.all(np.isfinite(beyond.force))
        free = np.arange(len(values))
        assert np.all(np.isfinite(observations.as_shares().residual_slopes(beyond, free)))
    with np.errstate(divide="raise", invalid="ignore"):
        assert np.all(np.isnan(observations.logs(np.where(observations.motion.y > 0, np.inf, -np.inf))))


@pytest.mark.parametrize(("apart", "told"), [(0.02, ()), (30.0, ("T",))])
def test_temperatures_as_they_were_measured_are_one_where_they_scatter(tests_of, apart, told):
    """An analyser's 16 rows at 40.00 to 40.02 °C had each been a temperature that was tested once."""
    rows = [f"{n},0.8,{1.3**n:.4g},{20 + apart * n},0.96,0.63\n" for n in range(6)]
    structure = Structure(effects=("damping_temperature",))
    result = SimpleNamespace(equations=structure.equations)
    judged = SimpleNamespace(effects=structure.effects, result=result)
    assert _tested_once(judged, metric_observations(tests_of(HEADER + "".join(rows)))) == told


@pytest.mark.parametrize(
    ("settings", "conditions"),
    [
        ([(A, f, T) for A in (0.4, 0.8) for f in (1.0, 3.0) for T in (20.0, 200.0)], 8),
        ([(0.4 * 1.1**n, 1.0, 20.0) for n in range(8)], 8),
        ([(0.4, 1.0, 20.0)], 8),
    ],
    ids=["a grid", "levels", "a load for ever"],
)
def test_repeats_are_at_one_condition_though_drives_miss_it(tests_of, settings, conditions):
    """Of three repeats each had been left out by itself, with two of its like among those that foretold it."""
    rng = np.random.default_rng(1)
    repeats = 24 // len(settings) if len(settings) > 1 else conditions
    rows = [
        f"{A * (1 + 0.004 * rng.standard_normal()):.6g},{f * (1 + 1e-3 * rng.standard_normal()):.6g},"
        f"{T + 0.5 * rng.standard_normal():.5g},{0.9 + 0.01 * rng.random():.6g},0.63,{10 ** (n / 4):.6g}\n"
        for n, (A, f, T) in enumerate(settings * repeats)
    ]
    table = HEADER.rstrip() + ",first_cycle\n" + "".join(f"r{n},{row}" for n, row in enumerate(rows))
    groups = distinct_conditions(metric_observations(tests_of(table)))
    assert groups.max() + 1 == conditions
    if len(settings) > 1:
        assert len(np.unique(groups.reshape(repeats, -1), axis=0)) == 1


def test_temperature_for_some_runs_only_is_refused(tests_of):
    with pytest.raises(UserError, match="1 of 2 runs only"):
        metric_observations(tests_of(HEADER + ROW + "B,0.5,3,,0.5,0.25\n"))


def test_metric_columns_beside_records_are_no_conditions(campaign_folder):
    folder = campaign_folder(table="run,file,dissipated_energy_J,current_A\nA,runs/A.csv,x,1\n")
    assert read_campaign(folder).condition_columns == ("current_A",)


def test_records_are_needed_where_loops_are(campaign_folder):
    with pytest.raises(UserError, match="without records"):
        read_campaign(campaign_folder(table=HEADER + ROW, records={}))


def test_written_metrics_are_read_back(run_of, campaign_of, harmonic_record, tmp_path):
    tests = campaign_of(run_of(harmonic_record(), "A", temperature_C=20.0, conditions={"current_A": 1.5}))
    bare = as_metrics(tests, loops_of(tests))
    write_folder(tmp_path / "bare", metric_files(bare))
    again = read_tests(tmp_path / "bare").metrics()
    assert again.condition_columns == ("current_A",)
    one, other = bare.runs[0], again.runs[0]
    assert other.setup == one.setup
    for name in ("amplitude_mm", "frequency_Hz", "dissipated_energy_J", "max_elastic_energy_J"):
        assert getattr(other, name) == getattr(one, name)
    assert one.dissipated_energy_J == pytest.approx(math.pi * 0.8 * 400.0 / 1e3, rel=1e-5)


def test_loops_that_make_energy_are_left_out_of_what_is_written(harmonic_record, run_of, campaign_of, tmp_path):
    """They had been written, and the campaign couldn't be read."""
    loss = (0.0, 2000.0 + 400.0j), (0.0, 2000.0 - 40.0j)
    runs = [run_of(harmonic_record(force=one), name) for one, name in zip(loss, ("A", "B"), strict=True)]
    tests = campaign_of(*runs)
    metrics = as_metrics(tests, loops_of(tests))
    (left_out,) = write_metrics(tmp_path / "metrics", metrics)
    assert str(left_out).startswith("run 'B' is left out: its loop makes energy: dW is -0.1")
    read = read_tests(tmp_path / "metrics").campaign
    assert ([run.name for run in read.runs], read.notes) == (["A"], "Left out, for their loops make energy: B.")
    none = campaign_of(runs[1])
    with pytest.raises(UserError, match="all its loops make energy"):
        write_metrics(tmp_path / "none", as_metrics(none, loops_of(none)))
    assert not (tmp_path / "none").exists()
