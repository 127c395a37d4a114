"""What explains what is missing: one effect, rivals that can't be told apart, or two together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeclamp_identification.diagnosis.candidates import distinct, likeliest, ranked
from pipeclamp_identification.diagnosis.foretold import (
    MEASURE_OF_SHARES,
    explained_share,
    share_of_error,
    takes_part,
)
from pipeclamp_identification.diagnosis.named import joined_by_and
from pipeclamp_identification.diagnosis.objections import without_essence
from pipeclamp_identification.diagnosis.problem import Judged, Problem
from pipeclamp_identification.diagnosis.screen import fits
from pipeclamp_identification.diagnosis.thresholds import (
    ALONE_SHARE,
    CAUSE_NOISE_SHARE,
    HALF_TAKEN_SHARE,
    MATERIAL_PART_SHARE,
    REAL_LACK_CHANCE,
    RIVAL_LIKELIHOOD,
)
from pipeclamp_identification.diagnosis.weighing.between_levels import rests_on
from pipeclamp_identification.diagnosis.weighing.reasons import NEXT_TO_NOTHING
from pipeclamp_identification.diagnosis.weighing.rivals import bettering, rivals_of
from pipeclamp_identification.diagnosis.weighing.scales import Scales, Weighed
from pipeclamp_identification.diagnosis.weighing.special_cases import simpler_than, without_general
from pipeclamp_identification.diagnosis.weighing.tolerance import is_adequate
from pipeclamp_identification.fitting.heldout import are_at_one_condition
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_identification.signals.levels import varies
from pipeclamp_models.base.digits import told_apart
from pipeclamp_models.law.catalogue import effect_id
from pipeclamp_models.law.file import NamedKind


def takers_of_half(sound: Sequence[Judged], law: Judged) -> list[Judged]:
    """Give the effects that take half of what is missing on left-out conditions, in N, that which takes most first.

    What the form of the law's other effects is off in quiet harmonics can weigh more than they do in squares.
    """
    shares = [(explained_share(each, law), each) for each in sound]
    able = [entry for entry in shares if entry[0] >= HALF_TAKEN_SHARE]
    return [each for _, each in sorted(able, key=lambda entry: -entry[0])]


def one_cause(best: Judged, sound: Sequence[Judged], scales: Scales) -> Weighed:
    """Name one effect that explains what is missing, and the others that do so as well."""
    able = [other for other in sound if scales.explains(other)]
    near = rivals_of(best, able, scales.problem)
    rivals = [each for each in able if any(each is one for one in near) or _leaves_form_alike(each, best, scales)]
    alike = without_general([best, *rivals])
    return _a_general_effect_and(alike, scales) or _one_of(alike, scales) or _no_rival_of(alike[0], sound, scales)


def _a_general_effect_and(alike: Sequence[Judged], scales: Scales) -> Weighed | None:
    """Name an effect that fits clearly better than a special case of it, beside that; None where none does.

    Where it doesn't leave scatter alone it must leave less in N, too: of a form that neither has it takes some anyway.
    """
    found = _of_the_exact_form(alike, scales)
    if found is not None and (alone := _general_alone(*found, scales)):
        return alone
    if found is None:
        better = [each for each in _generals(alike[0], scales) if not rivals_of(each, [alike[0]], scales.problem)]
        clearly = [each for each in better if _leaves_scatter(each) or each.lack.share < alike[0].lack.share]
        if not clearly:
            return None
        found = clearly[0], alike
    if many := _many_of_one(*found, scales):
        return many
    general, names = found[0], _names(found[1])
    fits_better = f"{general.effects[0]}, of which {names[0]} is a special case, fits these tests clearly better"
    reason = f"{' and '.join(names)} leave{'' if names[1:] else 's'} little over, but {fits_better}"
    return Weighed("ambiguous", (general.effects[0], *names), "part", general, None, (reason,))


def _of_the_exact_form(alike: Sequence[Judged], scales: Scales) -> tuple[Judged, Sequence[Judged]] | None:
    """Give a general effect that fits clearly better than all of these and leaves scatter alone, and what stays beside.

    Its special cases do, which it may stand for, and what leaves scatter alone too. The others came near each other by
    what each leaves of a form that none of them has; it has that form.
    """
    for special in alike:
        for general in _generals(special, scales):
            if _leaves_scatter(general) and not rivals_of(general, alike, scales.problem):
                others = [one for one in alike if _leaves_scatter(one) or general in _generals(one, scales)]
                return general, [special, *(one for one in others if one is not special)]
    return None


def _general_alone(general: Judged, beside: Sequence[Judged], scales: Scales) -> Weighed | None:
    """Name a general effect alone where each of those beside it leaves something material that scatter can't have made.

    It is a part: one of them may stand behind it in another form. None where one leaves no more than scatter may make,
    so that what tells them apart is next to nothing in N, or where another general effect comes near.
    """
    least = min(one.lack.sure_share for one in beside)
    generals = [each for one in beside for each in _generals(one, scales)]
    if least < scales.tolerance.complete or rivals_of(general, generals, scales.problem):
        return None
    name, names = general.effects[0], _names(beside)
    leaves = "leave" if names[1:] else "leaves"
    reason = (
        f"{name} leaves scatter alone; {joined_by_and(names)} {leaves} {least:.2g} times the noise, or more, that "
        "scatter can't make, but may stand behind it in another form"
    )
    return Weighed("missing", (name,), "part", general, None, (reason,))


def _many_of_one(general: Judged, beside: Sequence[Judged], scales: Scales) -> Weighed | None:
    """Name a general effect alone that is many of the one beside it, or a smoothed one: either name would be right.

    It is a part. None where another general effect comes near.
    """
    name, names = general.effects[0], _names(beside)
    generals = [each for one in beside for each in _generals(one, scales)]
    many_of = general.result.law.structure.effect(name).many_of
    if set(map(effect_id, names)) != {many_of} or rivals_of(general, generals, scales.problem):
        return None
    reason = f"{names[0]} leaves little over, but {name}, which is many of it or a smoothed one, fits clearly better"
    return Weighed("missing", (name,), "part", general, None, (reason,))


def _leaves_scatter(judged: Judged) -> bool:
    """Tell whether nothing real is left over, in units of the noise."""
    return judged.lack.p_value > REAL_LACK_CHANCE


def _one_of(alike: Sequence[Judged], scales: Scales) -> Weighed | None:
    """Name several effects that can't be told apart; None where it is one alone."""
    best, names = alike[0], _names(alike)
    if len(names) < 2:
        return None
    # simplicity speaks for a special case alone; where it has rivals, so has the general effect
    aside = [each for one in alike for each in _generals(one, scales)]
    names = distinct([*names, *(each.effects[0] for each in rivals_of(best, aside, scales.problem))])
    form = _form_left(best, scales)
    reasons = (f"this data can't tell {joined_by_and(names)} apart", *([form] if form else []))
    return Weighed("ambiguous", names, "part" if form else "cause", best, None, reasons)


