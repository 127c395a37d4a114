"""Groups of runs that differ beside their conditions: which, by how much, in what; and runs that are of another group.

What conditions may do goes first: a group's share is what is left beside them. So a condition that is constant inside
each group (a density) explains what it can, and groups that were tested at conditions of their own can't be told from
them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from pipeclamp_identification.fitting.group_factors import GroupFactors, Mixed, contrasts_of, mixed
from pipeclamp_identification.fitting.observations import LoopObservations
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_identification.signals.levels import SAME_KELVIN, SAME_SHARE, group_names, number_levels
from pipeclamp_identification.signals.orthonormal import orthonormal
from pipeclamp_identification.signals.real_harmonics import elastic_and_damping
from pipeclamp_identification.signals.sample_noise import scatter_by_median
from pipeclamp_models.base.arrays import Array, IntArray
from pipeclamp_models.base.signals import signal_of
from pipeclamp_models.realise.force import LawForce

GroupQuantity = Literal["stiffness", "damping", "mean_force"]
QUANTITIES: tuple[GroupQuantity, ...] = ("stiffness", "damping", "mean_force")

CHANCE_SHARE = 1e-3
"""Groups that differ so much by chance, over all columns and quantities, less often than this do differ."""
MATERIAL_SHARE = 5e-4
"""Groups whose factors spread by less than this share (of the force, for mean forces) don't matter: few load cells are
truer."""
FEWEST_FREE = 4
"""Runs that conditions and groups must leave free to show their scatter."""
STRANGE = 5.0
"""Standard deviations that a run must be off its own group, by the others' scatter, to be of another one."""
AT_HOME = 1 / 3
"""And no more than this share of that off the other one."""
MOST_STRANGE = 0.1
"""Share of the runs that may be strangers; more say that the column itself is in doubt."""


@dataclass(frozen=True)
class Stranger:
    """A run that behaves like another group than the one that runs.csv puts it in."""

    run: str
    said: str
    behaves_like: str


@dataclass(frozen=True)
class Groups:
    """What a column of labels does.

    Attributes:
        column: its name; `alike` names columns that part the runs in the same way.
        names: of the groups.
        of_run: the group of each run, strangers in the one that they behave like, blank where there is none.
        counts: runs of each group.
        own: conditions that are constant inside each group.
        contrasts: differences that a fit may give the groups, orthonormal, one a column, shape (G, K): none that
            follows such a condition, for that is for an effect to explain.
        differ: quantities in which the groups differ beyond chance.
        chances: that chance alone makes so much, by quantity.
        shares: of stiffness and damping, and mean forces in N, of each group, by quantity that differs.
        confounded: conditions that the groups can't be told from.
        explained_by: conditions, constant inside each group, that explain a difference as well.
        strangers: runs that are of another group.
    """

    column: str
    alike: tuple[str, ...]
    names: tuple[str, ...]
    of_run: Mapping[str, str]
    counts: tuple[int, ...]
    own: tuple[str, ...]
    contrasts: Array
    differ: tuple[GroupQuantity, ...]
    chances: Mapping[GroupQuantity, float]
    shares: Mapping[GroupQuantity, Mixed]
    confounded: tuple[str, ...]
    explained_by: tuple[str, ...]
    strangers: tuple[Stranger, ...]

    def factors(self, quantity: GroupQuantity) -> tuple[Array, Array]:
        """Give each group's factor (or mean force in N) and its standard error; 1 (or 0 N) where they don't differ."""
        neutral = 0.0 if quantity == "mean_force" else 1.0
        if quantity not in self.shares:
            return np.full(len(self.names), neutral), np.zeros(len(self.names))
        own = self.shares[quantity]
        if quantity == "mean_force":
            return own.values, own.errors
        # a share of the measured force: measured is the law's times 1/(1 - share)
        return 1 / (1 - own.values), own.errors / (1 - own.values) ** 2


