"""Effects that are special cases of others: where one does as well, the general one isn't named."""

from __future__ import annotations

from collections.abc import Sequence

from pipeclamp_identification.diagnosis.foretold import explained_share, share_of_error
from pipeclamp_identification.diagnosis.problem import Judged
from pipeclamp_identification.diagnosis.thresholds import HALF_TAKEN_SHARE
from pipeclamp_identification.diagnosis.weighing.rivals import bettering
from pipeclamp_identification.diagnosis.weighing.tolerance import Tolerance, explains
from pipeclamp_models.equations.effect import Effect


def without_general(alike: Sequence[Judged]) -> list[Judged]:
    """Leave out effects that do no better than a special case of theirs."""
    return [each for each in alike if not any(is_special_case(_added(other), _added(each)) for other in alike)]


def simpler_than(candidate: Judged, able: Sequence[Judged], law: Judged, tolerance: Tolerance) -> list[Judged]:
    """Give the special cases of an effect that leave about as little; arguments as in `Scales`."""
    return [other for other in able if _leaves_as_little(other, candidate, law, tolerance)]


def simpler_words(candidate: Judged, candidates: Sequence[Judged], law: Judged, tolerance: Tolerance) -> list[str]:
    """Say which special cases of an effect leave about as little, so that it isn't named; arguments as in `Scales`."""
    if len(candidate.effects) > 1:
        return []
    found = simpler_than(candidate, bettering(candidates, law), law, tolerance)
    return [f"{other.effects[0]}, a special case of it, leaves about as little" for other in found]


def _leaves_as_little(special: Judged, general: Judged, law: Judged, tolerance: Tolerance) -> bool:
    """Tell whether a special case of an effect leaves over no more than twice of what the effect does, in N.

    Of a weak effect scatter hides that: in units of the noise it must take half of what the effect takes, too, and in N
    where the effect takes nothing in units of the noise, half of which is no measure. And where the effect explains
    what is missing, so must it, or take as much in N.
    """
    if not is_special_case(_added(special), _added(general)):
        return False
    taken, whole = (law.squares - each.squares for each in (special, general))
    if whole <= 0:
        taken, whole = (explained_share(each, law) for each in (special, general))
    beyond = share_of_error(general, special)
    if taken < HALF_TAKEN_SHARE * whole or beyond >= HALF_TAKEN_SHARE:
        return False
    return not beyond or explains(special, law, tolerance) or not explains(general, law, tolerance)


def is_special_case(effect: Effect, general: Effect) -> bool:
    """Tell whether an effect is one of a general one's special cases; larger members of its family aren't."""
    return effect.id in general.special_cases and len(effect.parameters) < len(general.parameters)


def _added(judged: Judged) -> Effect:
    return judged.result.law.structure.effect(judged.effects[0])
