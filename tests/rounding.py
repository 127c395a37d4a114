"""Answers that may differ by what rounding does: sums in libraries' machine code hang on where memory lies."""

from __future__ import annotations

from typing import Any

import pytest


def to_rounding(answer: Any) -> Any:
    """The same answer, each of whose numbers is met to nine digits."""
    if isinstance(answer, dict):
        return {name: to_rounding(value) for name, value in answer.items()}
    if isinstance(answer, list | tuple):
        return type(answer)(to_rounding(value) for value in answer)
    return pytest.approx(answer, rel=1e-9, nan_ok=True) if isinstance(answer, float) else answer