@dataclass(frozen=True)
class _Runs:
    """Shares by run: rows of one run, its cycles say, together."""

    names: tuple[str, ...]
    rows: IntArray
    quantities: Mapping[GroupQuantity, Array]
    labels: Mapping[str, Sequence[str]]
    size: float


def find_groups(loops: Loops, observations: LoopObservations, law_force: LawForce) -> tuple[Groups, ...]:
    """Find the columns of labels whose groups differ, or can't be told from conditions.

    Args:
        loops: the tests, one row a run, or one a run and cycle.
        observations: the same as observations.
        law_force: of the law beside which they are looked for.
    """
    if not has_groups(loops):
        return ()
    runs = _by_run(loops, observations, law_force)
    parted: dict[tuple[int, ...], list[str]] = {}
    for column, labels in runs.labels.items():
        if group_names(list(labels)):
            numbers = {label: number for number, label in enumerate(dict.fromkeys(labels))}
            partition = tuple(numbers[label] for label in labels)
            parted.setdefault(partition, []).append(column)
    found = []
    for first, *alike in parted.values():
        others = [labels for column, labels in runs.labels.items() if column not in (first, *alike)]
        one = _groups_of(first, tuple(alike), runs, _Conditions(loops, runs), others, len(parted))
        if one is not None and (one.differ or one.confounded or one.explained_by):
            found.append(one)
    return tuple(found)


def has_groups(loops: Loops) -> bool:
    """Tell whether any column of labels groups the tests."""
    columns = loops.rows[0].labels
    return any(group_names([row.labels.get(column, "") for row in loops.rows]) for column in columns)


def factors_of(found: Sequence[Groups], loops: Loops, observations: LoopObservations) -> GroupFactors | None:
    """Give the random factors of groups that differ, for a fit; None where none do."""
    directions, members, spreads, values = [], [], [], []
    kinds: list[int] = []
    changes = _changes(observations)
    for one in found:
        group = np.array([one.of_run[run] for run in loops.run])
        for quantity in one.differ:
            kind = len(set(kinds))
            for contrast in one.contrasts.T:
                member = np.sum(
                    [share * (group == name) for share, name in zip(contrast, one.names, strict=True)], axis=0
                )
                directions.append(changes[quantity] * member[:, None])
                members.append(member)
                kinds.append(kind)
                spreads.append(one.shares[quantity].spread)
                values.append(float(contrast @ one.shares[quantity].values))
    if not directions:
        return None
    own = frozenset(signal_of(column) for one in found if one.differ for column in one.own)
    return GroupFactors(
        np.stack(directions), np.stack(members), np.array(kinds), np.array(spreads), np.array(values), own
    )


def _changes(observations: LoopObservations) -> dict[GroupQuantity, Array]:
    """Give what a share more of stiffness, of damping, and a newton of mean force do to the harmonics, shape (R, m)."""
    stiffness, damping = elastic_and_damping(np.where(observations.seen, observations.harmonics, 0.0))
    mean_force = np.zeros_like(stiffness)
    mean_force[:, 0] = observations.seen[:, 0]
    return {"stiffness": stiffness, "damping": damping, "mean_force": mean_force}


def _by_run(loops: Loops, observations: LoopObservations, law_force: LawForce) -> _Runs:
    residual = observations.plain_residual(law_force)
    if law_force.adrift.any():
        # what a law leaves open is asked of the measured means themselves
        residual[:, 0] = observations.harmonics[:, 0]
    names = tuple(dict.fromkeys(loops.run))
    place = {name: index for index, name in enumerate(names)}
    rows = np.array([place[run] for run in loops.run])
    counts = np.bincount(rows)
    quantities = {}
    changes = _changes(observations)
    for quantity, change in changes.items():
        size = np.sum(change**2, axis=1)
        off = np.sum(np.where(observations.seen, residual, 0.0) * change, axis=1)
        share = np.divide(off, size, out=np.full(len(size), np.nan), where=size > 0)
        quantities[quantity] = np.bincount(rows, share) / counts
    first = np.unique(rows, return_index=True)[1]
    columns = loops.rows[0].labels
    labels = {column: [loops.rows[row].labels[column] for row in first] for column in columns}
    return _Runs(names, first, quantities, labels, float(np.median(observations.force_amplitude)))


