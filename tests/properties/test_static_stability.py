"""A clamp of negative stiffness beyond the pipe's own is told as that, not as a matter of the time step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import pi
from pathlib import Path

import pytest
from cantilever import cantilever, shaken

from pipeclamp_models.base.errors import UserError
from pipeclamp_system.cosim.run import run_system
from pipeclamp_system.cosim.static_stability import about_rest
from pipeclamp_system.description.system import read_system
from pipeclamp_system.response.run import run_response
from pipeclamp_system.response.summary import response_summary

E, OUTER, WALL, PLACE = 195e3, 60.3, 3.91, 2000.0
"""N/mm2 of 316L at 20 degC, mm."""
HELD = 3 * E * pi / 64 * (OUTER**4 - (OUTER - 2 * WALL) ** 4) / PLACE**3
"""N/mm with which a beam, clamped at one end, holds a place."""


@pytest.fixture
def system(tmp_path: Path, write_law: Callable[..., None]) -> Callable[..., Path]:
    """Give a function that writes a cantilever with clamps, each with these coefficients."""

    def write(*clamps: dict[str, float], **more: float) -> Path:
        places = {f"clamp{number}": PLACE / 1e3 for number in range(1, len(clamps) + 1)}
        (tmp_path / "pipe.toml").write_text(cantilever(0.01, 400.0, places), encoding="utf-8")
        text = shaken(amplitude_mm=1.0, frequency_Hz=7.0)
        for number, values in enumerate(clamps, 1):
            name = "law" if number == 1 else f"law{number}"
            write_law(tmp_path / f"{name}.json", {"c0": 0.02, "alpha0": 1.0, **values})
            if number > 1:
                text += (
                    f'[[clamps]]\nat = "clamp{number}"\nlaw = "{name}.json"\ntemperature_C = 20.0\n'
                    "amplitude_mm = 1.0\nfrequency_Hz = 7.0\n"
                )
        (tmp_path / "system.toml").write_text(text, encoding="utf-8")
        return tmp_path / "system.toml"

    return write


def said(path: Path) -> str:
    return about_rest(read_system(path), path.parent, str(path))


def test_the_limit_is_the_beam_s_own_stiffness(system: Callable[..., Path]) -> None:
    assert not said(system({"k10": -0.97 * HELD}))
    words = said(system({"k10": -1.5 * HELD}))
    held, together = (float(words.split(before)[1].split(" N/mm")[0]) for before in ("holds it with ", "together "))
    assert held == pytest.approx(HELD, rel=0.002)
    assert together == pytest.approx(-0.5 * HELD, rel=0.02)


def test_another_clamp_may_hold_it(system: Callable[..., Path]) -> None:
    assert not said(system({"k10": -1.5 * HELD}, {"k10": HELD}))
    assert "the pipe with its other clamps" in said(system({"k10": -1.5 * HELD}, {"k10": 0.2 * HELD}))


def test_a_run_that_leaves_its_rest_for_ever_says_so(system: Callable[..., Path]) -> None:
    """ "The coupling diverges, use a smaller step_s" had been said, of any step."""
    with pytest.raises(UserError, match=r"'clamp1' has a negative stiffness at rest.*so that the pipe leaves its rest"):
        run_system(system({"k10": -100 * HELD}))


def test_a_run_that_comes_to_rest_elsewhere_warns(system: Callable[..., Path]) -> None:
    result = run_system(system({"k10": -2 * HELD, "k30": 5.0}))
    assert "the pipe leaves its rest" in result.warnings[0]


def test_a_response_of_a_pipe_that_leaves_its_rest_says_so(system: Callable[..., Path]) -> None:
    path = system({"k10": -2 * HELD})
    more = "[response]\nfrom_Hz = 12.0\nto_Hz = 13.0\ndots = 0\n"
    path.write_text(path.read_text(encoding="utf-8") + more, encoding="utf-8")
    said_of_it = response_summary(run_response(path))
    assert "warning: clamp 'clamp1' has a negative stiffness at rest" in said_of_it
    assert "step_s" not in said_of_it


def test_no_other_step_is_advised_where_the_pipe_swings_between_places_of_rest(system: Callable[..., Path]) -> None:
    result = run_system(system({"k10": -2 * HELD, "k30": 5.0}))
    ((what, rest),) = replace(result, step_error=0.2).doubts()
    assert "errs by 20.00% for its steps" in what
    assert "use step_s" not in rest
    assert "leaves its rest" in rest
    assert "step" not in replace(result, step_error=0.2).remedy()
