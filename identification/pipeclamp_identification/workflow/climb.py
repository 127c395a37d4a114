"""One way up the ladder: diagnose and add, again and again, until no step lowers the error on left-out conditions."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Literal, NamedTuple

from pipeclamp_identification.diagnosis.further_test.limits import Limits
from pipeclamp_identification.diagnosis.named import NO_PROOF, WITH, in_vain_words, no_help, parts_of, unproved_of
from pipeclamp_identification.diagnosis.thresholds import HALF_TAKEN_SHARE
from pipeclamp_identification.workflow.change import (
    LawChange,
    add_effects,
    as_well_without,
    clearly_better,
    exchange,
    fits_samples,
    helps,
    refit,
    stays_as_good,
    takes,
    without_spare_powers,
    without_spares,
)
from pipeclamp_identification.workflow.tests import Diagnosed, Tests
from pipeclamp_models.base.digits import error_goes
from pipeclamp_models.base.processes import Workers
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import InVain, LastDiagnosis, LawFile, NamedKind, Provenance
from pipeclamp_models.law.law import Structure, find_base
from pipeclamp_models.law.range import rounded

MOST_EXCHANGED = 3
"""Laws with one thing exchanged that are refitted, best first, until one's error on left-out conditions falls."""

OTHER_VALUES = "the law was judged with other values of its parameters, by which it errs less: it is fitted from these"


@dataclass(frozen=True)
class Rung:
    """One step of the ladder.

    Attributes:
        change: what was done to the law, and what the error did.
        kind: how it was named; `revision` where the law was asked again, and an effect went or another base came.
        words: what to mind of it.
        rivals: what might as well have been added in its place, best first.
        next_test: the test that would tell these apart, or why there is none, in words; "" where there are none.
        with_next: whether it was named together with what the next rungs add, without which it needn't help.
    """

    change: LawChange
    kind: NamedKind | Literal["revision"]
    words: tuple[str, ...]
    rivals: tuple[str, ...] = ()
    next_test: str = ""
    with_next: bool = False

    def said(self) -> str:
        """Say what was done, and what the error on left-out conditions did."""
        kind = f"{self.kind}, with the next one" if self.with_next else self.kind
        return f"{self.change.step} ({kind}): error on left-out conditions {error_goes(*self.change.heldout)}"


@dataclass(frozen=True)
class Settled:
    """Where a ladder ended.

    Attributes:
        file: the law.
        found: the last diagnosis.
        ladder: what was done on the way.
        in_vain: what the last diagnosis named, and didn't help.
    """

    file: LawFile
    found: Diagnosed
    ladder: tuple[Rung, ...]
    in_vain: tuple[InVain, ...] = ()

    @property
    def heldout(self) -> float:
        """Error of the law on left-out conditions; infinite where no rung has stated it."""
        return self.ladder[-1].change.heldout.after if self.ladder else math.inf

    def with_diagnosis(self, tests: str) -> LawFile:
        """Give the law with the last diagnosis in its file, on tests of this name."""
        last = LastDiagnosis(verdict=self.found.verdict, effects=self.found.effects, tests=tests, in_vain=self.in_vain)
        return self.file.model_copy(update={"diagnosis": last})

    def words(self) -> list[str]:
        """Say what each rung did to the error on left-out conditions, and what to mind of it."""
        words = []
        for rung in self.ladder:
            words += [rung.said(), *(f"  {word}" for word in rung.words)]
        return words


class MadeOf(NamedTuple):
    """What a law is made of: base, and effects in whatever order."""

    base: str
    effects: frozenset[str]

    @classmethod
    def of(cls, law: LawFile | Structure) -> MadeOf:
        """Give what a law is made of."""
        return cls(law.base, frozenset(law.effects))


@dataclass(frozen=True)
class Place:
    """Where a ladder has come to.

    Attributes:
        file: the law there.
        ladder: what was done on the way.
        gone: effects that went, for good, by name.
    """

    file: LawFile
    ladder: tuple[Rung, ...] = ()
    gone: Mapping[str, InVain] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def made_of(self) -> MadeOf:
        """What the law is made of."""
        return MadeOf.of(self.file)

    def after(self, *rungs: Rung) -> Place:
        """Give the place to which further rungs lead."""
        return replace(self, file=rungs[-1].change.after, ladder=(*self.ladder, *rungs))

    def without(self, spare: InVain) -> Place:
        """Give the place with an effect that went for good."""
        return replace(self, gone={**self.gone, spare.effect: spare})


