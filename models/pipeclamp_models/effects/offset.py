"""Offset of the force channel, a rig effect: F = F_o."""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import DOEBELIN
from pipeclamp_models.equations.symbols import F_typical

F_o = sp.Symbol("F_o", real=True)

EFFECT = Effect(
    id="offset",
    part="rig",
    does="a constant force: an error of the force sensor, or a load that is always there",
    source=f"{DOEBELIN}, on zero drift",
    looks_like="a mean force, the same in every run",
    imitated_by=("asymmetry", "directional_slip"),
    told_apart_by="the rig run without a specimen, or the rest before a test: the offset stays",
    parameters=(Parameter(F_o, "N", "constant force", 0.0, neutral=0.0, typical=0.02 * F_typical),),
    force=F_o,
)
