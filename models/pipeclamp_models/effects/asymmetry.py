"""Asymmetry, the two halves pressed unequally: F = k2 y^2."""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import JIANG, NAYFEH
from pipeclamp_models.equations.symbols import A_typical, F_typical, x

k2 = sp.Symbol("k2", real=True)

EFFECT = Effect(
    id="asymmetry",
    part="clamp",
    does="the two halves pressed unequally: a force with y^2",
    source=f"{JIANG}, Eq. 10 (even powers); {NAYFEH}, on quadratic stiffness",
    looks_like="one end of the loop steeper than the other: even harmonics in phase, and a mean force, both as A^2",
    imitated_by=("offset", "directional_damping", "directional_slip", "gas_spring"),
    told_apart_by="a sweep of amplitude: the second harmonic grows as A^2, an offset doesn't grow",
    parameters=(Parameter(k2, "N/mm2", "coefficient", 0.01 * F_typical / A_typical**2, neutral=0.0),),
    force=k2 * x**2,
    energy=k2 * x**3 / 3,
)
