"""A law diagnosed on metrics without records: the verdict in words, and the test to run next."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from pipeclamp_identification.diagnosis.further_test.limits import Limits
from pipeclamp_identification.diagnosis.further_test.next_test import NoTest
from pipeclamp_identification.diagnosis.named import NO_PROOF, WITH, by_history, few_levels_words, untested_words
from pipeclamp_identification.metrics_only.campaign import MetricCampaign
from pipeclamp_identification.metrics_only.law import MetricComparison, compare_metrics
from pipeclamp_identification.metrics_only.next_test import MetricProposal, next_metric_test
from pipeclamp_identification.metrics_only.verdict import MetricDiagnosis, diagnose_metrics
from pipeclamp_identification.metrics_only.weighing import MetricWeighed
from pipeclamp_models.base.processes import ALONE, Workers
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import LawFile, NamedKind, Verdict, structure_of

HEADLINES: dict[tuple[Verdict, NamedKind | None], str] = {
    ("complete", None): "Complete, as far as dW and W can show: what is left is scatter.",
    ("missing", "cause"): "Missing: {}.",
    ("missing", "part"): "Part of what is missing: {}.",
    ("ambiguous", "cause"): "One of these is missing, and these metrics can't tell which: {}.",
    ("ambiguous", "part"): "One of these takes part of what is missing, and these metrics can't tell which: {}.",
    ("unknown", None): "These metrics can't say what is missing.",
}
CONDITIONS = {"A": "amplitude", "f": "frequency", "T": "temperature", "N": "cycle number", "rho": "density"}


@dataclass(frozen=True)
class MetricDiagnosed:
    """A law diagnosed on metrics.

    Attributes:
        diagnosis: the verdict and its evidence.
        campaign: the metrics.
        comparison: the law as it is in its file against them.
        proposal: the test to run next, where rivals are left and one within the limits tells them apart.
        no_test: why there is none, where rivals are left.
        beside_a_part: whether what it names stands beside a part, so that it is no more than one itself.
    """

    diagnosis: MetricDiagnosis
    campaign: MetricCampaign
    comparison: MetricComparison
    proposal: MetricProposal | None
    no_test: str = ""
    beside_a_part: bool = False

    @property
    def verdict(self) -> Verdict:
        """The verdict."""
        return self.diagnosis.verdict

    @property
    def effects(self) -> tuple[str, ...]:
        """What is missing, or may be, as `add` takes it; best first."""
        return self.diagnosis.effects

    @property
    def kind(self) -> NamedKind | None:
        """How what is named is meant: as the cause, or as a part of what is missing."""
        kind = self.diagnosis.kind
        return "part" if kind and self.beside_a_part else kind

    @property
    def together(self) -> tuple[str, ...]:
        """What is named first, and the effect that scales what only it brings; empty where it is named alone."""
        named = self.diagnosis.named
        return () if named is None or len(named.effects) < 2 else named.effects

    @property
    def other_parts(self) -> Mapping[str, float]:
        """None: what metrics name stands alone, or beside what they can't tell from it."""
        return {}

    @property
    def leaves_means_open(self) -> bool:
        """Never: metrics hold no mean force."""
        return False

    @property
    def calls_for_a_term(self) -> bool:
        """Never: a term acts along a loop, which metrics don't hold."""
        return False

    @property
    def values(self) -> Mapping[str, float]:
        """Parameters of the law with what is named first, by name; empty where nothing is named."""
        named = self.diagnosis.named
        return {} if named is None else named.result.law.values

    def naming_a_part(self, reason: str) -> Self:
        """Give the same with what it names as the cause for a part, for this reason."""
        found = replace(self.diagnosis.found, reasons=(*self.diagnosis.reasons, reason))
        return replace(self, diagnosis=replace(self.diagnosis, found=found), beside_a_part=True)

    def naming_nothing(self, reason: str) -> Self:
        """Give the same with `unknown` for a verdict: what it named didn't help."""
        diagnosis = replace(self.diagnosis, found=MetricWeighed("unknown", (), (reason,)), rests_on=())
        return replace(self, diagnosis=diagnosis, proposal=None, no_test="")

    def headline(self) -> str:
        """Give the verdict in words."""
        names = " or ".join(WITH.join(law.effects) for law in self.diagnosis.found.laws)
        return HEADLINES[self.verdict, self.kind].format(names)

    def words(self) -> list[str]:
        """Say why, what it rests on, and what metrics can't show."""
        slow, timed = self.diagnosis.observations.motion.slow, self.campaign.time_measured
        untested = untested_words(slow, timed=timed)
        return [
            *self.diagnosis.reasons, *untested, *self.cautions(), *_hidden_words(self.diagnosis), *self.few_levels()
        ]  # fmt: skip

    def few_levels(self) -> tuple[str, ...]:
        """Say what a law that stays as it is does unasked between the levels of further conditions."""
        if self.verdict not in ("complete", "unknown"):
            return ()
        columns, runs = self.campaign.condition_columns, self.campaign.runs
        fitted = self.diagnosis.law.result.fitted_parameters
        return few_levels_words(
            fitted, {name: np.array([run.setup.conditions[name] for run in runs]) for name in columns}
        )

    def rung(self) -> tuple[str, ...]:
        """Say what the effect that is named first takes."""
        named = self.diagnosis.named
        if named is None:
            return ()
        takes = f"{WITH.join(named.effects)} takes {self.diagnosis.explained(named):.0%}"
        where = "is missing, on left-out conditions" if self.diagnosis.of_left_out else "the metrics show missing"
        return (f"{takes} of what {where}",)

    def refitted(self, before: float, after: float) -> tuple[str, ...]:
        """Say nothing: what a rung says here is no estimate of left-out conditions but the fit to all, or refits."""
        return ()

    def cautions(self) -> list[str]:
        """Warn where what was named rests on single measurements."""
        diagnosis, words = self.diagnosis, [NO_PROOF] if self.kind == "part" else []
        name = WITH.join(self.together or diagnosis.effects[:1])
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
            "nothing shows how far the metrics scatter there"
            for signal in diagnosis.tested_once
        ]
        return words


