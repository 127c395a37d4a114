"""Compiling an FMU's C sources into shared libraries: the system's compiler for this platform, Zig's for all."""

from __future__ import annotations

import base64
import json
import os
import platform
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Literal

from pipeclamp_models.base.errors import UsageError, UserError
from pipeclamp_models.base.kept import kept

MAIN_SOURCE = "fmu.c"

FLAGS = (
    "-std=c99",
    "-O2",
    "-shared",
    "-fvisibility=hidden",
    "-DFMU_SHARED_LIBRARY",
    "-ffp-contract=off",  # so that every platform gives the same numbers but for the mathematics library's last digit
    "-fno-math-errno",  # nobody asks for it, and the compiler can then work around the mathematics library's calls
)


@dataclass(frozen=True)
class Target:
    """A platform that FMUs are compiled for: its folders by FMI version, its libraries' ending, Zig's name for it."""

    folder: Mapping[int, str]
    ending: str
    zig: str
    flags: tuple[str, ...] = ()


PLATFORMS: Mapping[str, Target] = {
    # glibc 2.17 of 2013 runs on every Linux that is still in use.
    "linux64": Target({2: "linux64", 3: "x86_64-linux"}, ".so", "x86_64-linux-gnu.2.17", ("-fPIC", "-lm")),
    "win64": Target({2: "win64", 3: "x86_64-windows"}, ".dll", "x86_64-windows-gnu"),
    "linux-arm64": Target({3: "aarch64-linux"}, ".so", "aarch64-linux-gnu.2.17", ("-fPIC", "-lm")),
    "darwin64": Target({2: "darwin64", 3: "x86_64-darwin"}, ".dylib", "x86_64-macos", ("-fPIC",)),
    "darwin-arm64": Target({3: "aarch64-darwin"}, ".dylib", "aarch64-macos", ("-fPIC",)),
}
"""Platforms by the names that FMI 2.0 gives them; it has none for ARM, which is for FMI 3.0 alone."""


def host_platform() -> str | None:
    """Give the platform that this program runs on, None where it is none of PLATFORMS."""
    names = {
        ("Linux", "x86_64"): "linux64",
        ("Linux", "aarch64"): "linux-arm64",
        ("Windows", "AMD64"): "win64",
        ("Darwin", "x86_64"): "darwin64",
        ("Darwin", "arm64"): "darwin-arm64",
    }
    return names.get((platform.system(), platform.machine()))


def system_compiler() -> str | None:
    """Give the C compiler on the path, None where there is none."""
    return next((found for name in ("cc", "gcc", "clang") if (found := shutil.which(name))), None)


def default_platforms(fmi: int) -> tuple[str, ...]:
    """Give what can be compiled here for a version of FMI: the host's platform, or none without a compiler."""
    host = host_platform()
    able = host is not None and fmi in PLATFORMS[host].folder and (system_compiler() or find_spec("ziglang"))
    return (host,) if able and host is not None else ()


def kind_unasked() -> Literal["python", "native"]:
    """Give the kind of FMU that is made where nobody asks for one: native where a C compiler is found."""
    return "native" if default_platforms(fmi=2) else "python"


def refuse_unknown_platforms(platforms: Sequence[str], fmi: int) -> None:
    """Refuse platforms that there are no libraries for.

    Raises:
        UserError: with the platforms that there are.
    """
    known = [name for name, target in PLATFORMS.items() if fmi in target.folder]
    for name in platforms:
        if name not in known:
            raise UsageError(f"platform {name!r} is not known for FMI {fmi}; expected some of {', '.join(known)}")


def compile_sources(sources: Mapping[str, str], platforms: Sequence[str]) -> dict[str, bytes]:
    """Compile sources, of which `fmu.c` includes the others, into a shared library for each platform.

    What the same compiler made of the same sources is kept from one call to the next.

    Args:
        sources: text by file name.
        platforms: of PLATFORMS.

    Raises:
        UserError: there is no compiler for a platform, or it failed.
    """
    libraries: dict[str, bytes] = {}
    for name in platforms:
        compiler = _compiler(name)
        output = f"{name}{PLATFORMS[name].ending}"
        command = [*compiler, *FLAGS, MAIN_SOURCE, "-o", output, *PLATFORMS[name].flags]
        described = json.dumps([_identity(compiler), command, dict(sources)], sort_keys=True)

        def make(name: str = name, command: Sequence[str] = command, output: str = output) -> str:
            return base64.b64encode(_compiled(sources, name, command, output)).decode()

        libraries[name] = base64.b64decode(kept(f"library {described}", make))
    return libraries


def _identity(compiler: Sequence[str]) -> list[str]:
    """Tell a compiler from others and from what it was before: Zig's by its version, else by its file."""
    if "ziglang" in compiler:
        return [version("ziglang")]
    file = Path(compiler[0]).resolve()
    return [str(file), str(file.stat().st_size), str(file.stat().st_mtime_ns)]


def _compiled(sources: Mapping[str, str], name: str, command: Sequence[str], output: str) -> bytes:
    """Run a compiler on sources in a folder of its own; give what it made.

    Raises:
        UserError: it failed.
    """
    with tempfile.TemporaryDirectory(prefix="pipeclamp_") as folder:
        for file, text in sources.items():
            (Path(folder) / file).write_text(text, encoding="utf-8", newline="\n")
        failed, told = _ran(command, folder)
        made = Path(folder) / output
        if failed or not made.exists():
            # In whatever encoding the compiler has: what it says must not hide that it failed.
            said = told.decode("utf-8", "replace").strip().splitlines() or ["it said nothing"]
            reason = next((line for line in said if "error" in line), said[-1])
            raise UserError(
                f"the C compiler {command[0]} failed for {name}: {reason}; expected one that takes C99 and GCC's "
                "options (GCC, Clang, or `pip install 'pipeclamp[native]'`)"
            )
        return made.read_bytes()


def _ran(command: Sequence[str], folder: str) -> tuple[int, bytes]:
    """Run a compiler, and end it with all that it started where this is interrupted.

    Args:
        command: with its arguments.
        folder: that it runs in, and that holds what it keeps for a while.

    Returns:
        its exit status and what it said on stderr.
    """
    temporary = dict.fromkeys(("TMPDIR", "TMP", "TEMP"), folder)
    with subprocess.Popen(
        command, cwd=folder, env=os.environ | temporary, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE, start_new_session=True,
    ) as process:  # fmt: skip
        try:
            _, told = process.communicate()
        except BaseException:
            _end(process)
            raise
    return process.returncode, told


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a process that was started as the first of its session, with its children."""
    if hasattr(os, "killpg"):
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    else:
        process.kill()
    process.wait()


def _compiler(name: str) -> list[str]:
    """Give the command that compiles for a platform.

    Raises:
        UserError: there is none.
    """
    own = system_compiler()
    if name == host_platform() and own is not None:
        return [own]
    if find_spec("ziglang") is not None:
        return [sys.executable, "-m", "ziglang", "cc", "-target", PLATFORMS[name].zig, "-s"]
    raise UserError(
        f"there is no C compiler for {name}; expected Zig's, which compiles for all platforms: "
        "pip install 'pipeclamp[native]'"
    )
