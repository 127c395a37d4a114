"""Diagnosis: which physical effect a law lacks, told honestly, or which test would tell."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from pipeclamp_identification.campaign.reading import Campaign
from pipeclamp_identification.diagnosis.evidence import LackOfFit
from pipeclamp_identification.diagnosis.leftover import Leftover, describe
from pipeclamp_identification.diagnosis.problem import (
    Contender,
    Judged,
    Problem,
    judge,
    judge_each,
    prepare,
    weighed_for,
)
from pipeclamp_identification.diagnosis.screen import Promise, beside, fits_beside, screened
from pipeclamp_identification.diagnosis.thresholds import (
    ALONE_SHARE,
    FEWEST_RUNS,
    FORM_SHARE,
    LARGER_MEMBER_SQUARES,
    MATERIAL_FORCE_SHARE,
    MATERIAL_NOISE_SHARE,
    MOST_FORM_NOISE_SHARE,
    REAL_LACK_CHANCE,
    RIVAL_DRAWS_SHARE,
    RIVAL_LIKELIHOOD,
    UNEXPLAINED_SHARE,
    WORTH_FITTING_SHARE,
)
from pipeclamp_identification.fitting.identify import fit_structure
from pipeclamp_identification.fitting.least_squares import fit, linearised
from pipeclamp_identification.fitting.misfit import RunMisfit, misfits
from pipeclamp_identification.fitting.refinement import refined_starts
from pipeclamp_identification.loops.loops import Loops, loops_of
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.progress import Progress
from pipeclamp_models.law.catalogue import effect_id
from pipeclamp_models.law.law import Structure, with_effect

Verdict = Literal["complete", "missing", "ambiguous", "unknown"]

DRAWS = 2000
MOST_FITTED = 8
"""Candidates that the screen lets through to a full fit, at most."""
MOST_PAIRED = 3
"""Best candidates that are tried together with a second effect, where one alone doesn't explain."""
VALLEYS = 2
"""Starts from which a larger member is fitted, those that promise most: the error has valleys between them."""


@dataclass(frozen=True)
class Tolerance:
    """Lack of fit that is let pass, as shares of the force noise.

    Attributes:
        complete: below this a law counts as complete.
        form: below this an effect counts as explained, be its form not quite the catalogue's.
    """

    complete: float
    form: float


@dataclass(frozen=True)
class Diagnosis:
    """The answer.

    Attributes:
        verdict: complete, missing, ambiguous or unknown; what is locked to time, or to several cycles, is no scatter: a
            law that leaves it over isn't complete.
        effects: what is missing, or may be, as it was judged; best first.
        law: the law as it is, refitted.
        candidates: every effect that was fitted, best first.
        screened_out: effects that one step showed can't help, with the share of the best's promise.
        pair: the best two effects together, where one alone doesn't explain.
        problem: the data.
        tolerance: lack of fit that is let pass.
        reasons: why the verdict is what it is.
        best_misfits: error of the best law on every run.
        leftover: what the best law leaves over.
    """

    verdict: Verdict
    effects: tuple[str, ...]
    law: Judged
    candidates: tuple[Judged, ...]
    screened_out: Mapping[str, float]
    pair: Judged | None
    problem: Problem
    tolerance: Tolerance
    reasons: tuple[str, ...]
    best_misfits: tuple[RunMisfit, ...]
    leftover: Leftover

    @property
    def best(self) -> Judged:
        """The best law that was found: a pair, a candidate, or the law as it is."""
        return _best(self.law, self.candidates, self.pair)

    def is_adequate(self, judged: Judged) -> bool:
        """Tell whether nothing that a law leaves over follows the conditions."""
        return _adequate(judged.lack, self.tolerance)


