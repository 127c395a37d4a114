"""Directional damping: c times 1 + d sgn v, so that loading and unloading differ."""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import DIXON, WORDEN
from pipeclamp_models.equations.symbols import smooth_sign, v, v_r

d = sp.Symbol("d", real=True)

EFFECT = Effect(
    id="directional_damping",
    part="clamp",
    does="damping differs between the two directions",
    source=f"{WORDEN}, on bilinear damping; {DIXON}, on dampers that differ in bump and rebound",
    looks_like="the upper branch of the loop lies further from the middle than the lower one: even harmonics that "
    "follow |v|^alpha",
    imitated_by=("asymmetry", "offset", "directional_slip"),
    told_apart_by="amplitude and frequency swept apart: it follows the damping force, not the displacement",
    parameters=(
        Parameter(d, "-", "share by which damping differs between the directions", 0.02, -0.9, 0.9, neutral=0.0),
    ),
    scales={"damping": 1 + d * smooth_sign(v, v_r)},
)