def _no_rival_of(best: Judged, sound: Sequence[Judged], scales: Scales) -> Weighed:
    """Name one effect: as the cause, or as a part where another one does better by another measure, or form is left."""
    name = best.effects[0]
    others = [each for each in sound if effect_id(each.effects[0]) != effect_id(name)]
    generals = _generals(best, scales)
    if against := _weak_harmonics(best, [*others, *generals], scales) or _more_in_force(best, others, scales):
        return _neither_fits(best, against, others, scales)
    likelier = [each.effects[0] for each in generals if each.akaike < best.akaike]
    beside = f"; these tests can't tell it from {' and '.join(likelier)}, of which it is a special case"
    told = beside if likelier else ""
    if form := _form_left(best, scales):
        return Weighed("missing", (name,), "part", best, None, (f"no rival of {name} comes near, but {form}{told}",))
    if any(each.akaike + RIVAL_LIKELIHOOD < best.akaike for each in generals):
        but = f"but the fit to all tests clearly prefers {joined_by_and(likelier)}, of which it is a special case"
        return Weighed("missing", (name,), "part", best, None, (f"no rival of {name} comes near, {but}",))
    return Weighed("missing", (name,), "cause", best, None, (f"{name} explains it and no rival comes near{told}",))


def _neither_fits(best: Judged, against: str, others: Sequence[Judged], scales: Scales) -> Weighed:
    """Name a part, of an effect that explains what is missing and others that do better by another measure.

    It is what the fit to all tests prefers of those that take as much in N on left-out conditions, but for a trifle.
    """
    law, problem = scales.law, scales.problem
    enough = explained_share(best, law) - MATERIAL_PART_SHARE
    as_much = [each for each in others if explained_share(each, law) >= enough and each.akaike < best.akaike]
    able = [each for each in as_much if takes_part(each, law, problem) and rests_on(each, law, problem) is None]
    named = likeliest([best, *able])
    name, other = named.effects[0], best.effects[0]
    does = f"{name} leaves little over, but {against}"
    if named is not best:
        takes = f"{name} takes {explained_share(named, law):.0%} of what is missing ({MEASURE_OF_SHARES})"
        does = f"{takes}, and the fit to all tests prefers it; {other} leaves less that follows the conditions"
    return Weighed("missing", (name,), "part", named, None, (f"{does}: neither has the exact form",))


