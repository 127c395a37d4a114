"""What of pipe, clamps and measurement is wrong: in sentences, as a table, for --json."""

from __future__ import annotations

from pipeclamp.pages.page import Section
from pipeclamp.show.on_pipe import attribution_words, candidate_table
from pipeclamp_identification.attribution.next_test import Proposal
from pipeclamp_identification.attribution.verdict import Attribution

METHOD = (
    "Each parameter was refitted alone, and all of them together. A parameter is named only if every other one leaves "
    "clearly more on frequencies that it was not fitted to, in units of the sensors' noise. Of records of any motion, "
    "the amplitude and the phase in each band of frequency of each part of time count, not samples. A clamp's "
    "stiffness follows the amplitude as its law does, a support's doesn't: several levels tell them apart."
)
NOT_COVERED = (
    "Not tried: the excitation's and the supports' positions, flow and axial force, and laws of another form "
    "(pipeclamp diagnose, on loops of the clamp)."
)


def attribution_section(found: Attribution | None, proposal: Proposal | None) -> Section:
    """Give the report's section."""
    words = attribution_words(found, proposal)
    if found is None:
        return Section("What is wrong", words)
    return Section("What is wrong", [*words, METHOD, NOT_COVERED], [candidate_table(found)])
