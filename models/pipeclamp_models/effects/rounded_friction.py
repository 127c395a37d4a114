"""Rounded friction: F = F_t tanh(v/v_t), in proportion to v well below v_t and dry friction well above it."""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import ANDERSSON, ARMSTRONG
from pipeclamp_models.equations.symbols import F_typical, v, v_highest, v_lowest, v_typical

F_t, v_t = sp.symbols("F_t v_t", real=True)

EFFECT = Effect(
    id="rounded_friction",
    part="clamp",
    does="friction that turns over at a reversal while the clamp gathers speed, as where guides are greased",
    source=f"{ANDERSSON}, F_C tanh(k_tanh v); {ARMSTRONG}, on partial fluid lubrication",
    looks_like="a step of force at each reversal that is rounded, the more of the loop the slower and smaller it is",
    imitated_by=("coulomb", "viscous", "memory", "bouc_wen", "oil_damper"),
    told_apart_by="the slowest test at the smallest amplitude: its whole loop is rounded, and its area falls with f",
    special_cases=("coulomb", "viscous"),
    many_of="coulomb",
    parameters=(
        Parameter(F_t, "N", "friction at speed", (0.05 * F_typical,) * 3, lower=0.0),
        Parameter(
            v_t, "mm/s", "speed at which 76% of that is reached", (0.1 * v_lowest, 0.3 * v_lowest, 0.5 * v_typical),
            lower=3e-3 * v_lowest, upper=2 * v_highest,
        ),
    ),
    force=F_t * sp.tanh(v / v_t),
)  # fmt: skip
