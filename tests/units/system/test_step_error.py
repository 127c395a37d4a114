"""The error of a result from another run, on results whose error is known; the step that is then proposed."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, pi

import numpy as np
import pytest

from pipeclamp_system.cosim.energy import EnergyBalance
from pipeclamp_system.cosim.result import CosimResult
from pipeclamp_system.cosim.step_error import order_of, step_error
from pipeclamp_system.description.scheme import ORDER, Scheme
from pipeclamp_system.description.system import SystemDescription

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
