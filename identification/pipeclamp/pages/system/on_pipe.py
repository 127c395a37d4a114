"""The page of a comparison on the pipe."""

from __future__ import annotations

from dataclasses import replace

from pipeclamp.pages.page import Report, Section
from pipeclamp.pages.system.attribution import attribution_section
from pipeclamp.pages.system.pipe import pipe_comparison_sections
from pipeclamp.pages.system.pipe_records import records_sections
from pipeclamp.show.on_pipe import attribution_words
from pipeclamp_identification.attribution.attributed import Attributed
from pipeclamp_identification.workflow.next_step import NextStep


def attributed_page(found: Attributed, following: NextStep) -> Report:
    """Give the page of a comparison on the pipe."""
    system, measured = found.compared.system, found.compared.description
    title, about = f"{system.name} against {measured.name}", measured.notes or "pipe and clamps"
    return Report(title, about, attributed_sections(found, following))


def attributed_sections(found: Attributed, following: NextStep) -> list[Section]:
    """Give its sections: verdict, what comes next, errors before and after correction, what was tried."""
    sines, records = found.compared.sines, found.compared.records
    named = found.attribution.named if found.attribution else ()
    corrected = named[0].refit.computed if named else None
    how, *others = [
        *(pipe_comparison_sections(sines, corrected.sines if corrected else None, found.bands) if sines else []),
        *(records_sections(records, corrected.records if corrected else None) if records else []),
    ]
    verdict, *why = attribution_words(found.attribution, found.proposal)
    words = [verdict, *why, *how.paragraphs, *following.before()]
    answer = replace(how, title="Answer", paragraphs=words, command=following.line)
    tried = [attribution_section(found.attribution)] if found.attribution else []
    return [answer, *others[:1], *tried, *others[1:]]
