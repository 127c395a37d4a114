"""A described pipe's section as a beam: stiffness, mass, and the axial force of temperature, pressure and anchors."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi

from pipeclamp_models.pipe.beam import Beam
from pipeclamp_models.pipe.description import PipeDescription
from pipeclamp_models.pipe.materials import COLD, find_fluid, find_material

BAR = 1e5
"""Pa."""


@dataclass(frozen=True)
class PipeSection:
    """A pipe's section at its temperature.

    Attributes:
        outer: outer diameter, m.
        inner: inner diameter, m.
        modulus: E, Pa.
        poisson: Poisson's ratio.
        density: of the wall, kg/m3.
        strain: thermal strain since the pipe was installed.
    """

    outer: float
    inner: float
    modulus: float
    poisson: float
    density: float
    strain: float

    @property
    def wall_area(self) -> float:
        """A of the wall, m2."""
        return pi / 4 * (self.outer**2 - self.inner**2)

    @property
    def bore_area(self) -> float:
        """Clear area, m2."""
        return pi / 4 * self.inner**2

    @property
    def second_moment(self) -> float:
        """I, m4."""
        return pi / 64 * (self.outer**4 - self.inner**4)

    @property
    def shear_area(self) -> float:
        """kappa A, m2, with kappa of a round tube (Cowper, J. Appl. Mech. 33 (1966) 335)."""
        nu, ratio = self.poisson, (self.inner / self.outer) ** 2
        kappa = 6 * (1 + nu) * (1 + ratio) ** 2 / ((7 + 6 * nu) * (1 + ratio) ** 2 + (20 + 12 * nu) * ratio)
        return kappa * self.wall_area

    @property
    def shear_modulus(self) -> float:
        """G, Pa."""
        return self.modulus / (2 * (1 + self.poisson))


def section_of(description: PipeDescription) -> PipeSection:
    """Give the section of a pipe: as bought, and grown by its temperature."""
    table = description.pipe
    outer, inner = 1e-3 * table.outer_diameter_mm, 1e-3 * (table.outer_diameter_mm - 2 * table.wall_mm)
    warmed = table.temperature_C - description.axial.installed_at_C
    if isinstance(table.material, str):
        material = find_material(table.material)
        grown = 1 + material.expansion(table.temperature_C)
        return PipeSection(
            outer=outer * grown,
            inner=inner * grown,
            modulus=material.youngs_modulus(table.temperature_C),
            poisson=material.poisson,
            density=material.density(table.temperature_C),
            strain=material.expansion(table.temperature_C) - material.expansion(description.axial.installed_at_C),
        )
    given = table.material
    grown = 1 + 1e-6 * given.expansion_1e6_K * (table.temperature_C - COLD)
    return PipeSection(
        outer=outer * grown,
        inner=inner * grown,
        modulus=1e9 * given.E_GPa,
        poisson=given.poisson,
        density=given.density_kg_m3,
        strain=1e-6 * given.expansion_1e6_K * warmed,
    )


def fluid_density(description: PipeDescription) -> float:
    """Give the density of a pipe's fluid in kg/m3 at the pipe's temperature."""
    fluid = description.pipe.fluid
    return find_fluid(fluid).density(description.pipe.temperature_C) if isinstance(fluid, str) else fluid.density_kg_m3


def compression(description: PipeDescription, section: PipeSection, fluid_mass: float) -> float:
    """Give the axial compression P in N that acts besides the flow's M U^2.

    The wall carries N = E A (strain - thermal strain) + 2 nu p A_bore (a thin tube widened by pressure shortens);
    anchors of stiffness k take the share k/(k + E A/L) of what it can't follow, and P = p A_bore - N. For rigid anchors
    this is Paidoussis' p A (1 - 2 nu) (2014, chapter 3). An end whose thrust the pipe's own wall takes adds
    p A_bore + M U^2 to N.
    """
    axial, pressure = description.axial, BAR * description.flow.pressure_bar
    stiffness = section.modulus * section.wall_area
    anchors = {"none": 0.0, "rigid": inf}.get(str(axial.anchors))
    if anchors is None:
        anchors = 1e3 * float(axial.anchors)
    share = 1.0 if anchors == inf else anchors / (anchors + stiffness / description.pipe.length_m)
    on_bore = pressure * section.bore_area
    taken_by_wall = 0.0
    if axial.end_thrust == "pipe":
        taken_by_wall = on_bore + fluid_mass * description.flow.velocity_m_s**2
    blocked = taken_by_wall + stiffness * section.strain - 2 * section.poisson * on_bore
    return on_bore - taken_by_wall + share * blocked - axial.tension_N


def beam_of(description: PipeDescription) -> Beam:
    """Give the beam that a pipe with its fluid is."""
    table, section = description.pipe, section_of(description)
    fluid_mass = fluid_density(description) * section.bore_area
    carried = table.added_mass_kg_m
    if table.insulation is not None:
        around = section.outer + 2e-3 * table.insulation.thickness_mm
        carried += table.insulation.density_kg_m3 * pi / 4 * (around**2 - section.outer**2)
    shear = table.theory == "timoshenko"
    return Beam(
        length=table.length_m,
        bending_stiffness=section.modulus * section.second_moment,
        mass_per_length=section.density * section.wall_area + fluid_mass + carried,
        shear_stiffness=section.shear_modulus * section.shear_area if shear else inf,
        rotary_inertia=section.density * section.second_moment if shear else 0.0,
        compression=compression(description, section, fluid_mass),
        fluid_mass=fluid_mass,
        velocity=description.flow.velocity_m_s,
    )


def shear_error(description: PipeDescription, omega: float) -> float:
    """Estimate by how much the beam theory overstates a mode's frequency at omega (rad/s); 0 where shear counts.

    (beta r)^2 (1 + E/(kappa G))/2 with r the section's radius of gyration: Timoshenko's first correction.
    """
    if description.pipe.theory == "timoshenko":
        return 0.0
    section, beam = section_of(description), beam_of(description)
    gyration_squared = section.second_moment / section.wall_area
    softness = section.modulus * section.wall_area / (section.shear_modulus * section.shear_area)
    return beam.wave_number(omega) ** 2 * gyration_squared / 2 * (1 + softness)
