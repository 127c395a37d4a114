"""What a diagnosis names: how it is meant, where nothing shows it, and what was tried on the same tests in vain."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Protocol, Self, TypeVar

import numpy as np

from pipeclamp_identification.signals.levels import known_levels, varies
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.digits import error_goes
from pipeclamp_models.base.signals import condition_signal
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import InVain, LawFile, NamedKind, Verdict
from pipeclamp_models.law.outline import ParameterOutline, levels_taken
from pipeclamp_models.law.step import LawStep, read_step

NO_PROOF = "a part is no proof: something else that acts alike may stand behind it"
WITH = " with "
"""Joins the names of two that help only together."""
FURTHER_TESTS = "tests at further conditions would tell whether it is real"
OF_A_MOTION = {"A": ("amplitude", "mm"), "f": ("frequency", "Hz")}
"""Conditions that a law is asked for at other values than those tested."""


def joined_by_and(names: Sequence[str]) -> str:
    """Give names as a sentence lists them.

    >>> joined_by_and(["inertia", "play", "gap"])
    'inertia, play and gap'
    """
    return " and ".join(filter(None, [", ".join(names[:-1]), *names[-1:]]))


class Naming(Protocol):
    """A diagnosis, as far as it names something."""

    @property
    def verdict(self) -> Verdict:
        """See docs/reference/answers.md."""

    @property
    def effects(self) -> tuple[str, ...]:
        """What is missing, or may be, as `add` takes it; best first."""

    @property
    def kind(self) -> NamedKind | None:
        """How what is named is meant: as the cause, or as a part of what is missing."""

    @property
    def together(self) -> Sequence[str]:
        """What is named first, and the effect without which it clearly takes nothing; empty where it does alone."""

    def naming_a_part(self, reason: str) -> Self:
        """Give the same with what it names as the cause for a part, for this reason."""

    def naming_nothing(self, reason: str) -> Self:
        """Give the same with `unknown` for a verdict: what it named didn't help."""


Named = TypeVar("Named", bound=Naming)


def untested_words(slow: Mapping[str, Array], *, timed: bool) -> tuple[str, ...]:
    """Say which condition of a motion has one value in all tests: of others no verdict can tell.

    Args:
        slow: each condition of the tests, shape (R, 1).
        timed: whether their time was measured; frequencies mean nothing otherwise.
    """
    nominal = () if timed else ("f",)
    return tuple(
        f"all tests are at one {condition}, {float(np.median(slow[name])):.3g} {unit}: what the law does at others, "
        "nothing here shows"
        for name, (condition, unit) in OF_A_MOTION.items()
        if not varies(name, slow[name]) and name not in nominal
    )


def few_levels_words(parameters: Iterable[ParameterOutline], conditions: Mapping[str, Array]) -> tuple[str, ...]:
    """Say of which further conditions tests have no more levels than the curve takes by which a law follows them.

    Args:
        parameters: what of the law was fitted.
        conditions: further columns of the tests, by name, shape (R,).
    """
    fitted = tuple(parameters)
    words = []
    for name, values in conditions.items():
        taken, levels = levels_taken(condition_signal(name), fitted), len(known_levels(values))
        if levels <= taken:
            words.append(
                f"the tests have {levels} levels of {name}, no more than the curve takes by which the law follows it: "
                "what it does between them, nothing here shows"
            )
    return tuple(words)


def by_history(found: Named, file: LawFile, fingerprint: str, declared: Collection[Declaration] = ()) -> Named:
    """Give a diagnosis by what the law's file knows of its way.

    What a ladder that ended on the same tests has tried in vain isn't named again. Beside what may stand for something
    else nothing is called the cause.

    Args:
        found: the diagnosis.
        file: the law.
        fingerprint: of the tests.
        declared: a user's own effects.
    """
    named = [WITH.join(found.together)] if found.together else found.effects
    if in_vain := _tried_in_vain(named, file, fingerprint, declared):
        return found.naming_nothing(in_vain)
    if found.verdict == "missing" and found.kind == "cause" and (parts := unproved_of(file)):
        return found.naming_a_part(f"{' and '.join(parts)}, a part that the law has, may stand for something else")
    return found


def parts_of(file: LawFile) -> list[str]:
    """Give the effects of a law that were added as parts, which prove nothing."""
    came = {name for one in file.history if one.kind == "part" for name in read_step(one.step).come}
    return [name for name in file.effects if name in came]


def unproved_of(file: LawFile) -> list[str]:
    """Give what of a law may stand for something else: its parts, and a base that was changed for its errors.

    Not a constant force where most of the force is a constant load: no effect of the motion makes as much of a mean.
    """
    steps = [read_step(one.step) for one in file.history]
    bases = [str(LawStep(base=file.base))] if any(step.base for step in steps) else []
    freed = {name for step in steps for name in step.freed}
    bases += [f"base {step}" for step in steps if set(step.held) - freed]
    loaded = file.fit is not None and file.fit.mean_share is not None
    parts = [name for name in parts_of(file) if not (loaded and _is_constant(name))]
    return [*parts, *bases]


def _is_constant(name: str) -> bool:
    # equations load SymPy, which takes half a second
    from pipeclamp_models.equations.effect import Effect
    from pipeclamp_models.law.catalogue import effect_id, find_entry

    entry = find_entry(effect_id(name))
    return isinstance(entry, Effect) and entry.is_constant


def _tried_in_vain(effects: Sequence[str], file: LawFile, fingerprint: str, declared: Collection[Declaration]) -> str:
    """Say that all effects that a diagnosis names were tried in vain; empty where one is new, or the tests are.

    Args:
        effects: what the diagnosis names.
        file: the law.
        fingerprint: of the tests.
        declared: a user's own effects: their files may have changed since.
    """
    known = in_vain_on(file, fingerprint, declared)
    if not effects or not known.keys() >= set(effects):
        return ""
    return in_vain_words([known[name] for name in effects])


def in_vain_on(file: LawFile, fingerprint: str, declared: Collection[Declaration] = ()) -> dict[str, InVain]:
    """Give what was tried in vain on tests, by effect; arguments as for `by_history`."""
    if file.diagnosis is None or file.data.fingerprint != fingerprint:
        return {}
    own = {declaration.id for declaration in declared}
    return {one.effect: one for one in file.diagnosis.in_vain if one.effect not in own}


def in_vain_words(tried: Sequence[InVain]) -> str:
    """Say what was tried in vain, and what would tell more."""
    return f"{'; '.join(map(no_help, tried))}; {FURTHER_TESTS}"


def no_help(tried: InVain) -> str:
    """Say that an effect was tried, and what the error did."""
    without, having = tried.refitted_nrmse
    if having < without:  # by less than is worth an effect
        return f"{tried.effect} went, for the law did as well without it ({error_goes(having, without)})"
    return (
        f"{tried.effect} was tried and not added: the error on left-out conditions didn't fall "
        f"({error_goes(without, having)})"
    )
