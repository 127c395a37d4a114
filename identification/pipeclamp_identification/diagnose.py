"""Diagnosis: which physical effect a law lacks, told honestly, or which test would tell."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from pipeclamp.catalogue import entries, find_effect
from pipeclamp.errors import UserError
from pipeclamp.law import Structure
from pipeclamp_identification.add import with_effect
from pipeclamp_identification.evidence import LackOfFit
from pipeclamp_identification.fit import Linearised, Progress, linearised, starting_points
from pipeclamp_identification.identify import fit_structure
from pipeclamp_identification.loops import Loops
from pipeclamp_identification.problem import Judged, Problem, judge, prepare, weighed_for

Verdict = Literal["complete", "missing", "ambiguous", "unknown"]

SIGNIFICANT = 1e-3
"""Lack of fit less likely than this under noise alone is real."""
MATERIAL = 0.1
"""Lack of fit below this share of the force noise (rms) isn't worth an effect: it costs half a percent of the floor."""
FORM = 0.1
"""An effect may leave over this share (rms) of what the bare base law lacks: real effects rarely have a catalogue's
exact form."""
EXPLAINS = 0.3
"""A best candidate that leaves over more than this share (rms) of the lack of fit doesn't explain it."""
CLOSE = 0.1
"""A rival stays in the answer's set when resampling the conditions makes it the best in this share of the draws."""
DRAWS = 2000
SCREENED = 8
"""Candidates that the screen lets through to a full fit, at most."""
WORTH_FITTING = 0.01
"""A candidate passes the screen when one step promises this share of what the best promises."""
PAIRED = 3
"""Best candidates that are tried together with a second effect, where one alone doesn't explain."""
FEWEST_RUNS = 4
ABOUT_AS_WELL = 10.0
"""Difference in whitened squares that is no reason for a further slip element."""
MEMORY_SIZES = ("memory", "memory:2", "memory:3")


@dataclass(frozen=True)
class Diagnosis:
    """The answer.

    Attributes:
        verdict: see CONTRACT.md.
        effects: ids, best first.
        law: the law as it is, refitted.
        candidates: every effect that was fitted, best first.
        screened_out: effects that one step showed can't help, with the share of the best's promise.
        pair: the best two effects together, where one alone doesn't explain.
        problem: the data.
        limit: lack of fit, as a share of the force noise, below which a law counts as complete.
        reasons: why the verdict is what it is.
    """

    verdict: Verdict
    effects: tuple[str, ...]
    law: Judged
    candidates: tuple[Judged, ...]
    screened_out: Mapping[str, float]
    pair: Judged | None
    problem: Problem
    limit: float
    reasons: tuple[str, ...]

    @property
    def best(self) -> Judged:
        """The best law that was found: a pair, a candidate, or the law as it is."""
        found: list[Judged] = [self.law, *self.candidates, *([self.pair] if self.pair else [])]
        return min(found, key=lambda judged: judged.squares)


def diagnose(structure: Structure, loops: Loops, *, progress: Progress | None = None) -> Diagnosis:
    """Find which effect a law lacks.

    Args:
        structure: the law's structure; its parameters are refitted.
        loops: the tests.
        progress: is told what is being done.

    Raises:
        UserError: the data can't serve the law, or there are too few runs to tell.
    """
    tell = progress or (lambda _: None)
    if len(loops.run) < FEWEST_RUNS:
        raise UserError(f"{len(loops.run)} runs can't show what a law lacks; expected at least {FEWEST_RUNS}")
    tell("law as it is")
    problem, law = prepare(structure, loops)
    limit = max(MATERIAL, FORM * _bare_lack(structure, problem))
    if _adequate(law.lack, limit):
        reasons = (_scatter_words(law.lack, problem),)
        return Diagnosis("complete", (), law, (), {}, None, problem, limit, reasons)
    problem, law = _weighed_again(problem, law, law)
    promises = _promises(structure, problem, law, tell)
    candidates, screened_out = _candidates(structure, problem, promises, tell)
    if candidates and not candidates[0].objections:
        tell("evidence weighed by the best law's own residuals")
        problem, law = _weighed_again(problem, law, candidates[0])
        candidates = _ranked(_again(judged, problem) for judged in candidates)
    return _verdict(structure, problem, law, candidates, screened_out, limit, tell)


