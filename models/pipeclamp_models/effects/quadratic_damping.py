"""Quadratic damping, air pumped through the mesh: F = c2 v |v|."""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import INMAN, JIANG, NAYFEH
from pipeclamp_models.equations.symbols import A_highest, F_typical, f_highest, v

c2 = sp.Symbol("c2", real=True)

EFFECT = Effect(
    id="quadratic_damping",
    part="clamp",
    does="air pumped through the mesh: a force with v |v|",
    source=f"{JIANG}, Eq. 10 (b2); {NAYFEH}, on quadratic damping; {INMAN}",
    looks_like="loops that widen as (f A)^2: only fast, large runs show it",
    imitated_by=("viscous",),
    told_apart_by="the highest frequency at the largest amplitude: the extra area grows fourfold when f doubles",
    parameters=(
        Parameter(
            c2, "N s2/mm2", "coefficient", 0.03 * F_typical / (2 * sp.pi * f_highest * A_highest) ** 2, lower=0.0
        ),
    ),
    force=c2 * v * sp.Abs(v),
)