class _Conditions:
    """What conditions may do to runs: a constant each level; a line where a condition is constant inside each group."""

    def __init__(self, loops: Loops, runs: _Runs) -> None:
        rows = runs.rows
        self.main = {
            "A": loops.amplitude_mm[rows],
            "f": loops.frequency_Hz[rows],
            "T": loops.temperature_K[rows],
        }
        self.further = {
            name: values[rows] for name, values in {"density_g_cm3": loops.density_g_cm3, **loops.conditions}.items()
        }
        self.count = len(rows)

    def own(self, labels: Sequence[str]) -> list[str]:
        """Give the further conditions that are constant inside each group and differ between groups."""
        names = np.array(labels)
        found = []
        for name, values in self.further.items():
            if not np.all(np.isfinite(values)) or np.ptp(values) == 0:
                continue
            spans = [np.ptp(values[names == group]) for group in set(labels) - {""}]
            if max(spans) <= 1e-9 * np.max(np.abs(values)):
                found.append(name)
        return found

    def of_groups(self, lines: Sequence[str], labels: Sequence[str], names: Sequence[str]) -> Array:
        """Give conditions that are constant inside each group, as shares of their range, shape (G, p)."""
        first = [labels.index(name) for name in names]
        columns = [self.further[name][first] / np.ptp(self.further[name]) for name in lines]
        return np.stack(columns, axis=1) if columns else np.zeros((len(names), 0))

    def basis(self, lines: Sequence[str], leave: Sequence[str] = (), others: Sequence[Sequence[str]] = ()) -> Array:
        """Give orthonormal functions, shape (R, p): lines in some conditions, constants in the levels of others."""
        columns = [np.ones(self.count)]
        for name, values in {**self.main, **self.further}.items():
            if name in leave or not np.any(np.isfinite(values)):
                continue
            if name in lines:
                columns.append((values - values.mean()) / values.std())
                continue
            same = {"absolute": SAME_KELVIN} if name == "T" else {"relative": SAME_SHARE}
            levels = number_levels(values, **same)
            columns += [_one_at(level.rows, self.count) for level in levels[1:]]
        for labels in others:
            columns += [np.array([float(label == name) for label in labels]) for name in group_names(list(labels))[1:]]
        return orthonormal(np.stack(columns, axis=1))


def _one_at(rows: IntArray, count: int) -> Array:
    column = np.zeros(count)
    column[rows] = 1.0
    return column


def _groups_of(
    column: str,
    alike: tuple[str, ...],
    runs: _Runs,
    conditions: _Conditions,
    others: Sequence[Sequence[str]],
    tried: int,
) -> Groups | None:
    """Ask one column; None where there are too few runs to tell."""
    labels = list(runs.labels[column])
    names = group_names(labels)
    lines = conditions.own(labels)
    fixed = conditions.basis(lines, others=others)
    member = _member(labels, names)
    if _rank(member, fixed) < len(names) - 1 and _rank(member, conditions.basis(lines)) > _rank(member, fixed):
        fixed = conditions.basis(lines)
    if conditions.count - fixed.shape[1] - _rank(member, fixed) < FEWEST_FREE:
        return None
    limit = CHANCE_SHARE / (tried * len(QUANTITIES))
    known = {quantity: values for quantity, values in runs.quantities.items() if _tells(values, fixed, labels, names)}
    labels, strangers = _at_home(labels, names, known, fixed, runs.names, limit)
    member = _member(labels, names)
    chances = {quantity: _chance(values, fixed, member) for quantity, values in known.items()}
    shares = {quantity: mixed(*_where_known(values, fixed, member)) for quantity, values in known.items()}
    least = {"stiffness": MATERIAL_SHARE, "damping": MATERIAL_SHARE, "mean_force": MATERIAL_SHARE * runs.size}
    differ = tuple(
        quantity for quantity in known if chances[quantity] < limit and shares[quantity].spread > least[quantity]
    )
    alike_in = {quantity: values for quantity, values in known.items() if quantity not in differ}
    return Groups(
        column=column,
        alike=alike,
        names=tuple(names),
        of_run=dict(zip(runs.names, labels, strict=True)),
        counts=tuple(labels.count(name) for name in names),
        own=tuple(lines),
        contrasts=contrasts_of(len(names), conditions.of_groups(lines, labels, names)),
        differ=differ,
        chances=chances,
        shares={quantity: shares[quantity] for quantity in differ},
        confounded=_confounded(conditions, lines, fixed, member),
        explained_by=_explained_by(conditions, lines, alike_in, member, limit, least),
        strangers=strangers if differ else (),
    )