def diagnose(
    structure: Structure,
    campaign: Campaign,
    loops: Loops | None = None,
    *,
    jobs: int = 1,
    progress: Progress | None = None,
) -> Diagnosis:
    """Find which effect a law lacks.

    Args:
        structure: the law's structure; its parameters are refitted.
        campaign: the tests.
        loops: `loops_of(campaign)`, where they are known already.
        jobs: processes that fit the candidates of a large campaign; -1 for as many as there are cores.
        progress: is told what is being done.

    Raises:
        UserError: the data can't serve the law, or there are too few runs to tell.
    """
    tell = progress or (lambda _: None)
    loops = loops or loops_of(campaign)
    if len(loops.run) < FEWEST_RUNS:
        raise UserError(f"{len(loops.run)} runs can't show what a law lacks; expected at least {FEWEST_RUNS}")
    tell("law as it is")
    problem, law = prepare(structure, loops)
    form = FORM_SHARE * _bare_lack(structure, problem)
    tolerance = Tolerance(max(MATERIAL_NOISE_SHARE, _precision(loops), min(form, MOST_FORM_NOISE_SHARE)), form)
    candidates: list[Judged] = []
    screened_out: dict[str, float] = {}
    if not _complete(law, problem, tolerance):
        problem, law = _weighed_again(problem, law, law)
        promises = screened(structure, problem, law, tell)
        candidates, screened_out = _candidates(structure, problem, promises, jobs, tell)
        if candidates and not candidates[0].objections:
            tell("evidence weighed by the best law's own residuals")
            problem, law = _weighed_again(problem, law, _likeliest(candidates))
            candidates = _ranked(judge_each([_as_it_is(judged) for judged in candidates], problem, jobs, tell))
    found = _weigh(structure, problem, law, candidates, tolerance, jobs, tell)
    tell("what is left over")
    best = _best(law, candidates, found.pair)
    best_misfits = misfits(best.result.law, campaign, loops)
    leftover = describe(best, problem, campaign, best_misfits)
    verdict = "unknown" if found.verdict == "complete" and leftover.not_periodic else found.verdict
    return Diagnosis(
        verdict, found.effects, law, tuple(candidates), screened_out, found.pair, problem, tolerance, found.reasons,
        best_misfits, leftover,
    )  # fmt: skip


def _best(law: Judged, candidates: Sequence[Judged], pair: Judged | None) -> Judged:
    return min([law, *candidates, *([pair] if pair else [])], key=lambda judged: judged.squares)


def _weighed_again(problem: Problem, law: Judged, best: Judged) -> tuple[Problem, Judged]:
    """Weigh the data, and judge the law as it is, by noise and discrepancy as the best law so far shows them."""
    weighed = weighed_for(problem, best.result)
    return weighed, judge((), law.result.law.structure, law.result.law.values, weighed)


def _as_it_is(judged: Judged) -> Contender:
    """Give a law for judging it once more, from its own values."""
    return Contender(judged.effects, judged.result.law.structure, judged.result.law.values)


def _ranked(judged: Iterable[Judged]) -> list[Judged]:
    return sorted(judged, key=lambda candidate: candidate.squares)


def _likeliest(candidates: Iterable[Judged]) -> Judged:
    """Give the candidate that the fit to all data prefers, of those that nothing speaks against."""
    return min((each for each in candidates if not each.objections), key=lambda each: each.akaike)


def _bare_lack(structure: Structure, problem: Problem) -> float:
    """Give what the bare base law leaves over, as a share of the force noise; zero where the law is bare."""
    if not structure.effects:
        return 0.0
    bare = replace(structure, effects=())
    return judge((), bare, fit_structure(bare, problem.loops, problem.harmonics).law.values, problem).lack.share


def _precision(loops: Loops) -> float:
    """Give the force below which nothing can be told, as a share of the force noise."""
    return MATERIAL_FORCE_SHARE * float(np.sqrt(np.sum(loops.force_rms_N**2) / np.sum(loops.noise_rms_N**2)))


def _adequate(lack: LackOfFit, tolerance: Tolerance) -> bool:
    return lack.p_value > REAL_LACK_CHANCE or lack.share < tolerance.complete


def _complete(law: Judged, problem: Problem, tolerance: Tolerance) -> bool:
    """Tell whether what a law leaves over is scatter, and such as rigs have."""
    immaterial = law.lack.share < tolerance.complete
    return _adequate(law.lack, tolerance) and (immaterial or not problem.noise.is_no_rigs)


def _candidates(
    structure: Structure, problem: Problem, promises: Sequence[Promise], jobs: int, tell: Callable[[str], None]
) -> tuple[list[Judged], dict[str, float]]:
    """Fit the effects that promise something; best first, and what was screened out."""
    top = promises[0].gain if promises else 0.0
    ids = list(dict.fromkeys(effect_id(promise.name) for promise in promises))[:MOST_FITTED]
    worth = max(WORTH_FITTING_SHARE * top, 1e-300)
    chosen = [promise for promise in promises if effect_id(promise.name) in ids and promise.gain >= worth]
    left = {promise.name: promise.gain / top if top > 0 else 0.0 for promise in promises if promise not in chosen}
    contenders = [Contender((promise.name,), with_effect(structure, promise.name), promise.start) for promise in chosen]
    judged = _ranked(judge_each(contenders, problem, jobs, tell))
    return _ranked(
        [*(_grown(each, structure, problem, tell) for each in judged[:MOST_PAIRED]), *judged[MOST_PAIRED:]]
    ), left


def _grown(judged: Judged, structure: Structure, problem: Problem, tell: Callable[[str], None]) -> Judged:
    """Give a law with added effects' members as large as the data ask for: larger while each does clearly better."""
    for place in range(len(judged.effects)):
        while (larger := _with_larger(judged, place, structure, problem, tell)) is not None:
            judged = larger
    return judged


