"""A straight beam in bending that carries a flowing fluid: elements, assembly, modes.

Between nodes (Paidoussis, Fluid-Structure Interactions 1, 2nd ed. 2014, chapter 3; P is the axial compression)

    E I w'''' + (P + M U^2) w'' + 2 M U w_xt + m w_tt = 0.

Each node has a displacement w and a rotation of the section, which is w' where shear is neglected. The elements' static
shapes are exact (Friedman & Kosmatka, Computers & Structures 47 (1993) 473; Hermite's cubics for phi = 0), the mass is
consistent. Alone, they overstate an eigenfrequency by (beta l)^4/1440 for elements of length l (beta^4 =
omega^2 m/(E I)) and by (k l)^2/24 times the share of shear: inertia bends and shears an element further, between its
nodes. That is counted too, see `modes`, and 2e-6 of a frequency is left.

The fluid enters and leaves along the pipe: at an end that can move, M U (w_t + U w') stays as the force of the flow,
which is what makes a cantilever flutter.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import ceil, inf, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.one_thread import one_thread

ELEMENT_PHASE = 0.4
"""beta l of the longest element at the highest frequency: inertia within it takes 2e-5 of an eigenfrequency."""
SHEAR_WITHIN = 1e-4
"""Share of an eigenfrequency that the shear within elements by their own inertia may take at most."""
WITHIN = 1e-2
"""Share of omega^2 up to which what inertia does within elements is counted; beyond it, modes are the mesh's."""
CLOSEST = 2e-4
"""Of the beam's length: nodes closer than this would cost the stiffness matrix its digits, which hold E I/l^3."""

SAME = 1e-6
"""Of the beam's length: positions closer than this are the same."""

SHIFT = 1e-2
RIGID = 1e-5
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
        """Give beta in 1/m at an angular frequency in rad/s: beta^4 = omega^2 m/(E I)."""
        return float((omega**2 * self.mass_per_length / self.bending_stiffness) ** 0.25)

    def longest_element(self, omega: float) -> float:
        """Give the length of elements, m, with which modes up to an angular frequency in rad/s are right.

        A bending wave of wave number k has the share E I k^2/(E I k^2 + kappa G A) of its stiffness energy in shear; a
        shear angle that is constant over elements of length l overstates that by (k l)^2/12.
        """
        bent = ELEMENT_PHASE / self.wave_number(omega)
        if self.shear_stiffness == inf:
            return bent
        mass, inertia = self.mass_per_length * omega**2, self.rotary_inertia * omega**2
        a, b = self.shear_stiffness * self.bending_stiffness, mass * self.bending_stiffness
        b += inertia * self.shear_stiffness
        squared = (b + sqrt(b**2 - 4 * a * mass * (inertia - self.shear_stiffness))) / (2 * a)
        share = self.bending_stiffness * squared / (self.bending_stiffness * squared + self.shear_stiffness)
        return float(min(bent, sqrt(24 * SHEAR_WITHIN / (share * squared))))

    def shear_ratio(self, length: float) -> float:
        """Give phi = 12 E I/(kappa G A l^2) of an element of a length in m."""
        return 12 * self.bending_stiffness / (self.shear_stiffness * length**2)


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
        shear_ratios: phi of each element, (n - 1,).
        free: which of the 2 n degrees of freedom (w, rotation by node) are free, (2 n,).
        mass: (d, d), kg.
        stiffness: (d, d), N/m, of the pipe without axial force and flow.
        loads: what axial force and flow act through.
        translation: displacement of the free degrees of freedom when all moves by 1 m, (d,).
        inertia: what holds them back when all, held ones too, is accelerated by 1 m/s2, kg, (d,).
    """

    nodes: Array
    shear_ratios: Array
    free: NDArray[np.bool_]
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
        if abs(self.nodes[nearest] - position) < SAME * self.nodes[-1]:
            position = float(self.nodes[nearest])
        element = min(max(int(np.searchsorted(self.nodes, position, side="right")) - 1, 0), self.nodes.size - 2)
        start, end = self.nodes[element : element + 2]
        a, x = end - start, (position - start) / (end - start)
        row[2 * element : 2 * element + 4] = shapes_at(x, a, float(self.shear_ratios[element]))[0]
        return row[self.free]


GAUSS = np.polynomial.legendre.leggauss(4)
"""Points and weights that integrate the product of two element shapes exactly."""


def shapes_at(x: float, length: float, shear_ratio: float) -> tuple[Array, Array, Array]:
    """Give an element's shapes at x from 0 to 1: displacement, its slope, the section's rotation, each (4,).

    Args:
        x: place in the element, as a share of its length.
        length: m.
        shear_ratio: phi; 0 gives Hermite's cubics.
    """
    a, phi = length, shear_ratio
    displacement = (
        2 * x**3 - 3 * x**2 - phi * x + 1 + phi,
        a * (x**3 - (2 + phi / 2) * x**2 + (1 + phi / 2) * x),
        -(2 * x**3 - 3 * x**2 - phi * x),
        a * (x**3 - (1 - phi / 2) * x**2 - phi / 2 * x),
    )
    slope = (
        (6 * x**2 - 6 * x - phi) / a,
        3 * x**2 - (4 + phi) * x + 1 + phi / 2,
        -(6 * x**2 - 6 * x - phi) / a,
        3 * x**2 - (2 - phi) * x - phi / 2,
    )
    rotation = (
        6 * (x**2 - x) / a,
        3 * x**2 - (4 + phi) * x + 1 + phi,
        -6 * (x**2 - x) / a,
        3 * x**2 - (2 - phi) * x,
    )
    return np.array(displacement) / (1 + phi), np.array(slope) / (1 + phi), np.array(rotation) / (1 + phi)


def element_stiffness(beam: Beam, length: float) -> Array:
    """Give the stiffness of an element over (w1, rotation1, w2, rotation2), N/m, (4, 4)."""
    a, phi = length, beam.shear_ratio(length)
    unscaled = [
        [12, 6 * a, -12, 6 * a],
        [6 * a, (4 + phi) * a**2, -6 * a, (2 - phi) * a**2],
        [-12, -6 * a, 12, -6 * a],
        [6 * a, (2 - phi) * a**2, -6 * a, (4 + phi) * a**2],
    ]
    return beam.bending_stiffness / ((1 + phi) * a**3) * np.array(unscaled)


def element_integrals(beam: Beam, length: float) -> tuple[Array, Array, Array]:
    """Give the consistent mass (kg), the integral of w' w' (1/m) and that of w w' of an element, each (4, 4)."""
    mass, straightening, crossing = np.zeros((4, 4)), np.zeros((4, 4)), np.zeros((4, 4))
    for point, weight in zip(*GAUSS, strict=True):
        displacement, slope, rotation = shapes_at((1 + point) / 2, length, beam.shear_ratio(length))
        share = weight / 2 * length
        mass += share * beam.mass_per_length * np.outer(displacement, displacement)
        mass += share * beam.rotary_inertia * np.outer(rotation, rotation)
        straightening += share * np.outer(slope, slope)
        crossing += share * np.outer(displacement, slope)
    return mass, straightening, crossing


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
    straightening, crossing, outflow = np.zeros((size, size)), np.zeros((size, size)), np.zeros((size, size))
    lengths = [float(length) for length in np.diff(nodes)]
    for index, length in enumerate(lengths):
        own = slice(2 * index, 2 * index + 4)
        stiffness[own, own] += element_stiffness(beam, length)
        for whole, part in zip((mass, straightening, crossing), element_integrals(beam, length), strict=True):
            whole[own, own] += part
    for place, own, length in ((0.0, slice(0, 4), lengths[0]), (1.0, slice(size - 4, size), lengths[-1])):
        displacement, slope, _ = shapes_at(place, length, beam.shear_ratio(length))
        outflow[own, own] += (2 * place - 1) * np.outer(displacement, slope)
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
    return Assembly(
        nodes=nodes,
        shear_ratios=np.array([beam.shear_ratio(length) for length in lengths]),
        free=free,
        mass=mass[kept],
        stiffness=stiffness[kept],
        loads=LoadShapes(straightening[kept], outflow[kept], crossing[kept]),
        translation=translation[free],
        inertia=(mass @ translation)[free],
    )


