"""The model description: what pythonfmu writes, with what it leaves out.

pythonfmu 0.7 writes no units, displayUnit, min, max, nominal, output dependencies or InitialUnknowns.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement


@dataclass(frozen=True)
class Unit:
    """A unit by its SI base units; `display` gives further units as value_display = factor value + offset."""

    base: Mapping[str, int]
    display: Mapping[str, tuple[float, float]] | None = None


UNITS: Mapping[str, Unit] = {
    "m": Unit({"m": 1}, {"mm": (1000.0, 0.0)}),
    "m/s": Unit({"m": 1, "s": -1}, {"mm/s": (1000.0, 0.0)}),
    "m/s2": Unit({"m": 1, "s": -2}),
    "N": Unit({"kg": 1, "m": 1, "s": -2}),
    "J": Unit({"kg": 1, "m": 2, "s": -2}),
    "Hz": Unit({"s": -1}),
    "K": Unit({"K": 1}, {"degC": (1.0, -273.15)}),
}


@dataclass(frozen=True)
class Quantity:
    """What a person and an importer should know of a variable.

    Attributes:
        description: one phrase.
        unit: one of UNITS; "" for a Boolean.
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


@dataclass(frozen=True)
class ModelText:
    """What the description says of the model as a whole."""

    name: str
    description: str
    version: str
    step_size: float


def completed(
    written: bytes, guid: str, text: ModelText, quantities: Mapping[str, Quantity], initial_inputs: tuple[str, ...]
) -> bytes:
    """Complete pythonfmu's model description.

    Args:
        written: `modelDescription.xml` as pythonfmu wrote it.
        guid: identifies this content.
        text: what is said of the whole.
        quantities: what is said of each variable, by name.
        initial_inputs: names of the variables that outputs depend on at initialisation. After that, outputs are those
            of the last step, so no output depends on an input that is set at the same instant.

    Returns:
        the XML, without a date, so that the same content gives the same bytes.

    Raises:
        ValueError: `quantities` doesn't hold exactly the model's variables.
    """
    root = ElementTree.fromstring(written)
    root.attrib.pop("generationDateAndTime", None)
    tool = root.get("generationTool", "")
    root.attrib |= {
        "modelName": text.name,
        "guid": guid,
        "description": text.description,
        "version": text.version,
        "generationTool": f"pipeclamp {text.version} ({tool})",
    }
    variables = list(root.iter("ScalarVariable"))
    names = [variable.get("name", "") for variable in variables]
    if sorted(names) != sorted(quantities):
        raise ValueError(f"variables without a description or the reverse: {sorted(set(names) ^ set(quantities))}")
    for variable in variables:
        _describe(variable, quantities[variable.get("name", "")])
    root.insert(1, _unit_definitions({quantity.unit for quantity in quantities.values()} - {""}))
    experiment = Element("DefaultExperiment", {"startTime": "0", "stopTime": "1", "stepSize": repr(text.step_size)})
    root.insert(list(root).index(root.find("ModelVariables")), experiment)  # type: ignore[arg-type]
    structure = root.find("ModelStructure")
    if structure is not None:
        root.remove(structure)
    root.append(_structure(variables, [str(names.index(name) + 1) for name in initial_inputs]))
    ElementTree.indent(root)
    return bytes(ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True)) + b"\n"


def _describe(variable: Element, quantity: Quantity) -> None:
    variable.set("description", quantity.description)
    attributes = {
        "unit": quantity.unit or None,
        "displayUnit": quantity.display_unit or None,
        "min": quantity.minimum,
        "max": quantity.maximum,
        "nominal": quantity.nominal,
    }
    kind = variable[0]
    for name, value in attributes.items():
        if value is not None:
            kind.set(name, value if isinstance(value, str) else repr(float(value)))


def _unit_definitions(used: set[str]) -> Element:
    definitions = Element("UnitDefinitions")
    for name in sorted(used):
        unit = SubElement(definitions, "Unit", {"name": name})
        SubElement(unit, "BaseUnit", {base: str(power) for base, power in UNITS[name].base.items()})
        for display, (factor, offset) in (UNITS[name].display or {}).items():
            SubElement(unit, "DisplayUnit", {"name": display, "factor": repr(factor), "offset": repr(offset)})
    return definitions


def _structure(variables: list[Element], initial_inputs: list[str]) -> Element:
    structure = Element("ModelStructure")
    indices = [str(index) for index, variable in enumerate(variables, start=1) if variable.get("causality") == "output"]
    outputs = SubElement(structure, "Outputs")
    unknowns = SubElement(structure, "InitialUnknowns")
    for index in indices:
        SubElement(outputs, "Unknown", {"index": index, "dependencies": ""})
        SubElement(unknowns, "Unknown", {"index": index, "dependencies": " ".join(initial_inputs)})
    return structure
