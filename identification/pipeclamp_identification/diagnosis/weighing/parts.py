"""What takes a part of what is missing, though much remains."""

from __future__ import annotations

from collections.abc import Sequence

from pipeclamp_identification.diagnosis.candidates import best_of_each, distinct, likeliest
from pipeclamp_identification.diagnosis.foretold import MEASURE_OF_SHARES, explained_share, takes_part
from pipeclamp_identification.diagnosis.problem import Judged
from pipeclamp_identification.diagnosis.screen import Promise, beside, fits, fits_beside
from pipeclamp_identification.diagnosis.thresholds import HALF_TAKEN_SHARE, MATERIAL_PART_SHARE, SAME_PART_SHARE
from pipeclamp_identification.diagnosis.weighing.between_levels import rests_on
from pipeclamp_identification.diagnosis.weighing.causes import named_together
from pipeclamp_identification.diagnosis.weighing.reasons import curve_words, immaterial_words
from pipeclamp_identification.diagnosis.weighing.rivals import bettering
from pipeclamp_identification.diagnosis.weighing.scales import Scales, Weighed
from pipeclamp_identification.diagnosis.weighing.special_cases import simpler_than, without_general
from pipeclamp_models.law.catalogue import effect_id
from pipeclamp_models.law.law import with_effect


def able_to_take_a_part(scales: Scales) -> list[Judged]:
    """Give the effects that take a part beyond doubt, best first: of what may be form, half at least.

    Not one whose part rests on one level of A or f: between the levels tested it would be made up. A general effect
    gives way to a special case that leaves about as little only where that is the best.
    """
    least = HALF_TAKEN_SHARE if scales.law.lack.share < scales.tolerance.left else 0.0
    every = bettering(scales.candidates, scales.law)
    taking = [each for each in every if takes_part(each, scales.law, scales.problem)]
    large = [each for each in taking if explained_share(each, scales.law) >= least]
    enough = [each for each in large if rests_on(each, scales.law, scales.problem) is None]
    best = next((each for each in enough if any(each is one for one in scales.usable)), None)
    if best is None:
        return []
    return [each for each in enough if best not in simpler_than(each, every, scales.law, scales.tolerance)]


def one_part(
    able: Sequence[Judged],
    rivals: Sequence[Judged],
    promises: Sequence[Promise],
    pairs: Sequence[Judged],
    scales: Scales,
) -> Weighed:
    """Name the effect that clearly takes most of what is missing, though much remains.

    Args:
        able: effects that take a part beyond doubt, one at least, best first.
        rivals: those of them that can't be told from the best.
        promises: what these promise, at least.
        pairs: two effects together each.
        scales: all candidates.
    """
    same = [each for each in rivals if _same_part(each, able[0], promises, pairs, scales)]
    other_part = [each.effects[0] for each in rivals if not any(each is one for one in same)]
    alike = without_general([able[0], *same])
    if len(distinct(each.effects[0] for each in alike)) > 1:
        alike = [able[0], *same]  # simplicity speaks for a special case alone
    best = _likeliest_of(alike, scales.law)
    names = distinct([best.effects[0], *(each.effects[0] for each in alike)])
    named = {effect_id(name) for name in names}
    others = tuple(each for each in best_of_each(able) if effect_id(each.effects[0]) not in named)
    takes = f"{best.effects[0]} takes {_of_what_is_missing(best, scales.law)}"
    form = tuple(f"{words}: something else of similar form stands behind it" for words in best.reservations)
    form += curve_words(best, scales.law, scales.problem)
    if len(names) > 1:
        alike_words = f"{takes}; {' and '.join(names[1:])} would take much the same part"
        as_well = (each for each in best_of_each(alike) if effect_id(each.effects[0]) != effect_id(best.effects[0]))
        return Weighed("ambiguous", names, "part", best, None, (alike_words, *form), (*as_well, *others))
    unsure = [each for each in scales.usable if not takes_part(each, scales.law, scales.problem)]
    more = [each for each in unsure if explained_share(each, scales.law) > explained_share(best, scales.law)]
    most = f"beyond doubt; {immaterial_words(more[0], scales.law, scales.problem)}" if more else ""
    nearest = _takes_another_part(other_part[0], best, pairs, scales) if other_part else ""
    but = most or nearest or _how_far_others_are(others, best, scales.law)
    return Weighed("missing", names, "part", best, None, (f"{takes}, {but}", *form), others)


