"""What fits to metrics make of the verdict: a cause, a part, rivals that can't be told apart, or nothing."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_identification.diagnosis.candidates import distinct
from pipeclamp_identification.diagnosis.named import WITH, joined_by_and
from pipeclamp_identification.diagnosis.thresholds import (
    BEYOND_DOUBT_DRAWS_SHARE,
    MATERIAL_PART_SHARE,
    RIVAL_DRAWS_SHARE,
)
from pipeclamp_identification.diagnosis.weighing.special_cases import is_special_case
from pipeclamp_identification.fitting.resampling import share_of_gains
from pipeclamp_identification.metrics_only.campaign import SCATTER_BEFOREHAND
from pipeclamp_identification.metrics_only.evidence import EXPECTED_FREEDOMS, MetricJudged, Scatter, by_rank
from pipeclamp_identification.metrics_only.thresholds import (
    FEWEST_FREEDOMS,
    GREATER_PART_SHARE,
    PAIR_TAKES_SHARE,
    REAL_CHANCE,
    RIVAL_LIKELIHOOD,
)
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.equations.effect import Effect
from pipeclamp_models.law.file import Verdict

MORE_TESTS = "run tests at further conditions, repeat some for the scatter, or record the loops"

NEARLY_ALWAYS_CHANCE = 0.995
"""A chance that is larger would be shown as 100 %."""
RAREST_CHANCE = 1e-5
"""A chance that is smaller is shown as less than this: its digits rest on the far end of a distribution."""
MOST_ASKED = 4
"""Likeliest effects, and likeliest pairs, that are asked for left-out conditions, at most."""


@dataclass(frozen=True)
class MetricWeighed:
    """What comes of weighing: the verdict, the laws with what is named, best first, and why."""

    verdict: Verdict
    laws: tuple[MetricJudged, ...]
    reasons: tuple[str, ...]


@dataclass(frozen=True)
class MetricScales:
    """Candidates on the scales.

    Attributes:
        law, richest: the law as it is, and with all that the metrics support.
        candidates: the law with one effect more each, best first.
        pairs: the law with an effect and one that scales only it, best first.
        chances: chance of each candidate's and pair's gain under scatter alone, by its name.
        lack: chance of what `law` and `richest` leave over under scatter alone.
        scatter: what no law explains.
        heldout: gives the sum of squared logs of each left-out condition, shape (C,), of a law.
    """

    law: MetricJudged
    richest: MetricJudged
    candidates: Sequence[MetricJudged]
    pairs: Sequence[MetricJudged]
    chances: Mapping[str, float]
    lack: tuple[float, float]
    scatter: Scatter
    heldout: Callable[[MetricJudged], Array]

    @property
    def much_remains(self) -> bool:
        """Whether all that the metrics support leaves more than scatter: what is named is a part then."""
        return self.lack[1] < REAL_CHANCE

    def of_richest(self, judged: MetricJudged) -> float:
        """Give the share of what the richest law explains beyond the law as it is that another one explains."""
        whole = self.law.squares - min(self.richest.squares, judged.squares)
        return float(np.clip((self.law.squares - judged.squares) / whole, 0.0, 1.0)) if whole > 0 else 0.0

    def on_left_out(self, judged: MetricJudged) -> float:
        """Give the share of the law's squares on left-out conditions that another one takes."""
        before = float(self.heldout(self.law).sum())
        return float(np.clip(1 - self.heldout(judged).sum() / before, 0.0, 1.0)) if before > 0 else 0.0

    def takes_part(self, judged: MetricJudged) -> bool:
        """Tell whether a law lowers the error on left-out conditions materially and beyond doubt."""
        gain = self.heldout(self.law) - self.heldout(judged)
        sure = len(gain) > 1 and share_of_gains(gain) > BEYOND_DOUBT_DRAWS_SHARE
        return bool(sure and self.on_left_out(judged) >= MATERIAL_PART_SHARE)


def weigh(scales: MetricScales) -> MetricWeighed:
    """Weigh the candidates; the last reason says what is taken for scatter."""
    found = _weighed(scales)
    return replace(found, reasons=(*found.reasons, _scatter_words(scales.scatter)))