def _with_larger(
    judged: Judged, place: int, structure: Structure, problem: Problem, tell: Callable[[str], None]
) -> Judged | None:
    """Give a law with the next larger member of one of its added effects; None where it doesn't do clearly better."""
    smaller = structure.effect(judged.effects[place])
    if smaller.refinement is None or not smaller.refinement.at_once:
        return None
    effects = (*judged.effects[:place], smaller.refinement.name, *judged.effects[place + 1 :])
    tell(f"fit {' and '.join(effects)}")
    larger = structure
    for effect in effects:
        larger = with_effect(larger, effect)
    starts = refined_starts(larger, smaller, problem.observations, judged.result.law.values)
    starts.sort(key=lambda point: linearised(larger, problem.observations, point).cost_after_one_step())
    fits = [fit(larger, problem.observations, start=start) for start in starts[:VALLEYS]]
    start = min(fits, key=lambda result: result.cost).law.values
    grown = judge(effects, larger, start, problem)
    return None if grown.objections or grown.squares > judged.squares - LARGER_MEMBER_SQUARES else grown


@dataclass(frozen=True)
class _Weighed:
    """What the candidates make of the verdict, but for what doesn't repeat with each cycle; see `Diagnosis`."""

    verdict: Verdict
    effects: tuple[str, ...]
    pair: Judged | None
    reasons: tuple[str, ...]


def _weigh(
    structure: Structure,
    problem: Problem,
    law: Judged,
    candidates: Sequence[Judged],
    tolerance: Tolerance,
    jobs: int,
    tell: Callable[[str], None],
) -> _Weighed:
    """Weigh the candidates."""

    def answer(verdict: Verdict, effects: Iterable[str], pair: Judged | None, *reasons: str) -> _Weighed:
        return _Weighed(verdict, tuple(effects), pair, reasons)

    if _adequate(law.lack, tolerance):
        if _complete(law, problem, tolerance):
            return answer("complete", (), None, _scatter_words(law.lack, problem))
        return answer("unknown", (), None, _few_runs_words(law.lack, problem))
    sound = [candidate for candidate in candidates if not candidate.objections and _betters(candidate, law)]
    if not sound:
        return answer("unknown", (), None, "no effect of the catalogue lowers the error on left-out conditions")
    likeliest = _likeliest(sound)
    # One effect that explains it is nearer than two, even where left-out conditions prefer one of the two.
    best = likeliest if _explains(likeliest, law, tolerance) and not _explains(sound[0], law, tolerance) else sound[0]
    if not _explains(best, law, tolerance):
        tell("two effects together")
        pairs = _pairs(structure, problem, law, sound, jobs, tell)
        pair = pairs[0] if pairs else None
        if pair is None or not _explains(pair, law, tolerance):
            return answer("unknown", (), pair, _unexplained_words(best, law))
        together = f"{' and '.join(pair.effects)} together explain it, one alone doesn't"
        firsts = [name for name in _first_of_pairs(pairs, sound, law, tolerance) if _helps_alone(name, sound, law)]
        if not firsts:
            return answer("unknown", (), pair, f"{together}; they cancel each other, and neither helps by itself")
        if len(firsts) > 1:
            return answer("ambiguous", firsts, pair, f"{together}; which comes first, {' or '.join(firsts)}, is open")
        return answer("missing", firsts, pair, together)
    rivals = _rivals(best, sound, problem, tolerance, law)
    names = distinct([best.effects[0], *(rival.effects[0] for rival in rivals)])
    if len(names) > 1:
        return answer("ambiguous", names, None, f"this data can't tell {' from '.join(names)}")
    return answer("missing", names, None, f"{best.effects[0]} explains it and no rival comes near")


def distinct(names: Iterable[str]) -> tuple[str, ...]:
    """Give the first name of each id: members of one numbered family don't rival one another."""
    first: dict[str, str] = {}
    for name in names:
        first.setdefault(effect_id(name), name)
    return tuple(first.values())


def _explains(candidate: Judged, law: Judged, tolerance: Tolerance) -> bool:
    left, missing = candidate.lack.sure_share, law.lack.share
    return _adequate(candidate.lack, tolerance) or left < UNEXPLAINED_SHARE * missing or left < tolerance.form < missing


def _betters(candidate: Judged, law: Judged) -> bool:
    """Tell whether an effect betters the law: on left-out conditions, or by the fit to all data beyond doubt."""
    return candidate.squares < law.squares or candidate.akaike + RIVAL_LIKELIHOOD < law.akaike


