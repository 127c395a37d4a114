"""What a law's loop comes to in the middle of its tests, and how well they determine it there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_identification.loops.energies import loop_energies, metric_slopes, stiffness_of_energy
from pipeclamp_models.base.signals import REFERENCES, signal_in_range
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.file import Interval, LawFile, law_of
from pipeclamp_models.law.range import celsius_tested
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import sinusoids

BY_RATIO = ("A", "f")
"""Conditions whose levels are ratios of each other: their middle is the geometric mean."""


@dataclass(frozen=True)
class LoopInTheMiddle:
    """A law's loop of a sine in the middle of its range.

    Attributes:
        conditions: by their names in the law's range, in its units (T in K).
        dissipated_energy: dW, J.
        stiffness: (Fmax - Fmin)/(2 A), N/mm; Eq. 3 of Symmetry 2020, 12(8), 1283.
        energy_error, stiffness_error: standard errors, by the covariance of the parameters.
    """

    conditions: Mapping[str, float]
    dissipated_energy: float
    energy_error: float
    stiffness: float
    stiffness_error: float


def middle_of_range(file: LawFile) -> dict[str, float]:
    """Give the middle of each condition's range, by its name there, in its unit; of T between whole degrees Celsius."""
    return {name: _middle(name, each) for name, each in file.range.items()}


def _middle(name: str, interval: Interval) -> float:
    if name in BY_RATIO:
        return float(np.sqrt(interval.minimum * interval.maximum))
    if name == "T":
        return CELSIUS + sum(celsius_tested(interval)) / 2
    return (interval.minimum + interval.maximum) / 2


def loop_in_the_middle(file: LawFile) -> LoopInTheMiddle | None:
    """Give a law's loop in the middle of its range; None where its errors aren't known, or it dissipates nothing.

    Single parameters may be known badly where the loop isn't: they stand at 1 mm, 1 Hz and 20 degC, which may lie far
    from all tests.
    """
    told = file.covariance
    if told is None or not told.names:
        return None
    law, conditions = law_of(file), middle_of_range(file)
    motion = sinusoids(conditions["A"], conditions["f"], conditions.get("T", REFERENCES["T_0"]), about=file.about)
    slow = {signal_in_range(name): np.full((1, 1), value) for name, value in conditions.items()}
    motion = replace(motion, slow={**motion.slow, **slow})
    equations = law.equations
    law_force = force_of_equations(equations, law.vector(equations), (law.v_r, law.y_r), motion, derivatives=True)
    places = np.array([equations.names.index(name) for name in told.names])
    slopes = metric_slopes(motion, law_force, places)[:, 0]
    shares = np.sqrt(np.einsum("pm,pq,qm->m", slopes, np.array(told.matrix), slopes))
    (dissipated,), (elastic,) = loop_energies(motion, law_force.force)
    stiffness = stiffness_of_energy(elastic, conditions["A"])
    found = np.array([dissipated, dissipated * shares[0], stiffness, stiffness * shares[1]])
    if not np.all(np.isfinite(found)) or dissipated <= 0:
        return None
    return LoopInTheMiddle(conditions, *found.tolist())
