"""Cost of a native clamp's step in a C host and in fmpy, as ratios within one run.

Run: python build_scripts/benchmarks/native_step.py [LAW ...]

Prints what set (2 Real) + step + get (1 Real) costs, in nanoseconds and as a ratio to two empty FMUs: one that only
copies values, and one with this project's whole FMI layer and no law. Linux, with a C compiler.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from math import cos, sin
from pathlib import Path

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

from pipeclamp_fmu.build import build_native_clamp
from pipeclamp_fmu.contents.clamp_model import ClampStart
from pipeclamp_fmu.native.compiler import FLAGS, system_compiler
from pipeclamp_models.law.bundled import bundled_laws, open_law

HOST = Path(__file__).parents[1] / "c_host"
STEPS = 100_000
FMPY_STEPS = 20_000
ROUNDS = 7


def compiled(sources: Path, source: Path, output: Path, *options: str) -> Path:
    """Compile a C file next to an FMU's sources."""
    command = [str(system_compiler()), *options, "-DFMU_SHARED_LIBRARY", f"-I{sources}", str(source), "-o", str(output)]
    subprocess.run([*command, "-ldl", "-lm", "-lpthread"], check=True)
    return output


def in_c(host: Path, library: Path, token: str, resources: Path) -> float:
    """Nanoseconds per step in the C host."""
    command = [str(host), str(library), token, resources.as_uri(), "speed", str(STEPS)]
    return float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def in_fmpy(folder: Path, identifier: str, token: str) -> float:
    """Nanoseconds per step in fmpy, best of some rounds."""
    slave = FMU2Slave(guid=token, unzipDirectory=str(folder), modelIdentifier=identifier, instanceName="clamp")
    slave.instantiate()
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    motion = [[5e-4 * sin(0.01 * n), 5e-3 * cos(0.01 * n)] for n in range(FMPY_STEPS)]
    best = float("inf")
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        for n, values in enumerate(motion):
            slave.setReal([1, 2], values)
            slave.doStep(1e-3 * n, 1e-3)
            slave.getReal([7])
        best = min(best, time.perf_counter() - begin)
    slave.freeInstance()
    return 1e9 * best / FMPY_STEPS


def unpacked(fmu: Path, folder: Path) -> tuple[str, str, Path]:
    """Unpack an FMU; give its identifier, its token and its library."""
    description = read_model_description(str(fmu))
    extract(str(fmu), unzipdir=str(folder))
    identifier = description.coSimulation.modelIdentifier
    return identifier, description.guid, folder / "binaries" / "linux64" / f"{identifier}.so"


def without_law(folder: Path, sources: Path, library: Path) -> None:
    """Compile an FMU's sources again with a step that does nothing."""
    folder.mkdir()
    for source in sources.iterdir():
        text = source.read_text(encoding="utf-8")
        if source.name == "clamp.c":
            text = text.replace("static int model_step(", "static int unused_step(")
            text += """
static int model_step(Model *model, const Values *values, Scratch *scratch, double end, double h, char reason[TEXT])
{
    (void)values, (void)scratch, (void)end, (void)h, (void)reason, (void)unused_step;
    model->real[FORCE] = 0;
    return 1;
}
"""
        (folder / source.name).write_text(text, encoding="utf-8")
    compiled(folder, folder / "fmu.c", library, *FLAGS, "-fPIC")


def main() -> None:
    """Measure and print."""
    with tempfile.TemporaryDirectory() as scratch:
        root = Path(scratch)
        host: Path | None = None
        bare = 0.0
        for name in sys.argv[1:] or bundled_laws():
            fmu, folder = root / f"{name}.fmu", root / name
            build_native_clamp(open_law(name), fmu)
            identifier, token, library = unpacked(fmu, folder)
            if host is None:
                host = compiled(folder / "sources", HOST / "host.c", root / "host", "-O2")
                options = ("-O2", "-shared", "-fPIC")
                copying = compiled(folder / "sources", HOST / "empty.c", root / "empty.so", *options)
                bare = in_c(host, copying, token, folder)
            ours, ours_in_fmpy = in_c(host, library, token, folder / "resources"), in_fmpy(folder, identifier, token)
            build_native_clamp(open_law(name), fmu, start=ClampStart(track=True))
            _, its_token, its_library = unpacked(fmu, root / f"{name}_tracked")
            tracked = in_c(host, its_library, its_token, root / f"{name}_tracked" / "resources")
            without_law(root / f"{name}_empty", folder / "sources", library)
            empty, empty_in_fmpy = in_c(host, library, token, folder / "resources"), in_fmpy(folder, identifier, token)
            print(
                f"{name}: C host {ours:.1f} ns, {ours / empty:.1f} times the same FMU without its law ({empty:.1f} ns) "
                f"and {ours / bare:.1f} times one that copies values ({bare:.1f} ns); "
                f"with track {tracked:.1f} ns, {tracked / empty:.1f} times; "
                f"fmpy {ours_in_fmpy / 1e3:.2f} us, {ours_in_fmpy / empty_in_fmpy:.2f} times the one without its law"
            )


if __name__ == "__main__":
    main()