def _weighed(scales: MetricScales) -> MetricWeighed:
    law = scales.law
    usable = [each for each in scales.candidates if not each.objections and each.squares < law.squares]
    sound = [each for each in usable if each.may_be_cause]
    likely = [each for each in sound if scales.chances[each.name] < REAL_CHANCE]
    both = [each for each in scales.pairs if _outdoes(each, likely[0] if likely else None, scales)]
    if scales.much_remains or not (likely or both):
        part = _part(usable, scales) if scales.lack[0] < REAL_CHANCE else None
        return part or _nothing(sound, likely, scales)
    best = both[0] if both else likely[0]
    share = scales.of_richest(best)
    if share < GREATER_PART_SHARE:
        patchwork = f"no effect alone explains the greater part of what is missing; the best, {best.name}, {share:.0%}"
        return MetricWeighed("unknown", (), (patchwork, MORE_TESTS))
    named = _with_rivals(best, [*both, *sound])
    if len(named) > 1:
        return MetricWeighed("ambiguous", named, (f"dW and W at these conditions can't tell {_all(named)} apart",))
    gain = f"{_both(best)} explains {share:.0%} of what the metrics show missing"
    return MetricWeighed("missing", (best,), (gain, *_brings(best), _by_chance(best, scales)))


def _nothing(sound: Sequence[MetricJudged], likely: Sequence[MetricJudged], scales: MetricScales) -> MetricWeighed:
    """Say that nothing is missing, or that nothing can be named for it."""
    law = scales.law
    if likely:
        return MetricWeighed("unknown", (), (_remains(scales), MORE_TESTS))
    hint = (
        f"no effect gains more than scatter does; of the likeliest, {sound[0].name}, "
        f"{_by_chance(sound[0], scales)}" if sound else "no effect gains anything"
    )  # fmt: skip
    if scales.lack[0] < REAL_CHANCE:
        more = f"{hint}; {MORE_TESTS}"
        return MetricWeighed("unknown", (), ("what is left is more than scatter, and no effect explains it", more))
    if law.freedoms < FEWEST_FREEDOMS:
        few = f"{law.residual.size} metrics less {law.parameters} parameters leave too little to judge the law by"
        return MetricWeighed("unknown", (), (few, MORE_TESTS))
    return MetricWeighed("complete", (), ("what dW and W show is scatter", hint))


def _remains(scales: MetricScales) -> str:
    added = scales.richest.effects
    return f"{' and '.join(added)} together leave more than scatter" if added else "what is left is more than scatter"


def _part(usable: Sequence[MetricJudged], scales: MetricScales) -> MetricWeighed | None:
    """Name what clearly takes most on left-out conditions, though much remains or its form isn't right; else None.

    Args:
        usable: candidates that nothing physical speaks against, likeliest first.
        scales: all of them.
    """
    alone = _taking_part(usable, scales)
    both = _taking_part([each for each in scales.pairs if not each.objections], scales)
    by_itself = alone[0] if alone else scales.law
    both = [each for each in both if each.score < by_itself.score and _takes_over(each, by_itself, scales)]
    taking = both or alone
    if not taking:
        return None
    best = taking[0]
    near = _without_simpler_ends([each for each in taking if each is best or _comes_near(each, best, scales)])
    best = near[0]
    named = tuple(next(each for each in near if each.effects[0] == name) for name in _firsts(near))
    takes = (
        f"{_both(best)} takes {scales.on_left_out(best):.0%} of what is missing (mean square of the logs, on left-out "
        "conditions)"
    )
    form = tuple(f"{words}: something else of similar form stands behind it" for words in best.reservations)
    further = (*form, *([_remains(scales)] if scales.much_remains else []))
    if len(named) > 1:
        return MetricWeighed("ambiguous", named, (f"{takes}; dW and W can't tell {_all(named)} apart", *further))
    return MetricWeighed("missing", named, (takes, *_brings(best), *further, _by_chance(best, scales)))


def _taking_part(laws: Sequence[MetricJudged], scales: MetricScales) -> list[MetricJudged]:
    """Give the laws that take the greater part of what the richest one does, and a part beyond doubt; best first."""
    able = [each for each in laws if scales.chances[each.name] < REAL_CHANCE]
    large = [each for each in able if scales.of_richest(each) >= GREATER_PART_SHARE][:MOST_ASKED]
    return sorted(filter(scales.takes_part, large), key=lambda each: float(scales.heldout(each).sum()))


def _comes_near(other: MetricJudged, best: MetricJudged, scales: MetricScales) -> bool:
    """Tell whether a law does better than the best on left-out conditions in some of their draws, or as a whole."""
    better = share_of_gains(scales.heldout(best) - scales.heldout(other)) > RIVAL_DRAWS_SHARE
    return better or other.score < best.score + RIVAL_LIKELIHOOD


