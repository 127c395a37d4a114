"""Cost of co-simulation against the monolithic solution at the same accuracy, for the example pipe and clamp.

Run: python build_scripts/benchmarks/cosim_speed.py [LAW]

Prints, for each coupling scheme and macro step and for the monolithic solution at several tolerances, the CPU time and
the largest error of the clamp's displacement against a much finer monolithic solution; then, for each co-simulation,
its time as a ratio to what the monolithic solution takes for the same error (interpolated between its tolerances).
Building and loading of the FMUs is not counted.
"""

from __future__ import annotations

import sys
import tempfile
import time
from importlib import resources
from pathlib import Path

import numpy as np

from pipeclamp.bundled import open_law
from pipeclamp.errors import UserError
from pipeclamp.parameter_file import law_of
from pipeclamp.pipe import reduce
from pipeclamp.pipe_description import read_pipe
from pipeclamp_fmu.build import build_clamp, build_pipe
from pipeclamp_identification.cosim import run_system
from pipeclamp_identification.excitation import excitation_signal
from pipeclamp_identification.monolithic import clamp_equations, solve_monolithic
from pipeclamp_identification.system import read_system

STEPS = (4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4)
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
STOP = 4.0
OVERHEAD_STEPS = 10
"""A run of so few steps measures what loading costs."""


def prepare(folder: Path, law: str) -> str:
    """Build the example's FMUs in a folder and give the text of its system, with {scheme}, {step}, {stop} in it."""
    examples = resources.files("pipeclamp_identification").joinpath("data", "examples")
    (folder / "pipe.toml").write_text(examples.joinpath("pipe.toml").read_text(encoding="utf-8"), encoding="utf-8")
    build_pipe(reduce(read_pipe(folder / "pipe.toml")), folder / "pipe.fmu")
    build_clamp(open_law(law), folder / "clamp.fmu")
    return (
        '[pipe]\nfmu = "pipe.fmu"\n[[clamps]]\nat = "clamp1"\nfmu = "clamp.fmu"\ntemperature_C = 20\n'
        'amplitude_mm = 0.5\n[excitation]\nkind = "sine"\nacceleration_m_s2 = 1.0\nfrequency_Hz = 3.9\n'
        '[run]\nscheme = "{scheme}"\nstep_s = {step}\nstop_s = {stop}\n'
    )


def timed_system(folder: Path, text: str, scheme: str, step: float) -> tuple[float, np.ndarray, float]:
    """Give CPU time without loading, the clamp's displacement, and trials per step."""
    file = folder / "system.toml"
    spent, result = {}, None
    for stop in (OVERHEAD_STEPS * step, STOP):
        file.write_text(text.format(scheme=scheme, step=step, stop=stop), encoding="utf-8")
        begin = time.process_time()
        result = run_system(file)
        spent[stop] = time.process_time() - begin
    assert result is not None
    columns = result.columns
    return spent[STOP] - spent[OVERHEAD_STEPS * step], columns["clamp1.s"], float(columns["trials"][1:].mean())


def main(law: str = "emwm2") -> None:
    """Measure and print."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        text = prepare(folder, law)
        file = folder / "system.toml"
        file.write_text(text.format(scheme="iterated", step=STEPS[-1], stop=STOP), encoding="utf-8")
        system, pipe = read_system(file), reduce(read_pipe(folder / "pipe.toml"))
        signal = excitation_signal(system.excitation, pipe.excitation, STOP, folder, "benchmark")
        clamp = clamp_equations(law_of(open_law(law)), 0.5, 3.9, 293.15)
        points = np.linspace(0.0, STOP, round(STOP / STEPS[-1]) + 1)
        exact = solve_monolithic(pipe, [clamp], signal, points, 1e-10).displacement[:, 0]
        scale = np.abs(exact).max()
        print(f"law {law}, {STOP:g} s at 3.9 Hz, {len(pipe.omega)} modes")
        errors, times = [], []
        for tolerance in TOLERANCES:
            begin = time.process_time()
            found = solve_monolithic(pipe, [clamp], signal, points, tolerance).displacement[:, 0]
            times.append(time.process_time() - begin)
            errors.append(float(np.abs(found - exact).max() / scale))
            print(f"monolithic  rtol {tolerance:7.0e}: {times[-1]:6.2f} s   error {errors[-1]:.1e}")
        order = np.argsort(errors)
        for scheme in ("iterated", "sequential", "parallel"):
            for step in STEPS:
                try:
                    spent, found, trials = timed_system(folder, text, scheme, step)
                except UserError:
                    print(f"{scheme:11s} step {step:7.1e}: diverges")
                    continue
                error = np.abs(found - exact[:: round(step / STEPS[-1])]).max() / scale
                same = np.exp(np.interp(np.log(error), np.log(errors)[order], np.log(times)[order]))
                print(
                    f"{scheme:11s} step {step:7.1e}: {spent:6.2f} s   error {error:.1e}   "
                    f"{1e6 * spent * step / STOP:4.0f} us and {trials:.1f} trials a step   "
                    f"{spent / same:.2f} of the monolithic time for this error"
                )


if __name__ == "__main__":
    main(*sys.argv[1:])
