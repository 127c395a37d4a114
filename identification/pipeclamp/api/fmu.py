"""Laws and pipes as FMUs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from pipeclamp.api.law import Law, opened
from pipeclamp.api.shown import PathOrName
from pipeclamp_models.base.errors import UsageError
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.base.units import CELSIUS

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

    start = ClampStart(
        A=None if amplitude is None else amplitude / 1000,
        f=frequency,
        T=None if temperature is None else temperature + CELSIUS,
        track=track,
        connected_temperature=temperature_input,
        events=events,
        memory_as_states=memory_as_states,
    )
    file, target = opened(law).file, Path(path)
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

    reduced, target = reduce(read_pipe(Path(pipe))), Path(path)
    if _native(kind, fmi, platforms):
        build.build_native_pipe(reduced, target, fmi, platforms)
    else:
        build.build_pipe(reduced, target)
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
