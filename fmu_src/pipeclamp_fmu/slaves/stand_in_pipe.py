"""A pipe in the form in which reduced pipes enter the pipe slave: what the builder replaces by a generated one.

`pipe_slave` imports from here so that it is an ordinary module, linted, type-checked and usable without an FMU. One
clamped-free mode of 1 kg at 10 Hz.
"""

from __future__ import annotations

OMEGA: tuple[float, ...] = (62.83185307179586,)
DAMPING: tuple[float, ...] = (0.6283185307179586,)
COUPLING_STIFFNESS: tuple[tuple[float, ...], ...] = ()
COUPLING_DAMPING: tuple[tuple[float, ...], ...] = ()
EXCITATION = "base"
PARTICIPATION: tuple[float, ...] = (-1.0,)
CLAMP_NAMES: tuple[str, ...] = ("clamp1",)
CLAMP_SHAPES: tuple[tuple[float, ...], ...] = ((1.0,),)
PROBE_NAMES: tuple[str, ...] = ("tip",)
PROBE_SHAPES: tuple[tuple[float, ...], ...] = ((2.0,),)
