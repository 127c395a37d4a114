"""Friction that grows with the displacement: F = k_mu |y| sgn v, as where what deflects presses the sliding parts.

|y| is written as y^2/sqrt(y^2 + y_r^2), which is smooth at y = 0 and nought there: nothing slides without a force.
"""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import HILL, REID
from pipeclamp_models.equations.symbols import A_typical, F_typical, smooth_sign, v, v_r, y, y_r

k_mu = sp.Symbol("k_mu", real=True)

EFFECT = Effect(
    id="displacement_friction",
    part="clamp",
    does="dry friction that grows with the displacement",
    source=f"{REID}; {HILL}: ring springs, F = k y (1 + mu sgn(y v)), k_mu = mu k",
    looks_like="a bow tie: no width at y = 0, a step of force at each reversal that grows with the amplitude, at any "
    "speed",
    imitated_by=("power_damping", "memory", "coulomb"),
    told_apart_by="small cycles about a large displacement: they are as wide as it is far, however small and slow",
    parameters=(Parameter(k_mu, "N/mm", "friction per displacement", 0.03 * F_typical / A_typical, lower=0.0),),
    force=k_mu * y**2 / sp.sqrt(y**2 + y_r**2) * smooth_sign(v, v_r),
)
