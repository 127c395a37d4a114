"""A mass inside, driven through a spring: q = k_i (y - x), m_i dx'/dt = q - losses; fluid in an inertia track is one.

The mass is k_i/(2 pi f_i)^2; its losses are 2 zeta_i of critical damping, and b_i m_i |x'| x' of turbulent flow. What
thins the fluid, as warmth does, lessens the former, and leaves the latter as they are; what softens the spring leaves
the mass as it is. A step takes the spring's force and the mass's velocity at their means over it (implicit midpoint),
where the quadratic has one root. What the step dissipates is then exactly what the losses take at the mean velocity,
however long it is; its error falls with the square of h.
"""

import sympy as sp

from pipeclamp_models.equations.effect import Coefficient, Effect, Parameter, Stage, State
from pipeclamp_models.equations.literature import SINGH
from pipeclamp_models.equations.symbols import (
    A_typical,
    F_typical,
    compliance,
    f_highest,
    f_lowest,
    f_typical,
    h,
    y,
    y_previous,
)

k_i, f_i, zeta_i, b_i = sp.symbols("k_i f_i zeta_i b_i", real=True)
thickness, stiffer = sp.symbols("mu_i stiffer_i", positive=True)
q_i, s_i, mean = sp.symbols("q_i s_i s_i_mean", real=True)
turn = 2 * sp.pi * f_i
move = y - y_previous

pushed = 2 * s_i + h * turn**2 * (q_i * compliance(k_i) + stiffer * move / 2)
linear = 2 + 2 * h * thickness * zeta_i * turn + stiffer * (h * turn) ** 2 / 2
frequencies = (f_highest, 2 * f_highest, sp.sqrt(f_typical * f_highest), f_typical)

EFFECT = Effect(
    id="inner_mass",
    part="clamp",
    does="a mass inside that is driven through a spring, as fluid in an inertia track is",
    source=f"{SINGH}: chamber and inertia track, here with turbulent losses and one spring",
    looks_like="stiffness that falls with f at first and rises beyond one frequency, where damping is largest; in "
    "proportion to A but for turbulence",
    imitated_by=("relaxation", "stiffness_frequency", "inertia", "viscous", "relaxation_spread"),
    told_apart_by="frequencies on both sides of the inner resonance: damping falls again beyond it, and the stiffness "
    "levels off above the one at rest",
    special_cases=("relaxation", "viscous", "quadratic_damping", "inertia"),
    parameters=(
        Parameter(
            k_i, "N/mm", "stiffness of the spring that drives the mass", (0.3 * F_typical / A_typical,) * 4, lower=0.0,
            typical=0.1 * F_typical / A_typical,
        ),
        Parameter(
            f_i, "Hz", "frequency of the mass on its spring", frequencies,
            lower=f_lowest / 3, upper=20 * f_highest,
        ),
        Parameter(zeta_i, "-", "losses as a share of critical damping", (0.3,) * 4, lower=1e-3, upper=20.0),
        Parameter(
            b_i, "1/mm", "turbulent losses over mass and velocity squared", (0.1 / A_typical,) * 4, lower=0.0,
            upper=100.0 / A_typical, neutral=0.0,
        ),
    ),
    coefficients=(
        Coefficient(thickness, "-", "damping", sp.Integer(1)),
        Coefficient(stiffer, "-", "series", sp.Integer(1)),
    ),
    force=q_i,
    stages=(
        Stage(
            mean, "mm/s", "mean velocity of the mass over the step",
            2 * pushed / (linear + sp.sqrt(linear**2 + 4 * h * b_i * sp.Abs(pushed))),
        ),
    ),
    states=(
        State(q_i, "N", "force of the spring that drives the mass", update=q_i + k_i * stiffer * (move - h * mean)),
        State(s_i, "mm/s", "velocity of the mass", update=2 * mean - s_i),
    ),
    energy=compliance(k_i * stiffer) * q_i**2 / 2 + k_i / turn**2 * s_i**2 / 2,
)  # fmt: skip
