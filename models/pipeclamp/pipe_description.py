"""PIPE.toml: a straight pipe as a piping engineer describes it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Discriminator, Field, Tag, model_validator

from pipeclamp.materials import find_fluid, find_material
from pipeclamp.toml_file import Name, NotNegative, Number, Positive, Table, looked_up, parse_table, read_table

Kind = Literal["free", "pinned", "clamped", "guided"]


class Springs(Table):
    """An elastic support, against the ground or the base: N/mm in translation, N m/rad in rotation."""

    stiffness_N_mm: NotNegative = 0.0
    rotational_stiffness_Nm_rad: NotNegative = 0.0


def _variant(value: Any) -> str:
    return "(name)" if isinstance(value, str) else "(table)"


Condition = Annotated[
    Annotated[Kind, Tag("(name)")] | Annotated[Springs, Tag("(table)")],
    Discriminator(_variant),
]
"""How a section is held: "free", "pinned" (no displacement), "clamped" (neither displacement nor slope), "guided" (no
slope), or a table of springs."""


class MaterialTable(Table):
    """A material by its values."""

    E_GPa: Positive
    density_kg_m3: Positive


class FluidTable(Table):
    """A fluid by its density."""

    density_kg_m3: NotNegative


class PipeTable(Table):
    """The pipe itself; `added_mass_kg_m` is insulation, cladding or cables that move with it."""

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
    added_mass_kg_m: NotNegative = 0.0
    temperature_C: Annotated[Number, Field(ge=-273.15)] = 20.0

    @model_validator(mode="after")
    def _has_a_bore(self) -> Self:
        if 2 * self.wall_mm > self.outer_diameter_mm:
            raise ValueError(
                f"wall_mm = {self.wall_mm:g} doesn't fit into outer_diameter_mm = {self.outer_diameter_mm:g}; "
                f"expected at most {self.outer_diameter_mm / 2:g}"
            )
        return self


class Ends(Table):
    """How the two ends are held."""

    left: Condition
    right: Condition


class Support(Table):
    """A support between the ends."""

    position_m: NotNegative
    condition: Condition


class PointMass(Table):
    """A valve, flange or sensor; `rotary_inertia_kg_m2` about an axis across the pipe."""

    position_m: NotNegative
    mass_kg: NotNegative
    rotary_inertia_kg_m2: NotNegative = 0.0


class Place(Table):
    """A named position: a clamp or a probe."""

    name: Name
    position_m: NotNegative


class Excitation(Table):
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


class Damping(Table):
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


class Modes(Table):
    """The modes that are kept: all up to this frequency."""

    up_to_Hz: Positive


class PipeDescription(Table):
    """A straight pipe: section, ends, supports, masses, clamps, probes, excitation, damping, modes."""

    name: Annotated[str, Field(min_length=1, max_length=80)]
    notes: str = ""
    pipe: PipeTable
    ends: Ends
    supports: tuple[Support, ...] = ()
    masses: tuple[PointMass, ...] = ()
    clamps: tuple[Place, ...] = ()
    probes: tuple[Place, ...] = ()
    excitation: Excitation = Excitation()
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
        return self


def read_pipe(path: Path) -> PipeDescription:
    """Read a pipe's description.

    Raises:
        UserError: the file is missing, is not TOML, or describes no pipe; the message names the place.
    """
    return read_table(path, PipeDescription)


def parse_pipe(text: str, where: str = "pipe") -> PipeDescription:
    """Read a pipe's description from TOML text; `where` is named in errors.

    Raises:
        UserError: the text is not TOML, or describes no pipe.
    """
    return parse_table(text, PipeDescription, where)
