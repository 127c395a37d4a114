"""Slip forces over temperature: slip force times exp(z_T1 t + z_T2 t^2), t = (T - T0)/100 K, of all that slips."""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import AURICCHIO, DOLCE
from pipeclamp_models.equations.symbols import T_0, T

z_T1, z_T2 = sp.symbols("z_T1 z_T2", real=True)
t = (T - T_0) / 100

EFFECT = Effect(
    id="slip_temperature",
    part="clamp",
    does="slip forces follow the temperature smoothly",
    source=f"{DOLCE}: sliding friction over air temperature; {AURICCHIO}: the force at which an alloy gives way rises "
    "with the temperature. Here its logarithm does, so that it never changes its sign",
    looks_like="the loop is too wide at some temperatures and too narrow at others, by the same share at every f; its "
    "flanks after a reversal are as steep as they should be",
    imitated_by=("damping_temperature", "loosening", "fade"),
    told_apart_by="small amplitudes at several temperatures, at which little slips: what sticks is as stiff at each",
    parameters=(
        Parameter(
            z_T1, "-", "log change of slip forces per 100 K at T0", 0.0, -2.0, 2.0, neutral=0.0, follows=(T,),
            typical=-0.17,
        ),
        Parameter(
            z_T2, "-", "bend of the log of slip forces per (100 K)^2", 0.0, -1.0, 1.0, neutral=0.0, follows=(T,),
            levels=3,
        ),
    ),
    scales={"slip": sp.exp(z_T1 * t + z_T2 * t**2)},
)  # fmt: skip
