"""Damping part of the series law: F = r (b0 sgn v + sum b_n |v|^(n-1) v), r = (A/A0)^a (f/f0)^b."""

import sympy as sp

from pipeclamp_models.equations.effect import Coefficient, Effect, Family, Parameter, exponent, power_surface
from pipeclamp_models.equations.literature import JIANG
from pipeclamp_models.equations.symbols import A, F_typical, f, smooth_sign, v, v_r, v_typical

HIGHEST_ORDER = 5


def series(argument: str) -> Effect:
    """Give the series with powers 1 to n of the velocity.

    Raises:
        ValueError: the argument is not a whole number from 1 to 5.
    """
    if not argument.isdigit() or not 1 <= int(argument) <= HIGHEST_ORDER:
        raise ValueError(f"the highest power of the velocity, 1 to {HIGHEST_ORDER}")
    r, r_A, r_f, b_0 = sp.symbols("r r_A r_f b_0", real=True)
    parameters = [Parameter(b_0, "N", "dry friction", 0.1 * F_typical)]
    force = b_0 * smooth_sign(v, v_r)
    for order in range(1, int(argument) + 1):
        b_n = sp.Symbol(f"b_{order}", real=True)
        start = 0.1 * F_typical / v_typical if order == 1 else 0.0
        unit = "N s/mm" if order == 1 else f"N s{order}/mm{order}"
        typical = None if order == 1 else 0.1 * F_typical / v_typical**order
        parameters.append(Parameter(b_n, unit, f"coefficient of |v|^{order - 1} v", start, typical=typical))
        force += b_n * v * sp.Abs(v) ** (order - 1)
    return Effect(
        id="damping_series",
        part="base",
        does="damping force as a series in the velocity, of base law series",
        source=f"{JIANG}, Eq. 10, last two terms",
        looks_like="the loop has no area",
        imitated_by=("memory", "coulomb", "viscous"),
        told_apart_by="amplitude and frequency swept apart: it follows the velocity alone",
        parameters=(
            *parameters,
            exponent(r_A, "the damping series", A, 4.0),
            exponent(r_f, "the damping series", f, 3.0),
        ),
        coefficients=(Coefficient(r, "-", "damping", power_surface(sp.Integer(1), {A: r_A, f: r_f})),),
        force=r * force,
        argument=argument,
    )


EFFECT = Family("damping_series", "the highest power of the velocity", "1", series, numbered=True)
