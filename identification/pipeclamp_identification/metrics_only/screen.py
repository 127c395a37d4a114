"""What loop metrics can show of an effect at all, and what one step of least squares promises of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.fitting.joint.not_fitted import ONE_AMPLITUDE, undetermined, varies_in_amplitude
from pipeclamp_identification.fitting.joint.points import starting_points
from pipeclamp_identification.metrics_only.evidence import MetricJudged, directions, fewest_numbers
from pipeclamp_identification.metrics_only.observations import MetricObservations, metric_slopes
from pipeclamp_identification.metrics_only.thresholds import IMITATED_SHARE, UNSEEN_SHARE
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.law import with_effect
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


def look(law: MetricJudged, name: str, observations: MetricObservations) -> Look:
    """Look at an effect beside a law.

    Args:
        law: the law, fitted.
        name: the effect.
        observations: what it was fitted to.
    """
    try:
        larger = with_effect(law.structure, name)
        starts = starting_points(larger, observations, law.result.law.values)
    except UserError as error:
        return Look(name, str(error).removeprefix(f"effect {name!r} "), False, 0.0)
    if larger.effect(name).is_elastic and not varies_in_amplitude(observations):
        return Look(name, ONE_AMPLITUDE, False, 0.0)
    equations = larger.equations
    reasons = undetermined(equations, observations)
    own = set(law.result.equations.names)
    added = [parameter for parameter in equations.names if parameter not in own]
    if all(parameter in reasons for parameter in added):
        return Look(name, reasons[added[0]], False, 0.0)
    wanted = {*law.result.fitted, *(parameter for parameter in added if parameter not in reasons)}
    numbers, fitted = fewest_numbers(observations), len(set(equations.names) - set(larger.held()) - set(reasons))
    if fitted > numbers:
        few = f"with it the law has {fitted} parameters, and {numbers} numbers are there where conditions are left out"
        return Look(name, few, False, 0.0)
    free = np.array([place for place, parameter in enumerate(equations.names) if parameter in wanted], dtype=np.intp)
    new = np.array([equations.names[place] not in own for place in free])
    smooth = law.result.law.v_r, law.result.law.y_r
    looks = []
    for start in starts:
        values = tuple(start[parameter] for parameter in equations.names)
        law_force = force_of_equations(equations, values, smooth, observations.motion, derivatives=True)
        slopes = metric_slopes(observations.motion, law_force, free)
        weighted = np.moveaxis(slopes / observations.relative_error, 0, -1).reshape(-1, len(free))
        weighted = np.nan_to_num(weighted)
        size = np.sqrt(np.mean(law_force.force**2))
        in_force = np.sqrt(np.mean(known_jacobian(law_force).of(free) ** 2, axis=(1, 2)))[new] / size
        in_metrics = np.sqrt(np.mean(slopes**2, axis=(1, 2)))[new]
        seen = bool(np.any(in_metrics > UNSEEN_SHARE * in_force))
        basis = directions(weighted[:, ~new])
        beyond = weighted[:, new] - basis @ (basis.T @ weighted[:, new])
        apart = bool(np.any(_norms(beyond) > IMITATED_SHARE * _norms(weighted[:, new])))
        residual = np.nan_to_num(observations.residual(law_force)).ravel()
        left = residual - basis @ (basis.T @ residual)
        gain = float(np.sum((directions(beyond).T @ left) ** 2)) if apart else 0.0
        looks.append((float(left @ left) - gain, seen, apart))
    seen = any(seen for _, seen, _ in looks)
    hidden = "" if seen else "dW and W hardly change with it: only a recorded loop shows it"
    imitated = not any(apart for _, _, apart in looks)
    return Look(name, hidden, imitated, law.squares - min(cost for cost, _, _ in looks))


def _norms(columns: Array) -> Array:
    return np.asarray(np.linalg.norm(columns, axis=0))
