"""Slip under a pressing force that follows the displacement: F = z_n w, dw = dy/x_n while |w| < 1, else w = +-1.

The slip force is z_n = z_0 + mu_p y+ + mu_n (-y)+, for what deflects presses the sliding parts. A pressing force that
falls to one side, as of a spring under a static load, ends where nothing presses. The way x_n until it slips stays, as
the tangential stiffness of rough surfaces grows with what presses them. While it sticks, the force is a function of y
alone, and slip shortens w: no motion gains work. Under a load that falls to one side it sticks as y^2 does.
"""

import sympy as sp

from pipeclamp_models.equations.effect import Coefficient, Effect, Parameter, State
from pipeclamp_models.equations.literature import SHERIF, WHITEMAN, YANG
from pipeclamp_models.equations.symbols import A_typical, F_typical, y, y_previous

z_0, mu_p, mu_n, x_n, w_n = sp.symbols("z_0 mu_p mu_n x_n w_n", real=True)
middle, positive, negative = sp.symbols("slip_0 nu_p nu_n", real=True)
trial, start = w_n + (y - y_previous) / x_n, y - x_n * w_n


SMALLEST = sp.Rational(1, 10**9)
"""N/mm, so that nothing is divided by a growth of zero where the pressing force doesn't fall."""


def pressing_way(beyond: sp.Expr, growth: sp.Expr) -> sp.Expr:
    """Give the way to one side over which the pressing force changes: it ends where nothing presses any more."""
    falls = sp.Min(growth, -SMALLEST)
    return sp.Piecewise((sp.Min(beyond, -middle / falls), growth < 0), (beyond, True))


def work_beyond(side: int, growth: sp.Expr) -> sp.Expr:
    """Give the integral of the pressing way (s - start) over s from the start to y: what one side stores."""

    def up_to(place: sp.Expr) -> sp.Expr:
        beyond = sp.Max(side * place, 0)
        way = pressing_way(beyond, growth)
        further = (beyond**2 - way**2) / 2 - side * start * (beyond - way)
        return way**2 * (way / 3 - side * start / 2) + way * further

    return up_to(y) - up_to(start)


size = F_typical / A_typical
growths = ((0.15, 0.15), (0.1, -0.03), (-0.03, 0.1), (0.15, 0.15))
pressing = middle + positive * sp.Max(y, 0) + negative * sp.Max(-y, 0)

EFFECT = Effect(
    id="pressed_slip",
    part="clamp",
    does="slip under a pressing force that follows the displacement",
    source=f"{YANG}: slip and stick where the normal load is n0 + gamma y; {WHITEMAN}: a load that grows to both "
    f"sides; {SHERIF}: tangential stiffness in proportion to the normal load",
    looks_like="a loop that is wider the further out it is, on one side or on both, or narrower on the "
    "other, at any speed; each reversal's step takes the same way",
    imitated_by=(
        "displacement_friction", "memory", "bouc_wen", "self_centring", "slip_spread", "power_damping", "asymmetry"
    ),
    told_apart_by="slow small cycles about several means: how wide and steep they are follows their mean",
    special_cases=("memory", "displacement_friction", "asymmetry"),
    essence=(mu_p, mu_n),
    parameters=(
        Parameter(
            z_0, "N", "slip force in the middle", tuple(share * F_typical for share in (0.02, 0.1, 0.1, 0.02)),
            lower=0.0, upper=10 * F_typical, neutral=0.0, typical=0.05 * F_typical,
        ),
        Parameter(
            mu_p, "N/mm", "growth of the slip force over y > 0", tuple(each[0] * size for each in growths),
            lower=-2 * size, upper=20 * size, neutral=0.0, typical=0.1 * size,
        ),
        Parameter(
            mu_n, "N/mm", "growth of the slip force over y < 0", tuple(each[1] * size for each in growths),
            lower=-2 * size, upper=20 * size, neutral=0.0, typical=0.1 * size,
        ),
        Parameter(
            x_n, "mm", "way until it slips", tuple(share * A_typical for share in (0.05, 0.1, 0.1, 0.3)),
            lower=1e-3 * A_typical, upper=A_typical,
        ),
    ),
    coefficients=(
        Coefficient(middle, "N", "slip", z_0),
        Coefficient(positive, "N/mm", "slip", mu_p),
        Coefficient(negative, "N/mm", "slip", mu_n),
    ),
    force=sp.Max(pressing, 0) * w_n,
    states=(
        State(
            w_n, "-", "share of the slip force that it carries",
            update=sp.Max(-1, sp.Min(1, trial)),
        ),
    ),
    energy=middle * x_n * w_n**2 / 2
    + (positive * work_beyond(1, positive) + negative * work_beyond(-1, negative)) / x_n,
)  # fmt: skip
