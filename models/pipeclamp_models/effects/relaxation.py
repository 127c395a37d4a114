"""Relaxation: a Maxwell arm, dq/dt = k_m v - q/tau, exact for a displacement that is linear over a step."""

import sympy as sp
from sympy.codegen.cfunctions import expm1

from pipeclamp_models.equations.effect import Coefficient, Effect, Parameter, State
from pipeclamp_models.equations.literature import BOGRAD, FERRY
from pipeclamp_models.equations.relaxation_times import LOWER, STARTS, UPPER
from pipeclamp_models.equations.symbols import A_typical, F_typical, compliance, h, y, y_previous

k_m, tau, tau_m, q = sp.symbols("k_m tau tau_m q", real=True)
decay = sp.exp(-h / tau_m)
ramp = sp.Piecewise((-tau_m / h * expm1(-h / tau_m), h > 0), (1, True))

EFFECT = Effect(
    id="relaxation",
    part="clamp",
    does="a Maxwell arm: spring and dashpot in series",
    source=f"{FERRY}, on the Maxwell element; {BOGRAD}",
    looks_like="stiffness that rises with f and damping with a hump over f, both in proportion to A",
    imitated_by=("viscous", "stiffness_frequency", "relaxation_spread", "oil_damper"),
    told_apart_by="a wider range of frequency: the stiffness levels off and the damping falls again",
    parameters=(
        Parameter(k_m, "N/mm", "stiffness of the arm", (0.05 * F_typical / A_typical,) * len(STARTS), lower=0.0),
        Parameter(tau, "s", "relaxation time", STARTS, LOWER, UPPER),
    ),
    coefficients=(Coefficient(tau_m, "s", "relaxation", tau),),
    force=q,
    states=(State(q, "N", "force of the arm", update=decay * q + k_m * ramp * (y - y_previous)),),
    energy=compliance(k_m) * q**2 / 2,
)
