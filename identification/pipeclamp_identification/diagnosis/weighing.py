"""What the candidates make of the verdict: a cause, a part, rivals that can't be told apart, or nothing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pipeclamp_identification.diagnosis.between_levels import worst_level
from pipeclamp_identification.diagnosis.candidates import best_of_each, distinct, likeliest, pairs, ranked
from pipeclamp_identification.diagnosis.channel import BentChannel, bent_channel
from pipeclamp_identification.diagnosis.foretold import explained_share, foretold, takes_part
from pipeclamp_identification.diagnosis.problem import Judged, Problem, without_essence
from pipeclamp_identification.diagnosis.reasons import (
    between_words,
    few_runs_words,
    foretold_words,
    form_words,
    hidden_words,
    immaterial_words,
    pair_words,
    scatter_words,
)
from pipeclamp_identification.diagnosis.repeats import Unstated
from pipeclamp_identification.diagnosis.screen import Promise, beside, fits, fits_beside, screened
from pipeclamp_identification.diagnosis.thresholds import (
    ALONE_SHARE,
    FORM_NOISE_SHARE,
    HALF_TAKEN_SHARE,
    MATERIAL_PART_SHARE,
    NEAR_NOISE_SHARE,
    RIVAL_DRAWS_SHARE,
    RIVAL_LIKELIHOOD,
    SAME_PART_SHARE,
)
from pipeclamp_identification.diagnosis.tolerance import Tolerance, explains, is_adequate, is_complete, may_be_form
from pipeclamp_identification.fitting.resampling import DRAWS, draws
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.equations.effect import Effect
from pipeclamp_models.law.catalogue import effect_id
from pipeclamp_models.law.file import Kind, Verdict
from pipeclamp_models.law.law import Structure, with_effect

BEYOND_COMPARISON = 1e200
"""Squares that count as infinite, but none of them as nothing."""


@dataclass(frozen=True)
class Weighed:
    """What the candidates make of the verdict, but for what doesn't repeat with each cycle; see `verdict.Diagnosis`.

    `named` is the law with what is named first, by which the leftover is told. `others` are laws with another effect
    each that takes a part too, and not much the same one. `unstated` is what differs between runs at the same stated
    conditions; `bent` is a force channel that would explain it all.
    """

    verdict: Verdict
    effects: tuple[str, ...]
    kind: Kind | None
    named: Judged | None
    pair: Judged | None
    reasons: tuple[str, ...]
    others: tuple[Judged, ...] = ()
    unstated: Unstated | None = None
    bent: BentChannel | None = None


@dataclass(frozen=True)
class Scales:
    """Candidates on the scales.

    Attributes:
        structure: of the law.
        problem: the data.
        law: the law as it is, refitted.
        candidates: every effect that was fitted, best first.
        tolerance: lack of fit that is let pass.
        jobs, tell: as for `verdict.diagnose`.
    """

    structure: Structure
    problem: Problem
    law: Judged
    candidates: Sequence[Judged]
    tolerance: Tolerance
    jobs: int
    tell: Callable[[str], None]

    @property
    def form_allowed(self) -> bool:
        """Whether what is missing is so small that it may be the form of the effects that the law has."""
        return may_be_form(self.law, self.tolerance)

    @cached_property
    def usable(self) -> list[Judged]:
        """Candidates that better the law, and may take a part of what is missing at least; best first.

        A general effect whose special case leaves about as much isn't among them.
        """
        able = _able(self.candidates, self.law)
        return [each for each in able if not _simpler(each, able, self.law, self.tolerance)]

    @cached_property
    def sound(self) -> list[Judged]:
        """Of these, the ones that may be the cause, for nothing speaks against them; best first."""
        return [each for each in self.usable if each.may_be_cause]

    @cached_property
    def bent(self) -> BentChannel | None:
        """A force channel that isn't straight and explains what is missing; None where none does."""
        return bent_channel(self.problem, self.law)

    def explains(self, candidate: Judged) -> bool:
        """Tell whether a law leaves over next to nothing of what is missing, or what may be form.

        And does so beyond chance: the law as it is is a rival too.
        """
        return explains(candidate, self.law, self.tolerance) and not _near(candidate, [self.law], self.problem)


