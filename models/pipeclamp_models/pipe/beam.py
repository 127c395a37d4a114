"""A straight beam in bending that carries a flowing fluid: elements, assembly, modes.

Between nodes (Paidoussis, Fluid-Structure Interactions 1, 2nd ed. 2014, chapter 3; P is the axial compression)

    E I w'''' + (P + M U^2) w'' + 2 M U w_xt + m w_tt = 0.

Each node has a displacement w and a rotation of the section, which is w' where shear is neglected; each element has
inner shapes besides, by which its inertia bends and shears it between its nodes (`element`). The mass is consistent.

The fluid enters and leaves along the pipe: at an end that can move, M U (w_t + U w') stays as the force of the flow,
which is what makes a cantilever flutter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import ceil, inf, sqrt

import numpy as np
from scipy.linalg import eigh

from pipeclamp_models.base.arrays import Array, BoolArray, IntArray
from pipeclamp_models.base.digits import plain
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.pipe.element import Element

ELEMENT_PHASE = 0.7
"""Phase of the bending wave along the longest element, at the highest frequency: 1e-9 of an eigenfrequency are left
where shear is neglected, 3e-6 of a pipe's that is as thick as its waves are long."""
CLOSEST = 2e-4
"""Of the beam's length: nodes closer than this would cost the stiffness matrix its digits, which hold E I/l^3."""

SAME_POSITION_SHARE = 1e-6
"""Of the beam's length: positions closer than this are the same."""

EIGENVALUE_SHIFT = 1e-2
RIGID_BODY = 1e-5
"""Of E I/(M L^3), the scale of omega^2 (12.4 times it for a cantilever): a shift, and what counts as a rigid body."""


@dataclass(frozen=True)
class Beam:
    """A beam of one section with the fluid in it.

    Attributes:
        length: m.
        bending_stiffness: E I, N m2.
        mass_per_length: m, all that moves, kg/m.
        shear_stiffness: kappa G A, N; infinite where shear is neglected.
        rotary_inertia: of the section, kg m; 0 where it is neglected.
        compression: P, axial force that keeps its direction, N; below 0 for tension.
        fluid_mass: M, kg/m.
        velocity: U, m/s, from the left end to the right.
    """

    length: float
    bending_stiffness: float
    mass_per_length: float
    shear_stiffness: float = inf
    rotary_inertia: float = 0.0
    compression: float = 0.0
    fluid_mass: float = 0.0
    velocity: float = 0.0

    def wave_number(self, omega: float) -> float:
        """Give that of bending waves at an angular frequency in rad/s, 1/m."""
        mass, inertia = self.mass_per_length * omega**2, self.rotary_inertia * omega**2
        softness = 0.0 if self.shear_stiffness == inf else 1 / self.shear_stiffness
        # E I k^4 = (inertia + E I softness mass) k^2 + mass (1 - softness inertia)
        b = (inertia + self.bending_stiffness * softness * mass) / 2
        squared = b + sqrt(b**2 + self.bending_stiffness * mass * (1 - softness * inertia))
        return sqrt(squared / self.bending_stiffness)

    def element(self, length: float) -> Element:
        """Give an element of a length in m."""
        return Element(length, self.bending_stiffness, 12 * self.bending_stiffness / (self.shear_stiffness * length**2))


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
class LoadShapes:
    """What axial force and flow act through, over the degrees of freedom or over modes, each (d, d).

    Attributes:
        straightening: the integral of w' w', 1/m: times an axial tension, its stiffness.
        outflow: w w' at the right end less that at the left, 1/m: zero where the ends are held.
        crossing: the integral of w w'; the row is the virtual displacement.
    """

    straightening: Array
    outflow: Array
    crossing: Array

    def over(self, shapes: Array) -> LoadShapes:
        """Give the same over modes, whose shapes are the columns of (d, modes)."""
        return LoadShapes(*(shapes.T @ part @ shapes for part in (self.straightening, self.outflow, self.crossing)))

    def matrices(self, beam: Beam) -> tuple[Array, Array]:
        """Give what a beam's axial force and flow add: stiffness (N/m), damping (N s/m), each (d, d).

        With flow neither is symmetric.
        """
        thrust = beam.fluid_mass * beam.velocity**2
        stiffness = -(beam.compression + thrust) * self.straightening + thrust * self.outflow
        return stiffness, 2 * beam.fluid_mass * beam.velocity * self.crossing


