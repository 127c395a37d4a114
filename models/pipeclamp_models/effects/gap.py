"""Gap: the elastic path engages beyond a clearance, x = (|y| - g)+ sgn y in place of y."""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import SHAW, WORDEN
from pipeclamp_models.equations.symbols import A_typical, x, y

g = sp.Symbol("g", real=True)

EFFECT = Effect(
    id="gap",
    part="clamp",
    does="the elastic path engages beyond a clearance only",
    source=f"{WORDEN}, on piecewise linear stiffness (backlash); {SHAW}",
    looks_like="a flat middle of the loop between two kinks near zero, worst in the smallest loops",
    imitated_by=("cubic_stiffness", "memory", "play"),
    told_apart_by="a test at an amplitude near the clearance: the elastic force nearly vanishes",
    parameters=(
        Parameter(
            g, "mm", "half the clearance", tuple(share * A_typical for share in (0.01, 0.05, 0.2)), lower=0.0,
            upper=A_typical, neutral=0.0,
        ),
    ),
    replaces={x: sp.sign(y) * sp.Max(sp.Abs(y) - g, 0)},
)  # fmt: skip
