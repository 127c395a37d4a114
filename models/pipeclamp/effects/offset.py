"""Offset of the force channel, a rig effect: F = F_o."""

import sympy as sp

from pipeclamp.effect import Effect, Parameter

F_o = sp.Symbol("F_o", real=True)

EFFECT = Effect(
    id="offset",
    part="rig",
    source="EFFECTS.md",
    looks_like="a mean force, the same in every run",
    imitated_by=("asymmetry",),
    told_apart_by="the rig run without a specimen: the offset stays",
    parameters=(Parameter(F_o, "N", "constant force", 0.0, neutral=0.0),),
    force=F_o,
)
