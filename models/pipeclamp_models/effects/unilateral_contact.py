"""Contact that only pushes: F = F_h ((d/A_0)^n_h + chi_h (d/A_0)^m_h d')+ against what is met, at a depth d.

The sign of F_h is the side s of the stop or rest: its depth is d = (s y - y_h)+. What is pressed together at rest, as a
hung or preloaded part is (y_h < 0), bears a force there that tests don't show, for y and F are counted from rest: it is
left out. Where the force channel shows it, that is an `offset`. A power of d is written as
d (d^2 + y_r^2)^((n - 1)/2), which is smooth where the contact opens. With a second one at an own distance on the other
side it could be any symmetric spring or damper, and stood for them.
"""

import sympy as sp

from pipeclamp_models.equations.effect import Coefficient, Effect, Parameter, exponent, power_surface
from pipeclamp_models.equations.literature import HUNT, TSUJI
from pipeclamp_models.equations.symbols import A_0, F_typical, T, v, v_highest, y, y_middle, y_r, y_reach

F_h, y_h, n_h, chi_h, m_h, h_T = sp.symbols("F_h y_h n_h chi_h m_h h_T", real=True)
stiff, losing = sp.symbols("contact_F contact_chi", real=True)
side = sp.sign(F_h)
depth, at_rest = sp.Max(side * y - y_h, 0), sp.Max(-y_h, 0)


def smoothed(depth: sp.Expr, power: sp.Expr) -> sp.Expr:
    """(d/A_0)^power, smooth at d = 0."""
    return ((depth**2 + y_r**2) / A_0**2) ** (power / 2)


def power_of(depth: sp.Expr, power: sp.Expr) -> sp.Expr:
    """(d/A_0)^power, nought where the contact is open."""
    return depth / A_0 * smoothed(depth, power - 1)


HERTZ = 1.5
"""Exponent of round bodies; 1 of flat ones."""
away = sp.Min(sp.Abs(y_middle) / y_reach, 1)
sides = (1, -1, 1, -1, 1, -1)
places = (0, 0, 0.6, 0.6, -0.5 * away, -0.5 * away)
"""Starts of which side, and of where from the middle of the tests, in units of how far they reach to either side: also
within the half before it where that isn't zero, as in tests that load a part to one side."""

EFFECT = Effect(
    id="unilateral_contact",
    part="clamp",
    does="a stop or a rest on one side, which only pushes",
    source=f"{HUNT}, k d^n (1 + 3/2 alpha d'); {TSUJI}, a damping of d^(1/4) d' beside d^(3/2)",
    looks_like="a hook at one end of the loop alone: from one displacement on the force rises steeply, less steeply on "
    "the way back, and the loop closes where the contact opens",
    imitated_by=("end_stop", "asymmetry", "gas_spring", "pressed_slip", "directional_damping"),
    special_cases=("asymmetry",),
    told_apart_by="the same stroke about another mean: the hook stays at its displacement, and away from it the force "
    "is as without it",
    parameters=(
        Parameter(
            F_h, "N", "force at a depth of 1 mm at 20 °C; above 0 where it lies at y > 0",
            tuple(
                on * 0.4 * F_typical / ((1 - place) * y_reach / A_0) ** HERTZ
                for on, place in zip(sides, places, strict=True)
            ),
        ),
        Parameter(
            y_h, "mm", "displacement towards the stop at which it is touched",
            tuple(on * y_middle + place * y_reach for on, place in zip(sides, places, strict=True)),
            lower=-sp.Abs(y_middle) - 0.8 * y_reach, upper=sp.Abs(y_middle) + 0.98 * y_reach,
        ),
        Parameter(
            n_h, "-", "exponent of the depth: 1 flat, 1.5 round", (HERTZ,) * len(places), lower=0.7, upper=2.5,
            neutral=HERTZ, known_within=0.5,
        ),
        Parameter(
            chi_h, "s/mm", "damping force at a depth of 1 mm per velocity towards the stop, over F_h",
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
    force=stiff * (sp.Max(power_of(depth, n_h) + losing * side * v * power_of(depth, m_h), 0) - power_of(at_rest, n_h)),
    energy=side * stiff * A_0 / (n_h + 1) * (smoothed(depth, n_h + 1) - smoothed(at_rest, n_h + 1))
    - stiff * power_of(at_rest, n_h) * y,
)  # fmt: skip
