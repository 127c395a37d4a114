"""Inertia of the moving fixture, a rig effect: F = m a."""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import EWINS
from pipeclamp_models.equations.symbols import A_typical, F_typical, a, f_highest

m = sp.Symbol("m", real=True)

EFFECT = Effect(
    id="inertia",
    part="rig",
    does="mass of the fixture between sensor and specimen",
    source=f"{EWINS}, on mass cancellation",
    looks_like="stiffness that falls as f^2, by the same force at every temperature: exactly -m w^2 A in phase",
    imitated_by=("stiffness_frequency", "relaxation"),
    told_apart_by="the rig run without a specimen, or a higher frequency: inertia grows as f^2",
    parameters=(
        Parameter(
            m,
            "t",
            "mass between sensor and specimen",
            0.01 * F_typical / A_typical / (2 * sp.pi * f_highest) ** 2,
            lower=0.0,
        ),
    ),
    force=m * a,
)
