"""Viscous damping: F = c1 v."""

import sympy as sp

from pipeclamp.effect import Effect, Parameter
from pipeclamp.symbols import A_typical, F_typical, f_typical, v

c1 = sp.Symbol("c1", real=True)

EFFECT = Effect(
    id="viscous",
    part="clamp",
    source="Jiang et al. 2020, Eq. 14 (c v); EFFECTS.md",
    looks_like="quadrature of the fundamental that grows as f A: loops that widen with frequency",
    imitated_by=("delay", "power_damping"),
    told_apart_by="a wider range of frequency at one amplitude: the loop's area grows in proportion to f",
    parameters=(
        Parameter(
            c1, "N s/mm", "viscous coefficient", 0.05 * F_typical / (2 * sp.pi * f_typical * A_typical), lower=0.0
        ),
    ),
    force=c1 * v,
)
