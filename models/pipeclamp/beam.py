"""A straight Euler-Bernoulli beam in bending: elements, assembly, modes.

E I w'''' + m w_tt = 0 between nodes. Each node has a displacement w and a slope w'. Cubic (Hermite) elements with the
consistent mass: static shapes are exact at the nodes, and an eigenfrequency errs by (beta l)^4/1440 for elements of
length l (beta^4 = omega^2 m/(E I)).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import ceil, inf

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from pipeclamp.one_thread import one_thread

Array = NDArray[np.float64]

ELEMENT_PHASE = 0.4
"""beta l of the longest element at the highest frequency: eigenfrequencies err by 2e-5 of their value."""
CLOSEST = 2e-4
"""Of the beam's length: nodes closer than this would cost the stiffness matrix its digits, which hold E I/l^3."""

SAME = 1e-6
"""Of the beam's length: positions closer than this are the same."""

SHIFT = 1e-2
RIGID = 1e-5
"""Of E I/(M L^3), the scale of omega^2 (12.4 times it for a cantilever): a shift, and what counts as a rigid body."""


@dataclass(frozen=True)
class Beam:
    """A beam of one section.

    Attributes:
        length: m.
        bending_stiffness: E I, N m2.
        mass_per_length: kg/m.
    """

    length: float
    bending_stiffness: float
    mass_per_length: float

    def wave_number(self, omega: float) -> float:
        """Give beta in 1/m at an angular frequency in rad/s: beta^4 = omega^2 m/(E I)."""
        return float((omega**2 * self.mass_per_length / self.bending_stiffness) ** 0.25)


@dataclass(frozen=True)
class Attachment:
    """What is attached to the beam at one position; an infinite stiffness holds it rigidly.

    Attributes:
        position: m.
        stiffness: against displacement, N/m.
        rotational_stiffness: against slope, N m/rad.
        mass: kg.
        rotary_inertia: kg m2.
    """

    position: float
    stiffness: float = 0.0
    rotational_stiffness: float = 0.0
    mass: float = 0.0
    rotary_inertia: float = 0.0


@dataclass(frozen=True, eq=False)
class Assembly:
    """The beam's matrices with what is attached to it, rigidly held degrees of freedom left out.

    Attributes:
        nodes: positions, m, (n,).
        free: which of the 2 n degrees of freedom (w, w' by node) are free, (2 n,).
        mass: (d, d), kg.
        stiffness: (d, d), N/m.
        translation: displacement of the free degrees of freedom when all moves by 1 m, (d,).
    """

    nodes: Array
    free: NDArray[np.bool_]
    mass: Array
    stiffness: Array
    translation: Array

    @property
    def moving_mass(self) -> float:
        """Give the mass that the free degrees of freedom carry in translation, kg."""
        return float(self.translation @ self.mass @ self.translation)

    def displacement_at(self, position: float) -> Array:
        """Give the row that picks the displacement at a position (m) out of the free degrees of freedom, (d,)."""
        row = np.zeros(self.free.size)
        nearest = int(np.argmin(np.abs(self.nodes - position)))
        if abs(self.nodes[nearest] - position) < SAME * self.nodes[-1]:
            position = float(self.nodes[nearest])
        element = min(max(int(np.searchsorted(self.nodes, position, side="right")) - 1, 0), self.nodes.size - 2)
        start, end = self.nodes[element : element + 2]
        a, x = end - start, (position - start) / (end - start)
        row[2 * element : 2 * element + 4] = (
            1 - 3 * x**2 + 2 * x**3,
            a * (x - 2 * x**2 + x**3),
            3 * x**2 - 2 * x**3,
            a * (x**3 - x**2),
        )
        return row[self.free]


def element_matrices(beam: Beam, length: float) -> tuple[Array, Array]:
    """Give the consistent mass (kg) and stiffness (N/m) of an element over (w1, w1', w2, w2'), each (4, 4)."""
    a = length
    mass = (beam.mass_per_length * a / 420) * np.array(
        [
            [156, 22 * a, 54, -13 * a],
            [22 * a, 4 * a**2, 13 * a, -3 * a**2],
            [54, 13 * a, 156, -22 * a],
            [-13 * a, -3 * a**2, -22 * a, 4 * a**2],
        ]
    )
    stiffness = (beam.bending_stiffness / a**3) * np.array(
        [
            [12, 6 * a, -12, 6 * a],
            [6 * a, 4 * a**2, -6 * a, 2 * a**2],
            [-12, -6 * a, 12, -6 * a],
            [6 * a, 2 * a**2, -6 * a, 4 * a**2],
        ]
    )
    return mass, stiffness


