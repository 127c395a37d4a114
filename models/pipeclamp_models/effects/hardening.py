"""Hardening: F = k5 y^5."""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import JIANG, KOVACIC
from pipeclamp_models.equations.symbols import F_typical, x, y_farthest

k5 = sp.Symbol("k5", real=True)

EFFECT = Effect(
    id="hardening",
    part="clamp",
    does="a force with y^5, felt in the largest loops",
    source=f"{JIANG}, Eq. 13 (fifth power); {KOVACIC}",
    looks_like="tips of the largest loops bend up smoothly: harmonics 1, 3 and 5 in phase, as A^5",
    imitated_by=("end_stop", "cubic_stiffness", "exponential_stiffening"),
    told_apart_by="a larger amplitude: a stop's kink stays at its displacement, hardening has none",
    parameters=(Parameter(k5, "N/mm5", "coefficient", 0.05 * F_typical / y_farthest**5, lower=0.0),),
    force=k5 * x**5,
    energy=k5 * x**6 / 6,
)
