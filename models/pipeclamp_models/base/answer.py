"""What commands answer: typed, written by --json, with a published schema."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from typing import Any, Protocol

from pydantic import BaseModel, ConfigDict

from pipeclamp_models.base.arrays import Array


class AnswerModel(BaseModel):
    """A part of an answer. Fields may join from version to version; none changes its name or its meaning."""

    # A command uses few of all models: each is built when it is first used, which saved `compare` a fifth of its time.
    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    def to_dict(self) -> dict[str, Any]:
        """Give it as --json writes it: dicts, lists, text, numbers and None."""
        return self.model_dump(mode="json")

    def json_text(self) -> str:
        """Give the text that --json writes.

        Raises:
            ValueError: a number isn't finite, which JSON can't say.
        """
        return json.dumps(self.to_dict(), indent=1, allow_nan=False) + "\n"


def known(value: float) -> float | None:
    """Give a number, or None where it isn't known, which arrays say by NaN."""
    return float(value) if math.isfinite(value) else None


def known_numbers(values: Array) -> tuple[float | None, ...]:
    """Give the numbers of an array of one dimension, None where they aren't known."""
    return tuple(known(value) for value in values.tolist())


class LeftOutRun(AnswerModel):
    """A run that couldn't be used, and why."""

    run: str
    reason: str


class Unusable(Protocol):
    """A run that couldn't be used, wherever that was found."""

    @property
    def run(self) -> str:
        """The run's name."""

    @property
    def reason(self) -> str:
        """Why it couldn't."""


def left_out_runs(runs: Iterable[Unusable]) -> tuple[LeftOutRun, ...]:
    """Give runs that couldn't be used as answers have them."""
    return tuple(LeftOutRun(run=one.run, reason=one.reason) for one in runs)
