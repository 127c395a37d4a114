"""Oil damper with relief valve: a spring in series with a dashpot |w|^a up to a relief force, beyond it less steep.

Up to F_oil the dashpot holds F_oil |w/v_oil|^a_oil, beyond it goes on straight with a share p_oil of its slope there.
What thins the oil, as warmth does, makes the dashpot weaker, and leaves the valve as it is.
What the spring's force lacks to the one that the dashpot would hold at the step's speed falls as exp(-rate), at a rate
that the midpoint rule takes from within the step. So the force never overshoots, however stiff the oil, and a step is
exact for a_oil = p_oil = 1. With 512 steps a cycle the force is within 0.1 % (rms) while the spring gives by more than
2 % of the stroke; a spring that gives less is late by half a step.
"""

import sympy as sp

from pipeclamp_models.equations.effect import Coefficient, Effect, Parameter, Stage, State
from pipeclamp_models.equations.literature import AKCELYAN, DIXON, KASAI
from pipeclamp_models.equations.symbols import (
    A_typical,
    F_typical,
    compliance,
    h,
    v_highest,
    v_lowest,
    v_typical,
    y,
    y_previous,
)

k_o, F_o, v_o, a_o, p_o, q = sp.symbols("k_oil F_oil v_oil a_oil p_oil q_oil", real=True)
thickness = sp.Symbol("mu_oil", positive=True)
spring = sp.Symbol("spring_oil", real=True)
speed, held, at_first, midway = sp.symbols("speed_oil held_oil rate_oil rate_oil_midway", real=True)
move = y - y_previous

SMALLEST = sp.Rational(1, 10**6)
"""Share of the relief force below which the dashpot is viscous, so that its powers have slopes."""
REACHED = sp.Rational(1, 10**9)
"""Share of the relief force that counts as nothing left."""

LEAST = 0.01
"""Share of the stroke by which the spring gives at least under the whole force: if less, there is a dashpot alone."""


v_relief = v_o * thickness ** (-1 / a_o)
"""Speed of the dashpot at the relief force."""


def within(value: sp.Expr) -> sp.Expr:
    """Give a value, or the nearer end of -1 to 1."""
    return sp.Max(-1, sp.Min(1, value))


def power(value: sp.Expr, exponent: sp.Expr, smallest: sp.Expr) -> sp.Expr:
    """|value|^exponent sgn value up to 1, straight below the smallest."""
    return within(value) * sp.Max(sp.Min(sp.Abs(value), 1), smallest) ** (exponent - 1)


def speed_under(force: sp.Expr) -> sp.Expr:
    """Give the dashpot's speed, mm/s."""
    load = force / F_o
    return v_relief * (power(load, 1 / a_o, SMALLEST) + (load - within(load)) / (p_o * a_o))


def force_at(velocity: sp.Expr) -> sp.Expr:
    """Give the dashpot's force, N."""
    flow = velocity / v_relief
    return F_o * (power(flow, a_o, SMALLEST ** (1 / a_o)) + p_o * a_o * (flow - within(flow)))


def rate(force: sp.Expr) -> sp.Expr:
    """Give how fast what is left falls at a force, over the step."""
    left = held - force
    gone = sp.Abs(left) <= REACHED * F_o
    whole = sp.Piecewise((1, gone), (left, True))
    return spring * sp.Piecewise((h * v_relief / F_o, gone), ((move - h * speed_under(force)) / whole, True))


def after(falls: sp.Expr) -> sp.Expr:
    """Give the force when what was left has fallen by exp(-falls)."""
    return held + (q - held) * sp.exp(-falls)


reliefs = [share * F_typical for share in (0.4, 0.1, 0.2, 0.2)]
gives = [share * A_typical for share in (0.3, 0.5, 0.1, 0.03)]
"""How far the spring gives under the relief force."""

EFFECT = Effect(
    id="oil_damper",
    part="clamp",
    does="an oil damper: a spring in series with a dashpot that a valve relieves",
    source=f"{KASAI}; {AKCELYAN}: Maxwell elements with |v|^alpha and with a relief valve, here in one; {DIXON}, on "
    "valves",
    looks_like="a loop that is rounded at two opposite corners and flat along its long sides, the fuller the "
    "faster; stiffness that rises with f",
    imitated_by=("relaxation", "viscous", "memory", "bouc_wen", "power_damping"),
    told_apart_by="one amplitude over a decade of frequency: the flat sides rise with speed, by p_oil of what they did "
    "below the relief force, where slip stays",
    special_cases=("relaxation", "viscous", "quadratic_damping"),
    parameters=(
        Parameter(
            k_o, "N/mm", "stiffness of the oil and its mounting",
            tuple(relief / give for relief, give in zip(reliefs, gives, strict=True)), lower=0.0,
            upper=F_typical / (LEAST * A_typical),
        ),
        Parameter(
            F_o, "N", "force at which the valve relieves", tuple(reliefs), lower=1e-3 * F_typical, upper=10 * F_typical
        ),
        Parameter(
            v_o, "mm/s", "speed of the dashpot at that force", tuple(share * v_typical for share in (2, 0.2, 0.4, 0.3)),
            lower=1e-3 * v_lowest, upper=100 * v_highest,
        ),
        Parameter(a_o, "-", "exponent of the speed below it", (0.6, 0.8, 0.8, 0.8), lower=0.2, upper=2.0),
        Parameter(
            p_o, "-", "slope beyond it over the slope there", (0.5, 0.3, 0.15, 0.15), lower=0.01, upper=1.0,
            neutral=1.0,
        ),
    ),
    coefficients=(Coefficient(thickness, "-", "damping", sp.Integer(1)), Coefficient(spring, "N/mm", "series", k_o)),
    force=q,
    stages=(
        Stage(speed, "mm/s", "mean speed of the step", sp.Piecewise((move / h, h > 0), (0, True))),
        Stage(held, "N", "force that the dashpot would hold at that speed", force_at(speed)),
        Stage(at_first, "-", "rate at which the force nears it at first", rate(q)),
        Stage(midway, "-", "rate at which it nears it midway", rate(after(at_first / 2))),
    ),
    states=(
        State(q, "N", "force of the damper", update=sp.Piecewise((after(midway), h > 0), (q + spring * move, True))),
    ),
    energy=compliance(spring) * q**2 / 2,
)  # fmt: skip
