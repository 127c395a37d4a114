"""A comparison on the pipe told: how much the model errs, where, and what of it or of the measurement is wrong."""

from __future__ import annotations

from collections.abc import Sequence

from pipeclamp.show.comparison import parts_table
from pipeclamp.show.table import Table
from pipeclamp.show.view import View
from pipeclamp_identification.attribution.answer import system_comparison_answer
from pipeclamp_identification.attribution.attributed import Attributed
from pipeclamp_identification.attribution.repeats import NextMeasurement
from pipeclamp_identification.attribution.verdict import FEWEST_VALUES, PLAUSIBLE_NOISE_NRMSE, Attribution, Candidate
from pipeclamp_identification.comparison.sentences import sentence
from pipeclamp_identification.diagnosis.named import NO_PROOF
from pipeclamp_identification.on_pipe.records import records_words
from pipeclamp_identification.on_pipe.where import how_much, where_words
from pipeclamp_identification.workflow.next_step import NextStep
from pipeclamp_models.base.said import counted

CANDIDATES_PRINTED = 8


def attribution_words(found: Attribution | None, proposal: NextMeasurement | None) -> list[str]:
    """Say what is wrong; the first sentence is the verdict. None: too little was measured to ask."""
    if found is None:
        return [f"To ask which parameter may be wrong takes at least {FEWEST_VALUES} measured values."]
    words = [_headline(found)]
    if found.verdict in ("wrong", "ambiguous"):
        words += [f"{sentence(entry.value_words())} {_left(entry, found)}" for entry in found.named]
    if found.kind == "part":
        words.append(sentence(NO_PROOF))
    if found.verdict == "ambiguous":
        kinds = {suspect.kind for suspect in found.suspects}
        if len(kinds) == 1:
            words.append(f"Whichever it is, it is {kinds.pop()}.")
        elif len({suspect.side for suspect in found.suspects}) == 1:
            words.append(f"Whichever it is, it is the {found.suspects[0].side}'s.")
        shared = [one for one in found.suspects if all(one in entry.suspects for entry in found.named)]
        if shared:
            words.append(f"All of them hold {' and '.join(one.words for one in shared)}.")
    if found.branch_unknown:
        words.append(
            "It errs only where the model has several stable motions, and which of them was measured isn't said: sweep "
            "through these frequencies, and state sweep = 'up' or 'down' in measurement.toml."
        )
    elif found.verdict == "unknown":
        best = found.candidates[0]
        words.append(f"The best refit is {best.value_words()}. {_left(best, found)}")
    if found.unseen:
        words.append(
            f"Whether {counted(found.unseen, 'suspect')} of the worst would do better on another of the model's stable "
            "motions wasn't asked: following their responses takes more work than is allowed."
        )
    if found.noise_unknown:
        words.append(
            f"The error that is left is more than {PLAUSIBLE_NOISE_NRMSE:.0%}, by which tests on pipes scatter at "
            "most, as a rule. Only repeated sines tell whether it is noise, and none was repeated."
        )
    if proposal is not None:
        words.append(proposal.words())
    elif found.verdict == "ambiguous":
        words.append("No other level, frequency or probe, nor many repeats, would tell them apart.")
    return words


def _headline(found: Attribution) -> str:
    names = [entry.words for entry in found.named]
    match found.verdict:
        case "wrong" if found.kind == "part":
            return f"Part of what is wrong: {names[0]}."
        case "ambiguous" if found.kind == "part":
            which = "; ".join(names)
            return f"Ambiguous: one of these is part of what is wrong, and this measurement can't tell which: {which}."
        case "complete":
            return "Complete: nothing is found wrong with pipe, clamps or measurement; what is left is noise."
        case "wrong":
            return f"Wrong: {names[0]}."
        case "ambiguous":
            return f"Ambiguous: one of these is wrong, and this measurement can't tell which: {'; '.join(names)}."
        case "unknown" if found.branch_unknown:
            return "Unknown: no parameter errs where it is known which of the model's motions was measured."
        case "unknown" if found.noise_unknown:
            return "Unknown: no parameter takes clearly more than chance does, and what is left may be noise or not."
        case "unknown":
            return "Unknown: something is wrong that no one or two parameters of pipe, clamps and measurement explain."


def _left(entry: Candidate, found: Attribution) -> str:
    return f"With it the error falls from {found.stated.nrmse:.2%} to {entry.nrmse:.2%}."


def candidate_table(found: Attribution, most: int | None = None) -> Table:
    """Give what was tried as a table, best first."""
    size = found.stated.refit.residual.size
    rows: Sequence[tuple[str | float | None, ...]] = [
        (
            entry.words,
            " and ".join(sorted({suspect.side for suspect in entry.suspects})),
            entry.value_words().partition(": ")[2] if len(entry.suspects) == 1 else entry.value_words(),
            100 * entry.nrmse,
            (entry.heldout / size) ** 0.5,
        )
        for entry in found.candidates[:most]
    ]
    stated = ("nothing: the model as stated", "", "", 100 * found.stated.nrmse, (found.stated.heldout / size) ** 0.5)
    header = ("refitted", "of", "value", "error / %", "left / noise")
    caption = "what may be wrong, best first; left: on frequencies that were left out of the fit, in units of the noise"
    return Table(header, [*rows, stated], caption)


def attributed_view(found: Attributed, following: NextStep) -> View:
    """Tell how a coupled model stands against what was measured, what may be wrong, and what comes next."""
    sines, records, attribution = found.compared.sines, found.compared.records, found.attribution
    tables: list[Table] = []
    lines: list[str] = []
    if sines:
        tables.append(parts_table(sines.by_probe()))
        lines += [*how_much(sines), *where_words(sines), *(found.bands.words() if found.bands else ())]
    if records:
        tables += [parts_table(parts) for parts in records.breakdowns()]
        lines += records_words(records)
    if attribution:
        tables.append(candidate_table(attribution, most=CANDIDATES_PRINTED))
    lines += [*attribution_words(attribution, found.proposal), following.words()]
    return View(system_comparison_answer(found), tables, lines)
