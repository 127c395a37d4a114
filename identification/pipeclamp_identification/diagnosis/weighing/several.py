"""Special cases of a general effect that are there together: it may stand for several of them at once."""

from __future__ import annotations

from itertools import combinations

from pipeclamp_identification.diagnosis.candidates import likeliest
from pipeclamp_identification.diagnosis.foretold import explained_share
from pipeclamp_identification.diagnosis.named import joined_by_and
from pipeclamp_identification.diagnosis.problem import Judged, judge_each
from pipeclamp_identification.diagnosis.screen import candidate_names
from pipeclamp_identification.diagnosis.thresholds import RIVAL_LIKELIHOOD
from pipeclamp_identification.diagnosis.weighing.causes import first_of_pairs, helps_alone
from pipeclamp_identification.diagnosis.weighing.pairs import in_place_of
from pipeclamp_identification.diagnosis.weighing.rivals import rivals_of
from pipeclamp_identification.diagnosis.weighing.scales import Scales, Weighed
from pipeclamp_models.law.catalogue import effect_id

FEWEST = 2
"""Special cases that are several; one by itself is asked where candidates are weighed."""


def unless_several_do(found: Weighed, scales: Scales) -> Weighed:
    """Call no general effect the cause for which several of its special cases do as well together.

    It may stand for them, or they for it: it is a part. Where the fit to all tests prefers them, the first is named.
    """
    whole = found.pair or found.named
    if found.kind != "cause" or whole is None:
        return found
    for general in whole.effects:
        several = _several_in_place_of(general, whole, scales)
        if several is not None and rivals_of(whole, [several], scales.problem):
            alone = found.verdict == "missing"  # what rivals the general effect rivals them too
            first = _the_first_of(several, general, whole, scales) if alone else None
            return first or _as_a_part(found, several, general, whole)
    return found


def _several_in_place_of(general: str, whole: Judged, scales: Scales) -> Judged | None:
    """Give the law with several special cases in the place of an effect: of the likely ones with fewest of them.

    Each of them is asked for, whatever it takes alone: beside another it may take more. None where there are none.
    """
    simple = whole.result.law.structure.effect(general).special_cases
    if len(simple) < FEWEST:
        return None
    structure, loops = scales.structure, scales.problem.loops
    known = candidate_names(structure, loops.conditions, time_measured=loops.time_measured)
    names = [name for name in known if effect_id(name) in simple and name not in whole.effects]
    groups = [group for count in range(FEWEST, len(names) + 1) for group in combinations(names, count)]
    placed = (in_place_of(general, group, whole, scales) for group in groups)
    contenders = [each for each in placed if each is not None]
    found = judge_each(contenders, scales.problem, scales.workers)
    sound = [each for each in found if not each.objections]
    if not sound:
        return None
    most = likeliest(sound).akaike + RIVAL_LIKELIHOOD
    return min((each for each in sound if each.akaike < most), key=lambda each: (len(each.effects), each.akaike))


def _the_first_of(several: Judged, general: str, whole: Judged, scales: Scales) -> Weighed | None:
    """Name the first of several special cases that the fit prefers; None where it doesn't, or none helps alone.

    It is a part: of so many nothing shows how many there are.
    """
    if several.akaike >= whole.akaike:
        return None
    sound = [each for each in scales.sound if each.effects[0] != general]
    (first,) = first_of_pairs([several], sound, scales)
    if not helps_alone(first, sound, scales.law):
        return None
    named = next(each for each in sound if effect_id(each.effects[0]) == effect_id(first))
    better = "better" if rivals_of(several, [whole], scales.problem) else "clearly better"
    takes, together = (f"{explained_share(each, scales.law):.0%}" for each in (named, several))
    reason = (
        f"{_alike(several, whole)}, special cases of {general}, fit these tests {better} together than it does: "
        f"{named.effects[0]} takes {takes} by itself, together they take {together}"
    )
    return Weighed("missing", named.effects, "part", named, several, (reason,))


def _as_a_part(found: Weighed, several: Judged, general: str, whole: Judged) -> Weighed:
    words = f"{_alike(several, whole)}, special cases of {general}, leave about as little together"
    return found.as_part(f"{words}: it may stand for them")


def _alike(several: Judged, whole: Judged) -> str:
    return joined_by_and([name for name in several.effects if name not in whole.effects])
