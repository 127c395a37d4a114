"""Elastic part of the series law: F = s (a0 sgn y + sum a_n |y|^(n-1) y), s = (A/A0)^a (T/T0)^b."""

import sympy as sp

from pipeclamp_models.equations.effect import Coefficient, Effect, Family, Parameter, exponent, power_surface
from pipeclamp_models.equations.literature import JIANG
from pipeclamp_models.equations.symbols import A, A_typical, F_typical, T, smooth_sign, x, y_r

HIGHEST_ORDER = 7


def series(argument: str) -> Effect:
    """Give the series with powers 1 to n of the displacement.

    Raises:
        ValueError: the argument is not a whole number from 1 to 7.
    """
    if not argument.isdigit() or not 1 <= int(argument) <= HIGHEST_ORDER:
        raise ValueError(f"the highest power of the displacement, 1 to {HIGHEST_ORDER}")
    s, s_A, s_T, a_0 = sp.symbols("s s_A s_T a_0", real=True)
    parameters = [Parameter(a_0, "N", "step of the elastic force at y = 0", 0.0, typical=0.1 * F_typical)]
    force = a_0 * smooth_sign(x, y_r)
    energy = a_0 * (sp.sqrt(x**2 + y_r**2) - y_r)
    for order in range(1, int(argument) + 1):
        a_n = sp.Symbol(f"a_{order}", real=True)
        start = 0.8 * F_typical / A_typical if order == 1 else 0.0
        unit = "N/mm" if order == 1 else f"N/mm{order}"
        typical = None if order == 1 else 0.1 * F_typical / A_typical**order
        parameters.append(Parameter(a_n, unit, f"coefficient of |y|^{order - 1} y", start, typical=typical))
        force += a_n * x * sp.Abs(x) ** (order - 1)
        energy += a_n * sp.Abs(x) ** (order + 1) / (order + 1)
    return Effect(
        id="elastic_series",
        part="base",
        does="elastic force as a series in the displacement, of base law series",
        source=f"{JIANG}, Eq. 10, first two terms",
        looks_like="the loop has no slope",
        imitated_by=(),
        told_apart_by="nothing imitates it over several amplitudes",
        parameters=(
            *parameters,
            exponent(s_A, "the elastic series", A, 3.0),
            exponent(s_T, "the elastic series", T, 5.0),
        ),
        coefficients=(Coefficient(s, "-", "stiffness", power_surface(sp.Integer(1), {A: s_A, T: s_T})),),
        force=s * force,
        energy=s * energy,
        argument=argument,
    )


EFFECT = Family("elastic_series", "the highest power of the displacement", "3", series, numbered=True)
