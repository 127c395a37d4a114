"""The error of a result from another run, on results whose error is known; the step that is then proposed.

And runs that find their laws' A and f: what a still clamp asks for, and which system a run that is given up was of.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, pi
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp_system.cosim import run as cosim_run
from pipeclamp_system.cosim.energy import EnergyBalance
from pipeclamp_system.cosim.law_conditions import Solving
from pipeclamp_system.cosim.result import CosimResult
from pipeclamp_system.cosim.step_error import order_of, step_error
from pipeclamp_system.description.scheme import ORDER, Scheme
from pipeclamp_system.description.system import ClampSource, SystemDescription

Motion = Callable[[np.ndarray], np.ndarray]


def system_of(scheme: Scheme, step: float) -> SystemDescription:
    """Give a system that runs for 20 s."""
    clamp = {"at": "clamp1", "law": "emwm2", "temperature_C": 20.0, "amplitude_mm": 0.5}
    return SystemDescription.model_validate(
        {
            "pipe": {"file": "pipe.toml"},
            "clamps": (clamp,),
            "excitation": {"kind": "sine", "acceleration_m_s2": 1.0, "frequency_Hz": 1.0},
            "run": {"stop_s": 20.0, "step_s": step, "scheme": scheme},
        }
    )


def result_of(
    scheme: Scheme, parts: float, clamp: Motion, probe: Motion | None = None, force: Motion = np.sin
) -> CosimResult:
    """Give a result of 20 cycles of 1 Hz whose clamp and probe move so."""
    time = np.linspace(0.0, 20.0, round(20 * parts) + 1)
    columns = {"time": time, "clamp1.s": clamp(time), "tip.s": (probe or clamp)(time), "clamp1.f": force(time)}
    nothing = EnergyBalance(*(np.zeros_like(time) for _ in range(6)))
    return CosimResult(
        system=system_of(scheme, 1 / parts),
        probe_names=("tip",),
        columns=columns,
        units={},
        energy=nothing,
        out_of_range=(),
        warnings=(),
        hidden_share=0.0,
    )


def turned(phase: float, size: float = 1.0) -> Motion:
    return lambda time: size * np.sin(2 * pi * time + phase)


@pytest.mark.parametrize("scheme", ORDER)
@pytest.mark.parametrize("other", [16, 21, 64, 128])
def test_an_error_of_phase_that_falls_at_the_scheme_s_order_is_found(scheme: Scheme, other: int) -> None:
    late = {parts: turned(0.01 * (32 / parts) ** ORDER[scheme]) for parts in (32, other)}
    results = {parts: result_of(scheme, parts, motion) for parts, motion in late.items()}
    assert step_error(results[32], results[other]) == pytest.approx(0.01, rel=0.02)


@pytest.mark.parametrize("scheme", ["implicit", "iterated"])
@pytest.mark.parametrize("other", [21, 64, 128])
def test_a_force_that_steps_makes_every_scheme_one_of_order_1(scheme: Scheme, other: int) -> None:
    def friction(time: np.ndarray) -> np.ndarray:
        return 30.0 * np.sin(2 * pi * time) + 20.0 * np.sign(np.cos(2 * pi * time + 0.1))

    results = {parts: result_of(scheme, parts, turned(0.01 * 32 / parts), force=friction) for parts in (32, other)}
    assert order_of(results[32], results[other]) == 1
    assert step_error(results[32], results[other]) == pytest.approx(0.01, rel=0.02)
    smooth = {parts: result_of(scheme, parts, turned(0.0)) for parts in (32, other)}
    assert order_of(smooth[32], smooth[other]) == ORDER[scheme]


def test_the_worst_place_and_time_count() -> None:
    """A probe whose motion is small, and an error that is there at the end only."""
    fine = result_of("parallel", 64, turned(0.0), turned(0.0, 1e-3))
    assert step_error(fine, result_of("parallel", 32, turned(0.0), turned(0.03, 1e-3))) == pytest.approx(0.03, rel=0.02)

    def grown(time: np.ndarray) -> np.ndarray:
        return turned(0.0)(time) * (1 + 0.05 * (time > 16.0))

    assert step_error(fine, result_of("parallel", 32, grown, turned(0.0, 1e-3))) == pytest.approx(0.05, rel=0.05)


def test_what_stands_still_or_is_the_same_tells_nothing() -> None:
    fine, coarse = (result_of("parallel", parts, turned(0.0), lambda time: 0.0 * time) for parts in (64, 32))
    assert step_error(fine, coarse) == pytest.approx(0.0, abs=1e-9)
    assert step_error(fine, fine) == inf


SOLVED = {
    "pipe": {"file": "pipe.toml"},
    "clamps": [
        {"at": name, "law": "emwm2", "temperature_C": 20.0, "amplitude_mm": 0.5, "solve": True} for name in ("c1", "c2")
    ],
    "excitation": {"kind": "sine", "acceleration_m_s2": 1.0, "frequency_Hz": 4.0},
    "run": {"stop_s": 10.0, "step_s": 0.01},
}


def test_a_clamp_that_stands_still_is_solved_as_it_is():
    system = SystemDescription.model_validate(SOLVED)
    time = np.arange(0.0, 10.0, 0.001)
    omega = 2 * np.pi * 4.0
    still = np.zeros_like(time)
    moving = {"c1.s": 5e-4 * np.sin(omega * time), "c1.v": 5e-4 * omega * np.cos(omega * time)}
    result = SimpleNamespace(time=time, columns={**moving, "c2.s": still, "c2.v": still})
    nearer, off = Solving({"c1": {}, "c2": {}}).nearer(system, result, 1)
    assert off < 2e-3
    assert [clamp.amplitude_mm for clamp in nearer.clamps] == pytest.approx([0.5, 0.5], rel=2e-3)


@dataclass(frozen=True)
class Ran:
    """A run, of a system in steps of its own."""

    system: SystemDescription
    runs: int = 1
    unsolved: float = 0.0


def test_a_run_that_is_given_up_comes_with_the_system_that_was_run(monkeypatch: pytest.MonkeyPatch):
    def with_amplitude(system: SystemDescription, amplitude: float) -> SystemDescription:
        clamps = (ClampSource(at="c1", law="emwm2", temperature_C=20.0, amplitude_mm=amplitude, solve=True),)
        return system.model_copy(update={"clamps": clamps})

    def never(self: Solving, system: SystemDescription, result: Ran, runs: int) -> tuple[SystemDescription, float]:
        return with_amplitude(system, 1.0 + runs), 0.5

    monkeypatch.setattr(Solving, "nearer", never)
    monkeypatch.setattr(cosim_run, "_once", lambda ready, *_: Ran(ready))
    result, ready = cosim_run._solved(SystemDescription.model_validate(SOLVED), Path(), "system", None)
    assert result.unsolved == 0.5
    assert ready == result.system
