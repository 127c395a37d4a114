"""Pipe materials and fluids by name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from typing import TypeVar

import numpy as np

from pipeclamp.errors import UserError

Entry = TypeVar("Entry")


@dataclass(frozen=True)
class Material:
    """An elastic material.

    Attributes:
        density: kg/m3.
        temperatures: degC, where the modulus is tabulated; beyond the ends the end values hold.
        moduli: Young's modulus there, GPa.
        poisson: Poisson's ratio.
    """

    density: float
    temperatures: tuple[float, ...]
    moduli: tuple[float, ...]
    poisson: float = 0.3

    def youngs_modulus(self, temperature: float) -> float:
        """Give Young's modulus in Pa at a temperature in degC, linear between the table's."""
        return 1e9 * float(np.interp(temperature, self.temperatures, self.moduli))


AUSTENITIC = ((25.0, 100.0, 200.0, 300.0, 400.0), (195.0, 189.0, 183.0, 176.0, 169.0))
"""Austenitic chromium-nickel steels: degC, GPa; ASME BPVC section II part D, table TM-1, group G."""

CARBON = ((25.0, 100.0, 200.0, 300.0, 400.0), (202.0, 198.0, 192.0, 185.0, 171.0))
"""Carbon steels with at most 0.30 % carbon: degC, GPa; ASME BPVC section II part D, table TM-1."""

MATERIALS: Mapping[str, Material] = {
    "304L": Material(8030.0, *AUSTENITIC),
    "316L": Material(8030.0, *AUSTENITIC),
    "321": Material(8030.0, *AUSTENITIC),
    "carbon steel": Material(7750.0, *CARBON),
    "aluminium 6061": Material(2713.0, (25.0, 100.0, 200.0), (69.0, 66.0, 60.0), 0.33),
    "titanium grade 2": Material(4510.0, (25.0, 100.0, 200.0, 300.0), (107.0, 103.0, 97.0, 88.0), 0.32),
}
"""Materials by name; densities and Poisson's ratios after ASME BPVC section II part D, table PRD."""

FLUIDS: Mapping[str, float] = {
    "empty": 0.0,
    "air": 1.2,
    "water": 998.2,
    "seawater": 1025.0,
    "hydraulic oil": 870.0,
    "jet fuel": 804.0,
}
"""Densities of fluids by name, kg/m3, at 20 degC and atmospheric pressure."""


def find_material(name: str) -> Material:
    """Give a material by name.

    Raises:
        UserError: it isn't in the table.
    """
    return _find(name, MATERIALS, "material", "{ E_GPa = 195, density_kg_m3 = 8030 }")


def find_fluid(name: str) -> float:
    """Give a fluid's density in kg/m3 by name.

    Raises:
        UserError: it isn't in the table.
    """
    return _find(name, FLUIDS, "fluid", "{ density_kg_m3 = 998 }")


def _find(name: str, table: Mapping[str, Entry], kind: str, remedy: str) -> Entry:
    if name in table:
        return table[name]
    nearest = get_close_matches(name, table, n=1, cutoff=0.4)
    hint = f"did you mean {nearest[0]!r}? " if nearest else ""
    raise UserError(
        f"{kind} {name!r} is not known; {hint}expected one of {', '.join(map(repr, table))}, or a table {remedy}"
    )
