"""Coupling of a pipe with clamps, macro step by macro step: parallel, sequential, linearly implicit, iterated.

The pipe takes the excitation and the force into each clamp and gives each clamp's displacement and velocity; a clamp
takes these and gives its force. Over a step from t to t + h:

parallel (Jacobi, order 1): all step at once with what the others gave at t.
sequential (Gauss-Seidel, order 1): the pipe steps with the forces given at t, then the clamps with the motion at t + h.
implicit (order 2): forces linear over the step; its end is linearised once, see `coupling.implicit`.
iterated (order 2): forces linear over the step, and at its end those that the clamps give for the motion that results:
    clamps(pipe(f)) = f, every trial a roll-back and a new step, see `coupling.iterated`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import prod
from typing import Protocol

SMALLEST_MOTION = 1e-12
"""m and m/s: below this nothing moves."""


class Participant(Protocol):
    """What a scheme needs of a pipe or a clamp; `save` keeps one state, `restore` goes back to it."""

    def set_inputs(self, values: Sequence[float]) -> None:
        """Set all inputs, in the participant's order."""

    def step(self, time: float, h: float) -> None:
        """Step from `time` to `time + h`."""

    def outputs(self) -> Sequence[float]:
        """Give all outputs that couple, in the participant's order."""

    def save(self) -> None:
        """Keep the present state."""

    def restore(self) -> None:
        """Go back to the state that was kept."""

    def slopes(self) -> tuple[float, float] | None:
        """Give a clamp's dF/ds (N/m) and dF/dv (N s/m) at the end of the last step, where it knows them."""


@dataclass(frozen=True)
class Point:
    """The coupled system at a communication point.

    Attributes:
        index: 0 at the start.
        time: s.
        excitation: m/s2 or N.
        displacement: per clamp, m.
        velocity: per clamp, m/s.
        force: per clamp, into the clamp, as the clamp gave it, N.
        told: per clamp, the force that the pipe was told for the end of the step (held over it, without roll-back), N.
        trials: how often the step to this point was taken; 1 where nothing is iterated.
        passed: the points within the step, where it was taken in parts.
    """

    index: int
    time: float
    excitation: float
    displacement: tuple[float, ...]
    velocity: tuple[float, ...]
    force: tuple[float, ...]
    told: tuple[float, ...]
    trials: int
    passed: tuple[Point, ...] = ()


@dataclass(frozen=True)
class System:
    """A pipe, its clamps and what shakes them.

    Attributes:
        pipe: inputs (excitation, force per clamp); outputs (displacement per clamp, velocity per clamp). For the
            iterated scheme its inputs are those at the end of the step, else those that are held over it.
        clamps: inputs (displacement, velocity) at the end of the step; output (force,).
        excitation: the excitation over time, s.
    """

    pipe: Participant
    clamps: tuple[Participant, ...]
    excitation: Callable[[float], float]


class Advance(Protocol):
    """A scheme: takes the coupled system over one step."""

    def advance(self, start: Point, time: float, h: float) -> Point:
        """Step from `time` to `time + h`; a scheme that rolls back has kept the states at `time`."""

    def accept(self, point: Point) -> None:
        """Learn that a step was taken for good."""


def initial_point(system: System) -> Point:
    """Give the coupled system at its start, participants initialised at time 0."""
    count = len(system.clamps)
    outputs = system.pipe.outputs()
    force = tuple(clamp.outputs()[0] for clamp in system.clamps)
    displacement, velocity = tuple(outputs[:count]), tuple(outputs[count : 2 * count])
    return Point(0, 0.0, system.excitation(0.0), displacement, velocity, force, force, 0)


def march(system: System, advance: Advance, h: float, steps: int) -> Iterator[Point]:
    """Step a coupled system through time in equal steps; gives the start and then the end of each step.

    Args:
        system: participants that are initialised at time 0.
        advance: how they are coupled.
        h: macro step, s.
        steps: how many.

    Raises:
        UserError: an iterated step doesn't reach its tolerance; the message names the step.
    """
    point = initial_point(system)
    advance.accept(point)
    yield point
    for index in range(1, steps + 1):
        point = advance.advance(point, (index - 1) * h, h)
        advance.accept(point)
        yield point


def end_point(
    system: System,
    index: int,
    time: float,
    motion: Sequence[float],
    force: Sequence[float],
    told: Sequence[float],
    trials: int,
) -> Point:
    """Give the end of a step from the motion (displacements, then velocities) and the forces."""
    count = len(system.clamps)
    return Point(
        index,
        time,
        system.excitation(time),
        tuple(motion[:count]),
        tuple(motion[count : 2 * count]),
        tuple(force),
        tuple(told),
        trials,
    )


def step_clamps(system: System, motion: Sequence[float], time: float, h: float) -> list[float]:
    """Step each clamp to its displacement and velocity; give the forces."""
    count = len(system.clamps)
    for index, clamp in enumerate(system.clamps):
        clamp.set_inputs((motion[index], motion[count + index]))
        clamp.step(time, h)
    return [clamp.outputs()[0] for clamp in system.clamps]


@dataclass(frozen=True)
class Explicit:
    """The parallel and the sequential scheme."""

    system: System
    sequential: bool

    def advance(self, start: Point, time: float, h: float) -> Point:
        """Take one step."""
        system = self.system
        system.pipe.set_inputs((start.excitation, *start.force))
        system.pipe.step(time, h)
        motion = system.pipe.outputs()
        seen = motion if self.sequential else (*start.displacement, *start.velocity)
        force = step_clamps(system, seen, time, h)
        return end_point(system, start.index + 1, time + h, motion, force, start.force, 1)

    def accept(self, point: Point) -> None:
        """Nothing is remembered."""


class Predictor:
    """Guesses forces from those of the last points: the parabola through three."""

    def __init__(self) -> None:
        """Start without any."""
        self._points: list[Point] = []

    def accept(self, point: Point) -> None:
        """Remember a point."""
        self._points = [*self._points[-2:], point]

    def forces(self, time: float) -> list[float]:
        """Guess the forces at a time, s."""
        known = self._points
        weights = [
            prod((time - other.time) / (point.time - other.time) for other in known if other is not point)
            for point in known
        ]
        return [
            sum(weight * force for weight, force in zip(weights, forces, strict=True))
            for forces in zip(*(point.force for point in known), strict=True)
        ]
