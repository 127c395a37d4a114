"""The symbols that effects are written in, each with its unit and what it stands for.

Fast signals change within a cycle; slow ones are constant, or nearly so, over a cycle. A
coefficient that depends on slow signals only is computed once per cycle in every realisation.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from pipeclamp_models.base import signals


@dataclass(frozen=True)
class Signal:
    """A quantity that every effect may use."""

    symbol: sp.Symbol
    unit: str
    meaning: str


y = sp.Symbol("y", real=True)
x = sp.Symbol("x", real=True)
v = sp.Symbol("v", real=True)
a = sp.Symbol("a", real=True)
y_previous = sp.Symbol("y_previous", real=True)
h = sp.Symbol("h", nonnegative=True)

F_path = sp.Symbol("F_path", real=True)
F_moved = sp.Function("F_moved", real=True)

A = sp.Symbol("A", positive=True)
f = sp.Symbol("f", positive=True)
T = sp.Symbol("T", positive=True)
N = sp.Symbol("N", nonnegative=True)
rho = sp.Symbol("rho", positive=True)

FAST = (
    Signal(y, "mm", "displacement"),
    Signal(x, "mm", "displacement of the elastic path: y, unless an effect puts something in series with it"),
    Signal(v, "mm/s", "velocity"),
    Signal(a, "mm/s2", "acceleration"),
    Signal(y_previous, "mm", "displacement at the sample before"),
    Signal(h, "s", "time since the sample before"),
)
SLOW = (
    Signal(A, "mm", "amplitude of the fundamental of the motion"),
    Signal(f, "Hz", "frequency of the fundamental of the motion"),
    Signal(T, "K", "temperature of the specimen"),
    Signal(N, "-", "load cycles that the specimen has seen"),
    Signal(rho, "g/cm3", "density of the wire mesh"),
)

SERIES = (
    Signal(F_path, "N", "force of all else in the clamp, after the step"),
    Signal(
        sp.Symbol(F_moved.__name__, real=True),
        "N",
        "the same at another place, reached at a velocity; sgn v is smooth below another one",
    ),
)
"""What an effect in series with the whole clamp may use besides."""


def unit(symbol: sp.Symbol) -> str:
    """Give the unit of a slow signal; a further condition's is in its column's name."""
    return next((signal.unit for signal in SLOW if signal.symbol == symbol), "in its name")


A_0 = sp.Symbol("A_0", positive=True)
f_0 = sp.Symbol("f_0", positive=True)
T_0 = sp.Symbol("T_0", positive=True)
v_0 = sp.Symbol("v_0", positive=True)
v_r = sp.Symbol("v_r", positive=True)
y_r = sp.Symbol("y_r", positive=True)

rho_0 = sp.Symbol("rho_0", positive=True)

REFERENCES = {symbol: signals.REFERENCES[str(symbol)] for symbol in (A_0, f_0, T_0, v_0, rho_0)}
"""Reference values of ratios."""

FIXED = (
    Signal(A_0, "mm", "reference amplitude, 1 mm"),
    Signal(f_0, "Hz", "reference frequency, 1 Hz"),
    Signal(T_0, "K", "reference temperature, 293.15 K"),
    Signal(v_0, "mm/s", "reference velocity, 1 mm/s"),
    Signal(rho_0, "g/cm3", "reference density, 2.286 g/cm3"),
    Signal(v_r, "mm/s", "velocity below which sgn v is smooth"),
    Signal(y_r, "mm", "displacement below which sgn y is smooth"),
)

A_typical = sp.Symbol("A_typical", positive=True)
F_typical = sp.Symbol("F_typical", positive=True)
f_typical = sp.Symbol("f_typical", positive=True)
f_lowest = sp.Symbol("f_lowest", positive=True)
f_highest = sp.Symbol("f_highest", positive=True)
T_lowest = sp.Symbol("T_lowest", positive=True)
T_highest = sp.Symbol("T_highest", positive=True)
A_highest = sp.Symbol("A_highest", positive=True)
N_lowest = sp.Symbol("N_lowest", positive=True)
N_highest = sp.Symbol("N_highest", positive=True)
y_middle = sp.Symbol("y_middle", real=True)
y_reach = sp.Symbol("y_reach", positive=True)

SCALES = (
    A_typical, A_highest, F_typical, f_typical, f_lowest, f_highest, T_lowest, T_highest, N_lowest, N_highest,
    y_middle, y_reach,
)  # fmt: skip
"""Sizes of a campaign's data, in which starts and bounds of parameters are stated."""

y_nearest, y_farthest = sp.Max(sp.Abs(y_middle) - y_reach, 0), sp.Abs(y_middle) + y_reach
"""Between which distances from zero the tests move: 0 and the largest amplitude where they move about zero."""

v_lowest, v_typical, v_highest = (
    2 * sp.pi * f * A for f, A in ((f_lowest, A_typical), (f_typical, A_typical), (f_highest, A_highest))
)
"""Peak velocities of the data in these sizes, mm/s: at the lowest frequency, usually, and the most."""


def condition_symbol(column: str) -> sp.Symbol:
    """Give the slow signal of a further column of runs.csv."""
    return sp.Symbol(signals.condition_signal(column), real=True)


def condition_size(column: str) -> sp.Symbol:
    """Give the data's scale of a further column: its largest absolute value."""
    return sp.Symbol(signals.size_of(signals.condition_signal(column)), positive=True)


def signed_power(velocity: sp.Expr, exponent: sp.Expr) -> sp.Expr:
    """|v/v0|^alpha sgn v, smooth at v = 0 within the velocity v_r.

    v (v^2 + v_r^2)^((alpha - 1)/2) in units of v0. It is odd and passive for every alpha >= 0,
    has a finite slope, and differs from the sharp form by less than (1 - alpha)/2 (v_r/v)^2.
    """
    return velocity / v_0 * ((velocity**2 + v_r**2) / v_0**2) ** ((exponent - 1) / 2)


def compliance(stiffness: sp.Expr) -> sp.Expr:
    """1/k; 0 where there is no stiffness, for a spring that isn't there stores no energy."""
    return sp.Piecewise((1 / stiffness, stiffness > 0), (0, True))


def smooth_sign(quantity: sp.Expr, width: sp.Expr) -> sp.Expr:
    """Sgn q, smooth at q = 0 within the given width of the same unit."""
    return quantity / sp.sqrt(quantity**2 + width**2)
