"""What makes the FMUs of a described system: of pipes from their description, of clamps from their laws."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from pipeclamp_fmu.build import (
    build_clamp,
    build_clamp_to_run,
    build_excitation,
    build_native_clamp,
    build_native_excitation,
    build_native_pipe,
    build_pipe,
)
from pipeclamp_fmu.contents.excitation import Samples
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import LawFile, read_law
from pipeclamp_models.pipe.description import read_pipe
from pipeclamp_models.pipe.modes import ReducedPipe, reduce
from pipeclamp_system.description.system import PipeSource, SystemDescription


@dataclass(frozen=True)
class Builders:
    """What makes the FMUs of clamps that are given by their laws, of pipes that are described, of excitations."""

    clamp: Callable[[LawFile, Path], object] = build_clamp
    pipe: Callable[[ReducedPipe, Path], object] = build_pipe
    excitation: Callable[[Samples, Path], object] = build_excitation


PYTHON = Builders()
"""Python FMUs: made at once, and run wherever this program does."""

TO_RUN = Builders(build_clamp_to_run)
"""Python FMUs for one run, without what people and other programs would ask of them."""

TO_RUN_IN_DOUBT = Builders(partial(build_clamp_to_run, passive=True))
"""The same for laws that differ by their doubt from one that creates no energy: a run that does fails by itself."""

NATIVE = Builders(build_native_clamp, build_native_pipe, build_native_excitation)
"""Native FMUs: they take a C compiler, and run wherever they were compiled for."""


@contextmanager
def finished(description: SystemDescription, folder: Path, build: Builders = TO_RUN) -> Iterator[SystemDescription]:
    """Give the description with all its FMUs built; those that were built are gone at the end.

    Args:
        description: the system.
        folder: what its paths are relative to.
        build: what makes the FMUs.

    Raises:
        UserError: a pipe or a law can't be read or built.
    """
    built = Path(tempfile.mkdtemp(prefix="pipeclamp_"))
    try:
        pipe = description.pipe
        if pipe.fmu is None:
            build.pipe(reduce(read_pipe(folder / str(pipe.file))), built / "pipe.fmu")
            pipe = PipeSource(fmu=str(built / "pipe.fmu"))
        clamps = []
        for index, clamp in enumerate(description.clamps):
            if clamp.fmu is None:
                output = built / f"clamp_{index}.fmu"
                build.clamp(law_in(folder, str(clamp.law)), output)
                clamp = clamp.model_copy(update={"fmu": str(output)})
            clamps.append(clamp)
        yield description.model_copy(update={"pipe": pipe, "clamps": tuple(clamps)})
    finally:
        shutil.rmtree(built, ignore_errors=True)


def law_in(folder: Path, name: str) -> LawFile:
    """Give a law by its path relative to a folder, or by the name of a bundled one."""
    path = folder / name
    return read_law(path) if path.suffix or path.exists() else open_law(name)
