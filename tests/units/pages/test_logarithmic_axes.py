"""Labels of logarithmic axes: enough of them where a page shows less than a decade."""

import math

import pytest

from pipeclamp.pages.page import FEWEST_LABELS, log_axis


@pytest.mark.parametrize(
    ("low", "high"), [(3.2, 11.0), (0.02, 1.0), (1.0, 5.0), (12.0, 24.0), (0.14, 0.4), (1e-4, 1e4)]
)
def test_an_axis_has_labels_enough_and_not_too_many(low, high):
    axis = log_axis([math.nan, high, 0.0, low])
    shown = [text for value, text in zip(axis["tickvals"], axis["ticktext"], strict=True) if low <= value <= high]
    assert FEWEST_LABELS <= len(shown) <= 25
    assert all(len(text) <= 6 for text in shown)


def test_an_axis_of_decades_keeps_to_few_digits():
    assert log_axis([0.5, 60.0])["ticktext"][:3] == ["1e-06", "2e-06", "5e-06"]
    assert "3" not in log_axis([0.5, 60.0])["ticktext"]


def test_an_axis_of_nothing_is_one():
    assert log_axis([])["type"] == "log"
