"""A described pipe reduced to modes: what the pipe FMU and the monolithic solution step through time.

q'' + 2 zeta omega q' + omega^2 q = participation u - sum over clamps of shape f, with u the base's acceleration (m/s2;
all displacements are then relative to the base) or a force (N), and f the force into each clamp (N).

The modes up to the stated frequency are kept as they are. What the modes above it give statically at the clamps and at
the excitation is kept too, by residual vectors (MacNeal's residual flexibility, Computers & Structures 1 (1971) 581, as
further modes): without them a clamp that is stiff beside the pipe would feel a pipe that is too stiff. Where that
leaves a larger error than the stated one, without clamps or with clamps as stiff as any, further modes are kept.

The modes are those of the pipe at rest and without axial force, and damping is theirs. Axial force and flow couple
them: full matrices are added to omega^2 and 2 zeta omega, and the motions that the pipe then has are complex modes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, pi
from typing import TypedDict

import numpy as np
from scipy.linalg import eigh

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.digits import plain
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.pipe.beam import ELEMENT_PHASE, Assembly, Attachment, assemble, mesh, modes, upright
from pipeclamp_models.pipe.description import EndCondition, PipeDescription, Springs
from pipeclamp_models.pipe.materials import find_fluid, find_material
from pipeclamp_models.pipe.section import beam_of, shear_error
from pipeclamp_models.pipe.stability import Onset, Stability, buckling_load, natural_frequencies, onset, stability
from pipeclamp_models.pipe.truncation import FullResponse, ModalModel, ReductionErrors

MOST_NODES = 600
"""A finer mesh than this takes minutes and hints at a wrong unit."""

FASTEST_FLOW = 15.0
"""Dimensionless flow velocity u = U L sqrt(M/(E I)) up to which the onset of instability is looked for."""

WARM = 50.0
"""K by which a pipe may be beyond the table of its fluid or its material, before it is said."""

ROUNDING_SHARE = 1e-10
"""Share of a shape's largest entry below which another is rounding."""

CONDITION_STIFFNESS: dict[str, tuple[float, float]] = {
    "free": (0.0, 0.0),
    "pinned": (inf, 0.0),
    "clamped": (inf, inf),
    "guided": (0.0, inf),
}
"""Stiffness against displacement and against slope of the named conditions."""


