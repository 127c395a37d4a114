"""What a coefficient of the law, or the strength of a term, may follow: A, f, T, the cycles, and further columns."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from pipeclamp_identification.discovery.shapes import Entry
from pipeclamp_models.base.signals import REFERENCES
from pipeclamp_models.base.units import CELSIUS

ABOVE_ZERO = 0.001
"""Share of a further column's largest value that is added to it, for it may be zero."""

LEVEL, STEEPNESS = "l_x", "a_x"
"""Symbols of the level about which something changes, and of how steeply it does."""
NARROWEST = 0.01
"""Share of a condition's range within which nothing tested changes faster."""


@dataclass(frozen=True)
class Followed:
    """A signal that may be followed.

    Attributes:
        symbol: as expressions have it.
        name: in words.
        unit: its own.
        pure: without its dimension.
        step: by which growth is stated, and in words.
        bends: two levels at which it may bend, where fits begin.
        reach: how far it reaches over the tests.
        column: the further column that it is; empty where it is none.
    """

    symbol: str
    name: str
    unit: str
    pure: str
    step: str
    step_in_words: str
    bends: tuple[object, object]
    reach: str
    column: str = ""

    @property
    def within_tests(self) -> Entry:
        """The bounds of a level about which something steps: beyond the tests nothing shows a step."""
        return {"lower": "T_lowest", "upper": "T_highest"} if self.symbol == "T" else {"upper": self.reach}

    @property
    def past(self) -> str:
        """How far the signal lies past the level `LEVEL`, times how steeply something changes there."""
        return f"abs({STEEPNESS}) * ({self.symbol} - {LEVEL}) / {self.step}"

    def width(self, steepness: float) -> float:
        """Within how much of the signal something changes, in the signal's unit."""
        return float(REFERENCES.get(self.step, self.step)) / abs(steepness)

    def steepness(self, *widths: float) -> Entry:
        """How steeply something changes about a level, as a number that is as small as the tests allow.

        Where a change lies between two neighbouring levels of few, the tests tell neither where nor within how much:
        of all that fit as well the most gradual is meant, and with it the place midway. So this has a prior about zero,
        a third of its bounds wide, as a width, which it is one over, could have none. Its sign says nothing.

        Args:
            widths: within which it changes, as shares of the range, where fits begin.
        """
        sharpest = f"{1 / NARROWEST:g} * {self.step} / {self.reach}"
        return {"symbol": STEEPNESS, "unit": "-", "meaning": f"steepness of the change, for each {self.step_in_words}",
                "neutral": 0.0, "follows": (self.symbol,),
                "start": tuple(f"{1 / width:g} * {self.step} / {self.reach}" for width in widths),
                "lower": f"-{sharpest}", "upper": sharpest}  # fmt: skip


FOLLOWED = {
    "A": Followed("A", "amplitude", "mm", "A / A_0", "A_0", "mm", ("0.5 * A_typical", "A_typical"), "A_highest"),
    "f": Followed("f", "frequency", "Hz", "f / f_0", "f_0", "Hz", ("f_lowest", "f_typical"), "f_highest"),
    "T": Followed(
        "T", "temperature", "K", "(T - T_0) / 100", "100", "100 K",
        ("T_lowest + 0.3 * (T_highest - T_lowest)", "T_lowest + 0.6 * (T_highest - T_lowest)"),
        "(T_highest - T_lowest)",
    ),
    "N": Followed(
        "N", "number of cycles", "-", "N / 1000", "1000", "1000 cycles", ("0.1 * N_highest", "0.4 * N_highest"),
        "N_highest",
    ),
}  # fmt: skip
"""Of A, f, T and the cycles."""


def followed_signal(signal: str, conditions: Mapping[str, float]) -> Followed:
    """Give a signal that may be followed.

    Args:
        signal: A, f, T, N, or a further column.
        conditions: further columns, with the largest magnitude of each.
    """
    if signal not in conditions:
        return FOLLOWED[signal]
    symbol, largest = named(signal), conditions[signal]
    size = f"{largest:.6g}"
    return Followed(
        symbol, signal, "in its name", f"{symbol} / {size}", size, f"{size} of {signal}",
        (0.3 * largest, 0.6 * largest), size, signal,
    )  # fmt: skip


def shown(name: str, value: float) -> str:
    """Give a value of a signal that may be followed for people, with its unit."""
    if name not in FOLLOWED:
        return f"{value:.3g}"
    return f"{value - CELSIUS:.3g} °C" if name == "T" else f"{value:.3g} {FOLLOWED[name].unit}".removesuffix(" -")


def named(column: str) -> str:
    """Give the name that a further column has in expressions."""
    return re.sub(r"\W", "_", column)


@dataclass(frozen=True)
class Scale:
    """What a term that adds a force is scaled by.

    Attributes:
        name: as ids have it.
        factor: > 0, with the exponent `s_x`.
        words: what it is.
        condition: the further column that it needs; empty where it is A, f or T.
    """

    name: str
    factor: str
    words: str
    condition: str = ""


SCALED = {
    "A": Scale("A", "(A / A_0)**s_x", "the amplitude"),
    "f": Scale("f", "(f / f_0)**s_x", "the frequency"),
    "T": Scale("T", "(T / T_0)**s_x", "the temperature"),
}
"""By A, f and T."""


def scales_of(column: str, size: float) -> tuple[Scale, ...]:
    """Give by what a term may follow a further column: exponentially, or with a power of it, which a field has."""
    name, share = named(column), f"{named(column)} / {size:.6g}"
    return (
        Scale(name, f"exp(s_x * {share})", column, column),
        Scale(f"{name}_power", f"(abs({share}) + {ABOVE_ZERO})**s_x", f"a power of {column}", column),
    )
