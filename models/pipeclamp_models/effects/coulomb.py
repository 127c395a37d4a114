"""Dry friction: F = F_c sgn v."""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import GAUL, JIANG
from pipeclamp_models.equations.symbols import F_typical, smooth_sign, v, v_r

F_c = sp.Symbol("F_c", real=True)

EFFECT = Effect(
    id="coulomb",
    part="clamp",
    does="dry friction: a constant force against the motion",
    source=f"{JIANG}, Eq. 10 (b0 sgn v); {GAUL}",
    looks_like="a step of force at each reversal, the same at every A and f: quadrature of all odd harmonics",
    imitated_by=("power_damping", "memory", "stribeck"),
    told_apart_by="a very slow test at small amplitude: the step stays where a power of v dies out",
    parameters=(Parameter(F_c, "N", "friction force", 0.03 * F_typical, lower=0.0),),
    force=F_c * smooth_sign(v, v_r),
)
