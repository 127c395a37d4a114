"""Levels of conditions: set points that values scatter about, classes where there are none, names."""

from __future__ import annotations

import numpy as np
import pytest

from pipeclamp_identification.signals.levels import CLASSES_OF_MANY, name_levels, number_levels, set_points


def labels(levels):
    return [level.label for level in levels]


def test_values_scatter_about_their_set_points():
    rng = np.random.default_rng(0)
    values = np.repeat([0.2, 0.5, 0.8, 1.0], 12) * (1 + 0.005 * rng.standard_normal(48))
    levels = number_levels(values, relative=0.06)
    assert labels(levels) == ["0.2", "0.5", "0.8", "1"]
    assert [len(level.rows) for level in levels] == [12] * 4
    assert set(levels[2].rows) == set(range(24, 36))


def test_temperatures_are_told_apart_in_kelvin_not_in_percent():
    levels = number_levels(np.array([-1.0, 1.0, 19.0, 21.0, 300.0, 302.0]), absolute=3.0)
    assert [len(level.rows) for level in levels] == [2, 2, 2]
    assert labels(levels) == ["0", "20", "300"]


def test_values_without_set_points_make_classes():
    values = np.linspace(0.1, 1.0, 60)
    levels = number_levels(values, relative=0.06)
    assert len(levels) == CLASSES_OF_MANY
    assert sum(len(level.rows) for level in levels) == 60
    assert labels(levels)[0].startswith("0.1 to ")
    assert levels[-1].high == "1"


def test_set_points_that_lie_close_keep_the_digits_that_tell_them_apart():
    assert labels(number_levels(np.array([2.286, 2.31, 2.4]), relative=0.06, absolute=0.002)) == ["2.29", "2.31", "2.4"]


@pytest.mark.parametrize(
    ("small", "others", "levels"),
    [
        # a coil without current, measured: each run had been a level of its own
        ([-0.032, -0.048, 0.171, -0.029, 0.103, 0.007, -0.133, -0.077, 0.276], [1000.0, 2000.0, 3000.0], 4),
        ([0.31, 0.42, 0.33, 0.65], [1000.0, 2000.0], 3),
        # decades of a frequency, each tested several times or once
        ([0.01, 0.01, 0.03, 0.03], [0.1, 1.0, 10.0, 100.0], 6),
        ([0.01, 0.03, 0.1], None, 6),
    ],
)
def test_values_about_zero_are_one_level(small, others, levels):
    values = np.array([*small, *(np.repeat(others, 3) if others else [1.0, 10.0, 100.0])])
    found = number_levels(values, relative=0.05)
    assert len(found) == levels
    assert len(np.unique(set_points(values))) == levels
    if levels < 6:
        assert found[0].label == "0"
        assert len(found[0].rows) == len(small)


def test_what_is_not_known_comes_last():
    levels = number_levels(np.array([np.nan, 20.0, np.nan, 100.0]), absolute=3.0)
    assert labels(levels) == ["20", "100", "not known"]
    assert list(levels[-1].rows) == [0, 2]
    assert not levels[-1].known
    assert labels(number_levels(np.full(3, np.nan), absolute=3.0)) == ["not known"]


def test_one_value_is_one_level():
    assert labels(number_levels(np.full(5, 3.0), relative=0.06, absolute=0.0)) == ["3"]
    assert labels(number_levels(np.zeros(5), relative=0.06, absolute=0.0)) == ["0"]


def test_names():
    levels = name_levels(["S2", None, "S1", "S2"])
    assert labels(levels) == ["S1", "S2", "not known"]
    assert [list(level.rows) for level in levels] == [[2], [0, 3], [1]]


def test_a_set_point_near_zero_is_told_no_finer_than_others():
    assert labels(number_levels(np.array([-0.166, 0.014, 40.1]), absolute=5.0)) == ["-0.1", "40"]
    assert labels(number_levels(np.array([-0.03, 0.01, 40.1]), absolute=5.0)) == ["0", "40"]


def test_classes_of_many_set_points_hold_whole_ones():
    """Of runs at 5 mm one had been in the class "4.00016 to 5.00023", and the next in "5.00026 to 7"."""
    settings = np.repeat([4.0, 5, 6, 7, 8, 9, 10, 12, 14, 16, 18, 20], 4)
    values = settings * (1 + 1e-4 * np.random.default_rng(2).standard_normal(len(settings)))
    levels = number_levels(values, relative=0.05)
    assert [level.label for level in levels] == ["4 to 5", "6 to 7", "8 to 9", "10 to 12", "14 to 16", "18 to 20"]
    for level in levels:
        assert set(settings[level.rows]) == {float(level.low), float(level.high)}
    assert sorted(np.concatenate([level.rows for level in levels]).tolist()) == list(range(len(values)))
