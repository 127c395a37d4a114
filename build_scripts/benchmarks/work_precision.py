"""Work and precision of the coupling schemes and of the monolithic solution.

Run: python build_scripts/benchmarks/work_precision.py [example|stiff] [PICTURE.html]

Two systems: the bundled example, and a pipe at resonance with a clamp that is ten times as stiff as the pipe. For each
scheme and macro step, and for the monolithic solution at several tolerances: CPU time and largest error of the clamp's
displacement against a much finer monolithic solution. Building and loading of the FMUs is not counted, nor is the run
in twice the step that tells a result's error. Where a C compiler is found, the linearly implicit scheme also runs with
the native clamp FMU, which gives its own derivatives.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

import numpy as np
import plotly.graph_objects as go

from pipeclamp.pages.page import Section, styled, write_report
from pipeclamp_fmu.build import build_clamp, build_native_clamp, build_pipe
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import law_of
from pipeclamp_models.pipe.description import read_pipe
from pipeclamp_models.pipe.modes import reduce
from pipeclamp_system.cosim.run import run_described
from pipeclamp_system.description.excitation import excitation_signal
from pipeclamp_system.description.system import read_system
from pipeclamp_system.transient.monolithic import clamp_equations, solve_monolithic

LAW = "emwm2"
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
OVERHEAD_STEPS = 10
"""A run of so few steps measures what loading costs."""

GOAL = 0.01
"""The error at which the schemes are compared."""

STIFF_PIPE = """
name = "cantilever"
[pipe]
outer_diameter_mm = 114.3
wall_mm = 3.6
length_m = 3.0
material = "carbon steel"
[ends]
left = "clamped"
right = "free"
[[clamps]]
name = "clamp1"
position_m = 2.0
[damping]
ratio = 0.005
[modes]
up_to_Hz = 200.0
"""


@dataclass(frozen=True)
class Case:
    """A system and the macro steps, as parts of a cycle, at which each scheme is tried."""

    pipe: str
    frequency: float
    acceleration: float
    cycles: int
    parts: dict[str, Sequence[int]]


FINEST = 4096
"""Parts of a cycle of the finest steps; others divide it."""

CASES = {
    "example": Case(
        resources.files("pipeclamp_identification").joinpath("data", "examples", "pipe.toml").read_text("utf-8"),
        3.9,
        1.0,
        16,
        {
            "iterated": (32, 64, 128, 256, 512),
            "implicit": (32, 64, 128, 256, 512),
            "sequential": (128, 256, 512, 1024, 2048),
            "parallel": (256, 512, 1024, 2048),
        },
    ),
    "stiff": Case(
        STIFF_PIPE,
        0.0,
        5.0,
        30,
        {
            "iterated": (16, 32, 64, 128),
            "implicit": (8, 16, 32, 64, 128),
            "implicit, native clamp": (8, 16, 32, 64, 128),
            "sequential": (256, 512, 1024, 2048),
            "parallel": (512, 1024, 2048, 4096),
        },
    ),
}


def resonance(folder: Path) -> tuple[float, float]:
    """Give the first natural frequency (Hz) with the clamp's k1 as a spring, and k1 over the pipe's own stiffness."""
    pipe, law = reduce(read_pipe(folder / "pipe.toml")), law_of(open_law(LAW))
    k1 = 1e3 * law.values["k10"] * 0.5 ** law.values["k1_A"]
    shape = np.array(pipe.clamp_shapes[0])
    frequency = np.sqrt(np.linalg.eigvalsh(pipe.stiffness_matrix + k1 * np.outer(shape, shape))[0]) / (2 * np.pi)
    return float(frequency), float(k1 * shape @ np.linalg.solve(pipe.stiffness_matrix, shape))


def system_text(case: Case, frequency: float, scheme: str, step: float, stop: float) -> str:
    """Give a SYSTEM.toml."""
    name, _, native = scheme.partition(", ")
    return (
        f'[pipe]\nfmu = "pipe.fmu"\n[[clamps]]\nat = "clamp1"\nfmu = "{"native" if native else "clamp"}.fmu"\n'
        f'temperature_C = 20\namplitude_mm = 0.5\n[excitation]\nkind = "sine"\n'
        f"acceleration_m_s2 = {case.acceleration}\nfrequency_Hz = {frequency!r}\n"
        f'[run]\nscheme = "{name}"\nstep_s = {step!r}\nstop_s = {stop!r}\n'
    )


def timed(folder: Path, case: Case, frequency: float, scheme: str, parts: int) -> tuple[float, Array]:
    """Give CPU time without loading, and the clamp's displacement."""
    file, step = folder / "system.toml", 1 / (frequency * parts)
    spent = []
    for stop in (OVERHEAD_STEPS * step, case.cycles / frequency):
        file.write_text(system_text(case, frequency, scheme, step, stop), encoding="utf-8")
        begin = time.process_time()
        result = run_described(read_system(file), folder, str(file), checked=False)
        spent.append(time.process_time() - begin)
    return spent[1] - spent[0], result.columns["clamp1.s"]


