"""Refits of a coupled model to a measurement: parameters that may be wrong, by Gauss-Newton, in units of the noise."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.attribution.lockstep import Evaluated, LeastSquares, fit_together
from pipeclamp_identification.attribution.suspect import Suspect, Values
from pipeclamp_identification.attribution.task import Computed, ModelFamily, RefitTask
from pipeclamp_identification.on_pipe.model import CoupledModel
from pipeclamp_models.base.arrays import Array

NUDGE = 3e-3
"""Of a parameter's smallest start, or of itself: by so much it is moved for a derivative."""
WORTH_GAINING = 1e-3
"""A refit is done when no more than this share of the squared error, or of the noise's, is to be gained."""
MOST_EVALUATIONS = 25
CLOSE_RMS = 0.15
"""Rms of the coarse residual below which the model as stated is a good enough start."""
ROUGH_GAIN = 0.02
MOST_ROUGH = 8
"""Likewise, of the first approach on the coarse residual."""


@dataclass(frozen=True, eq=False)
class Refit:
    """A model with some parameters refitted.

    Attributes:
        suspects: what was refitted; none for the model as stated.
        values: of all parameters, in the suspects' order.
        computed: what the refitted model says.
        residual: over the noise, (n,).
        jacobian: of the residual by the values, (n, parameters).
        moved: what the model says with each value moved, which the derivatives were taken from.
    """

    suspects: tuple[Suspect, ...]
    values: Values
    computed: Computed
    residual: Array
    jacobian: Array
    moved: tuple[Computed | None, ...] = ()

    @property
    def squared(self) -> float:
        """Sum of squares of the residual."""
        return float(self.residual @ self.residual)

    @property
    def freedoms(self) -> int:
        """Values that are compared less those that were refitted; 1 at least."""
        return max(1, self.residual.size - len(self.values))

    @property
    def rms(self) -> float:
        """Root of the residual's mean square over its degrees of freedom: what is left in units of the noise."""
        return float(np.sqrt(self.squared / self.freedoms))

    def values_of(self, suspect: Suspect) -> Values:
        """Give the values of one suspect."""
        return self.values[_places(self.suspects)[suspect.id]]

    def errors_of(self, suspect: Suspect, overdispersion: float = 1.0) -> Values:
        """Give the standard errors of one suspect's values; what the data can't tell has a large one."""
        information = self.jacobian.T @ self.jacobian
        covariance = overdispersion * np.linalg.pinv(information, hermitian=True)
        return tuple(np.sqrt(np.maximum(np.diag(covariance), 0.0)).tolist())[_places(self.suspects)[suspect.id]]


@dataclass(frozen=True, eq=False)
class RefitStart:
    """Where a refit begins: suspects, their values, and what the model says there or nearby.

    Where it is known what it says there with each value moved, too, as of `Refit`, that isn't computed again.
    """

    suspects: tuple[Suspect, ...]
    values: Values
    near: Computed
    moved: tuple[Computed | None, ...] = ()


@dataclass(frozen=True, eq=False)
class _Said:
    """What a model says, and with each value moved; none of these where it is but near."""

    computed: Computed
    moved: tuple[Computed | None, ...] = ()


def as_stated(task: RefitTask) -> Refit:
    """Give the model as it is stated."""
    residual = task.residual(task.stated)
    return Refit((), (), task.stated, residual, np.zeros((residual.size, 0)))


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


def refit(task: RefitTask, starts: Sequence[RefitStart], most: Sequence[int] | int = MOST_EVALUATIONS) -> list[Refit]:
    """Refit from each start, all in lock step, in so many evaluations at most."""
    negligible = WORTH_GAINING * task.residual(task.stated).size
    found = _fitted(task, starts, task.residual, (WORTH_GAINING, negligible), most)
    return [
        Refit(
            start.suspects, tuple(one.values.tolist()), one.state.computed, one.residual, one.jacobian, one.state.moved
        )
        for start, one in zip(starts, found, strict=True)
    ]


def searched(task: RefitTask, suspects: Sequence[Suspect]) -> list[RefitStart]:
    """Give where the refit of each suspect alone should begin.

    Starts are tried outwards from the model as stated, each from its neighbour's motion; from the best of them the
    coarse residual is followed down. Where the model as stated comes near, a factor is not searched, and of what has
    no size of its own only the next starts are tried.
    """
    coarse = task.coarse_residual(task.stated)
    least = float(coarse @ coarse)
    near_enough = least < CLOSE_RMS**2 * coarse.size
    starts = [RefitStart((suspect,), suspect.neutral, task.stated) for suspect in suspects]
    asked = {
        index: start
        for index, start in enumerate(starts)
        if not (near_enough and start.values[0] > suspects[index].lower[0])
    }
    best = _outwards(task, asked, least, most=1 if near_enough else None)
    if near_enough:
        return [best.get(index, start) for index, start in enumerate(starts)]
    rough = _fitted(task, list(best.values()), task.coarse_residual, (ROUGH_GAIN, 0.0), MOST_ROUGH)
    for (index, start), found in zip(best.items(), rough, strict=True):
        starts[index] = RefitStart(start.suspects, tuple(found.values.tolist()), found.state.computed)
    return starts


