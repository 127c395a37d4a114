"""Slip-lock: a clearance that is taken up gradually, in series with an element that slips, at another force each way.

The element's own displacement d grows with y and stops where its force reaches a slip force. Up to g there is no force,
beyond it F = F_m ((|d| - g) / x_l)^n_l, with F_m the mean of the two slip forces as identified. What makes the slip
forces follow speed or temperature leaves this curve as it is, so that no work is gained.
"""

import sympy as sp

from pipeclamp_models.equations.effect import Coefficient, Effect, Parameter, Stage, State
from pipeclamp_models.equations.literature import ARMSTRONG, BABER, JENKINS
from pipeclamp_models.equations.symbols import A_typical, F_typical, y, y_previous

x_l, z_up, z_down, g_l, n_l, d = sp.symbols("x_l z_lp z_ln g_l n_l d_l", real=True)
up, down = sp.symbols("lock_p lock_n", real=True)
most, least = sp.symbols("d_most d_least", real=True)
mean = (z_up + z_down) / 2
trial = d + y - y_previous
taken = [sp.Max(side * d - g_l, 0) / x_l for side in (1, -1)]
"""On either side: way beyond the clearance, over that of the mean slip force."""

LEAST = sp.Rational(1, 10**9)
"""Share of the mean slip force that counts as none, so that powers have slopes."""


def limit(slip: sp.Expr) -> sp.Expr:
    """Give the displacement at which a slip force is reached, mm."""
    return g_l + x_l * sp.Max(slip / mean, LEAST) ** (1 / n_l)


def power(way: sp.Expr, exponent: sp.Expr) -> sp.Expr:
    """Give a power > 1 of what isn't negative, with slopes also where it vanishes."""
    return way * sp.Max(way, LEAST) ** (exponent - 1)


slips = [share * F_typical for share in (0.4, 0.4, 0.15, 0.15)]

EFFECT = Effect(
    id="slip_lock",
    part="clamp",
    does="dry friction behind a clearance that is taken up gradually, at another force each way",
    source=f"{BABER}: slip-lock, in series with hysteresis; {JENKINS}; {ARMSTRONG}, on friction that differs between "
    "the directions. Here the element's force is a power of its own displacement, which leaves steps exact",
    looks_like="a loop that is pinched: after each reversal the force falls off, waits about zero, and grows ever "
    "more steeply until it slips",
    imitated_by=("directional_slip", "play", "bouc_wen"),
    told_apart_by="small cycles that begin at several places of a large one: the clearance moves along with the slip, "
    "where a gap stays about zero",
    special_cases=("directional_slip", "memory"),
    essence=(g_l, n_l),
    parameters=(
        Parameter(
            x_l, "mm", "way beyond the clearance on which the mean slip force is reached",
            tuple(share * A_typical for share in (0.2, 0.2, 0.1, 0.4)), lower=1e-3 * A_typical, upper=3 * A_typical,
        ),
        Parameter(z_up, "N", "slip force on the way up", tuple(slips), lower=1e-4 * F_typical, upper=10 * F_typical),
        Parameter(
            z_down, "N", "slip force on the way down", tuple(slips), lower=1e-4 * F_typical, upper=10 * F_typical
        ),
        Parameter(
            g_l, "mm", "half the clearance", tuple(share * A_typical for share in (0.02, 0.15, 0.1, 0.2)), lower=0.0,
            upper=A_typical, neutral=0.0,
        ),
        Parameter(n_l, "-", "exponent by which it is taken up", (1.5,) * 4, lower=1.0, upper=5.0, neutral=1.0),
    ),
    coefficients=(Coefficient(up, "N", "slip", z_up), Coefficient(down, "N", "slip", z_down, down=True)),
    force=mean * (power(taken[0], n_l) - power(taken[1], n_l)),
    stages=(
        Stage(most, "mm", "displacement at which it slips on the way up", limit(up)),
        Stage(least, "mm", "displacement at which it slips on the way down", -limit(down)),
    ),
    states=(
        State(
            d, "mm", "own displacement",
            update=sp.Piecewise((most, trial > most), (least, trial < least), (trial, True)),
        ),
    ),
    energy=mean * x_l * sum(power(way, n_l + 1) for way in taken) / (n_l + 1),
)  # fmt: skip
