"""System structures (SSP 1.0): FMUs, their connections and their parameters in one file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from pipeclamp_fmu.describe.model_description import FILE_NAME as MODEL_DESCRIPTION
from pipeclamp_fmu.describe.model_description import identifier
from pipeclamp_fmu.describe.ssv import element, parameter_set, written
from pipeclamp_fmu.python.packing import zipped
from pipeclamp_models.base.archive import read_part
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import plain_stems, write_whole

PARAMETER_SET = "parameters"
"""Name of every component's parameter set: masters that choose sets by name take one name for all components."""

Port = tuple[str, str]
"""An element's name and one of its variables."""


@dataclass(frozen=True)
class Component:
    """An FMU in a system.

    Attributes:
        name: of the element.
        fmu: the file.
        parameters: values that it starts with, by variable.
    """

    name: str
    fmu: Path
    parameters: Mapping[str, float | bool]


@dataclass(frozen=True)
class SystemStructure:
    """A system of FMUs.

    Attributes:
        name: of the system; its identifier where it isn't one, and the name as the description.
        components: its elements.
        connections: from an output to an input; inputs without one are left out.
        stop_time: proposed end, s.
        step: proposed macro step, s; None where none is known.
    """

    name: str
    components: Sequence[Component]
    connections: Sequence[tuple[Port, Port]]
    stop_time: float
    step: float | None = None


def write_ssp(structure: SystemStructure, output: Path) -> None:
    """Write an SSP, whole or not at all.

    Raises:
        UserError: an FMU is not of FMI 2.0, or the file can't be written.
    """
    places = [f"resources/{stem}" for stem in plain_stems([one.name for one in structure.components])]
    files = {"SystemStructure.ssd": _description(structure, places)}
    for component, place in zip(structure.components, places, strict=True):
        files[f"{place}.fmu"] = component.fmu.read_bytes()
        if component.parameters:
            files[f"{place}.ssv"] = parameter_set(PARAMETER_SET, component.parameters)
    write_whole(output, zipped(files))


@dataclass(frozen=True)
class _Port:
    """An input or output of an FMU: name, causality, type, unit ("" where the FMU doesn't define it)."""

    name: str
    causality: str
    kind: str
    unit: str


def _ports(fmu: Path) -> tuple[list[_Port], dict[str, Mapping[str, str]]]:
    """Give the FMU's inputs and outputs, and the units that it defines, each by its base units.

    Raises:
        UserError: the FMU is not of FMI 2.0.
    """
    try:
        root = ElementTree.fromstring(read_part(fmu, MODEL_DESCRIPTION, "an FMU of FMI 2.0"))
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        raise UserError(f"{fmu}: {MODEL_DESCRIPTION} in it is no XML ({error}); expected an FMU of FMI 2.0") from error
    if root.get("fmiVersion") != "2.0":
        raise UserError(
            f"{fmu}: FMI {root.get('fmiVersion')}; expected FMI 2.0, as masters take it in an SSP 1.0: "
            "build it without --fmi 3"
        )
    units: dict[str, Mapping[str, str]] = {
        unit.get("name", ""): dict(base.attrib) for unit in root.iter("Unit") for base in unit.findall("BaseUnit")
    }
    ports = []
    for variable in root.iter("ScalarVariable"):
        causality, unit = variable.get("causality", ""), variable[0].get("unit", "")
        if causality in ("input", "output"):
            known = unit if unit in units else ""
            ports.append(_Port(variable.get("name", ""), causality, variable[0].tag, known))
    return ports, units


def _description(structure: SystemStructure, places: Sequence[str]) -> bytes:
    named = {"name": identifier(structure.name), "description": structure.name}
    root = element(None, "ssd:SystemStructureDescription", {"version": "1.0", **named})
    system = element(root, "ssd:System", {"name": "system"})
    connected = {end for _, end in structure.connections}
    elements = element(system, "ssd:Elements", {})
    units: dict[str, Mapping[str, str]] = {}
    for component, place in zip(structure.components, places, strict=True):
        listed = element(elements, "ssd:Component", {
            "name": component.name,
            "type": "application/x-fmu-sharedlibrary",
            "source": f"{place}.fmu",
            "implementation": "CoSimulation",
        })  # fmt: skip
        connectors = element(listed, "ssd:Connectors", {})
        ports, defined = _ports(component.fmu)
        for port in ports:
            if port.causality == "input" and (component.name, port.name) not in connected:
                continue  # a master would set an unconnected one to zero
            connector = element(connectors, "ssd:Connector", {"name": port.name, "kind": port.causality})
            element(connector, f"ssc:{port.kind}", {"unit": port.unit} if port.unit else {})
            if port.unit:
                units.setdefault(port.unit, defined[port.unit])
        if component.parameters:
            bindings = element(listed, "ssd:ParameterBindings", {})
            element(bindings, "ssd:ParameterBinding", {"source": f"{place}.ssv"})
    connections = element(system, "ssd:Connections", {})
    for (start, output), (end, into) in structure.connections:
        element(connections, "ssd:Connection", {
            "startElement": start, "startConnector": output, "endElement": end, "endConnector": into,
        })  # fmt: skip
    listed_units = element(root, "ssd:Units", {}) if units else root
    for name, base in sorted(units.items()):
        element(element(listed_units, "ssc:Unit", {"name": name}), "ssc:BaseUnit", base)
    times = {"startTime": "0.0", "stopTime": repr(float(structure.stop_time))}
    experiment = element(root, "ssd:DefaultExperiment", times)
    if structure.step is not None:
        # SSP 1.0 has no attribute for a step; libcosim reads this annotation.
        annotations = element(experiment, "ssd:Annotations", {})
        annotation = element(annotations, "ssc:Annotation", {"type": "com.opensimulationplatform"})
        algorithm = element(annotation, "osp:Algorithm", {})
        element(algorithm, "osp:FixedStepAlgorithm", {"baseStepSize": repr(float(structure.step))})
    return written(root)