def part_of_two(pair: Judged | None, sound: Sequence[Judged], scales: Scales) -> Weighed | None:
    """Name the first of two effects that together take a part, though neither clearly does alone."""
    law = scales.law
    if pair is None or not takes_part(pair, law, scales.problem):
        return None
    if law.lack.share < scales.tolerance.left and explained_share(pair, law) < HALF_TAKEN_SHARE:
        return None
    if rests_on(pair, law, scales.problem):
        return None
    takes = f"{' and '.join(pair.effects)} together take {_of_what_is_missing(pair, law)}"
    return named_together(pair, sound, "part", takes, scales)


def outdoes(pair: Judged | None, able: Sequence[Judged], scales: Scales) -> bool:
    """Tell whether an effect with what scales only it takes half, or more, of what the best one alone would leave."""
    if pair is None or not able or all(fits(scales.structure, name) for name in pair.effects):
        return False
    alone, together = (explained_share(each, scales.law) for each in (able[0], pair))
    return together - alone >= HALF_TAKEN_SHARE * (1 - alone)


def _of_what_is_missing(judged: Judged, law: Judged) -> str:
    return f"{explained_share(judged, law):.0%} of what is missing ({MEASURE_OF_SHARES})"


def _likeliest_of(alike: Sequence[Judged], law: Judged) -> Judged:
    """Give the law that the fit to all data prefers among those that take as much as the first, but for a trifle."""
    enough = explained_share(alike[0], law) - MATERIAL_PART_SHARE
    return likeliest(each for each in alike if explained_share(each, law) >= enough)


def _same_part(
    other: Judged, best: Judged, promises: Sequence[Promise], pairs: Sequence[Judged], scales: Scales
) -> bool:
    """Tell whether an effect takes what the best one takes too: beside it, little of its own is left.

    Where both were fitted together, that tells; else one step does.
    """
    name = other.effects[0]
    together = fitted_together(best, name, pairs)
    if together is not None:
        own, both, alone = (explained_share(each, scales.law) for each in (other, together, best))
        return both - alone < SAME_PART_SHARE * own
    promise = next((each for each in promises if effect_id(each.name) == effect_id(name)), None)
    if promise is None or promise.gain <= 0 or not fits_beside(with_effect(scales.structure, best.effects[0]), name):
        return True
    return beside(promise, best, scales.law)[0] < SAME_PART_SHARE * promise.gain


def _takes_another_part(name: str, best: Judged, pairs: Sequence[Judged], scales: Scales) -> str:
    """Say that an effect comes near the best one with another part, and what both take where they were fitted so."""
    together = fitted_together(best, name, pairs)
    both = f"; both together take {explained_share(together, scales.law):.0%}" if together else ""
    return f"but {name} comes near: it takes another part, which is asked next{both}"


def _how_far_others_are(others: Sequence[Judged], best: Judged, law: Judged) -> str:
    """Say that no other effect comes near the best one, or what one takes that seems to, and is no rival of it."""
    shares = {each.effects[0]: explained_share(each, law) for each in others}
    name = max(shares, key=shares.__getitem__, default="")
    if not name or shares[name] < HALF_TAKEN_SHARE * explained_share(best, law):
        return "and no rival comes near"
    if shares[name] < explained_share(best, law):
        return f"clearly more than {name}, which takes {shares[name]:.0%}"
    return f"and {name} {shares[name]:.0%}, but clearly less where errors are counted in units of the noise"


def fitted_together(one: Judged, other: str, pairs: Sequence[Judged]) -> Judged | None:
    """Give the law with both effects, of whatever size; None where they weren't fitted together."""
    ids = {effect_id(one.effects[0]), effect_id(other)}
    return next((pair for pair in pairs if {effect_id(name) for name in pair.effects} == ids), None)