@dataclass(frozen=True)
class Fork:
    """A place on the way where another effect takes a part too.

    Attributes:
        place: the place.
        effect: the other effect.
        taken: what was added in its place.
        share: how much it takes of what that does.
    """

    place: Place
    effect: str
    taken: str
    share: float


@dataclass(frozen=True)
class _Onward:
    """Where a diagnosis leads: the next place, and where the way could have gone another way."""

    place: Place
    forks: tuple[Fork, ...] = ()


@dataclass(frozen=True)
class WayUp:
    """A way up.

    Attributes:
        settled: where it ended; None where it came to a law that another way had come by, and so would end like that.
        forks: where it could have gone another way.
        met: the laws that it came by.
    """

    settled: Settled | None
    forks: tuple[Fork, ...]
    met: frozenset[MadeOf]


@dataclass(frozen=True)
class Climber:
    """What a ladder is climbed with; see `auto.add_until_settled`."""

    tests: Tests
    command: str
    declared: Sequence[Declaration]
    limits: Limits | None
    workers: Workers
    most: int
    seen: Callable[[Diagnosed, LawFile], None]
    climbed: Callable[[LawFile, tuple[Rung, ...]], None]

    def climb(self, place: Place, before: frozenset[MadeOf] = frozenset()) -> WayUp:
        """Diagnose and add until nothing helps.

        Args:
            place: where to begin.
            before: laws that other ways came by.
        """
        forks: tuple[Fork, ...] = ()
        met: frozenset[MadeOf] = frozenset()
        while place.made_of not in before:
            met |= {place.made_of}
            led = self._led_from(place, before)
            if isinstance(led, Settled):
                return WayUp(led, forks, met)
            place, forks = led.place, (*forks, *led.forks)
        return WayUp(None, forks, met)

    def climb_from(self, fork: Fork, ended: float, before: frozenset[MadeOf]) -> WayUp:
        """Add the other effect at a fork, and go on from there.

        Args:
            fork: the fork.
            ended: error on left-out conditions where the way ended that didn't take it.
            before: laws that other ways came by.
        """
        (change,) = self._added(fork.place.file, [fork.effect], "part")
        words = (
            f"by itself it takes {fork.share:.0%} of what {fork.taken} does, but with {fork.taken} in its place the "
            f"ladder ended at {ended:.2%} on left-out conditions"
        )
        place = fork.place.after(Rung(change, "part", (words, NO_PROOF)))
        return self.climb(self._without_spares(place, fork.effect, fork.effect), before)

    def _led_from(self, place: Place, before: frozenset[MadeOf]) -> Settled | _Onward:
        """Diagnose the law at a place, and add to it, exchange something in it, or end there.

        Where what is named takes less than half of what is missing, a part may stand where its like belongs: what does
        better in a part's place is asked, and goes first if it leaves less. Nothing is exchanged for a law that another
        way came by, which has shown where that leads.
        """
        if place.ladder:
            self.climbed(place.file, place.ladder)
        found = self.tests.diagnose(place.file, declared=self.declared, limits=self.limits, workers=self.workers)
        went = tuple(place.gone[name] for name in found.effects if name in place.gone)
        if went and found.effects[0] in place.gone:
            found = found.naming_nothing(in_vain_words(went))
        if len(place.ladder) >= self.most or not _goes_on(found, place.file):
            return self._simpler_or_settled(place, found, went)
        tried = self._until_one_helps(place, found)
        helped = bool(tried) and helps(tried[-1])
        parts = parts_of(place.file)
        goes_well = helped and (takes(tried[-1], HALF_TAKEN_SHARE) or not parts)
        rung = None if goes_well else self._with_something_exchanged(place.file, parts if helped else None, before)
        if helped and (rung is None or tried[-1][-1].heldout.after <= rung.change.heldout.after):
            self.seen(found, place.file)
            added = tried[-1][-1].step.effect
            forks = _forks(place, found, tried[-1][0].step.effect)
            return _Onward(self._without_spares(place.after(*_rungs(found, tried)), added, added), tuple(forks))
        failed = () if helped else tuple(map(_in_vain, tried))
        in_vain = (*went, *failed)
        found = found.naming_nothing(in_vain_words(in_vain)) if failed else found
        self.seen(found, place.file)
        if rung is None:
            return self._settled(place, found, in_vain)
        step = rung.change.step
        return _Onward(self._without_spares(place.after(rung), step.effect, str(step)))

    def _simpler_or_settled(self, place: Place, found: Diagnosed, went: tuple[InVain, ...]) -> Settled | _Onward:
        """Put something simpler into a law to which nothing is to be added, where that does as well, or end there."""
        self.seen(found, place.file)
        whole = found.verdict == "complete" and len(place.ladder) < self.most
        simpler = self._with_something_simpler(place.file) if whole else None
        return self._settled(place, found, went) if simpler is None else _Onward(place.after(simpler))

    def _settled(self, place: Place, found: Diagnosed, in_vain: tuple[InVain, ...]) -> Settled | _Onward:
        """End at a place, or go on from the values by which the diagnosis judged the law, where these do better.

        A fit that begins at another law's values may end in a lower valley than the law's own. Nor is that the end
        where the law's memory spares it powers of the amplitude: what they imitated may show then.
        """
        if not found.effects and found.values and len(place.ladder) < self.most:
            made, tell = self._provenance(place.file), self.workers.tell
            change = refit(place.file, self.tests, provenance=made, start=found.values, progress=tell)
            if clearly_better(change):
                return _Onward(place.after(Rung(change, "revision", (OTHER_VALUES,))))
        spared = self._without_spare_powers(place.file, found) if len(place.ladder) < self.most else None
        if spared is not None:
            return _Onward(place.after(spared))
        return Settled(place.file, found, place.ladder, in_vain)

    def _until_one_helps(self, place: Place, found: Diagnosed) -> list[list[LawChange]]:
        """Add one effect that is named or another, until one lowers the error on left-out conditions.

        The fit of the first begins at the values that are known of it; what it needs beside it is added too.

        Returns:
            what was tried, each in its steps; those that went aren't.
        """
        tried: list[list[LawChange]] = []
        for name in (name for name in found.effects if name not in place.gone):
            whole = not tried and found.together
            named = found.together if whole else (name,)
            tried.append(self._added(place.file, named, _kind(found), None if tried else found.values))
            if helps(tried[-1]):
                break
        return tried

    def _provenance(self, file: LawFile) -> Provenance:
        """Give how a law that is made of another comes about: by the ladder's command, at the time of the first."""
        return Provenance(self.command, file.date)

    def _added(
        self, file: LawFile, effects: Sequence[str], kind: NamedKind, start: Mapping[str, float] | None = None
    ) -> list[LawChange]:
        return add_effects(
            file, effects, self.tests, provenance=self._provenance(file), declared=self.declared, kind=kind,
            start=start, progress=self.workers.tell,
        )  # fmt: skip

    def _without_spares(self, place: Place, keep: str, having: str) -> Place:
        """Take out what the law at a place does as well without, now that it has something.

        Args:
            place: the place.
            keep: the effect that was added last, which isn't asked.
            having: what was added last, in words.
        """
        made = self._provenance(place.file)
        for change in without_spares(place.file, keep, self.tests, provenance=made, progress=self.workers.tell):
            rung = Rung(change, "revision", (as_well_without(change, having),))
            place = place.after(rung).without(_in_vain([change]))
        return place

    def _with_something_exchanged(
        self, file: LawFile, names: Collection[str] | None, before: frozenset[MadeOf]
    ) -> Rung | None:
        """Put another effect of a family in one's place, or a law on another base; None where none does better.

        Args:
            file: the law.
            names: its effects that are asked; None for all, and its base.
            before: laws that other ways came by.
        """
        better = self.tests.better_structures(file, names, self.workers)
        for structure in [one for one in better if MadeOf.of(one) not in before][:MOST_EXCHANGED]:
            change = self._exchanged(file, structure)
            if change.heldout.after < change.heldout.before and fits_samples(change):
                words = f"{change.step}: the error on left-out conditions falls beyond doubt"
                return Rung(change, "revision", (words, *_energy_words(change.after)))
        return None

    def _with_something_simpler(self, file: LawFile) -> Rung | None:
        """Put a simpler effect in the place of a part that it acts like; None where none does as well.

        A part was taken while more was missing, which may have bent what it was chosen by.
        """
        parts = parts_of(file)
        structure = self.tests.simpler_structure(file, parts, self.workers) if parts else None
        if structure is None:
            return None
        change = self._exchanged(file, structure)
        if not stays_as_good(change):
            return None
        return Rung(change, "revision", (f"{change.step}: the law does as well with fewer parameters",))

    def _without_spare_powers(self, file: LawFile, found: Diagnosed) -> Rung | None:
        """Take out the powers of the amplitude that a law's memory spares; None where it needs each.

        Only at the end: while much is missing, next to nothing is seen of a power that is the device's own.
        """
        if found.verdict not in ("complete", "unknown"):
            return None
        change = without_spare_powers(
            file, self.tests, complete=found.verdict == "complete", provenance=self._provenance(file),
            progress=self.workers.tell,
        )  # fmt: skip
        return Rung(change, "revision", (_spared(change),)) if change else None

    def _exchanged(self, file: LawFile, structure: Structure) -> LawChange:
        return exchange(file, structure, self.tests, provenance=self._provenance(file), progress=self.workers.tell)