@one_thread()
def modes(beam: Beam, assembly: Assembly) -> tuple[Array, Array]:
    """Give all natural frequencies and mode shapes of an assembly, without axial force and flow.

    What inertia does within elements is counted in the frequencies, as far as the mesh is fine enough for it.

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
    shift = SHIFT * scale
    mu, shapes = eigh(mass, stiffness + shift * mass)
    if not mu[0] > 0:
        raise UserError(
            f"the pipe moves with {assembly.moving_mass:.3g} kg, {beam.mass_per_length * beam.length:.3g} kg of them "
            "its own, which are lost in rounding; expected masses in kg, and a support where nothing moves"
        )
    squared = 1.0 / mu[::-1] - shift
    shapes = shapes[:, ::-1] / np.sqrt(mu[::-1])
    squared[squared < RIGID * scale] = 0.0
    yielding = squared * within_elements(beam, assembly, shapes)
    grown = np.sqrt(1 + np.where(yielding < WITHIN, yielding, 0.0))
    # The modal mass grows, and the modal stiffness stays: what a load at a node gives statically was exact.
    omega, shapes = np.sqrt(squared) / grown, shapes / grown
    order = np.argsort(omega, kind="stable")
    return omega[order], upright(shapes[:, order])


def within_elements(beam: Beam, assembly: Assembly, shapes: Array) -> Array:
    """Give by how much more elements yield between their nodes in each mode, under the inertia of their own mass.

    An inertia q = m omega^2 w per length bends and shears an element that is held at its ends further, and does the
    work q^2 (l^5/(720 E I) + l^3/(12 kappa G A)) on it, twice what is stored. To first order that lowers omega^2 by so
    much over the modal mass (Rayleigh's quotient with the element's inner deflection).

    Args:
        beam: the beam that was assembled.
        assembly: of it.
        shapes: of unit modal mass, (d, modes).

    Returns:
        share of omega^2 per omega^2, s2, (modes,).
    """
    displacement = np.zeros((assembly.free.size, shapes.shape[1]))
    displacement[assembly.free] = shapes
    start, end = displacement[:-2:2], displacement[2::2]
    length = np.diff(assembly.nodes)[:, None]
    softness = length**2 / (12 * beam.shear_stiffness) + length**4 / (720 * beam.bending_stiffness)
    squares = length * (start**2 + start * end + end**2) / 3
    return np.asarray(beam.mass_per_length**2 * np.sum(softness * squares, axis=0))


def upright(shapes: Array) -> Array:
    """Give shapes, one per column, turned so that the largest entry of each is positive, which LAPACK leaves open."""
    largest = np.take_along_axis(shapes, np.abs(shapes).argmax(axis=0)[None, :], axis=0)
    return np.asarray(shapes * np.sign(largest), dtype=np.float64)