def _outwards(
    task: RefitTask, asked: Mapping[int, RefitStart], least: float, most: int | None
) -> dict[int, RefitStart]:
    """Give the best of the starts that are tried outwards from the model as stated, by the coarse residual.

    Args:
        task: the task.
        asked: where each suspect stands as stated, by number.
        least: squares of the coarse residual as stated.
        most: starts of each ray at most; None for all.
    """
    best = {index: (least, start) for index, start in asked.items()}
    rays = [(index, ray[:most]) for index, start in asked.items() for ray in _rays(start.suspects[0])]
    last = [task.stated] * len(rays)
    for number in range(max((len(ray) for _, ray in rays), default=0)):
        tried = [place for place, (_, ray) in enumerate(rays) if number < len(ray)]
        families = [
            ModelFamily([changed(task.model, asked[rays[place][0]].suspects, rays[place][1][number])], last[place])
            for place in tried
        ]
        for place, (computed,) in zip(tried, task.computed(families), strict=True):
            index, ray = rays[place]
            squared = np.inf if computed is None else float(np.sum(task.coarse_residual(computed) ** 2))
            if computed is None or not np.isfinite(squared):
                rays[place] = index, ray[:number]  # beyond a place without a motion none is looked for
                continue
            last[place] = computed
            if squared < best[index][0]:
                best[index] = squared, RefitStart(asked[index].suspects, ray[number], computed)
    return {index: start for index, (_, start) in best.items()}


def _rays(suspect: Suspect) -> list[list[Values]]:
    """Give the starts of a suspect in the order in which they are tried, each from the one before it.

    Of a single parameter they go outwards to both sides; of several each begins from the model as stated.
    """
    if len(suspect.lower) > 1:
        return [[start] for start in suspect.starts]
    outwards = sorted(suspect.starts, key=lambda one: abs(one[0]))
    return [[one for one in outwards if side * one[0] > 0] for side in (-1, 1)]


def _fitted(
    task: RefitTask,
    starts: Sequence[RefitStart],
    residual_of: Callable[[Computed], Array],
    tolerances: tuple[float, float],
    most: Sequence[int] | int,
) -> list[Evaluated[_Said]]:
    """Refit from each start; one without a motion there begins from the model as stated."""
    bounds = [bounds_of(start.suspects) for start in starts]
    scales = [
        np.concatenate([np.min(np.abs(np.array(suspect.starts)), axis=0) for suspect in start.suspects])
        for start in starts
    ]
    limits = [most] * len(starts) if isinstance(most, int) else most

    def evaluate(asked: Sequence[tuple[int, Array, _Said]]) -> list[Evaluated[_Said] | None]:
        families, moves, known = [], [], dict[int, list[Computed | None]]()
        for place, (index, values, near) in enumerate(asked):
            steps = NUDGE * np.maximum(np.abs(values), scales[index])
            steps = np.where(values + steps <= bounds[index][1], steps, -steps)
            moves.append(steps)
            if near.moved and near is begun[index] and np.array_equal(values, starts[index].values):
                known[place] = [near.computed, *near.moved]
                continue
            places = [values, *(values + np.diag(steps))]
            models = [changed(task.model, starts[index].suspects, tuple(place.tolist())) for place in places]
            families.append(ModelFamily(models, near.computed))
        fresh = iter(task.computed(families))
        found = [known[place] if place in known else next(fresh) for place in range(len(asked))]
        return [
            _evaluated(values, computed, steps, residual_of)
            for (_, values, _), steps, computed in zip(asked, moves, found, strict=True)
        ]

    def problem(index: int, begin: Array, near: _Said) -> LeastSquares[_Said]:
        lower, upper = bounds[index]
        return LeastSquares(np.clip(begin, lower, upper), lower, upper, scales[index], near, limits[index])

    begun = [_Said(start.near, start.moved) for start in starts]
    problems = [problem(index, np.array(start.values), begun[index]) for index, start in enumerate(starts)]
    found = fit_together(problems, evaluate, *tolerances)
    lost = [index for index, one in enumerate(found) if one is None]
    again = [problem(index, _neutral(starts[index].suspects), _Said(task.stated)) for index in lost]

    def evaluate_lost(asked: Sequence[tuple[int, Array, _Said]]) -> list[Evaluated[_Said] | None]:
        return evaluate([(lost[index], values, near) for index, values, near in asked])

    for index, one in zip(lost, fit_together(again, evaluate_lost, *tolerances), strict=True):
        found[index] = one
    return [one or _still(starts[index], task, residual_of) for index, one in enumerate(found)]


def _evaluated(
    values: Array, computed: Sequence[Computed | None], steps: Array, residual_of: Callable[[Computed], Array]
) -> Evaluated[_Said] | None:
    """Give residual and derivatives; None where there is no motion. A derivative that can't be taken is 0."""
    first, *moved = computed
    if first is None:
        return None
    here = residual_of(first)
    if not np.all(np.isfinite(here)):
        return None
    columns = np.zeros((here.size, steps.size))
    for column, (one, step) in enumerate(zip(moved, steps, strict=True)):
        change = (residual_of(one) - here) / step if one is not None else np.zeros(here.size)
        columns[:, column] = np.where(np.isfinite(change), change, 0.0)
    return Evaluated(values, _Said(first, tuple(moved)), here, columns)


def _still(start: RefitStart, task: RefitTask, residual_of: Callable[[Computed], Array]) -> Evaluated[_Said]:
    """Give the model as stated, where nothing else has a motion."""
    values = _neutral(start.suspects)
    residual = residual_of(task.stated)
    return Evaluated(values, _Said(task.stated), residual, np.zeros((residual.size, values.size)))


def _neutral(suspects: Sequence[Suspect]) -> Array:
    return np.array([value for suspect in suspects for value in suspect.neutral])


def _places(suspects: Sequence[Suspect]) -> dict[str, slice]:
    """Give where each suspect's values stand."""
    places, begin = {}, 0
    for suspect in suspects:
        places[suspect.id] = slice(begin, begin + len(suspect.lower))
        begin += len(suspect.lower)
    return places
