"""PIPE.toml: a straight pipe as a piping engineer describes it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Discriminator, Field, Tag, model_validator

from pipeclamp_models.base.toml_file import (
    Celsius,
    NotNegative,
    Number,
    Positive,
    ShortName,
    TomlTable,
    looked_up,
    parse_table,
    read_described,
)
from pipeclamp_models.pipe.materials import find_fluid, find_material

SupportKind = Literal["free", "pinned", "clamped", "guided"]


class Springs(TomlTable):
    """An elastic support, against the ground or the base: N/mm in translation, N m/rad in rotation."""

    stiffness_N_mm: NotNegative = 0.0
    rotational_stiffness_Nm_rad: NotNegative = 0.0


def _variant(value: Any) -> str:
    return "(name)" if isinstance(value, str) else "(table)"


EndCondition = Annotated[
    Annotated[SupportKind, Tag("(name)")] | Annotated[Springs, Tag("(table)")],
    Discriminator(_variant),
]
"""How a section is held: "free", "pinned" (no displacement), "clamped" (neither displacement nor slope), "guided" (no
slope), or a table of springs."""


class MaterialTable(TomlTable):
    """A material by its values at the pipe's temperature; the expansion is the mean one from where it was installed.

    No pipe is stiffer or lighter than the bounds: values beyond them are in other units.
    """

    E_GPa: Annotated[Positive, Field(le=2000)]
    density_kg_m3: Annotated[Positive, Field(ge=100)]
    expansion_1e6_K: NotNegative = 0.0
    poisson: Annotated[NotNegative, Field(lt=0.5)] = 0.3


class FluidTable(TomlTable):
    """A fluid by its density."""

    density_kg_m3: NotNegative


class Insulation(TomlTable):
    """Insulation around the pipe; it adds mass, no stiffness."""

    thickness_mm: Positive
    density_kg_m3: Positive


class PipeTable(TomlTable):
    """The pipe itself, its dimensions as bought (at 20 degC).

    `added_mass_kg_m` is cladding or cables that move with it. With theory "timoshenko" shear and rotary inertia count.
    """

    outer_diameter_mm: Positive
    wall_mm: Positive
    length_m: Positive
    material: Annotated[
        Annotated[str, AfterValidator(looked_up(find_material)), Tag("(name)")]
        | Annotated[MaterialTable, Tag("(table)")],
        Discriminator(_variant),
    ]
    fluid: Annotated[
        Annotated[str, AfterValidator(looked_up(find_fluid)), Tag("(name)")] | Annotated[FluidTable, Tag("(table)")],
        Discriminator(_variant),
    ] = "empty"
    insulation: Insulation | None = None
    added_mass_kg_m: NotNegative = 0.0
    temperature_C: Celsius = 20.0
    theory: Literal["euler", "timoshenko"] = "euler"

    @model_validator(mode="after")
    def _has_a_bore(self) -> Self:
        if 2 * self.wall_mm > self.outer_diameter_mm:
            raise ValueError(
                f"wall_mm = {self.wall_mm:g} doesn't fit into outer_diameter_mm = {self.outer_diameter_mm:g}; "
                f"expected at most {self.outer_diameter_mm / 2:g}"
            )
        return self


class Ends(TomlTable):
    """How the two ends are held."""

    left: EndCondition
    right: EndCondition


class Support(TomlTable):
    """A support between the ends."""

    position_m: NotNegative
    condition: EndCondition


class PointMass(TomlTable):
    """A valve, flange or sensor; `rotary_inertia_kg_m2` about an axis across the pipe."""

    position_m: NotNegative
    mass_kg: NotNegative
    rotary_inertia_kg_m2: NotNegative = 0.0


class Place(TomlTable):
    """A named position: a clamp or a probe."""

    name: ShortName
    position_m: NotNegative


class Excitation(TomlTable):
    """What shakes the pipe: the base (ends, supports and clamp foundations move together), or a force at a position."""

    kind: Literal["base", "force"] = "base"
    position_m: NotNegative | None = None

    @model_validator(mode="after")
    def _placed(self) -> Self:
        if (self.kind == "force") != (self.position_m is not None):
            raise ValueError(
                "kind = 'force' needs position_m, the point where the force acts"
                if self.kind == "force"
                else "position_m belongs to kind = 'force'; leave it out, as the base moves everywhere"
            )
        return self


class Damping(TomlTable):
    """The pipe's own damping: one ratio for all modes, or Rayleigh's alpha M + beta K."""

    ratio: Annotated[NotNegative, Field(lt=1)] | None = None
    rayleigh_alpha_1_s: NotNegative | None = None
    rayleigh_beta_s: NotNegative | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        rayleigh = self.rayleigh_alpha_1_s is not None or self.rayleigh_beta_s is not None
        if (self.ratio is not None) == rayleigh:
            raise ValueError("expected either ratio (of critical), or rayleigh_alpha_1_s and rayleigh_beta_s")
        return self


class Flow(TomlTable):
    """The flow in the pipe, from the left end to the right, and its pressure above the surroundings'."""

    velocity_m_s: NotNegative = 0.0
    pressure_bar: NotNegative = 0.0