def _weighed_again(problem: Problem, law: Judged, best: Judged) -> tuple[Problem, Judged]:
    """Weigh the data, and judge the law as it is, by noise and discrepancy as the best law so far shows them."""
    weighed = weighed_for(problem, best.result)
    return weighed, _again(law, weighed)


def _again(judged: Judged, problem: Problem) -> Judged:
    """Refit a law to the problem as it is weighted now."""
    law = judged.result.law
    return judge(judged.effects, law.structure, law.values, problem)


def _ranked(judged: Iterable[Judged]) -> list[Judged]:
    return sorted(judged, key=lambda candidate: candidate.squares)


def _bare_lack(structure: Structure, problem: Problem) -> float:
    """Give what the bare base law leaves over, as a share of the force noise; zero where the law is bare."""
    if not structure.effects:
        return 0.0
    bare = replace(structure, effects=())
    return judge((), bare, fit_structure(bare, problem.loops, problem.harmonics).law.values, problem).lack.share


def _adequate(lack: LackOfFit, limit: float) -> bool:
    return lack.p_value > SIGNIFICANT or lack.share < limit


def candidate_names(structure: Structure, conditions: Iterable[str]) -> list[str]:
    """Give the effects that could be missing: those of the catalogue and the user's that the law hasn't got yet.

    Args:
        structure: the law's structure.
        conditions: further columns of the tests.
    """
    present = {effect.id for effect in structure.all_effects()}
    names = []
    for name, entry in entries().items():
        if getattr(entry, "part", None) == "base" or name in ("elastic_series", "damping_series", "condition"):
            continue
        if name == "memory":
            names += [size for size in MEMORY_SIZES if _elements(size) > _elements_present(structure)]
        elif name not in present:
            names.append(name)
    declared = (declaration.id for declaration in structure.declared)
    further = [*(f"condition:{column}" for column in conditions), *declared]
    return names + [name for name in further if name not in structure.effects]


def _elements(name: str) -> int:
    return len(find_effect(name).states)


def _elements_present(structure: Structure) -> int:
    return max((len(effect.states) for effect in structure.all_effects() if effect.id == "memory"), default=0)


def _promises(structure: Structure, problem: Problem, law: Judged, tell: Callable[[str], None]) -> list[_Promise]:
    """Screen every effect by one step; most promising first."""
    promises = []
    for name in candidate_names(structure, problem.loops.conditions):
        tell(f"screen {name}")
        promise = _promise(structure, name, problem, law)
        if promise is not None:
            promises.append(promise)
    return sorted(promises, key=lambda promise: -promise.gain)


def _candidates(
    structure: Structure, problem: Problem, promises: Sequence[_Promise], tell: Callable[[str], None]
) -> tuple[list[Judged], dict[str, float]]:
    """Fit the effects that promise something; best first, and what was screened out."""
    top = promises[0].gain if promises else 0.0
    ids = list(dict.fromkeys(effect_id(promise.name) for promise in promises))[:SCREENED]
    worth = max(WORTH_FITTING * top, 1e-300)
    judged, left = [], {}
    for promise in promises:
        if effect_id(promise.name) in ids and promise.gain >= worth:
            tell(f"fit {promise.name}")
            larger = with_effect(structure, promise.name)
            judged.append(_alive(judge((promise.name,), larger, promise.start, problem), structure, problem))
        else:
            left[promise.name] = promise.gain / top if top > 0 else 0.0
    return _ranked(_simplest(judged)), left


def _simplest(judged: Sequence[Judged]) -> list[Judged]:
    """Keep of each id, of several numbers of elements, the smallest that does about as well as the best."""
    best: dict[str, float] = {}
    for candidate in judged:
        name = effect_id(candidate.effects[-1])
        best[name] = min(best.get(name, np.inf), candidate.squares)
    kept: dict[str, Judged] = {}
    for candidate in sorted(judged, key=lambda candidate: len(candidate.result.fitted)):
        name = effect_id(candidate.effects[-1])
        if name not in kept and candidate.squares <= best[name] + ABOUT_AS_WELL:
            kept[name] = candidate
    return list(kept.values())


