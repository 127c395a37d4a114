"""Linear stiffness of the base law: F = k1 y, k1 = k10 (A/A0)^a (T/T0)^b."""

import sympy as sp

from pipeclamp_models.equations.effect import Coefficient, Effect, Parameter, exponent, power_surface
from pipeclamp_models.equations.literature import JIANG
from pipeclamp_models.equations.symbols import A, A_typical, F_typical, T, x

k1, k10, k1_A, k1_T = sp.symbols("k1 k10 k1_A k1_T", real=True)

EFFECT = Effect(
    id="linear_stiffness",
    part="base",
    does="the base law's force with y",
    source=f"{JIANG}, Eq. 17 and 20",
    looks_like="the loop has no slope",
    imitated_by=(),
    told_apart_by="nothing imitates it over several amplitudes",
    parameters=(
        Parameter(k10, "N/mm", "linear stiffness at A0, T0", 0.8 * F_typical / A_typical, lower=0.0),
        exponent(k1_A, "k1", A, 3.0),
        exponent(k1_T, "k1", T, 5.0),
    ),
    coefficients=(Coefficient(k1, "N/mm", "stiffness", power_surface(k10, {A: k1_A, T: k1_T})),),
    force=k1 * x,
    energy=k1 * x**2 / 2,
)
