"""Density of the wire mesh: stiffness times (rho/rho_0)^k_rho, damping times (rho/rho_0)^c_rho."""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, exponent
from pipeclamp_models.equations.literature import GIBSON, JIANG
from pipeclamp_models.equations.symbols import rho, rho_0

k_rho, c_rho = sp.symbols("k_rho c_rho", real=True)

EFFECT = Effect(
    id="density",
    part="clamp",
    does="stiffness and damping follow the density of the wire mesh",
    source=f"{JIANG}, Table 4: dW and W over density; "
    f"{GIBSON}: stiffness of cellular solids as a power of their density",
    looks_like="error that follows the specimen",
    imitated_by=(),
    told_apart_by="further specimens of the same densities",
    parameters=(exponent(k_rho, "the stiffness", rho, 15.0, 3.6), exponent(c_rho, "the damping", rho, 15.0, 3.6)),
    scales={"stiffness": (rho / rho_0) ** k_rho, "damping": (rho / rho_0) ** c_rho},
)