def _names(alike: Sequence[Judged]) -> tuple[str, ...]:
    return distinct(each.effects[0] for each in alike)


def _weak_harmonics(best: Judged, others: Sequence[Judged], scales: Scales) -> str:
    """Say which effect fits clearly better in units of the noise than the best in N; empty where none does."""
    better = [each for each in others if not rivals_of(each, [best], scales.problem)]
    return f"{better[0].effects[0]}, which leaves more in N, fits the weak harmonics clearly better" if better else ""


def _more_in_force(best: Judged, others: Sequence[Judged], scales: Scales) -> str:
    """Say which effect takes more in N than the best, which leaves some over; empty where none does."""
    if is_adequate(best.lack, scales.tolerance):
        return ""
    takes = explained_share(best, scales.law)
    more = [each for each in takers_of_half(others, scales.law) if explained_share(each, scales.law) > takes]
    return f"{more[0].effects[0]}, which fits the weak harmonics worse, takes more of it in N" if more else ""


def _form_left(best: Judged, scales: Scales) -> str:
    """Say that a law leaves more than a cause's form may; empty where it doesn't.

    A fit to few tests may leave little: what a cause's form can't foretell is left, too. And what lies under scatter
    shows no form.
    """
    taken = share_of_error(best, scales.law)
    if taken < HALF_TAKEN_SHARE:
        return f"on left-out conditions it takes only {taken:.0%} of the law's error, scatter included"
    if is_adequate(best.lack, scales.tolerance) or best.lack.sure_share < CAUSE_NOISE_SHARE:
        return ""
    return f"{best.lack.share:.2g} times the noise still follows the conditions: its form isn't this one's exactly"


def _leaves_form_alike(other: Judged, best: Judged, scales: Scales) -> bool:
    """Tell whether two laws leave about as much of a form that neither has: what tells them apart is that form."""
    if other is best or is_adequate(best.lack, scales.tolerance):
        return False
    return other.lack.share - best.lack.share < scales.tolerance.complete


def _generals(special: Judged, scales: Scales) -> list[Judged]:
    """Give the effects that were left aside for a special case of them, best first."""
    able = bettering(scales.candidates, scales.law)
    general = [each for each in able if special in simpler_than(each, able, scales.law, scales.tolerance)]
    return ranked(each for each in general if each.may_be_cause)


def cause_of_two(found: Sequence[Judged], sound: Sequence[Judged], scales: Scales) -> Weighed | None:
    """Name the first of two effects that together explain what is missing; None where no two do.

    Of some hundred pairs one or another comes near by chance: it is a part where more than scatter is left, or where it
    takes less than half of the law's error on left-out conditions.
    """
    if not found or not scales.explains(found[0]):
        return None
    pair = found[0]
    does = f"{' and '.join(pair.effects)} together explain it, one alone doesn't"
    foretells = share_of_error(pair, scales.law) >= HALF_TAKEN_SHARE
    kind: NamedKind = "cause" if foretells and is_adequate(pair.lack, scales.tolerance) else "part"
    likely = [each for each in found if each.akaike - pair.akaike < RIVAL_LIKELIHOOD and scales.explains(each)]
    able = [name for name in first_of_pairs(likely, sound, scales) if helps_alone(name, sound, scales.law)]
    if not able:
        return named_together(pair, sound, kind, does, scales)
    # beside another an effect may have grown; what is said is of the one by itself
    alone = [next(one for one in sound if effect_id(one.effects[0]) == effect_id(name)) for name in able]
    named, firsts = alone[0], [one.effects[0] for one in alone]
    if len(firsts) > 1:
        reason = f"{does}; which comes first, {' or '.join(firsts)}, is open"
        return Weighed("ambiguous", tuple(firsts), kind, named, pair, (reason,))
    reason = _first_of_two_words(named, pair, likely, kind, scales.law)
    return Weighed("missing", tuple(firsts), kind, named, pair, (reason,))


