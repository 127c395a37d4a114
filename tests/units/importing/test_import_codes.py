"""Numbers that a logger writes for none are taken out before runs are told apart, and nothing else is."""

import numpy as np
import pytest

from pipeclamp import import_files
from pipeclamp_identification.importing.samples.codes import without_codes

RATE, SECONDS, FREQUENCY = 400.0, 8.0, 2.0
TIME = np.arange(int(RATE * SECONDS)) / RATE
RNG = np.random.default_rng(4)
MOTION = 0.5 * np.sin(2 * np.pi * FREQUENCY * TIME) + RNG.normal(0, 2e-4, len(TIME))
FORCE = 900.0 * MOTION + 60.0 * np.sign(np.gradient(MOTION)) + RNG.normal(0, 2.0, len(TIME))


def with_rows(values, rows, number):
    changed = values.copy()
    changed[rows] = number
    return changed


@pytest.mark.parametrize(
    ("rows", "number"),
    [
        (slice(1000, 1005), 32767.0),
        (slice(1000, 1002), -9999.0),
        (slice(1000, 1300), 9.99e37),
        ([10, 900, 1701], 1e6),
        (1500, 1e300),
    ],
)
def test_a_number_that_stands_for_none_is_taken_as_blank(rows, number):
    found, (words,) = without_codes("displacement_mm", with_rows(MOTION, rows, number))
    expected = with_rows(MOTION, rows, np.nan)
    assert np.array_equal(found, expected, equal_nan=True)
    count = np.count_nonzero(np.isnan(expected))
    assert words.startswith(f"displacement_mm is {number:g} in {count} sample{'s' if count > 1 else ''}, far off")


def test_two_such_numbers_are_both_told():
    found, words = without_codes("force_N", with_rows(with_rows(FORCE, [7, 8], -9999.0), [70, 80], 32767.0))
    assert np.flatnonzero(np.isnan(found)).tolist() == [7, 8, 70, 80]
    assert len(words) == 2


@pytest.mark.parametrize(
    "values",
    [
        MOTION,
        np.clip(FORCE, -300.0, 300.0),  # the end of a sensor's range
        np.round(MOTION, 1),
        with_rows(MOTION, 1500, 40.0),  # a spike is taken out later, as one
        np.where(TIME < 2.0, 0.0, MOTION + 20.0),  # it rests, far off, for a quarter of the time
        np.zeros(100),
        np.where(TIME < 4.0, 0.0, 5.0),
        np.full(50, np.nan),
    ],
)
def test_what_was_measured_stays(values):
    found, words = without_codes("force_N", values)
    assert np.array_equal(found, values, equal_nan=True)
    assert words == ()


def test_such_numbers_make_no_free_motion_of_a_sine(tmp_path):
    y = with_rows(MOTION, slice(1000, 1005), 32767.0)
    rows = "".join(f"{t:.4f},{a:.5f},{F:.3f}\n" for t, a, F in zip(TIME, y, FORCE, strict=True))
    (tmp_path / "a.csv").write_text("Time [s],Position [mm],Load [N]\n" + rows)
    found = import_files([tmp_path / "a.csv"], tmp_path / "tests")
    (run,) = found.to_dict()["runs"]
    assert run["frequency_Hz"] == pytest.approx(FREQUENCY, rel=1e-3)
    assert run["amplitude_mm"] == pytest.approx(0.5, rel=0.01)
    assert any("displacement_mm is 32767 in 5 samples" in words for words in run["done"])
