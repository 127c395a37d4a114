"""What of pipe and clamps is wrong: in sentences, as a table, for --json."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pipeclamp_identification.pipe_attribution import FEWEST, Attribution, Candidate
from pipeclamp_identification.pipe_next_test import Proposal
from pipeclamp_identification.report import Section, Table

METHOD = (
    "Each parameter was refitted alone, and all of them together. A parameter is named only if every other one leaves "
    "clearly more on frequencies that it was not fitted to, in units of the sensors' noise. Of records of any motion, "
    "the amplitude and the phase in each band of frequency of each part of time count, not samples. A clamp's "
    "stiffness follows the amplitude as its law does, a support's doesn't: several levels tell them apart."
)
NOT_COVERED = (
    "Not tried: the pipe's bending stiffness, positions, flow and axial force, sensors out of calibration, and laws of "
    "another form (pipeclamp diagnose, on loops of the clamp)."
)


def attribution_words(found: Attribution | None, proposal: Proposal | None) -> list[str]:
    """Say what is wrong; the first sentence is the verdict. None: too little was measured to ask."""
    if found is None:
        return [f"Which parameter may be wrong is asked of {FEWEST} measured values at least."]
    words = [_headline(found)]
    if found.verdict in ("wrong", "ambiguous"):
        words += [f"{_capital(entry.told())}. {_left(entry, found)}" for entry in found.named]
    if found.verdict == "ambiguous":
        kinds = {suspect.kind for suspect in found.suspects}
        if len(kinds) == 1:
            words.append(f"Whichever it is, it is {kinds.pop()}.")
        elif len({suspect.side for suspect in found.suspects}) == 1:
            words.append(f"Whichever it is, it is the {found.suspects[0].side}'s.")
    if found.verdict == "unknown":
        best = found.candidates[0]
        words.append(f"The best refit is {best.told()}. {_left(best, found)}")
    if proposal is not None:
        words.append(proposal.words())
    elif found.verdict == "ambiguous":
        words.append("No other level, frequency or probe was found that would tell them apart.")
    return words


def _headline(found: Attribution) -> str:
    names = [entry.words for entry in found.named]
    match found.verdict:
        case "complete":
            return "complete: no parameter of pipe or clamps is found wrong; what is left is the sensors' noise."
        case "wrong":
            return f"wrong: {names[0]}."
        case "ambiguous":
            return f"ambiguous: one of these is wrong, and this measurement can't tell which: {'; '.join(names)}."
        case "unknown":
            return "unknown: something is wrong that no one or two parameters of pipe and clamps explain."


def _left(entry: Candidate, found: Attribution) -> str:
    return f"With it the error falls from {found.stated.nrmse:.2%} to {entry.nrmse:.2%}."


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def attribution_json(found: Attribution, proposal: Proposal | None) -> dict[str, Any]:
    """Give the answer for --json."""
    return {
        "verdict": found.verdict,
        "parameters": [suspect.id for suspect in found.suspects],
        "alternatives": [[suspect.id for suspect in entry.suspects] for entry in found.named],
        "sides": sorted({suspect.side for suspect in found.suspects}),
        "left_in_noise": found.left,
        "nrmse": {"stated": found.stated.nrmse, "all_refitted": found.together.nrmse},
        "candidates": [
            {
                "parameters": [suspect.id for suspect in entry.suspects],
                "sides": sorted({suspect.side for suspect in entry.suspects}),
                "values": entry.told(),
                "nrmse": entry.nrmse,
                "heldout": entry.heldout / entry.refit.residual.size,
            }
            for entry in found.candidates
        ],
        "next_test": proposal.words() if proposal else None,
    }


def candidate_table(found: Attribution, most: int | None = None) -> Table:
    """Give what was tried as a table, best first."""
    size = found.stated.refit.residual.size
    rows: Sequence[tuple[str | float | None, ...]] = [
        (
            entry.words,
            " and ".join(sorted({suspect.side for suspect in entry.suspects})),
            entry.told().partition(": ")[2] if len(entry.suspects) == 1 else entry.told(),
            100 * entry.nrmse,
            (entry.heldout / size) ** 0.5,
        )
        for entry in found.candidates[:most]
    ]
    stated = ("nothing: the model as stated", "", "", 100 * found.stated.nrmse, (found.stated.heldout / size) ** 0.5)
    header = ("refitted", "of", "value", "error / %", "left on what was left out, in units of the noise")
    return Table(header, [*rows, stated], "what may be wrong, best first")


def attribution_section(found: Attribution | None, proposal: Proposal | None) -> Section:
    """Give the report's section."""
    words = [*attribution_words(found, proposal), METHOD, NOT_COVERED]
    return Section("What is wrong", words, [candidate_table(found)] if found else [])
