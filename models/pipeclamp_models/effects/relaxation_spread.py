"""Relaxation spread: a spring in series with a springpot, k_r (i w tau_r)^beta_r / (1 + (i w tau_r)^beta_r), in arms.

Its relaxation times are spread about tau_r as Cole and Cole's, the wider the smaller beta_r; with beta_r = 1 there is
one. The spread is cut into cells, evenly in log tau, and each has a Maxwell arm with the stiffness of the whole cell,
so that k_r is met exactly. From tau_r/10 to 10 tau_r the complex stiffness is met within 4 %, and within 7 % a decade
and a half to each side. A step is exact for a displacement that is linear over it.
"""

from itertools import pairwise

import sympy as sp
from sympy.codegen.cfunctions import expm1

from pipeclamp_models.equations.effect import Coefficient, Effect, Parameter, State
from pipeclamp_models.equations.literature import COLE, KOELLER, PARK
from pipeclamp_models.equations.relaxation_times import LOWER, STARTS, UPPER
from pipeclamp_models.equations.symbols import A_typical, F_typical, compliance, h, y, y_previous

ARMS = 7
DECADES = sp.Rational(1, 2)
"""Between neighbouring relaxation times, for beta_r = 1; over the root of beta_r otherwise."""

k_r, tau_r, beta_r = sp.symbols("k_r tau_r beta_r", real=True)
distance = DECADES * sp.log(10) / sp.sqrt(beta_r)


def share_below(logarithm: sp.Expr) -> sp.Expr:
    """Give the share of the stiffness with relaxation times below tau_r exp(logarithm)."""
    slant = sp.tan(sp.pi * beta_r / 2) * sp.tanh(beta_r * logarithm / 2)
    return sp.Rational(1, 2) + sp.atan(slant) / (sp.pi * beta_r)


places = [arm - sp.Rational(ARMS - 1, 2) for arm in range(ARMS)]
shares = [0, *(share_below((low + high) / 2 * distance) for low, high in pairwise(places)), 1]
k, tau, q = (sp.symbols(f"{name}_r1:{ARMS + 1}", real=True) for name in ("k", "tau", "q"))


def after(arm: int) -> sp.Expr:
    """Give the force of an arm after a step."""
    ramp = sp.Piecewise((-tau[arm] / h * expm1(-h / tau[arm]), h > 0), (1, True))
    return sp.exp(-h / tau[arm]) * q[arm] + k[arm] * ramp * (y - y_previous)


EFFECT = Effect(
    id="relaxation_spread",
    part="clamp",
    does="viscoelasticity with a spread of relaxation times (fractional), by three parameters",
    source=f"{KOELLER}, spring and springpot in series; {COLE}, the spread; {PARK}: arms in its place, here {ARMS}",
    looks_like="stiffness and damping that rise slowly with f over decades, both in proportion to A",
    imitated_by=("relaxation", "stiffness_frequency", "viscous"),
    told_apart_by="two decades of frequency at one amplitude: the loss factor hardly changes, where a single "
    "relaxation time makes a hump of one decade",
    special_cases=("relaxation",),
    many_of="relaxation",
    parameters=(
        Parameter(k_r, "N/mm", "stiffness of all arms", (0.1 * F_typical / A_typical,) * len(STARTS), lower=0.0),
        Parameter(tau_r, "s", "relaxation time in the middle", STARTS, LOWER, UPPER),
        Parameter(
            beta_r, "-", "order of the springpot: 1 one relaxation time, less a wider spread", (0.5,) * len(STARTS),
            lower=0.2, upper=1.0,
        ),
    ),
    coefficients=(
        *(
            Coefficient(symbol, "N/mm", None, k_r * (above - below))
            for symbol, (below, above) in zip(k, pairwise(shares), strict=True)
        ),
        *(
            Coefficient(symbol, "s", "relaxation", tau_r * sp.exp(place * distance))
            for symbol, place in zip(tau, places, strict=True)
        ),
    ),
    force=sp.Add(*q),
    states=tuple(
        State(symbol, "N", f"force of arm {arm + 1}", update=after(arm)) for arm, symbol in enumerate(q)
    ),
    energy=sp.Add(*(compliance(stiffness) * force**2 / 2 for stiffness, force in zip(k, q, strict=True))),
)  # fmt: skip
