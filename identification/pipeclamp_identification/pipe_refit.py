"""Refits of a coupled model to a measurement: parameters that may be wrong, by Gauss-Newton, in units of the noise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from pipeclamp.errors import UserError
from pipeclamp_identification.pipe_comparison import turned_error
from pipeclamp_identification.pipe_measurement import PipeMeasurement
from pipeclamp_identification.pipe_model import CoupledModel, Prediction, predict
from pipeclamp_identification.pipe_suspects import Suspect, Values

Array = NDArray[np.float64]

NUDGE = 3e-3
"""Of a parameter's smallest start, or of itself: by so much it is moved for a derivative."""
SETTLED = 1e-3
"""A refit is done when the squared error, or the parameters, change by less than this share."""
MOST_EVALUATIONS = 25
CLOSE = 0.15
"""Rms of the coarse residual below which the model as stated is a good enough start."""
ROUGHLY = 0.02
MOST_ROUGH = 8
"""Likewise, of the first approach on the coarse residual."""
BURIED = 10.0
"""A response of fewer times its noise counts little in a first approach."""


@dataclass(frozen=True, eq=False)
class Task:
    """What refits are fitted to.

    Attributes:
        measurement: what was measured.
        model: as stated, with mounts.
        prediction: what it says.
        noise: standard deviation of real and of imaginary part of each response, (P, probes).
    """

    measurement: PipeMeasurement
    model: CoupledModel
    prediction: Prediction
    noise: Array

    def residual(self, prediction: Prediction) -> Array:
        """Give measured less computed over the noise; not finite where a steady state is missing that was there."""
        error = turned_error(self.measurement, prediction.response) / self.noise
        return self.flat(error.real, error.imag)

    def flat(self, real: Array, imaginary: Array) -> Array:
        """Give what belongs to real and to imaginary parts, (P, probes) each, in the order of the residual, (n,)."""
        steady = self.measurement.steady
        compared = np.isfinite(steady.response) & np.isfinite(self.prediction.response)
        return np.concatenate([real[compared], imaginary[compared & steady.phased]])

    def coarse_residual(self, prediction: Prediction) -> Array:
        """Give the logarithm of measured over computed response where `residual` gives their difference.

        A resonance that is moved by several times its width changes it steadily, where differences have many valleys.
        """
        steady = self.measurement.steady
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.log(steady.response / prediction.response)
            above_noise = np.abs(steady.response) / (np.abs(steady.response) + BURIED * self.noise)
        ratio *= above_noise
        return self.flat(ratio.real, ratio.imag)


@dataclass(frozen=True, eq=False)
class Refit:
    """A model with some parameters refitted.

    Attributes:
        suspects: what was refitted; none for the model as stated.
        values: of all parameters, in the suspects' order.
        prediction: what the refitted model says.
        residual: over the noise, (n,).
        jacobian: of the residual by the values, (n, parameters).
    """

    suspects: tuple[Suspect, ...]
    values: Values
    prediction: Prediction
    residual: Array
    jacobian: Array

    @property
    def squared(self) -> float:
        """Sum of squares of the residual."""
        return float(self.residual @ self.residual)

    def values_of(self, suspect: Suspect) -> Values:
        """Give the values of one suspect."""
        return self.values[_places(self.suspects)[suspect.id]]

    def errors_of(self, suspect: Suspect, overdispersion: float = 1.0) -> Values:
        """Give the standard errors of one suspect's values; what the data can't tell has a large one."""
        information = self.jacobian.T @ self.jacobian
        covariance = overdispersion * np.linalg.pinv(information, hermitian=True)
        return tuple(np.sqrt(np.maximum(np.diag(covariance), 0.0)).tolist())[_places(self.suspects)[suspect.id]]


def as_stated(task: Task) -> Refit:
    """Give the model as it is stated."""
    residual = task.residual(task.prediction)
    return Refit((), (), task.prediction, residual, np.zeros((residual.size, 0)))


def bounds_of(suspects: Sequence[Suspect]) -> tuple[Array, Array]:
    """Give the least and the largest values of suspects' parameters, (parameters,) each."""
    lower = [value for suspect in suspects for value in suspect.lower]
    upper = [value for suspect in suspects for value in suspect.upper]
    return np.array(lower), np.array(upper)


def changed(model: CoupledModel, suspects: Sequence[Suspect], values: Values) -> CoupledModel:
    """Give a model with all values of some suspects in place."""
    places = _places(suspects)
    for suspect in suspects:
        model = suspect.change(model, values[places[suspect.id]])
    return model


