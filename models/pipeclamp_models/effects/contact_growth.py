"""Contact growth: stiffness times 1 + beta (T - T_c)+, as thermal expansion closes pores of the mesh."""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import JIANG
from pipeclamp_models.equations.symbols import T, T_highest, T_lowest

beta, T_c = sp.symbols("beta T_c", real=True)
span = T_highest - T_lowest

EFFECT = Effect(
    id="contact_growth",
    part="clamp",
    does="stiffness rises above one temperature, as pores close",
    source=f"{JIANG}, Table 5: W rises by 21% from 200 to 300 °C, which it lays to thermal expansion of the wires",
    looks_like="stiffness that rises above one temperature only, at every A and f",
    imitated_by=("loosening",),
    told_apart_by="more temperatures around the one where the rise begins, tested up and down",
    parameters=(
        Parameter(
            beta,
            "1/K",
            "growth of stiffness per kelvin above T_c",
            (1e-3,) * 3,
            lower=0.0,
            upper=0.1,
            neutral=0.0,
            follows=(T,),
            typical=2e-3,
        ),
        Parameter(
            T_c,
            "K",
            "temperature above which contacts grow",
            tuple(T_lowest + share * span for share in (0.25, 0.5, 0.75)),
            lower=T_lowest,
            upper=T_highest,
            neutral=473.15,
            follows=(T,),
            levels=3,
        ),
    ),
    scales={"stiffness": 1 + beta * sp.Max(T - T_c, 0)},
)