def measure(name: str, folder: Path) -> dict[str, list[tuple[float, float, float]]]:
    """Give (step in s, CPU time in s, error) by way of solution."""
    case = CASES[name]
    (folder / "pipe.toml").write_text(case.pipe, encoding="utf-8")
    build_pipe(reduce(read_pipe(folder / "pipe.toml")), folder / "pipe.fmu")
    build_clamp(open_law(LAW), folder / "clamp.fmu")
    schemes = dict(case.parts)
    try:
        build_native_clamp(open_law(LAW), folder / "native.fmu")
    except UserError as error:
        print(f"no native clamp: {error}")
        schemes.pop("implicit, native clamp", None)
    resonant, ratio = resonance(folder)
    frequency = case.frequency or round(resonant, 3)
    pipe = reduce(read_pipe(folder / "pipe.toml"))
    stop = case.cycles / frequency
    file = folder / "system.toml"
    file.write_text(system_text(case, frequency, "iterated", 1e-3, stop), encoding="utf-8")
    signal = excitation_signal(read_system(file).excitation, pipe.excitation, stop, folder, "benchmark")
    clamp = clamp_equations(law_of(open_law(LAW)), 0.5, frequency, 293.15)
    points = np.linspace(0.0, stop, case.cycles * FINEST + 1)
    exact = solve_monolithic(pipe, [clamp], signal, points, 1e-10).displacement[:, 0]
    scale = float(np.abs(exact).max())
    print(
        f"{name}: {frequency:g} Hz, first resonance with the clamp {resonant:.4g} Hz, {case.cycles} cycles, "
        f"{len(pipe.omega)} modes, clamp {ratio:.3g} times as stiff as the pipe, up to {1e3 * scale:.3g} mm"
    )
    found: dict[str, list[tuple[float, float, float]]] = {"monolithic": []}
    for tolerance in TOLERANCES:
        begin = time.process_time()
        ours = solve_monolithic(pipe, [clamp], signal, points[::32], tolerance).displacement[:, 0]
        spent = time.process_time() - begin
        found["monolithic"].append((0.0, spent, float(np.abs(ours - exact[::32]).max() / scale)))
        print(f"{'monolithic':24s} rtol {tolerance:7.0e}: {spent:6.2f} s   error {found['monolithic'][-1][2]:.1e}")
    for scheme, tried in schemes.items():
        found[scheme] = []
        for parts in tried:
            step = 1 / (frequency * parts)
            try:
                spent, ours = timed(folder, case, frequency, scheme, parts)
            except UserError:
                print(f"{scheme:24s} 1/{parts} cycle: diverges")
                continue
            error = float(np.abs(ours - exact[:: FINEST // parts]).max() / scale)
            found[scheme].append((step, spent, error))
            print(f"{scheme:24s} 1/{parts} cycle, {1e6 * step:6.1f} us: {spent:6.2f} s   error {error:.1e}")
    return found


def verdict(found: dict[str, list[tuple[float, float, float]]]) -> str:
    """Compare the largest steps that reach the goal."""
    best = {
        scheme: max((run for run in runs if run[2] <= GOAL), default=None)
        for scheme, runs in found.items()
        if scheme != "monolithic"
    }
    lines = [
        f"{scheme}: {'none of the steps tried' if run is None else f'{1e6 * run[0]:.4g} us, {run[1]:.3g} s'}"
        for scheme, run in best.items()
    ]
    return f"largest step for an error of {GOAL:.0%}, and its time: " + "; ".join(lines)


def picture_of(found: dict[str, list[tuple[float, float, float]]], title: str) -> go.Figure:
    """Draw error over CPU time."""
    figure = go.Figure(
        [
            go.Scatter(
                x=[run[1] for run in runs], y=[run[2] for run in runs], mode="lines+markers", name=way,
                marker={"size": 8}, text=[f"{1e6 * run[0]:.4g} us" if run[0] else "" for run in runs],
            )
            for way, runs in found.items()
        ]
    )  # fmt: skip
    figure.add_hline(y=GOAL, line={"dash": "dot", "width": 1.5})
    times = [0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20]
    figure.update_xaxes(title_text="CPU time / s", type="log", tickvals=times)
    figure.update_yaxes(title_text="largest error / largest displacement", type="log", dtick=1, exponentformat="power")
    return styled(figure, title, height=480)


def main(name: str = "stiff", page: str = "") -> None:
    """Measure, print, and draw where a page is asked for."""
    with tempfile.TemporaryDirectory() as folder:
        found = measure(name, Path(folder))
    print(verdict(found))
    if page:
        write_report(
            Path(page),
            "Coupling schemes",
            name,
            [Section(name, (verdict(found),), (), [picture_of(found, f"Work and precision: {name}")])],
        )


if __name__ == "__main__":
    main(*sys.argv[1:])
