"""A response that nothing damps ends where a clamp moves farther than the pipe is long, and says why."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import polars as pl
import pytest
from cantilever import cantilever

from pipeclamp_models.law.file import law_of, read_law
from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_models.pipe.modes import reduce
from pipeclamp_system.description.system import ResponseTable
from pipeclamp_system.response.curves import Curve, FrequencyResponse
from pipeclamp_system.response.run import curve_of
from pipeclamp_system.response.summary import response_summary
from pipeclamp_system.response.table import write_response
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.clamp import SteadyClamp
from pipeclamp_system.steady.states import half_range

LENGTH_MM = 3000.0


@pytest.fixture
def curve(tmp_path: Path, write_law: Callable[..., None]) -> Callable[..., Curve]:
    """Give a function that follows the cantilever's response from 4 Hz on, by default without any damping."""

    def follow(to_Hz: float = 9.0, acceleration: float = 1.0, ratio: float = 0.0, **values: float) -> Curve:
        write_law(tmp_path / "law.json", {"k10": 20.0, "alpha0": 1.0, **values})
        clamp = SteadyClamp(law_of(read_law(tmp_path / "law.json")), 293.15, 1.0, 7.0, (0.01, 5.0), (1.0, 60.0))
        pipe = reduce(parse_pipe(cantilever(ratio, 100.0)))
        system = SteadySystem(pipe, [(0, clamp)], lambda frequency: acceleration)
        return curve_of(system, ResponseTable(from_Hz=4.0, to_Hz=to_Hz), None, 1.0, "system.toml")

    return follow


def told(curve: Curve) -> FrequencyResponse:
    return FrequencyResponse("x", ("clamp1",), (), "", (curve,), (), ({},))


def largest(curve: Curve) -> float:
    return max(half_range(state.clamps)[0] for state in curve.states)


@pytest.mark.parametrize("c0", [0.0, 1e-6])
def test_a_response_without_damping_ends_at_the_pipe_s_length(
    tmp_path: Path, curve: Callable[..., Curve], c0: float
) -> None:
    """It had been followed to 3e11 mm, through 862 states, and been called stable and unstable by rounding."""
    found = curve(c0=c0)
    below, above = found.followed.pieces
    assert (below[0].frequency, above[-1].frequency) == (4.0, 9.0)
    assert [state.unbounded for piece in (below, above) for state in (*piece[:1], *piece[-1:])] == [
        False, True, True, False,
    ]  # fmt: skip
    assert above[0].frequency - below[-1].frequency < 1e-3 * below[-1].frequency
    assert LENGTH_MM < largest(found) < 2 * LENGTH_MM
    assert len(found.states) < 250
    assert not found.followed.in_time
    assert not found.detached
    said = response_summary(told(found))
    assert "; not bounded about 8.5" in said
    assert "Hz, for lack of damping\n" in said
    assert "a curve ends as a clamp moves farther than the pipe is long" in said
    assert "(where it isn't bounded)" in said
    if not c0:
        assert "unstable from" not in said
        assert "neither stable nor unstable, as nothing damps it, from 4 to" in said
        write_response(told(found), tmp_path / "r.csv")
        assert pl.read_csv(tmp_path / "r.csv")["stable"].null_count() == len(found.states)


def test_what_lies_between_two_resonances_without_damping_is_found(curve: Callable[..., Curve]) -> None:
    found = curve(to_Hz=80.0)
    (between,) = found.detached
    ends = [between[0].frequency, between[-1].frequency]
    assert ends == pytest.approx(found.followed.unbounded, rel=1e-3)
    assert [between[0].unbounded, between[-1].unbounded] == [True, True]


@pytest.mark.parametrize(("acceleration", "c0", "ratio"), [(1e6, 0.02, 0.01), (1.0, 1e-3, 0.0)])
def test_what_damping_bounds_is_followed_to_the_end(
    curve: Callable[..., Curve], acceleration: float, c0: float, ratio: float
) -> None:
    """However far an excitation drives it."""
    found = curve(acceleration=acceleration, c0=c0, ratio=ratio)
    assert found.followed.whole
    assert (largest(found) > LENGTH_MM) == (acceleration > 1.0)
    assert "bounded" not in response_summary(told(found))
