"""Several laws held against the same tests: those that a user names, and the earlier stages of a law's own history."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol

from pipeclamp_identification.comparison.compare import Comparison
from pipeclamp_identification.comparison.names import labels_of
from pipeclamp_identification.fitting.misfit import RunMisfit, misfits, overall_nrmse
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.file import LawFile, law_at
from pipeclamp_models.law.law import Law


class Errs(Protocol):
    """A law that was held against tests."""

    @property
    def nrmse(self) -> float:
        """Error over all runs, as a share."""


@dataclass(frozen=True)
class ComparedLaw:
    """A law and its error on each run of a campaign.

    Attributes:
        label: how it is named beside the others.
        law: the law.
        runs: the error on each run, in the campaign's order.
    """

    label: str
    law: Law
    runs: tuple[RunMisfit, ...]

    @property
    def nrmse(self) -> float:
        """Error over all samples as a share of the force."""
        return overall_nrmse(self.runs)


def least_error(held: Sequence[Errs]) -> int:
    """Give the place of the law that errs least of several held against the same tests; of equal ones the first."""
    return min(range(len(held)), key=lambda place: held[place].nrmse)


def stages_held(file: LawFile, comparison: Comparison) -> tuple[ComparedLaw, ...]:
    """Hold each stage of a law's history against the tests, the law itself last.

    A stage that this version can't compute, or that the tests can't serve, is left out.

    Args:
        file: the law.
        comparison: it held against the tests, with runs of sines.
    """
    stages: list[ComparedLaw] = []
    for step in file.history[:-1]:
        if step.stage is None:
            continue
        try:
            law = law_at(file, step.stage)
            runs = misfits(law, comparison.campaign, comparison.loops)
        except UserError:
            continue
        stages.append(ComparedLaw(step.step, law, runs))
    label = file.history[-1].step if file.history else file.name
    return (*stages, ComparedLaw(label, comparison.law, comparison.runs))


def laws_held(comparisons: Iterable[tuple[LawFile, Comparison]]) -> tuple[ComparedLaw, ...]:
    """Give laws of files, each held against the same tests, with labels that tell them apart."""
    held = tuple(comparisons)
    labels = labels_of([file for file, _ in held])
    return tuple(ComparedLaw(label, one.law, one.runs) for label, (_, one) in zip(labels, held, strict=True))