def weigh(
    structure: Structure,
    problem: Problem,
    law: Judged,
    candidates: Sequence[Judged],
    tolerance: Tolerance,
    jobs: int,
    tell: Callable[[str], None],
    differing: Unstated | None = None,
) -> Weighed:
    """Weigh the candidates; arguments as in `Scales`, and what differs between runs at the same stated conditions."""
    scales = Scales(structure, problem, law, candidates, tolerance, jobs, tell)
    if differing is None:
        return _weighed(scales, causes=True)
    if differing.is_most:
        return replace(_nothing("unknown", differing.words()), unstated=differing)
    found = _weighed(scales, causes=False)
    return replace(found, reasons=(*found.reasons, differing.words()), unstated=differing)


def _weighed(scales: Scales, causes: bool) -> Weighed:
    """Weigh the candidates; without causes, what is named takes a part at most."""
    structure, problem, law, tolerance = scales.structure, scales.problem, scales.law, scales.tolerance
    if is_adequate(law.lack, tolerance):
        if is_complete(law, problem, tolerance):
            return _complete(scatter_words(law.lack, problem), scales)
        return _nothing("unknown", few_runs_words(law.lack, problem, repeat=causes))
    usable, sound = scales.usable, scales.sound
    pair: Judged | None = None
    if sound and causes:
        # One effect that explains it is nearer than two, even where left-out conditions prefer one of the two.
        asked = (sound[0], likeliest(sound), *_takers(sound, law), *sound)
        best = next((each for each in asked if scales.explains(each)), None)
        if best is not None:
            return _but_for_the_channel(_if_it_is_itself(_cause(best, sound, scales)), scales)
    if usable and not scales.form_allowed:
        able = _able_to_take_a_part(scales)
        rivals = _near(able[0], able, problem) if able else []
        in_pairs = sound and causes and (not able or able[0].lack.share < NEAR_NOISE_SHARE)
        ids = None if in_pairs else {effect_id(each.effects[0]) for each in rivals}
        promises = screened(structure, problem, law, scales.tell, ids)
        weighed = None
        if sound and causes:
            scales.tell("two effects together")
            found = pairs(structure, problem, law, sound, promises if in_pairs else (), scales.jobs, scales.tell)
            pair = found[0] if found else None
            weighed = _cause_of_two(found, sound, scales)
        weighed = weighed or _part(able, rivals, promises, pair, scales) or _part_of_two(pair, sound, scales)
        if weighed is not None:
            return _but_for_the_channel(_if_it_is_itself(weighed), scales)
    if scales.form_allowed:
        if law.lack.most_share > FORM_NOISE_SHARE:
            return _nothing("unknown", hidden_words(law.lack, problem))
        elsewhere = foretold(law, problem)
        if (elsewhere.sure_share if tolerance.proved else elsewhere.share) > FORM_NOISE_SHARE:
            return _nothing("unknown", foretold_words(law.lack, elsewhere))
        return _complete(form_words(law.lack, elsewhere, best=usable[0] if usable else None, law=law), scales)
    if scales.bent is not None:
        return _the_channel(scales.bent)
    if not usable:
        return _nothing("unknown", "no effect of the catalogue lowers the error on left-out conditions")
    most = max(usable, key=lambda each: explained_share(each, law))
    none = _nothing("unknown", immaterial_words(most, law, problem), pair)
    return replace(none, reasons=(*none.reasons, *pair_words(pair, law)))


def _if_it_is_itself(found: Weighed) -> Weighed:
    """Call no effect the cause without what sets it apart: it fits by its form then."""
    named = found.pair or found.named
    words = without_essence(found.effects[0], named.result) if named is not None and found.kind == "cause" else ""
    return replace(found, kind="part", reasons=(*found.reasons, words)) if words else found


