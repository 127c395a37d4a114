"""Stamps of time in a text become seconds."""

from __future__ import annotations

import numpy as np

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.tables import pl

FORMATS = ("%Y-%m-%d", "%d.%m.%Y", "%Y/%m/%d", "%m/%d/%Y", "%d/%m/%Y", "%d-%m-%Y")
DAY = 86400.0


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
        clock = (
            text.str.extract(r"(\d{1,3}):(\d{2})(?::(\d{2}(?:[.,]\d+)?))?", 1).cast(pl.Float64, strict=False) * 3600.0
        )
        clock += text.str.extract(r"\d{1,3}:(\d{2})", 1).cast(pl.Float64, strict=False) * 60.0
        seconds = text.str.extract(r"\d{1,3}:\d{2}:(\d{2}(?:[.,]\d+)?)", 1).str.replace(",", ".", literal=True)
        clock += seconds.cast(pl.Float64, strict=False).fill_null(0.0)
        values: Array = clock.fill_null(float("nan")).to_numpy()
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
        """Give the seconds of all parts, going on over midnight where there is no date."""
        if self._format:
            return values
        for step in np.flatnonzero(np.diff(values) < -DAY / 2):
            values = np.concatenate([values[: step + 1], values[step + 1 :] + DAY])
        return values
