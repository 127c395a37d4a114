"""Stamps of time in a text become seconds."""

from __future__ import annotations

import numpy as np

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.tables import pl

FORMATS = ("%Y-%m-%d", "%d.%m.%Y", "%Y/%m/%d", "%m/%d/%Y", "%d/%m/%Y", "%d-%m-%Y")
DAY = 86400.0
CLOCK = r"(?i)(\d{1,3}):(\d{2}(?:[.,]\d+)?)(?::(\d{2}(?:[.,:]\d+)?))?\s*([ap]\.?m\.?)?"
"""Hours, minutes and seconds, or minutes and seconds with decimals; the decimals may stand behind a colon."""


class Clock:
    """A column of stamps, read part after part; the first part tells how its dates are written."""

    def __init__(self) -> None:
        self._format: str | None = None
        self._first_day = 0.0

    def seconds(self, text: pl.Series) -> Array:
        """Give stamps in seconds: of the day, or since the first day where they have a date; nan where there is none.

        Args:
            text: the stamps of a part.
        """
        first, second, third, half = (text.str.extract(CLOCK, group) for group in range(1, 5))
        numbers = [part.str.replace(r"[,:]", ".").cast(pl.Float64, strict=False) for part in (first, second, third)]
        begun, middle, rest = (part.fill_null(0.0).to_numpy() for part in numbers)
        afternoon = half.str.contains("(?i)p").fill_null(False).to_numpy()
        hours = np.where(half.is_null().to_numpy(), begun, begun % 12 + 12 * afternoon)
        # nobody samples a motion by the minute: 01:02 and 01:02.345 are minutes and seconds
        clock = np.where(third.is_null().to_numpy(), 60 * begun + middle, 3600 * hours + 60 * middle + rest)
        values: Array = np.where((numbers[0].is_null() | numbers[1].is_null()).to_numpy(), np.nan, clock)
        date = text.str.extract(r"^(\d{1,4}[-./]\d{1,2}[-./]\d{1,4})[ T]", 1)
        if date.null_count() == len(date):
            return values
        for pattern in (self._format,) if self._format else FORMATS:
            days = date.str.to_date(pattern, strict=False)
            if self._format or days.null_count() == date.null_count():
                number = days.cast(pl.Int32).cast(pl.Float64).fill_null(float("nan")).to_numpy()
                if self._format is None:
                    self._format, self._first_day = pattern, float(np.nanmin(number))
                return np.asarray(values + DAY * (number - self._first_day))
        return values

    def continued(self, values: Array) -> Array:
        """Give the seconds of all parts, shape (n,), going on over midnight where there is no date."""
        if self._format:
            return values
        for step in np.flatnonzero(np.diff(values) < -DAY / 2):
            values = np.concatenate([values[: step + 1], values[step + 1 :] + DAY])
        return values