def _forks(place: Place, found: Diagnosed, taken: str) -> list[Fork]:
    return [
        Fork(place, effect, taken, share) for effect, share in found.other_parts.items() if effect not in place.gone
    ]


def _rungs(found: Diagnosed, tried: Sequence[Sequence[LawChange]]) -> list[Rung]:
    """Give the rungs of what was tried last and helped."""
    kind = _kind(found)
    *before, (first, *beside) = tried
    others = tuple(name for name in found.effects if name not in {steps[0].step.effect for steps in tried})
    alike = (_alike(others), _told_apart(found)) if others else ()
    told, last = found.rung(), [first, *beside][-1]
    rung = (*told[:1], *found.refitted(first.heldout.before, last.heldout.after), *told[1:])
    before_it = tuple(no_help(_in_vain(steps)) for steps in before) or rung
    proof = () if kind == "cause" or NO_PROOF in found.cautions() else (NO_PROOF,)  # one of several causes is a part
    needed = f"{first.step.effect} needs it beside it"
    return [
        Rung(first, kind, (*before_it, *alike, *found.cautions(), *proof), others, "".join(alike[1:]), bool(beside)),
        *(Rung(step, kind, (needed,), with_next=step is not last) for step in beside),
    ]


def _alike(others: Sequence[str]) -> str:
    """Say that other effects might as well have been added."""
    return (
        f"it was ambiguous: {' or '.join(others)} would have done much the same, and these tests can't tell which it is"
    )


