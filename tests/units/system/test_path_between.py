"""Where a path of solutions passes a parameter between two of its points."""

import numpy as np
import pytest

from pipeclamp_system.steady.continuation import Equation, Solution, between

STEEP = 20.0


def rounded_step(unknowns, parameter):
    """A step about the path u = p^3, rounded: corrections from farther than 1.39 / STEEP run away."""
    off = np.clip(STEEP * (unknowns - parameter**3), -1e9, 1e9)
    slope = STEEP / (1 + off**2)
    return np.arctan(off), np.diag(slope), -3 * parameter**2 * slope


def test_a_path_is_met_from_its_ends_where_corrections_run_away_between_them():
    """A pipe's response had no state at 5.098 Hz, between two of its points, where a co-simulation then "settled"."""
    found = between(Equation(rounded_step), Solution(0.0, np.zeros(1)), Solution(1.0, np.ones(1)), 0.1)
    assert found == pytest.approx(0.001, rel=1e-6)
