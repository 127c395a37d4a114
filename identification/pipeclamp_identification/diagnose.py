"""Diagnosis: which physical effect a law lacks, told honestly, or which test would tell."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from pipeclamp.errors import UserError
from pipeclamp.law import Structure
from pipeclamp_identification.add import with_effect
from pipeclamp_identification.evidence import LackOfFit
from pipeclamp_identification.fit import Progress, fit, linearised, starting_points
from pipeclamp_identification.identify import fit_structure
from pipeclamp_identification.loops import Loops
from pipeclamp_identification.problem import Contender, Judged, Problem, judge, judge_each, prepare, weighed_for
from pipeclamp_identification.screen import Promise, beside, effect_id, fits_beside, screened

Verdict = Literal["complete", "missing", "ambiguous", "unknown"]

SIGNIFICANT = 1e-3
"""Lack of fit less likely than this under noise alone is real."""
MATERIAL = 0.1
"""Lack of fit below this share of the force noise (rms) isn't worth an effect: it costs half a percent of the floor."""
PRECISE = 2e-4
"""Nor is what lies below this share of the force (rms): few load cells are truer."""
FORM = 0.1
"""An effect may leave over this share (rms) of what the bare base law lacks: real effects rarely have a catalogue's
exact form."""
MOST_FORM = 1.0
"""But a law that leaves over more than the force noise itself is not complete, whatever its effects' form."""
EXPLAINS = 0.3
"""A best candidate that leaves over more than this share (rms) of the lack of fit doesn't explain it."""
ALONE = EXPLAINS**2
"""Of two effects that explain it together, the one to name must explain this share (mean square) alone: two that do so
only against each other are terms of a series, not physics."""
CLOSE = 0.1
"""A rival stays in the answer's set when resampling the runs makes it the best in this share of the draws."""
DRAWS = 2000
AS_LIKELY = 2 * np.log(100.0)
"""A rival also stays when the fit to all data leaves it a hundredth of the best's likelihood: where few conditions were
tested, leaving one out asks for what the rest can't tell, and its errors aren't evidence."""
SCREENED = 8
"""Candidates that the screen lets through to a full fit, at most."""
WORTH_FITTING = 0.01
"""A candidate passes the screen when one step promises this share of what the best promises."""
PAIRED = 3
"""Best candidates that are tried together with a second effect, where one alone doesn't explain."""
FEWEST_RUNS = 4
MOST_ELEMENTS = 3
"""Slip elements up to which a spread of slip forces is resolved."""
VALLEYS = 2
"""Starts from which a further slip element is fitted, those that promise most: the error has valleys between them."""
ABOUT_AS_WELL = 10.0
"""Difference in squares on left-out groups that is no reason for a further slip element."""


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
        verdict: see CONTRACT.md.
        effects: ids, best first.
        law: the law as it is, refitted.
        candidates: every effect that was fitted, best first.
        screened_out: effects that one step showed can't help, with the share of the best's promise.
        pair: the best two effects together, where one alone doesn't explain.
        problem: the data.
        tolerance: lack of fit that is let pass.
        reasons: why the verdict is what it is.
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

    @property
    def best(self) -> Judged:
        """The best law that was found: a pair, a candidate, or the law as it is."""
        found: list[Judged] = [self.law, *self.candidates, *([self.pair] if self.pair else [])]
        return min(found, key=lambda judged: judged.squares)

    def is_adequate(self, judged: Judged) -> bool:
        """Tell whether nothing that a law leaves over follows the conditions."""
        return _adequate(judged.lack, self.tolerance)


def diagnose(structure: Structure, loops: Loops, *, jobs: int = 1, progress: Progress | None = None) -> Diagnosis:
    """Find which effect a law lacks.

    Args:
        structure: the law's structure; its parameters are refitted.
        loops: the tests.
        jobs: processes that fit the candidates of a large campaign; -1 for as many as there are cores.
        progress: is told what is being done.

    Raises:
        UserError: the data can't serve the law, or there are too few runs to tell.
    """
    tell = progress or (lambda _: None)
    if len(loops.run) < FEWEST_RUNS:
        raise UserError(f"{len(loops.run)} runs can't show what a law lacks; expected at least {FEWEST_RUNS}")
    tell("law as it is")
    problem, law = prepare(structure, loops)
    form = FORM * _bare_lack(structure, problem)
    tolerance = Tolerance(max(MATERIAL, _precision(loops), min(form, MOST_FORM)), form)
    if _complete(law, problem, tolerance):
        reasons = (_scatter_words(law.lack, problem),)
        return Diagnosis("complete", (), law, (), {}, None, problem, tolerance, reasons)
    problem, law = _weighed_again(problem, law, law)
    promises = screened(structure, problem, law, tell)
    candidates, screened_out = _candidates(structure, problem, promises, jobs, tell)
    if candidates and not candidates[0].objections:
        tell("evidence weighed by the best law's own residuals")
        problem, law = _weighed_again(problem, law, _likeliest(candidates))
        candidates = _ranked(judge_each([_as_it_is(judged) for judged in candidates], problem, jobs, tell))
    return _verdict(structure, problem, law, candidates, screened_out, tolerance, jobs, tell)


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
    return PRECISE * float(np.sqrt(np.sum(loops.force_rms_N**2) / np.sum(loops.noise_rms_N**2)))


