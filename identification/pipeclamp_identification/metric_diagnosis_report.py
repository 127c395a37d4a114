"""The answer of a diagnosis on loop metrics alone: as JSON (CONTRACT.md), and as a report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeclamp.declaration import Declaration
from pipeclamp.parameter_file import LawFile, structure_of
from pipeclamp_identification.fit import Progress
from pipeclamp_identification.metric_campaign import MetricCampaign
from pipeclamp_identification.metric_diagnosis import MetricDiagnosis, diagnose_metrics
from pipeclamp_identification.metric_evidence import MetricJudged
from pipeclamp_identification.metric_law import MetricComparison, compare_metrics, metric_comparison_sections, rms
from pipeclamp_identification.metric_next_test import MetricProposal, next_metric_test
from pipeclamp_identification.next_test import Limits
from pipeclamp_identification.pictures import waterfall_picture
from pipeclamp_identification.report import Section, Table
from pipeclamp_identification.screen import effect_id

HEADLINES = {
    "complete": "Complete, as far as dW and W can show: what is left is scatter.",
    "missing": "Missing: {}.",
    "ambiguous": "One of these is missing, and these metrics can't tell which: {}.",
    "unknown": "These metrics can't say what is missing.",
}
CONDITIONS = {"A": "amplitude", "f": "frequency", "T": "temperature", "N": "cycle number", "rho": "density"}


@dataclass(frozen=True)
class MetricAnswer:
    """A diagnosis with what belongs to it.

    Attributes:
        diagnosis: the verdict and its evidence.
        campaign: the metrics.
        comparison: the law as it is in its file against them.
        proposal: the test to run next, where rivals are left.
    """

    diagnosis: MetricDiagnosis
    campaign: MetricCampaign
    comparison: MetricComparison
    proposal: MetricProposal | None

    @property
    def verdict(self) -> str:
        """The verdict."""
        return self.diagnosis.verdict

    @property
    def to_add(self) -> str:
        """The effect to add."""
        return next(
            judged.effects[0]
            for judged in self.diagnosis.candidates
            if effect_id(judged.effects[0]) == self.diagnosis.effects[0]
        )

    def headline(self) -> str:
        """Give the verdict in words."""
        return HEADLINES[self.verdict].format(" or ".join(self.diagnosis.effects))

    def words(self) -> list[str]:
        """Say why, what it rests on, and what metrics can't show."""
        return [*self.diagnosis.reasons, *self.cautions(), *_hidden_words(self.diagnosis)]

    def cautions(self) -> list[str]:
        """Warn where what was named rests on single measurements."""
        diagnosis, words = self.diagnosis, []
        name = "".join(diagnosis.effects[:1])
        if diagnosis.rests_on:
            rows = "; ".join(_place(self.campaign, row) for row in diagnosis.rests_on)
            one = len(diagnosis.rests_on) == 1
            few, without, tests = (
                ("one row", "without", "that test") if one else ("single rows", "without any one of", "these tests")
            )
            words.append(
                f"warning: {name} rests on {few}: {without} {rows}, less than half of its gain is left; repeat {tests} "
                "before you trust it"
            )
        words += [
            f"warning: every {CONDITIONS.get(signal, signal)} but one was tested once: each rests on one row, and "
            f"nothing shows how far {name} scatters there"
            for signal in diagnosis.tested_once
        ]
        return words


