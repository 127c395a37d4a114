"""When something is made."""

from __future__ import annotations

import datetime


def now() -> str:
    """Give date and time, UTC, as files state them."""
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
