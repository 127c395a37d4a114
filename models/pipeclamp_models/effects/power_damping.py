"""Damping of the base law: F = c |v/v0|^alpha sgn v, c = c0 (A/A0)^a (f/f0)^b, alpha likewise."""

import sympy as sp

from pipeclamp_models.equations.effect import Coefficient, Effect, Parameter, exponent, power_surface
from pipeclamp_models.equations.literature import JIANG
from pipeclamp_models.equations.symbols import A, F_typical, f, signed_power, v, v_0, v_typical

c, c0, c_A, c_f = sp.symbols("c c0 c_A c_f", real=True)
alpha, alpha0, alpha_A, alpha_f = sp.symbols("alpha alpha0 alpha_A alpha_f", real=True)

EFFECT = Effect(
    id="power_damping",
    part="base",
    does="the base law's damping, a power of the velocity",
    source=f"{JIANG}, Eq. 17, 23 and 24",
    looks_like="the loop has no area",
    imitated_by=("memory", "coulomb", "viscous"),
    told_apart_by="amplitude and frequency swept apart: it follows the velocity alone",
    parameters=(
        Parameter(
            c0,
            "N",
            "damping force at v0, A0, f0",
            0.3 * F_typical / sp.sqrt(v_typical / v_0),
            lower=0.0,
        ),
        exponent(c_A, "c", A, 4.0),
        exponent(c_f, "c", f, 3.0),
        Parameter(alpha0, "-", "exponent of the velocity at A0, f0", 0.5, lower=0.0, upper=2.5),
        exponent(alpha_A, "alpha", A, 3.0),
        exponent(alpha_f, "alpha", f, 2.0),
    ),
    coefficients=(
        Coefficient(c, "N", "damping", power_surface(c0, {A: c_A, f: c_f})),
        Coefficient(alpha, "-", None, power_surface(alpha0, {A: alpha_A, f: alpha_f})),
    ),
    force=c * signed_power(v, alpha),
)