def mesh(length: float, held: tuple[float, ...], watched: tuple[float, ...], longest: float) -> Array:
    """Give nodes from 0 to `length`, no further apart than `longest`, m.

    Args:
        length: of the beam, m.
        held: positions of attachments: each is a node.
        watched: positions of loads and of observation: nodes where no other node is closer than `CLOSEST`.
        longest: longest element, m.

    Raises:
        ValueError: two attachments lie closer than `CLOSEST` allows, but not at the same place; the message names them.
    """
    closest = CLOSEST * length
    fixed: list[float] = []
    for position in sorted({0.0, length, *held}):
        if fixed and position - fixed[-1] < closest:
            if position - fixed[-1] > SAME * length:
                raise ValueError(
                    f"something is held at {fixed[-1]:.9g} m and at {position:.9g} m; expected the same position, "
                    f"or at least {1e3 * closest:.3g} mm between them"
                )
            continue
        fixed.append(position)
    for position in watched:
        if min(abs(position - node) for node in fixed) >= closest:
            fixed.append(position)
    parts = [
        np.linspace(start, end, max(1, ceil((end - start) / longest)), endpoint=False)
        for start, end in pairwise(sorted(fixed))
    ]
    return np.concatenate([*parts, [length]])


def assemble(beam: Beam, nodes: Array, attachments: tuple[Attachment, ...]) -> Assembly:
    """Assemble a beam with its attachments.

    Args:
        beam: the beam.
        nodes: positions that `mesh` gave, m, (n,).
        attachments: supports and masses; their positions are nodes.
    """
    size = 2 * nodes.size
    mass, stiffness = np.zeros((size, size)), np.zeros((size, size))
    for index, length in enumerate(np.diff(nodes)):
        own = slice(2 * index, 2 * index + 4)
        element_mass, element_stiffness = element_matrices(beam, float(length))
        mass[own, own] += element_mass
        stiffness[own, own] += element_stiffness
    free = np.ones(size, dtype=bool)
    for attachment in attachments:
        node = 2 * int(np.argmin(np.abs(nodes - attachment.position)))
        springs = (attachment.stiffness, attachment.rotational_stiffness)
        inertias = (attachment.mass, attachment.rotary_inertia)
        for freedom, (spring, inertia) in enumerate(zip(springs, inertias, strict=True), start=node):
            mass[freedom, freedom] += inertia
            if spring == inf:
                free[freedom] = False
            else:
                stiffness[freedom, freedom] += spring
    translation = np.zeros(size)
    translation[0::2] = 1.0
    kept = np.ix_(free, free)
    return Assembly(nodes, free, mass[kept], stiffness[kept], translation[free])


@one_thread()
def modes(beam: Beam, assembly: Assembly) -> tuple[Array, Array]:
    """Give all natural frequencies and mode shapes of an assembly.

    Args:
        beam: the beam that was assembled; it gives the scale of its frequencies.
        assembly: the beam with what is attached to it.

    Returns:
        omega, (d,), rad/s, ascending (0 for rigid body modes), and shapes, (d, d), one per column, of unit modal mass.
    """
    mass, stiffness = assembly.mass, assembly.stiffness
    # The inverse problem, M x = mu (K + s M) x with mu = 1/(omega^2 + s), keeps the digits of the lowest frequencies;
    # the shift s keeps K + s M definite when the beam can move as a rigid body. The whole beam sets it, not the
    # matrices, whose largest entries belong to the shortest elements.
    scale = beam.bending_stiffness / (assembly.moving_mass * beam.length**3)
    shift = SHIFT * scale
    mu, shapes = eigh(mass, stiffness + shift * mass)
    squared = 1.0 / mu[::-1] - shift
    shapes = shapes[:, ::-1] / np.sqrt(mu[::-1])
    squared[squared < RIGID * scale] = 0.0
    return np.sqrt(squared), upright(shapes)


def upright(shapes: Array) -> Array:
    """Give shapes, one per column, turned so that the largest entry of each is positive, which LAPACK leaves open."""
    largest = np.take_along_axis(shapes, np.abs(shapes).argmax(axis=0)[None, :], axis=0)
    return np.asarray(shapes * np.sign(largest), dtype=np.float64)
