"""Dry friction: F = F_c sgn v."""

import sympy as sp

from pipeclamp.effect import Effect, Parameter
from pipeclamp.symbols import F_typical, smooth_sign, v, v_r

F_c = sp.Symbol("F_c", real=True)

EFFECT = Effect(
    id="coulomb",
    part="clamp",
    source="Jiang et al. 2020, Eq. 10 (b0 sgn v); EFFECTS.md",
    looks_like="a step of force at each reversal, the same at every A and f: quadrature of all odd harmonics",
    imitated_by=("power_damping", "memory"),
    told_apart_by="a very slow test at small amplitude: the step stays where a power of v dies out",
    parameters=(Parameter(F_c, "N", "friction force", 0.03 * F_typical, lower=0.0),),
    force=F_c * smooth_sign(v, v_r),
)
