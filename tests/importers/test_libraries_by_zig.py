"""Zig makes libraries for every platform; those for Windows, in a host under Wine, give what those for Linux give.

What Zig makes for all libraries of a platform takes it a minute: these tests stand in one file so that it's made once.
"""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest

from pipeclamp_fmu.build import build_native_clamp, build_native_pipe
from pipeclamp_fmu.native.compiler import PLATFORMS
from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_models.pipe.modes import reduce

pytest.importorskip("ziglang", reason="ziglang isn't installed: pip install 'pipeclamp[native]'")

MAGIC = {
    2: {"linux64": b"\x7fELF", "win64": b"MZ", "darwin64": b"\xcf\xfa\xed\xfe"},
    3: {"aarch64-linux": b"\x7fELF", "aarch64-darwin": b"\xcf\xfa\xed\xfe"},
}
ZIG_PLATFORMS = {2: ("linux64", "win64", "darwin64"), 3: ("linux-arm64", "darwin-arm64")}

LAST_DIGITS = 1e-12
"""The mathematics libraries of Linux and Windows differ in the last digit of a power."""
STEP, STEPS = 1e-4, 3000


@pytest.mark.parametrize("fmi", [2, 3])
def test_zig_compiles_for_every_platform(law_with_memory, tmp_path, fmi):
    built = build_native_clamp(law_with_memory, tmp_path / "all.fmu", fmi, ZIG_PLATFORMS[fmi])
    assert built.platforms == ZIG_PLATFORMS[fmi]
    with zipfile.ZipFile(tmp_path / "all.fmu") as archive:
        for folder, magic in MAGIC[fmi].items():
            (library,) = [name for name in archive.namelist() if name.startswith(f"binaries/{folder}/")]
            assert archive.read(library).startswith(magic)


@pytest.fixture(scope="module")
def hosts(tmp_path_factory):
    """Give how the host is begun, by platform."""
    wine = shutil.which("wine") or shutil.which("wine64")
    if wine is None:
        pytest.skip("Wine isn't installed: apt-get install wine64")
    folder = tmp_path_factory.mktemp("hosts")
    headers, source = Path(fmpy.__file__).parent / "c-code", Path(__file__).with_name("windows_host.c")
    begun = {"linux64": [], "win64": [wine]}
    for platform, command in begun.items():
        host = folder / f"host_{platform}.exe"
        # stripped as the libraries are, or Zig would make all that belongs to a platform once more
        zig = [sys.executable, "-m", "ziglang", "cc", "-target", PLATFORMS[platform].zig, "-s", "-O2"]
        subprocess.run([*zig, f"-I{headers}", str(source), "-o", str(host)], check=True)
        command.append(str(host))
    return begun


@pytest.fixture(scope="module")
def wine_prefix(tmp_path_factory):
    """Give what Wine keeps, made anew."""
    return {**os.environ, "WINEPREFIX": str(tmp_path_factory.mktemp("wine") / "prefix"), "WINEDEBUG": "-all"}


def outputs_of(fmu, platform, begun, folder, environment, inputs, outputs, motion):
    """Give an FMU's outputs, (steps, outputs), along a motion, (steps, inputs), with its library for a platform."""
    unpacked = Path(fmpy.extract(str(fmu), unzipdir=str(folder / f"{fmu.stem}_{platform}")))
    description = fmpy.read_model_description(str(fmu))
    references = {variable.name: str(variable.valueReference) for variable in description.modelVariables}
    name = description.coSimulation.modelIdentifier + PLATFORMS[platform].ending
    command = [*begun, str(unpacked / "binaries" / platform / name), description.guid]
    command += [(unpacked / "resources").as_uri(), str(STEP)]
    command += [",".join(references[variable] for variable in chosen) for chosen in (inputs, outputs)]
    text = "\n".join(" ".join(map(repr, row)) for row in motion.tolist())
    done = subprocess.run(command, input=text, env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return np.array([[float(number) for number in line.split()] for line in done.stdout.split("\n") if line.strip()])


def assert_alike(fmu, hosts, folder, environment, inputs, outputs, motion):
    """Hold the library for Windows against the one for Linux."""
    linux, windows = (
        outputs_of(fmu, platform, hosts[platform], folder, environment, inputs, outputs, motion)
        for platform in ("linux64", "win64")
    )
    assert linux.shape == (STEPS, len(outputs))
    assert np.all(np.ptp(linux, axis=0) > 0)
    np.testing.assert_allclose(windows, linux, rtol=LAST_DIGITS, atol=LAST_DIGITS * np.max(np.abs(linux)))


@pytest.fixture(scope="module")
def clamp(law_with_memory, tmp_path_factory):
    """Give the FMU of a clamp for Linux and Windows."""
    fmu = tmp_path_factory.mktemp("clamp") / "clamp.fmu"
    build_native_clamp(law_with_memory, fmu, platforms=["linux64", "win64"])
    return fmu


def test_a_clamp_with_memory_is_the_same_under_windows(clamp, hosts, wine_prefix, tmp_path):
    omega, time = 2 * np.pi * 6.0, STEP * np.arange(1, STEPS + 1)
    motion = 5e-4 * np.column_stack([np.sin(omega * time), omega * np.cos(omega * time)])
    assert_alike(clamp, hosts, tmp_path, wine_prefix, ["flange.s", "flange.v"], ["flange.f"], motion)


def test_under_windows_its_files_are_found_by_any_form_of_their_path(clamp, hosts, wine_prefix, tmp_path):
    """UTF-8 in a URI, as the standard says; what a host's `main` is given is in the code page of the computer."""
    folder = tmp_path / "Jörg's FMU (x86)"
    fmpy.extract(str(clamp), unzipdir=str(folder))
    description = fmpy.read_model_description(str(clamp))
    library = folder / "binaries" / "win64" / f"{description.coSimulation.modelIdentifier}.dll"
    backslashed = f"Z:{folder / 'resources'}".replace("/", "\\")
    encoded = (folder / "resources").as_uri().replace("file:///", "file:///Z:/")
    environment = {**wine_prefix, "LC_ALL": "C.UTF-8"}
    for given in (encoded, f"\\\\?\\{backslashed}"):
        command = [*hosts["win64"], str(library), description.guid, given, "0.001", "1", "7"]
        done = subprocess.run(command, input="1e-4", env=environment, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, f"{given}: {done.stderr}"


def test_a_pipe_is_the_same_under_windows(pipe_text, hosts, wine_prefix, tmp_path):
    fmu = tmp_path / "pipe.fmu"
    build_native_pipe(reduce(parse_pipe(pipe_text("pipe"))), fmu, platforms=["linux64", "win64"])
    time = STEP * np.arange(1, STEPS + 1)
    motion = np.column_stack([30.0 * np.sin(50.0 * time), -20.0 * np.sin(90.0 * time)])
    forces, places = ["clamp1.f", "clamp2.f"], ["clamp1.s", "clamp2.s"]
    assert_alike(fmu, hosts, tmp_path, wine_prefix, forces, places, motion)