def metric_answer_for(
    file: LawFile,
    campaign: MetricCampaign,
    *,
    declared: Sequence[Declaration] = (),
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> MetricAnswer:
    """Diagnose the law of a parameter file on a campaign of metrics.

    Raises:
        UserError: the metrics can't serve the law.
    """
    comparison = compare_metrics(file, campaign)
    diagnosis = diagnose_metrics(structure_of(file).with_declared(declared), campaign, progress=progress)
    return MetricAnswer(diagnosis, campaign, comparison, next_metric_test(diagnosis, limits))


def _place(campaign: MetricCampaign, row: int) -> str:
    run = campaign.runs[row]
    T = "" if run.temperature_C is None else f", {run.temperature_C:g} °C"
    return f"{run.name} ({run.amplitude_mm:g} mm, {run.frequency_Hz:g} Hz{T})"


def _hidden_words(diagnosis: MetricDiagnosis) -> list[str]:
    reasons: dict[str, list[str]] = {}
    for name, reason in diagnosis.hidden.items():
        reasons.setdefault(reason, []).append(name)
    return [f"not visible in these metrics, so neither found nor refuted: {', '.join(names)} ({reason})"
            for reason, names in reasons.items()]  # fmt: skip


def metric_answer_json(answer: MetricAnswer) -> dict[str, Any]:
    """Give the answer of `diagnose --json` (CONTRACT.md); errors are rms log ratios of dW and W."""
    diagnosis, proposal = answer.diagnosis, answer.proposal
    dissipated, elastic = diagnosis.scatter.share
    return {
        "verdict": answer.verdict,
        "effects": list(diagnosis.effects),
        "measure": "rms of log(measured/computed) of dW and W: the campaign has no records",
        "candidates": [_candidate_json(judged, diagnosis) for judged in diagnosis.candidates],
        "screened_out": list(diagnosis.screened_out),
        "not_visible": dict(diagnosis.hidden),
        "nrmse": {
            "law": answer.comparison.nrmse,
            "best": _error(diagnosis.best, diagnosis),
            "noise": float(np.sqrt((dissipated**2 + elastic**2) / 2)),
        },
        "heldout_nrmse": {"law": diagnosis.heldout[""], "best": diagnosis.heldout["".join(diagnosis.best.effects)]},
        "scatter": {
            "dissipated_energy": float(dissipated),
            "max_elastic_energy": float(elastic),
            "degrees_of_freedom": diagnosis.scatter.freedoms.tolist(),
        },
        "richest_law": list(diagnosis.richest.effects),
        "rests_on": [answer.campaign.runs[row].name for row in diagnosis.rests_on],
        "next_test": None
        if proposal is None
        else {
            "amplitude_mm": proposal.amplitude_mm,
            "frequency_Hz": proposal.frequency_Hz,
            "temperature_C": proposal.temperature_C,
            "profile": "sine",
            "separation": proposal.separation,
            "between": list(proposal.rivals),
            "words": proposal.words(),
        },
        "left_over": [],
        "reasons": answer.words(),
        "left_out": [{"run": entry.run, "reason": entry.reason} for entry in answer.campaign.left_out],
    }


def _error(judged: MetricJudged, diagnosis: MetricDiagnosis) -> float:
    return rms(judged.residual * diagnosis.observations.relative_error)


def _candidate_json(judged: MetricJudged, diagnosis: MetricDiagnosis) -> dict[str, Any]:
    name = judged.effects[0]
    return {
        "effect": name,
        "heldout_nrmse": diagnosis.heldout[name],
        "nrmse": _error(judged, diagnosis),
        "explained": explained(judged, diagnosis),
        "chance": diagnosis.chances[name],
        "objections": list(judged.objections),
        "parameters": {
            parameter.name: judged.result.law.values[parameter.name]
            for effect in judged.result.equations.effects
            if effect.name == name
            for parameter in effect.parameters
        },
    }


def explained(judged: MetricJudged, diagnosis: MetricDiagnosis) -> float:
    """Give the share of what the richest law explains beyond the law as it is that a candidate explains alone."""
    whole = diagnosis.law.squares - min(diagnosis.richest.squares, judged.squares)
    return float(np.clip((diagnosis.law.squares - judged.squares) / whole, 0.0, 1.0)) if whole > 0 else 0.0


def metric_candidate_table(diagnosis: MetricDiagnosis) -> Table:
    """Give the candidates, best first, and the law as it is."""
    rows: list[tuple[str | float | None, ...]] = [
        (
            judged.effects[0],
            100 * _error(judged, diagnosis),
            100 * diagnosis.heldout[judged.effects[0]],
            100 * explained(judged, diagnosis),
            100 * diagnosis.chances[judged.effects[0]],
            "; ".join(judged.objections) or "–",
        )
        for judged in diagnosis.candidates
    ]
    rows.append(("law as it is", 100 * _error(diagnosis.law, diagnosis), 100 * diagnosis.heldout[""], 0.0, None, "–"))
    header = ("with", "error / %", "on left-out conditions / %", "explained / %", "by scatter alone / %", "against it")
    return Table(header, rows, "every candidate refitted jointly with the law; rms log ratios of dW and W")


def metric_answer_sections(answer: MetricAnswer) -> list[Section]:
    """Give the report of a diagnosis on metrics."""
    diagnosis = answer.diagnosis
    words = [answer.headline(), *(f"{word[0].upper()}{word[1:]}." for word in answer.words())]
    if answer.proposal:
        words.append(f"Next: {answer.proposal.words()}.")
    steps = [("law as it is", diagnosis.heldout[""])]
    if diagnosis.best.effects:
        name = diagnosis.best.effects[0]
        steps.append((f"+ {name}", diagnosis.heldout[name]))
    noise = float(np.sqrt(np.mean(diagnosis.scatter.share**2)))
    falling = waterfall_picture(steps, noise, "error on left-out conditions", "What the best effect would do")
    return [
        Section("Verdict", words, [metric_candidate_table(diagnosis)], [falling]),
        *metric_comparison_sections(answer.comparison),
    ]