def _confounded(conditions: _Conditions, lines: Sequence[str], fixed: Array, member: Array) -> tuple[str, ...]:
    """Give the conditions that vary with the groups, so that differences between these can't all be seen."""
    rank = _rank(member, fixed)
    if rank >= member.shape[1] - 1:
        return ()
    return tuple(name for name in ("A", "f", "T") if _rank(member, conditions.basis(lines, (name,))) > rank)


def _explained_by(
    conditions: _Conditions,
    lines: Sequence[str],
    alike: Mapping[GroupQuantity, Array],
    member: Array,
    limit: float,
    least: Mapping[str, float],
) -> tuple[str, ...]:
    """Give the conditions of the groups without whose lines these would differ in what they are alike in."""
    without = {name: conditions.basis([line for line in lines if line != name], (name,)) for name in lines}
    return tuple(
        name
        for name, basis in without.items()
        if any(
            _chance(values, basis, member) < limit
            and mixed(*_where_known(values, basis, member)).spread > least[quantity]
            for quantity, values in alike.items()
        )
    )


def _tells(quantity: Array, fixed: Array, labels: Sequence[str], names: Sequence[str]) -> bool:
    """Tell whether a quantity is known in runs enough, of every group: a law may leave mean forces open."""
    known = np.isfinite(quantity)
    groups = {label for label, there in zip(labels, known, strict=True) if there} - {""}
    return groups == set(names) and np.count_nonzero(known) - fixed.shape[1] - len(names) + 1 >= FEWEST_FREE


def _where_known(quantity: Array, fixed: Array, member: Array) -> tuple[Array, Array, Array]:
    """Give a quantity, orthonormal functions of the conditions and groups for the runs that it is known of."""
    known = np.isfinite(quantity)
    if np.all(known):
        return quantity, fixed, member
    return quantity[known], orthonormal(fixed[known]), member[known]


def _member(labels: Sequence[str], names: Sequence[str]) -> Array:
    return np.array([[float(label == name) for name in names] for label in labels])


def _rank(member: Array, fixed: Array) -> int:
    """Give how many differences between groups the conditions leave to be seen."""
    own = member - fixed @ (fixed.T @ member)
    return int(np.linalg.matrix_rank(own, tol=1e-6 * np.linalg.norm(member)))


def _chance(quantity: Array, fixed: Array, member: Array) -> float:
    """Give the chance that groups differ so much by the scatter of runs alone: the F test beside the conditions."""
    # what has no groups does without it
    from scipy.special import fdtrc

    quantity, fixed, member = _where_known(quantity, fixed, member)
    rest = quantity - fixed @ (fixed.T @ quantity)
    own = member - fixed @ (fixed.T @ member)
    left, singular, _ = np.linalg.svd(own, full_matrices=False)
    left = left[:, singular > 1e-6 * np.linalg.norm(member)]
    between = float(np.sum((left.T @ rest) ** 2))
    free = len(rest) - fixed.shape[1] - left.shape[1]
    if left.shape[1] == 0 or free < 1:
        return 1.0
    within = max(float(rest @ rest) - between, 1e-300)
    return float(fdtrc(left.shape[1], free, between / left.shape[1] / (within / free)))


