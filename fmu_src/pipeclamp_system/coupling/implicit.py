"""The linearly implicit coupling scheme: one linear solve a step, with the clamps' own slopes.

Over a step the pipe answers linearly to the forces at its end: motion(f) = motion(g) + B (f - g), with B measured once
for each length of step. A trial with the guess g gives the motion (s, v) and the clamps' forces F there, with their
slopes K = dF/ds and D = dF/dv. The forces at the end of the step solve the linearised

    f = F + (K B_s + D B_v) (f - g),

and the step is taken again with them: two trials, whatever the stiffness of the clamps. For a law that is smooth the
force errs by O(h^2) or less, and so does the motion. Where the clamps then give a force that is off by more than a
stated share of the largest (friction that turns within the step), it is linearised anew from there.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeclamp_models.base.arrays import Array
from pipeclamp_system.coupling.march import (
    SMALLEST_MOTION,
    Participant,
    Point,
    Predictor,
    System,
    end_point,
    step_clamps,
)

NUDGE = 1e-3
"""Share of a step's change, and of the largest value so far, by which s and v are moved for a slope."""

MISS = 0.01
"""Share of the largest force so far by which the clamps' force may miss the one that the pipe was told."""

MOST_TRIALS_A_STEP = 12
"""Of a step; the nearest one is taken then, and its error shows in the energy."""


class LinearlyImplicit:
    """The scheme's memory from step to step: the pipe's answers by length of step, and points for the next guess."""

    def __init__(self, system: System) -> None:
        """Start without any."""
        self._system = system
        self._predictor = Predictor()
        self._answers: dict[float, Array] = {}
        self._peaks = np.full(2 * len(system.clamps), SMALLEST_MOTION)
        self._largest = np.full(len(system.clamps), SMALLEST_MOTION)

    def accept(self, point: Point) -> None:
        """Remember a point for the next guess."""
        self._predictor.accept(point)
        self._peaks = np.maximum(self._peaks, np.abs((*point.displacement, *point.velocity)))
        self._largest = np.maximum(self._largest, np.abs(point.force))

    def advance(self, start: Point, time: float, h: float) -> Point:
        """Take one step: a trial, a linear solve, the step; again where that misses."""
        system = self._system
        participants = (system.pipe, *system.clamps)
        for participant in participants:
            participant.save()
        excitation = system.excitation(time + h)
        told = np.array(self._predictor.forces(time + h))
        count = told.size
        nearest, nearest_miss, share, slopes = told, np.inf, 1.0, np.zeros((count, 2))
        change = np.zeros(count)
        for trial in range(1, MOST_TRIALS_A_STEP + 1):
            if trial > 1:
                for participant in participants:
                    participant.restore()
            motion = self._pipe_motion(excitation, told.tolist(), time, h)
            if not count:
                return end_point(system, start.index + 1, time + h, motion, (), (), trial)
            if h not in self._answers:
                self._answers[h] = self._measured_answers(excitation, told.tolist(), motion, time, h)
                system.pipe.restore()
                motion = self._pipe_motion(excitation, told.tolist(), time, h)
            given = step_clamps(system, motion, time, h)
            missed = np.subtract(given, told)
            miss = float(np.abs(missed / np.maximum(self._largest, np.abs(given))).max())
            if (trial > 1 and miss <= MISS) or trial == MOST_TRIALS_A_STEP:
                break
            if miss < nearest_miss:
                nearest, nearest_miss, share = told, miss, 1.0
                slopes = self._slopes(start, motion, given, time, h)
                answers = self._answers[h]
                follows = slopes[:, :1] * answers[:count] + slopes[:, 1:] * answers[count:]
                change = np.linalg.solve(np.eye(count) - follows, missed)
            else:
                share /= 2
            told = nearest + share * change
        return end_point(system, start.index + 1, time + h, motion, given, told.tolist(), trial)

    def _pipe_motion(self, excitation: float, force: Sequence[float], time: float, h: float) -> Sequence[float]:
        """Step the pipe; give displacements and then velocities."""
        self._system.pipe.set_inputs((excitation, *force))
        self._system.pipe.step(time, h)
        return tuple(self._system.pipe.outputs())

    def _measured_answers(
        self, excitation: float, guess: Sequence[float], motion: Sequence[float], time: float, h: float
    ) -> Array:
        """Give B: how displacements and then velocities follow each force at the end of the step, (2 c, c)."""
        columns = []
        for index in range(len(guess)):
            force = list(guess)
            more = max(1.0, abs(force[index]))
            force[index] += more
            self._system.pipe.restore()
            columns.append(np.subtract(self._pipe_motion(excitation, force, time, h), motion) / more)
        return np.array(columns).T

    def _slopes(self, start: Point, motion: Sequence[float], forces: Sequence[float], time: float, h: float) -> Array:
        """Give dF/ds and dF/dv of each clamp at the end of the trial, (c, 2)."""
        count = len(forces)
        found = []
        for index, clamp in enumerate(self._system.clamps):
            own = clamp.slopes()
            if own is None:
                place = (motion[index], motion[count + index])
                before = (start.displacement[index], start.velocity[index])
                own = self._differences(clamp, before, place, self._peaks[index::count], forces[index], time, h)
            found.append(own)
        return np.array(found)

    def _differences(
        self,
        clamp: Participant,
        before: tuple[float, float],
        place: tuple[float, float],
        peaks: Array,
        force: float,
        time: float,
        h: float,
    ) -> tuple[float, float]:
        """Give a clamp's slopes by two more trials."""
        found = []
        for which in (0, 1):
            more = NUDGE * max(abs(place[which] - before[which]), float(peaks[which]))
            moved = list(place)
            moved[which] += more
            clamp.restore()
            clamp.set_inputs(moved)
            clamp.step(time, h)
            found.append((clamp.outputs()[0] - force) / more)
        return found[0], found[1]