def _told_apart(found: Diagnosed) -> str:
    """Say which test tells apart what may be missing, or why none does."""
    if found.proposal is None:
        return f"no test tells them apart: {found.no_test}"
    return f"the test that tells them apart: {found.proposal.words()}"


def _kind(found: Diagnosed) -> NamedKind:
    """Say how what is added is meant: the best of several isn't proved by being taken."""
    return "cause" if found.verdict == "missing" and found.kind == "cause" else "part"


def _spared(change: LawChange) -> str:
    """Say that powers of the amplitude went, and why."""
    return (
        f"{change.step} the law errs by next to no more: along sines A stands for what has gone before, which the "
        "law's memory knows along any motion"
    )


def _energy_words(file: LawFile) -> tuple[str, ...]:
    """Say that a law could create energy; only a base is asked whose damping has coefficients of either sign."""
    if not find_base(file.base).signed:
        return ()
    from pipeclamp_fmu.build import creates_energy  # loads what FMUs are built with

    return ("over some cycles this law would create energy: `build-fmu` refuses it",) if creates_energy(file) else ()


def _in_vain(steps: Sequence[LawChange]) -> InVain:
    """Give what a law was refitted with, or without, and isn't to have."""
    without, having = rounded(steps[0].heldout.before), rounded(steps[-1].heldout.after)
    if not steps[0].step.come:
        without, having = having, without
    return InVain(effect=WITH.join(change.step.effect for change in steps), refitted_nrmse=(without, having))


def _goes_on(found: Diagnosed, file: LawFile) -> bool:
    """Tell whether there is something to do.

    A part is no claim, so the best of several that act alike may be taken; and where the law has what may stand for
    something else already, so may the best of several causes, as a part too.
    """
    if found.verdict == "ambiguous":
        return found.kind == "part" or bool(unproved_of(file))
    return found.verdict in ("missing", "unknown")