def _alive(judged: Judged, structure: Structure, problem: Problem) -> Judged:
    """Give a law of several slip elements without those that came out dead, refitted from the living ones."""
    name = judged.effects[-1]
    states = len(structure.effect(name).states)
    if effect_id(name) != "memory" or states < 2:
        return judged
    values = judged.result.law.values
    living = [index for index in range(1, states + 1) if f"k_s{index}" not in judged.result.at_bound]
    if len(living) in (0, states):
        return judged
    smaller = "memory" if len(living) == 1 else f"memory:{len(living)}"
    start = dict(values)
    for place, index in enumerate(living, 1):
        suffix = "" if len(living) == 1 else str(place)
        start |= {f"k_s{suffix}": values[f"k_s{index}"], f"z_s{suffix}": values[f"z_s{index}"]}
    return judge((*judged.effects[:-1], smaller), with_effect(structure, smaller), start, problem)


@dataclass(frozen=True)
class _Promise:
    """What an effect promises by one step of linear least squares from the best of its starts.

    Attributes:
        name: the effect.
        gain: by how much the step lowers the cost.
        start: the start's values, all of the law's parameters.
        steps: the law with the effect at each of its starts, linearised.
        starts: those starts.
    """

    name: str
    gain: float
    start: Mapping[str, float]
    steps: Sequence[Linearised]
    starts: Sequence[Mapping[str, float]]


def _promise(structure: Structure, name: str, problem: Problem, law: Judged) -> _Promise | None:
    """Give what an effect promises; None if it can't be fitted."""
    try:
        larger = with_effect(structure, name)
        points = starting_points(larger, problem.observations, law.result.law.values)
    except UserError:
        if any(declaration.id == name for declaration in structure.declared):
            raise  # who declares an effect wants to know why it can't be tried
        return None
    steps = [linearised(larger, problem.observations, point) for point in points]
    costs = [step.cost_after_one_step() for step in steps]
    best = int(np.argmin(costs))
    return _Promise(name, law.result.cost - costs[best], points[best], steps, points)


def _beside(promise: _Promise, first: Judged, law: Judged) -> tuple[float, dict[str, float], _Promise]:
    """Give what an effect promises beside another one that has been fitted, where to start them, and the effect.

    What the effect adds to the residuals, and its derivatives, are taken over from where it stood alone.

    Args:
        promise: the effect on the law as it is.
        first: the law with the other effect.
        law: the law as it is.
    """
    jacobian = first.fitted.jacobian.reshape(-1, first.fitted.jacobian.shape[2])
    own = set(first.result.equations.names)
    costs = []
    for step in promise.steps:
        new = [place for place, name in enumerate(step.free) if name not in own]
        together = Linearised(
            first.result.fitted + tuple(step.free[place] for place in new),
            step.residual + (first.fitted.residual - law.fitted.residual).ravel(),
            np.concatenate([jacobian, step.jacobian[:, new]], axis=1),
        )
        costs.append(together.cost_after_one_step())
    best = int(np.argmin(costs))
    return first.result.cost - costs[best], {**promise.starts[best], **first.result.law.values}, promise


def _verdict(
    structure: Structure,
    problem: Problem,
    law: Judged,
    candidates: Sequence[Judged],
    screened_out: Mapping[str, float],
    limit: float,
    tell: Callable[[str], None],
) -> Diagnosis:
    """Weigh the candidates."""
    sound = [candidate for candidate in candidates if not candidate.objections and candidate.squares < law.squares]

    def answer(verdict: Verdict, effects: Iterable[str], pair: Judged | None, *reasons: str) -> Diagnosis:
        names = tuple(dict.fromkeys(effect_id(name) for name in effects))
        return Diagnosis(verdict, names, law, tuple(candidates), screened_out, pair, problem, limit, reasons)

    if not sound:
        return answer("unknown", (), None, "no effect of the catalogue lowers the error on left-out conditions")
    best = sound[0]
    pair = None
    if not _explains(best, law, limit):
        tell("two effects together")
        pair = _best_pair(structure, problem, law, sound, tell)
        if pair is None or not _explains(pair, law, limit):
            return answer("unknown", (), pair, _unexplained_words(best, law))
        members = sorted(pair.effects, key=lambda name: _alone(name, sound))
        return answer(
            "missing", members[:1], pair, f"{' and '.join(pair.effects)} together explain it, one alone doesn't"
        )
    rivals = _rivals(best, sound, problem, limit, law)
    names = [best.effects[0], *(rival.effects[0] for rival in rivals)]
    distinct = list(dict.fromkeys(effect_id(name) for name in names))
    if len(distinct) > 1:
        return answer("ambiguous", distinct, None, f"this data can't tell {' from '.join(distinct)}")
    return answer("missing", distinct, None, f"{best.effects[0]} explains it and no rival comes near")


