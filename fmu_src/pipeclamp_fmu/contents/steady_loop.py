"""A clamp's loop in the middle of its range: what its icon shows and its reference results hold."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pipeclamp_fmu.slaves.clamp import ClampSlave
from pipeclamp_fmu.slaves.loading import instance_of

SAMPLES_PER_CYCLE = 200
"""Per cycle."""

THIRD = 0.3
"""Share of a third harmonic in the motion, so that it isn't the one that the law was fitted to."""


@dataclass(frozen=True)
class ReferenceLoop:
    """Two cycles from rest, after a step at rest, under the clamp's default conditions: motion and answer, SI units.

    Attributes:
        step: s.
        s, v: motion at the end of each step.
        force: N.
        dissipated: work on the clamp less what it stores, J.
    """

    step: float
    s: tuple[float, ...]
    v: tuple[float, ...]
    force: tuple[float, ...]
    dissipated: tuple[float, ...]


def steady_loop(module: str, values: str) -> ReferenceLoop:
    """Run a clamp's generated module along two cycles of its default amplitude and frequency.

    Args:
        module: see `contents.clamp.clamp_module`.
        values: its file of values.
    """
    slave = instance_of(module, ClampSlave.__name__, values)
    slave.exit_initialization_mode()
    places = {variable.name: reference for reference, variable in slave.vars.items()}
    A, f = slave.get_real([places["A"], places["f"]])
    h, omega = 1 / (f * SAMPLES_PER_CYCLE), 2 * math.pi * f
    rows = []
    for index in range(2 * SAMPLES_PER_CYCLE + 1):
        theta = 2 * math.pi * index / SAMPLES_PER_CYCLE
        s = A / (1 + THIRD) * (math.sin(theta) + THIRD * math.sin(3 * theta))
        v = A / (1 + THIRD) * omega * (math.cos(theta) + 3 * THIRD * math.cos(3 * theta)) * (index > 0)
        slave.set_real([places["flange.s"], places["flange.v"]], [s, v])
        slave.do_step(index * h, h)
        rows.append((s, v, *slave.get_real([places["flange.f"], places["energyDissipated"]])))
    motion, speed, force, dissipated = zip(*rows, strict=True)
    return ReferenceLoop(h, motion, speed, force, dissipated)
