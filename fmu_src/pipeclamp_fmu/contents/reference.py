"""Reference results that travel inside a clamp's FMU, as the layered standard FMI-LS-REF describes them."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from pipeclamp_fmu.contents.steady_loop import Loop
from pipeclamp_fmu.describe.model_description import xml_bytes

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
MANIFEST = "http://fmi-standard.org/fmi-ls-manifest"
TEXT = "Layered Standard providing information on related files included in an FMU."


def reference_files(loop: Loop) -> dict[str, bytes]:
    """Give the files by name: the manifest, an experiment, its stimuli and its results.

    Co-simulation steps end at the rows' times, and a row's stimuli are set before the step that ends there.
    """
    times = [index * loop.step for index in range(1, len(loop.s) + 1)]
    stimuli = _table(("time", "flange.s", "flange.v"), (times, loop.s, loop.v))
    results = _table(("time", "flange.f", "energyDissipated"), (times, loop.force, loop.dissipated))
    stop = repr(times[-1])
    experiments = Element("Experiments", {"name": "reference"})
    experiment = SubElement(
        experiments,
        "Experiment",
        {
            "name": "loop",
            "description": "two cycles from rest, middle of the range; stimuli are those at each step's end",
            "startTime": "0.0",
            "stopTime": stop,
            "stepSize": repr(loop.step),
            "tolerance": "1e-9",
        },
    )
    SubElement(experiment, "Stimuli", {"source": "stimuli.csv"})
    SubElement(experiment, "References", {"source": "results.csv"})
    return {
        f"{FOLDER}/fmi-ls-manifest.xml": _manifest(),
        f"{FOLDER}/experiments.xml": xml_bytes(experiments),
        f"{FOLDER}/stimuli.csv": stimuli,
        f"{FOLDER}/results.csv": results,
    }


def _manifest() -> bytes:
    ElementTree.register_namespace("fmi-ls", MANIFEST)
    root = Element(
        "fmiReferences",
        {
            f"{{{MANIFEST}}}fmi-ls-name": "org.fmi-standard.fmi-ls-ref",
            f"{{{MANIFEST}}}fmi-ls-version": "1.0.0-alpha.1",
            f"{{{MANIFEST}}}fmi-ls-description": TEXT,
        },
    )
    for source, kind, role, meaning in (
        ("experiments.xml", "application/xml", "experiment/smoke-test", "a loop in the middle of the law's range"),
        ("stimuli.csv", "text/csv", "testcase", "its motion, under the default conditions"),
        ("results.csv", "text/csv", "result", "force and dissipated energy, of the Python FMU"),
    ):
        SubElement(root, "Related", {"type": kind, "source": source, "role": role, "description": meaning})
    return xml_bytes(root)


def _table(names: Sequence[str], columns: Sequence[Sequence[float]]) -> bytes:
    rows = [",".join(names), *(",".join(map(repr, row)) for row in zip(*columns, strict=True))]
    return ("\n".join(rows) + "\n").encode("utf-8")