def _at_home(
    labels: list[str], names: Sequence[str], known: Mapping[GroupQuantity, Array], fixed: Array, runs: Sequence[str],
    limit: float,
) -> tuple[list[str], tuple[Stranger, ...]]:  # fmt: skip
    """Move runs that behave like another group there, the strangest first, as long as there are few."""
    moved = list(labels)
    for _ in range(max(1, int(MOST_STRANGE * len(labels)))):
        strangest = strangest_run(moved, names, known, fixed, limit)
        if strangest is None:
            break
        row, home = strangest
        moved[row] = home
    else:
        if strangest_run(moved, names, known, fixed, limit) is not None:
            return labels, ()
    found = [Stranger(run, said, like) for run, said, like in zip(runs, labels, moved, strict=True) if said != like]
    return moved, tuple(found)


def strangest_run(
    labels: Sequence[str], names: Sequence[str], known: Mapping[GroupQuantity, Array], fixed: Array, limit: float
) -> tuple[int, str] | None:
    """Give the run that is farthest off its own group and at home in another, and that group; None where none is.

    Args:
        labels: the group of each run, "" where it has none.
        names: the groups'.
        known: quantities of the runs, shape (R,) each.
        fixed: orthonormal functions of the conditions, shape (R, p).
        limit: largest chance at which a quantity's groups count as different.
    """
    off = _off_groups(labels, names, known, fixed, limit)
    if off is None:
        return None
    for row in np.argsort(-off.own).tolist():
        if off.own[row] < STRANGE**2:
            return None
        if not labels[row]:
            continue
        home = int(np.argmin(off.others[row]))
        if off.others[row, home] <= AT_HOME**2 * off.own[row] and names[home] != labels[row]:
            return row, names[home]
    return None


class _OffGroups(NamedTuple):
    """By how many scatters runs are off, squared, over all quantities: off their own groups (R,), off each (R, G)."""

    own: Array
    others: Array


def _off_groups(
    labels: Sequence[str], names: Sequence[str], known: Mapping[GroupQuantity, Array], fixed: Array, limit: float
) -> _OffGroups | None:
    """Give by how much runs are off groups; None where groups differ in no quantity. Arguments of `strangest_run`."""
    member = _member(labels, names)
    basis = np.concatenate([fixed, member], axis=1)
    left, singular, right = np.linalg.svd(basis, full_matrices=False)
    kept = singular > 1e-8 * singular[0]
    span = left[:, kept]
    leverage = np.minimum(np.sum(span**2, axis=1), 1.0)
    # a run that alone is at its conditions shows no scatter
    shows = leverage < 1 - 1e-6
    differing = [
        values for values in known.values() if np.all(np.isfinite(values)) and _chance(values, fixed, member) < limit
    ]
    if not differing:
        return None
    own = np.zeros(len(labels))
    others = np.zeros((len(labels), len(names)))
    for values in differing:
        rest = values - span @ (span.T @ values)
        # a run that is off pulls its own group along: what it would be off had it been left out
        off = rest / np.maximum(1 - leverage, 1e-6)
        scatter = scatter_by_median(rest[shows]) / float(np.sqrt(np.median(1 - leverage[shows])))
        solution = (right[kept].T / singular[kept]) @ (span.T @ values)
        share = solution[fixed.shape[1] :]
        scatter = max(scatter, 1e-12)
        weight = np.sqrt(1 - leverage) / scatter
        own += (off * weight) ** 2
        for row, label in enumerate(labels):
            if label:
                step = share - share[names.index(label)]
                others[row] += ((off[row] - step) * weight[row]) ** 2
    return _OffGroups(own, others)
