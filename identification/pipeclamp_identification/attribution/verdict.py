"""Which parameter of a coupled model is wrong: the pipe's or the clamp's, or can't these measurements tell?

Each suspect is refitted alone, and all of them together, to sines, to records of any motion, or to both. That anything
is wrong is judged by what the best one leaves over on frequencies that it was not fitted to, in units of the noise;
which one it is, by the likelihood: one is named only if it rules every other one out. Where a second one beside a first
promises clearly more than the best one alone, or all together do, pairs are refitted, and named likewise.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from pipeclamp_identification.attribution.compared import Compared
from pipeclamp_identification.attribution.other_branches import MUCH_LESS_RMS_SHARE, on_the_nearest_branches
from pipeclamp_identification.attribution.pairs import promised_pairs, refitted_pairs
from pipeclamp_identification.attribution.refit import (
    MOST_EVALUATIONS,
    Refit,
    RefitStart,
    as_stated,
    bounds_of,
    refit,
    searched,
)
from pipeclamp_identification.attribution.sine_evidence import SineEvidence
from pipeclamp_identification.attribution.suspect import Suspect
from pipeclamp_identification.attribution.suspects import suspects_of, with_mounts
from pipeclamp_identification.attribution.task import RefitTask, task_of
from pipeclamp_identification.on_pipe.prediction import predict
from pipeclamp_identification.signals.chances import squares_of_chance
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.law.file import NamedKind

PipeVerdict = Literal["complete", "wrong", "ambiguous", "unknown"]

FEWEST_VALUES = 20
"""Measured values, an amplitude and a phase being two, of which it can be asked what is wrong."""
BLOCKS = 10
"""Parts of neighbouring frequencies that are left out in turn."""
CLEARLY_MORE_SQUARES = 15.0
"""Squares over the noise's that a suspect must take away where it wasn't fitted, so that something is wrong: the best
of some 40 does so by chance in less than one of 100 measurements."""
RULED_OUT_SQUARES = 10.0
"""Twice the log of the likelihood ratio at which one suspect rules another out: that it rules out the true one has a
chance of 8e-4 at most, of sqrt(10) standard deviations, whatever the two are."""
PARAMETER_SQUARES = 2.0
"""By Akaike: squares that a further parameter takes away for nothing, there and where it wasn't fitted."""
WORTH_RMS_SHARE = 0.97
"""A suspect that leaves more than this share of the rms isn't worth a name."""
NEEDLESS_CHANCE = 1e-5
"""Chance with which more parameters would be taken for needed where they aren't."""
NOISE_ONLY_RMS = 1.4
"""Rms in units of the noise up to which what is left is noise."""
PLAUSIBLE_NOISE_NRMSE = 0.1
"""More than tests on pipes scatter by: of what is left beyond it repeated sines alone tell that it is noise. How rough
a misfit is doesn't, where sines lie farther apart than resonances are wide."""
EXPLAINED_SQUARES_SHARE = 0.7
"""Share of the squared misfit that a suspect must take away to be named although more than noise is left."""
PLAIN_SQUARES_SHARE = 0.9
"""Likewise, of one that is named as a part although all together leave clearly less."""
NEAR_IN_SQUARES = 30.0
"""Suspects that leave more squares than this times the best one's are not refitted once the noise is known."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """Suspects that were refitted together, alone as a rule.

    Attributes:
        refit: their refit.
        heldout: squares that it leaves on parts that were left out, over the noise.
        nrmse: rms of what it leaves over the rms of what was measured.
    """

    refit: Refit
    heldout: float
    nrmse: float

    @property
    def suspects(self) -> tuple[Suspect, ...]:
        """What was refitted."""
        return self.refit.suspects

    @property
    def id(self) -> str:
        """The suspects' ids."""
        return " + ".join(suspect.id for suspect in self.suspects)

    @property
    def words(self) -> str:
        """The suspects in words."""
        return " and ".join(suspect.words for suspect in self.suspects)

    @property
    def overdispersion(self) -> float:
        """Mean square of what is left, in units of the noise's; 1 at least."""
        return max(1.0, self.refit.squared / self.refit.freedoms)

    @property
    def unlikelihood(self) -> float:
        """Squares that are left, with what its parameters take away for nothing."""
        return self.refit.squared + PARAMETER_SQUARES * len(self.refit.values)

    def value_words(self) -> str:
        """Say the refitted values."""
        parts = []
        for suspect in self.suspects:
            errors = self.refit.errors_of(suspect, self.overdispersion)
            parts.append(f"{suspect.words}: {suspect.value_words(self.refit.values_of(suspect), errors)}")
        return "; ".join(parts)


