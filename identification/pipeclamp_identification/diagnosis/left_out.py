"""How a fitted law would foretell groups of runs, had they been left out.

Told from the fit to all runs by the formula of linear least squares, which is exact for linear laws. Where a group
pulls hard on the parameters, the law itself is evaluated at what the formula gives, and the step is shortened until the
other runs agree with it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeclamp_identification.diagnosis.noise import WhitenedObservations
from pipeclamp_identification.diagnosis.run_scatter import ScatterAxes
from pipeclamp_identification.fitting.joint.fitted import Fit
from pipeclamp_identification.signals.real_harmonics import mean_squares_of
from pipeclamp_models.base.arrays import Array, BoolArray, IntArray
from pipeclamp_models.realise.force import LawForce, force_of_equations

OPEN_SHARE = 1e-10
"""Directions of the scaled parameters of which is told less than this share of the best known one are open."""
SHORTEST_STEP_SHARE = 2.0**-10
"""Share of a step below which it isn't shortened further."""
DISAGREE_LIKELIHOOD = 2 * np.log(100.0)
"""The others disagree with a step that leaves them a hundredth of their likelihood: a direction in which they hardly
change is one that they can't tell, and what the group knows of it mustn't stay."""


@dataclass(frozen=True)
class Whitened:
    """Whitened residuals of a fit and their derivatives by the fitted parameters, shapes (R, m) and (R, m, P).

    Factors of groups, where there are any, come after the law's parameters; `factors` are their values, shape (K,).
    """

    residual: Array
    jacobian: Array
    factors: Array


def whitened(result: Fit, observations: WhitenedObservations, factors: Array | None = None) -> Whitened:
    """Give the whitened residuals of a fit at its solution.

    Args:
        result: the fit, with P fitted parameters.
        observations: R rows of m harmonic parts.
        factors: of groups, shape (K,); the likeliest ones where None.
    """
    slopes = observations.in_units(observations.loops.plain_slopes(result.law_force, result.places))
    residual = observations.against_noise(result.law_force)
    if factors is None:
        factors = observations.factors_beside(result.law_force)
    if observations.factors is not None:
        changes = observations.in_units(observations.factors.beside(result.law_force).directions)
        residual = residual - np.tensordot(factors, changes, axes=1)
        slopes = np.concatenate([slopes, -changes])
    return Whitened(residual, np.moveaxis(slopes, 0, -1), factors)


@dataclass(frozen=True)
class LeftOutScore:
    """How a law foretells groups of runs that it wasn't fitted to.

    Attributes:
        squares: sum of squared whitened residuals of each run, its group left out, shape (R,).
        errors: harmonics of each run's error, N, shape (R, m); zero of runs that are never left out.
        axes: how runs scatter; None where nothing is known of that.
    """

    squares: Array
    errors: Array
    axes: ScatterAxes | None = None

    @cached_property
    def mean_squares(self) -> Array:
        """Mean square of each run's error, N2, shape (R,)."""
        return mean_squares_of(self.errors)


