"""A clamp in steady motion says which of its conditions lie beyond its law's data, as the clamp FMU does."""

from __future__ import annotations

import numpy as np
import pytest

from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import law_of
from pipeclamp_system.steady.clamp import SteadyClamp

RANGES = {"range_A": (0.2, 1.0), "range_f": (1.0, 5.0), "ranges": {"T": (290.0, 575.0)}}


def beyond(A: float, f: float, T: float, given: float | None = None) -> dict[str, float]:
    clamp = SteadyClamp(law_of(open_law("emwm2")), T, given, None, **RANGES)  # type: ignore[arg-type]
    return clamp.beyond(np.array([0.0, A, 0.0], dtype=np.complex128), f, A)


@pytest.mark.parametrize(
    ("motion", "expected"),
    [
        ((0.5, 3.0, 300.0), {}),
        ((1.0, 5.0, 575.0), {}),
        ((0.1, 3.0, 300.0), {"A": 0.1}),
        ((3.0, 3.0, 300.0), {"A": 3.0}),
        ((0.5, 6.0, 300.0), {"f": 6.0}),
        ((0.5, 3.0, 600.0), {"T": 600.0}),
        ((0.1, 3.0, 300.0, 0.5), {}),  # a law that is taken for one amplitude holds for less
        ((3.0, 3.0, 300.0, 0.5), {"A": 3.0}),
        ((0.5, 3.0, 300.0, 2.0), {"A": 2.0}),
    ],
)
def test_what_lies_beyond_is_named(motion: tuple[float, ...], expected: dict[str, float]) -> None:
    assert beyond(*motion) == pytest.approx(expected)
