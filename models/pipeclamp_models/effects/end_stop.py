"""End stop: F = k_e (|y| - y_e)+ sgn y."""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import SHAW, WORDEN
from pipeclamp_models.equations.symbols import F_typical, y, y_farthest, y_nearest

k_e, y_e = sp.symbols("k_e y_e", real=True)
beyond = sp.Max(sp.Abs(y) - y_e, 0)

EFFECT = Effect(
    id="end_stop",
    part="clamp",
    does="a further spring beyond one displacement",
    source=f"{SHAW}; {WORDEN}, on piecewise linear stiffness",
    looks_like="a kink at one displacement, beyond which the loop is steeper; runs that don't reach it don't show it",
    imitated_by=("hardening", "cubic_stiffness", "exponential_stiffening"),
    told_apart_by="a larger amplitude: the kink stays at its displacement",
    parameters=(
        Parameter(k_e, "N/mm", "stiffness of the stop", (0.3 * F_typical / (y_farthest - y_nearest),) * 3, lower=0.0),
        Parameter(
            y_e,
            "mm",
            "displacement at which the stop engages",
            tuple(y_nearest + share * (y_farthest - y_nearest) for share in (0.5, 0.7, 0.88)),
            lower=0.0,
            upper=y_farthest,
        ),
    ),
    force=k_e * beyond * sp.sign(y),
    energy=k_e * beyond**2 / 2,
)
