"""The native FMU in C programs: a host without Python, threads, many instances, and up to a million random calls."""

import math
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import pytest
from native_driver import NativeDriver
from project import BUILD_SCRIPTS

from pipeclamp_fmu.native.compiler import system_compiler

HERE = Path(__file__).parent
HOST = BUILD_SCRIPTS / "c_host" / "host.c"
SANITIZERS = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
CALLS = {2: 1_000_000, 3: 1_000_000, "pipe": 300_000, "loaded_pipe": 50_000}
"""Fewer for pipes, which find new matrices for nearly every random step."""


def compiled(sources, program, *options):
    """Compile a program next to an FMU's sources."""
    compiler = system_compiler()
    if compiler is None:
        pytest.skip("there is no C compiler (cc, gcc or clang) on the path")
    command = [compiler, "-std=c11", "-O1", "-g", "-DFMU_SHARED_LIBRARY", f"-I{sources}", *options]
    return subprocess.run([*command, "-o", str(program), "-lm"], capture_output=True, text=True, check=False)


@pytest.fixture(params=[2, 3, "pipe", "loaded_pipe"])
def unpacked(request, native_fmus, native_pipes, tmp_path):
    """Give a native FMU's token, its folder and how many calls: the clamp in both versions, pipes of both kinds."""
    fmu = (native_fmus | native_pipes)[request.param]
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(tmp_path / "fmu")
    description = fmpy.read_model_description(str(fmu))
    return description.guid or description.instantiationToken, tmp_path / "fmu", CALLS[request.param]


def test_random_calls_end_in_a_status(unpacked, tmp_path):
    """NaN, infinities, denormals, wrong order, unknown references, corrupted states, under the sanitizers."""
    token, folder, calls = unpacked
    program = tmp_path / "fuzz"
    (tmp_path / "empty.c").write_text("int main(void) { return 0; }", encoding="utf-8")
    if compiled(folder / "sources", program, str(tmp_path / "empty.c"), *SANITIZERS).returncode:
        pytest.skip("the C compiler has no sanitizers")
    done = compiled(folder / "sources", program, str(HERE / "fuzz.c"), *SANITIZERS)
    assert done.returncode == 0, done.stderr
    run = subprocess.run(
        [str(program), token, str(folder / "resources"), str(calls), "1"], capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stdout + run.stderr[-3000:]


@pytest.fixture
def host(native_fmus, tmp_path):
    """Give a function that runs the C host in one of its modes and gives what it printed."""
    if not sys.platform.startswith("linux"):
        pytest.skip("the C host loads libraries as Linux does")
    with zipfile.ZipFile(native_fmus[2]) as archive:
        archive.extractall(tmp_path / "fmu")
    done = compiled(tmp_path / "fmu" / "sources", tmp_path / "host", str(HOST), "-ldl", "-lpthread")
    assert done.returncode == 0, done.stderr
    description = fmpy.read_model_description(str(native_fmus[2]))
    library = tmp_path / "fmu" / "binaries" / fmpy.platform / f"{description.coSimulation.modelIdentifier}.so"

    def run(mode, count):
        arguments = [str(library), description.guid, (tmp_path / "fmu" / "resources").as_uri(), mode, str(count)]
        done = subprocess.run([str(tmp_path / "host"), *arguments], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return [float(line) for line in done.stdout.split()]

    return run


def test_a_host_without_python_gets_the_same_forces(host, native_fmus, tmp_path):
    clamp = NativeDriver(native_fmus[2], tmp_path / "driven", "CoSimulation", {})
    expected = []
    for n in range(500):
        theta = 6 * math.pi * 1e-3 * (n + 1)
        clamp.step(1e-3, 5e-4 * math.sin(theta), 5e-4 * 6 * math.pi * math.cos(theta))
        expected += clamp.get("flange.f")
    clamp.free()
    assert host("forces", 500) == pytest.approx(expected, rel=1e-12)


def test_a_hundred_thousand_instances_leave_nothing_behind(host):
    """Growth of the peak of memory, kB, after the first hundredth of them."""
    (growth,) = host("cycles", 100_000)
    assert growth <= 64


def test_instances_in_threads_are_independent(host):
    assert host("threads", 8) == [0]