def _but_for_the_channel(found: Weighed, scales: Scales) -> Weighed:
    """Name nothing where a bent force channel explains what is missing clearly better; no cause if it does as well."""
    named, bent = found.pair or found.named, scales.bent
    if named is None or bent is None or bent.akaike >= named.akaike + RIVAL_LIKELIHOOD:
        return found
    if bent.akaike < named.akaike - RIVAL_LIKELIHOOD:
        return _the_channel(bent)
    as_well = f"{bent.words()}; it would explain it as well"
    return replace(found, kind="part", reasons=(*found.reasons, as_well), bent=bent)


def _the_channel(bent: BentChannel) -> Weighed:
    return replace(_nothing("unknown", f"{bent.words()}; no effect explains it as well"), bent=bent)


def _takers(sound: Sequence[Judged], law: Judged) -> list[Judged]:
    """Give the effects that take half of what is missing on left-out conditions, in N, that which takes most first.

    What the form of the law's other effects is off in quiet harmonics can weigh more than they do in squares.
    """
    shares = [(explained_share(each, law), each) for each in sound]
    able = [entry for entry in shares if entry[0] >= HALF_TAKEN_SHARE]
    return [each for _, each in sorted(able, key=lambda entry: -entry[0])]


def _nothing(verdict: Verdict, reason: str, pair: Judged | None = None) -> Weighed:
    return Weighed(verdict, (), None, None, pair, (reason,))


def _complete(reason: str, scales: Scales) -> Weighed:
    """Call a law complete for a reason, unless it goes wrong between the levels tested by more than passes for form."""
    scales.tell("levels left out")
    worst = worst_level(scales.law, scales.problem)
    if worst is not None and worst.share > FORM_NOISE_SHARE:
        return _nothing("unknown", between_words(worst))
    return _nothing("complete", reason)


def _betters(candidate: Judged, law: Judged) -> bool:
    """Tell whether an effect betters the law: on left-out conditions, or by the fit to all data beyond doubt."""
    return candidate.squares < law.squares or candidate.akaike + RIVAL_LIKELIHOOD < law.akaike


def _cause(best: Judged, sound: Sequence[Judged], scales: Scales) -> Weighed:
    """Name one effect that explains what is missing, and the others that do so as well."""
    able = [other for other in sound if scales.explains(other)]
    near = _near(best, able, scales.problem)
    rivals = [each for each in able if any(each is one for one in near) or _leaves_form_alike(each, best, scales)]
    best, *rivals = _without_general([best, *rivals])
    names = distinct([best.effects[0], *(rival.effects[0] for rival in rivals)])
    generals = _generals(best, scales)
    clearly = [each for each in generals if not _near(each, [best], scales.problem)]
    if clearly:
        general = clearly[0]
        fits_better = f"{general.effects[0]}, of which {names[0]} is a special case, fits these tests clearly better"
        reason = f"{' and '.join(names)} leave{'' if names[1:] else 's'} little over, but {fits_better}"
        return Weighed("ambiguous", (general.effects[0], *names), "part", general, None, (reason,))
    if len(names) > 1:
        # simplicity speaks for a special case alone; where it has rivals, so has the general effect
        aside = [each for one in (best, *rivals) for each in _generals(one, scales)]
        names = distinct([*names, *(each.effects[0] for each in _near(best, aside, scales.problem))])
        return Weighed("ambiguous", names, "cause", best, None, (f"this data can't tell {' from '.join(names)}",))
    others = [each for each in sound if effect_id(each.effects[0]) != effect_id(best.effects[0])]
    if better := [each for each in others if not _near(each, [best], scales.problem)]:
        weak = f"{better[0].effects[0]}, which leaves more in N, fits the weak harmonics clearly better"
        reason = f"{best.effects[0]} leaves little over, but {weak}: neither has the exact form"
        return Weighed("missing", names, "part", best, None, (reason,))
    reason = f"{best.effects[0]} explains it and no rival comes near"
    if likelier := [each.effects[0] for each in generals if each.akaike < best.akaike]:
        reason += f"; these tests can't tell it from {' and '.join(likelier)}, of which it is a special case"
    return Weighed("missing", names, "cause", best, None, (reason,))


