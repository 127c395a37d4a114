"""Steady states of a pipe with clamps under a sine, by harmonic balance: no time integration.

What is balanced stands in `driven`; here it is followed over frequency, and its solutions become states. Whether a
motion is stable is told by Floquet's multipliers.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from pipeclamp_models.base.arrays import Array
from pipeclamp_system.steady.clamp import harmonics_of
from pipeclamp_system.steady.continuation import Solution, Steps, between, follow
from pipeclamp_system.steady.driven import DrivenPipe
from pipeclamp_system.steady.floquet import growth
from pipeclamp_system.steady.harmonics import packed
from pipeclamp_system.steady.start import grown
from pipeclamp_system.steady.states import FollowedResponse, SteadyState, half_range
from pipeclamp_system.steady.tangents import tangents
from pipeclamp_system.steady.truncation import truncated

OVER_FREQUENCY = Steps(widest=0.05)
"""Of a path over frequency: a resonance damped by 1 % stands out twentyfold so far from its frequency, as a share: in
a longer step one that is small beside others could begin and end unseen."""


class SteadySystem(DrivenPipe):
    """A pipe with its clamps under a sine, and the steady states that it comes to."""

    def at(self, frequency: float) -> SteadyState | None:
        """Give the motion at a frequency (Hz) that grows out of rest with the excitation; None where it isn't found."""
        start = grown(self, frequency)
        return None if start is None else self.state(start, frequency)

    def curve(self, first: float, last: float) -> list[SteadyState]:
        """Give the frequency response from one frequency to another (Hz), round its turning points.

        The curve begins at the first frequency; where it ends before the last one, the list does too.
        """
        return [self.state(point.unknowns, point.parameter, point.side) for point in self.path(first, last)]

    def path(self, first: float, last: float) -> list[Solution]:
        """Give the solutions that `curve` evaluates, which takes as long as to find them."""
        start = grown(self, first)
        if start is None:
            return []
        if not self._clamps:
            return [Solution(frequency, start) for frequency in np.linspace(first, last, 200).tolist()]
        size = float(self.sizes(start[None])[0])
        return list(follow(self.over_frequency(), Solution(first, start), last, size, OVER_FREQUENCY))

    def followed(self, first: float, last: float) -> FollowedResponse:
        """Follow the frequency response from its lower end (Hz), and from its upper end where that isn't reached."""
        lower = tuple(self.curve(first, last))
        if lower and lower[-1].frequency == last:
            return FollowedResponse((lower,), whole=True)
        upper = tuple(reversed(self.curve(last, first)))
        if upper and upper[0].frequency == first:
            return FollowedResponse((upper,), whole=True)
        return FollowedResponse(tuple(piece for piece in (lower, upper) if piece), whole=False)

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
        )
