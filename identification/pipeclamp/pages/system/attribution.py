"""What of pipe, clamps and measurement was tried as wrong, and how."""

from __future__ import annotations

from pipeclamp.pages.page import Section
from pipeclamp.show.on_pipe import candidate_table
from pipeclamp_identification.attribution.verdict import Attribution

METHOD = (
    "Each parameter was refitted alone, and all of them together. That something is wrong is told by what the best one "
    "leaves on frequencies that it was not fitted to, in units of the sensors' noise; a parameter is named only if its "
    "likelihood rules every other one out. Of records of any motion, the amplitude and the phase in each band of "
    "frequency of each part of time count, not samples. A clamp's stiffness follows the amplitude as its law does, a "
    "support's doesn't: several levels tell them apart."
)
NOT_COVERED = (
    "Not tried: the supports' positions, flow and axial force, and laws of another form "
    "(pipeclamp diagnose, on loops of the clamp)."
)


def attribution_section(found: Attribution) -> Section:
    """Give the report's section on what was tried."""
    return Section("What was tried", [METHOD, NOT_COVERED], [candidate_table(found)])
