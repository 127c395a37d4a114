"""Relaxation times over temperature: tau times exp(r_T1 t + r_T2 t^2), t = (T - T0)/100 K, of all that relaxes."""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import FERRY, WILLIAMS
from pipeclamp_models.equations.symbols import T_0, T

r_T1, r_T2 = sp.symbols("r_T1 r_T2", real=True)
t = (T - T_0) / 100

EFFECT = Effect(
    id="relaxation_temperature",
    part="clamp",
    does="relaxation times follow the temperature: what relaxes is at another place of its frequencies",
    source=f"{WILLIAMS}; {FERRY}, on time-temperature superposition. Its logarithm is a parabola about T0 here",
    looks_like="a loop at a higher temperature is as one at a lower frequency: stiffness and damping change with T as "
    "they do with f",
    imitated_by=("damping_temperature", "stiffness_frequency"),
    told_apart_by="a decade of frequency at several temperatures: curves over f lie on one when shifted along log f",
    parameters=(
        Parameter(
            r_T1, "-", "log change of relaxation times per 100 K at T0", (-1.0, -4.0, -12.0), -20.0, 20.0, neutral=0.0,
            follows=(T,),
        ),
        Parameter(
            r_T2, "-", "bend of the log of relaxation times per (100 K)^2", (0.0,) * 3, -10.0, 10.0, neutral=0.0,
            follows=(T,), levels=3,
        ),
    ),
    scales={"relaxation": sp.exp(r_T1 * t + r_T2 * t**2)},
)  # fmt: skip
