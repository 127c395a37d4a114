"""Gas spring: F = F_g ((1 - q_g y)^-n_g - 1), gas of pressure times area F_g in a column of length 1/|q_g|."""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import BAUER, QUAGLIA
from pipeclamp_models.equations.symbols import F_typical, x, y_farthest

F_g, q_g, n_g = sp.symbols("F_g q_g n_g", real=True)

SHORTEST = sp.Rational(1, 50)
"""Share of the column from which the force goes straight on, as its tangent: no gas is compressed further."""
ISOTHERMAL = sp.Rational(1, 10**6)
"""An exponent that is this near to 1 has the work of 1, to its second order."""

column = 1 - q_g * x
left = sp.Max(column, SHORTEST)
beyond = sp.Max(SHORTEST - column, 0) / left
pressure = left**-n_g
work = sp.Piecewise(
    (-sp.log(left) * (1 - (n_g - 1) * sp.log(left) / 2), n_g < 1 + ISOTHERMAL),
    ((left ** (1 - n_g) - 1) / (n_g - 1), True),
)
"""Of the gas, from the middle to where what is left of the column is `left`, over F_g/q_g."""
USUAL = 1.3
"""Exponent between the isothermal 1 of slow strokes and the adiabatic 1.4 of fast ones."""
shares = [0.3, -0.3, 0.7, -0.7]

EFFECT = Effect(
    id="gas_spring",
    part="clamp",
    does="gas that is compressed: stiffer the shorter its column is",
    source=f"{BAUER}, polytropic change of state; {QUAGLIA}",
    looks_like="the loop's back is bent to one side, more steeply towards the end where the column is short: even "
    "harmonics in phase, and with them the odd ones",
    imitated_by=("asymmetry", "exponential_stiffening", "cubic_stiffness", "offset"),
    special_cases=("asymmetry",),
    told_apart_by="larger amplitudes: the force on the short side grows beyond any bound towards the column's end, and "
    "on the long side it doesn't fall below -F_g",
    parameters=(
        Parameter(
            F_g, "N", "pressure times area in the middle",
            tuple(0.3 * F_typical / ((1 - abs(share)) ** -USUAL - 1) for share in shares), lower=0.0,
            upper=100 * F_typical,
        ),
        Parameter(
            q_g, "1/mm", "one over the column's length; above 0 where positive y compresses",
            tuple(share / y_farthest for share in shares), lower=-0.98 / y_farthest, upper=0.98 / y_farthest,
        ),
        Parameter(
            n_g, "-", "exponent of the change of state: 1 isothermal, 1.4 adiabatic", (USUAL,) * len(shares),
            lower=1.0, upper=1.8, neutral=USUAL, known_within=0.15,
        ),
    ),
    force=F_g * (pressure * (1 + n_g * beyond) - 1),
    energy=F_g
    * sp.Piecewise(((work + pressure * left * (beyond + n_g * beyond**2 / 2)) / q_g - x, sp.Abs(q_g) > 0), (0, True)),
)  # fmt: skip
