"""Laws and pipes as FMUs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from pipeclamp.api.law import Law, opened
from pipeclamp.api.shown import PathOrName, Told, flag_of, number_or_none, path_of
from pipeclamp_models.base.errors import UsageError
from pipeclamp_models.base.files import FMU, SSP, refuse_ending
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.base.units import CELSIUS

if TYPE_CHECKING:
    from pipeclamp.show.table import Table
    from pipeclamp_system.cosim.parallel_step import ParallelStep

FmuKind = Literal["python", "native"]


@one_thread()
def build_fmu(
    law: Law | PathOrName,
    path: PathOrName,
    kind: FmuKind = "python",
    *,
    fmi: Literal[2, 3] = 2,
    platforms: Sequence[str] | None = None,
    amplitude: float | None = None,
    frequency: float | None = None,
    temperature: float | None = None,
    track: bool = False,
    temperature_input: bool = False,
    events: bool = True,
    memory_as_states: bool = False,
) -> Path:
    """Package a law as an FMU with A, f and T parameters.

    Args:
        law: the law, or its file or bundled name.
        path: the FMU to write, whole or not at all.
        kind: "python" needs a Python in the importing tool; "native" is C and needs nothing.
        fmi: native: version of FMI.
        platforms: native: of linux64, win64, darwin64; this machine's by default, none for sources alone.
        amplitude: A at the start, mm; the middle of the law's range by default.
        frequency: f at the start, Hz; likewise.
        temperature: T at the start, °C; likewise.
        track: A and f follow the motion.
        temperature_input: T_in is an input to connect, in place of T.
        events: native: in model exchange, a reversal of the motion is an event where the law has memory.
        memory_as_states: native: in model exchange, memory is continuous states, for tools that complete no steps.

    Returns:
        the FMU's path.

    Raises:
        UserError: the law is to start beyond its range, or would create energy over a cycle in it, a platform can't be
            compiled for, or the FMU can't be written.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     build_fmu("emwm2", Path(folder) / "clamp.fmu", amplitude=0.5, frequency=3.0).name
    'clamp.fmu'
    """
    from pipeclamp_fmu.build import build_clamp, build_native_clamp
    from pipeclamp_fmu.contents.clamp_model import ClampStart

    A, T = number_or_none(amplitude, "amplitude", "mm"), number_or_none(temperature, "temperature", "°C")
    start = ClampStart(
        A=None if A is None else A / 1000,
        f=number_or_none(frequency, "frequency", "Hz"),
        T=None if T is None else T + CELSIUS,
        track=flag_of(track, "track"),
        connected_temperature=flag_of(temperature_input, "temperature_input"),
        events=flag_of(events, "events"),
        memory_as_states=flag_of(memory_as_states, "memory_as_states"),
    )
    file, target = opened(law).file, _target(path, FMU, "an FMU")
    if not events and kind == "python":
        raise UsageError("events=False is for kind='native'; a Python FMU has no model exchange")
    if memory_as_states and kind == "python":
        raise UsageError("memory_as_states=True is for kind='native'; a Python FMU has no model exchange")
    if _native(kind, fmi, platforms):
        build_native_clamp(file, target, fmi, platforms, start)
    else:
        build_clamp(file, target, start)
    return target


@one_thread()
def set_parameters(fmu: PathOrName, law: Law | PathOrName, path: PathOrName | None = None) -> Path:
    """Put another law's parameters into a finished clamp FMU, without a compiler.

    Args:
        fmu: an FMU made by `build_fmu`, of a law with the same base and effects.
        law: the law, or its file or bundled name.
        path: the FMU to write, whole or not at all; the same unless told.

    Returns:
        the path of the FMU that was written.

    Raises:
        UserError: the file is no such FMU, the law has other equations, its range doesn't hold what the FMU was told to
            start with, or the FMU can't be written.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     fmu = build_fmu("published_R1", Path(folder) / "clamp.fmu")
    ...     set_parameters(fmu, "published_R2", Path(folder) / "other.fmu").name
    'other.fmu'
    """
    from pipeclamp_fmu import set_parameters as setting

    given = Path(path_of(fmu, "a clamp's FMU"))
    target = given if path is None else _target(path, FMU, "an FMU")
    setting.set_parameters(given, opened(law).file, target)
    return target


@one_thread()
def build_pipe(
    pipe: PathOrName,
    path: PathOrName,
    kind: FmuKind = "python",
    *,
    fmi: Literal[2, 3] = 2,
    platforms: Sequence[str] | None = None,
) -> Path:
    """Package a pipe as an FMU with a port for each of its clamps.

    Args:
        pipe: description of the pipe, PIPE.toml.
        path, kind, fmi, platforms: as of `build_fmu`.

    Returns:
        the FMU's path.

    Raises:
        UserError: the description can't serve, a platform can't be compiled for, or the FMU can't be written.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     written = Path(folder, "pipe.toml").write_text('''
    ... name = "pipe"
    ... pipe = { outer_diameter_mm = 60.3, wall_mm = 2.9, length_m = 3.0, material = "304L" }
    ... ends = { left = "clamped", right = "free" }
    ... clamps = [{ name = "clamp1", position_m = 2.0 }]
    ... excitation = { kind = "base" }
    ... damping = { ratio = 0.005 }
    ... modes = { up_to_Hz = 50.0 }
    ... ''')
    ...     build_pipe(Path(folder) / "pipe.toml", Path(folder) / "pipe.fmu").name
    'pipe.fmu'
    """
    from pipeclamp_fmu import build
    from pipeclamp_models.pipe.description import read_pipe
    from pipeclamp_models.pipe.modes import reduce

    reduced, target = reduce(read_pipe(Path(path_of(pipe, "a pipe, PIPE.toml")))), _target(path, FMU, "an FMU")
    if _native(kind, fmi, platforms):
        build.build_native_pipe(reduced, target, fmi, platforms)
    else:
        build.build_pipe(reduced, target)
    return target


class SystemPackage(Told):
    """A coupled system packaged for other masters.

    Attributes:
        path: the SSP.

    `build_system` makes one.
    """

    def __init__(self, path: Path, found: ParallelStep) -> None:
        self.path = path
        self._found = found

    @property
    def step_s(self) -> float | None:
        """The longest macro step for masters that couple in parallel, s; None where none is known."""
        return self._found.step

    @property
    def step_error(self) -> float:
        """The error of the displacement in the shortest step that was tried, as a share; inf where it isn't known."""
        return self._found.error

    def __fspath__(self) -> str:
        """Give the path of the SSP, so that it may stand where a path does."""
        return str(self.path)

    def _told(self) -> tuple[Sequence[Table], Sequence[str]]:
        from pipeclamp.show.packaged import parallel_words

        return [], [f"{self.path}: SSP 1.0", parallel_words(self._found)]

    def __repr__(self) -> str:
        """Give the file and the step."""
        return f"<system {self.path.name}: {f'steps of {self.step_s:g} s' if self.step_s else 'no step known'}>"


@one_thread()
def build_system(
    system: PathOrName, path: PathOrName, kind: FmuKind = "python", *, progress: Progress = silent
) -> SystemPackage:
    """Package a coupled system, FMUs, connections and parameters, as an SSP 1.0 for other masters.

    Args:
        system: description of the coupled system, SYSTEM.toml.
        path: the SSP to write, whole or not at all.
        kind: of all that isn't an FMU yet, as of `build_fmu`.
        progress: is told which steps are tried.

    Returns:
        the SSP's path, and the step that masters may take.

    Raises:
        UserError: the system can't be read or built, has too many steps, or the file can't be written.

    >>> build_system("system.toml", "system.ssp")  # doctest: +SKIP
    <system system.ssp: steps of 0.001 s>
    """
    from pipeclamp_system.cosim.building import NATIVE, PYTHON
    from pipeclamp_system.cosim.ssp import write_system

    described, target = Path(path_of(system, "the description of a system, SYSTEM.toml")), _target(path, SSP, "an SSP")
    build = NATIVE if _native(kind, 2, None) else PYTHON
    return SystemPackage(target, write_system(described, target, build, progress))


def _target(path: PathOrName, ending: str, what: str) -> Path:
    """Give the file to write.

    Raises:
        UserError: it is no path, or its name ends otherwise.
    """
    target = Path(path_of(path, f"the name of {what} to write"))
    refuse_ending(target, ending, what)
    return target


def _native(kind: FmuKind, fmi: int, platforms: Sequence[str] | None) -> bool:
    """Tell whether a native FMU is wanted.

    Raises:
        UsageError: there is no such kind, or what is asked for belongs to the other one.
    """
    if kind not in ("python", "native"):
        raise UsageError(f"kind: got {kind!r}; expected 'python' or 'native'")
    if kind == "python" and (fmi != 2 or platforms is not None):
        raise UsageError("fmi and platforms are for kind='native'; a Python FMU is of FMI 2.0, for linux64 and win64")
    return kind == "native"
