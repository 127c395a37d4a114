"""A discovery told: the proposed term, what was asked of it, and what to run next; or why nothing is proposed."""

from __future__ import annotations

from pipeclamp.show.table import Table
from pipeclamp.show.view import View
from pipeclamp_identification.diagnosis.named import NO_PROOF, joined_by_and
from pipeclamp_identification.diagnosis.thresholds import MATERIAL_NOISE_SHARE
from pipeclamp_identification.discovery.hearing import TermFound
from pipeclamp_identification.discovery.proposal import NumberAnswer, TermProposal, formula_of
from pipeclamp_identification.discovery.shapes import SIGN_V, SIGN_Y, SIZE_V, SIZE_Y, STILL, STILL_SQUARED
from pipeclamp_identification.discovery.telling import BEYOND_A, BEYOND_F
from pipeclamp_models.base.digits import error_goes, one_digit
from pipeclamp_models.base.units import unit_shown

RIVALS_SHOWN = 5
READ_AS = {
    SIGN_Y: "sign(y)", SIGN_V: "sign(v)", SIZE_Y: "|y|", SIZE_V: "|v|", f" + {STILL}": "", f" + {STILL_SQUARED}": "",
}  # fmt: skip
"""What people read for what is smooth about zero, or never zero; a declaration has it whole."""
WHERE_AS_WELL = "on these conditions or in a tenth of draws of them"


def formula_read(formula: str) -> str:
    """Give a formula as people read it."""
    for written, read in READ_AS.items():
        formula = formula.replace(written, read)
    return formula


def numbers_words(proposal: TermProposal) -> str:
    """Give the best term's fitted numbers, each with what it is, how sure and its unit."""
    return f"Its numbers: {', '.join(map(_number_words, proposal.numbers()))}."


def _number_words(number: NumberAnswer) -> str:
    error = "" if number.standard_error is None else f" ± {one_digit(number.standard_error)}"
    where = " (at its bound)" if number.at_bound else ""
    unit = "" if number.unit == "-" else f" {unit_shown(number.unit)}"
    return f"{number.meaning} {number.value:.3g}{error}{unit}{where}"


def discovery_words(proposal: TermProposal) -> list[str]:
    """Say what came out, most important first."""
    found = proposal.found
    kinds = "springs, dampers, elements that slip or creep, factors on the law's coefficients"
    tried = f"{proposal.search.tried} terms were tried: {kinds}."
    if proposal.instead:
        return [*_instead_words(proposal), tried]
    if proposal.declaration is None or found is None or proposal.heldout is None:
        words = [f"Nothing is proposed: {proposal.reason}."]
        if found:
            words.append(numbers_words(proposal))
        if proposal.search.tried:
            words.append(tried)
        if rest := proposal.left_over():
            words.append(f"Where the rest lies: {'; '.join(rest)}.")
        return words
    words = [
        f"Acts like {found.term.acts_like}.",
        numbers_words(proposal),
        _error_words(proposal),
        *_powers_back_words(proposal),
        *(f"The law does as well without {name}, now that it has the term: it went." for name in proposal.spare),
        f"As a formula: {formula_read(formula_of(proposal.declaration))}.",
        "These tests support it; it is no proof of a physical cause.",
    ]
    if found.caution:
        words.append(f"Mind: {found.caution}.")
    if found.rivals:
        rivals = "; ".join(rival.acts_like for rival in found.rivals[:RIVALS_SHOWN])
        words.append(f"Other forms do as well, {WHERE_AS_WELL}: {rivals}. {_what_tells(found)}.")
    return [*words, tried]


def _instead_words(proposal: TermProposal) -> list[str]:
    """Say that an effect of the catalogue takes the place of a term, and why no term is proposed."""
    name = proposal.instead
    return [
        f"{name} of the catalogue takes a part of what is missing, and passes what a term is asked.",
        _error_words(proposal),
        *_powers_back_words(proposal),
        *(f"With it the law does as well without {one}." for one in proposal.spare),
        f"{NO_PROOF[0].upper()}{NO_PROOF[1:]}.",
        f"No term is proposed: {proposal.reason}.",
    ]


def _powers_back_words(proposal: TermProposal) -> list[str]:
    """Say which powers of the amplitude were fitted again, and what they alone do; nothing where none were."""
    back = proposal.powers_back
    if back is None:
        return []
    names = joined_by_and(back.names)
    return [
        f"{names}, without which the law was, are fitted again first, for a term might stand for them: that alone "
        f"makes {error_goes(*back.heldout)}."
    ]


def _error_words(proposal: TermProposal) -> str:
    """Say what the error on left-out conditions does."""
    assert proposal.heldout is not None  # something is proposed
    scatter = f"; {proposal.noise_nrmse:.2%} is scatter" if proposal.noise_nrmse is not None else ""
    return f"RMS error on left-out conditions {error_goes(*proposal.heldout)} of RMS force{scatter}."


def _what_tells(found: TermFound) -> str:
    if found.next_test:
        return f"What tells: {found.next_test}"
    return (
        f"No sine up to {BEYOND_A:g} times the largest amplitude and {BEYOND_F:g} times the highest frequency tells "
        f"the term from the first of these: they differ by less than {MATERIAL_NOISE_SHARE:g} times the scatter"
    )


def guards_table(proposal: TermProposal) -> Table:
    """Give what was asked of the best term, or of the effect in its place."""
    rows = [(one.name, "yes" if one.passed else "no", one.words) for one in proposal.guards]
    return Table(("asked", "passed", "with which figures"), rows, "what is asked before anything is proposed")


def rivals_table(proposal: TermProposal) -> Table:
    """Give the terms that do as well."""
    rivals = proposal.found.rivals if proposal.found else ()
    rows = [(one.acts_like, formula_read(formula_of(one.declaration))) for one in rivals]
    return Table(("acts like", "formula"), rows, f"terms that do as well, {WHERE_AS_WELL}")


def discovery_view(proposal: TermProposal, next_command: str) -> View:
    """Tell a discovery, and the command to run next."""
    tables = [guards_table(proposal)] if proposal.guards else []
    return View(proposal.answer(), tables, [*discovery_words(proposal), f"Next: {next_command}"])