def _leaves_form_alike(other: Judged, best: Judged, scales: Scales) -> bool:
    """Tell whether two laws leave about as much of a form that neither has: what tells them apart is that form."""
    if other is best or is_adequate(best.lack, scales.tolerance):
        return False
    return other.lack.share - best.lack.share < scales.tolerance.complete


def _generals(special: Judged, scales: Scales) -> list[Judged]:
    """Give the effects that were left aside for a special case of them, best first."""
    able = _able(scales.candidates, scales.law)
    general = [each for each in able if special in _simpler(each, able, scales.law, scales.tolerance)]
    return ranked(each for each in general if each.may_be_cause)


def _cause_of_two(found: Sequence[Judged], sound: Sequence[Judged], scales: Scales) -> Weighed | None:
    """Name the first of two effects that together explain what is missing; None where no two do.

    Of some hundred pairs one or another comes near by chance: it is a part where more than scatter is left.
    """
    if not found or not scales.explains(found[0]):
        return None
    pair = found[0]
    together = f"{' and '.join(pair.effects)} together explain it, one alone doesn't"
    kind: Kind = "cause" if is_adequate(pair.lack, scales.tolerance) else "part"
    likely = [each for each in found if each.akaike - pair.akaike < RIVAL_LIKELIHOOD and scales.explains(each)]
    firsts = [name for name in _first_of_pairs(likely, sound, scales) if _helps_alone(name, sound, scales.law)]
    if not firsts:
        return _both(pair, sound, kind, together, scales)
    named = next(one for one in sound if effect_id(one.effects[0]) == effect_id(firsts[0]))
    if len(firsts) > 1:
        reason = f"{together}; which comes first, {' or '.join(firsts)}, is open"
        return Weighed("ambiguous", tuple(firsts), kind, named, pair, (reason,))
    both = (each.effects for each in likely if any(effect_id(name) == effect_id(firsts[0]) for name in each.effects))
    second = " or ".join(distinct(name for names in both for name in names if effect_id(name) != effect_id(firsts[0])))
    reason = (
        f"two effects are missing: {named.effects[0]} first, which takes {explained_share(named, scales.law):.0%} by "
        f"itself; with {second} beside it {explained_share(pair, scales.law):.0%} is explained"
    )
    return Weighed("missing", tuple(firsts), kind, named, pair, (reason,))


def _able_to_take_a_part(scales: Scales) -> list[Judged]:
    """Give the effects that take a part beyond doubt, best first: of what may be form, half at least.

    A general effect gives way to a special case that leaves about as little only where that is the best.
    """
    least = HALF_TAKEN_SHARE if scales.law.lack.share < scales.tolerance.left else 0.0
    every = _able(scales.candidates, scales.law)
    taking = [each for each in every if takes_part(each, scales.law, scales.problem)]
    enough = [each for each in taking if explained_share(each, scales.law) >= least]
    best = next((each for each in enough if any(each is one for one in scales.usable)), None)
    if best is None:
        return []
    return [each for each in enough if best not in _simpler(each, every, scales.law, scales.tolerance)]