def refit(
    task: Task, suspects: tuple[Suspect, ...], begin: Values, near: Prediction, most: int = MOST_EVALUATIONS
) -> Refit:
    """Refit suspects from values, in so many evaluations at most; `near` is what the model says there or nearby."""
    path = _Path(task, suspects, near, task.residual)
    values, jacobian = path.fitted(np.array(begin), SETTLED, most)
    return Refit(suspects, tuple(values.tolist()), path.at(values), path.residual(values), jacobian)


def searched(task: Task, suspect: Suspect) -> tuple[Values, Prediction]:
    """Give values of a suspect from which its refit should begin, and what the model says there.

    Starts are tried outwards from the model as stated, each from its neighbour's steady states; from the best of them
    the coarse residual is followed down. Where the model as stated comes near, a factor is not searched.
    """
    best = np.clip(np.zeros(len(suspect.lower)), suspect.lower, suspect.upper)
    near_best = task.prediction
    coarse = task.coarse_residual(task.prediction)
    least = float(coarse @ coarse)
    if least < CLOSE**2 * coarse.size and best[0] > suspect.lower[0]:
        return tuple(best.tolist()), task.prediction
    for side in (-1, 1):
        near = task.prediction
        for start in sorted((one for one in suspect.starts if side * one[0] > 0), key=lambda one: abs(one[0])):
            path = _Path(task, (suspect,), near, task.coarse_residual)
            squared = float(np.sum(path.residual(np.array(start)) ** 2))
            if not np.isfinite(squared):
                break
            near = path.at(np.array(start)) if len(start) == 1 else near
            if squared < least:
                best, near_best, least = np.array(start), path.at(np.array(start)), squared
    path = _Path(task, (suspect,), near_best, task.coarse_residual)
    found, _ = path.fitted(best, ROUGHLY, MOST_ROUGH)
    return tuple(found.tolist()), path.at(found)


class _Path:
    """The model along a refit: each prediction starts from the last one at which derivatives were taken."""

    def __init__(
        self,
        task: Task,
        suspects: tuple[Suspect, ...],
        near: Prediction,
        residual_of: Callable[[Prediction], Array],
    ) -> None:
        self._task, self._suspects, self._near, self._residual_of = task, suspects, near, residual_of
        self._lower, self._upper = bounds_of(suspects)
        self._scales = np.concatenate([np.min(np.abs(np.array(suspect.starts)), axis=0) for suspect in suspects])
        self._size = residual_of(task.prediction).size
        self._known: dict[Values, Prediction] = {}

    def fitted(self, begin: Array, tolerance: float, most: int) -> tuple[Array, Array]:
        """Give the values of least squares, and the residual's derivatives there."""
        inside = np.clip(begin, self._lower, self._upper)
        if not np.all(np.isfinite(self.residual(inside))):
            self._near = self._task.prediction
            inside = np.clip(np.zeros_like(inside), self._lower, self._upper)
            self._known.pop(tuple(inside.tolist()), None)
        # A step to where there is no steady state is infinitely bad, and shortened; numpy needn't warn of it.
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            found = least_squares(
                self.residual, inside, self.jacobian, bounds=(self._lower, self._upper), x_scale=self._scales,
                ftol=tolerance, xtol=tolerance, gtol=None, max_nfev=most,
            )  # fmt: skip
        if not np.all(np.isfinite(found.x)):
            return inside, self.jacobian(inside)
        return np.asarray(found.x, dtype=np.float64), np.asarray(found.jac, dtype=np.float64)

    def at(self, values: Array) -> Prediction:
        """Give what the model says."""
        key = tuple(values.tolist())
        if key not in self._known:
            model = changed(self._task.model, self._suspects, key)
            self._known[key] = predict(model, self._task.measurement, self._near)
        return self._known[key]

    def residual(self, values: Array) -> Array:
        """Give the residual; infinite where the model has no steady states."""
        try:
            residual = self._residual_of(self.at(values))
        except (UserError, np.linalg.LinAlgError):
            return np.full(self._size, np.inf)
        return residual if np.all(np.isfinite(residual)) else np.full(self._size, np.inf)

    def jacobian(self, values: Array) -> Array:
        """Differentiate at values that were evaluated; a derivative that can't be taken is 0."""
        self._near = self.at(values)
        here = self.residual(values)
        columns = []
        for index, step in enumerate(NUDGE * np.maximum(np.abs(values), self._scales)):
            moved = values.copy()
            moved[index] += step if values[index] + step <= self._upper[index] else -step
            column = (self.residual(moved) - here) / (moved[index] - values[index])
            columns.append(np.where(np.isfinite(column), column, 0.0))
        return np.column_stack(columns)


def _places(suspects: Sequence[Suspect]) -> dict[str, slice]:
    """Give where each suspect's values stand."""
    places, begin = {}, 0
    for suspect in suspects:
        places[suspect.id] = slice(begin, begin + len(suspect.lower))
        begin += len(suspect.lower)
    return places
