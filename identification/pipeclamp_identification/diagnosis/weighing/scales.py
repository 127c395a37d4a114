"""What is weighed, and what comes of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from pipeclamp_identification.diagnosis.problem import Judged, Problem
from pipeclamp_identification.diagnosis.repeats import Unstated
from pipeclamp_identification.diagnosis.weighing.channel import BentChannel, bent_channel
from pipeclamp_identification.diagnosis.weighing.rivals import bettering, rivals_of
from pipeclamp_identification.diagnosis.weighing.special_cases import simpler_than
from pipeclamp_identification.diagnosis.weighing.tolerance import Tolerance, explains, may_be_form
from pipeclamp_models.base.processes import Workers
from pipeclamp_models.law.file import NamedKind, Verdict
from pipeclamp_models.law.law import Structure


@dataclass(frozen=True)
class Weighed:
    """What the candidates make of the verdict, but for what doesn't repeat with each cycle; see `verdict.Diagnosis`.

    Attributes:
        verdict, effects, kind: as of `RecordDiagnosed`.
        named: the law with what is named first, by which the leftover is told.
        pair: the law with the best pair of effects, where pairs were tried.
        reasons: why, in words.
        others: laws with another effect each that takes a part too, much the same one first.
        unstated: what differs between runs at the same stated conditions.
        bent: a force channel that would explain it all.
    """

    verdict: Verdict
    effects: tuple[str, ...]
    kind: NamedKind | None
    named: Judged | None
    pair: Judged | None
    reasons: tuple[str, ...]
    others: tuple[Judged, ...] = ()
    unstated: Unstated | None = None
    bent: BentChannel | None = None

    def as_part(self, why: str) -> Weighed:
        """Give the same with what is named as a part, and why it is no cause."""
        return replace(self, kind="part", reasons=(*self.reasons, why))


@dataclass(frozen=True)
class Scales:
    """Candidates on the scales.

    Attributes:
        structure: of the law.
        problem: the data.
        law: the law as it is, refitted.
        candidates: every effect that was fitted, best first.
        tolerance: lack of fit that is let pass.
        workers: who does it, and who is told.
    """

    structure: Structure
    problem: Problem
    law: Judged
    candidates: Sequence[Judged]
    tolerance: Tolerance
    workers: Workers

    @property
    def form_allowed(self) -> bool:
        """Whether what is missing is so small that it may be the form of the effects that the law has."""
        return may_be_form(self.law, self.tolerance)

    @cached_property
    def usable(self) -> list[Judged]:
        """Candidates that better the law, and may take a part of what is missing at least; best first.

        A general effect whose special case leaves about as much isn't among them; but where another effect outdoes
        that, and it outdoes the other, it is.
        """
        able = bettering(self.candidates, self.law)
        special = {id(each): simpler_than(each, able, self.law, self.tolerance) for each in able}
        found = [each for each in able if not special[id(each)]]
        return [each for each in able if all(self._is_between(one, each, found) for one in special[id(each)])]

    def _is_between(self, special: Judged, general: Judged, others: Sequence[Judged]) -> bool:
        """Tell whether another that explains it is clearly better than a special case, and the general effect than it.

        The other would be named then, and the special case doesn't stand for the general one.
        """
        better = (one for one in others if one is not special and one.may_be_cause and self.explains(one))
        return any(
            not rivals_of(one, [special], self.problem) and not rivals_of(general, [one], self.problem)
            for one in better
        )

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
        return explains(candidate, self.law, self.tolerance) and not rivals_of(candidate, [self.law], self.problem)


def nothing_named(verdict: Verdict, reason: str, pair: Judged | None = None) -> Weighed:
    """Name no effect, for a reason."""
    return Weighed(verdict, (), None, None, pair, (reason,))
