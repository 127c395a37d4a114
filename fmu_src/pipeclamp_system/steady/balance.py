"""Steady states of a pipe with clamps under a sine, by harmonic balance: no time integration.

What is balanced stands in `driven`; here it is followed over frequency, and its solutions become states. Whether a
motion is stable is told by Floquet's multipliers.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby, pairwise
from math import ceil, log

import numpy as np

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_system.steady.clamp import harmonics_of
from pipeclamp_system.steady.continuation import Solution, Steps, between, follow
from pipeclamp_system.steady.driven import DrivenPipe
from pipeclamp_system.steady.floquet import growth
from pipeclamp_system.steady.harmonics import DOUBTFUL_SHARE, packed
from pipeclamp_system.steady.in_time import MarchedMotion, Standing
from pipeclamp_system.steady.start import begun
from pipeclamp_system.steady.states import FollowedResponse, SteadyState, Unsteady, half_range
from pipeclamp_system.steady.tangents import tangents
from pipeclamp_system.steady.truncation import truncated

OVER_FREQUENCY = Steps(widest=0.05)
"""Of a path over frequency: a resonance damped by 1 % stands out twentyfold so far from its frequency, as a share: in
a longer step one that is small beside others could begin and end unseen."""

APART_SHARE, CLOSEST_SHARE, MOST_IN_TIME = 0.04, 0.002, 120
"""Frequencies that are marched lie so far apart, as a share, and half of that again where the response bends, down to
the second; but no more are marched than these."""

MOST_WORK_OF_A_PATH = 8e6
"""Work, as of `Work`, after which a path over frequency is given up with where it begins: some minutes."""

TOLD_EVERY = 20
"""Points of a path after which it is told how far it was followed."""

STRAIGHT_SHARE, OTHER = 0.01, 0.05
"""Share by which an amplitude may be off the straight line through its neighbours', and from which on it is that of
another motion."""


class SteadySystem(DrivenPipe):
    """A pipe with its clamps under a sine, and the steady states that it comes to."""

    def at(self, frequency: float) -> SteadyState | None:
        """Give the motion at a frequency (Hz) that grows out of rest with the excitation; None where it isn't found.

        Where it can't be balanced it is the one to which a march from rest comes.
        """
        start = None if self.holds_places else begun(self, frequency)
        if start is not None:
            return self.state(start, frequency)
        marched = self.marched(frequency)
        return self.state_in_time(marched) if marched is not None and marched.round == 1 else None

    def curve(self, first: float, last: float, tell: Progress = silent) -> list[SteadyState]:
        """Give the frequency response from one frequency to another (Hz), round its turning points.

        The curve begins at the first frequency; where it ends before the last one, the list does too.
        """
        return [self.state(point.unknowns, point.parameter, point.side) for point in self.path(first, last, tell)]

    def path(self, first: float, last: float, tell: Progress = silent) -> list[Solution]:
        """Give the solutions that `curve` evaluates, which takes as long as to find them.

        It ends where no more work is to be spent on it.
        """
        with self.work.at_most(MOST_WORK_OF_A_PATH):
            tell(f"begun at {first:.4g} Hz")
            start = begun(self, first)
            if start is None:
                return []
            if not self._clamps:
                return [Solution(frequency, start) for frequency in np.linspace(first, last, 200).tolist()]
            size = float(self.sizes(start[None])[0])
            points = []
            for point in follow(self.over_frequency(), Solution(first, start), last, size, OVER_FREQUENCY):
                points.append(point)
                if len(points) % TOLD_EVERY == 0:
                    tell(f"followed to {point.parameter:.4g} Hz")
        return points

    def followed(self, first: float, last: float, tell: Progress = silent) -> FollowedResponse:
        """Follow the frequency response from its lower end (Hz), and from its upper end where that isn't reached.

        What lies between what was followed is marched in time, frequency by frequency, unless nothing bounds it.

        Args:
            first, last: its ends, Hz.
            tell: told how far it was followed.
        """
        if self.holds_places:
            return self._in_time((), first, last, tell)
        lower = tuple(self.curve(first, last, tell))
        if lower and lower[-1].frequency == last:
            return FollowedResponse((lower,), whole=True)
        upper = tuple(reversed(self.curve(last, first, tell)))
        if upper and upper[0].frequency == first:
            return FollowedResponse((upper,), whole=True)
        followed = FollowedResponse(tuple(piece for piece in (lower, upper) if piece), whole=False)
        if followed.unbounded:
            return followed
        lower, upper = self._sound(lower), self._sound(upper[::-1])[::-1]
        given_up = max((state.frequency for state in lower), default=first)
        from_above = min((state.frequency for state in upper), default=last)
        return self._in_time(tuple(piece for piece in (lower, upper) if piece), given_up, from_above, tell)

    def _in_time(
        self, pieces: tuple[tuple[SteadyState, ...], ...], low: float, high: float, tell: Progress
    ) -> FollowedResponse:
        """March between two frequencies (Hz), upwards and downwards: where there are two motions, each way has its own.

        Pieces are what is balanced beside them.
        """
        if low >= high or not self._clamps:
            return FollowedResponse(pieces, whole=False)
        upwards = self._finer(self._in_turn(low, high, tell), tell)
        downwards = self._others(upwards, self._in_turn(high, low, tell, upwards[-1].end if upwards else None), tell)
        ways = [[one for one in way if one.round == 1] for way in (upwards, *downwards)]
        return FollowedResponse(
            pieces,
            whole=False,
            in_time=tuple(tuple(self.state_in_time(one) for one in way) for way in ways if way),
            unsteady=tuple(
                Unsteady(one.frequency, one.round, one.cycles, tuple(one.low.tolist()), tuple(one.high.tolist()))
                for one in upwards
                if one.round != 1
            ),
        )

    def _sound(self, states: tuple[SteadyState, ...]) -> tuple[SteadyState, ...]:
        """Leave out where a path that was given up had strayed, at its end."""
        while not self.stated_harmonics and states and states[-1].truncated > DOUBTFUL_SHARE:
            states = states[:-1]
        return states

    def _in_turn(self, first: float, last: float, tell: Progress, begin: Standing | None = None) -> list[MarchedMotion]:
        """March at frequencies (Hz) from one to another, each from the motion before; lowest first.

        Those whose motion has no numbers are left out.
        """
        count = min(MOST_IN_TIME // 2, 2 + ceil(abs(log(last / first)) / log(1 + APART_SHARE)))
        found: list[MarchedMotion] = []
        for frequency in np.geomspace(first, last, count).tolist():
            tell(f"marched in time at {frequency:.4g} Hz")
            one = self.marched(frequency, found[-1].end if found else begin)
            found += [one] if one is not None else []
        return sorted(found, key=lambda one: one.frequency)

    def _finer(self, found: list[MarchedMotion], tell: Progress) -> list[MarchedMotion]:
        """March between motions where the response bends, too."""
        while between := self._bent(found)[: max(0, MOST_IN_TIME - len(found))]:
            for before, frequency in between:
                tell(f"marched in time at {frequency:.4g} Hz")
                one = self.marched(frequency, before.end)
                found = found if one is None else [*found, one]
            found = sorted(found, key=lambda one: one.frequency)
        return found

    def _others(
        self, known: Sequence[MarchedMotion], found: Sequence[MarchedMotion], tell: Progress
    ) -> list[list[MarchedMotion]]:
        """Give the steady motions that aren't those known at their frequency, neighbours together."""
        steady = [one for one in known if one.round == 1]
        if not steady:
            return []
        frequencies, amplitudes = [one.frequency for one in steady], np.array([one.high for one in steady])
        others: list[list[MarchedMotion]] = []
        for is_other, group in groupby(
            (one for one in found if one.round == 1),
            key=lambda one: any(
                abs(np.interp(one.frequency, frequencies, own) / amplitude - 1) > OTHER
                for own, amplitude in zip(amplitudes.T, one.high.tolist(), strict=True)
            ),
        ):
            others += [self._finer(list(group), tell)] if is_other else []
        return others

    @staticmethod
    def _bent(found: Sequence[MarchedMotion]) -> list[tuple[MarchedMotion, float]]:
        """Give frequencies, Hz, between motions where straight lines through their amplitudes aren't near enough, and
        the motion before each."""
        bent: dict[float, MarchedMotion] = {}
        for one, two, three in zip(found, found[1:], found[2:], strict=False):
            share = (two.frequency - one.frequency) / (three.frequency - one.frequency)
            straight = one.high + share * (three.high - one.high)
            if np.any(np.abs(straight - two.high) > STRAIGHT_SHARE * two.high):
                for begin, end in ((one, two), (two, three)):
                    if abs(log(end.frequency / begin.frequency)) > CLOSEST_SHARE:
                        bent[(begin.frequency + end.frequency) / 2] = begin
        return [(before, frequency) for frequency, before in bent.items()]

    def solutions(self, states: Sequence[SteadyState], frequency: float) -> list[Array]:
        """Give the unknowns, (m,) each, where a curve passes a frequency (Hz), in the order in which it does."""
        path = [Solution(state.frequency, packed(state.balanced[None])[0]) for state in states]
        return self.passing(path, frequency)

    def passing(self, path: Sequence[Solution], frequency: float) -> list[Array]:
        """Give the unknowns, (m,) each, where a path passes a frequency (Hz), in the order in which it does."""
        found = []
        for before, after in pairwise(path):
            if (before.parameter - frequency) * (after.parameter - frequency) < 0:
                met = between(self.over_frequency(), before, after, frequency) if self._clamps else before.unknowns
                if met is not None:
                    found.append(met)
            if before.parameter == frequency:
                found.append(before.unknowns)
        if path and path[-1].parameter == frequency:
            found.append(path[-1].unknowns)
        return found

    def marched(self, frequency: float, begin: Standing | None = None) -> MarchedMotion | None:
        """March at a frequency (Hz), from rest unless told, until the motion repeats; as of `InTime.at`."""
        return self.in_time.at(frequency, self.excitation(frequency), begin)

    def state_in_time(self, marched: MarchedMotion) -> SteadyState:
        """Give the steady state to which a march came."""
        points, count = marched.points, len(self._clamps)
        farthest = half_range(points[:count]).tolist()
        return SteadyState(
            frequency=marched.frequency,
            clamps=points[:count],
            probes=points[count:],
            forces=marched.forces,
            conditions=marched.conditions,
            growth=marched.decay,
            truncated=marched.error,
            beyond=tuple(c.beyond(points[i], marched.frequency, farthest[i]) for i, c in enumerate(self._clamps)),
            cycles=marched.cycles,
        )

    def crossings(self, states: Sequence[SteadyState], frequency: float) -> list[SteadyState]:
        """Give the states at a frequency (Hz) at which a curve passes it."""
        return [self.state(unknowns, frequency) for unknowns in self.solutions(states, frequency)]

    def state(self, unknowns: Array, frequency: float, side: int = 0) -> SteadyState:
        """Evaluate a solution (m,) at a frequency (Hz), and its stability; side as of `Solution`."""
        count = len(self._clamps)
        motion = self.unpacked(unknowns[None])
        at, drive = np.array([frequency]), np.array([self.excitation(frequency)])
        H = motion.shape[2] - 1
        told, rubs = max(H, self.told_harmonics), self.rubs(unknowns, frequency)
        if rubs:
            rubbed = self.rubbed(motion[0], frequency, H)
            motion, forces = rubbed.whole[None, :, : told + 1], rubbed.smooth_beyond(H)[None, :, : told + 1]
            moving = np.concatenate([forces[:, :, : H + 1], rubbed.stepping[None, :, H + 1 : told + 1]], axis=2)
            laws = rubbed.disturbed()
        else:
            laws = [tangents(clamp, motion[0, index], frequency) for index, clamp in enumerate(self._clamps)]
            forces = np.zeros((1, count, told + 1), dtype=np.complex128)
            for index, law in enumerate(laws):
                forces[:, index] = harmonics_of(law.force[None], told + 1)
            moving = forces[:, :, : H + 1]
        moved = self.under_forces(moving, drive, self.responses(at, moving.shape[2] - 1))[0]
        conditions = [c.conditions(motion[:, i], np.array([frequency])) for i, c in enumerate(self._clamps)]
        farthest = half_range(moved[:count]).tolist()
        adrift = self._receptance.adrift
        return SteadyState(
            frequency=frequency,
            clamps=moved[:count],
            probes=moved[count:],
            forces=forces[0, :, : H + 1],
            conditions=np.array([[A[0], f[0]] for A, f in conditions]).reshape(count, 2),
            growth=growth(self._stiffness, self._damping, self._shapes, laws, 1 / frequency, adrift=adrift),
            truncated=truncated(self, unknowns, at, drive, forces) if count else 0.0,
            beyond=tuple(c.beyond(motion[0, i], frequency, farthest[i]) for i, c in enumerate(self._clamps)),
            side=side,
            unbounded=self.unbounded(unknowns, frequency),
        )
