"""The published clamp: F = k1 y + k3 y^3 + c |v|^alpha sgn v with the paper's own surfaces.

k1 = p1 A^p1_A t^p1_T, k3 = p3 A^p3_A t^p3_T, c = c_e f^c_n + c_c, alpha = p_alpha A^p_A f^p_f with
t = T - T_zero, so that both readings of the paper's temperature, kelvin and degC, can be told.
"""

import sympy as sp

from pipeclamp_models.equations.effect import Coefficient, Effect, Parameter
from pipeclamp_models.equations.literature import JIANG
from pipeclamp_models.equations.symbols import A_0, A, T, f, f_0, signed_power, v, x

k1, k3, c, alpha = sp.symbols("k1 k3 c alpha", real=True)
p1, p1_A, p1_T, p3, p3_A, p3_T = sp.symbols("p1 p1_A p1_T p3 p3_A p3_T", real=True)
c_e, c_n, c_c, p_alpha, p_A, p_f, T_zero = sp.symbols("c_e c_n c_c p_alpha p_A p_f T_zero", real=True)
t = T - T_zero

EFFECT = Effect(
    id="published_clamp",
    part="base",
    does="the published clamp's whole force, with the paper's own surfaces",
    source=f"{JIANG}, Eq. 17 and 20 to 24, as far as they can be read: minus signs and units were lost in print, "
    "and the sine term of c is left out",
    looks_like="no force at all",
    imitated_by=(),
    told_apart_by="nothing imitates it",
    parameters=(
        Parameter(p1, "N/mm", "k1 at 1 mm and one unit of temperature", 2380.0),
        Parameter(p1_A, "-", "exponent of k1 over A", -0.2218),
        Parameter(p1_T, "-", "exponent of k1 over temperature", -0.05131),
        Parameter(p3, "N/mm3", "k3 at 1 mm and one unit of temperature", 1112.0),
        Parameter(p3_A, "-", "exponent of k3 over A", -1.228),
        Parameter(p3_T, "-", "exponent of k3 over temperature", -0.1374),
        Parameter(c_e, "N", "part of c that falls with f, at 1 Hz", 1000.0 * 0.135742),
        Parameter(c_n, "-", "exponent of that part over f", -0.7084),
        Parameter(c_c, "N", "part of c that is constant", 38.11),
        Parameter(p_alpha, "-", "alpha at 1 mm, 1 Hz", 0.4718),
        Parameter(p_A, "-", "exponent of alpha over A", 0.4822),
        Parameter(p_f, "-", "exponent of alpha over f", 0.01232),
        Parameter(T_zero, "K", "zero of the temperature scale that was read", 0.0),
    ),
    coefficients=(
        Coefficient(k1, "N/mm", "stiffness", p1 * (A / A_0) ** p1_A * t**p1_T),
        Coefficient(k3, "N/mm3", "stiffness", p3 * (A / A_0) ** p3_A * t**p3_T),
        Coefficient(c, "N", "damping", c_e * (f / f_0) ** c_n + c_c),
        Coefficient(alpha, "-", None, p_alpha * (A / A_0) ** p_A * (f / f_0) ** p_f),
    ),
    force=k1 * x + k3 * x**3 + c * signed_power(v, alpha),
    energy=k1 * x**2 / 2 + k3 * x**4 / 4,
)
