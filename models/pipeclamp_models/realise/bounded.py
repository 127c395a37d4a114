"""A bound on the time that SymPy takes to write a law's equations: declared effects could send it away for hours."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.time_limit import time_limit

MOST_SECONDS_DERIVING = 60.0
"""For one function with all its derivatives; those of the catalogue's laws take less than two."""


@contextmanager
def bounded() -> Iterator[None]:
    """Raise a UserError where what is inside takes longer than laws do; a decorator, too."""
    too_long = UserError(
        f"the law's equations take more than {MOST_SECONDS_DERIVING:g} s to be worked out with their derivatives; "
        "expected simpler expressions in its declared effects: fewer min, max, abs, where and powers within one another"
    )
    with time_limit(MOST_SECONDS_DERIVING, too_long):
        yield
