"""Slip forces over the sliding speed: slip force times 1 + s_v (1 - exp(-|v|/v_slip)), of every element that slips.

|v| is smooth at v = 0 within v_r.
"""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import CONSTANTINOU, OLSSON
from pipeclamp_models.equations.symbols import v, v_highest, v_lowest, v_r, v_typical

s_v, v_slip = sp.symbols("s_v v_slip", real=True)

EFFECT = Effect(
    id="slip_speed",
    part="clamp",
    does="slip forces rise or fall with the speed of sliding",
    source=f"{CONSTANTINOU}, f_max/f_min = 1 + s_v; {OLSSON}: friction that falls with the speed",
    looks_like="where the element slips, the force bulges (or sags) towards the middle of the loop, where the motion "
    "is fastest, and more so the faster the cycle, up to a limit",
    imitated_by=("stribeck", "power_damping", "viscous"),
    told_apart_by="one amplitude from very slow to fast: the loop's width levels off at both ends, and its corners at "
    "the reversals stay as they are",
    parameters=(
        Parameter(
            s_v, "-", "slip force at speed over that next to rest, less 1", (0.3, -0.3, 0.3, -0.3), lower=-0.95,
            upper=20.0, neutral=0.0,
        ),
        Parameter(
            v_slip, "mm/s", "speed at which two thirds of that are reached",
            (0.3 * v_typical, 0.3 * v_typical, 0.5 * v_highest, 0.1 * v_lowest), lower=0.01 * v_lowest,
            upper=2 * v_highest,
        ),
    ),
    scales={"slip": 1 + s_v * (1 - sp.exp(-sp.sqrt(v**2 + v_r**2) / v_slip))},
)  # fmt: skip
