"""The page of a discovery: the term, its loops before and after with the difference, what was asked of it."""

from __future__ import annotations

from collections.abc import Sequence

from pipeclamp.pages.page import Card, Section
from pipeclamp.pages.sections import laws_sections
from pipeclamp.pages.sketch import sketch
from pipeclamp.pages.waterfall import rungs_of, waterfall_picture
from pipeclamp.show.discovery import discovery_words, guards_table, rivals_table
from pipeclamp_identification.discovery.proposal import TermProposal
from pipeclamp_identification.workflow.tests import Held
from pipeclamp_models.law.declared import effect_of
from pipeclamp_models.law.file import LawFile


def discovery_title(file: LawFile, tests: str) -> tuple[str, str]:
    """Give title and subtitle of the page of a discovery of what a law lacks, on the tests of that name."""
    return f"Discovery on {tests}", f"what law {file.name} lacks"


def discovery_page(proposal: TermProposal, laws: Sequence[tuple[LawFile, Held]], next_command: str) -> list[Section]:
    """Give the page of a discovery.

    Args:
        proposal: what the search came to.
        laws: the law, and the one with the term where there is one, against the tests.
        next_command: the shell line to run next.
    """
    file = laws[-1][0]
    words = discovery_words(proposal)
    falling = waterfall_picture(rungs_of(file), proposal.noise_nrmse, "The error, effect by effect")
    answer = Section("Answer", words, figures=[falling] if len(file.history) > 1 else [], command=next_command)
    cards = []
    if proposal.declaration is not None:
        effect = effect_of(proposal.declaration)
        cards.append(Card(proposal.declaration.id, words[:2], sketch(effect.name, effect, [proposal.declaration])))
    tables = [guards_table(proposal)] if proposal.guards else []
    if proposal.found and proposal.found.rivals:
        tables.append(rivals_table(proposal))
    evidence = [Section("Evidence", (), tables, cards=cards)] if tables or cards else []
    difference, *details = laws_sections(laws, about=len(laws) - 1)
    return [answer, difference, *evidence, *details]
