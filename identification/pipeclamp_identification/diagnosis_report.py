"""The answer of a diagnosis: as JSON (CONTRACT.md), and as a report with the evidence in a test engineer's words."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeclamp.declaration import Declaration
from pipeclamp.parameter_file import LawFile, structure_of
from pipeclamp_identification.campaign import Campaign
from pipeclamp_identification.compare import Comparison, compare
from pipeclamp_identification.comparison_report import comparison_sections
from pipeclamp_identification.diagnose import Diagnosis, diagnose
from pipeclamp_identification.fit import Progress
from pipeclamp_identification.leftover import Leftover, describe
from pipeclamp_identification.misfit import RunMisfit, misfits, overall_nrmse
from pipeclamp_identification.next_test import Limits, Proposal, next_test
from pipeclamp_identification.pictures import LoopPanel, curves_picture, loops_picture, waterfall_picture
from pipeclamp_identification.problem import Judged
from pipeclamp_identification.report import Section, Table
from pipeclamp_identification.screen import effect_id

WORSE = 1.02
"""An error on left-out conditions that rises by less is the same."""

HEADLINES = {
    "complete": "Complete: what is left is scatter.",
    "missing": "Missing: {}.",
    "ambiguous": "One of these is missing, and this data can't tell which: {}.",
    "unknown": "Something is missing, and nothing in the catalogue explains it.",
}


@dataclass(frozen=True)
class Answer:
    """A diagnosis with what belongs to it.

    Attributes:
        diagnosis: the verdict and its evidence.
        comparison: the law as it is in its file, held against the tests.
        best: error on every run of the best law found.
        leftover: what the best law leaves over.
        proposal: the test to run next, where rivals are left.
    """

    diagnosis: Diagnosis
    comparison: Comparison
    best: tuple[RunMisfit, ...]
    leftover: Leftover
    proposal: Proposal | None

    @property
    def verdict(self) -> str:
        """The verdict; what is locked to time, or to several cycles, is no scatter: a law with it isn't complete."""
        if self.diagnosis.verdict == "complete" and self.leftover.not_periodic:
            return "unknown"
        return self.diagnosis.verdict

    def left_over(self) -> tuple[str, ...]:
        """Say what the best law leaves over, beyond scatter."""
        if self.verdict == "complete":
            return ()
        best = self.diagnosis.best
        if self.diagnosis.is_adequate(best):
            return self.leftover.lines
        law = f"with {' and '.join(best.effects)}" if best.effects else "as it is"
        left = f"the law {law} leaves {best.lack.share:.0%} of the force noise that follows the conditions"
        return (left, *self.leftover.words, *self.leftover.lines)

    def headline(self) -> str:
        """Give the verdict in words."""
        return HEADLINES[self.verdict].format(" or ".join(self.diagnosis.effects))


def answer_for(
    file: LawFile,
    campaign: Campaign,
    *,
    declared: Iterable[Declaration] = (),
    limits: Limits | None = None,
    jobs: int = 1,
    progress: Progress | None = None,
) -> Answer:
    """Diagnose the law of a parameter file on a campaign, in so many processes; declared effects are candidates too.

    Raises:
        UserError: the data can't serve the law.
    """
    comparison = compare(file, campaign)
    structure = structure_of(file).with_declared(declared)
    diagnosis = diagnose(structure, comparison.loops, jobs=jobs, progress=progress)
    if progress:
        progress("what is left over")
    best = misfits(diagnosis.best.result.law, campaign, comparison.loops)
    leftover = describe(diagnosis.best, diagnosis.problem, campaign, best)
    return Answer(diagnosis, comparison, best, leftover, next_test(diagnosis, limits))