def metrics_diagnosed(
    file: LawFile,
    campaign: MetricCampaign,
    *,
    declared: Collection[Declaration] = (),
    limits: Limits | None = None,
    workers: Workers = ALONE,
) -> MetricDiagnosed:
    """Diagnose the law of a parameter file on a campaign of metrics; see `diagnosis.named.by_history`.

    Raises:
        UserError: the metrics can't serve the law.
    """
    comparison = compare_metrics(file, campaign)
    diagnosis = diagnose_metrics(structure_of(file).with_declared(declared), campaign, workers=workers)
    test = next_metric_test(diagnosis, limits, timed=campaign.time_measured)
    proposal, no_test = (None, test.words) if isinstance(test, NoTest) else (test, "")
    found = MetricDiagnosed(diagnosis, campaign, comparison, proposal, no_test)
    return by_history(found, file, campaign.fingerprint, declared)


def _place(campaign: MetricCampaign, row: int) -> str:
    run = campaign.runs[row]
    T = "" if run.setup.temperature_C is None else f", {run.setup.temperature_C:g} °C"
    return f"{run.name} ({run.amplitude_mm:g} mm, {run.frequency_Hz:g} Hz{T})"


def _hidden_words(diagnosis: MetricDiagnosis) -> list[str]:
    reasons: dict[str, list[str]] = {}
    for name, reason in diagnosis.hidden.items():
        reasons.setdefault(reason, []).append(name)
    told = "; ".join(f"{', '.join(names)} ({reason})" for reason, names in reasons.items())
    return [f"not visible in these metrics, so neither found nor refuted: {told}"] if told else []
