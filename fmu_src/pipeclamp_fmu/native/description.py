"""The XML files of a native FMU: its model description in FMI 2.0 and 3.0, its terminals, how to build it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement

from pipeclamp_fmu.describe import legal
from pipeclamp_fmu.describe.model_description import (
    ModelText,
    Quantity,
    default_experiment,
    number_attributes,
    unit_definitions,
    xml_bytes,
)
from pipeclamp_fmu.describe.variables import TIME, Dependencies, Variable, Variables
from pipeclamp_fmu.native.compiler import MAIN_SOURCE

LOG_CATEGORIES = {
    "logStatusWarning": "Messages of a warning",
    "logStatusDiscard": "Messages of a discarded step",
    "logStatusError": "Messages of an error",
    "logStatusFatal": "Messages of a fatal error",
    "logAll": "All messages",
}

TIME_QUANTITY = Quantity("time", "s")
"""FMI 3.0's independent variable."""

FLANGE = "Modelica.Mechanics.Translational.Interfaces.Flange_a"
"""The terminal kind of a translational flange."""


@dataclass(frozen=True)
class Terminal:
    """Variables that belong to one connector: by member name, the variable and FMI's kind of member."""

    name: str
    kind: str
    members: Mapping[str, tuple[str, str]]


@dataclass(frozen=True)
class Description:
    """What the XML files of a native FMU say.

    Attributes:
        identifier: model identifier, the name of the libraries.
        token: guid (FMI 2.0) or instantiation token (FMI 3.0).
        text: what is said of the whole.
        variables: all variables.
        indicator: name of the variable whose zero crossings are events of model exchange, "" for none.
        steps_matter, exchange_slopes: as of `NativeModel`.
        terminals: connectors.
        dependencies: of outputs and states' derivatives.
        tool: program that wrote the FMU, with its version.
    """

    identifier: str
    token: str
    text: ModelText
    variables: Variables
    indicator: str
    steps_matter: bool
    exchange_slopes: bool
    terminals: Sequence[Terminal]
    dependencies: Dependencies
    tool: str

    def structure(self) -> tuple[tuple[Sequence[Variable], Mapping[str, Sequence[str]]], ...]:
        """Give outputs, derivatives, and what is calculated at initialisation, each with what it depends on."""
        variables = self.variables
        known = {variable.name for variable in (*variables.outputs, *variables.locals[: 2 * variables.states])}
        initial = [variable for variable in variables.all if variable.name in known]
        always, initially = self.dependencies.always, self.dependencies.initially
        return (variables.outputs, always), (variables.derivatives, always), (initial, initially)


def model_description(description: Description, fmi: int) -> bytes:
    """Give `modelDescription.xml` in a version of FMI, 2 or 3."""
    return _fmi2(description) if fmi == 2 else _fmi3(description)


def _fmi2(description: Description) -> bytes:
    variables = description.variables
    root = Element("fmiModelDescription", {
        "fmiVersion": "2.0",
        "modelName": description.text.name,
        "guid": description.token,
        "description": description.text.titled,
        "version": description.text.version,
        "generationTool": description.tool,
        **legal.ATTRIBUTES,
        "variableNamingConvention": "structured",
        "numberOfEventIndicators": str(int(bool(description.indicator))),
    })  # fmt: skip
    common = {
        "modelIdentifier": description.identifier,
        "canNotUseMemoryManagementFunctions": "true",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
    }
    exchange = {"providesDirectionalDerivative": _truth(description.exchange_slopes)}
    if not description.steps_matter:
        exchange["completedIntegratorStepNotNeeded"] = "true"
    for kind, own in (
        ("ModelExchange", exchange),
        (
            "CoSimulation",
            {"providesDirectionalDerivative": "true", "canHandleVariableCommunicationStepSize": "true"},
        ),
    ):
        files = SubElement(SubElement(root, kind, common | own), "SourceFiles")
        SubElement(files, "File", {"name": MAIN_SOURCE})
    _common_elements(root, description)
    listed = SubElement(root, "ModelVariables")
    places: dict[str, str] = {}
    for reference, variable in enumerate(variables.all, start=1):
        causality, variability = variables.causality(variable)
        places[variable.name] = str(reference)
        element = SubElement(listed, "ScalarVariable", {
            "name": variable.name,
            "valueReference": str(reference),
            "causality": causality,
            "variability": variability,
            "description": variable.quantity.description,
        })  # fmt: skip
        kind = "Boolean" if variable in variables.booleans else "Real"
        derivative = _derived(variables, variable)
        SubElement(element, kind, number_attributes(variable.quantity) | _start(variable) | derivative)
    structure = SubElement(root, "ModelStructure")
    for kind, (group, known) in zip(
        ("Outputs", "Derivatives", "InitialUnknowns"), description.structure(), strict=True
    ):
        unknowns = SubElement(structure, kind) if group else structure
        for variable in group:
            listed_known = _listed(places, known.get(variable.name, ()))
            SubElement(unknowns, "Unknown", {"index": places[variable.name], "dependencies": listed_known})
    return xml_bytes(root)