@dataclass(frozen=True)
class WithoutGroups:
    """A fit to all runs, prepared for leaving groups out.

    Attributes:
        result: the fit.
        observations: what it was fitted to.
        coarse: the same at fewer points of the cycle, for evaluating the law elsewhere.
        fitted: its whitened residuals and derivatives.
    """

    result: Fit
    observations: WhitenedObservations
    coarse: WhitenedObservations
    fitted: Whitened

    def score(self, groups: IntArray) -> LeftOutScore:
        """Tell how the fit would foretell each group, had it been left out.

        Args:
            groups: the group of each run, shape (R,); -1 for those that are never left out, whose score is zero.
        """
        seen = self.observations.loops.seen
        squares, errors = np.zeros(len(groups)), np.zeros(seen.shape)
        for group in range(int(groups.max()) + 1):
            own = groups == group
            residual, error = self._foretold(own)
            squares[own] = np.nan_to_num(np.sum(residual**2, axis=1), nan=np.inf)
            errors[own] = np.where(seen[own], error, 0.0)
        return LeftOutScore(squares, errors)

    def unlikelihood(self, own: BoolArray) -> float:
        """Give minus twice the log likelihood of a group of runs, foretold by the others, but for what noise has of it.

        What the others don't determine they foretell vaguely: what lies within that is unlikely for its width alone,
        where squares would count it as an error. For linear laws this is the predictive likelihood (Rasmussen and
        Williams 2006, Gaussian Processes for Machine Learning, 5.4.2, for one run).

        Args:
            own: which runs are left out, shape (R,).
        """
        residual = self._foretold(own)[0].ravel()
        slopes = np.nan_to_num(self._slopes_of(own))
        pull = slopes.T @ np.nan_to_num(residual)
        every = np.linalg.pinv(slopes.T @ slopes + self._known_without(own), rcond=OPEN_SHARE, hermitian=True)
        shares = np.clip(np.linalg.eigvals(self.shares(own)).real, 0.0, 1 - OPEN_SHARE)
        unlikely = float(residual @ residual - pull @ every @ pull - np.sum(np.log1p(-shares)))
        return unlikely if np.isfinite(unlikely) else np.inf

    def _foretold(self, own: BoolArray) -> tuple[Array, Array]:
        """Give the whitened residuals and the plain ones of a group, as the others foretell it."""
        plain, plain_slopes = self._plain
        step = self._step(own)
        residual = self.fitted.residual[own] + self.fitted.jacobian[own] @ step
        error = plain[own] + plain_slopes[own] @ step
        pull = residual - self.fitted.residual[own]
        if not np.sum(pull**2) < np.sum(self.fitted.residual[own] ** 2):
            residual, error = self._evaluated(step, own, plain[own])
        return residual, error

    @cached_property
    def _plain(self) -> tuple[Array, Array]:
        """Residuals in N at the fit, what factors of groups explain left aside, and their derivatives."""
        plain = self.observations.loops.plain_residual(self.result.law_force)
        slopes = self.observations.loops.plain_slopes(self.result.law_force, self.result.places)
        if self.observations.factors is not None:
            shown = self.observations.factors.beside(self.result.law_force)
            plain = plain - shown.force(self.fitted.factors)
            slopes = np.concatenate([slopes, -shown.directions])
        return plain, np.moveaxis(slopes, 0, -1)

    def _step(self, own: BoolArray) -> Array:
        """Give how the fitted parameters would move without a group, by the linear formula, inside their bounds."""
        J, known = self._slopes_of(own), self._known_without(own)
        # a group's factors come from what is left of its runs
        factors, room = self.observations.factors, self.result.room
        if factors is not None:
            room = np.concatenate([room, np.array([[-np.inf], [np.inf]]) + np.zeros(len(factors.spreads))], axis=1)
        pull = np.nan_to_num(J.T @ self.fitted.residual[own].ravel())
        back, ways = self._without_factors_of(own)
        # A direction that this group alone determines can't be foretold without it, but by the priors.
        inverse = np.linalg.pinv(ways.T @ known @ ways, rcond=OPEN_SHARE, hermitian=True)
        step = back + ways @ (inverse @ (ways.T @ (pull - known @ back)))
        return np.asarray(np.clip(step / self._scale, *room))

    def shares(self, own: BoolArray) -> Array:
        """Give a group's share in what all runs and the priors tell of the fitted parameters, shape (P, P).

        Its eigenvalues are the shares in independent directions.
        """
        J = self._slopes_of(own)
        by_own = np.nan_to_num(J.T @ J)
        return np.asarray(np.linalg.pinv(by_own + self._known_without(own), rcond=OPEN_SHARE, hermitian=True) @ by_own)

    def _slopes_of(self, chosen: BoolArray) -> Array:
        """Give the scaled derivatives of the residuals of some runs, (n, P)."""
        return np.asarray((self.fitted.jacobian[chosen] / self._scale).reshape(-1, len(self._scale)))

    def _known_without(self, own: BoolArray) -> Array:
        """Give what is known of the scaled parameters by the other runs and the priors, (P, P)."""
        rest, precision = self._slopes_of(~own), self.result.precision
        if self.observations.factors is not None:
            precision = np.concatenate([precision, self.observations.factors.precision])
        return np.asarray(np.nan_to_num(rest.T @ rest) + np.diag(precision / self._scale**2))

    @cached_property
    def _scale(self) -> Array:
        """Size of each parameter's derivatives, shape (P,); one where there are none."""
        scale = np.linalg.norm(self.fitted.jacobian, axis=(0, 1))
        return np.where(scale > 0, scale, 1.0)

    def _without_factors_of(self, own: BoolArray) -> tuple[Array, Array]:
        """Give the step that takes out the factors of groups that stand in these runs alone, and the ways left, (P, Q).

        Nothing is known of such a group: it counts as the one in the middle, and so the law stands for the others.
        Steps are in units of one over `_scale`.
        """
        size = self.fitted.jacobian.shape[2]
        factors = self.observations.factors
        gone = np.zeros((0, 0)) if factors is None else factors.of_groups_in(own)
        if not len(gone):
            return np.zeros(size), np.eye(size)
        values = np.concatenate([np.zeros(len(self.result.fitted)), self.fitted.factors]) * self._scale
        gone = np.concatenate([np.zeros((len(gone), size - gone.shape[1])), gone], axis=1) / self._scale
        _, singular, ways = np.linalg.svd(gone)
        rank = int(np.sum(singular > 1e-8 * singular[0]))
        return -np.linalg.pinv(gone) @ (gone @ values), ways[rank:].T

    def _evaluated(self, step: Array, own: BoolArray, plain: Array) -> tuple[Array, Array]:
        """Give the whitened residuals and the plain ones of a group where its step leads, which the others agree with.

        Args:
            step: of the fitted parameters.
            own: which runs are left out.
            plain: their plain residuals at the fit.
        """
        here = self._here
        most = self._cost_of_others(here, np.zeros_like(step), own)
        share = 1.0
        while share > SHORTEST_STEP_SHARE:
            moved = share * step
            there = self._law_force(moved)
            with np.errstate(over="ignore", invalid="ignore"):  # of a force beyond all numbers, with which none agrees
                agreed = self._cost_of_others(there, moved, own) <= most + DISAGREE_LIKELIHOOD
            if agreed:
                break
            share /= 2
        change = self._residual(there, moved) - self._residual(here, np.zeros_like(step))
        plain_change = self.coarse.loops.plain_residual(there) - self.coarse.loops.plain_residual(here)
        if self.coarse.factors is not None:
            factors, size = self.fitted.factors, len(self.result.fitted)
            plain_change -= self.coarse.factors.beside(there).force(factors + moved[size:])
            plain_change += self.coarse.factors.beside(here).force(factors)
        return self.fitted.residual[own] + change[own], plain + plain_change[own]

    @cached_property
    def _here(self) -> LawForce:
        """The law's force at the fit."""
        return self._law_force(np.zeros(self.fitted.jacobian.shape[2]))

    def _law_force(self, step: Array) -> LawForce:
        law = self.result.law
        values = np.array(law.vector(self.result.equations))
        values[self.result.places] += step[: len(self.result.fitted)]
        return force_of_equations(self.result.equations, values, (law.v_r, law.y_r), self.coarse.motion)

    def _cost_of_others(self, law_force: LawForce, step: Array, own: BoolArray) -> float:
        """Give the sum of squares of the other runs and of the priors, less the priors' at the fit."""
        squares = float(np.sum(self._residual(law_force, step)[~own] ** 2))
        size = len(self.result.fitted)
        from_mean, own_step = self.result.from_priors, step[:size]
        squares += float(np.sum(self.result.precision * ((from_mean + own_step) ** 2 - from_mean**2)))
        if self.coarse.factors is not None:
            factors = self.fitted.factors
            squares += float(np.sum(self.coarse.factors.precision * ((factors + step[size:]) ** 2 - factors**2)))
        return squares

    def _residual(self, law_force: LawForce, step: Array) -> Array:
        """Give the whitened residuals of all runs for a law's force, factors of groups moved by a step."""
        residual = self.coarse.against_noise(law_force)
        if self.coarse.factors is None:
            return residual
        changes = self.coarse.in_units(self.coarse.factors.beside(law_force).directions)
        return np.asarray(
            residual - np.tensordot(self.fitted.factors + step[len(self.result.fitted) :], changes, axes=1)
        )
