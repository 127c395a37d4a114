"""Stribeck friction: F = (F_k + F_b exp(-|v/v_s|^delta_s)) sgn v, F_k + F_b next to rest and F_k at speed.

|v| is smooth at v = 0 within v_r, as sgn v is, so that its powers have slopes.
"""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import ARMSTRONG, BO, OLSSON
from pipeclamp_models.equations.symbols import F_typical, smooth_sign, v, v_highest, v_lowest, v_r, v_typical

F_k, F_b, v_s, delta_s = sp.symbols("F_k F_b v_s delta_s", real=True)

EFFECT = Effect(
    id="stribeck",
    part="clamp",
    does="dry friction that falls as the clamp moves faster",
    source=f"{OLSSON}, F_C = F_k and F_S = F_k + F_b; {BO}; {ARMSTRONG}",
    looks_like="a step of force at each reversal that falls while the clamp gathers speed: ears at the loop's ends",
    imitated_by=("coulomb", "memory", "power_damping"),
    told_apart_by="one amplitude from very slow to fast: the loop shrinks, the faster the cycle, by up to F_b on each "
    "side, and no further",
    special_cases=("coulomb",),
    parameters=(
        Parameter(F_k, "N", "friction at speed", (0.03 * F_typical,) * 3, lower=0.0, neutral=0.0),
        Parameter(
            F_b, "N", "friction beyond it where the clamp begins to move", (0.05 * F_typical,) * 3, lower=0.0,
            upper=10 * F_typical,
        ),
        Parameter(
            v_s, "mm/s", "speed at which a third of that is left", (0.1 * v_lowest, 0.2 * v_typical, 0.6 * v_typical),
            lower=0.01 * v_lowest, upper=2 * v_highest,
        ),
        Parameter(
            delta_s, "-", "how suddenly it falls: 1 exponential (Tustin), 2 Gaussian (Armstrong)", (1.5,) * 3,
            lower=0.5, upper=3.0,
        ),
    ),
    force=(F_k + F_b * sp.exp(-(((v**2 + v_r**2) / v_s**2) ** (delta_s / 2)))) * smooth_sign(v, v_r),
)  # fmt: skip
