"""The page of an import."""

from __future__ import annotations

import numpy as np
import pytest

from pipeclamp.pages.imported import overview_picture
from pipeclamp_identification.importing.plan import Overview


@pytest.mark.parametrize(("runs", "labels"), [(1, []), (2, ["1", "2"])])
def test_runs_of_one_file_are_told_apart_where_it_holds_several(runs, labels):
    """Above the one run of A1_f2_T-10degC.dat there stood -10degC."""
    time = np.linspace(0.0, 10.0, 50)
    spans = tuple((f"A1_f2_T-10degC_{number}", 4.0 * number - 3, 4.0 * number) for number in range(1, runs + 1))
    picture = overview_picture(Overview("A1", time, np.stack([np.sin(time) - 0.1, np.sin(time)], axis=1), spans, ()))
    assert [note.text for note in picture.layout.annotations] == labels


@pytest.mark.parametrize(("timed", "along"), [(True, "t / s"), (False, "in the order measured")])
def test_seconds_that_nobody_measured_are_not_drawn(timed, along):
    """The page of an import with --rate none drew seconds."""
    time = np.linspace(0.0, 10.0, 50)
    shown = Overview("A1", time, np.stack([np.sin(time) - 0.1, np.sin(time)], axis=1), (("A1", 0.0, 9.0),), ())
    axis = overview_picture(shown, timed=timed).layout.xaxis
    assert (axis.title.text, axis.showticklabels) == (along, timed)


def test_a_line_that_falls_is_drawn_without_teeth():
    """Of stretches of one and of two samples, as a record a little longer than its picture has them."""
    least, largest = np.array([[4.0, 4.0], [2.0, 3.0], [1.0, 1.0], [-1.0, 0.0]]).T
    picture = overview_picture(Overview("A1", np.arange(4.0), np.stack([least, largest], axis=1), (), ()))
    assert np.all(np.diff(picture.data[0].y) <= 0)
