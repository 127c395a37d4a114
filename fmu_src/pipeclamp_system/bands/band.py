"""A number with its band, and what of the band comes from what."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr, ndtri

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UsageError
from pipeclamp_system.bands.quantities import KIND_WORDS, Unknown

HIGHEST_LEVEL = 99.9
"""Per cent that a band holds at most: beyond, what is known of the tails is too little."""
NAMED_SHARE = 0.01
"""Share of a band's variance from which on its origin is named."""
DIGITS = (4, 5, 6)
"""Significant ones of a number with its band."""
LEADING = 3
"""Quantities that are named as those which matter most."""


def steps_of(per_cent: float) -> float:
    """Give how many standard deviations to either side hold so many per cent.

    Raises:
        UsageError: it isn't a share that a band can hold.
    """
    if not 1.0 <= per_cent <= HIGHEST_LEVEL:
        raise UsageError(f"--bands: got {per_cent:g}; expected a number from 1 to {HIGHEST_LEVEL:g}, such as 95")
    return float(ndtri(0.5 + per_cent / 200))


@dataclass(frozen=True)
class Band:
    """A number and what isn't known of it.

    Attributes:
        value: the number.
        low, high: ends of its band.
        middle: of it: the number, or where what tests near there show of the law moves it.
        deviation: standard deviation.
        shares: of the variance, by kind.
        leading: quantities with the largest shares of it, by name, largest first; negative where they go against it.
    """

    value: float
    low: float
    high: float
    middle: float
    deviation: float
    shares: Mapping[str, float]
    leading: tuple[tuple[str, float], ...]

    def beyond(self, limit: float, steps: float) -> float:
        """Give the probability that the number is above a limit; the band reaches so many standard deviations."""
        side = self.high - self.middle if limit > self.middle else self.middle - self.low
        if side <= 0:
            return float(self.middle > limit)
        return float(ndtr((self.middle - limit) / (side / steps)))


def band_of(
    value: float, by_quantity: Array, unknown: Unknown, steps: float, solution: float = 0.0, moved: float | None = None
) -> Band:
    """Give a number's band, to first order.

    Args:
        value: the number.
        by_quantity: its derivatives by what isn't known, (Q,).
        unknown: that, with its covariance.
        steps: standard deviations to either side.
        solution: standard deviation of what the solver leaves out besides.
        moved: by how much the band lies beside the number; None for what its derivatives tell.
    """
    middle = value + (float(by_quantity @ unknown.means) if moved is None else moved)
    parts = by_quantity * (unknown.covariance @ by_quantity)
    variance = float(parts.sum()) + solution**2
    whole = variance if variance > 0 else 1.0
    shares: dict[str, float] = {str(kind): float(parts[unknown.of_kind(kind)].sum()) / whole for kind in KIND_WORDS}
    shares["solution"] += solution**2 / whole
    largest = np.argsort(-np.abs(parts))[:LEADING]
    deviation = float(np.sqrt(variance))
    return Band(
        value,
        middle - steps * deviation,
        middle + steps * deviation,
        middle,
        deviation,
        shares,
        tuple((unknown.quantities[place].name, float(parts[place]) / whole) for place in largest),
    )


REMEDIES: Mapping[str, str] = {
    "parameters": "more tests near that motion would narrow it",
    "runs": "that is what one mounting does; tests of the clamp as it is mounted would narrow it",
    "form": "pipeclamp diagnose tells which effect the law lacks, and adding it narrows the band",
    "solution": "more harmonics, or shorter steps, would narrow it",
}
"""What narrows a band most of which is of a kind."""


def figures(band: Band) -> tuple[str, str, str]:
    """Give a number and the ends of its band with four digits, more where the ends would look alike."""
    told = [tuple(f"{one:.{digits}g}" for one in (band.value, band.low, band.high)) for digits in DIGITS]
    value, low, high = next((each for each in told if each[1] != each[2]), told[0])
    return value, low, high


def ends_words(band: Band, unit: str, per_cent: float) -> str:
    """Give a number with the ends of its band."""
    value, low, high = figures(band)
    return f"{value} {unit} ({per_cent:g}%: {low} to {high})"


def beside_words(band: Band, what: str = "the number") -> str:
    """Say why a number lies outside of its own band, as both are told; "" where it doesn't."""
    value, low, high = map(float, figures(band))
    if low <= value <= high:
        return ""
    return f"; {what} itself lies outside: tests near that motion lie beside the law, and the band is where they lie"


def origin_words(name: str, band: Band) -> list[str]:
    """Say what a band comes from, and what would narrow it."""
    named = {str(kind): words for kind, words in KIND_WORDS.items()}
    shares = sorted(band.shares.items(), key=lambda item: -item[1])
    parts = [f"{share:.0%} {named[kind]}" for kind, share in shares if share >= NAMED_SHARE]
    if not parts:
        return []
    leading = [one for one, share in band.leading if share >= NAMED_SHARE]
    most = f"; most from {', '.join(leading)}" if leading else ""
    return [f"variance of {name}: {', '.join(parts)}{most}; {REMEDIES[shares[0][0]]}"]
