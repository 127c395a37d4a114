"""Self-centring: an elastic element that gives way at F_u, comes back at (1 - beta_c) F_u, and returns to zero: a flag.

Half a flag for each side: z = k_c y on the way out, no more than F_u; on the way back no less than (1 - beta_c) F_u,
until it is k_c y again. What it gave way by is taken back before y = 0, so that it centres the clamp.
"""

import sympy as sp

from pipeclamp_models.equations.effect import Coefficient, Effect, Parameter, State
from pipeclamp_models.equations.literature import AURICCHIO, CHRISTOPOULOS
from pipeclamp_models.equations.symbols import A_typical, F_typical, compliance, y, y_previous

k_c, F_u, beta_c, z_c = sp.symbols("k_c F_u beta_c z_c", real=True)
outward, stiffness = sp.symbols("slip_c stick_c", real=True)
elastic, trial = stiffness * y, z_c + stiffness * (y - y_previous)
way_out, way_back = sp.Min(sp.Abs(elastic), outward), sp.Min(sp.Abs(elastic), (1 - beta_c) * outward)
side = sp.Piecewise((1, y >= 0), (-1, True))

EFFECT = Effect(
    id="self_centring",
    part="clamp",
    does="a flag: gives way at one force, comes back at a lower one, and returns to zero",
    source=f"{CHRISTOPOULOS}, Fig. 1, without stiffness after yield, which the base law has; {AURICCHIO}",
    looks_like="each half of the loop is a flag on a thin pole: no width about y = 0, a wide one beyond a displacement",
    imitated_by=("displacement_friction", "memory", "end_stop"),
    told_apart_by="small cycles about zero lose nothing, and small cycles about a large displacement do",
    parameters=(
        Parameter(
            k_c, "N/mm", "stiffness before it gives way",
            tuple(force * F_typical / (limit * A_typical) for force, limit in ((0.3, 0.1), (0.3, 0.3), (0.3, 0.8))),
            lower=0.0, upper=200 * F_typical / A_typical, typical=0.4 * F_typical / A_typical,
        ),
        Parameter(
            F_u, "N", "force at which it gives way", (0.3 * F_typical,) * 3, lower=0.0, upper=10 * F_typical,
            typical=0.1 * F_typical,
        ),
        Parameter(
            beta_c, "-", "share of it by which it comes back lower", (0.5,) * 3, lower=0.0, upper=1.0,
        ),
    ),
    coefficients=(Coefficient(outward, "N", "slip", F_u), Coefficient(stiffness, "N/mm", "sticking", k_c)),
    force=z_c,
    states=(
        State(
            z_c, "N", "force of the element",
            update=side * sp.Min(sp.Max(side * trial, way_back), way_out),
        ),
    ),
    energy=compliance(stiffness) * z_c**2 / 2
    + (1 - beta_c) * outward * sp.Max(0, sp.Abs(y) - compliance(stiffness) * sp.Abs(z_c)),
)  # fmt: skip
