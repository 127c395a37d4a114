"""Cells of a record: a factor shows as amplitude and phase, noise as its own size, and neither as the other."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipeclamp_identification.attribution.noise import MODEL_ERROR, TRUSTED_SHARE
from pipeclamp_identification.attribution.record_evidence import LINES, RecordEvidence, cells_of
from pipeclamp_identification.on_pipe.measurement import ProbeTable
from pipeclamp_identification.on_pipe.record_files import MotionRecord
from pipeclamp_identification.on_pipe.record_motion import RecordPrediction

TIME = np.arange(4000) / 200
LOW, HIGH = 4.0, 16.0


def motion(seed: int = 1) -> np.ndarray:
    """Give random motion between 4 and 16 Hz at two probes, (n, 2)."""
    rng = np.random.default_rng(seed)
    f = rng.uniform(LOW, HIGH, (300, 1, 2))
    return np.sin(2 * np.pi * f * TIME[:, None] + rng.uniform(0, 6.28, f.shape)).sum(axis=0)


def evidence(measured: np.ndarray) -> RecordEvidence:
    probes = tuple(ProbeTable(name=name, position_m=1.0, unit="mm") for name in "ab")
    record = MotionRecord(Path("a.csv"), "a.csv", None, probes, TIME, "force_N", TIME, measured)
    return RecordEvidence.begun(record, LOW, HIGH)


def test_a_record_is_cut_into_cells_that_cover_its_motion():
    found = evidence(motion())
    cells = found.cells
    per_hertz = cells.samples / 200
    assert cells.parts > 1
    assert cells.first / per_hertz == pytest.approx(LOW, abs=1 / per_hertz)
    assert (cells.first + LINES * cells.bands) / per_hertz == pytest.approx(HIGH, abs=LINES / per_hertz)
    # far fewer values than samples
    assert found.residual(RecordPrediction(motion(), ())).size < motion().size / 10
    assert set(found.blocks(5)) == set(range(5))


def test_a_tone_has_one_cell_a_part():
    record = MotionRecord(Path("a.csv"), "a.csv", None, (), TIME, "force_N", TIME, motion())
    assert cells_of(record, 8.0, 8.01).parts == 1
    assert cells_of(record, 8.0, 8.01).bands == 1


def test_a_sensor_that_reads_too_high_errs_in_amplitude():
    computed = motion()
    found = evidence(1.05 * computed).renewed(RecordPrediction(computed, ()))
    real, imaginary = np.split(found.residual(RecordPrediction(computed, ())), 2)
    assert np.all(real > 5.0)
    assert np.abs(imaginary).max() < 1e-6
    coarse = found.coarse_residual(RecordPrediction(computed, ()))
    assert coarse == pytest.approx(np.log(1.05), rel=0.2)


def test_noise_is_told_from_what_is_incoherent_and_leaves_residuals_of_its_size():
    computed = motion()
    rng = np.random.default_rng(2)
    measured = computed + 0.2 * np.std(computed) * rng.standard_normal(computed.shape)
    found = evidence(measured).renewed(RecordPrediction(computed, ()))
    residual = found.residual(RecordPrediction(computed, ()))
    assert np.sqrt(np.mean(residual**2)) == pytest.approx(1.0, rel=0.15)
    assert abs(np.mean(residual)) < 4 / np.sqrt(residual.size)


def test_a_model_is_not_held_to_more_than_it_can_do():
    computed = motion()
    found = evidence(computed).renewed(RecordPrediction(computed, ()))
    size = np.sqrt(np.sum(np.abs(found.measured) ** 2, axis=2))
    least = np.hypot(MODEL_ERROR * size, TRUSTED_SHARE * size.max(axis=(0, 1)))
    assert found.noise[found.used] == pytest.approx(least[found.used])