def _part(
    able: Sequence[Judged],
    rivals: Sequence[Judged],
    promises: Sequence[Promise],
    pair: Judged | None,
    scales: Scales,
) -> Weighed | None:
    """Name the effect that clearly takes most of what is missing, though much remains; None where none does.

    Args:
        able: effects that take a part beyond doubt, best first.
        rivals: those of them that can't be told from the best.
        promises: what these promise, at least.
        pair: the best two effects together.
        scales: all candidates.
    """
    if not able:
        return None
    same = [each for each in rivals if _same_part(each, able[0], promises, scales)]
    other_part = [each.effects[0] for each in rivals if not any(each is one for one in same)]
    alike = _without_general([able[0], *same])
    if len(distinct(each.effects[0] for each in alike)) > 1:
        alike = [able[0], *same]  # simplicity speaks for a special case alone
    best = _likeliest_of(alike, scales.law)
    names = distinct([best.effects[0], *(each.effects[0] for each in alike)])
    named = {effect_id(name) for name in names}
    others = tuple(each for each in best_of_each(able) if effect_id(each.effects[0]) not in named)
    takes = f"{best.effects[0]} takes {_of_what_is_missing(best, scales.law)}"
    form = tuple(f"{words}: something else of similar form stands behind it" for words in best.reservations)
    if len(names) > 1:
        alike_words = f"{takes}; {' and '.join(names[1:])} would take much the same part"
        return Weighed("ambiguous", names, "part", best, pair, (alike_words, *form), others)
    unsure = [each for each in scales.usable if not takes_part(each, scales.law, scales.problem)]
    more = [each for each in unsure if explained_share(each, scales.law) > explained_share(best, scales.law)]
    most = f"beyond doubt; {immaterial_words(more[0], scales.law, scales.problem)}" if more else ""
    nearest = f"but {other_part[0]} comes near: it takes another part, which is asked next" if other_part else ""
    but = most or nearest or "and no rival comes near"
    return Weighed("missing", names, "part", best, pair, (f"{takes}, {but}", *form), others)


def _part_of_two(pair: Judged | None, sound: Sequence[Judged], scales: Scales) -> Weighed | None:
    """Name the first of two effects that together take a part, though neither clearly does alone."""
    law = scales.law
    if pair is None or not takes_part(pair, law, scales.problem):
        return None
    if law.lack.share < scales.tolerance.left and explained_share(pair, law) < HALF_TAKEN_SHARE:
        return None
    takes = f"{' and '.join(pair.effects)} together take {_of_what_is_missing(pair, law)}"
    return _both(pair, sound, "part", takes, scales)


def _both(pair: Judged, sound: Sequence[Judged], kind: Kind, does: str, scales: Scales) -> Weighed:
    """Name the first of two effects that neither helps by itself: a cause only where one scales what the other has.

    Otherwise they may cancel each other, as terms of a series do.

    Args:
        pair: the two.
        sound: the effects that may be the cause.
        kind: how the two would be meant otherwise.
        does: what they do together, in words.
        scales: all candidates.
    """
    first, second = sorted(pair.effects, key=lambda name: _alone(name, sound))
    if fits(scales.structure, second):
        kind, why = "part", "neither clearly helps by itself, so judge when both are added"
    else:
        why = f"{second} scales what only {first} brings, so they come together"
    named = replace(pair, effects=(first, second))
    return Weighed("missing", (first,), kind, named, named, (f"{does}; {why}",))


def _of_what_is_missing(judged: Judged, law: Judged) -> str:
    return f"{explained_share(judged, law):.0%} of what is missing (mean square, on left-out conditions)"


def _without_general(alike: Sequence[Judged]) -> list[Judged]:
    """Leave out effects that do no better than a special case of theirs."""
    return [each for each in alike if not any(_is_special_case(_added(other), _added(each)) for other in alike)]


def _able(candidates: Sequence[Judged], law: Judged) -> list[Judged]:
    return [each for each in candidates if not each.objections and _betters(each, law)]


def _simpler(candidate: Judged, able: Sequence[Judged], law: Judged, tolerance: Tolerance) -> list[Judged]:
    return [other for other in able if _leaves_as_little(other, candidate, law, tolerance)]


def simpler_words(candidate: Judged, candidates: Sequence[Judged], law: Judged, tolerance: Tolerance) -> list[str]:
    """Say which special cases of an effect leave about as little, so that it isn't named; arguments as in `Scales`."""
    if len(candidate.effects) > 1:
        return []
    found = _simpler(candidate, _able(candidates, law), law, tolerance)
    return [f"{other.effects[0]}, a special case of it, leaves about as little" for other in found]