def _first_of_pairs(pairs: Sequence[Judged], sound: Sequence[Judged], law: Judged, tolerance: Tolerance) -> list[str]:
    """Give the better effect of the best pair, and of each pair without it that is as likely."""
    firsts: list[str] = []
    for pair in pairs:
        taken = {effect_id(name) for name in firsts}
        as_likely = pair.akaike - pairs[0].akaike < RIVAL_LIKELIHOOD and _explains(pair, law, tolerance)
        if as_likely and not taken & {effect_id(name) for name in pair.effects}:
            firsts.append(min(pair.effects, key=lambda name: _alone(name, sound)))
    return firsts


def _alone(name: str, sound: Sequence[Judged]) -> float:
    same = (candidate.squares for candidate in sound if effect_id(candidate.effects[0]) == effect_id(name))
    return min(same, default=np.inf)


def _helps_alone(name: str, sound: Sequence[Judged], law: Judged) -> bool:
    """Tell whether an effect explains something of the lack of fit without a second one."""
    excess = (one.lack.excess for one in sound if effect_id(one.effects[0]) == effect_id(name))
    return min(excess, default=np.inf) < (1 - ALONE_SHARE) * law.lack.excess


def _pairs(
    structure: Structure,
    problem: Problem,
    law: Judged,
    sound: Sequence[Judged],
    jobs: int,
    tell: Callable[[str], None],
) -> list[Judged]:
    """Fit the best candidates together with the second effects that promise most; give the sound pairs, best first."""
    contenders: list[Contender] = []
    seen: set[frozenset[str]] = set()
    promises = screened(structure, problem, law, tell)
    for first in _best_of_each(sound)[:MOST_PAIRED]:
        larger = with_effect(structure, first.effects[0])
        seconds = [
            beside(promise, first, law)
            for promise in promises
            if effect_id(promise.name) != effect_id(first.effects[0]) and fits_beside(larger, promise.name)
        ]
        tried: set[str] = set()
        for _, start, second in sorted(seconds, key=lambda entry: -entry[0]):
            both = frozenset((effect_id(first.effects[0]), effect_id(second.name)))
            if both in seen or len(tried) == MOST_PAIRED:
                continue
            tried.add(second.name)
            contenders.append(Contender((first.effects[0], second.name), with_effect(larger, second.name), start))
        seen |= {frozenset((effect_id(first.effects[0]), effect_id(name))) for name in tried}
    usable = [pair for pair in judge_each(contenders, problem, jobs, tell) if not pair.objections]
    ranked = _ranked(usable)
    return [_grown(pair, structure, problem, tell) for pair in ranked[:1]] + ranked[1:]


def _best_of_each(judged: Sequence[Judged]) -> list[Judged]:
    """Give the best of each id, of candidates that are ranked."""
    names = distinct(candidate.effects[0] for candidate in judged)
    return [candidate for candidate in judged if candidate.effects[0] in names]


def _rivals(best: Judged, sound: Sequence[Judged], problem: Problem, tolerance: Tolerance, law: Judged) -> list[Judged]:
    """Find who can't be told from the best: by left-out conditions, resampled ones, or the fit to all data."""
    others = [candidate for candidate in sound if candidate is not best and _explains(candidate, law, tolerance)]
    if not others:
        return []
    random = np.random.default_rng(0)
    squares = np.stack([each.squares_by_run(problem.loops) for each in (best, *others)], axis=1)
    count = len(squares)
    weights = random.multinomial(count, np.full(count, 1 / count), size=DRAWS)
    wins = np.bincount(np.argmin(weights @ squares, axis=1), minlength=1 + len(others)) / DRAWS
    rivals = []
    for place, candidate in enumerate(others, 1):
        difference = squares[:, place] - squares[:, 0]
        error = np.sqrt(count * np.var(difference, ddof=1)) if count > 1 else np.inf
        as_likely = candidate.akaike - best.akaike < RIVAL_LIKELIHOOD
        if difference.sum() <= error or wins[place] >= RIVAL_DRAWS_SHARE or as_likely:
            rivals.append(candidate)
    return rivals


def _scatter_words(lack: LackOfFit, problem: Problem) -> str:
    return (
        f"what follows the conditions is {lack.share:.1%} of the force noise; the rest doesn't follow them: noise, and "
        f"{problem.noise.stiffness_scatter:.2%} of stiffness and {problem.noise.damping_scatter:.2%} of damping from "
        "run to run"
    )


def _few_runs_words(lack: LackOfFit, problem: Problem) -> str:
    return (
        f"{_scatter_words(lack, problem)}: more than rigs have, and these {len(problem.loops.run)} runs are too few to "
        "tell it from physics; repeat some of them three times each"
    )


def _unexplained_words(best: Judged, law: Judged) -> str:
    left = best.lack.share / law.lack.share
    return f"the best of the catalogue, {best.effects[0]}, leaves {left:.0%} of what is missing (rms) unexplained"
