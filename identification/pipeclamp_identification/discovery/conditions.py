"""What a coefficient of the law, or the strength of a term, may follow: A, f, T, the cycles, and further columns."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from pipeclamp_identification.discovery.shapes import Entry

ABOVE_ZERO = 0.001
"""Share of a further column's largest value that is added to it, for it may be zero."""


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