def answer_json(answer: Answer) -> dict[str, Any]:
    """Give the answer of `diagnose --json` (CONTRACT.md)."""
    diagnosis, proposal = answer.diagnosis, answer.proposal
    return {
        "verdict": answer.verdict,
        "effects": list(diagnosis.effects),
        "candidates": [_candidate_json(candidate, diagnosis) for candidate in diagnosis.candidates],
        "pair": _candidate_json(diagnosis.pair, diagnosis) if diagnosis.pair else None,
        "screened_out": dict(diagnosis.screened_out),
        "nrmse": {
            "law": answer.comparison.nrmse,
            "best": overall_nrmse(answer.best),
            "noise": answer.comparison.noise_nrmse,
        },
        "heldout_nrmse": {"law": diagnosis.law.heldout_nrmse, "best": diagnosis.best.heldout_nrmse},
        "lack_of_fit": {
            "law": diagnosis.law.lack.share,
            "best": diagnosis.best.lack.share,
            "p_value": diagnosis.law.lack.p_value,
            "limit": diagnosis.tolerance.complete,
        },
        "scatter": {
            "stiffness": diagnosis.problem.noise.stiffness_scatter,
            "damping": diagnosis.problem.noise.damping_scatter,
        },
        "next_test": None
        if proposal is None
        else {
            "amplitude_mm": proposal.amplitude_mm,
            "frequency_Hz": proposal.frequency_Hz,
            "temperature_C": proposal.temperature_C,
            "further_conditions": dict(proposal.further),
            "profile": proposal.profile,
            "separation": proposal.separation,
            "between": list(proposal.rivals),
            "words": proposal.words(),
        },
        "left_over": list(answer.left_over()),
        "reasons": list(diagnosis.reasons),
        "left_out": [{"run": entry.run, "reason": entry.reason} for entry in answer.comparison.campaign.left_out],
    }


def _candidate_json(candidate: Judged, diagnosis: Diagnosis) -> dict[str, Any]:
    return {
        "effect": " + ".join(candidate.effects),
        "heldout_nrmse": candidate.heldout_nrmse,
        "heldout_by": dict(candidate.heldout_by),
        "lack_of_fit": candidate.lack.share,
        "explained": explained(candidate, diagnosis),
        "objections": list(candidate.objections),
        "parameters": {
            parameter.name: candidate.result.law.values[parameter.name]
            for effect in candidate.result.equations.effects
            if effect.name in candidate.effects
            for parameter in effect.parameters
        },
    }


def explained(candidate: Judged, diagnosis: Diagnosis) -> float:
    """Give the share of the lack of fit's energy that a candidate explains."""
    whole = diagnosis.law.lack.excess
    return float(np.clip(1.0 - max(candidate.lack.excess, 0.0) / whole, 0.0, 1.0)) if whole > 0 else 0.0


def _against(candidate: Judged, law: Judged) -> list[str]:
    """Say what speaks against a candidate: its parameters, and left-out conditions that it foretells worse."""
    errors = {"A, f": (law.heldout_nrmse, candidate.heldout_nrmse)}
    errors |= {name: (error, candidate.heldout_by[name]) for name, error in law.heldout_by.items()}
    worse = (
        f"on left-out {name} the error rises from {before:.2%} to {after:.2%}"
        for name, (before, after) in errors.items()
        if after > WORSE * before
    )
    return [*candidate.objections, *worse]


def candidate_table(diagnosis: Diagnosis) -> Table:
    """Give the candidates, best first."""
    judged = [*diagnosis.candidates, *([diagnosis.pair] if diagnosis.pair else [])]
    law = diagnosis.law
    rows: list[tuple[str | float, ...]] = [
        (
            " + ".join(candidate.effects),
            100 * candidate.heldout_nrmse,
            *(100 * error for error in candidate.heldout_by.values()),
            100 * explained(candidate, diagnosis),
            "; ".join(_against(candidate, law)) or "–",
        )
        for candidate in sorted(judged, key=lambda candidate: candidate.squares)
    ]
    further = (100 * error for error in law.heldout_by.values())
    rows.append(("law as it is", 100 * law.heldout_nrmse, *further, 0.0, "–"))
    header = (
        "with",
        "error on left-out A, f / %",
        *(f"on left-out {name} / %" for name in law.heldout_by),
        "of the lack of fit explained / %",
        "speaks against it",
    )
    return Table(header, rows, "every candidate refitted jointly with the law")


