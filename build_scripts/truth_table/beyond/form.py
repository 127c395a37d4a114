"""Whether a proposed term has the form of what is hidden: force against force, on motions that neither was fitted to.

Both forces are freed of what the parameters of the law beside the term can do about them, for that part is found
whatever is proposed. Effects in whose place the term stands are none of it: what they could do, the term must.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from cases import FINELY, Drawn
from rig import campaign_of, recorded
from truth import Array

from pipeclamp_identification.fitting.observations import LoopObservations, loop_observations
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.law.law import Law
from pipeclamp_models.realise.force import force_of_equations, force_of_law, known_jacobian

RIGHT_FORM = 0.3
"""The term differs by at most this share (rms) from what is hidden: more than that a diagnosis doesn't call explained
either."""
DETERMINED = 1e-7
"""Directions of the law's tangents of a smaller share of the largest are none."""


class Forces(NamedTuple):
    """Two forces over the harmonics of all held-out runs, of which each counts as its mean square."""

    hidden: Array
    proposed: Array


def difference(drawn: Drawn, sizes: tuple[float, ...], before: Law, after: Law) -> float:
    """Give the rms by which a term differs from what is hidden, over that of what is hidden.

    Args:
        drawn: the case.
        sizes: of what is hidden: the law, and an effect of the catalogue that it may be beside.
        before: a law that lacks the term.
        after: the law with it, which may lack effects of the other.
    """
    there, without = (_observed(drawn, each) for each in (sizes, (0.0, *sizes[1:])))
    seen = there.seen & without.seen
    weights = np.where(np.arange(seen.shape[1]) > 0, np.sqrt(0.5), 1.0) * seen
    hidden = (there.harmonics - without.harmonics) * weights
    (name,) = set(after.structure.effects) - set(before.structure.effects)
    own = [one.name for one in after.structure.effect(name).parameters]
    idle = Law(after.structure, {**after.values, own[0]: 0.0}, after.v_r, after.y_r)
    term = there.transformed(own_force(idle, after, there)) * weights
    beside = [place for place, one in enumerate(idle.equations.names) if one not in own]
    free = freed(tangents(idle, there)[beside] * weights, Forces(hidden, term))
    return relative(free)


def relative(forces: Forces) -> float:
    """Give the rms of their difference over that of the hidden one."""
    return float(np.linalg.norm(forces.proposed - forces.hidden) / np.linalg.norm(forces.hidden))


def freed(directions: Array, forces: Forces) -> Forces:
    """Take out of forces, (R, m) each, what lies along directions, (P, R, m)."""
    flat = directions.reshape(len(directions), -1)
    lengths = np.linalg.norm(flat, axis=1)
    left, singular, _ = np.linalg.svd((flat[lengths > 0] / lengths[lengths > 0, None]).T, full_matrices=False)
    basis = left[:, singular > DETERMINED * singular[:1]]
    return Forces(*(force.ravel() - basis @ (basis.T @ force.ravel()) for force in forces))


def own_force(idle: Law, law: Law, observations: LoopObservations) -> Array:
    """Give what a term does to a law's force, N, (R, n): with it less with its strength nothing."""
    return np.asarray(force_of_law(law, observations.motion).force - force_of_law(idle, observations.motion).force)


def tangents(law: Law, observations: LoopObservations) -> Array:
    """Give what each parameter of a law does to the harmonics of its force, (P, R, m)."""
    equations = law.equations
    force = force_of_equations(
        equations, law.vector(equations), (law.v_r, law.y_r), observations.motion, derivatives=True
    )
    every = np.arange(len(equations.names))
    return np.asarray(known_jacobian(force).through(observations.transformed, every))


def _observed(drawn: Drawn, sizes: tuple[float, ...]) -> LoopObservations:
    """Give the true force on the held-out motions, without noise and scatter."""
    forces = drawn.forces(drawn.heldout, sizes, False)
    channels = [recorded(batch, force, FINELY) for batch, force in zip(drawn.heldout, forces, strict=True)]
    return loop_observations(loops_of(campaign_of("noise-free", drawn.heldout, channels, drawn.needs)))
