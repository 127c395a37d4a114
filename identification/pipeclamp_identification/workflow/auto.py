"""Diagnose and add, again and again, until no step lowers the error on left-out conditions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from pipeclamp_identification.diagnosis.limits import Limits
from pipeclamp_identification.diagnosis.named import Kind, in_vain_words, no_help
from pipeclamp_identification.workflow.change import (
    Addition,
    add_effect,
    as_well_without,
    exchange,
    stays_as_good,
    without_spares,
)
from pipeclamp_identification.workflow.tests import Diagnosed, Tests, silent
from pipeclamp_models.base.progress import Progress
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import InVain, LastDiagnosis, LawFile
from pipeclamp_models.law.range import rounded

MOST_RUNGS = 12
MOST_EXCHANGED = 3
"""Laws with one thing exchanged that are refitted, best first, until one's error on left-out conditions falls."""


@dataclass(frozen=True)
class Rung:
    """One step of the ladder.

    Attributes:
        change: what was done to the law, and what the error did.
        kind: how it was named; `revision` where the law was asked again, and an effect went or another base came.
        words: what to mind of it.
    """

    change: Addition
    kind: Kind | Literal["revision"]
    words: tuple[str, ...]


@dataclass(frozen=True)
class Settled:
    """Where the repetition ended.

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

    def told(self, tests: str) -> LawFile:
        """Give the law with the last diagnosis in its file, on tests of this name."""
        last = LastDiagnosis(verdict=self.found.verdict, effects=self.found.effects, tests=tests, in_vain=self.in_vain)
        return self.file.model_copy(update={"diagnosis": last})

    def words(self) -> list[str]:
        """Say what each rung did to the error on left-out conditions, and what to mind of it."""
        words = []
        for rung in self.ladder:
            before, after = rung.change.heldout
            words.append(
                f"{rung.change.effect} ({rung.kind}): error on left-out conditions {before:.2%} -> {after:.2%}"
            )
            words += [f"  {word}" for word in rung.words]
        return words


def add_until_settled(
    file: LawFile,
    tests: Tests,
    *,
    command: str,
    declared: Sequence[Declaration] = (),
    limits: Limits | None = None,
    jobs: int = 1,
    progress: Progress = silent,
    most: int = MOST_RUNGS,
    seen: Callable[[Diagnosed, LawFile], None] = lambda found, file: None,
) -> Settled:
    """Add the missing effect and diagnose again, while one is missing and the error on left-out conditions falls.

    Of several effects that take much the same part the best is added, or the next where a refit with the best doesn't
    lower the error; where none does, the diagnosis names nothing. Of several that may be the cause none is, but where
    the law has a part already: the proposed test would tell. Beside a part, which may stand for something else, nothing
    is called the cause. After each step the effects so far are asked again:
    one that the law does as well without goes, for good. Where nothing is named, or nothing that is helps, the other
    base laws are tried, and in the place of each effect those that act alike; what does better beyond doubt takes the
    place. Where the law is complete, simpler effects that act alike are tried in the place of each part.

    Args:
        file: the law to begin with.
        tests: records, or metrics alone.
        command, declared, limits, jobs, progress: as for `add_effect` and `Tests.diagnose`.
        most: rungs at most.
        seen: is given each diagnosis with its law, once what it names has been tried.

    Raises:
        UserError: the data can't serve the law.
    """
    ladder: list[Rung] = []
    gone: dict[str, InVain] = {}
    while True:
        found = tests.diagnose(file, declared=declared, limits=limits, jobs=jobs, progress=progress)
        if found.verdict == "missing" and found.kind == "cause" and (parts := _parts(file, ladder)):
            found = found.naming_a_part(f"{' and '.join(parts)}, a part that the law has, may stand for something else")
        went = tuple(gone[name] for name in found.effects if name in gone)
        if went and found.effects[0] in gone:
            found = found.naming_nothing(in_vain_words(went))
        if len(ladder) >= most or not _goes_on(found, ladder):
            seen(found, file)
            whole = found.verdict == "complete" and len(ladder) < most
            rung = _with_something_simpler(file, ladder, tests, command, progress) if whole else None
            if rung is None:
                return Settled(file, found, tuple(ladder))
            ladder.append(rung)
            file = rung.change.after
            continue
        names = [name for name in found.effects if name not in gone]
        tried = _until_one_helps(file, names, found.values, tests, command, declared, progress)
        if tried and _helps(tried[-1]):
            seen(found, file)
            # the best of several isn't proved by being taken
            kind: Kind = "cause" if found.verdict == "missing" and found.kind == "cause" else "part"
            ladder.append(Rung(tried[-1], kind, (*_told(found, names, tried), *found.cautions())))
            name = having = names[len(tried) - 1]
        else:
            in_vain = (*went, *map(_in_vain, tried))
            found = found.naming_nothing(in_vain_words(in_vain)) if tried else found
            seen(found, file)
            rung = _with_something_exchanged(file, tests, command, progress)
            if rung is None:
                return Settled(file, found, tuple(ladder), in_vain)
            ladder.append(rung)
            name, having = rung.change.effect.rpartition(" -> ")[2], rung.change.effect
        file = ladder[-1].change.after
        for change in without_spares(file, name, tests, command=command, date=file.date, progress=progress):
            ladder.append(Rung(change, "revision", (as_well_without(change, having),)))
            spare = _in_vain(change)
            gone[spare.effect] = spare
            file = change.after


def _parts(file: LawFile, ladder: Sequence[Rung]) -> list[str]:
    """Give the effects that a law was given as parts, which prove nothing, and has still."""
    named = [rung.change.effect.removeprefix("+ ") for rung in ladder if rung.kind == "part"]
    return [name for name in named if name in file.effects]


def _until_one_helps(
    file: LawFile,
    names: Sequence[str],
    values: Mapping[str, float] | None,
    tests: Tests,
    command: str,
    declared: Sequence[Declaration],
    progress: Progress,
) -> list[Addition]:
    """Add one effect or another to a law, until one lowers the error on left-out conditions; give what was tried.

    The fit of the first begins at the values that are given.
    """
    tried: list[Addition] = []
    for name in names:
        start = None if tried else values
        tried.append(
            add_effect(
                file, name, tests, command=command, date=file.date, declared=declared, start=start, progress=progress
            )
        )
        if _helps(tried[-1]):
            break
    return tried


def _in_vain(change: Addition) -> InVain:
    """Give what a law was refitted with, or without, and isn't to have."""
    errors = tuple(map(rounded, change.heldout))
    without, having = reversed(errors) if change.effect.startswith("- ") else errors
    return InVain(effect=change.effect.lstrip("+- "), refitted_nrmse=(without, having))