def _adequate(lack: LackOfFit, tolerance: Tolerance) -> bool:
    return lack.p_value > SIGNIFICANT or lack.share < tolerance.complete


def _complete(law: Judged, problem: Problem, tolerance: Tolerance) -> bool:
    """Tell whether what a law leaves over is scatter, and such as rigs have."""
    immaterial = law.lack.share < tolerance.complete
    return _adequate(law.lack, tolerance) and (immaterial or not problem.noise.is_no_rigs)


def _candidates(
    structure: Structure, problem: Problem, promises: Sequence[Promise], jobs: int, tell: Callable[[str], None]
) -> tuple[list[Judged], dict[str, float]]:
    """Fit the effects that promise something; best first, and what was screened out."""
    top = promises[0].gain if promises else 0.0
    ids = list(dict.fromkeys(effect_id(promise.name) for promise in promises))[:SCREENED]
    worth = max(WORTH_FITTING * top, 1e-300)
    chosen = [promise for promise in promises if effect_id(promise.name) in ids and promise.gain >= worth]
    left = {promise.name: promise.gain / top if top > 0 else 0.0 for promise in promises if promise not in chosen}
    contenders = [Contender((promise.name,), with_effect(structure, promise.name), promise.start) for promise in chosen]
    judged = _ranked(judge_each(contenders, problem, jobs, tell))
    return _ranked([*(_grown(each, structure, problem, tell) for each in judged[:PAIRED]), *judged[PAIRED:]]), left


def _grown(judged: Judged, structure: Structure, problem: Problem, tell: Callable[[str], None]) -> Judged:
    """Give a law with slip elements as many of them as the data asks for: one more while each does clearly better."""
    name = next((name for name in judged.effects if effect_id(name) == "memory"), None)
    count = len(structure.effect(name).states) if name else MOST_ELEMENTS
    while name and count < MOST_ELEMENTS:
        count += 1
        more = f"memory:{count}"
        effects = tuple(more if effect == name else effect for effect in judged.effects)
        tell(f"fit {' and '.join(effects)}")
        larger = structure
        for effect in effects:
            larger = with_effect(larger, effect)
        starts = [*starting_points(larger, problem.observations, _shared(judged)), _split(judged, count)]
        starts.sort(key=lambda point: linearised(larger, problem.observations, point).cost_after_one_step())
        fits = [fit(larger, problem.observations, start=start) for start in starts[:VALLEYS]]
        start = min(fits, key=lambda result: result.cost).law.values
        grown = judge(effects, larger, start, problem)
        if grown.objections or grown.squares > judged.squares - ABOUT_AS_WELL:
            break
        judged, name = grown, more
    return judged


def _shared(judged: Judged) -> dict[str, float]:
    """Give a law's values but for its slip elements'."""
    return {key: value for key, value in judged.result.law.values.items() if not key.startswith(("k_s", "z_s"))}


def _split(judged: Judged, count: int) -> dict[str, float]:
    """Give values for so many slip elements, one more than a law has: its strongest one in two, early and late."""
    values = judged.result.law.values
    suffixes = [""] if count == 2 else [str(number) for number in range(1, count)]
    elements = sorted(
        ((values[f"k_s{suffix}"], values[f"z_s{suffix}"]) for suffix in suffixes), key=lambda each: each[1]
    )
    stiffness, slip = elements.pop()
    elements += [(stiffness / 2, share * slip / 2) for share in (0.5, 1.5)]
    return _shared(judged) | {
        f"{symbol}{number}": value
        for number, element in enumerate(elements, 1)
        for symbol, value in zip(("k_s", "z_s"), element, strict=True)
    }