def _leaves_as_little(special: Judged, general: Judged, law: Judged, tolerance: Tolerance) -> bool:
    """Tell whether a special case of an effect leaves over no more than twice of what the effect does, in N.

    Of a weak effect scatter hides that: in units of the noise it must take half of what the effect takes, too. And
    where the effect explains what is missing, so must it.
    """
    if not _is_special_case(_added(special), _added(general)):
        return False
    takes_half = law.squares - special.squares >= HALF_TAKEN_SHARE * (law.squares - general.squares)
    if not takes_half or explained_share(general, special) >= HALF_TAKEN_SHARE:
        return False
    return explains(special, law, tolerance) or not explains(general, law, tolerance)


def _is_special_case(effect: Effect, general: Effect) -> bool:
    """Tell whether an effect is one of a general one's special cases; larger members of its family aren't."""
    return effect.id in general.special_cases and len(effect.parameters) < len(general.parameters)


def _added(judged: Judged) -> Effect:
    return judged.result.law.structure.effect(judged.effects[0])


def _likeliest_of(alike: Sequence[Judged], law: Judged) -> Judged:
    """Give the law that the fit to all data prefers among those that take as much as the first, but for a trifle."""
    enough = explained_share(alike[0], law) - MATERIAL_PART_SHARE
    return likeliest(each for each in alike if explained_share(each, law) >= enough)


def _same_part(other: Judged, best: Judged, promises: Sequence[Promise], scales: Scales) -> bool:
    """Tell whether an effect takes what the best one takes too: beside it, little of its own is left."""
    name = other.effects[0]
    promise = next((each for each in promises if effect_id(each.name) == effect_id(name)), None)
    if promise is None or promise.gain <= 0 or not fits_beside(with_effect(scales.structure, best.effects[0]), name):
        return True
    return beside(promise, best, scales.law)[0] < SAME_PART_SHARE * promise.gain


def _first_of_pairs(likely: Sequence[Judged], sound: Sequence[Judged], scales: Scales) -> list[str]:
    """Give the effect that all pairs share which can't be told from the best one: what is open is the other alone.

    Where they share none that helps by itself, give the better effect of the best pair, and of each pair without it.
    """
    shared = set.intersection(*({effect_id(name) for name in pair.effects} for pair in likely))
    in_all = [name for name in likely[0].effects if effect_id(name) in shared and _helps_alone(name, sound, scales.law)]
    if in_all:
        return [min(in_all, key=lambda name: _alone(name, sound))]
    firsts: list[str] = []
    for pair in likely:
        taken = {effect_id(name) for name in firsts}
        if not taken & {effect_id(name) for name in pair.effects}:
            firsts.append(min(pair.effects, key=lambda name: _alone(name, sound)))
    return firsts


def _alone(name: str, sound: Sequence[Judged]) -> float:
    same = (candidate.squares for candidate in sound if effect_id(candidate.effects[0]) == effect_id(name))
    return min(same, default=np.inf)


def _helps_alone(name: str, sound: Sequence[Judged], law: Judged) -> bool:
    """Tell whether an effect explains something of the lack of fit without a second one."""
    excess = (one.lack.excess for one in sound if effect_id(one.effects[0]) == effect_id(name))
    return min(excess, default=np.inf) < (1 - ALONE_SHARE) * law.lack.excess


def _near(best: Judged, others: Sequence[Judged], problem: Problem) -> list[Judged]:
    """Find who can't be told from the best: by left-out conditions, resampled ones, or the fit to all data."""
    others = [each for each in others if each is not best]
    if not others:
        return []
    squares: Array = np.stack([each.squares_by_run(problem.loops) for each in (best, *others)], axis=1)
    squares = np.minimum(squares, BEYOND_COMPARISON)
    count = len(squares)
    wins = np.bincount(np.argmin(draws(count) @ squares, axis=1), minlength=1 + len(others)) / DRAWS
    near = []
    for place, candidate in enumerate(others, 1):
        difference = squares[:, place] - squares[:, 0]
        error = np.sqrt(count * np.var(difference, ddof=1)) if count > 1 else np.inf
        as_likely = candidate.akaike - best.akaike < RIVAL_LIKELIHOOD
        if difference.sum() <= error or wins[place] >= RIVAL_DRAWS_SHARE or as_likely:
            near.append(candidate)
    return near
