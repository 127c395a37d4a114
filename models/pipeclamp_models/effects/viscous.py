"""Viscous damping: F = c1 v."""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import INMAN, JIANG
from pipeclamp_models.equations.symbols import F_typical, v, v_typical

c1 = sp.Symbol("c1", real=True)

EFFECT = Effect(
    id="viscous",
    part="clamp",
    does="viscous damping: a force with v",
    source=f"{JIANG}, Eq. 14 (c v); {INMAN}",
    looks_like="quadrature of the fundamental that grows as f A: loops that widen with frequency",
    imitated_by=("delay", "power_damping"),
    told_apart_by="a wider range of frequency at one amplitude: the loop's area grows in proportion to f",
    parameters=(Parameter(c1, "N s/mm", "viscous coefficient", 0.05 * F_typical / v_typical, lower=0.0),),
    force=c1 * v,
)