class Axial(TomlTable):
    """What holds the pipe along its axis, and so what axial force it carries.

    Attributes:
        anchors: "none" (an end slides), "rigid", or the stiffness in N/mm of both anchors together.
        end_thrust: what takes the end thrust of pressure and flow: "outside" (bellows, slip joints, open ends), or
            "pipe" (elbows, caps: the pipe's own wall).
        installed_at_C: temperature at which the anchored pipe had no axial force.
        tension_N: axial force besides, above 0 for tension.
    """

    anchors: Annotated[
        Annotated[Literal["none", "rigid"], Tag("(name)")] | Annotated[Positive, Tag("(number)")],
        Discriminator(lambda value: "(name)" if isinstance(value, str) else "(number)"),
    ] = "none"
    end_thrust: Literal["outside", "pipe"] = "outside"
    installed_at_C: Celsius = 20.0
    tension_N: Number = 0.0


class Modes(TomlTable):
    """The modes that are kept: all up to this frequency, and further ones until the reduction errs by at most `error`.

    `error` is that of the frequency response at each frequency up to there, without clamps and with clamps as stiff as
    any, and of the static compliance, as a share.
    """

    up_to_Hz: Positive
    error: Annotated[Positive, Field(ge=1e-6, lt=0.5)] = 0.01


class PipeDescription(TomlTable):
    """A straight pipe: section, ends, supports, masses, clamps, probes, excitation, flow, axial force, modes."""

    name: Annotated[str, Field(min_length=1, max_length=80)]
    notes: str = ""
    pipe: PipeTable
    ends: Ends
    supports: tuple[Support, ...] = ()
    masses: tuple[PointMass, ...] = ()
    clamps: tuple[Place, ...] = ()
    probes: tuple[Place, ...] = ()
    excitation: Excitation = Excitation()
    flow: Flow = Flow()
    axial: Axial = Axial()
    damping: Damping
    modes: Modes

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        length = self.pipe.length_m
        places = [
            *((f"supports[{i}]", entry.position_m) for i, entry in enumerate(self.supports, 1)),
            *((f"masses[{i}]", entry.position_m) for i, entry in enumerate(self.masses, 1)),
            *((f"clamps[{i}] {entry.name!r}", entry.position_m) for i, entry in enumerate(self.clamps, 1)),
            *((f"probes[{i}] {entry.name!r}", entry.position_m) for i, entry in enumerate(self.probes, 1)),
        ]
        if self.excitation.position_m is not None:
            places.append(("excitation", self.excitation.position_m))
        for place, position in places:
            if position > length:
                raise ValueError(f"{place}: position_m = {position:g} is beyond the pipe's length_m = {length:g}")
        seen = {"base", "excitation"}
        for entry in (*self.clamps, *self.probes):
            if entry.name in seen:
                raise ValueError(
                    f"the name {entry.name!r} is taken; expected a name of its own for each clamp and probe"
                )
            seen.add(entry.name)
        self._refuse_flow_of_nothing()
        self._refuse_impossible_ends()
        return self

    def _refuse_flow_of_nothing(self) -> None:
        """Refuse a flow that nothing flows in."""
        if not self.flow.velocity_m_s:
            return
        fluid = self.pipe.fluid
        if fluid == "empty" or (isinstance(fluid, FluidTable) and not fluid.density_kg_m3):
            raise ValueError(
                f"flow.velocity_m_s = {self.flow.velocity_m_s:g} needs a fluid, and pipe.fluid is without mass; "
                "expected for example pipe.fluid = 'water', or no velocity"
            )
        if 2 * self.pipe.wall_mm == self.pipe.outer_diameter_mm:
            raise ValueError("flow.velocity_m_s needs a bore, and pipe.wall_mm leaves none; expected a thinner wall")

    def _refuse_impossible_ends(self) -> None:
        """Refuse ends that can't carry what flow and anchors put on them."""
        free = [side for side, held in (("left", self.ends.left), ("right", self.ends.right)) if held == "free"]
        if "left" in free and self.flow.velocity_m_s:
            raise ValueError("flow.velocity_m_s needs something that the fluid comes from; ends.left is 'free'")
        if free and self.axial.anchors != "none":
            raise ValueError(f"axial.anchors need both ends held; ends.{free[0]} is 'free'")
        if free and self.flow.pressure_bar and self.axial.end_thrust == "outside":
            raise ValueError(
                f"flow.pressure_bar is 0 at an open end; ends.{free[0]} is 'free': leave the pressure out, or say "
                "axial.end_thrust = 'pipe' for a capped end"
            )
        if "right" in free and self.flow.velocity_m_s and self.axial.end_thrust == "pipe":
            raise ValueError("axial.end_thrust = 'pipe' needs an elbow or a cap, and ends.right is 'free'")


def read_pipe(path: Path) -> PipeDescription:
    """Read a pipe's description.

    Raises:
        UserError: the file is missing, is not TOML, or describes no pipe; the message names the place.
    """
    return read_described(path, PipeDescription, "pipe")


def parse_pipe(text: str, where: str = "pipe") -> PipeDescription:
    """Read a pipe's description from TOML text; `where` is named in errors.

    Raises:
        UserError: the text is not TOML, or describes no pipe.
    """
    return parse_table(text, PipeDescription, where)
