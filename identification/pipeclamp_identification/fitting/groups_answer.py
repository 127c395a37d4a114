"""What groups of runs answer: sentences, and the entry of JSON."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Literal

from pydantic import Field

from pipeclamp_identification.fitting.groups import GroupQuantity, Groups
from pipeclamp_models.base.answer import AnswerModel
from pipeclamp_models.base.said import counted
from pipeclamp_models.law.file import GroupEntry

LEFT_OUT_BESIDE = (
    "errors on left-out conditions are told without these differences, the error on the runs used with them"
)
"""How the two errors of a law are to be read where groups of its runs differ."""


class EstimateAnswer(AnswerModel):
    """A value with its standard error."""

    value: float
    standard_error: float


class GroupAnswer(AnswerModel):
    """One group of runs, against the law, which stands for the one in the middle; null where groups don't differ."""

    name: str
    runs: int
    stiffness_factor: EstimateAnswer | None
    damping_factor: EstimateAnswer | None
    mean_force_N: EstimateAnswer | None


class StrangerAnswer(AnswerModel):
    """A run that behaves like another group than the one that runs.csv puts it in."""

    run: str
    said: str
    behaves_like: str


class GroupsAnswer(AnswerModel):
    """A column of runs.csv by whose texts the runs differ, or can't be told from conditions."""

    column: str
    alike: tuple[str, ...] = Field(description="other columns that part the runs in the same way")
    differ: tuple[Literal["stiffness", "damping", "mean_force"], ...] = Field(
        description="in what the groups differ beyond chance, beside what their conditions make"
    )
    chance: Mapping[str, float] = Field(description="that scatter from run to run alone makes so much, by quantity")
    groups: tuple[GroupAnswer, ...]
    confounded_with: tuple[str, ...] = Field(description="conditions that the groups can't be told from in these tests")
    explained_by: tuple[str, ...] = Field(
        description="columns, constant inside each group, that explain a difference as well: left to their effects"
    )
    strangers: tuple[StrangerAnswer, ...]
    words: tuple[str, ...]


def groups_answer(found: Sequence[Groups]) -> tuple[GroupsAnswer, ...]:
    """Give the entries of what was found."""
    return tuple(
        GroupsAnswer(
            column=one.column,
            alike=one.alike,
            differ=one.differ,
            chance={str(quantity): chance for quantity, chance in one.chances.items()},
            groups=tuple(_group(one, place) for place in range(len(one.names))),
            confounded_with=one.confounded,
            explained_by=one.explained_by,
            strangers=tuple(
                StrangerAnswer(run=each.run, said=each.said, behaves_like=each.behaves_like) for each in one.strangers
            ),
            words=_words(one),
        )
        for one in found
    )


def _group(one: Groups, place: int) -> GroupAnswer:
    def estimate(quantity: GroupQuantity) -> EstimateAnswer | None:
        if quantity not in one.differ:
            return None
        values, errors = one.factors(quantity)
        return EstimateAnswer(value=float(values[place]), standard_error=float(errors[place]))

    return GroupAnswer(
        name=one.names[place],
        runs=one.counts[place],
        stiffness_factor=estimate("stiffness"),
        damping_factor=estimate("damping"),
        mean_force_N=estimate("mean_force"),
    )


def per_group_words(entries: Sequence[GroupEntry]) -> tuple[str, ...]:
    """Say what a law's file knows of the groups of its runs, a line each."""
    lines = []
    for entry in entries:
        parts = [
            f"{name} {_percent(estimate.value, estimate.standard_error)}"
            for name, estimate in (("stiffness", entry.stiffness_factor), ("damping", entry.damping_factor))
            if estimate
        ]
        if entry.mean_force_N:
            parts.append(f"mean force {entry.mean_force_N.value:+.3g} ± {entry.mean_force_N.standard_error:.1g} N")
        runs = counted(entry.runs, "run")
        lines.append(f"{entry.column} {entry.name} ({runs}) against the law: {', '.join(parts)}.")
    return tuple(lines)


def group_words(found: Sequence[Groups]) -> tuple[str, ...]:
    """Say what columns of texts do to the runs, in sentences."""
    return tuple(itertools.chain.from_iterable(_words(one) for one in found))


def _words(one: Groups) -> tuple[str, ...]:
    kinds = " and ".join((one.column, *one.alike))
    words = [_differ_words(one, kinds)] if one.differ else []
    words += [
        f"run {each.run} behaves like {each.behaves_like}, not like {each.said} as runs.csv says, and counts as "
        f"{each.behaves_like}'s; to do: look up which {one.column} it was"
        for each in one.strangers
    ]
    if one.confounded:
        conditions = " and ".join(one.confounded)
        words.append(
            f"{kinds} can't be told from {conditions}: each was tested at its own, and what looks like {conditions} "
            f"may be {one.column}; to do: test one {one.column} at another's conditions"
        )
    words += [
        f"the runs differ by {kinds}; {name}, one value for each, explains it as well and goes first: left to the "
        "effect that follows it"
        for name in one.explained_by
    ]
    return tuple(words)


def _differ_words(one: Groups, kinds: str) -> str:
    parts = []
    for quantity in one.differ:
        rows = zip(one.names, *one.factors(quantity), strict=True)
        if quantity == "mean_force":
            shown = [f"{name} {value:+.3g} ± {error:.1g} N" for name, value, error in rows]
        else:
            shown = [f"{name} {_percent(value, error)}" for name, value, error in rows]
        parts.append(f"{quantity.replace('_', ' ')} ({', '.join(shown)})")
    return (
        f"the runs differ by {kinds}, beside their conditions, in {'; in '.join(parts)}; the law stands for the one in "
        f"the middle, and physics is judged on what is left; {LEFT_OUT_BESIDE}"
    )


def _percent(factor: float, error: float) -> str:
    return f"{100 * (factor - 1):+.2f} ± {100 * error:.1g}%"