def answer_sections(answer: Answer) -> list[Section]:
    """Give the report of a diagnosis."""
    diagnosis = answer.diagnosis
    words = [answer.headline(), *(_sentence(reason) for reason in diagnosis.reasons)]
    if answer.proposal:
        words.append(f"Next: {answer.proposal.words()}.")
    steps = [("law as it is", diagnosis.law.heldout_nrmse), *_steps(diagnosis)]
    noise = answer.comparison.noise_nrmse
    falling = waterfall_picture(steps, noise, "error on left-out conditions", "What the best effects would do")
    sections = [
        Section("Verdict", words, [candidate_table(diagnosis)], [falling]),
        Section("Evidence", _evidence(diagnosis), _screened(diagnosis)),
        Section("What the best law leaves over", _left_over_sentences(answer), (), [
            curves_picture(
                "phase / deg after the largest displacement", "residual / N",
                [("rms over runs", answer.leftover.phase.tolist(), answer.leftover.shape.tolist(), "lines")],
                "Residual force along the cycle, best law, noise included",
            )
        ]),
    ]  # fmt: skip
    if answer.proposal:
        sections.append(_proposal_section(answer.proposal))
    return [*sections, *comparison_sections(answer.comparison)]


def _sentence(words: str) -> str:
    return f"{words[0].upper()}{words[1:]}."


def _left_over_sentences(answer: Answer) -> list[str]:
    return [_sentence(word) for word in answer.left_over()] or ["Nothing that follows the conditions."]


def _steps(diagnosis: Diagnosis) -> list[tuple[str, float]]:
    """Give the effects that the answer names, or the best one, each alone, then the pair, with the error left out."""
    named = [judged for judged in diagnosis.candidates if effect_id(judged.effects[0]) in diagnosis.effects]
    alone = named or diagnosis.candidates[:1]
    together = [diagnosis.pair] if diagnosis.pair else []
    return [
        (f"{'or ' if place and len(judged.effects) == 1 else ''}+ {' + '.join(judged.effects)}", judged.heldout_nrmse)
        for place, judged in enumerate([*alone, *together])
    ]


def _evidence(diagnosis: Diagnosis) -> list[str]:
    """Say of the best candidates what to look at and what would speak against them."""
    words = []
    for candidate in diagnosis.candidates[:4]:
        name = candidate.effects[0]
        effect = next(effect for effect in candidate.result.equations.effects if effect.name == name)
        against = "; ".join(_against(candidate, diagnosis.law)) or "nothing in this data"
        words.append(
            f"{name}, in the picture: {effect.looks_like}. It takes the error on left-out conditions from "
            f"{diagnosis.law.heldout_nrmse:.2%} to {candidate.heldout_nrmse:.2%} and explains "
            f"{explained(candidate, diagnosis):.0%} of what is missing. Imitated by "
            f"{', '.join(effect.imitated_by) or 'nothing'}; what tells: {effect.told_apart_by}. Against it: {against}."
        )
    return words


def _screened(diagnosis: Diagnosis) -> list[Table]:
    rows = [(name, 100 * max(share, 0.0)) for name, share in diagnosis.screened_out.items()]
    return [Table(("screened out", "promise, % of the best's"), rows, "effects that one step showed can't help")]


def _proposal_section(proposal: Proposal) -> Section:
    panels = [
        LoopPanel(f"if it is {name}", proposal.motion.y[0], None, force)
        for name, force in zip(proposal.rivals, proposal.forces, strict=True)
    ]
    difference = LoopPanel("difference", proposal.motion.y[0], None, proposal.forces[0] - proposal.forces[1])
    return Section(
        "Next test", [_sentence(proposal.words())], (),
        [loops_picture([*panels, difference], "What each rival predicts")],
    )  # fmt: skip
