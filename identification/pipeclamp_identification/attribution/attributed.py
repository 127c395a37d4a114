"""A coupled model held against what was measured on the pipe, with what of it may be wrong."""

from __future__ import annotations

from dataclasses import dataclass

from pipeclamp_identification.attribution.compared import Compared
from pipeclamp_identification.attribution.next_test import propose
from pipeclamp_identification.attribution.repeats import NextMeasurement, repeats
from pipeclamp_identification.attribution.verdict import Attribution, attribute
from pipeclamp_identification.on_pipe.bands import PipeBands
from pipeclamp_models.base.progress import Progress


@dataclass(frozen=True)
class Attributed:
    """A comparison on the pipe, and what may be wrong.

    Attributes:
        compared: the model against sines, records of any motion, or both.
        attribution: the verdict and its evidence; None where too little was measured to ask.
        proposal: the measurement that would tell rivals apart.
        bands: how sure the model is at the sines, where that was asked.
    """

    compared: Compared
    attribution: Attribution | None
    proposal: NextMeasurement | None
    bands: PipeBands | None = None


def attributed(compared: Compared, progress: Progress) -> Attributed:
    """Say which parameter of a coupled model may be wrong, or which measurement would tell."""
    found = attribute(compared, progress)
    if found is None or found.verdict != "ambiguous":
        return Attributed(compared, found, None)
    progress("look for a test that would tell")
    return Attributed(compared, found, propose(found, compared) or repeats(found))