def _helps(addition: Addition) -> bool:
    return addition.heldout[1] < addition.heldout[0]


def _goes_on(found: Diagnosed, ladder: Sequence[Rung]) -> bool:
    """Tell whether there is something to do.

    A part is no claim, so the best of several that act alike may be taken; and where the law has a part already, which
    may stand for something else, so may the best of several causes, as a part too.
    """
    if found.verdict == "ambiguous":
        return found.kind == "part" or any(rung.kind == "part" for rung in ladder)
    return found.verdict in ("missing", "unknown")


def _told(found: Diagnosed, names: Sequence[str], tried: Sequence[Addition]) -> tuple[str, ...]:
    """Say what the effect that was added takes, or what was tried in vain before it; and what would do as well."""
    before = tuple(no_help(_in_vain(addition)) for addition in tried[:-1])
    others = names[len(tried) :]
    rivals = (f"{' or '.join(others)} would have done much the same",) if others else ()
    return (*(before or found.rung()), *rivals)


def _with_something_exchanged(file: LawFile, tests: Tests, command: str, progress: Progress) -> Rung | None:
    """Put a law on another base, or another effect of a family in one's place; None where none does better."""
    for structure in tests.better_structures(file, progress)[:MOST_EXCHANGED]:
        change = exchange(file, structure, tests, command=command, date=file.date, progress=progress)
        if _helps(change):
            return Rung(change, "revision", (f"{change.effect}: the error on left-out conditions falls beyond doubt",))
    return None


def _with_something_simpler(
    file: LawFile, ladder: Sequence[Rung], tests: Tests, command: str, progress: Progress
) -> Rung | None:
    """Put a simpler effect in the place of a part that it acts like; None where none does as well.

    A part was taken while more was missing, which may have bent what it was chosen by.
    """
    parts = _parts(file, ladder)
    structure = tests.simpler_structure(file, parts, progress) if parts else None
    if structure is None:
        return None
    change = exchange(file, structure, tests, command=command, date=file.date, progress=progress)
    if not stays_as_good(change):
        return None
    return Rung(change, "revision", (f"{change.effect}: the law does as well with fewer parameters",))
