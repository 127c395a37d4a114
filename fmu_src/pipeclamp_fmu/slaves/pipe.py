"""A pipe in modes as an FMI 2.0 co-simulation slave on the standard library alone.

The builder makes one module of this file, `plain`, `pipe.step`, `pipe.coupled_step` and a generated pipe in place of
`stand_in_pipe`, and gives the class a name of its own.

q'' + damping q' + omega^2 q = participation u - sum over clamps of shape f, stepped exactly for inputs that are held
over the step, or linear from the last communication point's to those set (inputsAtStepEnd). Axial force and flow add
matrices to omega^2 and damping that couple the modes.
"""

from __future__ import annotations

import math
from operator import mul
from typing import Any

from pipeclamp_fmu.slaves.plain import Fmi2Slave
from pipeclamp_fmu.slaves.stand_in_pipe import (
    CLAMP_NAMES,
    CLAMP_SHAPES,
    COUPLING_DAMPING,
    COUPLING_STIFFNESS,
    DAMPING,
    EXCITATION,
    OMEGA,
    PARTICIPATION,
    PROBE_NAMES,
    PROBE_SHAPES,
)
from pipeclamp_models.pipe.coupled_step import Rows, step_coupled, transition
from pipeclamp_models.pipe.step import Coefficients, coefficients, step, work

Values = tuple[float, ...]

EXCITATION_INPUT = {"base": "base.a", "force": "excitation.f"}[EXCITATION]
INPUTS = (EXCITATION_INPUT, *[f"{name}.f" for name in CLAMP_NAMES])
MOTION_OUTPUTS = (
    *[f"{name}.s" for name in CLAMP_NAMES],
    *[f"{name}.v" for name in CLAMP_NAMES],
    *[f"{name}.{kind}" for kind in "sva" for name in PROBE_NAMES],
)
ENERGY_OUTPUTS = ("energyPipe", "energyDissipated", "workExcitation", "workClamps")
BOOLEAN_PARAMETERS = ("inputsAtStepEnd",)

STIFFNESS = tuple(omega * omega for omega in OMEGA)
DAMPING_ROWS: Rows = tuple(
    [
        tuple([entry + DAMPING[row] * (row == column) for column, entry in enumerate(entries)])
        for row, entries in enumerate(COUPLING_DAMPING)
    ]
)
STIFFNESS_ROWS: Rows = tuple(
    [
        tuple([entry + STIFFNESS[row] * (row == column) for column, entry in enumerate(entries)])
        for row, entries in enumerate(COUPLING_STIFFNESS)
    ]
)
"""Full matrices; empty where the modes aren't coupled."""
MOST_LENGTHS = 8
"""Lengths of step whose matrices are remembered: a master that varies its step comes back to some."""
BY_MODE = tuple(zip(PARTICIPATION, *[[-entry for entry in shape] for shape in CLAMP_SHAPES], strict=True))
"""Modal load per unit of each input, mode by mode: clamps' forces act on the pipe with the opposite sign."""
MOVED = (PARTICIPATION, *CLAMP_SHAPES)
"""What each input does work on, as a shape."""
CARRIED = 1.0 if EXCITATION == "base" else 0.0
"""Share of the base's acceleration in the absolute acceleration of a probe."""


def seen(shapes: tuple[Values, ...], modal: Values) -> list[float]:
    """Give the values at the shapes' points of something that is given per mode."""
    return [sum(map(mul, shape, modal)) for shape in shapes]


def stiffness_forces(q: Values) -> list[float]:
    """Give the modal stiffness times q."""
    return seen(STIFFNESS_ROWS, q) if STIFFNESS_ROWS else list(map(mul, STIFFNESS, q))


def damping_forces(p: Values) -> list[float]:
    """Give the modal damping times q'."""
    return seen(DAMPING_ROWS, p) if DAMPING_ROWS else list(map(mul, DAMPING, p))


def stored(q: Values, p: Values) -> float:
    """Give the kinetic and strain energy, J."""
    doubled: float = sum(map(mul, p, p)) + sum(map(mul, q, stiffness_forces(q)))
    return doubled / 2


