"""The page of a comparison on the pipe."""

from __future__ import annotations

from pipeclamp.pages.page import Section
from pipeclamp.pages.system.attribution import attribution_section
from pipeclamp.pages.system.pipe import pipe_comparison_sections
from pipeclamp.pages.system.pipe_records import records_sections
from pipeclamp_identification.attribution.attributed import Attributed


def attributed_sections(found: Attributed) -> list[Section]:
    """Give the page: how much the model errs, what may be wrong, and where."""
    sines, records = found.compared.sines, found.compared.records
    named = found.attribution.named if found.attribution else ()
    corrected = named[0].refit.computed if named else None
    how, *others = [
        *(pipe_comparison_sections(sines, corrected.sines if corrected else None, found.bands) if sines else []),
        *(records_sections(records, corrected.records if corrected else None) if records else []),
    ]
    return [how, attribution_section(found.attribution, found.proposal), *others]
