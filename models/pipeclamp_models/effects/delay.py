"""Delay of the force channel, a rig effect: what is measured now is the force of tau_d ago."""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import EWINS, OPPENHEIM
from pipeclamp_models.equations.symbols import f_highest

tau_d = sp.Symbol("tau_d", real=True)

EFFECT = Effect(
    id="delay",
    part="rig",
    does="the force is measured late",
    source=f"{OPPENHEIM}: a shift in time turns each harmonic in proportion to its order; "
    f"{EWINS}, on errors of the measuring chain",
    looks_like="every loop opened or closed in proportion to its stiffness and f: harmonic n turned by n w tau",
    imitated_by=("viscous",),
    told_apart_by="a spring of steel in place of the clamp: its loop must have no area",
    parameters=(
        Parameter(
            tau_d,
            "s",
            "time by which the force is late",
            0.001 / f_highest,
            lower=0.0,
            upper=0.25 / f_highest,  # a quarter of a cycle later a spring looks like a damper that drives
            neutral=0.0,
        ),
    ),
    lag=tau_d,
)
