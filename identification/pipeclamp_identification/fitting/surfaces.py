"""The paper's own route: each loop decomposed by itself, then surfaces through the coefficients (Eq. 11-13, 20-24).

It gives the joint fit its start, and by itself it is `--method surfaces`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.fitting.observations import loop_motion
from pipeclamp_identification.loops.loops import Loops, on_grid
from pipeclamp_identification.signals.levels import varies
from pipeclamp_models.base.arrays import Array, BoolArray
from pipeclamp_models.base.signals import REFERENCES
from pipeclamp_models.law.law import Structure
from pipeclamp_models.law.outline import ParameterOutline

POINTS_PER_AXIS = 128
NEAR_REVERSAL = 0.2
"""Below this share of its peak, velocity says little of the exponent: noise and memory rule there."""
SURFACE_PARAMETERS = {"k1": "k10", "k3": "k30", "c": "c0", "alpha": "alpha0"}
ELASTIC = ("k1", "k3")


@dataclass(frozen=True)
class LoopCoefficients:
    """Coefficients of Eq. 17 of each loop by itself, shape (R,): k1 N/mm, k3 N/mm3, c N, alpha."""

    k1: Array
    k3: Array
    c: Array
    alpha: Array


def loop_coefficients(loops: Loops, alpha: float | None = None) -> LoopCoefficients:
    """Decompose each loop and fit Eq. 17 to its parts.

    What is even in time about the reversal (the real harmonics) is the single-valued, elastic part; what is odd is the
    double-valued, damping part. k1 and k3 are the elastic part's least squares over y and y^3; alpha is the slope of
    the damping part's logarithm over that of the velocity; c gives the loop its area.

    Args:
        loops: R loops.
        alpha: the exponent, where it is given.
    """
    from scipy.special import gamma

    y = on_grid(loops.displacement, POINTS_PER_AXIS)
    elastic = on_grid(loops.force.real.astype(np.complex128), POINTS_PER_AXIS)
    elastic -= loops.force[:, :1].real
    basis = np.stack([y, y**3], axis=2)
    transposed = np.swapaxes(basis, 1, 2)
    solution = np.linalg.solve(transposed @ basis, transposed @ elastic[:, :, None])
    peak = 2 * np.pi * loops.frequency_Hz * loops.amplitude_mm
    theta = 2 * np.pi * np.arange(POINTS_PER_AXIS) / POINTS_PER_AXIS
    # Odd harmonics only: even ones are asymmetry, which a power of |v| doesn't have.
    odd = np.arange(loops.force.shape[1]) % 2
    damping = on_grid((1j * loops.force.imag * odd).astype(np.complex128), POINTS_PER_AXIS)
    push = -damping * np.sign(np.sin(theta))
    moving = np.abs(np.sin(theta)) > NEAR_REVERSAL
    if alpha is None:
        level = np.log(np.abs(np.sin(theta[moving])))
        usable = np.maximum(push[:, moving], 1e-3 * np.abs(push).max(axis=1, keepdims=True))
        centred = level - level.mean()
        exponents: Array = np.clip(np.log(usable) @ centred / (centred @ centred), 0.02, 2.0)
    else:
        exponents = np.full(len(peak), alpha)
    quadrature = np.maximum(loops.force[:, 1].imag, 0.0)
    area = 2 * np.sqrt(np.pi) * gamma(exponents / 2 + 1) / gamma(exponents / 2 + 1.5)
    c: Array = np.pi * quadrature / (area * peak**exponents)
    k1, k3 = np.asarray(solution[:, :, 0].T, dtype=np.float64)
    return LoopCoefficients(k1, k3, c, exponents)


def surface_values(structure: Structure, loops: Loops) -> Mapping[str, float]:
    """Give values of the base law's parameters by surfaces through the coefficients of the loops.

    Args:
        structure: its power surfaces are fitted; other bases get none.
        loops: R loops.

    Returns:
        values by parameter name; empty where the base has no such surfaces.
    """
    by_name = {parameter.name: parameter for parameter in Structure(structure.base).equations.parameters}
    if not set(SURFACE_PARAMETERS.values()) <= set(by_name):
        return {}
    held = structure.held()
    coefficients = loop_coefficients(loops, held.get("alpha0"))
    slow = loop_motion(loops, 4).slow
    values: dict[str, float] = {}
    for name, reference in SURFACE_PARAMETERS.items():
        exponents = [by_name[entry] for entry in by_name if entry.startswith(f"{name}_") and by_name[entry].follows]
        values |= _surface(getattr(coefficients, name), by_name[reference], exponents, slow)
    return {**values, **{name: value for name, value in held.items() if name in values}}


def elastic_values(values: Mapping[str, float]) -> dict[str, float]:
    """Give those of the surfaces' values that belong to k1 and k3."""
    return {name: value for name, value in values.items() if name.startswith(ELASTIC)}


def _surface(
    coefficient: Array, reference: ParameterOutline, exponents: list[ParameterOutline], slow: Mapping[str, Array]
) -> dict[str, float]:
    """Fit the logarithm of a coefficient by a plane over the logarithms of the conditions that vary."""
    ratios = {
        parameter.name: np.log(slow[parameter.follows[0]][:, 0] / REFERENCES[f"{parameter.follows[0]}_0"])
        for parameter in exponents
    }
    varied = [parameter for parameter in exponents if varies(parameter.follows[0], slow[parameter.follows[0]])]
    values = {parameter.name: 0.0 for parameter in exponents}
    positive: BoolArray = coefficient > 0
    if np.count_nonzero(positive) <= max(len(varied), len(coefficient) // 2):
        return {reference.name: float(np.median(coefficient)), **values}
    plane = np.column_stack([np.ones(len(coefficient)), *(ratios[parameter.name] for parameter in varied)])[positive]
    logarithm = np.log(coefficient[positive])
    solution = np.linalg.lstsq(plane, logarithm, rcond=1e-6)[0]
    for parameter, value in zip(varied, solution[1:], strict=True):
        values[parameter.name] = float(np.clip(value, float(parameter.lower), float(parameter.upper)))
    # Through the tests with these exponents: of conditions that lie close together they may be far beyond their bounds.
    within = [values[parameter.name] for parameter in varied]
    values[reference.name] = float(np.exp(np.mean(logarithm - plane[:, 1:] @ np.array(within))))
    return values