def _without_simpler_ends(near: Sequence[MetricJudged]) -> list[MetricJudged]:
    """Leave out effects of which a special case is among them, and which ended at the end of their range: as that."""
    return [
        each
        for each in near
        if not (each.reservations and any(is_special_case(_first(other), _first(each)) for other in near))
    ]


def _first(judged: MetricJudged) -> Effect:
    return judged.structure.effect(judged.effects[0])


def _takes_over(pair: MetricJudged, alone: MetricJudged, scales: MetricScales) -> bool:
    """Tell whether a pair takes half, or more, of what one alone leaves on left-out conditions, beyond doubt.

    What the richest law leaves there as well counts for nothing: no effect takes it.
    """
    left, both = scales.heldout(alone), scales.heldout(pair)
    if share_of_gains(left - both) <= BEYOND_DOUBT_DRAWS_SHARE:
        return False
    explained = left.sum() - min(scales.heldout(scales.richest).sum(), both.sum())
    return bool(left.sum() - both.sum() >= PAIR_TAKES_SHARE * explained)


def _outdoes(pair: MetricJudged, alone: MetricJudged | None, scales: MetricScales) -> bool:
    """Tell whether an effect with what scales only it takes half, or more, of what the best one alone would leave."""
    if not pair.may_be_cause or scales.chances[pair.name] >= REAL_CHANCE:
        return False
    if alone is not None and not _clearly_likelier(pair, alone):
        return False
    whole = scales.law.squares - min(scales.richest.squares, pair.squares)
    by_itself = scales.law.squares - alone.squares if alone else 0.0
    together = scales.law.squares - pair.squares
    return together - by_itself >= PAIR_TAKES_SHARE * (whole - by_itself)


def outdoes_in_fit(pair: MetricJudged, alone: MetricJudged) -> bool:
    """Tell whether two effects together leave half, or less, of what one alone does, and are clearly likelier."""
    return pair.squares <= (1 - PAIR_TAKES_SHARE) * alone.squares and _clearly_likelier(pair, alone)


def _clearly_likelier(pair: MetricJudged, alone: MetricJudged) -> bool:
    return pair.score <= alone.score - RIVAL_LIKELIHOOD


def _with_rivals(best: MetricJudged, sound: Sequence[MetricJudged]) -> tuple[MetricJudged, ...]:
    """Give the best law and those that are about as likely, one for each first effect, likeliest first."""
    near = sorted(
        (each for each in sound if each is best or each.score < best.score + RIVAL_LIKELIHOOD),
        key=by_rank,
    )
    return tuple(next(each for each in near if each.effects[0] == name) for name in _firsts(near))


def _firsts(laws: Sequence[MetricJudged]) -> tuple[str, ...]:
    return distinct(each.effects[0] for each in laws)


def _all(named: Sequence[MetricJudged]) -> str:
    return joined_by_and([_both(one) for one in named])


def _both(judged: MetricJudged) -> str:
    return WITH.join(judged.effects)


def _brings(judged: MetricJudged) -> tuple[str, ...]:
    """Say why two effects come together."""
    if len(judged.effects) < 2:
        return ()
    first, second = judged.effects
    return (f"{second} scales what only {first} brings, so they come together",)


def _by_chance(judged: MetricJudged, scales: MetricScales) -> str:
    chance = scales.chances[judged.name]
    if chance >= NEARLY_ALWAYS_CHANCE:
        return "scatter alone would gain as much in nearly all cases"
    return f"scatter alone would gain as much in {chance_words(chance)} of all cases"


def chance_words(chance: float) -> str:
    """Say a chance in per cent; what is far below any that could be counted as such."""
    if chance < RAREST_CHANCE:
        return f"less than {100 * RAREST_CHANCE:g}%"
    return np.format_float_positional(100 * chance, precision=2, fractional=False, trim="-") + "%"


def _scatter_words(scatter: Scatter) -> str:
    dissipated, elastic = scatter.share
    few = int(scatter.freedoms.min() - EXPECTED_FREEDOMS)
    return (
        f"scatter is taken for {dissipated:.2%} of dW and {elastic:.2%} of W: {SCATTER_BEFOREHAND:.0%} was expected, "
        f"and what the richest law leaves ({few} more numbers than it has parameters) corrected it"
    )
