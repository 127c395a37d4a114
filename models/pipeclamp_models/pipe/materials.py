"""Pipe materials and fluids by name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from pipeclamp_models.base.errors import UserError, did_you_mean

Entry = TypeVar("Entry")


COLD = 20.0
"""degC: the temperature of the dimensions that a pipe is bought with, and where expansion begins."""

Curve = tuple[tuple[float, ...], tuple[float, ...]]
"""Temperatures in degC and the values there; linear between them, the end values beyond."""


@dataclass(frozen=True)
class Material:
    """An elastic material.

    Attributes:
        cold_density: at 20 degC, kg/m3.
        moduli: Young's modulus in GPa over temperature.
        expansions: mean coefficient of linear expansion from 20 degC in 1e-6/K over temperature.
        poisson: Poisson's ratio.
    """

    cold_density: float
    moduli: Curve
    expansions: Curve
    poisson: float = 0.3

    @property
    def hottest(self) -> float:
        """The temperature up to which all of it is tabulated, degC."""
        return min(self.moduli[0][-1], self.expansions[0][-1])

    @property
    def coldest(self) -> float:
        """The temperature down to which all of it is tabulated, degC."""
        return max(self.moduli[0][0], self.expansions[0][0])

    def youngs_modulus(self, temperature: float) -> float:
        """Give Young's modulus in Pa at a temperature in degC."""
        return 1e9 * _at(temperature, self.moduli)

    def expansion(self, temperature: float) -> float:
        """Give the linear expansion, as a share, from 20 degC to a temperature in degC."""
        return 1e-6 * _at(temperature, self.expansions) * (temperature - COLD)

    def density(self, temperature: float) -> float:
        """Give the density in kg/m3 at a temperature in degC: the mass stays, the volume grows."""
        return self.cold_density / (1 + self.expansion(temperature)) ** 3


@dataclass(frozen=True)
class Fluid:
    """A fluid: its density in kg/m3 over temperature in degC; a single value where no more is tabulated."""

    densities: Curve

    @property
    def hottest(self) -> float:
        """The last temperature of the table, degC."""
        return self.densities[0][-1]

    def density(self, temperature: float) -> float:
        """Give the density in kg/m3 at a temperature in degC."""
        return _at(temperature, self.densities)


def _at(temperature: float, curve: Curve) -> float:
    return float(np.interp(temperature, *curve))


AUSTENITIC_MODULI: Curve = (
    (25.0, 100.0, 200.0, 300.0, 400.0, 500.0, 600.0),
    (195.0, 189.0, 183.0, 176.0, 169.0, 160.0, 151.0),
)
"""Austenitic chromium-nickel steels; ASME BPVC section II part D (metric), table TM-1, group G."""

AUSTENITIC_EXPANSIONS: Curve = (
    (20.0, 100.0, 200.0, 300.0, 400.0, 500.0, 600.0),
    (15.3, 16.2, 17.0, 17.7, 18.1, 18.4, 18.8),
)
"""The same steels; table TE-1, group 3, coefficient B."""

CARBON_MODULI: Curve = (
    (25.0, 100.0, 200.0, 300.0, 400.0, 500.0),
    (202.0, 198.0, 192.0, 185.0, 171.0, 151.0),
)
"""Carbon steels with at most 0.30 % carbon; table TM-1."""

CARBON_EXPANSIONS: Curve = (
    (20.0, 100.0, 200.0, 300.0, 400.0, 500.0),
    (11.5, 12.1, 12.7, 13.3, 13.8, 14.4),
)
"""Carbon and low-alloy steels; table TE-1, group 1, coefficient B."""

MATERIALS: Mapping[str, Material] = {
    "304": Material(8030.0, AUSTENITIC_MODULI, AUSTENITIC_EXPANSIONS),
    "304L": Material(8030.0, AUSTENITIC_MODULI, AUSTENITIC_EXPANSIONS),
    "316L": Material(8030.0, AUSTENITIC_MODULI, AUSTENITIC_EXPANSIONS),
    "321": Material(8030.0, AUSTENITIC_MODULI, AUSTENITIC_EXPANSIONS),
    "P91": Material(
        7770.0,
        ((20.0, 200.0, 400.0, 650.0), (218.0, 207.0, 190.0, 162.0)),
        ((20.0, 100.0, 200.0, 400.0, 650.0), (10.5, 10.9, 11.3, 12.0, 12.7)),
    ),
    "carbon steel": Material(7750.0, CARBON_MODULI, CARBON_EXPANSIONS),
    "aluminium 6061": Material(
        2713.0, ((25.0, 100.0, 200.0), (69.0, 66.0, 60.0)), ((20.0, 100.0, 200.0), (22.5, 23.4, 24.4)), 0.33
    ),
    "titanium grade 2": Material(
        4510.0,
        ((25.0, 100.0, 200.0, 300.0), (107.0, 103.0, 97.0, 88.0)),
        ((20.0, 100.0, 200.0, 300.0), (8.3, 8.6, 8.8, 9.0)),
        0.32,
    ),
}
"""Materials by name.

Steels, aluminium and titanium after ASME BPVC section II part D (densities and Poisson's ratios: table PRD), P91 after
makers' data sheets of X10CrMoVNb9-1 (1.4903). The standard itself was not at hand: its values are as commonly
reprinted. The expansions of carbon steel were held against a reprint of TE-1, the values of P91 at 200 and 400 degC
against a data sheet; the others were not checked. A design value should be taken from the standard and given as a
table of its own.
"""

FLUIDS: Mapping[str, Fluid] = {
    "empty": Fluid(((20.0,), (0.0,))),
    "air": Fluid(((20.0,), (1.2,))),
    "water": Fluid(((20.0, 100.0, 150.0, 200.0, 250.0, 300.0), (998.2, 958.4, 917.0, 864.7, 799.1, 712.1))),
    "seawater": Fluid(((20.0,), (1025.0,))),
    "hydraulic oil": Fluid(((20.0,), (870.0,))),
    "jet fuel": Fluid(((20.0,), (804.0,))),
}
"""Fluids by name; water as a saturated liquid (as IAPWS-IF97 gives it), the others at 20 degC and 1 bar."""


def find_material(name: str) -> Material:
    """Give a material by name.

    Raises:
        UserError: it isn't in the table.
    """
    return _find(name, MATERIALS, "material", "{ E_GPa = 195, density_kg_m3 = 8030 }")


def find_fluid(name: str) -> Fluid:
    """Give a fluid by name.

    Raises:
        UserError: it isn't in the table.
    """
    return _find(name, FLUIDS, "fluid", "{ density_kg_m3 = 998 }")


def _find(name: str, table: Mapping[str, Entry], kind: str, remedy: str) -> Entry:
    if name in table:
        return table[name]
    expected = f"expected one of {', '.join(map(repr, table))}, or a table {remedy}"
    raise UserError(f"{kind} {name!r} is not known; {did_you_mean(name, table)}{expected}")