class PipeSlave(Fmi2Slave):
    """A straight pipe with ports for clamps, shaken by its base or by a force.

    Attributes:
        _modes: q and q' of the modes.
        _loads: the inputs at the last communication point, and the modal loads that they made.
        _works: work of the excitation and work done on the clamps, J.
    """

    KEPT = ("_modes", "_loads", "_works")

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(INPUTS, (), MOTION_OUTPUTS + ENERGY_OUTPUTS, BOOLEAN_PARAMETERS, (), kwargs)
        at_rest = (0.0,) * len(OMEGA)
        self._modes: tuple[Values, Values] = (at_rest, at_rest)
        self._loads: tuple[Values, Values] = ((0.0,) * len(INPUTS), at_rest)
        self._works = (0.0, 0.0)
        # Not part of a saved state: what steps of one length are made of.
        self._length = 0.0
        self._k: list[Coefficients] = []
        self._transitions: dict[float, Rows] = {}

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Move through the step; refuse what can't be, the state untouched."""
        loads = tuple(self._reals[: len(INPUTS)])
        total = sum(loads) + step_size
        if self._lost or not (step_size > 0.0 and total - total == 0.0):
            return self._refuse(current_time, step_size, self._what_is_wrong(step_size))
        modal_loads = tuple([sum(map(mul, row, loads)) for row in BY_MODE])
        loads_before, modal_loads_before = self._loads if self._flags[0] else (loads, modal_loads)
        q_before, p_before = self._modes
        q, p, integral = self._moved(step_size, q_before, p_before, modal_loads_before, modal_loads)
        energy = stored(q, p)
        if energy - energy != 0.0:
            return self._refuse(current_time, step_size, "the motion would not be finite")
        excited, *on_clamps = [
            work(load_before, load, s_before, s, mean / step_size)
            for load_before, load, s_before, s, mean in zip(
                loads_before, loads, seen(MOVED, q_before), seen(MOVED, q), seen(MOVED, integral), strict=True
            )
        ]
        self._modes = (q, p)
        self._loads = (loads, modal_loads)
        self._works = (self._works[0] + excited, self._works[1] + sum(on_clamps))
        self._show()
        return True

    def _moved(self, h: float, q: Values, p: Values, g0: Values, g1: Values) -> tuple[Values, Values, Values]:
        """Give q, q' and the integral of q after a step."""
        if STIFFNESS_ROWS:
            rows = self._transitions.get(h)
            if rows is None:
                if len(self._transitions) == MOST_LENGTHS:
                    self._transitions.clear()
                rows = self._transitions[h] = transition(STIFFNESS_ROWS, DAMPING_ROWS, h)
            return step_coupled(rows, q, p, g0, g1)
        if h != self._length:
            self._k = [coefficients(omega, damping, h) for omega, damping in zip(OMEGA, DAMPING, strict=True)]
            self._length = h
        after, speed, integral = zip(*map(step, self._k, q, p, g0, g1), strict=True)
        return after, speed, integral

    def _what_is_wrong(self, step_size: float) -> str:
        if self._lost:
            return self._lost
        if not (step_size > 0.0 and math.isfinite(step_size)):
            return "expected a finite step above 0 s"
        names = [name for name, value in zip(INPUTS, self._reals, strict=False) if not math.isfinite(value)]
        if not names:
            return "the inputs are too large"
        return f"{names[0]} is {self._reals[INPUTS.index(names[0])]}; expected a finite number"

    def _show(self) -> None:
        """Write the outputs of the present motion."""
        q, p = self._modes
        loads, modal_loads = self._loads
        acceleration = tuple(
            [g - b - a for g, b, a in zip(modal_loads, damping_forces(p), stiffness_forces(q), strict=True)]
        )
        carried = CARRIED * loads[0]
        energy = stored(q, p)
        excited, on_clamps = self._works
        self._reals[len(INPUTS) :] = [
            *seen(CLAMP_SHAPES, q),
            *seen(CLAMP_SHAPES, p),
            *seen(PROBE_SHAPES, q),
            *seen(PROBE_SHAPES, p),
            *[carried + value for value in seen(PROBE_SHAPES, acceleration)],
            energy,
            # The pipe starts at rest, and both works are exact: what is left is what damping has taken.
            excited - on_clamps - energy,
            excited,
            on_clamps,
        ]

    def _evaluate_start(self) -> None:
        """Take the inputs as those at the start; the pipe is at rest."""
        loads = tuple(self._reals[: len(INPUTS)])
        self._loads = (loads, tuple([sum(map(mul, row, loads)) for row in BY_MODE]))
        self._show()