@dataclass(frozen=True, eq=False)
class Attribution:
    """What of a coupled model is wrong.

    Attributes:
        verdict: "complete": what is left is noise; "wrong": this is; "ambiguous": one of these is; "unknown": none of
            these explains it.
        named: what the verdict names, best first.
        candidates: all that were tried, best first.
        stated: the model as it is stated.
        together: all suspects refitted at once.
        left: rms of what the best leaves in units of the noise.
        task: what was fitted.
        kind: of what is named: a cause leaves noise; a part takes most, and more is wrong, or something that acts
            alike stands behind it.
        branch_unknown: whether it is "unknown" since what is named errs at sines alone of which it isn't known which of
            the model's stable motions was measured.
        noise_unknown: whether more is left than can be taken for noise, and no sine was repeated that would tell.
        unseen: suspects of which no other stable motions were looked for, as that would take too much work.
    """

    verdict: PipeVerdict
    named: tuple[Candidate, ...]
    candidates: tuple[Candidate, ...]
    stated: Candidate
    together: Candidate
    left: float
    task: RefitTask
    kind: NamedKind | None = None
    branch_unknown: bool = False
    noise_unknown: bool = False
    unseen: int = 0

    @property
    def suspects(self) -> tuple[Suspect, ...]:
        """All suspects that are named, each once."""
        return tuple({suspect.id: suspect for entry in self.named for suspect in entry.suspects}.values())


def attribute(compared: Compared, tell: Progress = silent) -> Attribution | None:
    """Find out which parameter of a coupled model is wrong; None where too little was measured to ask.

    Args:
        compared: the model with what was measured.
        tell: told what is being done.
    """
    task = stated_task(compared)
    if as_stated(task).residual.size < FEWEST_VALUES:
        return None
    suspects = suspects_of(compared.model, compared.description)
    tell("refit each parameter alone")
    unseen = 0
    refits = sorted(refit(task, searched(task, suspects)), key=lambda one: one.squared)
    if compared.sines:
        refits, unseen = on_the_nearest_branches(task, refits, compared.sines, tell)
    tell("refit all together")
    best = min(refits, key=lambda one: one.squared)
    (together,) = refit(task, [_all_from(suspects, best)])
    task = task.renewed(together.computed, together.rms)
    tell("refit with the noise that was found")
    together, *refits = _again(task, (together, *refits))
    alone = min((as_stated(task), *refits), key=lambda one: one.squared)
    if alone.rms <= NOISE_ONLY_RMS and not _needs_more(alone, together):
        task = task.explained(alone.computed, len(alone.values))
        together, *refits = _again(task, (together, *refits))
    singles = [_candidate(compared, task, one) for one in refits]
    return replace(_judged(compared, task, singles, together, tell), unseen=unseen)


def stated_task(compared: Compared) -> RefitTask:
    """Give what is fitted to, with mounts on the clamps and a first guess of the noise."""
    model = with_mounts(compared.model)
    sines = None
    if compared.sines:
        measurement = compared.sines.measurement
        sines = SineEvidence.begun(measurement, predict(model, measurement, compared.sines.prediction))
    return task_of(model, sines, compared.records)


def _again(task: RefitTask, refits: Sequence[Refit]) -> list[Refit]:
    """Refit with another noise, from where refits ended."""
    return refit(task, [_from(one) for one in refits], _limits(task, refits))


def _from(one: Refit) -> RefitStart:
    """Go on from a refit."""
    return RefitStart(one.suspects, one.values, one.computed, one.moved)


def _all_from(suspects: Sequence[Suspect], best: Refit) -> RefitStart:
    """Begin with all suspects at once, from the best single one."""
    values = [best.values if suspect.id == best.suspects[0].id else suspect.neutral for suspect in suspects]
    return RefitStart(tuple(suspects), tuple(value for part in values for value in part), best.computed)


def _limits(task: RefitTask, refits: Iterable[Refit]) -> list[int]:
    """Give how often each refit may be evaluated once more: but once where it can't matter any more."""
    residuals = [task.residual(one.computed) for one in refits]
    squares = [float(residual @ residual) for residual in residuals]
    least = min(squares)
    return [
        MOST_EVALUATIONS if squared < NEAR_IN_SQUARES * max(least, residual.size) else 1
        for squared, residual in zip(squares, residuals, strict=True)
    ]


def _candidate(compared: Compared, task: RefitTask, one: Refit) -> Candidate:
    return Candidate(one, _heldout(task, one), compared.saying(one.computed).nrmse)


def _heldout(task: RefitTask, one: Refit) -> float:
    """Give the squares that are left where a part of the frequencies is left out of the fit in turn.

    What the values would be without it is the Gauss-Newton step from the fit to all, within bounds.
    """
    total = 0.0
    J, residual, values = one.jacobian, one.residual, np.array(one.values)
    lower, upper = bounds_of(one.suspects)
    blocks = task.blocks(BLOCKS)
    for block in np.unique(blocks):
        inside, rest = blocks == block, blocks != block
        step = np.linalg.lstsq(J[rest], -residual[rest], rcond=None)[0] if J.shape[1] else np.zeros(0)
        left = residual[inside] + J[inside] @ (np.clip(values + step, lower, upper) - values)
        total += float(left @ left)
    return total


