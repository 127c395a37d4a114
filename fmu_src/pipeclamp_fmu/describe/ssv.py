"""Parameter sets as SSV files (SSP 1.0), which hold values by variable."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from pipeclamp_fmu.describe.model_description import xml_bytes

NAMESPACES = {
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    "osp": "http://opensimulationplatform.com/SSP/OSPAnnotations",
}

MEDIA_TYPE = "application/x-ssp-parameter-set"


def element(parent: Element | None, kind: str, attributes: Mapping[str, str]) -> Element:
    """Make an element of a kind such as "ssv:Parameter", within a parent where there is one."""
    prefix, name = kind.split(":")
    tag = f"{{{NAMESPACES[prefix]}}}{name}"
    return Element(tag, dict(attributes)) if parent is None else SubElement(parent, tag, dict(attributes))


def written(root: Element) -> bytes:
    """Give the file, with the usual prefixes."""
    for prefix, address in NAMESPACES.items():
        ElementTree.register_namespace(prefix, address)
    return xml_bytes(root)


def parameter_set(name: str, values: Mapping[str, float | bool], description: str = "") -> bytes:
    """Give a parameter set: its name, the values by variable in the variables' own units, what it is."""
    told = {"description": description} if description else {}
    root = element(None, "ssv:ParameterSet", {"version": "1.0", "name": name, **told})
    parameters = element(root, "ssv:Parameters", {})
    for variable, value in values.items():
        parameter = element(parameters, "ssv:Parameter", {"name": variable})
        if isinstance(value, bool):
            element(parameter, "ssv:Boolean", {"value": str(value).lower()})
        else:
            element(parameter, "ssv:Real", {"value": repr(float(value))})
    return written(root)