def _first_of_two_words(named: Judged, pair: Judged, likely: Sequence[Judged], kind: NamedKind, law: Judged) -> str:
    """Say what the first of two effects takes by itself, and what may stand beside it.

    Args:
        named: the law with the first effect.
        pair: the law with the best two.
        likely: laws with two effects that can't be told from it.
        kind: how the first is meant.
        law: the law as it is.
    """
    first = named.effects[0]
    with_first = (each.effects for each in likely if effect_id(first) in map(effect_id, each.effects))
    second = " or ".join(distinct(name for both in with_first for name in both if effect_id(name) != effect_id(first)))
    by_itself = explained_share(named, law)
    part, whole = told_apart(by_itself, explained_share(pair, law))
    takes = part if by_itself >= NEXT_TO_NOTHING else "next to nothing"
    # of parts nothing shows how many effects stand behind them
    does = f"two effects are missing: {first} first, which takes" if kind == "cause" else f"{first} takes"
    return f"{does} {takes} by itself; with {second} beside it {whole} is explained"


def unless_another_does(found: Weighed, like: Sequence[Judged]) -> Weighed:
    """Call no pair the cause where one that acts alike fits as well, though it can't be named as the cause itself.

    With more parameters it may come to the same.
    """
    pair = found.pair
    if found.kind != "cause" or pair is None:
        return found
    as_well = [
        each
        for each in like
        if each.reservations
        and each.akaike - pair.akaike < RIVAL_LIKELIHOOD
        and len(each.result.law.values) <= len(pair.result.law.values)
    ]
    if not as_well:
        return found
    words = f"{' and '.join(as_well[0].effects)} together fit as well, though {as_well[0].reservations[0]}"
    return found.as_part(words)


def named_together(pair: Judged, sound: Sequence[Judged], kind: NamedKind, does: str, scales: Scales) -> Weighed:
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


def first_of_pairs(likely: Sequence[Judged], sound: Sequence[Judged], scales: Scales) -> list[str]:
    """Give the effect that all pairs share which can't be told from the best one: what is open is the other alone.

    Where they share none that helps by itself, give the better effect of the best pair, and of each pair without it.
    As of effects that explain it alone, what takes half of what is missing in N goes before others: noise that is
    weighed beside a law without it holds some of it for scatter from run to run.
    """
    halves = [effect_id(one.effects[0]) for one in takers_of_half(sound, scales.law)]

    def place(name: str) -> tuple[int, float]:
        identifier = effect_id(name)
        return halves.index(identifier) if identifier in halves else len(halves), _alone(name, sound)

    shared = set.intersection(*({effect_id(name) for name in pair.effects} for pair in likely))
    in_all = [name for name in likely[0].effects if effect_id(name) in shared and helps_alone(name, sound, scales.law)]
    if in_all:
        return [min(in_all, key=place)]
    firsts: list[str] = []
    for pair in likely:
        taken = {effect_id(name) for name in firsts}
        if not taken & {effect_id(name) for name in pair.effects}:
            firsts.append(min(pair.effects, key=place))
    return firsts


def _alone(name: str, sound: Sequence[Judged]) -> float:
    same = (candidate.squares for candidate in sound if effect_id(candidate.effects[0]) == effect_id(name))
    return min(same, default=np.inf)


def helps_alone(name: str, sound: Sequence[Judged], law: Judged) -> bool:
    """Tell whether an effect explains something of the lack of fit without a second one."""
    excess = (one.lack.excess for one in sound if effect_id(one.effects[0]) == effect_id(name))
    return min(excess, default=np.inf) < (1 - ALONE_SHARE) * law.lack.excess


def unless_at_one_condition(found: Weighed, loops: Loops) -> Weighed:
    """Call nothing the cause where no condition can be left out to see whether it foretells that."""
    if found.kind != "cause" or not are_at_one_condition(loops):
        return found
    words = "all tests are at one amplitude and frequency, so that nothing shows whether it foretells others"
    return found.as_part(words)


def unless_it_slips_at_one_amplitude(found: Weighed, problem: Problem) -> Weighed:
    """Call nothing the cause that slips where all tests are at one amplitude.

    A few slip elements follow any one loop; which part of a clamp slips before which is told by other amplitudes.
    """
    named = found.named
    sure = found.verdict == "missing" and found.kind == "cause"
    if named is None or not sure or varies("A", problem.observations.motion.slow["A"]):
        return found
    effect = named.result.law.structure.effect(found.effects[0])
    if not any(coefficient.role == "slip" for coefficient in effect.coefficients):
        return found
    words = f"all tests are at one amplitude, at which what slips otherwise than {effect.name} may do the same"
    return found.as_part(words)


def if_it_is_itself(found: Weighed) -> Weighed:
    """Call no effect the cause without what sets it apart: it fits by its form then."""
    named = found.pair or found.named
    words = without_essence(found.effects[0], named.result) if named is not None and found.kind == "cause" else ""
    return found.as_part(words) if words else found
