"""Slip spread: elastic-slip elements whose slip displacements are spread as phi^chi up to a largest one.

Four parameters, as Segalman's: F_S = the force at which all slip, K_T = the stiffness while all stick, chi, beta. The
spread is cut into cells that grow evenly from small to large; the element of a cell has the stiffness and the slip
force of the whole cell, so that F_S and K_T are met exactly.
"""

from itertools import pairwise

import sympy as sp

from pipeclamp_models.equations.effect import Coefficient, Effect, Parameter, State
from pipeclamp_models.equations.literature import IWAN, MASING, SEGALMAN
from pipeclamp_models.equations.symbols import A_typical, F_typical, compliance, y, y_previous

CELLS = 14
"""Cells of the spread, the lowest up to 1/196 of the largest slip displacement; one more element is the peak there."""

F_S, K_T, chi, beta = sp.symbols("F_S K_T chi beta_S", real=True)
edges = [sp.Rational(cell, CELLS) ** 2 for cell in range(CELLS + 1)]
"""Of the cells, over the largest slip displacement."""


def moment(order: int) -> list[sp.Expr]:
    """Give the share of each cell, then of the peak, in the whole stiffness (order 0) or slip force (order 1)."""
    powers = [edge ** (chi + 1 + order) if edge else edge for edge in edges]
    spread = sp.Integer(1) if order == 0 else (chi + 1) / (chi + 2)
    cells = [spread * (upper - lower) for lower, upper in pairwise(powers)]
    return [part / (spread + beta) for part in (*cells, beta)]


stiffnesses, slips = ([whole * part for part in moment(order)] for order, whole in enumerate((K_T, F_S)))
count = len(slips)
k, slip, z = (sp.symbols(f"{name}_w1:{count + 1}", real=True) for name in ("k", "slip", "z"))


def after(element: int) -> sp.Expr:
    """Give the force of an element after a step."""
    trial, most = z[element] + k[element] * (y - y_previous), slip[element]
    return sp.Piecewise((most, trial > most), (-most, trial < -most), (trial, True))


starts = [share * F_typical for share in (0.15, 0.12, 0.08)]
limits = [share * A_typical for share in (0.05, 0.2, 0.6)]

EFFECT = Effect(
    id="slip_spread",
    part="clamp",
    does="a continuous spread of slip forces (Iwan), by four parameters",
    source=f"{SEGALMAN}, here in {CELLS} cells and the peak; {IWAN}; {MASING}",
    looks_like="force just after reversals bends over gradually; rate-independent; loops of all sizes are pieces of "
    "one curve (Masing), and small ones lose as A^(chi + 3)",
    imitated_by=("memory", "bouc_wen"),
    special_cases=("memory",),
    many_of="memory",
    told_apart_by="amplitudes over a decade: loss over amplitude is a straight line in logarithms, where a few "
    "elements make steps",
    parameters=(
        Parameter(F_S, "N", "force at which all elements slip", tuple(starts), lower=0.0, upper=10 * F_typical),
        Parameter(
            K_T, "N/mm", "stiffness while all stick",
            tuple(2 * start / limit for start, limit in zip(starts, limits, strict=True)), lower=0.0,
            upper=200 * F_typical / A_typical,
        ),
        Parameter(chi, "-", "exponent of the spread", (-0.3,) * 3, lower=-0.95, upper=1.0),
        Parameter(
            beta, "-", "stiffness of the peak over that of the spread", (0.3,) * 3, lower=0.0, upper=50.0, neutral=0.0
        ),
    ),
    coefficients=(
        *(Coefficient(symbol, "N/mm", "sticking", part) for symbol, part in zip(k, stiffnesses, strict=True)),
        *(Coefficient(symbol, "N", "slip", part) for symbol, part in zip(slip, slips, strict=True)),
    ),
    force=sp.Add(*z),
    states=tuple(
        State(symbol, "N", f"force of element {number + 1}", update=after(number)) for number, symbol in enumerate(z)
    ),
    energy=sp.Add(*(compliance(stiffness) * force**2 / 2 for stiffness, force in zip(k, z, strict=True))),
)  # fmt: skip
