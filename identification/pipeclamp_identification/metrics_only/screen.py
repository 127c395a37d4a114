"""What loop metrics can show of an effect at all, and what one step of least squares promises of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pipeclamp_identification.fitting.joint.not_fitted import ONE_AMPLITUDE, undetermined, varies_in_amplitude
from pipeclamp_identification.fitting.joint.points import starting_points
from pipeclamp_identification.loops.energies import metric_slopes
from pipeclamp_identification.metrics_only.evidence import MetricJudged, fewest_numbers, orthonormal_directions
from pipeclamp_identification.metrics_only.observations import MetricObservations
from pipeclamp_identification.metrics_only.thresholds import IMITATED_SHARE, UNSEEN_SHARE
from pipeclamp_models.base.arrays import Array, BoolArray, IntArray
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.law import Equations, Law, with_effect
from pipeclamp_models.realise.force import force_of_equations, known_jacobian


@dataclass(frozen=True)
class Look:
    """An effect as metrics see it.

    Attributes:
        name: the effect.
        hidden: why metrics can't show it; empty where they can.
        imitated: whether the law's own parameters, as they are, could do what it does.
        promise: by how much one step from its best start lowers the sum of squares.
    """

    name: str
    hidden: str
    imitated: bool
    promise: float


def look(law: MetricJudged, observations: MetricObservations, name: str) -> Look:
    """Look at an effect beside a law.

    Args:
        law: the law, fitted.
        observations: what it was fitted to.
        name: the effect.
    """
    try:
        larger = with_effect(law.structure, name)
        starts = starting_points(larger, observations, law.result.law.values)
    except UserError as error:
        return _hidden(name, str(error).removeprefix(f"effect {name!r} "))
    if larger.effect(name).is_elastic and not varies_in_amplitude(observations):
        return _hidden(name, ONE_AMPLITUDE)
    equations = larger.equations
    reasons = undetermined(equations, observations)
    own = set(law.result.equations.names)
    added = [parameter for parameter in equations.names if parameter not in own]
    if all(parameter in reasons for parameter in added):
        return _hidden(name, reasons[added[0]])
    numbers, fitted = fewest_numbers(observations), len(set(equations.names) - set(larger.held()) - set(reasons))
    if fitted > numbers:
        few = f"with it the law has {fitted} parameters, and {numbers} numbers are there where conditions are left out"
        return _hidden(name, few)
    wanted = {*law.result.fitted, *(parameter for parameter in added if parameter not in reasons)}
    free = np.array([place for place, parameter in enumerate(equations.names) if parameter in wanted], dtype=np.intp)
    new = np.array([equations.names[place] not in own for place in free])
    steps = [_first_step(equations, start, law.result.law, observations, free, new) for start in starts]
    hidden = "" if any(step.seen for step in steps) else "dW and W hardly change with it: only a recorded loop shows it"
    imitated = not any(step.apart for step in steps)
    return Look(name, hidden, imitated, law.squares - min(step.squares for step in steps))


def _hidden(name: str, why: str) -> Look:
    return Look(name, why, False, 0.0)


class _Step(NamedTuple):
    """One step of least squares from a start: the sum of squares after it; whether the metrics see what the effect does
    to the force, and whether that is apart from what the law's own parameters do."""

    squares: float
    seen: bool
    apart: bool


def _first_step(
    equations: Equations, start: Mapping[str, float], law: Law, observations: MetricObservations, free: IntArray,
    new: BoolArray,
) -> _Step:  # fmt: skip
    """Take one step of least squares from a start.

    Args:
        equations: of the law with the effect.
        start: values of all its parameters, by name.
        law: without the effect.
        observations: the metrics.
        free: places of the parameters that are fitted, (P,).
        new: which of them the effect brings, (P,).
    """
    values = tuple(start[parameter] for parameter in equations.names)
    law_force = force_of_equations(equations, values, (law.v_r, law.y_r), observations.motion, derivatives=True)
    slopes = metric_slopes(observations.motion, law_force, free)
    weighted = np.moveaxis(slopes / observations.relative_error, 0, -1).reshape(-1, len(free))
    weighted = np.nan_to_num(weighted)
    size = np.sqrt(np.mean(law_force.force**2))
    in_force = np.sqrt(np.mean(known_jacobian(law_force).of(free) ** 2, axis=(1, 2)))[new] / size
    in_metrics = np.sqrt(np.mean(slopes**2, axis=(1, 2)))[new]
    basis = orthonormal_directions(weighted[:, ~new])
    beyond = weighted[:, new] - basis @ (basis.T @ weighted[:, new])
    apart = bool(np.any(_norms(beyond) > IMITATED_SHARE * _norms(weighted[:, new])))
    residual = np.nan_to_num(observations.residual(law_force)).ravel()
    left = residual - basis @ (basis.T @ residual)
    gain = float(np.sum((orthonormal_directions(beyond).T @ left) ** 2)) if apart else 0.0
    return _Step(float(left @ left) - gain, bool(np.any(in_metrics > UNSEEN_SHARE * in_force)), apart)


def _norms(columns: Array) -> Array:
    return np.asarray(np.linalg.norm(columns, axis=0))
