"""What the mark of a co-simulation promises, over laws, frequencies, schemes and steps, against the monolithic one.

A result that isn't marked errs by at most 1.5 times its `trusted_share`, in amplitude and phase: rms of the error over
rms of the motion, of the whole run and of its last fifth, at the clamp and at the tip. None is refused for its step
that errs by less than a third of the share.
"""

from __future__ import annotations

from collections.abc import Callable
from math import pi
from pathlib import Path

import numpy as np
import pytest
from cantilever import cantilever

from pipeclamp_fmu.build import build_clamp, build_pipe
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.file import law_of, read_law
from pipeclamp_models.pipe.description import read_pipe
from pipeclamp_models.pipe.modes import reduce
from pipeclamp_system.cosim.result import CosimResult
from pipeclamp_system.cosim.run import run_system
from pipeclamp_system.description.excitation import excitation_signal
from pipeclamp_system.description.system import read_system
from pipeclamp_system.transient.monolithic import MonolithicResult, clamp_equations, solve_monolithic

PROMISE, NEEDLESS = 1.5, 1 / 3
"""Shares of `trusted_share`: most error of what isn't marked, least error of what is marked for its step."""

PIPE = cantilever(ratio=0.01, up_to_Hz=200.0, probes={"tip": 3.0})

PIPE_STIFFNESS = 20.2
"""N/mm, static, at clamp1."""

LAWS = {
    "soft": ({"k10": 0.2 * PIPE_STIFFNESS, "k30": 0.0, "c0": 3.0, "alpha0": 0.45}, "power"),
    "stiff": ({"k10": 10 * PIPE_STIFFNESS, "k30": 40.0, "c0": 10.0, "alpha0": 0.45}, "power"),
    "elastic": ({"k10": 3 * PIPE_STIFFNESS, "k30": 0.0, "c0": 0.001, "alpha0": 1.0}, "power"),
    "memory": ({"k10": 0.2 * PIPE_STIFFNESS, "c0": 0.01, "k_s": 10 * PIPE_STIFFNESS, "z_s": 8.0}, "memory"),
}
"""Values and base; "elastic" hardly damps, so that the pipe magnifies what is off by a hundred."""

PARTS = 1024
"""Of a cycle, at which the truth is known."""

STEPS = {
    "iterated": (16, 64, 128),
    "implicit": (16, 32, 64),
    "sequential": (64, 512),
    "parallel": (128, 1024),
}
"""Parts of a cycle, by scheme."""

CYCLES = 8


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory, write_law: Callable[..., None]) -> Path:
    """Give a folder with the pipe, the laws and their FMUs."""
    folder = tmp_path_factory.mktemp("trust")
    (folder / "pipe.toml").write_text(PIPE, encoding="utf-8")
    build_pipe(reduce(read_pipe(folder / "pipe.toml")), folder / "pipe.fmu")
    for name, (values, base) in LAWS.items():
        write_law(folder / f"{name}.json", values, base)
        build_clamp(read_law(folder / f"{name}.json"), folder / f"{name}.fmu")
    return folder


def resonance(bench: Path, law: str) -> float:
    """Give the first natural frequency with the law's k1 as a spring, Hz."""
    pipe = reduce(read_pipe(bench / "pipe.toml"))
    shape = np.array(pipe.clamp_shapes[0])
    k1 = 1e3 * LAWS[law][0]["k10"]
    return float(np.sqrt(np.linalg.eigvalsh(pipe.stiffness_matrix + k1 * np.outer(shape, shape))[0]) / (2 * pi))


def described(bench: Path, law: str, frequency: float, scheme: str, parts: int) -> Path:
    file = bench / "system.toml"
    file.write_text(
        f'[pipe]\nfmu = "pipe.fmu"\n[[clamps]]\nat = "clamp1"\nfmu = "{law}.fmu"\ntemperature_C = 20.0\n'
        f'amplitude_mm = 1.0\n[excitation]\nkind = "sine"\nacceleration_m_s2 = 6.0\nfrequency_Hz = {frequency!r}\n'
        f'[run]\nscheme = "{scheme}"\nstop_s = {CYCLES / frequency!r}\nstep_s = {1 / (frequency * parts)!r}\n',
        encoding="utf-8",
    )
    return file


def truth(bench: Path, law: str, frequency: float) -> MonolithicResult:
    system = read_system(described(bench, law, frequency, "iterated", PARTS))
    pipe, stop = reduce(read_pipe(bench / "pipe.toml")), system.run.stop_s
    signal = excitation_signal(system.excitation, pipe.excitation, stop, bench, "test")
    clamp = clamp_equations(law_of(read_law(bench / f"{law}.json")), 1.0, frequency, 293.15)
    return solve_monolithic(pipe, [clamp], signal, np.linspace(0.0, stop, CYCLES * PARTS + 1), 1e-7)


def true_error(result: CosimResult, exact: MonolithicResult, parts: int) -> float:
    every = PARTS // parts
    pairs = (
        (result.columns["clamp1.s"], exact.displacement[::every, 0]),
        (result.columns["tip.s"], exact.probes[::every, 0]),
    )
    last = -CYCLES * parts // 5
    return max(
        float(np.linalg.norm((ours - theirs)[window]) / np.linalg.norm(theirs[window]))
        for ours, theirs in pairs
        for window in (slice(None), slice(last, None))
    )


@pytest.mark.parametrize(("law", "where"), [*((law, 1.0) for law in LAWS), ("memory", 0.7), ("stiff", 1.3)])
def test_what_is_not_marked_errs_as_little_as_promised(bench: Path, law: str, where: float) -> None:
    frequency = round(where * resonance(bench, law), 3)
    exact = truth(bench, law, frequency)
    trusted: list[bool] = []
    for scheme, tried in STEPS.items():
        for parts in tried:
            case = f"{law}, {where} of the resonance, {scheme}, 1/{parts} cycle"
            try:
                result = run_system(described(bench, law, frequency, scheme, parts))
            except UserError as diverged:
                assert "diverges" in str(diverged)
                trusted.append(False)
                continue
            error, share = true_error(result, exact, parts), result.trusted_share
            if result.trusted:
                assert error <= PROMISE * share, case
            if result.step_error is not None and result.step_error > share:
                assert error >= NEEDLESS * share, case
            trusted.append(result.trusted)
    assert set(trusted) == {True, False}