def effect_id(name: str) -> str:
    """Give the name that stays: with its argument for a condition, without for the number of memory elements."""
    identifier = name.partition(":")[0]
    return name if identifier == "condition" else identifier


def _explains(candidate: Judged, law: Judged, limit: float) -> bool:
    return _adequate(candidate.lack, limit) or candidate.lack.share < EXPLAINS * law.lack.share


def _alone(name: str, sound: Sequence[Judged]) -> float:
    return min((candidate.squares for candidate in sound if candidate.effects == (name,)), default=np.inf)


def _best_pair(
    structure: Structure,
    problem: Problem,
    law: Judged,
    sound: Sequence[Judged],
    tell: Callable[[str], None],
) -> Judged | None:
    """Fit the best candidates together with the second effects that promise most; give the best sound pair."""
    pairs: list[Judged] = []
    seen: set[frozenset[str]] = set()
    promises = _promises(structure, problem, law, tell)
    for first in _distinct(sound)[:PAIRED]:
        larger = with_effect(structure, first.effects[0])
        beside = [
            _beside(promise, first, law)
            for promise in promises
            if effect_id(promise.name) != effect_id(first.effects[0]) and _fits_beside(larger, promise.name)
        ]
        tried: set[str] = set()
        for _, start, second in sorted(beside, key=lambda entry: -entry[0]):
            both = frozenset((effect_id(first.effects[0]), effect_id(second.name)))
            if both in seen or len(tried) == PAIRED:
                continue
            tried.add(second.name)
            tell(f"fit {first.effects[0]} and {second.name}")
            effects = (first.effects[0], second.name)
            pairs.append(judge(effects, with_effect(larger, second.name), start, problem))
        seen |= {frozenset((effect_id(first.effects[0]), effect_id(name))) for name in tried}
    usable = [pair for pair in pairs if not pair.objections]
    return min(usable, key=lambda pair: pair.squares, default=None)


def _fits_beside(structure: Structure, name: str) -> bool:
    """Tell whether an effect can be added to a law that another effect has joined."""
    try:
        with_effect(structure, name)
    except UserError:
        return False
    return True


def _distinct(judged: Sequence[Judged]) -> list[Judged]:
    """Give the best of each id: numbers of memory elements don't rival one another."""
    best: dict[str, Judged] = {}
    for candidate in judged:
        best.setdefault(effect_id(candidate.effects[0]), candidate)
    return list(best.values())


def _rivals(best: Judged, sound: Sequence[Judged], problem: Problem, limit: float, law: Judged) -> list[Judged]:
    """Find who can't be told from the best: one standard error away, or best in many resampled sets of conditions."""
    others = [candidate for candidate in sound if candidate is not best and _explains(candidate, law, limit)]
    if not others:
        return []
    random = np.random.default_rng(0)
    count = len(best.score.squares)
    weights = random.multinomial(count, np.full(count, 1 / count), size=DRAWS)
    totals = weights @ np.stack([candidate.score.squares for candidate in (best, *others)], axis=1)
    wins = np.bincount(np.argmin(totals, axis=1), minlength=1 + len(others)) / DRAWS
    rivals = []
    for place, candidate in enumerate(others, 1):
        difference = candidate.score.squares - best.score.squares
        error = np.sqrt(count * np.var(difference, ddof=1)) if count > 1 else np.inf
        if difference.sum() <= error or wins[place] >= CLOSE:
            rivals.append(candidate)
    return rivals


def _scatter_words(lack: LackOfFit, problem: Problem) -> str:
    return (
        f"what follows the conditions is {lack.share:.1%} of the force noise; the rest is scatter: cycle noise, and "
        f"{problem.noise.stiffness_scatter:.2%} of stiffness and {problem.noise.damping_scatter:.2%} of damping from "
        "run to run"
    )


def _unexplained_words(best: Judged, law: Judged) -> str:
    left = best.lack.share / law.lack.share
    return f"the best of the catalogue, {best.effects[0]}, leaves {left:.0%} of what is missing (rms) unexplained"
