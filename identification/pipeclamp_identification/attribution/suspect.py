"""What may be wrong in a coupled model: a parameter with the change that it makes, and where a search begins."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import exp
from typing import Literal

from pipeclamp_identification.on_pipe.model import CoupledModel
from pipeclamp_models.base.digits import one_digit

Side = Literal["pipe", "clamp", "measurement"]
Values = tuple[float, ...]
ModelChange = Callable[[CoupledModel, Values], CoupledModel]

LOG_FACTORS = (-1.2, -0.4, 0.4, 1.2)
"""Logarithms of factors at which a search begins: a quarter to four times what is stated."""
LARGEST_LOG_FACTOR = 5.0
"""Logarithm of the largest factor."""


@dataclass(frozen=True)
class Suspect:
    """Something that may be wrong in a model.

    Attributes:
        id: its name in answers.
        side: whose it is.
        kind: what it is, in words; suspects of one kind differ by their place.
        words: the same with its place.
        change: gives the model with values of its parameters in place; all 0 change nothing.
        value_words: says values and their standard errors in the engineer's units.
        starts: values at which a search begins besides 0.
        lower, upper: bounds of each parameter.
        others: values of all parameters but the first that matter only where the first isn't neutral, a place say:
            pairs are sought beginning from each of them.
    """

    id: str
    side: Side
    kind: str
    words: str
    change: ModelChange
    value_words: Callable[[Values, Values], str]
    starts: tuple[Values, ...]
    lower: Values
    upper: Values
    others: tuple[Values, ...] = ()

    @property
    def neutral(self) -> Values:
        """Values that change nothing: 0, and for what then is without effect the middle of its bounds."""
        first, *others = zip(self.lower, self.upper, strict=True)
        return (max(0.0, first[0]), *((low + high) / 2 for low, high in others))

    @property
    def neutrals(self) -> tuple[Values, ...]:
        """All values that change nothing and from which a search may begin."""
        return tuple((self.neutral[0], *values) for values in self.others) or (self.neutral,)


@dataclass(frozen=True)
class ValueSearch:
    """Where a search for values begins, and within which bounds; as of `Suspect`."""

    starts: tuple[Values, ...]
    lower: Values
    upper: Values


A_FACTOR = ValueSearch(tuple((value,) for value in LOG_FACTORS), (-LARGEST_LOG_FACTOR,), (LARGEST_LOG_FACTOR,))
"""Of a factor by its logarithm."""


def factor_words(whose: str, size: float, unit: str, values: Values, errors: Values) -> str:
    """Say a factor: as such, or as the size that it makes of a stated one."""
    factor = exp(values[0])
    if unit:
        return f"{factor * size:.4g} ± {one_digit(factor * size * errors[0])} {unit} instead of {size:.4g} {unit}"
    return f"{factor:.3g} ± {factor * errors[0]:.1g} times {whose}"


def amount_words(size: float, unit: str, instead: str, values: Values, errors: Values) -> str:
    """Say an amount of what isn't there as stated."""
    return f"{size * values[0]:.3g} ± {one_digit(size * errors[0])} {unit} {instead}"
