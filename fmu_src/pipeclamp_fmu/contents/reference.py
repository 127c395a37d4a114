"""Reference results that travel inside an FMU, as the layered standard FMI-LS-REF describes them.

They are what a co-simulation gives that sets a row of stimuli at its time, then steps to the next row's time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from pipeclamp_fmu.describe.model_description import xml_bytes

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
MANIFEST = "http://fmi-standard.org/fmi-ls-manifest"
TEXT = "Layered Standard providing information on related files included in an FMU."


@dataclass(frozen=True)
class Reference:
    """Stimuli at equal steps from time 0, and what they make of the FMU.

    Attributes:
        name: of the experiment.
        description: what is done.
        step: s.
        stimuli: by input, each (n,), at time 0 and after each step but the last.
        results: by output, each (n,), at the end of each step.
        at_once: whether in model exchange the results stand at the times of their stimuli, a step earlier.
    """

    name: str
    description: str
    step: float
    stimuli: Mapping[str, Sequence[float]]
    results: Mapping[str, Sequence[float]]
    at_once: bool


def reference_files(reference: Reference, model_exchange: bool) -> dict[str, bytes]:
    """Give the files by name: the manifest, an experiment, its stimuli and its results.

    Args:
        reference: what they say.
        model_exchange: whether the FMU has that interface too; where its results stand at other times it has an
            experiment and results of its own.
    """
    count = len(next(iter(reference.stimuli.values())))
    times = [index * reference.step for index in range(count + 1)]
    files = {
        "experiments.xml": _experiments(reference, times[-1], "results.csv"),
        "stimuli.csv": _table(times[:-1], reference.stimuli),
        "results.csv": _table(times[1:], reference.results),
    }
    related = [
        ("experiments.xml", "application/xml", "experiment/smoke-test", reference.description),
        ("stimuli.csv", "text/csv", "testcase", "inputs, to be set before the step that begins at their time"),
        ("results.csv", "text/csv", "result", "outputs after that step"),
    ]
    if model_exchange and reference.at_once:
        files["experiments_model_exchange.xml"] = _experiments(reference, times[-2], "results_model_exchange.csv")
        files["results_model_exchange.csv"] = _table(times[:-1], reference.results)
        what = f"{reference.description}, in model exchange"
        related += [
            ("experiments_model_exchange.xml", "application/xml", "experiment/smoke-test", what),
            ("results_model_exchange.csv", "text/csv", "result", "outputs at the time of the stimuli"),
        ]
    files["fmi-ls-manifest.xml"] = _manifest(related)
    return {f"{FOLDER}/{name}": content for name, content in files.items()}


def _experiments(reference: Reference, stop: float, results: str) -> bytes:
    root = Element("Experiments")
    experiment = SubElement(
        root,
        "Experiment",
        {
            "name": reference.name,
            "description": reference.description,
            "startTime": "0.0",
            "stopTime": repr(stop),
            "stepSize": repr(reference.step),
            "tolerance": "1e-6",
        },
    )
    SubElement(experiment, "Stimuli", {"source": "stimuli.csv"})
    SubElement(experiment, "References", {"source": results})
    return xml_bytes(root)


def _manifest(related: Sequence[tuple[str, str, str, str]]) -> bytes:
    ElementTree.register_namespace("fmi-ls", MANIFEST)
    root = Element(
        "fmiReferences",
        {
            f"{{{MANIFEST}}}fmi-ls-name": "org.fmi-standard.fmi-ls-ref",
            f"{{{MANIFEST}}}fmi-ls-version": "1.0.0-alpha.1",
            f"{{{MANIFEST}}}fmi-ls-description": TEXT,
        },
    )
    for source, kind, role, meaning in related:
        SubElement(root, "Related", {"type": kind, "source": source, "role": role, "description": meaning})
    return xml_bytes(root)


def _table(times: Sequence[float], columns: Mapping[str, Sequence[float]]) -> bytes:
    rows = [",".join(("time", *columns))]
    rows += [",".join(map(repr, row)) for row in zip(times, *columns.values(), strict=True)]
    return ("\n".join(rows) + "\n").encode("utf-8")
