"""What the candidates make of the verdict: a cause, a part, rivals that can't be told apart, or nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from pipeclamp_identification.diagnosis.candidates import likeliest, ranked
from pipeclamp_identification.diagnosis.foretold import explained_share, foretold
from pipeclamp_identification.diagnosis.open_means import means_left_open
from pipeclamp_identification.diagnosis.problem import Judged
from pipeclamp_identification.diagnosis.repeats import Unstated
from pipeclamp_identification.diagnosis.screen import Promise, screened
from pipeclamp_identification.diagnosis.thresholds import FORM_NOISE_SHARE, NEAR_NOISE_SHARE, RIVAL_LIKELIHOOD
from pipeclamp_identification.diagnosis.weighing.causes import (
    cause_of_two,
    if_it_is_itself,
    one_cause,
    takers_of_half,
    unless_another_does,
)
from pipeclamp_identification.diagnosis.weighing.channel import BentChannel
from pipeclamp_identification.diagnosis.weighing.pairs import pairs, together_with_each, twins
from pipeclamp_identification.diagnosis.weighing.parts import (
    able_to_take_a_part,
    fitted_together,
    one_part,
    outdoes,
    part_of_two,
)
from pipeclamp_identification.diagnosis.weighing.reasons import (
    chance_words,
    few_runs_words,
    foretold_words,
    form_words,
    hidden_words,
    immaterial_words,
    pair_words,
    scatter_words,
)
from pipeclamp_identification.diagnosis.weighing.rivals import rivals_of
from pipeclamp_identification.diagnosis.weighing.scales import Scales, Weighed, nothing_named
from pipeclamp_identification.diagnosis.weighing.several import unless_several_do
from pipeclamp_identification.diagnosis.weighing.tolerance import is_adequate, is_complete
from pipeclamp_models.law.catalogue import effect_id


def weigh(scales: Scales, differing: Unstated | None = None) -> Weighed:
    """Weigh the candidates, beside what differs between runs at the same stated conditions."""
    if differing is None:
        return _weighed(scales, causes=True)
    if differing.is_most:
        return replace(nothing_named("unknown", differing.words()), unstated=differing)
    found = _weighed(scales, causes=False)
    return replace(found, reasons=(*found.reasons, differing.words()), unstated=differing)


def part_or_nothing(scales: Scales, more_than_form: str) -> Weighed:
    """Name what takes a part of what is more than passes for form, as where more is missing; else nothing, and why."""
    found = _two_or_a_part(scales, ())[0] if able_to_take_a_part(scales) else None
    if found is None:
        return nothing_named("unknown", more_than_form)
    return _but_for_the_channel(replace(found, reasons=(*found.reasons, more_than_form)), scales)


def _weighed(scales: Scales, causes: bool) -> Weighed:
    """Weigh the candidates; without causes, what is named takes a part at most."""
    if is_adequate(scales.law.lack, scales.tolerance):
        return _next_to_nothing_left(scales, repeat=causes)
    found = _one_that_explains(scales) if causes else None
    pair: Judged | None = None
    if found is None and scales.usable and not scales.form_allowed:
        found, pair = _two_or_a_part(scales, scales.sound if causes else ())
    if found is not None:
        return _but_for_the_channel(if_it_is_itself(unless_several_do(found, scales)), scales)
    if scales.form_allowed:
        return _form_at_most(scales)
    return _nothing_named(scales, pair)


def _next_to_nothing_left(scales: Scales, repeat: bool) -> Weighed:
    """Call a law complete that leaves over what is let pass, where the tests are enough to tell."""
    problem, lack = scales.problem, scales.law.lack
    if is_complete(scales.law, problem, scales.tolerance):
        return _complete(scatter_words(lack, problem), scales)
    told = few_runs_words if problem.noise.is_no_rigs else chance_words
    return nothing_named("unknown", told(lack, problem, repeat=repeat))


def _one_that_explains(scales: Scales) -> Weighed | None:
    """Name the effect that explains what is missing; None where none does by itself.

    One effect that explains it is nearer than two, even where left-out conditions prefer one of the two.
    """
    sound = scales.sound
    if not sound:
        return None
    asked = (sound[0], likeliest(sound), *takers_of_half(sound, scales.law), *sound)
    best = next((each for each in asked if scales.explains(each)), None)
    return one_cause(best, sound, scales) if best is not None else None


def _two_or_a_part(scales: Scales, sound: Sequence[Judged]) -> tuple[Weighed | None, Judged | None]:
    """Name the first of two effects that explain what is missing together, or the one that takes most of it.

    Args:
        scales: all candidates.
        sound: those of them that may be the cause, with another beside it.

    Returns:
        what is named, None where nothing takes a part; and the best two effects together.
    """
    structure, problem = scales.structure, scales.problem
    able = able_to_take_a_part(scales)
    rivals = rivals_of(able[0], able, problem) if able else []
    in_pairs = sound and (not able or able[0].lack.share < NEAR_NOISE_SHARE)
    ids = None if in_pairs else {effect_id(each.effects[0]) for each in rivals}
    promises = screened(structure, problem, scales.law, scales.workers, ids)
    both: list[Judged] = []
    found: Weighed | None = None
    if sound:
        scales.workers.tell("two effects together")
        both = pairs(sound, promises if in_pairs else (), scales)
        found = _cause_of_two(both, sound, scales)
    pair = both[0] if both else None
    if found is None and outdoes(pair, able, scales):
        found = part_of_two(pair, sound, scales)
    if found is None and able:
        together = _with_rivals(able[0], rivals, promises, both, scales)
        found = replace(one_part(able, rivals, promises, together, scales), pair=pair)
    return found or part_of_two(pair, scales.sound, scales), pair


def _with_rivals(
    best: Judged, rivals: Sequence[Judged], promises: Sequence[Promise], both: Sequence[Judged], scales: Scales
) -> list[Judged]:
    """Give the laws with the best effect and a rival each: of those fitted already, and of others fitted now."""
    open_yet = [each for each in rivals if fitted_together(best, each.effects[0], both) is None]
    new = together_with_each(best, open_yet, promises, scales)
    return [*both, *new]


def _cause_of_two(found: Sequence[Judged], sound: Sequence[Judged], scales: Scales) -> Weighed | None:
    """Name the first of two effects that explain it together, unless what acts like one of them does as well."""
    weighed = cause_of_two(found, sound, scales)
    if weighed is None or weighed.kind != "cause":
        return weighed
    like = twins(found[0], scales)
    found = ranked([*found, *(each for each in like if each.may_be_cause)])
    return unless_another_does(cause_of_two(found, sound, scales) or weighed, like)


def _form_at_most(scales: Scales) -> Weighed:
    """Call a law complete whose leftover may be the form of its effects, unless it hides some or foretells worse.

    What is more than passes for form is asked for a part, as where more is missing.
    """
    law, tolerance = scales.law, scales.tolerance
    if law.lack.most_share > FORM_NOISE_SHARE:
        return part_or_nothing(scales, hidden_words(law.lack, scales.problem))
    elsewhere = foretold(law, scales.problem)
    if tolerance.counted(elsewhere) > FORM_NOISE_SHARE:
        return part_or_nothing(scales, foretold_words(law.lack, elsewhere))
    best = scales.usable[0] if scales.usable else None
    return _complete(form_words(law.lack, elsewhere, best=best, law=law), scales)


def _nothing_named(scales: Scales, pair: Judged | None) -> Weighed:
    """Say why nothing is named: the channel, or that no effect takes a material share."""
    law, problem = scales.law, scales.problem
    if scales.bent is not None:
        return _the_channel(scales.bent)
    if not scales.usable:
        return nothing_named("unknown", "no effect of the catalogue lowers the error on left-out conditions")
    most = max(scales.usable, key=lambda each: explained_share(each, law))
    none = nothing_named("unknown", immaterial_words(most, law, problem), pair)
    return replace(none, reasons=(*none.reasons, *pair_words(pair, most, law, problem)))


def _complete(reason: str, scales: Scales) -> Weighed:
    """Call a law complete for a reason, unless a part of it leaves mean forces open that are more than passes for form.

    What nobody foretells isn't explained.
    """
    if not scales.tolerance.proved:
        means = means_left_open(scales.law, scales.problem)
        if means.are_material:
            return nothing_named("unknown", means.words())
    return nothing_named("complete", reason)


def _but_for_the_channel(found: Weighed, scales: Scales) -> Weighed:
    """Name nothing where a bent force channel explains what is missing clearly better; no cause if it does as well."""
    named, bent = found.pair or found.named, scales.bent
    if named is None or bent is None or bent.akaike >= named.akaike + RIVAL_LIKELIHOOD:
        return found
    if bent.akaike < named.akaike - RIVAL_LIKELIHOOD:
        return _the_channel(bent)
    as_well = f"{bent.words()}; it would explain it as well"
    return replace(found.as_part(as_well), bent=bent)


def _the_channel(bent: BentChannel) -> Weighed:
    return replace(nothing_named("unknown", f"{bent.words()}; no effect explains it as well"), bent=bent)