@dataclass(frozen=True)
class ReducedPipe:
    """A pipe in modes of unit mass; plain numbers, so that it can be written into an FMU.

    Attributes:
        name: of the pipe.
        omega: rad/s per mode; 0 for rigid body modes. The residual modes come last.
        damping: 2 zeta omega, 1/s, per mode.
        coupling_stiffness: [mode][mode], 1/s2, added to omega^2 by axial force and flow; () without.
        coupling_damping: [mode][mode], 1/s, added to damping by the flow; () without.
        kept: how many of the modes are the pipe's own; those after them are residual.
        clamp_names: of the clamps, in the description's order.
        clamp_shapes: [clamp][mode], 1/sqrt(kg): displacement per modal displacement.
        probe_names: of the probes.
        probe_shapes: [probe][mode].
        excitation: "base" or "force".
        excitation_participation: [mode]: modal load per m/s2 of the base, or per N.
        up_to_Hz: the stated frequency.
        length: m.
        mass: all that moves, kg.
        mass_per_length: kg/m, with fluid.
        bending_stiffness: E I, N m2.
        compression: axial force that keeps its direction, N; below 0 for tension.
        buckling_load: compression at which the pipe at rest buckles, N; None where it can move as a rigid body.
        velocity: of the flow, m/s.
        stability: what the pipe without clamps does by itself.
        onset: where a growing flow makes it unstable; None without flow, or where it doesn't.
        errors: what the reduction costs.
        shear_error: estimated share by which beam theory without shear and rotary inertia overstates the frequency of
            a mode at `up_to_Hz`; 0 where they count.
        notes: what else a user should know.
    """

    name: str
    omega: tuple[float, ...]
    damping: tuple[float, ...]
    coupling_stiffness: tuple[tuple[float, ...], ...]
    coupling_damping: tuple[tuple[float, ...], ...]
    kept: int
    clamp_names: tuple[str, ...]
    clamp_shapes: tuple[tuple[float, ...], ...]
    probe_names: tuple[str, ...]
    probe_shapes: tuple[tuple[float, ...], ...]
    excitation: str
    excitation_participation: tuple[float, ...]
    up_to_Hz: float
    length: float
    mass: float
    mass_per_length: float
    bending_stiffness: float
    compression: float
    buckling_load: float | None
    velocity: float
    stability: Stability
    onset: Onset | None
    errors: ReductionErrors
    shear_error: float
    notes: tuple[str, ...]

    @property
    def zeta(self) -> tuple[float, ...]:
        """Damping ratio per mode; 0 for rigid body modes."""
        return tuple(d / (2 * w) if w else 0.0 for w, d in zip(self.omega, self.damping, strict=True))

    @property
    def stiffness_matrix(self) -> Array:
        """Modal stiffness with axial force and flow, 1/s2, (n, n)."""
        stiffness = np.diag(np.square(self.omega))
        return stiffness + np.array(self.coupling_stiffness) if self.coupling_stiffness else stiffness

    @property
    def damping_matrix(self) -> Array:
        """Modal damping with flow, 1/s, (n, n)."""
        damping = np.diag(self.damping)
        return damping + np.array(self.coupling_damping) if self.coupling_damping else damping

    @property
    def frequencies(self) -> tuple[float, ...]:
        """Natural frequencies without clamps, with axial force and flow, Hz; as many as were kept at most."""
        if self.coupling_stiffness:
            return natural_frequencies(self.stiffness_matrix, self.damping_matrix)[: self.kept]
        return tuple(w / (2 * pi) for w in self.omega[: self.kept])

    def summary(self) -> str:
        """Give what was kept and what it costs, for a person to read."""
        first = ", ".join(f"{frequency:.4g}" for frequency in self.frequencies[:6])
        more = ", ..." if self.kept > 6 else ""
        lines = [
            f"pipe {self.name!r}, straight: {plain(self.mass, 4)} kg, E I = {plain(self.bending_stiffness, 4)} N m²",
            f"{self.kept} modes kept for {self.up_to_Hz:g} Hz: {first}{more} Hz; "
            f"{len(self.omega) - self.kept} residual modes",
            f"static compliance: {self.errors.static_truncated:.1%} of it lies in the modes left out; "
            f"with the residual modes it errs by {self.errors.static:.1e}",
            f"frequency response up to {self.up_to_Hz:g} Hz: the modes left out change it by at most "
            f"{100 * self.errors.response:.2g}% without clamps{self._about_clamps()}",
            *self._about_stability(),
        ]
        if self.shear_error > 0.02:
            lines.append(
                f"shear and rotary inertia, which are neglected, would lower a mode at {self.up_to_Hz:g} Hz "
                f"by about {self.shear_error:.0%}; pipe.theory = 'timoshenko' takes them in"
            )
        return "\n".join((*lines, *self.notes))

    def _about_clamps(self) -> str:
        """Say what the reduction costs with clamps."""
        if not self.errors.clamped_at:
            return ""
        stiffest = float(f"{max(self.errors.clamped_at) / 1e3:.2g}")
        return f", and by {100 * self.errors.clamped:.2g}% with clamps of any stiffness (most at {stiffest:g} N/mm)"

    def _about_stability(self) -> list[str]:
        """Say what axial force and flow do."""
        lines = []
        if self.compression:
            kind, load = ("compression", self.compression) if self.compression > 0 else ("tension", -self.compression)
            share = f", {load / self.buckling_load:.0%} of its buckling load" if self.buckling_load else ""
            lines.append(f"axial {kind} {plain(load, 4)} N{share if kind == 'compression' else ''}")
        if self.velocity:
            begins = "stable at any flow that was tried"
            if self.onset:
                begins = f"{self.onset.kind} from {self.onset.velocity:.4g} m/s on"
            lines.append(f"flow {self.velocity:g} m/s; without clamps: {begins}")
        if self.stability.kind == "divergence":
            lines.append(
                f"UNSTABLE without clamps: it diverges (buckles), growing with {self.stability.growth:.3g} 1/s; only "
                "clamps that hold it make a result of this pipe worth anything"
            )
        if self.stability.kind == "flutter":
            lines.append(
                f"UNSTABLE without clamps: it flutters at {self.stability.frequency:.4g} Hz, growing with "
                f"{self.stability.growth:.3g} 1/s"
            )
        return lines