@dataclass(frozen=True, eq=False)
class Assembly:
    """The beam's matrices with what is attached to it, rigidly held degrees of freedom left out.

    Attributes:
        nodes: positions, m, (n,).
        elements: between them, n - 1.
        free: which degrees of freedom are free: (w, rotation) by node, then the inner ones by element.
        mass: (d, d), kg.
        stiffness: (d, d), N/m, of the pipe without axial force and flow.
        loads: what axial force and flow act through.
        translation: displacement of the free degrees of freedom when all moves by 1 m, (d,).
        inertia: what holds them back when all, held ones too, is accelerated by 1 m/s2, kg, (d,).
    """

    nodes: Array
    elements: tuple[Element, ...]
    free: BoolArray
    mass: Array
    stiffness: Array
    loads: LoadShapes
    translation: Array
    inertia: Array

    @property
    def moving_mass(self) -> float:
        """Give the mass that the free degrees of freedom carry in translation, kg."""
        return float(self.translation @ self.mass @ self.translation)

    def displacement_at(self, position: float) -> Array:
        """Give the row that picks the displacement at a position (m) out of the free degrees of freedom, (d,)."""
        row = np.zeros(self.free.size)
        nearest = int(np.argmin(np.abs(self.nodes - position)))
        if abs(self.nodes[nearest] - position) < SAME_POSITION_SHARE * self.nodes[-1]:
            position = float(self.nodes[nearest])
        element = min(max(int(np.searchsorted(self.nodes, position, side="right")) - 1, 0), self.nodes.size - 2)
        start = self.nodes[element]
        one = self.elements[element]
        row[_places(self.elements)[element]] = one.shapes_at((position - start) / one.length)[0]
        return row[self.free]


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
            if position - fixed[-1] > SAME_POSITION_SHARE * length:
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
    elements = tuple(beam.element(float(length)) for length in np.diff(nodes))
    places = _places(elements)
    size = int(places[-1][-1]) + 1
    mass, stiffness = np.zeros((size, size)), np.zeros((size, size))
    straightening, crossing, outflow = np.zeros((size, size)), np.zeros((size, size)), np.zeros((size, size))
    for element, own in zip(elements, places, strict=True):
        parts = _matrices(element, beam.mass_per_length, beam.rotary_inertia)
        for whole, part in zip((stiffness, mass, straightening, crossing), parts, strict=True):
            whole[np.ix_(own, own)] += part
    for place, end in ((0, 0), (1, -1)):
        displacement, slope, _ = elements[end].shapes_at(place)
        outflow[np.ix_(places[end], places[end])] += (2 * place - 1) * np.outer(displacement, slope)
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
    translation[: 2 * nodes.size : 2] = 1.0
    kept = np.ix_(free, free)
    return Assembly(
        nodes=nodes,
        elements=elements,
        free=free,
        mass=mass[kept],
        stiffness=stiffness[kept],
        loads=LoadShapes(straightening[kept], outflow[kept], crossing[kept]),
        translation=translation[free],
        inertia=(mass @ translation)[free],
    )


@lru_cache(maxsize=256)
def _matrices(element: Element, mass_per_length: float, rotary_inertia: float) -> tuple[Array, ...]:
    """Give an element's stiffness, then its `integrals`: most elements of a beam, and of its like, are the same."""
    return element.stiffness(), *element.integrals(mass_per_length, rotary_inertia)


def _places(elements: Sequence[Element]) -> list[IntArray]:
    """Give the places of each element's degrees of freedom among all."""
    inner = np.cumsum([2 * (len(elements) + 1), *(element.inner for element in elements)])
    return [
        np.concatenate([np.arange(2 * index, 2 * index + 4), np.arange(*inner[index : index + 2])])
        for index in range(len(elements))
    ]


@one_thread()
def modes(beam: Beam, assembly: Assembly) -> tuple[Array, Array]:
    """Give all natural frequencies and mode shapes of an assembly, without axial force and flow.

    Args:
        beam: the beam that was assembled; it gives the scale of its frequencies.
        assembly: the beam with what is attached to it.

    Returns:
        omega, (d,), rad/s, ascending (0 for rigid body modes), and shapes, (d, d), one per column, of unit modal mass.

    Raises:
        UserError: what is attached is so heavy that the pipe's own mass is lost in rounding.
    """
    mass, stiffness = assembly.mass, assembly.stiffness
    # The inverse problem, M x = mu (K + s M) x with mu = 1/(omega^2 + s), keeps the digits of the lowest frequencies;
    # the shift s keeps K + s M definite when the beam can move as a rigid body. The whole beam sets it, not the
    # matrices, whose largest entries belong to the shortest elements.
    scale = beam.bending_stiffness / (assembly.moving_mass * beam.length**3)
    shift = EIGENVALUE_SHIFT * scale
    mu, shapes = eigh(mass, stiffness + shift * mass)
    if not mu[0] > 0:
        raise UserError(
            f"the pipe moves with {plain(assembly.moving_mass, 3)} kg, "
            f"{plain(beam.mass_per_length * beam.length, 3)} kg of them its own, which are lost in rounding; expected "
            "masses in kg, and a support where nothing moves"
        )
    squared = 1.0 / mu[::-1] - shift
    shapes = shapes[:, ::-1] / np.sqrt(mu[::-1])
    squared[squared < RIGID_BODY * scale] = 0.0
    return np.sqrt(squared), upright(shapes)


def upright(shapes: Array) -> Array:
    """Give shapes, one per column, turned so that the largest entry of each is positive, which LAPACK leaves open."""
    largest = np.take_along_axis(shapes, np.abs(shapes).argmax(axis=0)[None, :], axis=0)
    return np.asarray(shapes * np.sign(largest), dtype=np.float64)
