"""Building FMUs: a law into a clamp, a described pipe into a pipe."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from pipeclamp_fmu.contents.behind import what_stands_behind
from pipeclamp_fmu.contents.clamp import clamp_content
from pipeclamp_fmu.contents.clamp_model import USUAL, ClampModel, ClampStart, Entry, middle
from pipeclamp_fmu.contents.clamp_of_law import clamp_model
from pipeclamp_fmu.contents.content import Content
from pipeclamp_fmu.contents.continuous_memory import require_states
from pipeclamp_fmu.contents.excitation import Samples, excitation_content
from pipeclamp_fmu.contents.passivity import moved_about, require_dissipation
from pipeclamp_fmu.contents.passivity_proof import Proof, cycles_through, prove
from pipeclamp_fmu.contents.pipe import pipe_content
from pipeclamp_fmu.native.clamp import native_clamp
from pipeclamp_fmu.native.compiler import default_platforms
from pipeclamp_fmu.native.excitation import native_excitation
from pipeclamp_fmu.native.packing import Built, NativeContent, write_native_fmu
from pipeclamp_fmu.native.pipe import native_pipe
from pipeclamp_fmu.python.packing import write_fmu
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.file import LawFile, law_of, law_text
from pipeclamp_models.law.law import Structure
from pipeclamp_models.pipe.modes import ReducedPipe
from pipeclamp_models.realise.c import c_source
from pipeclamp_models.realise.scalar_law import loaded, parameter_values, source_of
from pipeclamp_models.realise.stepping import stepping


def version() -> str:
    """Give this program's version."""
    return importlib.metadata.version("pipeclamp")


def build_clamp(file: LawFile, output: Path, start: ClampStart = USUAL) -> str:
    """Build a clamp FMU (FMI 2.0 co-simulation, Python) from a law.

    Args:
        file: the law.
        output: the FMU to write, whole or not at all.
        start: what it starts with.

    Returns:
        the FMU's model identifier, unique for its content.

    Raises:
        UserError: the law would create energy over some closed cycle in its range, depends on a condition that isn't in
            that range, is told to start beyond it, or the FMU can't be written.
    """
    return write_fmu(python_clamp_content(file, start), output)


def build_clamp_to_run(file: LawFile, output: Path, *, passive: bool = False) -> str:
    """Build a law's Python FMU for a run of this program, after which it is gone.

    It has no icon, reference results, parameter sets or record, which nobody would look at, and building it for one run
    after another takes no more than writing it.

    Args:
        file: the law.
        output: the FMU to write, whole or not at all.
        passive: whether the law is taken to create no energy, as one that differs from such a law by its doubt.

    Returns:
        the FMU's model identifier.

    Raises:
        UserError: as `build_clamp`.
    """
    return write_fmu(_content_to_run(law_text(file), passive), output)


@lru_cache(maxsize=8)
def _content_to_run(law: str, passive: bool) -> Content:
    """Give what goes into the FMU of a law, the text of its file."""
    file = LawFile.model_validate_json(law)
    model = clamp_model(file)
    if not passive:
        require_passive(model, file)
    return clamp_content(model, version(), extras=False)


def build_native_clamp(
    file: LawFile, output: Path, fmi: int = 2, platforms: Sequence[str] | None = None, start: ClampStart = USUAL
) -> Built:
    """Build a clamp FMU (FMI 2.0 or 3.0, co-simulation and model exchange, C) from a law.

    Args:
        file: the law.
        output: the FMU to write, whole or not at all.
        fmi: version of FMI, 2 or 3.
        platforms: to compile for, see `compile.PLATFORMS`; the host's by default. None of them gives an FMU of sources.
        start: what it starts with.

    Raises:
        UserError: as `native_clamp_content`; a platform can't be compiled for.
    """
    content = native_clamp_content(file, start)
    return write_native_fmu(content, output, fmi, default_platforms(fmi) if platforms is None else platforms)


def python_clamp_content(file: LawFile, start: ClampStart = USUAL) -> Content:
    """Give all that goes into a law's Python FMU.

    Raises:
        UserError: as `build_clamp`.
    """
    model = clamp_model(file, start)
    require_passive(model, file)
    return clamp_content(_with_what_stands_behind(model, file), version())


def native_clamp_content(file: LawFile, start: ClampStart = USUAL) -> NativeContent:
    """Give all that goes into a law's native FMU.

    Raises:
        UserError: as `build_clamp`; its memory is to be continuous states and can't be.
    """
    model = clamp_model(file, start)
    if start.memory_as_states:
        require_states(model)
    require_passive(model, file)
    structure = law_of(file).structure
    states = [
        Entry(str(state.symbol), state.unit, state.meaning) for state in structure.equations_without_rig.composed.states
    ]
    return native_clamp(_with_what_stands_behind(model, file), c_source(structure), states, version())


