"""The model description: units and quantities of all FMUs, and what pythonfmu leaves out of those that it writes.

pythonfmu 0.7 writes no units, displayUnit, min, max, nominal, output dependencies or InitialUnknowns.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from pipeclamp_fmu.describe import legal
from pipeclamp_models.base.said import printable
from pipeclamp_models.base.units import CELSIUS

FILE_NAME = "modelDescription.xml"


@dataclass(frozen=True)
class Unit:
    """A unit by its SI base units, of which it has `factor`; none are given where they aren't known.

    `display` gives further units as value_display = factor value + offset.
    """

    base: Mapping[str, int]
    display: Mapping[str, tuple[float, float]] | None = None
    factor: float = 1.0


UNITS: Mapping[str, Unit] = {
    "m": Unit({"m": 1}, {"mm": (1000.0, 0.0)}),
    "m/s": Unit({"m": 1, "s": -1}, {"mm/s": (1000.0, 0.0)}),
    "m/s2": Unit({"m": 1, "s": -2}),
    "N": Unit({"kg": 1, "m": 1, "s": -2}),
    "J": Unit({"kg": 1, "m": 2, "s": -2}),
    "Hz": Unit({"s": -1}),
    "K": Unit({"K": 1}, {"degC": (1.0, -CELSIUS)}),
    "kg/m3": Unit({"kg": 1, "m": -3}, {"g/cm3": (1e-3, 0.0)}),
    "1": Unit({}),
}

LAW_UNITS: Mapping[str, tuple[Mapping[str, int], int]] = {
    "N": ({"kg": 1, "m": 1, "s": -2}, 0),
    "mm": ({"m": 1}, -3),
    "cm": ({"m": 1}, -2),
    "s": ({"s": 1}, 0),
    "Hz": ({"s": -1}, 0),
    "K": ({"K": 1}, 0),
    "g": ({"kg": 1}, -3),
    "t": ({"kg": 1}, 3),
}
"""What units of a law's coefficients are made of: SI base units and a power of ten."""


def find_unit(name: str) -> Unit:
    """Give a unit of UNITS, or one of a law's coefficients such as `N s2/mm2`; one that isn't known has no base."""
    if name in UNITS:
        return UNITS[name]
    exponents: Counter[str] = Counter()
    ten = 0
    for sign, side in zip((1, -1), name.split("/"), strict=False):
        for part in side.split():
            match = re.fullmatch(r"([A-Za-z]+)(\d*)", part)
            if part == "1":
                continue
            if match is None or match[1] not in LAW_UNITS or name.count("/") > 1:
                return Unit({})
            base, tens = LAW_UNITS[match[1]]
            power = sign * int(match[2] or 1)
            exponents.update({symbol: power * exponent for symbol, exponent in base.items()})
            ten += tens * power
    left = {symbol: exponent for symbol, exponent in exponents.items() if exponent}
    return Unit(left, None, float(f"1e{ten}"))  # no product of floats, which would leave 999999999.9999999


@dataclass(frozen=True)
class Quantity:
    """What a person and an importer should know of a variable.

    Attributes:
        description: one phrase.
        unit: as `find_unit` knows them; "" for a Boolean or a plain number.
        display_unit: the unit for people, "" for the same.
        minimum: smallest sensible value, in `unit`.
        maximum: greatest sensible value, in `unit`.
        nominal: its usual size, in `unit`, above 0.
    """

    description: str
    unit: str = ""
    display_unit: str = ""
    minimum: float | None = None
    maximum: float | None = None
    nominal: float | None = None


def usual(value: float) -> float:
    """Give the value to one digit, as a nominal value; 1 for zero."""
    return float(f"{abs(value):.0e}") or 1.0


@dataclass(frozen=True)
class ModelText:
    """What the description says of the model as a whole.

    Attributes:
        title: what people call it.
        description: what it is, in a phrase that begins with a capital.
        version: of this program.
        step_size: that importers propose, s.
    """

    title: str
    description: str
    version: str
    step_size: float

    @property
    def name(self) -> str:
        """The model's name as an identifier: some importers make variables or files of it."""
        return identifier(self.title)

    @property
    def titled(self) -> str:
        """Title and description as one phrase."""
        return f"{self.title}: {self.description[0].lower()}{self.description[1:]}"


def identifier(name: str) -> str:
    """Give a name with letters, digits and underscores alone, a letter first."""
    plain = re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_")
    return plain if plain[:1].isalpha() else f"model_{plain}".rstrip("_")


