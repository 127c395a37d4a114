"""Reference results that travel inside an FMU, and what else its manifest names, as FMI-LS-REF describes them.

Experiments are in the form of MA-HS-Experiments, to which that layered standard points since 1.0.0-beta.1. Results are
what a co-simulation gives that sets a row of stimuli at its time, then steps to the next row's time.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from pipeclamp_fmu.describe.model_description import xml_bytes

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
MANIFEST = "http://fmi-standard.org/fmi-ls-manifest"
VERSION = "1.0.0-beta.1"
EXPERIMENTS = "application/x-ma-hs-experiments"
TEXT = "Layered Standard providing information on related files included in an FMU."


@dataclass(frozen=True)
class Related:
    """A file of the manifest: its name, its media type, FMI-LS-REF's role for it, what it is, its content."""

    name: str
    kind: str
    role: str
    meaning: str
    content: bytes


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


def reference_files(reference: Reference, model_exchange: bool, further: Sequence[Related] = ()) -> dict[str, bytes]:
    """Give the files by name: the manifest, an experiment, its stimuli and its results, and what is told besides.

    Args:
        reference: what they say.
        model_exchange: whether the FMU has that interface too; where its results stand at other times it has an
            experiment and results of its own.
        further: files beside them.
    """
    count = len(next(iter(reference.stimuli.values())))
    times = [index * reference.step for index in range(count + 1)]
    stimuli, results = "inputs, to be set before the step that begins at their time", "outputs after that step"
    files = [
        _experiments("experiments.exp", reference, reference.description, times[-1], "results.csv"),
        Related("stimuli.csv", "text/csv", "testcase", stimuli, _table(times[:-1], reference.stimuli)),
        Related("results.csv", "text/csv", "result", results, _table(times[1:], reference.results)),
    ]
    if model_exchange and reference.at_once:
        what, own = f"{reference.description}, in model exchange", "results_model_exchange.csv"
        at_once = _table(times[:-1], reference.results)
        files += [
            _experiments("experiments_model_exchange.exp", reference, what, times[-2], own),
            Related(own, "text/csv", "result", "outputs at the time of the stimuli", at_once),
        ]
    files += further
    contents = {entry.name: entry.content for entry in files} | {"fmi-ls-manifest.xml": _manifest(files)}
    return {f"{FOLDER}/{name}": content for name, content in contents.items()}


def _experiments(name: str, reference: Reference, description: str, stop: float, results: str) -> Related:
    root = Element("Experiments", {"name": reference.name, "description": description})
    experiment = SubElement(
        root, "Experiment", {"name": reference.name, "description": description, "tolerance": "1e-6"}
    )
    SubElement(
        experiment,
        "TransientSimulation",
        {"startTime": "0.0", "stopTime": repr(stop), "stepSize": repr(reference.step)},
    )
    SubElement(experiment, "Stimuli", {"source": "stimuli.csv"})
    SubElement(experiment, "References", {"source": results})
    return Related(name, EXPERIMENTS, "experiment/smoke-test", description, xml_bytes(root))


def _manifest(files: Sequence[Related]) -> bytes:
    ElementTree.register_namespace("fmi-ls", MANIFEST)
    root = Element(
        "fmiReferences",
        {
            f"{{{MANIFEST}}}fmi-ls-name": "org.fmi-standard.fmi-ls-ref",
            f"{{{MANIFEST}}}fmi-ls-version": VERSION,
            f"{{{MANIFEST}}}fmi-ls-description": TEXT,
        },
    )
    for entry in files:
        SubElement(root, "Related", {
            "type": entry.kind,
            "source": entry.name,
            "role": entry.role,
            "description": entry.meaning,
            "checksum": hashlib.sha3_256(entry.content).hexdigest(),
        })  # fmt: skip
    return xml_bytes(root)


def _table(times: Sequence[float], columns: Mapping[str, Sequence[float]]) -> bytes:
    rows = [",".join(("time", *columns))]
    rows += [",".join(map(repr, row)) for row in zip(times, *columns.values(), strict=True)]
    return ("\n".join(rows) + "\n").encode("utf-8")
