"""Diagnosis: which physical effect a law lacks, told honestly, or which test would tell."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pipeclamp_identification.campaign.reading import Campaign
from pipeclamp_identification.diagnosis.candidates import (
    as_it_is,
    candidates,
    law_from_another_valley,
    likeliest,
    ranked,
)
from pipeclamp_identification.diagnosis.elsewhere import elsewhere
from pipeclamp_identification.diagnosis.foretold import explained_share
from pipeclamp_identification.diagnosis.leftover import Leftover, describe
from pipeclamp_identification.diagnosis.open_means import with_means_counted
from pipeclamp_identification.diagnosis.problem import (
    CLOSELY,
    Judged,
    Prepared,
    Problem,
    judge,
    judge_each,
    prepare,
    weighed_again,
)
from pipeclamp_identification.diagnosis.repeats import Unstated, unstated
from pipeclamp_identification.diagnosis.screen import screened
from pipeclamp_identification.diagnosis.thresholds import (
    FEWEST_RUNS,
    FORM_NOISE_SHARE,
    FORM_SHARE,
    MATERIAL_FORCE_SHARE,
    MATERIAL_NOISE_SHARE,
)
from pipeclamp_identification.diagnosis.weighing.causes import (
    unless_at_one_condition,
    unless_it_slips_at_one_amplitude,
)
from pipeclamp_identification.diagnosis.weighing.scales import Scales, Weighed
from pipeclamp_identification.diagnosis.weighing.tolerance import Tolerance, is_adequate, is_complete
from pipeclamp_identification.diagnosis.weighing.weigh import part_or_nothing, weigh
from pipeclamp_identification.fitting.identify import fit_structure
from pipeclamp_identification.fitting.misfit import RunMisfit, misfits
from pipeclamp_identification.loops.loops import Loops, loops_of
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.processes import ALONE, Workers
from pipeclamp_models.base.said import counted
from pipeclamp_models.law.file import NamedKind, Verdict
from pipeclamp_models.law.law import Structure


@dataclass(frozen=True)
class Diagnosis:
    """The answer.

    Attributes:
        found: the verdict, what it names and why. What is locked to time, or to several cycles, is no scatter: a law
            that leaves it over isn't complete.
        law: the law as it is, refitted.
        candidates: every effect that was fitted, best first.
        screened_out: effects that one step showed can't help, with the share of the best's promise.
        problem: the data.
        tolerance: lack of fit that is let pass.
        campaign: the tests.
        loops: `loops_of(campaign)`.
    """

    found: Weighed
    law: Judged
    candidates: tuple[Judged, ...]
    screened_out: Mapping[str, float]
    problem: Problem
    tolerance: Tolerance
    campaign: Campaign
    loops: Loops

    @property
    def verdict(self) -> Verdict:
        """The verdict."""
        return self.found.verdict

    @property
    def effects(self) -> tuple[str, ...]:
        """What is missing, or may be, as it was judged; best first."""
        return self.found.effects

    @property
    def kind(self) -> NamedKind | None:
        """How what is named is meant: it explains what is missing, or takes a part of it."""
        return self.found.kind

    @property
    def pair(self) -> Judged | None:
        """The best two effects together, where one alone doesn't explain."""
        return self.found.pair

    @property
    def reasons(self) -> tuple[str, ...]:
        """Why the verdict is what it is."""
        return self.found.reasons

    @property
    def best(self) -> Judged:
        """The best law that was found: a pair, a candidate, or the law as it is."""
        found = (self.law, *self.candidates, *([self.pair] if self.pair else []))
        return min(found, key=lambda each: each.squares)

    @cached_property
    def best_misfits(self) -> tuple[RunMisfit, ...]:
        """Error of the best law on every run."""
        return self._misfits(self.best)

    @property
    def described(self) -> Judged:
        """The law whose leftover is described: with what is named first, or as it is."""
        return self.found.named or self.law

    @cached_property
    def leftover(self) -> Leftover:
        """What that leaves over."""
        return describe(self.described, self.problem, self.campaign, self._misfits(self.described))

    def _misfits(self, judged: Judged) -> tuple[RunMisfit, ...]:
        return misfits(judged.result.law, self.campaign, self.loops)

    @property
    def explained(self) -> float | None:
        """Share of the mean-square lack of fit, on left-out conditions, that what is named first takes."""
        named = self.found.named
        return None if named is None else explained_share(named, self.law)

    def is_adequate(self, judged: Judged) -> bool:
        """Tell whether nothing that a law leaves over follows the conditions."""
        return is_adequate(judged.lack, self.tolerance)


