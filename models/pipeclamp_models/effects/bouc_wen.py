"""Bouc-Wen with pinching: F = z (1 - p exp(-(z/w)^2)), and while |z| grows dz/dy = k_b (1 - |z/z_b|^n_b).

While |z| falls dz/dy = k_b (1 + s_b |z/z_b|^n_b): elastic for s_b = 0 (Wen's beta = gamma), Dahl's for n_b = s_b = 1
(gamma = 0). Wen's s_b is (beta - gamma)/(beta + gamma); below 0 it would create energy.

What is left to z_b falls as exp(-rate way), with a rate between 1 and n_b that changes little within a step; the four
stages of Runge and Kutta give its mean. So a step is exact for n_b = 1, whatever its size, and otherwise (n_b up to 6)
within 1e-4 of z_b where it is a quarter of z_b/k_b, within 1.3e-3 where it is half of that. Unloading goes by the same
stages; where a step passes zero force the way there is by Gauss's rule of two points.
"""

from collections.abc import Sequence

import sympy as sp

from pipeclamp_models.equations.effect import Coefficient, Effect, Parameter, Stage, State
from pipeclamp_models.equations.literature import BABER, DAHL, FOLIENTE, WEN
from pipeclamp_models.equations.symbols import A_typical, F_typical, compliance, y, y_previous

k_b, z_b, n_b, s_b, p_b, w_b, z = sp.symbols("k_b z_b n_b s_b p_b w_b z_h", real=True)
slip, stiffness = sp.symbols("slip_b stick_b", real=True)
way, load, start, left = sp.symbols("x_b load_b load_from x_left", real=True)
unload, back = sp.symbols("unload_b back_b", real=True)
steeps = sp.symbols("steep_b1:5", real=True)
rates = sp.symbols("b_b1:5", real=True)
direction = sp.Piecewise((1, y >= y_previous), (-1, True))

SMALLEST = sp.Rational(1, 10**9)
"""A load that counts as none, so that its powers have slopes."""
LARGEST = 1 - sp.Rational(1, 10**12)
"""A load that counts as whole, so that something is left to it."""
ENOUGH = 50
"""A way over z_b/k_b after which nothing is left to yield."""


def after(distance: sp.Expr) -> sp.Expr:
    """Give the load after a way by which what is left to 1 has fallen by exp(-distance)."""
    return 1 - (1 - start) * sp.exp(-distance)


def rate(loaded: sp.Expr) -> sp.Expr:
    """Give by which rate what is left to 1 falls at a load."""
    most = sp.Min(loaded, LARGEST)
    return (1 - most**n_b) / (1 - most)


def steepness(unloaded: sp.Expr) -> sp.Expr:
    """Give how steep unloading is, over the stiffness, where so much of the ultimate force is left."""
    return 1 + s_b * sp.Max(SMALLEST, sp.Min(unloaded, 1)) ** n_b


GAUSS = (sp.Rational(1, 2) - sp.sqrt(3) / 6, sp.Rational(1, 2) + sp.sqrt(3) / 6)
"""Points of Gauss's rule over a stretch of 1, which weigh alike."""


WHENS = ("at first", "in the middle", "in the middle again", "in the end")
"""Where in a step Runge and Kutta's four stages lie."""


def four_stages(symbols: Sequence[sp.Symbol], what: str, slopes: Sequence[sp.Expr]) -> tuple[Stage, ...]:
    """Give Runge and Kutta's four stages of a step."""
    return tuple(
        Stage(symbol, "-", f"{what} {when}", slope) for symbol, when, slope in zip(symbols, WHENS, slopes, strict=True)
    )


def six_times_the_mean(stages: Sequence[sp.Symbol]) -> sp.Expr:
    """Give the sum of four stages, as Runge and Kutta weigh them."""
    return stages[0] + 2 * stages[1] + 2 * stages[2] + stages[3]


