"""Directional slip: an elastic-slip (Jenkins) element that yields at +z_p on the way up and at -z_n on the way down."""

import sympy as sp

from pipeclamp_models.equations.effect import Coefficient, Effect, Parameter, State
from pipeclamp_models.equations.literature import ARMSTRONG, JENKINS
from pipeclamp_models.equations.symbols import A_typical, F_typical, compliance, y, y_previous

k_d, z_p, z_n, z_d = sp.symbols("k_d z_p z_n z_d", real=True)
up, down, stiffness = sp.symbols("slip_p slip_n stick_d", real=True)
trial = z_d + stiffness * (y - y_previous)
limits = [share * A_typical for share in (0.05, 0.2, 0.6)]
slips = [share * F_typical for share in (0.15, 0.12, 0.08)]

EFFECT = Effect(
    id="directional_slip",
    part="clamp",
    does="an elastic-slip element that slips at another force each way",
    source=f"{JENKINS}; {ARMSTRONG}, on friction that differs between the directions",
    looks_like="a mean force that comes with slip: the way back yields at another force than the way there",
    imitated_by=("memory", "directional_damping", "asymmetry", "offset"),
    told_apart_by="amplitude and frequency swept apart: the two forces at which it yields stay, and at amplitudes that "
    "don't slip the mean force goes",
    special_cases=("memory",),
    parameters=(
        Parameter(
            k_d, "N/mm", "stiffness of the element while it sticks",
            tuple(slip / limit for slip, limit in zip(slips, limits, strict=True)), lower=0.0,
            upper=200 * F_typical / A_typical,
        ),
        Parameter(z_p, "N", "slip force on the way up", tuple(slips), lower=0.0, upper=10 * F_typical),
        Parameter(
            z_n, "N", "slip force on the way down", tuple(slips), lower=0.0, upper=10 * F_typical,
            typical=0.5 * slips[1],
        ),
    ),
    coefficients=(
        Coefficient(up, "N", "slip", z_p),
        Coefficient(down, "N", "slip", z_n, down=True),
        Coefficient(stiffness, "N/mm", "sticking", k_d),
    ),
    force=z_d,
    states=(
        State(
            z_d, "N", "force of the element",
            update=sp.Piecewise((up, trial > up), (-down, trial < -down), (trial, True)),
        ),
    ),
    energy=compliance(stiffness) * z_d**2 / 2,
)  # fmt: skip
