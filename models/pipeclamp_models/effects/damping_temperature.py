"""Damping over temperature: c times exp(c_T1 t + c_T2 t^2 + c_T3 t^3), t = (T - T0)/100 K.

A spring that it is driven through, an oil damper's or an inner mass's, has a factor exp(k_cT t) of its own.
"""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import JIANG, NASHIF
from pipeclamp_models.equations.symbols import T_0, T

c_T1, c_T2, c_T3, k_cT = sp.symbols("c_T1 c_T2 c_T3 k_cT", real=True)
t = (T - T_0) / 100

EFFECT = Effect(
    id="damping_temperature",
    part="clamp",
    does="damping follows the temperature smoothly",
    source=f"{JIANG}, Table 5: dW over T has a minimum near 200 °C; {NASHIF}, on damping over temperature",
    looks_like="the loop's area is wrong by the same share at every A and f, and that share changes with T",
    imitated_by=("loosening", "fade"),
    told_apart_by="the temperatures tested in another order: a share that follows T, not the cycle number",
    parameters=(
        Parameter(
            c_T1,
            "-",
            "log change of c per 100 K at T0",
            0.0,
            -6.0,  # a mineral oil of 20 °C loses so much of its viscosity
            6.0,
            neutral=0.0,
            follows=(T,),
            typical=-0.17,
            known_within=2 / 3,
        ),
        Parameter(
            c_T2,
            "-",
            "bend of the log of c per (100 K)^2",
            0.0,
            -3.0,
            3.0,
            neutral=0.0,
            follows=(T,),
            levels=3,
            typical=0.058,
            known_within=1 / 3,
        ),
        Parameter(c_T3, "-", "its change per (100 K)^3", 0.0, -0.5, 0.5, neutral=0.0, follows=(T,), levels=4),
        Parameter(
            k_cT,
            "-",
            "log change per 100 K of the spring that an oil damper or an inner mass is driven through",
            0.0,
            -2.0,
            2.0,
            neutral=0.0,
            follows=(T,),
            if_scaled=True,
        ),
    ),
    scales={"damping": sp.exp(c_T1 * t + c_T2 * t**2 + c_T3 * t**3), "series": sp.exp(k_cT * t)},
)
