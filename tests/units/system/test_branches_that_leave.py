"""Branches that leave a curve of symmetric motions, on an equation whose branches are known in closed form."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.continuation import Equation, Evaluated, Solution, Work
from pipeclamp_system.steady.detached import leaving_branches, meeting

FIRST, LAST = 5.0, 5.6
LOW, HIGH = 5.16, 5.404
TURNS_BACK = 2500.0
"""Symmetric motions are unstable from LOW to HIGH; the branch leaves that range by this, and turns back into it."""


class Pitchforks(SteadySystem):
    """One clamp whose fundamental is 1 mm at all frequencies, and whose mean m is 0 or solves
    (f - LOW)(f - HIGH) = m^2 - TURNS_BACK m^4."""

    def __init__(self) -> None:
        self._clamps = [None]
        self.work = Work()

    def over_frequency(self) -> Equation:
        def equation(unknowns, frequency):
            mean, cosine, sine = unknowns
            off = (frequency - LOW) * (frequency - HIGH) - mean**2 + TURNS_BACK * mean**4
            by_mean = off + mean * (4 * TURNS_BACK * mean**3 - 2 * mean)
            return Evaluated(
                np.array([mean * off, cosine - 1, sine]),
                np.diag([by_mean, 1.0, 1.0]),
                np.array([mean * (2 * frequency - LOW - HIGH), 0.0, 0.0]),
            )

        return Equation(equation)

    def state(self, unknowns, frequency, side=0):
        return SimpleNamespace(
            frequency=frequency, balanced=self.unpacked(unknowns[None])[0], side=side, mean=unknowns[0]
        )


def curve(system, beyond):
    """The symmetric motions at frequencies of which some lie so far beyond LOW and HIGH, with their sides."""
    told = [
        (5.1, 1),
        (LOW - beyond, 1),
        (LOW + 1.3e-3, -1),
        (5.28, -1),
        (HIGH - 1.3e-3, -1),
        (HIGH + beyond, 1),
        (5.5, 1),
    ]
    return [system.state(np.array([0.0, 1.0, 0.0]), frequency, side) for frequency, side in told]


def off_the_branch(frequencies, means):
    return (frequencies - LOW) * (frequencies - HIGH) - means**2 + TURNS_BACK * means**4


@pytest.mark.parametrize("beyond", [1e-6, 1e-5, 1e-3])
def test_a_branch_that_leaves_a_curve_and_comes_back_to_it_is_one_and_ends_there(beyond):
    """Its end lies beyond the two states between which it meets the curve, across it or on it: it was followed twice,
    and went on along the curve."""
    system = Pitchforks()
    (branch,) = leaving_branches(system, [curve(system, beyond)], FIRST, LAST)
    frequencies, means = np.array([(state.frequency, state.mean) for state in branch[1:-1]]).T
    assert np.all(means > 0) or np.all(means < 0)
    assert np.abs(off_the_branch(frequencies, means)).max() < 1e-6
    assert means.max() - means.min() > 0.04


def test_where_a_branch_meets_symmetric_motions_is_told_by_its_last_points():
    system = Pitchforks()
    points = []
    for mean in (-3e-3, 1e-3, 4e-3):  # the end is the mirror image of a motion of the branch
        off = mean**2 - TURNS_BACK * mean**4
        frequency = (LOW + HIGH) / 2 + np.sqrt(((HIGH - LOW) / 2) ** 2 + off)
        points.append(Solution(frequency, np.array([mean, 1.0, 0.0])))
    assert points[0].parameter - HIGH > 3e-5
    met = meeting(system, points)
    assert met.parameter == pytest.approx(HIGH, abs=2e-7)
    assert met.unknowns == pytest.approx([0.0, 1.0, 0.0], abs=1e-12)