def attachments_of(description: PipeDescription) -> tuple[Attachment, ...]:
    """Give the ends, supports and masses as what is attached to the beam."""
    length = description.pipe.length_m
    held: list[tuple[float, EndCondition]] = [(0.0, description.ends.left), (length, description.ends.right)]
    held += [(support.position_m, support.condition) for support in description.supports]
    return (
        *(Attachment(position, *_stiffnesses(condition)) for position, condition in held),
        *(
            Attachment(entry.position_m, mass=entry.mass_kg, rotary_inertia=entry.rotary_inertia_kg_m2)
            for entry in description.masses
        ),
    )


def _stiffnesses(condition: EndCondition) -> tuple[float, float]:
    if isinstance(condition, Springs):
        return 1e3 * condition.stiffness_N_mm, condition.rotational_stiffness_Nm_rad
    return CONDITION_STIFFNESS[condition]


def finite_elements(description: PipeDescription) -> Assembly:
    """Give the finite element model of a pipe, fine enough for the modes up to the stated frequency.

    Raises:
        UserError: the stated frequency needs an unreasonable number of elements, or supports nearly coincide.
    """
    beam = beam_of(description)
    attachments = attachments_of(description)
    points = [entry.position_m for entry in (*description.clamps, *description.probes)]
    if description.excitation.position_m is not None:
        points.append(description.excitation.position_m)
    held = tuple(attachment.position for attachment in attachments)
    omega = 2 * pi * description.modes.up_to_Hz
    longest = min(ELEMENT_PHASE / beam.wave_number(omega), beam.length / 16)
    if beam.length / longest > MOST_NODES:
        raise UserError(
            f"pipe {description.name!r}: modes.up_to_Hz = {description.modes.up_to_Hz:g} needs "
            f"{beam.length / longest:.0f} elements, expected at most {MOST_NODES}; lower it, or check length_m "
            f"and the section"
        )
    try:
        nodes = mesh(beam.length, held, tuple(points), longest)
    except ValueError as error:
        raise UserError(f"pipe {description.name!r}: supports and masses: {error}") from error
    return assemble(beam, nodes, attachments)


@one_thread()
def reduce(description: PipeDescription) -> ReducedPipe:
    """Reduce a pipe to its modes up to the stated frequency, with residual modes for its clamps and its excitation.

    Raises:
        UserError: a clamp or the force sits where the pipe can't move, or no mode lies below the stated frequency.
    """
    full = _FullModel(description)
    up_to = 2 * pi * description.modes.up_to_Hz
    in_band = int(np.count_nonzero(full.omega <= up_to))
    if in_band == 0:
        raise UserError(
            f"pipe {description.name!r}: no mode lies below modes.up_to_Hz = {description.modes.up_to_Hz:g}; "
            f"the lowest is at {full.omega[0] / (2 * pi):.4g} Hz: raise it"
        )
    reference = FullResponse(full.modal(full.omega, full.shapes), in_band, up_to, len(description.clamps))
    for kept in range(in_band, reference.most + 1):
        all_omega, all_shapes = full.with_residual_modes(kept)
        reduced = full.modal(all_omega, all_shapes)
        errors = reference.errors(reduced, kept)
        if errors.largest <= description.modes.error:
            break
    beam = full.beam
    over_modes = full.assembly.loads.over(all_shapes)
    stiffness, damping = reduced.matrices(all_omega.size)

    def at_velocity(velocity: float) -> tuple[Array, Array]:
        flow = description.flow.model_copy(update={"velocity_m_s": velocity})
        added = over_modes.matrices(beam_of(description.model_copy(update={"flow": flow})))
        return np.diag(all_omega**2) + added[0], np.diag(reduced.damping) + added[1]

    fastest = (
        FASTEST_FLOW / beam.length * float(np.sqrt(beam.bending_stiffness / beam.fluid_mass)) if beam.velocity else 0.0
    )
    return ReducedPipe(
        name=description.name,
        **_moving(full, reduced, kept),
        clamp_names=tuple(entry.name for entry in description.clamps),
        excitation=description.excitation.kind,
        up_to_Hz=description.modes.up_to_Hz,
        length=beam.length,
        mass=beam.mass_per_length * beam.length + sum(entry.mass_kg for entry in description.masses),
        mass_per_length=beam.mass_per_length,
        bending_stiffness=beam.bending_stiffness,
        compression=beam.compression,
        buckling_load=buckling_load(all_omega, over_modes.straightening),
        velocity=beam.velocity,
        stability=stability(stiffness, damping) if full.loaded else Stability("stable", 0.0, 0.0),
        onset=onset(at_velocity, max(2 * beam.velocity, fastest)) if beam.velocity else None,
        errors=errors,
        shear_error=shear_error(description, up_to),
        notes=(*_about_reduction(description, kept, errors), *_about_tables(description)),
    )