def diagnose(
    structure: Structure,
    campaign: Campaign,
    loops: Loops | None = None,
    *,
    start: Mapping[str, float] | None = None,
    proved: bool = True,
    workers: Workers = ALONE,
    prepared: Callable[[Structure, Mapping[str, float]], Prepared] | None = None,
) -> Diagnosis:
    """Find which effect a law lacks.

    Args:
        structure: the law's structure; its parameters are refitted.
        campaign: the tests.
        loops: `loops_of(campaign)`, where they are known already.
        start: values of the law's parameters to start from, by name, where they are known.
        proved: whether nothing of the law was added as a mere part.
        workers: who does it, and who is told.
        prepared: gives `prepare` of a structure and values to start from, where it may be known already.

    Raises:
        UserError: the data can't serve the law, or there are too few runs to tell.
    """
    loops = loops or loops_of(campaign)
    if len(loops.run) < FEWEST_RUNS:
        raise UserError(
            f"{counted(len(loops.run), 'run')} can't show what a law lacks; expected at least {FEWEST_RUNS}: "
            "`pipeclamp plan` proposes tests, and `pipeclamp import --columns segment=each-cycle` makes each cycle of "
            "a program a run"
        )
    workers.tell("law as it is")
    problem, in_newtons = prepared(structure, start or {}) if prepared else prepare(structure, loops, start)
    law = judge((), structure, [in_newtons.law.values], problem)
    tolerance = _tolerance(structure, problem, loops, proved)
    judged: list[Judged] = []
    screened_out: dict[str, float] = {}
    if not is_complete(law, problem, tolerance):
        problem, law = weighed_again(problem, structure, in_newtons, [in_newtons, law.result])
        promises = screened(structure, problem, law, workers)
        judged, screened_out = candidates(structure, problem, law, promises, workers)
        problem, law, judged = _by_the_best_ones_residuals(problem, law, judged, workers)
    differing = _unstated_beside(law, judged, problem)
    scales = Scales(structure, problem, law, judged, tolerance, workers)
    found = weigh(scales, differing)
    found = unless_it_slips_at_one_amplitude(unless_at_one_condition(found, problem.loops), problem)
    workers.tell("what is left over")
    diagnosis = Diagnosis(found, law, tuple(judged), screened_out, problem, tolerance, campaign, loops)
    if found.verdict != "complete":
        return diagnosis
    if diagnosis.leftover.not_periodic:
        return replace(diagnosis, found=replace(found, verdict="unknown"))
    workers.tell("levels left out")
    contradiction = elsewhere(law, problem, tolerance, campaign, loops).contradiction
    if not contradiction:
        return diagnosis
    return replace(diagnosis, found=_contradicted(found, contradiction, scales))


def _contradicted(found: Weighed, contradiction: str, scales: Scales) -> Weighed:
    """Name what takes a part where a law that had passed as complete doesn't hold elsewhere; else nothing, and why."""
    part = part_or_nothing(scales, contradiction)
    return replace(part, reasons=(*part.reasons, *found.reasons[1:]), unstated=found.unstated)


def _by_the_best_ones_residuals(
    problem: Problem, law: Judged, judged: list[Judged], workers: Workers
) -> tuple[Problem, Judged, list[Judged]]:
    """Weigh the evidence by what the best law leaves over, and leave a poor valley that candidates have left."""
    if judged and not judged[0].objections:
        workers.tell("evidence weighed by the best law's own residuals")
        problem, law = weighed_again(problem, law.result.law.structure, likeliest(judged).result, [law.result])
        judged = ranked(judge_each([as_it_is(each) for each in judged], problem, workers))
    law = law_from_another_valley(law, judged, problem, workers)
    return problem, law, [with_means_counted(each, law, problem) for each in judged]


def _unstated_beside(law: Judged, judged: Sequence[Judged], problem: Problem) -> Unstated | None:
    """Find what differs between runs at the same stated conditions, beside the likeliest law and the law as it is."""
    sound = likeliest([law, *(each for each in judged if not each.objections)])
    residual, missed = (problem.plain_residual(each.result.law_force) for each in (sound, law))
    return unstated(problem.loops, problem.noise, residual, missed)


def _tolerance(structure: Structure, problem: Problem, loops: Loops, proved: bool) -> Tolerance:
    """Give the lack of fit that is let pass; of form, a share of what the law's effects explain."""
    complete = max(MATERIAL_NOISE_SHARE, _precision(loops))
    form = max(complete, min(FORM_SHARE * _bare_lack(structure, problem), FORM_NOISE_SHARE))
    return Tolerance(complete, form, max(complete, FORM_NOISE_SHARE), proved)


def _bare_lack(structure: Structure, problem: Problem) -> float:
    """Give what the bare base law leaves over, as a share of the force noise; zero where the law is bare."""
    if not structure.effects:
        return 0.0
    bare = replace(structure, effects=())
    fitted = fit_structure(bare, problem.loops, problem.harmonics, tolerance=CLOSELY)
    return judge((), bare, [fitted.law.values], problem).lack.share


def _precision(loops: Loops) -> float:
    """Give the force below which nothing can be told, as a share of the force noise."""
    return MATERIAL_FORCE_SHARE * float(np.sqrt(np.sum(loops.force_rms_N**2) / np.sum(loops.scatter_rms_N**2)))