def _judged(
    compared: Compared, task: RefitTask, singles: list[Candidate], together: Refit, tell: Progress
) -> Attribution:
    """Give the verdict."""
    stated = _candidate(compared, task, as_stated(task))
    everything = _candidate(compared, task, together)

    def found(
        verdict: PipeVerdict, named: Sequence[Candidate], candidates: Sequence[Candidate], kind: NamedKind | None = None
    ) -> Attribution:
        left = (candidates[0] if verdict != "complete" else stated).refit.rms
        return Attribution(verdict, tuple(named), tuple(candidates), stated, everything, left, task, kind)

    singles = sorted(singles, key=lambda one: one.unlikelihood)
    most_general = min(singles, key=lambda one: one.heldout)
    if not _better(most_general, stated):
        if stated.refit.rms > NOISE_ONLY_RMS or _needs_more(stated.refit, together):
            return found("unknown", (), singles)
        if not _may_be_noise(compared, stated):
            return replace(found("unknown", (), singles), noise_unknown=True)
        return found("complete", (), singles)
    pairs = _pairs(compared, task, singles, everything, tell)
    of_size = pairs if pairs and _better(min(pairs, key=lambda one: one.heldout), most_general) else singles
    candidates = sorted([*singles, *pairs], key=lambda one: one.unlikelihood)
    best = of_size[0]
    needs_more = _needs_more(best.refit, together)
    may_be_noise = _may_be_noise(compared, best)
    of_noise = best.refit.residual.size if may_be_noise else 0.0
    explained = (stated.refit.squared - best.refit.squared) / (stated.refit.squared - of_noise)
    noise_only = may_be_noise and best.refit.rms <= NOISE_ONLY_RMS and not needs_more
    if not noise_only and explained < (PLAIN_SQUARES_SHARE if needs_more else EXPLAINED_SQUARES_SHARE):
        return found("unknown", (), candidates)
    if _hangs_on_a_branch(task, stated, best):
        return replace(found("unknown", (), candidates), branch_unknown=True)
    # A rival needn't be beyond doubt by itself: it is enough that the best one doesn't rule it out.
    rivals = [one for one in of_size if one is best or (not _rules_out(best, one) and _may_help(one, stated))]
    verdict: PipeVerdict = "wrong" if len(rivals) == 1 else "ambiguous"
    return replace(
        found(verdict, rivals, candidates, "cause" if noise_only else "part"), noise_unknown=not may_be_noise
    )


def _pairs(
    compared: Compared, task: RefitTask, singles: Sequence[Candidate], everything: Candidate, tell: Progress
) -> list[Candidate]:
    """Give refitted pairs, best first; none where no second suspect promises clearly more than the best one alone."""
    best, reach = singles[0], CLEARLY_MORE_SQUARES * everything.overdispersion
    promised = promised_pairs(task, [one.refit for one in singles])
    if promised[0].squared > best.refit.squared - reach and not _needs_more(best.refit, everything.refit):
        return []
    tell("refit pairs")
    pairs = [_candidate(compared, task, one) for one in refitted_pairs(task, promised, reach)]
    return sorted(pairs, key=lambda one: one.unlikelihood)


def _hangs_on_a_branch(task: RefitTask, stated: Candidate, best: Candidate) -> bool:
    """Tell whether a candidate explains nothing but sines of which it isn't known which stable motion was measured."""
    before, after = (task.on_known_branches(one.refit.residual) for one in (stated, best))
    gained = float(before @ before) - float(after @ after)
    return before.size < stated.refit.residual.size and gained <= CLEARLY_MORE_SQUARES * best.overdispersion


def _may_be_noise(compared: Compared, one: Candidate) -> bool:
    """Tell whether what a candidate leaves may be noise: it is little, or repeats tell how much that is."""
    return compared.sines is None or compared.sines.noise_nrmse is not None or one.nrmse <= PLAUSIBLE_NOISE_NRMSE


def _better(one: Candidate, other: Candidate) -> bool:
    """Tell whether a candidate leaves clearly less than another one where it wasn't fitted, and less by enough."""
    clearly = other.heldout - one.heldout > CLEARLY_MORE_SQUARES * one.overdispersion
    return clearly and _worth(one, other)


def _rules_out(one: Candidate, other: Candidate) -> bool:
    """Tell whether a candidate is so much likelier that it isn't the other one, by the noise that it leaves itself."""
    return other.unlikelihood - one.unlikelihood > RULED_OUT_SQUARES * one.refit.rms**2


def _may_help(one: Candidate, other: Candidate) -> bool:
    """Tell whether a candidate is likelier than another one, and leaves less by an amount that matters."""
    return one.unlikelihood < other.unlikelihood and _worth(one, other)


def _worth(one: Candidate, other: Candidate) -> bool:
    return one.refit.squared < WORTH_RMS_SHARE**2 * other.refit.squared


def _needs_more(one: Refit, everything: Refit) -> bool:
    """Tell whether all suspects together leave so much less that one alone (or one pair) can't be all."""
    freedoms = len(everything.values) - len(one.values)
    gained = (one.squared - everything.squared) / max(1.0, everything.squared / everything.freedoms)
    by_chance = float(squares_of_chance(NEEDLESS_CHANCE, freedoms))
    return gained > by_chance and everything.squared < MUCH_LESS_RMS_SHARE**2 * one.squared