def _verdict(
    structure: Structure,
    problem: Problem,
    law: Judged,
    candidates: Sequence[Judged],
    screened_out: Mapping[str, float],
    tolerance: Tolerance,
    jobs: int,
    tell: Callable[[str], None],
) -> Diagnosis:
    """Weigh the candidates."""
    sound = [candidate for candidate in candidates if not candidate.objections and _betters(candidate, law)]

    def answer(verdict: Verdict, effects: Iterable[str], pair: Judged | None, *reasons: str) -> Diagnosis:
        names = tuple(dict.fromkeys(effect_id(name) for name in effects))
        return Diagnosis(verdict, names, law, tuple(candidates), screened_out, pair, problem, tolerance, reasons)

    if _adequate(law.lack, tolerance):
        if _complete(law, problem, tolerance):
            return answer("complete", (), None, _scatter_words(law.lack, problem))
        return answer("unknown", (), None, _few_runs_words(law.lack, problem))
    if not sound:
        return answer("unknown", (), None, "no effect of the catalogue lowers the error on left-out conditions")
    likeliest = _likeliest(sound)
    # One effect that explains it is nearer than two, even where left-out conditions prefer one of the two.
    best = likeliest if _explains(likeliest, law, tolerance) and not _explains(sound[0], law, tolerance) else sound[0]
    pair = None
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
    names = [best.effects[0], *(rival.effects[0] for rival in rivals)]
    distinct = list(dict.fromkeys(effect_id(name) for name in names))
    if len(distinct) > 1:
        return answer("ambiguous", distinct, None, f"this data can't tell {' from '.join(distinct)}")
    return answer("missing", distinct, None, f"{best.effects[0]} explains it and no rival comes near")


def _explains(candidate: Judged, law: Judged, tolerance: Tolerance) -> bool:
    left, missing = candidate.lack.sure_share, law.lack.share
    return _adequate(candidate.lack, tolerance) or left < EXPLAINS * missing or left < tolerance.form < missing


def _betters(candidate: Judged, law: Judged) -> bool:
    """Tell whether an effect betters the law: on left-out conditions, or by the fit to all data beyond doubt."""
    return candidate.squares < law.squares or candidate.akaike + AS_LIKELY < law.akaike


def _first_of_pairs(pairs: Sequence[Judged], sound: Sequence[Judged], law: Judged, tolerance: Tolerance) -> list[str]:
    """Give the better effect of the best pair, and of each pair without it that is as likely."""
    firsts: list[str] = []
    for pair in pairs:
        names = list(dict.fromkeys(effect_id(name) for name in pair.effects))
        as_likely = pair.akaike - pairs[0].akaike < AS_LIKELY and _explains(pair, law, tolerance)
        if as_likely and not set(names) & set(firsts):
            firsts.append(min(names, key=lambda name: _alone(name, sound)))
    return firsts


def _alone(name: str, sound: Sequence[Judged]) -> float:
    same = (candidate.squares for candidate in sound if effect_id(candidate.effects[0]) == effect_id(name))
    return min(same, default=np.inf)


def _helps_alone(name: str, sound: Sequence[Judged], law: Judged) -> bool:
    """Tell whether an effect explains something of the lack of fit without a second one."""
    excess = (one.lack.excess for one in sound if effect_id(one.effects[0]) == effect_id(name))
    return min(excess, default=np.inf) < (1 - ALONE) * law.lack.excess


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
    for first in _distinct(sound)[:PAIRED]:
        larger = with_effect(structure, first.effects[0])
        seconds = [
            beside(promise, first, law)
            for promise in promises
            if effect_id(promise.name) != effect_id(first.effects[0]) and fits_beside(larger, promise.name)
        ]
        tried: set[str] = set()
        for _, start, second in sorted(seconds, key=lambda entry: -entry[0]):
            both = frozenset((effect_id(first.effects[0]), effect_id(second.name)))
            if both in seen or len(tried) == PAIRED:
                continue
            tried.add(second.name)
            contenders.append(Contender((first.effects[0], second.name), with_effect(larger, second.name), start))
        seen |= {frozenset((effect_id(first.effects[0]), effect_id(name))) for name in tried}
    usable = [pair for pair in judge_each(contenders, problem, jobs, tell) if not pair.objections]
    ranked = _ranked(usable)
    return [_grown(pair, structure, problem, tell) for pair in ranked[:1]] + ranked[1:]


def _distinct(judged: Sequence[Judged]) -> list[Judged]:
    """Give the best of each id: numbers of memory elements don't rival one another."""
    best: dict[str, Judged] = {}
    for candidate in judged:
        best.setdefault(effect_id(candidate.effects[0]), candidate)
    return list(best.values())


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
        as_likely = candidate.akaike - best.akaike < AS_LIKELY
        if difference.sum() <= error or wins[place] >= CLOSE or as_likely:
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
