"""Stamps of time in a text become seconds."""

from __future__ import annotations

import numpy as np

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.tables import pl

FORMATS = ("%Y-%m-%d", "%d.%m.%Y", "%Y/%m/%d", "%m/%d/%Y", "%d/%m/%Y", "%d-%m-%Y")
DAY, HOUR = 86400.0, 3600.0
CLOCK = r"(?i)(\d{1,3}):(\d{2}(?:[.,]\d+)?)(?::(\d{2}(?:[.,:]\d+)?))?\s*([ap]\.?m\.?)?"
"""Hours, minutes and seconds, or minutes and seconds with decimals; the decimals may stand behind a colon."""


class Clock:
    """A column of stamps, read part after part; the first part tells how its dates are written."""

    def __init__(self) -> None:
        self._format: str | None = None
        self._first_day = 0.0
        self._has_hours = False

    def seconds(self, text: pl.Series) -> Array:
        """Give stamps in seconds: of the day, or since the first day where they have a date; nan where there is none.

        Args:
            text: the stamps of a part.
        """
        first, second, third, half = (text.str.extract(CLOCK, group) for group in range(1, 5))
        numbers = [part.str.replace(r"[,:]", ".").cast(pl.Float64, strict=False) for part in (first, second, third)]
        begun, middle, rest = (part.fill_null(0.0).to_numpy() for part in numbers)
        self._has_hours |= third.null_count() < len(third)
        afternoon = half.str.contains("(?i)p").fill_null(False).to_numpy()
        hours = np.where(half.is_null().to_numpy(), begun, begun % 12 + 12 * afternoon)
        # nobody samples a motion by the minute: 01:02 and 01:02.345 are minutes and seconds
        clock = np.where(third.is_null().to_numpy(), 60 * begun + middle, 3600 * hours + 60 * middle + rest)
        values: Array = np.where((numbers[0].is_null() | numbers[1].is_null()).to_numpy(), np.nan, clock)
        date = text.str.extract(r"^(\d{1,4}[-./]\d{1,2}[-./]\d{1,4})[ T]", 1)
        if date.null_count() == len(date):
            return values
        if self._format is None:
            # of those that read all dates, the one in which a test takes fewest days: 05/06 and 06/06 are of one month
            read = {pattern: date.str.to_date(pattern, strict=False) for pattern in FORMATS}
            whole = {pattern: _days(days) for pattern, days in read.items() if days.null_count() == date.null_count()}
            if not whole:
                return values
            self._format = min(whole, key=lambda pattern: float(np.nanmax(whole[pattern]) - np.nanmin(whole[pattern])))
            self._first_day = float(np.nanmin(whole[self._format]))
        return np.asarray(values + DAY * (_days(date.str.to_date(self._format, strict=False)) - self._first_day))

    def continued(self, values: Array) -> Array:
        """Give the seconds of all parts, shape (n,), going on over midnight, or the full hour, where that isn't stated.

        Stamps of minutes and seconds, as spreadsheets write them, begin anew with each hour.
        """
        turn = DAY if self._has_hours else HOUR
        if self._format or (turn == HOUR and np.max(values, initial=0.0, where=np.isfinite(values)) >= HOUR):
            return values
        for step in np.flatnonzero(np.diff(values) < -turn / 2):
            values = np.concatenate([values[: step + 1], values[step + 1 :] + turn])
        return values


def _days(dates: pl.Series) -> Array:
    """Give dates as numbers of days, nan where there is none."""
    days: Array = dates.cast(pl.Int32).cast(pl.Float64).fill_null(float("nan")).to_numpy()
    return days