def completed(
    root: Element,
    guid: str,
    text: ModelText,
    quantities: Mapping[str, Quantity],
    initially: Mapping[str, Sequence[str]],
    starts: Mapping[str, float],
    tunable: tuple[str, ...] = (),
) -> Element:
    """Complete pythonfmu's model description.

    Args:
        root: the description as pythonfmu gives it; it is changed.
        guid: identifies this content.
        text: what is said of the whole.
        quantities: what is said of each variable, by name.
        initially: names of the variables that each output depends on at initialisation, if it does. After that, outputs
            are those of the last step, so none depends on an input that is set at the same instant.
        starts: start values by name, which pythonfmu writes to 16 digits only.
        tunable: names of inputs that are to be tunable parameters.

    Returns:
        it, without a date, so that the same content gives the same bytes.

    Raises:
        ValueError: `quantities` doesn't hold exactly the model's variables.
    """
    root.attrib.pop("generationDateAndTime", None)
    tool = root.get("generationTool", "")
    root.attrib |= {
        "modelName": text.name,
        "guid": guid,
        "description": text.titled,
        "version": text.version,
        "generationTool": f"pipeclamp {text.version} ({tool})",
        **legal.ATTRIBUTES,
    }
    variables = list(root.iter("ScalarVariable"))
    names = [variable.get("name", "") for variable in variables]
    if sorted(names) != sorted(quantities):
        raise ValueError(f"variables without a description or the reverse: {sorted(set(names) ^ set(quantities))}")
    for variable in variables:
        quantity = quantities[variable.get("name", "")]
        variable.set("description", quantity.description)
        variable[0].attrib |= number_attributes(quantity)
        name = variable.get("name", "")
        if name in starts:
            start = starts[name]
            variable[0].set("start", repr(start) if variable[0].tag == "Real" else str(bool(start)).lower())
        if name in tunable:
            variable.attrib |= {"causality": "parameter", "variability": "tunable"}
    root.insert(1, unit_definitions(quantities.values()))
    root.insert(list(root).index(root.find("ModelVariables")), default_experiment(text))  # type: ignore[arg-type]
    structure = root.find("ModelStructure")
    if structure is not None:
        root.remove(structure)
    root.append(_structure(variables, initially))
    return root


BLANKS = "\n\t"
"""Control characters that XML holds."""


def xml_bytes(root: Element) -> bytes:
    """Give an XML document, indented; characters that XML can't hold stand as they would in Python."""
    for element in root.iter():
        for name, text in element.attrib.items():
            element.set(name, printable(text, keep=BLANKS))
        if element.text:
            element.text = printable(element.text, keep=BLANKS)
    ElementTree.indent(root)
    return bytes(ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True)) + b"\n"


BOUND_DIGITS = 12
"""Of bounds, which are conversions and products of others: so many that rounding doesn't show."""


def number_attributes(quantity: Quantity) -> dict[str, str]:
    """Give the attributes of a Real variable that its quantity says."""
    attributes = {
        "unit": quantity.unit or None,
        "displayUnit": quantity.display_unit or None,
        "min": quantity.minimum,
        "max": quantity.maximum,
        "nominal": quantity.nominal,
    }
    return {
        name: value if isinstance(value, str) else repr(float(f"{value:.{BOUND_DIGITS}g}"))
        for name, value in attributes.items()
        if value is not None
    }


PROPOSED_TOLERANCE = "1e-6"
"""Relative, that importers propose to their integrators."""


def default_experiment(text: ModelText) -> Element:
    """Give the experiment that importers propose."""
    times = {"startTime": "0", "stopTime": "1", "stepSize": repr(text.step_size)}
    return Element("DefaultExperiment", {**times, "tolerance": PROPOSED_TOLERANCE})


def unit_definitions(quantities: Iterable[Quantity]) -> Element:
    """Give the definitions of the units that quantities use."""
    definitions = Element("UnitDefinitions")
    for name in sorted({quantity.unit for quantity in quantities} - {""}):
        unit = find_unit(name)
        element = SubElement(definitions, "Unit", {"name": name})
        if unit.base:
            scale = {} if unit.factor == 1.0 else {"factor": repr(unit.factor)}
            SubElement(element, "BaseUnit", {base: str(power) for base, power in unit.base.items()} | scale)
        for display, (factor, offset) in (unit.display or {}).items():
            SubElement(element, "DisplayUnit", {"name": display, "factor": repr(factor), "offset": repr(offset)})
    return definitions


def _structure(variables: Sequence[Element], initially: Mapping[str, Sequence[str]]) -> Element:
    structure = Element("ModelStructure")
    places = {variable.get("name", ""): str(index) for index, variable in enumerate(variables, start=1)}
    outputs = SubElement(structure, "Outputs")
    unknowns = SubElement(structure, "InitialUnknowns")
    for variable in variables:
        name = variable.get("name", "")
        if variable.get("causality") == "output":
            SubElement(outputs, "Unknown", {"index": places[name], "dependencies": ""})
            known = " ".join(places[entry] for entry in initially.get(name, ()))
            SubElement(unknowns, "Unknown", {"index": places[name], "dependencies": known})
    return structure