@one_thread()
def reduce_likewise(description: PipeDescription, neighbour: ReducedPipe) -> ReducedPipe:
    """Reduce a pipe that differs a little from one that was reduced, keeping as many modes.

    Only what decides its motion and what its probes see is computed again, and it may have other probes; what the
    reduction costs, mass and stability stay the neighbour's.

    Raises:
        UserError: a clamp or the force sits where the pipe can't move.
    """
    full = _FullModel(description)
    reduced = full.modal(*full.with_residual_modes(neighbour.kept))
    return replace(neighbour, **_moving(full, reduced, neighbour.kept))


class _FullModel:
    """All modes of a pipe's finite elements, with what acts on them and what is seen of them."""

    def __init__(self, description: PipeDescription) -> None:
        self.description, self.beam = description, beam_of(description)
        self.assembly = finite_elements(description)
        self.omega, self.shapes = modes(self.beam, self.assembly)
        self.loaded = bool(self.beam.compression or self.beam.velocity)
        self._inputs = _load_vectors(description, self.assembly)
        self._rows = _rows(self.assembly, [entry.position_m for entry in (*description.clamps, *description.probes)])

    def modal(self, omega: Array, shapes: Array) -> ModalModel:
        """Give the model over modes: omega (n,), rad/s, and shapes (d, n)."""
        coupling = self.assembly.loads.over(shapes).matrices(self.beam) if self.loaded else None
        damping = _damping(self.description, omega)
        return ModalModel(omega, damping, shapes.T @ self._inputs, self._rows @ shapes, coupling)

    def with_residual_modes(self, kept: int) -> tuple[Array, Array]:
        """Give the kept modes and, after them, the residual ones of those left out: omega (n,) and shapes (d, n)."""
        left_out, above = self.shapes[:, kept:], self.omega[kept:]
        residual = left_out @ ((left_out.T @ self._inputs) / above[:, None] ** 2)
        omega, shapes = _residual_modes(self.assembly, residual)
        return np.concatenate([self.omega[:kept], omega]), np.hstack([self.shapes[:, :kept], shapes])


class _Moving(TypedDict):
    """What of a reduced pipe decides its motion and what is seen of it, as of `ReducedPipe`."""

    probe_names: tuple[str, ...]
    omega: tuple[float, ...]
    damping: tuple[float, ...]
    coupling_stiffness: tuple[tuple[float, ...], ...]
    coupling_damping: tuple[tuple[float, ...], ...]
    kept: int
    clamp_shapes: tuple[tuple[float, ...], ...]
    probe_shapes: tuple[tuple[float, ...], ...]
    excitation_participation: tuple[float, ...]


def _moving(full: _FullModel, reduced: ModalModel, kept: int) -> _Moving:
    clamps = len(full.description.clamps)
    return _Moving(
        probe_names=tuple(entry.name for entry in full.description.probes),
        omega=_floats(reduced.omega),
        damping=_floats(reduced.damping),
        coupling_stiffness=tuple(map(_floats, reduced.coupling[0])) if reduced.coupling else (),
        coupling_damping=tuple(map(_floats, reduced.coupling[1])) if reduced.coupling else (),
        kept=kept,
        clamp_shapes=tuple(map(_without_rounding, reduced.shapes[:clamps])),
        probe_shapes=tuple(map(_without_rounding, reduced.shapes[clamps:])),
        excitation_participation=_without_rounding(reduced.loads[:, -1]),
    )


