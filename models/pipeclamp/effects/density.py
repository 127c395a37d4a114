"""Density of the wire mesh: stiffness times (rho/rho_0)^k_rho, damping times (rho/rho_0)^c_rho."""

import sympy as sp

from pipeclamp.effect import Effect, exponent
from pipeclamp.symbols import rho, rho_0

k_rho, c_rho = sp.symbols("k_rho c_rho", real=True)

EFFECT = Effect(
    id="density",
    part="clamp",
    source="Jiang et al. 2020, Table 4 (dW and W over density); EFFECTS.md",
    looks_like="error that follows the specimen",
    imitated_by=(),
    told_apart_by="further specimens of the same densities",
    parameters=(exponent(k_rho, "the stiffness", rho, 15.0), exponent(c_rho, "the damping", rho, 15.0)),
    scales={"stiffness": (rho / rho_0) ** k_rho, "damping": (rho / rho_0) ** c_rho},
)