def _fmi3(description: Description) -> bytes:
    variables = description.variables
    root = Element("fmiModelDescription", {
        "fmiVersion": "3.0",
        "modelName": description.text.name,
        "instantiationToken": description.token,
        "description": description.text.titled,
        "version": description.text.version,
        "generationTool": description.tool,
        **legal.ATTRIBUTES,
        "variableNamingConvention": "structured",
    })  # fmt: skip
    common = {
        "modelIdentifier": description.identifier,
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
    }
    slopes = ("providesDirectionalDerivatives", "providesAdjointDerivatives")
    exchange = dict.fromkeys(slopes, _truth(description.exchange_slopes))
    exchange["needsCompletedIntegratorStep"] = _truth(description.steps_matter)
    SubElement(root, "ModelExchange", common | exchange)
    stepped = dict.fromkeys(slopes, "true") | {"canHandleVariableCommunicationStepSize": "true"}
    SubElement(root, "CoSimulation", common | stepped)
    _common_elements(root, description, TIME_QUANTITY)
    listed = SubElement(root, "ModelVariables")
    places = {variable.name: str(reference) for reference, variable in enumerate(variables.all, start=1)}
    for variable in variables.all:
        causality, variability = variables.causality(variable)
        SubElement(listed, "Boolean" if variable in variables.booleans else "Float64", {
            "name": variable.name,
            "valueReference": places[variable.name],
            "causality": causality,
            "variability": variability,
            "description": variable.quantity.description,
        } | number_attributes(variable.quantity) | _start(variable) | _derived(variables, variable))  # fmt: skip
    time = {
        "name": TIME,
        "valueReference": str(len(places) + 1),
        "causality": "independent",
        "variability": "continuous",
    }
    SubElement(listed, "Float64", time | {"description": TIME_QUANTITY.description} | number_attributes(TIME_QUANTITY))
    places[TIME] = time["valueReference"]
    structure = SubElement(root, "ModelStructure")
    kinds = ("Output", "ContinuousStateDerivative", "InitialUnknown")
    for kind, (group, known) in zip(kinds, description.structure(), strict=True):
        for variable in group:
            listed_known = _listed(places, known.get(variable.name, ()))
            SubElement(structure, kind, {"valueReference": places[variable.name], "dependencies": listed_known})
    if description.indicator:
        SubElement(structure, "EventIndicator", {"valueReference": places[description.indicator]})
    return xml_bytes(root)


def _listed(places: Mapping[str, str], names: Sequence[str]) -> str:
    """Give the places of variables as a list in their order; FMI 2.0 has none for the time."""
    return " ".join(sorted((places[name] for name in names if name in places), key=int))


def _derived(variables: Variables, variable: Variable) -> dict[str, str]:
    """Give the attribute that tells whose derivative a variable is."""
    if variable not in variables.derivatives:
        return {}
    state = variables.state_variables[variables.derivatives.index(variable)]
    return {"derivative": str(variables.all.index(state) + 1)}


def _common_elements(root: Element, description: Description, *further: Quantity) -> None:
    """Add units, log categories and the default experiment, which both versions have in this order."""
    quantities = [*further, *(variable.quantity for variable in description.variables.all)]
    root.append(unit_definitions(quantities))
    categories = SubElement(root, "LogCategories")
    for name, meaning in LOG_CATEGORIES.items():
        SubElement(categories, "Category", {"name": name, "description": meaning})
    root.append(default_experiment(description.text))


def _start(variable: Variable) -> dict[str, str]:
    if variable.start is None:
        return {}
    return {"start": _truth(variable.start) if isinstance(variable.start, bool) else repr(float(variable.start))}


def _truth(value: bool) -> str:
    return str(value).lower()


def terminals_and_icons(description: Description, with_icon: bool) -> bytes:
    """Give `terminalsAndIcons/terminalsAndIcons.xml`, whose form is FMI 3.0's in 2.0 too."""
    root = Element("fmiTerminalsAndIcons", {"fmiVersion": "3.0"})
    corners = {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"}
    if with_icon:
        picture = SubElement(root, "GraphicalRepresentation")
        SubElement(picture, "CoordinateSystem", corners | {"suggestedScalingFactorTo_mm": "0.1"})
        SubElement(picture, "Icon", corners)
    listed = SubElement(root, "Terminals") if description.terminals else root
    for terminal in description.terminals:
        element = SubElement(
            listed, "Terminal", {"name": terminal.name, "matchingRule": "plug", "terminalKind": terminal.kind}
        )
        for member, (variable, kind) in terminal.members.items():
            attributes = {"variableName": variable, "memberName": member, "variableKind": kind}
            SubElement(element, "TerminalMemberVariable", attributes)
    return xml_bytes(root)


def build_description(identifier: str, fmi: int) -> bytes:
    """Give `sources/buildDescription.xml`: one C99 file. Its form is FMI 3.0's, in which 2.0 has it too."""
    root = Element("fmiBuildDescription", {"fmiVersion": "3.0"})
    configuration = SubElement(root, "BuildConfiguration", {"modelIdentifier": identifier})
    files = SubElement(configuration, "SourceFileSet", {"language": "C99"})
    SubElement(files, "SourceFile", {"name": MAIN_SOURCE})
    SubElement(files, "PreprocessorDefinition", {
        "name": f"FMI{fmi}_OVERRIDE_FUNCTION_PREFIX",
        "optional": "true",
        "value": "1",
        "description": "for a shared library, whose functions have no prefix",
    })  # fmt: skip
    SubElement(configuration, "Library", {"name": "m", "external": "true", "description": "C's mathematics, on Unix"})
    return xml_bytes(root)
