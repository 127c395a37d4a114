"""Contact that only pushes: F = F_h ((d/A_0)^n_h + chi_h (d/A_0)^m_h d')+ against what is met, at a depth d.

The sign of F_h is the side of the nearer stop or rest, s: its depth is d = (s y - y_h)+. Where q_h > 0 there is another
one of the same kind on the other side, behind a free travel of 1/q_h: its depth is d = (-s y + y_h - 1/q_h)+.
A power of d is written as d (d^2 + y_r^2)^((n - 1)/2), which is smooth where the contact opens.
"""

import sympy as sp

from pipeclamp_models.equations.effect import Coefficient, Effect, Parameter, exponent, power_surface
from pipeclamp_models.equations.literature import HUNT, TSUJI
from pipeclamp_models.equations.symbols import A_0, A_highest, F_typical, T, v, v_highest, y, y_r

F_h, y_h, q_h, n_h, chi_h, m_h, h_T = sp.symbols("F_h y_h q_h n_h chi_h m_h h_T", real=True)
stiff, losing = sp.symbols("contact_F contact_chi", real=True)
side = sp.sign(F_h)

LONGEST = 10**9
"""Free travel in mm in the place of none that is known."""
nearer = sp.Max(side * y - y_h, 0)
farther = sp.Max(q_h * (y_h - side * y) - 1, 0) / sp.Max(q_h, sp.Rational(1, LONGEST))


def smoothed(depth: sp.Expr, power: sp.Expr) -> sp.Expr:
    """(d/A_0)^power, smooth at d = 0."""
    return ((depth**2 + y_r**2) / A_0**2) ** (power / 2)


def pushed(depth: sp.Expr, towards: sp.Expr) -> sp.Expr:
    """Force over F_h at a depth and a velocity towards the stop."""
    elastic, lossy = (depth / A_0 * smoothed(depth, power - 1) for power in (n_h, m_h))
    return sp.Max(elastic + losing * towards * lossy, 0)


def stored(depth: sp.Expr) -> sp.Expr:
    """Work of the elastic force up to a depth, over F_h."""
    return A_0 / (n_h + 1) * (smoothed(depth, n_h + 1) - (y_r / A_0) ** (n_h + 1))


HERTZ = 1.5
"""Exponent of round bodies; 1 of flat ones."""
sides = (1, -1, -1, 1, 1, 1, -1)
places = (0.0, 0.0, 0.6, 0.6, 0.6, 0.3, 0.3)
travels = (None, None, None, None, 1.2, 1.0, 1.0)
"""Starts of which side, of where, and of the free travel, in units of the largest amplitude."""

EFFECT = Effect(
    id="unilateral_contact",
    part="clamp",
    does="a stop, a rest or a loose guide, which only pushes, on one side or at unequal clearances",
    source=f"{HUNT}, k d^n (1 + 3/2 alpha d'); {TSUJI}, a damping of d^(1/4) d' beside d^(3/2)",
    looks_like="a hook at one end of the loop, or unlike ones at both: from one displacement on the force rises "
    "steeply, less steeply on the way back, and the loop closes where the contact opens",
    imitated_by=("end_stop", "asymmetry", "gas_spring", "pressed_slip", "directional_damping"),
    special_cases=("asymmetry", "end_stop"),
    told_apart_by="the same stroke about another mean: the hook stays at its displacement, and away from it the force "
    "is as without it",
    parameters=(
        Parameter(
            F_h, "N", "force at a depth of 1 mm at 20 degC; above 0 where the nearer contact lies at y > 0",
            tuple(
                on * 0.4 * F_typical / ((1 - place) * A_highest / A_0) ** HERTZ
                for on, place in zip(sides, places, strict=True)
            ),
        ),
        Parameter(
            y_h, "mm", "displacement towards the nearer contact at which it is touched",
            tuple(place * A_highest for place in places), lower=-0.8 * A_highest,
            upper=0.98 * A_highest,
        ),
        Parameter(
            q_h, "1/mm", "one over the free travel between two contacts; 0 where there is one",
            tuple(1 / (travel * A_highest) if travel else 0.0 for travel in travels), lower=0.0, upper=2.5 / A_highest,
            neutral=0.0, known_within=1 / A_highest,
        ),
        Parameter(
            n_h, "-", "exponent of the depth: 1 flat, 1.5 round", (HERTZ,) * len(places), lower=0.7, upper=2.5,
            neutral=HERTZ, known_within=0.5,
        ),
        Parameter(
            chi_h, "s/mm", "damping force at a depth of 1 mm per velocity towards the contact, over F_h",
            (0.3 / v_highest,) * len(places), lower=0.0, upper=3 / v_highest, neutral=0.0,
        ),
        Parameter(
            m_h, "-", "exponent of the depth in the damping: 1.5 as Hunt and Crossley, 0 for a dashpot",
            (HERTZ,) * len(places), lower=0.0, upper=1.75, neutral=HERTZ, known_within=0.75,
        ),
        exponent(h_T, "the contact's stiffness", T, 8.0),
    ),
    coefficients=(
        Coefficient(stiff, "N", "stiffness", power_surface(F_h, {T: h_T})),
        Coefficient(losing, "s/mm", "damping", chi_h),
    ),
    force=stiff * (pushed(nearer, side * v) - pushed(farther, -side * v)),
    energy=side * stiff * (stored(nearer) + stored(farther)),
)  # fmt: skip
