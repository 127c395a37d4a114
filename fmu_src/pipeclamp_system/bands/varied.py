"""What isn't known of a law, and the law as it may be instead."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import log

import numpy as np

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import CoefficientEntry, LawFile, Shares, structure_of
from pipeclamp_models.law.local_form import LOGARITHMIC, Kriged
from pipeclamp_models.law.range import as_in_range, conditions_beyond, conditions_inside

OFF_BY = Declaration.model_validate(
    {
        "id": "off_by",
        "title": "stiffness and damping are off by shares",
        "looks_like": "loops that are a little too steep, or too wide",
        "parameters": [
            {"symbol": "off_k", "unit": "-", "meaning": "share of the stiffness", "start": 0.0, "neutral": 0.0},
            {"symbol": "off_c", "unit": "-", "meaning": "share of the damping", "start": 0.0, "neutral": 0.0},
        ],
        "scales": [
            {"coefficient": "stiffness", "factor": "exp(off_k)"},
            {"coefficient": "damping", "factor": "exp(off_c)"},
            {"coefficient": "slip", "factor": "exp(off_c)"},
        ],
    }
)
"""By what a whole law may be off, as an effect beside its own: no share turns a sign."""

SHARE_OF_PARAMETER: Mapping[str, str] = {"off_k": "stiffness", "off_c": "damping"}
"""Its parameters, and which of a law's shares each is."""


@dataclass(frozen=True, eq=False)
class VariedLaw:
    """A law with what isn't known of it.

    Attributes:
        file: the law, `OFF_BY` with its shares at none beside its effects.
        names: parameters that were fitted and travel to the pipe.
        covariance: theirs, shape (P, P).
    """

    file: LawFile
    names: tuple[str, ...]
    covariance: Array

    def with_changes(self, changes: Mapping[str, float]) -> LawFile:
        """Give the law's file with parameters changed by so much, by name."""
        coefficients = {
            name: entry.model_copy(update={"value": entry.value + changes.get(name, 0.0)})
            for name, entry in self.file.coefficients.items()
        }
        return self.file.model_copy(update={"coefficients": coefficients})

    @cached_property
    def _near(self) -> dict[str, Kriged]:
        """What its tests tell of conditions near theirs, by share; empty where its file doesn't."""
        local = self.file.spread.local if self.file.spread else None
        return {name: Kriged.of(local, getattr(local, name)) for name in SHARE_OF_PARAMETER.values()} if local else {}

    def lean(self, at: Mapping[str, float]) -> dict[str, float]:
        """Give the shares by which its tests near conditions (A mm, f Hz, T K and so on) lie beside it."""
        return dict.fromkeys(SHARE_OF_PARAMETER.values(), 0.0) | {
            name: one.at(as_in_range(self.file, at))[0] for name, one in self._near.items()
        }

    def form(self, beyond: Mapping[str, float], at: Mapping[str, float] | None = None) -> Shares:
        """Give by how much the law's form may be off, in standard deviations.

        Inside the range, near tests, it is known from these, where the law's file tells them. Beyond the range of its
        data that grows as it grew in the tests, from one level to the one that was left out: with the distance in such
        steps, of A and f that of their logarithms.

        Args:
            beyond: conditions that lie beyond the range, in its units, by its names or those of the law's equations.
            at: the law's conditions, held inside its range, likewise; None for any of them.
        """
        spread = self.file.spread
        if spread is None:
            return Shares(stiffness=0.0, damping=0.0)
        inside = [spread.form.stiffness, spread.form.damping]
        if at is not None and self._near:
            here = as_in_range(self.file, at)
            inside = [self._near[name].at(here)[1] for name in SHARE_OF_PARAMETER.values()]
        squares = np.array(inside) ** 2
        for name, steps in self._steps_beyond(as_in_range(self.file, beyond)).items():
            error = spread.beyond[name].error
            squares += (steps * np.array([error.stiffness, error.damping])) ** 2
        stiffness, damping = np.sqrt(squares).tolist()
        return Shares(stiffness=stiffness, damping=damping)

    def form_at(self, conditions: Mapping[str, float]) -> Shares:
        """Give the same at conditions, which may lie beyond the range."""
        own = as_in_range(self.file, conditions)
        return self.form(conditions_beyond(self.file, own), conditions_inside(self.file.range, own))

    def _steps_beyond(self, beyond: Mapping[str, float]) -> dict[str, float]:
        """Give how far conditions lie beyond the range, in steps between the tests' levels; below it less than 0."""
        found = {}
        for name, value in beyond.items():
            told, interval = self.file.spread and self.file.spread.beyond.get(name), self.file.range.get(name)
            if told and interval:
                end = interval.maximum if value > interval.maximum else interval.minimum
                found[name] = (log(value / end) if name in LOGARITHMIC else value - end) / told.step
        return found

    def form_told(self, test: Mapping[str, float], used: Mapping[str, float]) -> dict[str, tuple[float, float]]:
        """Give what a test tells of the law's form where the law is used.

        Inside the range that is what the kriging of the tests so far makes of it. Beyond, a test leaves what grows
        from it on, as the form's error grew from the range on.

        Args:
            test: conditions of the test, named and in units as of `form`.
            used: conditions where it is used, likewise.

        Returns:
            by share: its standard deviation at the test, and its correlation with that where the law is used.
        """
        spread = self.file.spread
        if spread is None:
            return dict.fromkeys(SHARE_OF_PARAMETER.values(), (0.0, 0.0))
        both = [as_in_range(self.file, one) for one in (test, used)]
        inside = [conditions_inside(self.file.range, one) for one in both]
        beyond = [conditions_beyond(self.file, one) for one in both]
        there, here = self.form_at(test), self.form_at(used)
        reached, wanted = (self._steps_beyond(one) for one in beyond)
        found = {}
        for share in SHARE_OF_PARAMETER.values():
            whole = getattr(here, share) ** 2
            kriged = self._near[share].left(inside) if self._near else None
            inner = kriged[0, 1] ** 2 / kriged[0, 0] if kriged is not None and kriged[0, 0] > 0 else 0.0
            outer = 0.0
            for name, steps in wanted.items():
                left = min(abs(steps - reached.get(name, 0.0)), abs(steps))
                outer += getattr(spread.beyond[name].error, share) ** 2 * (steps**2 - left**2)
            known = (inner + outer) / whole if whole > 0 else 0.0
            found[share] = getattr(there, share), float(np.sqrt(np.clip(known, 0.0, 1.0)))
        return found