def _without_rounding(shape: Array) -> tuple[float, ...]:
    """Give a shape (n,) with zeros where a mode has a node, of which the eigenvalue solver makes some 1e-12."""
    return _floats(np.where(np.abs(shape) > ROUNDING_SHARE * np.abs(shape).max(initial=0.0), shape, 0.0))


def _about_reduction(description: PipeDescription, kept: int, errors: ReductionErrors) -> list[str]:
    """Say where the stated error isn't reached."""
    if errors.largest <= description.modes.error:
        return []
    return [
        f"modes.error = {description.modes.error:g} isn't reached: with {kept} modes, as many as are tried, the error "
        f"is {errors.largest:.2g}; raise modes.up_to_Hz or allow a larger error"
    ]


def _about_tables(description: PipeDescription) -> list[str]:
    """Say where fluid and material are taken beyond their tables."""
    table = description.pipe
    lines = []
    if isinstance(table.fluid, str) and table.fluid != "empty":
        hottest = find_fluid(table.fluid).hottest
        if table.temperature_C > hottest + WARM:
            lines.append(
                f"{table.fluid} is taken with its density at {hottest:g} °C, the pipe is at "
                f"{table.temperature_C:g} °C; give fluid = {{ density_kg_m3 = ... }} where that matters"
            )
    if isinstance(table.material, str):
        material = find_material(table.material)
        known = min(max(table.temperature_C, material.coldest), material.hottest)
        if abs(table.temperature_C - known) > WARM:
            lines.append(
                f"{table.material} is taken with its stiffness and expansion at {known:g} °C, where its table ends; "
                f"the pipe is at {table.temperature_C:g} °C; give material = {{ E_GPa = ..., density_kg_m3 = ... }}"
            )
    return lines


def _floats(values: Array) -> tuple[float, ...]:
    return tuple(float(value) for value in values)


def _rows(assembly: Assembly, positions: list[float]) -> Array:
    """Give the rows that pick the displacements at the positions, (positions, d)."""
    rows = [assembly.displacement_at(position) for position in positions]
    return np.array(rows).reshape(len(positions), assembly.mass.shape[0])


def _load_vectors(description: PipeDescription, assembly: Assembly) -> Array:
    """Give the load of a unit force at each clamp, and last that of the excitation, (d, clamps + 1)."""
    columns = []
    for entry in description.clamps:
        columns.append(assembly.displacement_at(entry.position_m))
        if not columns[-1].any():
            raise UserError(
                f"pipe {description.name!r}: clamp {entry.name!r} at {entry.position_m:g} m sits on a rigid support, "
                "where nothing moves; give one of them another position, or the support a stiffness"
            )
    position = description.excitation.position_m
    if position is None:
        columns.append(-assembly.inertia)
    else:
        columns.append(assembly.displacement_at(position))
        if not columns[-1].any():
            raise UserError(
                f"pipe {description.name!r}: the exciting force at {position:g} m acts on a rigid support; "
                "give it another position_m"
            )
    return np.column_stack(columns)


def _residual_modes(assembly: Assembly, residual: Array) -> tuple[Array, Array]:
    """Make modes of unit mass out of residual vectors.

    Args:
        assembly: the finite element model.
        residual: static shapes of the left-out modes under each load, (d, loads).

    Returns:
        omega (r,), rad/s, and shapes (d, r); r is smaller than the number of loads where they give the same shapes.
    """
    if not residual.any():
        return np.zeros(0), np.zeros((residual.shape[0], 0))
    norms = np.sqrt(np.einsum("ij,ij->j", residual, assembly.mass @ residual))
    present = residual[:, norms > 1e-12 * norms.max(initial=0.0)] / norms[norms > 1e-12 * norms.max(initial=0.0)]
    weight, mix = eigh(present.T @ assembly.mass @ present)
    independent = weight > 1e-9
    basis = present @ (mix[:, independent] / np.sqrt(weight[independent]))
    squared, turn = eigh(basis.T @ assembly.stiffness @ basis)
    return np.sqrt(squared), upright(basis @ turn)


def _damping(description: PipeDescription, omega: Array) -> Array:
    """Give 2 zeta omega of the modes, 1/s."""
    table = description.damping
    if table.ratio is not None:
        return 2 * table.ratio * omega
    return (table.rayleigh_alpha_1_s or 0.0) + (table.rayleigh_beta_s or 0.0) * omega**2
