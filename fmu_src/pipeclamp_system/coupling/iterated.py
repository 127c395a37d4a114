"""The iterated scheme: forces that are linear over a step, and at its end those that the clamps give for the motion.

clamps(pipe(f)) = f is solved by Broyden's method with a Jacobian that is carried from step to step; plain repetition
f := clamps(pipe(f)) would diverge as soon as a clamp is stiffer than the pipe is over one step.

Dry friction steps where the velocity passes zero, somewhere within a macro step. Up to there the clamp slides: its
force is continued through v = 0 as it is beside it, so that nothing steps and the instant is a plain root. There the
pipe is told the other force all at once: that which the clamp gives when it is told so for a short while, whether it
slides back then or is held. The rest of the step goes on from there, in shorter parts while a clamp is held.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import copysign

from scipy.optimize import brentq

from pipeclamp_models.base.errors import UserError
from pipeclamp_system.coupling.bracketing import MOST_SWEEPS, enclosed
from pipeclamp_system.coupling.broyden import Answer, NotFoundError, Solver, SolverTolerance, Vector
from pipeclamp_system.coupling.march import Point, Predictor, System, end_point, step_clamps

REST_VELOCITY_SHARE = 1e-3
"""Share of a clamp's largest velocity so far below which it may be at rest."""

STEPPING_FORCE_SHARE = 0.01
"""Share of the largest force so far by which it must change from one slow velocity to the other to count as a step."""

SLIDES = 0.1
"""Share of the step within which a force is still that of sliding."""

END_SHARE = 1e-6
"""Share of a macro step to which the instant is found; nearer to its end than that it counts as the end."""

SUDDEN, SHORT = 1e-5, 0.05
"""Shares of a macro step within which the pipe is told the new force, and for which the clamp must then agree."""

HELD_PARTS = 4
"""Of a macro step while friction holds a clamp: the force that holds it follows the pipe's higher modes."""

MOST_PARTS = 16
"""Of one macro step: what steps more often in it isn't located."""

Sides = Mapping[int, int]
"""By clamp, to which side it slides: 1 or -1."""


class _Trials:
    """Steps from a saved state, where the participants are, each for other forces.

    Attributes:
        count: how many there were.
        motion: what the pipe gave at the end of the last one.
    """

    def __init__(
        self, system: System, restore: Callable[[], None], parts: Sequence[tuple[float, float, float]], length: float
    ) -> None:
        """Take the parts in which the pipe steps: excitation at the end, begin, length, s; clamps take all in one."""
        self._system, self._restore, self._parts, self._length = system, restore, parts, length
        self.count = 0
        self.motion: Sequence[float] = ()

    def answer(self, force: Vector) -> Vector:
        """Give the clamps' forces for the motion that results from `force`, told at the end of each part."""
        if self.count:
            self._restore()
        self.count += 1
        for excitation, begin, length in self._parts:
            self._system.pipe.set_inputs((excitation, *force))
            self._system.pipe.step(begin, length)
        self.motion = self._system.pipe.outputs()
        return step_clamps(self._system, self.motion, self._parts[0][1], self._length)


