"""What slips over temperature: slip force times exp(z_T1 t + z_T2 t^2), t = (T - T0)/100 K, of all that slips.

Its stiffness while it sticks has a factor exp(k_zT t) of its own: where a modulus falls, both do.
"""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import AURICCHIO, DOLCE, NASHIF
from pipeclamp_models.equations.symbols import T_0, T

z_T1, z_T2, k_zT = sp.symbols("z_T1 z_T2 k_zT", real=True)
t = (T - T_0) / 100

EFFECT = Effect(
    id="slip_temperature",
    part="clamp",
    does="what slips follows the temperature smoothly: its slip force, and its stiffness while it sticks",
    source=f"{DOLCE}: sliding friction over air temperature; {AURICCHIO}: the force at which an alloy gives way rises "
    f"with the temperature; {NASHIF}, on moduli. Here their logarithms do, so that none changes its sign",
    looks_like="the loop is too wide at some temperatures and too narrow at others, by the same share at every f; its "
    "flanks after a reversal are as steep as they should be, or too steep where it is too wide",
    imitated_by=("damping_temperature", "loosening", "fade"),
    told_apart_by="small amplitudes at several temperatures, at which little slips: what is lost there hardly changes",
    parameters=(
        Parameter(
            z_T1, "-", "log change of slip forces per 100 K at T0", 0.0, -2.0, 2.0, neutral=0.0, follows=(T,),
            typical=-0.17,
        ),
        Parameter(
            z_T2, "-", "bend of the log of slip forces per (100 K)^2", 0.0, -1.0, 1.0, neutral=0.0, follows=(T,),
            levels=3,
        ),
        Parameter(
            k_zT, "-", "log change per 100 K of the stiffness of what slips, while it sticks", 0.0, -2.0, 2.0,
            neutral=0.0, follows=(T,), if_scaled=True,
        ),
    ),
    scales={"slip": sp.exp(z_T1 * t + z_T2 * t**2), "sticking": sp.exp(k_zT * t)},
)  # fmt: skip
