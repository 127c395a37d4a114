"""How sure fitted parameters are: by the noise that tests state, and by how far the fit hangs on single runs."""

from __future__ import annotations

import numpy as np

from pipeclamp_models.base.arrays import Array, IntArray

FROM_OTHERS_SHARE = 1e-6
"""A direction of the parameters that the other runs determine to less than this share: nothing is seen without it."""

LARGEST_ERROR = 1e150
"""Standard errors, in a parameter's own unit, are this at most: their squares still are numbers."""


def covariance_of(
    scaled: Array, norms: Array, residual: Array, compared: int, precision: Array, runs: IntArray | None = None
) -> Array:
    """Give the covariance of P parameters that were fitted to R rows, each a run or a stretch of one, (P, P).

    Residuals of one run share their causes (its temperature, its scatter, what the law's form is off), so they are
    counted run by run: standard errors are those of the jackknife, and never below those that trust the stated
    uncertainties. Correlations are the latter's.

    Args:
        scaled: the Jacobian, with columns of length 1, (residuals, P).
        norms: what its columns were divided by, (P,).
        residual: by row, (R, m), in units of their stated uncertainties.
        compared: so many of the residuals are; the others are zero, whatever the law.
        precision: of the priors, (P,).
        runs: number of the run of each row, (R,); None where each row is one of its own.
    """
    count = scaled.shape[1]
    if count == 0:
        return np.zeros((0, 0))
    spread = max(1.0, float(np.sum(residual**2)) / max(compared - count, 1))
    inverse = np.linalg.pinv(scaled.T @ scaled + spread * np.diag((np.sqrt(precision) / norms) ** 2), hermitian=True)
    stated = inverse * spread
    by_row = scaled.reshape(*residual.shape, count)
    moved = moved_by_runs(_together(by_row, runs), inverse, _together(residual, runs))
    widened = np.minimum(np.sqrt(np.maximum(moved / np.diag(stated), 1.0)) / norms, LARGEST_ERROR)
    return np.asarray(stated * np.outer(widened, widened))


def _together(rows: Array, runs: IntArray | None) -> Array:
    """Give what belongs to rows, (R, m, ...), by run, (runs, rows of the longest times m, ...), 0 where one ends."""
    if runs is None:
        return rows
    counts = np.bincount(runs)
    order = np.argsort(runs, kind="stable")
    place = np.empty_like(runs)
    place[order] = np.concatenate([np.arange(count) for count in counts.tolist()])
    found = np.zeros((len(counts), int(counts.max()), *rows.shape[1:]))
    found[runs, place] = rows
    return found.reshape(len(counts), -1, *rows.shape[2:])


def moved_by_runs(jacobian: Array, inverse: Array, residual: Array) -> Array:
    """Give the jackknife's variances, (P,): how far the fit moves without each run, squared and summed over the runs.

    To first order: R. M. Bell, D. F. McCaffrey, Bias reduction in standard errors for linear regression with
    multi-stage samples, Survey Methodology 28 (2002) 169-181.

    Args:
        jacobian: by run, (R, m, P).
        inverse: of the normal equations of all runs, (P, P).
        residual: by run, (R, m).
    """
    values, vectors = np.linalg.eigh(inverse)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    by_run = jacobian @ root
    leverages, directions = np.linalg.eigh(by_run.transpose(0, 2, 1) @ by_run)
    pulls = np.einsum("rpd,rp->rd", directions, np.einsum("rmp,rm->rp", by_run, residual))
    moved = np.where(leverages < 1 - FROM_OTHERS_SHARE, pulls / np.maximum(1 - leverages, FROM_OTHERS_SHARE), 0.0)
    return np.asarray(np.sum((root @ np.einsum("rpd,rd->pr", directions, moved)) ** 2, axis=1))