yielding_from = (start, after(left * rates[0] / 2), after(left * rates[1] / 2), after(left * rates[2]))
unloading_from = (unload, unload - way * steeps[0] / 2, unload - way * steeps[1] / 2, unload - way * steeps[2])
mean = six_times_the_mean(rates) / 6
loaded = sp.Max(0, load)
yielded = loaded + (1 - loaded) * (1 - sp.exp(-left * mean))
"""Load after a step that yields: one that is next to none stays as it is at rest, so that its slope is known there."""

way_back = unload * sum(1 / steepness(unload * at) for at in GAUSS) / 2
unloading = load + way * six_times_the_mean(steeps) / 6
"""Load after a step that takes back no more than there was."""

starts = [share * F_typical for share in (0.15, 0.12, 0.08)]
limits = [share * A_typical for share in (0.05, 0.2, 0.6)]

EFFECT = Effect(
    id="bouc_wen",
    part="clamp",
    does="hysteresis that yields smoothly, pinched at zero force",
    source=f"{WEN}; {DAHL}; {BABER}: slip-lock at zero force; {FOLIENTE}. "
    "Here the pinching is a function of the force alone, which leaves steps exact",
    looks_like="a loop that yields smoothly after each reversal and is narrow where the force passes zero; "
    "rate-independent",
    imitated_by=("slip_spread", "memory"),
    told_apart_by="slow cycles of several sizes about several means: pinching stays at zero force, and small cycles "
    "creep, which those of elastic-slip elements don't",
    parameters=(
        Parameter(
            k_b, "N/mm", "stiffness at first",
            tuple(slip / limit for slip, limit in zip(starts, limits, strict=True)), lower=0.0,
            upper=200 * F_typical / A_typical,
        ),
        Parameter(z_b, "N", "ultimate force", tuple(starts), lower=1e-4 * F_typical, upper=10 * F_typical),
        Parameter(n_b, "-", "sharpness of the yield", (1.5,) * 3, lower=1.0, upper=8.0),
        Parameter(
            s_b, "-", "steepness gained on unloading from the ultimate force, over k_b", (0.0,) * 3,
            lower=0.0, upper=3.0, neutral=0.0, typical=1.0,
        ),
        Parameter(
            p_b, "-", "pinching: share of the stiffness lost at zero force", (0.3,) * 3, lower=0.0, upper=0.95,
            neutral=0.0,
        ),
        Parameter(
            w_b, "-", "width of the pinching over the ultimate force", (0.3,) * 3, lower=0.05, upper=1.0, neutral=0.3
        ),
    ),
    coefficients=(Coefficient(slip, "N", "slip", z_b), Coefficient(stiffness, "N/mm", "sticking", k_b)),
    force=z * (1 - p_b * sp.exp(-((z / (w_b * slip)) ** 2))),
    stages=(
        Stage(way, "-", "way of the step over z_b/k_b", stiffness * sp.Abs(y - y_previous) / slip),
        Stage(load, "-", "force over z_b, positive where the step loads it", sp.Min(1, direction * z / slip)),
        Stage(start, "-", "load from which it yields", sp.Max(SMALLEST, sp.Min(load, LARGEST))),
        Stage(unload, "-", "force over z_b that the step takes back first", sp.Max(0, -load)),
        *four_stages(steeps, "steepness of unloading", [steepness(place) for place in unloading_from]),
        Stage(back, "-", "way over z_b/k_b to zero force", way_back),
        Stage(left, "-", "way that is left for it", sp.Max(0, sp.Min(way - back, ENOUGH))),
        *four_stages(rates, "rate of yielding", [rate(place) for place in yielding_from]),
    ),
    states=(
        State(
            z, "N", "force before pinching",
            update=direction * slip * sp.Piecewise((unloading, way + sp.Max(0, load) <= back), (yielded, True)),
        ),
    ),
    energy=compliance(stiffness) * (z**2 + p_b * (w_b * slip) ** 2 * (sp.exp(-((z / (w_b * slip)) ** 2)) - 1)) / 2,
)  # fmt: skip
