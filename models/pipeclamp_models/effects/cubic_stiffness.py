"""Cubic stiffness of the base law: F = k3 y^3, k3 = k30 (A/A0)^a (T/T0)^b."""

import sympy as sp

from pipeclamp_models.equations.effect import Coefficient, Effect, Parameter, exponent, power_surface
from pipeclamp_models.equations.literature import JIANG, KOVACIC
from pipeclamp_models.equations.symbols import A, A_typical, F_typical, T, x

k3, k30, k3_A, k3_T = sp.symbols("k3 k30 k3_A k3_T", real=True)

EFFECT = Effect(
    id="cubic_stiffness",
    part="base",
    does="the base law's force with y^3",
    source=f"{JIANG}, Eq. 17 and 21; {KOVACIC}",
    looks_like="in phase, third harmonic: the loop's back is curved",
    imitated_by=("hardening", "end_stop"),
    told_apart_by="a sweep of amplitude: the third harmonic grows as A^3",
    parameters=(
        Parameter(
            k30, "N/mm3", "cubic stiffness at A0, T0", 0.2 * F_typical / A_typical**3, neutral=0.0, by_shape=True
        ),
        exponent(k3_A, "k3", A, 4.0, by_shape=True),
        exponent(k3_T, "k3", T, 8.0, by_shape=True),
    ),
    coefficients=(Coefficient(k3, "N/mm3", "stiffness", power_surface(k30, {A: k3_A, T: k3_T})),),
    force=k3 * x**3,
    energy=k3 * x**4 / 4,
)