def passivity(model: ClampModel, file: LawFile) -> Proof:
    """Prove that a law creates no energy in its range, where its structure allows.

    Args:
        model: the law as the FMU needs it.
        file: the law.
    """
    law = law_of(file)
    return _proof(law.structure, parameter_values(law), _ranges(model), model.about)


@lru_cache(maxsize=8)
def _proof(
    structure: Structure, values: tuple[float, ...], ranges: tuple[tuple[float, float], ...], about: float
) -> Proof:
    """Prove it once: who builds an FMU is told by the same proof that let it be built."""
    return prove(stepping(structure), values, ranges, about)


def require_passive(model: ClampModel, file: LawFile) -> None:
    """Refuse a law that would create energy over some closed cycle in its range; arguments as of `passivity`.

    Where it isn't proved that it doesn't, such a cycle is sought.

    Raises:
        UserError: it would.
    """
    law = law_of(file)
    _require_passive(model.name, law.structure, parameter_values(law), _ranges(model), model.about)


@lru_cache(maxsize=8)
def _require_passive(
    name: str, structure: Structure, values: tuple[float, ...], ranges: tuple[tuple[float, float], ...], about: float
) -> None:
    """Refuse it; once it has passed, it isn't tried again for another FMU of the same law."""
    proof = _proof(structure, values, ranges, about)
    law = moved_about(loaded(source_of(structure), values), about)
    require_dissipation(name, law, *ranges, begin=cycles_through(proof, about), proved=proof.proved)


def creates_energy(file: LawFile) -> str:
    """Say on which closed cycle in its range a law would create energy; empty where none is found."""
    try:
        require_passive(clamp_model(file), file)
    except UserError as error:
        return str(error)
    return ""


def _ranges(model: ClampModel) -> tuple[tuple[float, float], ...]:
    """Give the ranges of A (mm), f (Hz), T (K) and further conditions."""
    return (model.range_A, model.range_f, model.temperatures, *(entry.interval for entry in model.further))


def build_pipe(pipe: ReducedPipe, output: Path) -> str:
    """Build a pipe FMU (FMI 2.0 co-simulation, Python) from a reduced pipe.

    Args:
        pipe: what `pipeclamp.pipe.reduce` makes of a description.
        output: the FMU to write, whole or not at all.

    Returns:
        the FMU's model identifier, unique for its content.

    Raises:
        UserError: the description can't serve, or the FMU can't be written.
    """
    return write_fmu(pipe_content(pipe, version()), output)


def build_native_pipe(pipe: ReducedPipe, output: Path, fmi: int = 2, platforms: Sequence[str] | None = None) -> Built:
    """Build a pipe FMU (FMI 2.0 or 3.0, co-simulation and model exchange, C) from a reduced pipe.

    Args:
        pipe: what `pipeclamp.pipe.reduce` makes of a description.
        output: the FMU to write, whole or not at all.
        fmi: version of FMI, 2 or 3.
        platforms: as `build_native_clamp`.

    Raises:
        UserError: the FMU can't be written, or a platform can't be compiled for.
    """
    content = native_pipe(pipe, version())
    return write_native_fmu(content, output, fmi, default_platforms(fmi) if platforms is None else platforms)


def build_excitation(samples: Samples, output: Path) -> str:
    """Build an FMU (FMI 2.0 co-simulation, Python) that gives an excitation.

    Returns:
        the FMU's model identifier, unique for its content.

    Raises:
        UserError: the FMU can't be written.
    """
    return write_fmu(excitation_content(samples, version()), output)


def build_native_excitation(
    samples: Samples, output: Path, fmi: int = 2, platforms: Sequence[str] | None = None
) -> Built:
    """Build an FMU (FMI 2.0 or 3.0, co-simulation and model exchange, C) that gives an excitation.

    Raises:
        UserError: the FMU can't be written, or a platform can't be compiled for.
    """
    content = native_excitation(samples, version())
    return write_native_fmu(content, output, fmi, default_platforms(fmi) if platforms is None else platforms)


def _with_what_stands_behind(model: ClampModel, file: LawFile) -> ClampModel:
    """Give the law with its parameter sets and its record, of the loop in the middle of its range."""
    middles = (middle(model.range_A), middle(model.range_f), model.temperature)
    further = tuple(entry.scale * entry.start for entry in model.further)
    values = {entry.name: entry.value for entry in model.coefficients}
    return replace(model, behind=what_stands_behind(file, model.source, values, (*middles, *further), version()))