class Iteration:
    """The scheme's memory from step to step: the solver's, the forces before the present ones, and who slides."""

    def __init__(self, system: System, tolerance: SolverTolerance, *, locates: bool = True) -> None:
        """Start without any.

        Args:
            system: what is coupled.
            tolerance: of the forces.
            locates: whether a step is taken in parts where a force steps within it; its saved state then is that of
                the last part's beginning.
        """
        self._system = system
        self._participants = (system.pipe, *system.clamps)
        self._tolerance = tolerance
        self._solver = Solver(len(system.clamps), tolerance)
        self._predictor = Predictor()
        self._locates = locates
        self._fastest = [0.0] * len(system.clamps)
        self._slow_sides: Sides = {}
        self._held: set[int] = set()

    def accept(self, point: Point) -> None:
        """Remember a point for the next guess."""
        self._predictor.accept(point)
        self._fastest = [max(fastest, abs(v)) for fastest, v in zip(self._fastest, point.velocity, strict=True)]

    def advance(self, start: Point, time: float, h: float) -> Point:
        """Take one step, tried until the forces agree, in parts where a force steps.

        Raises:
            UserError: they don't within the number of trials.
        """
        passed: list[Point] = []
        point, end = start, time + h
        while end - time > END_SHARE * h or not passed:
            left = end - time
            length = min(left, h / HELD_PARTS) if self._held else left
            reached = self._reached(point, time, left if left - length < END_SHARE * h else length, h, len(passed))
            passed += reached
            point, time = reached[-1], reached[-1].time
            if end - time > END_SHARE * h:
                self._predictor.accept(point)
        trials = sum(point.trials for point in passed)
        return replace(passed.pop(), index=start.index + 1, time=end, trials=trials, passed=tuple(passed))

    def _reached(self, point: Point, time: float, length: float, h: float, taken: int) -> list[Point]:
        """Go on from a point, where the participants are, to the end of a part, or to where a force has stepped in it.

        Args:
            point: where the part begins.
            time: of it, s.
            length: of the part, s.
            h: the macro step, s.
            taken: how many parts of it have been taken.
        """
        self._save()
        reached = self._part(point, time, length)
        stopped = self._stopped(point, reached) if self._locates and taken < MOST_PARTS else {}
        if not stopped:
            self._held = {index for index in self._held if self._is_slow(index, reached)}
            return [reached]
        arrived = self._arrived(point, time, length, stopped)
        if arrived is None:
            self._restore()
            return [self._part(point, time, length)]
        self._save()
        released = self._released(arrived, min(SHORT * h, time + length - arrived.time), h)
        self._held = {index for index in stopped if self._is_slow(index, released)}
        self._predictor, self._slow_sides = Predictor(), {}
        return [arrived, released]

    def _is_slow(self, index: int, point: Point) -> bool:
        """Tell whether a clamp may be at rest."""
        return abs(point.velocity[index]) < REST_VELOCITY_SHARE * self._fastest[index]

    def _save(self) -> None:
        for participant in self._participants:
            participant.save()

    def _restore(self) -> None:
        for participant in self._participants:
            participant.restore()

    def _part(
        self, point: Point, time: float, length: float, sides: Sides | None = None, solver: Solver | None = None
    ) -> Point:
        """Go on from a point whose state was saved; the participants are there.

        Args:
            point: where the part begins.
            time: of it, s.
            length: of the part, s.
            sides: clamps whose force is that of sliding, whatever their velocity.
            solver: other than the scheme's own.
        """
        system, slides = self._system, sides or {}
        trials = _Trials(system, self._restore, ((system.excitation(time + length), time, length),), length)

        def answer(force: Vector) -> Vector:
            """Give the clamps' forces for the motion that results from `force`."""
            given = trials.answer(force)
            for index, side in slides.items():
                given[index] = self._continued(index, side, trials.motion, time, length)
            return given

        try:
            # Broyden's method needs a trial less from a parabola than from a straight line.
            force = (solver or self._solver).solve(answer, self._predictor.forces(time + length))
        except NotFoundError:
            self._solver = self._solver.fresh()  # what it has learned of a step is no slope
            force = self._enclosed(answer, point, time + length)
        return end_point(system, point.index, time + length, trials.motion, force, force, trials.count)

    def _enclosed(self, answer: Answer, start: Point, end: float) -> Vector:
        """Enclose the forces of a step in which they step themselves, as dry friction's that turns.

        Raises:
            UserError: they don't come to agree.
        """
        try:
            return enclosed(answer, start.force, self._solver.scale(start.force), self._tolerance)
        except NotFoundError as error:
            raise UserError(
                f"step {start.index + 1} (t = {end:.6g} s): the forces of pipe and clamps don't agree after "
                f"{self._tolerance.trials} secants and {MOST_SWEEPS} enclosings: {error.error:.1e} of the largest "
                f"force apart, expected at most {self._tolerance.relative:.1e}; use scheme = 'implicit', a smaller "
                "step_s, a larger tolerance or more max_iterations"
            ) from error

    def _stopped(self, start: Point, reached: Point) -> Sides:
        """Give the clamps that have slid to a side, and whose force has stepped since; remember who slides slowly."""
        stopped, slow_sides = {}, {}
        for index, (before, now) in enumerate(zip(start.velocity, reached.velocity, strict=True)):
            slow = REST_VELOCITY_SHARE * self._fastest[index]
            side = int(copysign(1, before)) if abs(before) > slow else self._slow_sides.get(index, 0)
            if not side or side * now >= slow:
                continue
            motion = (reached.displacement[index], side * slow, -side * slow, now)
            sliding, other, _ = self._forces_at(index, motion, start.time, reached.time - start.time)
            step = abs(sliding - other)
            if step <= STEPPING_FORCE_SHARE * self._solver.scale(reached.force)[index]:
                continue
            if side * now > 0 and abs(reached.force[index] - sliding) <= SLIDES * step:
                slow_sides[index] = side
            else:
                stopped[index] = side
        if not stopped:
            self._slow_sides = slow_sides
        return stopped

    def _forces_at(self, index: int, motion: Sequence[float], time: float, length: float) -> Vector:
        """Give the forces of a clamp at the end of a part, at a displacement and velocities; it ends at the last."""
        clamp, (displacement, *velocities) = self._system.clamps[index], motion
        found = []
        for velocity in velocities:
            clamp.restore()
            clamp.set_inputs((displacement, velocity))
            clamp.step(time, length)
            found.append(clamp.outputs()[0])
        return found

    def _continued(self, index: int, side: int, motion: Sequence[float], time: float, length: float) -> float:
        """Give the force of a clamp that slides to a side, a straight line through v = 0 where it is slow."""
        slow = side * REST_VELOCITY_SHARE * self._fastest[index]
        displacement, velocity = motion[index], motion[len(self._system.clamps) + index]
        if velocity / slow >= 2:
            return self._forces_at(index, (displacement, velocity), time, length)[0]
        faster, at_slow = self._forces_at(index, (displacement, 2 * slow, slow), time, length)
        return at_slow + (faster - at_slow) * (velocity / slow - 1)

    def _arrived(self, start: Point, time: float, length: float, sides: Sides) -> Point | None:
        """Give the point at which the first of the clamps that slide comes to rest, and be there.

        None where none of them does, were its force that of sliding throughout.
        """
        solver, at, trials = self._solver.fresh(), start, 0

        def left(share: float) -> float:
            """Give the least velocity to the side that a clamp slides to, as a share of its largest."""
            nonlocal at, trials
            at = start
            if share > 0:
                self._restore()
                at = self._part(start, time, share * length, sides, solver)
                trials += at.trials
            return min(side * at.velocity[index] / self._fastest[index] for index, side in sides.items())

        if left(0.0) <= 0 or left(1.0) >= 0:
            return None
        share = float(brentq(left, 0.0, 1.0, xtol=END_SHARE, rtol=END_SHARE))
        if share >= 1 - END_SHARE:
            return None
        left(share)
        return replace(at, trials=trials)

    def _released(self, arrived: Point, length: float, h: float) -> Point:
        """Go on for a short while under forces that step at its beginning; the state there was saved.

        Args:
            arrived: where a clamp has come to rest.
            length: s.
            h: the macro step, s.
        """
        system, time = self._system, arrived.time
        sudden = min(SUDDEN * h, SHORT * length)
        excitation, later = system.excitation(time + sudden), system.excitation(time + length)
        # The pipe is told these forces all the while.
        parts = ((excitation, time, sudden), (later, time + sudden, length - sudden))
        trials = _Trials(system, self._restore, parts, length)
        force = self._enclosed(trials.answer, arrived, time + length)
        return end_point(system, arrived.index, time + length, trials.motion, force, force, trials.count)
