"""The studio's map: what its panels are levels of."""

import numpy as np

from pipeclamp.studio.error_map import error_map
from pipeclamp_identification.comparison.conditions import Condition
from pipeclamp_identification.signals.levels import Level

RUNS = ("a", "b", "c", "d")


def condition(key, *rows):
    levels = (Level(str(place), place, place, np.array(level)) for place, level in enumerate(rows))
    return Condition(key, key, "", tuple(levels))


A, F = condition("A", [0, 1], [2, 3]), condition("f", [0, 1, 2, 3])


def test_panels_are_levels_that_hold_several_runs():
    """A protocol of one block an amplitude had a panel for each block: eight panels with one cell each."""
    before = condition("first_cycle", [0], [1], [2], [3])
    shown = error_map(RUNS, (A, F, before), None)
    assert (shown.by, shown.choices, len(shown.panels)) == ("", (), 1)
    assert [cell.runs for row in shown.panels[0].rows for cell in row] == [("c", "d"), ("a", "b")]


def test_panels_are_levels_of_what_sorts_runs():
    bolt = condition("bolt_torque_Nm", [0, 2], [1, 3])
    shown = error_map(RUNS, (A, F, bolt), None)
    assert (shown.by, len(shown.panels)) == ("bolt_torque_Nm", 2)
