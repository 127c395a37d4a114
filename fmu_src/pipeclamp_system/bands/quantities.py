"""What isn't known of a system's clamps, as quantities with their covariance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy.linalg import block_diag
from scipy.special import ndtri

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.law.file import Shares
from pipeclamp_system.bands.varied import SHARE_OF_PARAMETER, VariedLaw

UnknownKind = Literal["parameters", "runs", "form", "solution"]
KIND_WORDS: Mapping[UnknownKind, str] = {
    "parameters": "the law's parameters",
    "runs": "scatter from run to run",
    "form": "what the law leaves over on left-out tests",
    "solution": "what the solver leaves out",
}
"""Kinds of what isn't known, in words."""
NOUGHT = 1e-10
"""Share of the largest variance that is rounding."""
SEED = 1
"""The same system gives the same band."""


@dataclass(frozen=True)
class UnknownQuantity:
    """One thing that isn't known.

    Attributes:
        kind: of what.
        name: of the law and its parameter, or of the clamp and the share.
        parameter: of the varied law, that it changes.
        clamps: which of the system's clamps it changes.
        lean: whether it is what tests near there show of the law's form: known, and no part of what isn't.
    """

    kind: UnknownKind
    name: str
    parameter: str
    clamps: tuple[int, ...]
    lean: bool = False


@dataclass(frozen=True, eq=False)
class Unknown:
    """All that isn't known of a system's clamps.

    Attributes:
        laws: of each clamp; clamps of one law share it.
        quantities: Q of them. Shares are in units of their standard deviation.
        covariance: shape (Q, Q).
    """

    laws: Sequence[VariedLaw]
    quantities: tuple[UnknownQuantity, ...]
    covariance: Array

    def roots(self) -> Array:
        """Give a root of the covariance, (Q, K): what is surely nought is left out."""
        sizes = np.sqrt(np.diag(self.covariance))
        sizes = np.where(sizes > 0, sizes, 1.0)
        values, vectors = np.linalg.eigh(self.covariance / np.outer(sizes, sizes))
        kept = values > NOUGHT * values.max(initial=0.0)
        return np.asarray(sizes[:, None] * vectors[:, kept] * np.sqrt(values[kept]))

    def by_clamp(self) -> Unknown:
        """Give the same, what a law's form may be off at each clamp by itself: wholly correlated, as it is one law."""
        told: list[tuple[int, UnknownQuantity]] = []
        for place, one in enumerate(self.quantities):
            apart = [replace(one, clamps=(clamp,)) for clamp in one.clamps] if one.kind == "form" else [one]
            told += [(place, each) for each in apart]
        places = [place for place, _ in told]
        return Unknown(self.laws, tuple(one for _, one in told), self.covariance[np.ix_(places, places)])

    @property
    def means(self) -> Array:
        """Their expected values, shape (Q,): what tests show is there, all else as likely up as down."""
        return np.array([float(quantity.lean) for quantity in self.quantities])

    @property
    def scales(self) -> Array:
        """By how much each is moved to see what follows it, shape (Q,): its standard deviation, or what it is."""
        return np.asarray(np.sqrt(np.diag(self.covariance)) + self.means)

    def of_kind(self, kind: UnknownKind) -> Array:
        """Tell which quantities are of a kind, shape (Q,)."""
        return np.array([quantity.kind == kind for quantity in self.quantities])

    def sizes(
        self, clamp: int, beyond: Mapping[str, float], at: Mapping[str, float] | None = None, truncated: float = 0.0
    ) -> Array:
        """Give by how much each quantity, of size one, changes its parameter at a clamp, shape (Q,).

        Args:
            clamp: which.
            beyond: its conditions that lie beyond the data of its law, by name.
            at: all its law's conditions, held inside these data; None where they aren't known.
            truncated: share of the motion in harmonics that the solver leaves out: the force may be off by as much.
        """
        law = self.laws[clamp]
        form, lean = (
            law.form(beyond, at),
            law.lean(at) if at is not None else dict.fromkeys(SHARE_OF_PARAMETER.values(), 0.0),
        )
        shares = {
            "form": form,
            "runs": law.file.spread.runs if law.file.spread else form,
            "solution": Shares(stiffness=truncated, damping=truncated),
        }
        sizes = np.zeros(len(self.quantities))
        for place, quantity in enumerate(self.quantities):
            if clamp not in quantity.clamps:
                continue
            if quantity.kind == "parameters":
                sizes[place] = 1.0
            elif quantity.lean:
                sizes[place] = lean[SHARE_OF_PARAMETER[quantity.parameter]]
            else:
                sizes[place] = getattr(shares[quantity.kind], SHARE_OF_PARAMETER[quantity.parameter])
        return sizes

    def changes(
        self, clamp: int, beyond: Mapping[str, float], at: Mapping[str, float], amounts: Array
    ) -> dict[str, float]:
        """Give the changes of a clamp's parameters, by name, that amounts of the quantities, shape (Q,), make."""
        made: dict[str, float] = {}
        for quantity, size, amount in zip(self.quantities, self.sizes(clamp, beyond, at), amounts, strict=True):
            made[quantity.parameter] = made.get(quantity.parameter, 0.0) + float(size * amount)
        return made


def unknown_of_clamps(laws: Sequence[VariedLaw], clamps: Sequence[str], *, solved: bool) -> Unknown:
    """Give what isn't known of clamps.

    What a law's tests tell is one truth for all clamps that have it; each clamp is mounted by itself.

    Args:
        laws: of each clamp; the same object where clamps share a law.
        clamps: their names.
        solved: whether a solver leaves harmonics out.
    """
    quantities: list[UnknownQuantity] = []
    blocks: list[Array] = []
    for law in dict.fromkeys(laws):
        own = tuple(place for place, other in enumerate(laws) if other is law)
        name = law.file.name
        quantities += [UnknownQuantity("parameters", f"{name}: {one}", one, own) for one in law.names]
        blocks.append(law.covariance)
        further: list[UnknownQuantity] = []
        for parameter, share in SHARE_OF_PARAMETER.items():
            of_clamps = [(f"{clamps[place]}: {share}", parameter, (place,)) for place in own]
            if law.file.spread is not None:
                further.append(UnknownQuantity("form", f"{name}: {share}", parameter, own))
                further += [UnknownQuantity("runs", *each) for each in of_clamps]
            if solved:
                further += [UnknownQuantity("solution", *each) for each in of_clamps]
        quantities += further
        blocks.append(np.eye(len(further)))
        if law.file.spread is not None and law.file.spread.local is not None:
            shown = "as tests near there show"
            known = [
                UnknownQuantity("form", f"{name}: {share}, {shown}", one, own, True)
                for one, share in SHARE_OF_PARAMETER.items()
            ]
            quantities += known
            blocks.append(np.zeros((len(known), len(known))))
    return Unknown(laws, tuple(quantities), block_diag(*blocks) if blocks else np.zeros((0, 0)))


def even_normal(count: int, size: int) -> Array:
    """Give normal numbers that fill their space evenly, (count, size); always the same."""
    from scipy.stats import qmc

    return np.asarray(ndtri(qmc.LatinHypercube(size, rng=SEED).random(count)))


def normal_draws(count: int, what: Unknown) -> Array:
    """Give so many draws of what isn't known, (count, Q)."""
    roots = what.roots()
    return even_normal(count, roots.shape[1]) @ roots.T