def varied(file: LawFile) -> VariedLaw:
    """Give a law with what its file says is not known of it.

    Raises:
        UserError: it has an effect with the name of `OFF_BY` already.
    """
    structure = structure_of(file).with_declared((OFF_BY,))
    coefficients = dict(file.coefficients)
    for table in OFF_BY.parameters:
        coefficients[table.symbol] = CoefficientEntry(value=0.0, unit=table.unit, state="given", meaning=table.meaning)
    whole = file.model_copy(
        update={
            "effects": (*file.effects, OFF_BY.id),
            "declared": structure.declared,
            "coefficients": coefficients,
            "covariance": None,
            "history": (),
        }
    )
    travels = set(structure_of(whole).equations_without_rig.names)
    told = file.covariance
    places = [place for place, name in enumerate(told.names) if name in travels] if told else []
    if told is None or not places:
        return VariedLaw(whole, (), np.zeros((0, 0)))
    matrix = np.array(told.matrix)[np.ix_(places, places)]
    return VariedLaw(whole, tuple(told.names[place] for place in places), matrix)


def gaps(laws: Iterable[VariedLaw]) -> tuple[str, ...]:
    """Say what the files of laws don't tell of their uncertainty."""
    lines = []
    for law in dict.fromkeys(laws):
        name = law.file.name
        if not law.names:
            lines.append(f"{name}: no covariance in its file: its parameters count as exact; identify it from tests")
        if law.file.spread is None:
            lines.append(
                f"{name}: its file doesn't tell what its tests scatter about it: bands are of its parameters alone; "
                "identify it again from records"
            )
    return tuple(lines)


def refuse_silent(laws: Iterable[VariedLaw], where: str) -> None:
    """Refuse laws of which none tells how sure it is; `where` is named in the error.

    Raises:
        UserError: none does.
    """
    if not any(law.names or law.file.spread for law in laws):
        raise UserError(f"{where}: no clamp has a law that tells how sure it is; expected one identified from tests")
