"""The law on a pipe: its frequency response with the clamp cold and hot, as files that `pipeclamp response` reads."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from pipeclamp_identification.loops.loops import Loops
from pipeclamp_identification.signals.levels import varies
from pipeclamp_models.base.answer import AnswerModel
from pipeclamp_models.base.digits import rounded_to
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import write_whole
from pipeclamp_models.base.progress import Progress
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.file import LawFile, read_law
from pipeclamp_models.pipe.beam import modes
from pipeclamp_models.pipe.description import PipeDescription, Support, read_pipe
from pipeclamp_models.pipe.modes import finite_elements
from pipeclamp_models.pipe.section import beam_of

PIPE = "pipe.toml"
"""The pipe's description: an example's where the folder has none; it may be changed there."""
SYSTEM = """
# The pipe of {pipe}, held by the clamp of {law}, shaken near its first resonance.
name = {name}

[pipe]
file = "{pipe}"
{clamps}
[excitation]
kind = "sine"
{excitation}
frequency_Hz = {middle}

[run]
stop_s = 30.0
# Four steps in a period of the highest frequency that the pipe's modes are kept up to.
step_s = {step}
scheme = "iterated"

[response]
# From below the pipe's first resonance without clamps to above that with clamps as stiff as any.
from_Hz = {low}
to_Hz = {high}
levels = [0.1, 0.25]
dots = 0
{temperatures}"""
CLAMP = """
[[clamps]]
at = {at}
law = "{law}"
temperature_C = {temperature}
# The law's A and f: followed from the motion itself; these are where it starts.
track = true
amplitude_mm = {amplitude}
frequency_Hz = {middle}
"""
EXCITATIONS = {"base": "acceleration_m_s2 = 1.0", "force": "force_N = 100.0"}
"""By the kind of the pipe's excitation; the response is found at shares of them."""
BELOW, ABOVE = 0.85, 1.1
"""Of the first resonance without clamps and with rigid ones: damping moves the peak, which should be shown whole."""
FIRST_FREQUENCY_SHARE = 0.25
"""Of the first resonance with rigid clamps: there a response begins of a pipe that nothing else holds."""
ROOM_C = 20.0
"""Of tests that tell no temperature."""


class OnPipe(AnswerModel):
    """A response as it is shown: in words, and as pictures of Plotly with what each shows."""

    words: tuple[str, ...]
    pictures: tuple[tuple[str, str], ...]


def temperatures_of(loops: Loops) -> tuple[float, ...]:
    """Give the lowest and the highest temperature of tests, °C; one where they vary by no more than drives miss.

    None where no test tells it.
    """
    known = loops.temperature_K[np.isfinite(loops.temperature_K)]
    if not len(known):
        return ()
    if not varies("T", known):
        return (round(float(known.mean()) - CELSIUS, 1),)
    # rounded inwards: beyond them is beyond the law's data
    return math.ceil(10 * (known.min() - CELSIUS)) / 10, math.floor(10 * (known.max() - CELSIUS)) / 10


def first_resonances(pipe: PipeDescription) -> tuple[float, float]:
    """Give the first resonance of a pipe without clamps, 0 where nothing else holds it, and with rigid ones, Hz.

    Raises:
        UserError: a clamp sits where something else holds the pipe.
    """
    rigid = tuple(Support(position_m=clamp.position_m, condition="pinned") for clamp in pipe.clamps)
    held = pipe.model_copy(update={"supports": (*pipe.supports, *rigid), "clamps": ()})
    free, stiff = (modes(beam_of(one), finite_elements(one))[0][0] / (2 * math.pi) for one in (pipe, held))
    return float(free), float(stiff)


def system_text(pipe: PipeDescription, file: LawFile, law: str, temperatures_C: Sequence[float]) -> str:
    """Give the description of a pipe with a law at each of its clamps, as `pipeclamp response` reads it.

    Args:
        pipe: of pipe.toml.
        file: the law; it starts in the middle of its amplitudes.
        law: name of its file.
        temperatures_C: at which the response is found; none where the tests tell none.

    Raises:
        UserError: the pipe has no clamp, or one that sits where something else holds the pipe.
    """
    if not pipe.clamps:
        raise UserError(f"{PIPE}: the pipe has no clamp; expected [[clamps]] with name and position_m")
    free, stiff = first_resonances(pipe)
    low, high = _short(BELOW * (free or FIRST_FREQUENCY_SHARE * stiff)), _short(ABOVE * stiff)
    middle, amplitudes = _short((low + high) / 2), file.range.get("A")
    shared = {
        "law": law, "middle": middle, "temperature": temperatures_C[0] if temperatures_C else ROOM_C,
        "amplitude": _short(math.sqrt(amplitudes.minimum * amplitudes.maximum)) if amplitudes else 0.5,
    }  # fmt: skip
    clamps = "".join(CLAMP.format(at=_quoted(clamp.name), **shared) for clamp in pipe.clamps)
    return SYSTEM.lstrip().format(
        pipe=PIPE, law=law, name=_quoted(f"{pipe.name} with {law.removesuffix('.json')}"), clamps=clamps,
        excitation=EXCITATIONS[pipe.excitation.kind], middle=middle, low=low, high=high,
        step=_short(1 / (4 * pipe.modes.up_to_Hz)),
        temperatures=f"temperatures_C = {list(temperatures_C)}\n" if temperatures_C else "",
    )  # fmt: skip


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)  # as TOML quotes it too


def _short(value: float) -> float:
    """Give a number with three digits, as a person would write it."""
    return rounded_to(value, 3)


def respond(
    tell: Progress, *, law: str, system: str, output: str, shown: str, temperatures_C: list[float]
) -> dict[str, Any]:
    """Describe the pipe with the law's clamp, find its response, and write description, curves and pictures."""
    from pipeclamp.pages.alternative import words_of
    from pipeclamp.pages.system.response import WORDS, response_picture
    from pipeclamp_system.response.run import run_response
    from pipeclamp_system.response.summary import response_summary
    from pipeclamp_system.response.table import write_response

    tell("the pipe's own resonances")
    path = Path(system)
    if not (path.parent / PIPE).exists():
        write_whole(path.parent / PIPE, _example(PIPE))
    pipe = read_pipe(path.parent / PIPE)
    write_whole(path, system_text(pipe, read_law(Path(law)), Path(law).name, temperatures_C))
    found = run_response(path, tell)
    write_response(found, Path(output))
    figures = [response_picture(found, index).update_layout(height=None) for index in range(len(found.points))]
    pictures = tuple((_specification(figure), words_of(figure)) for figure in figures)
    write_whole(
        Path(shown), OnPipe(words=(WORDS, *response_summary(found).splitlines()), pictures=pictures).json_text()
    )
    return {"file": Path(output).name}


def shown_on_pipe(path: Path) -> OnPipe | None:
    """Give what was found on the pipe; None where nothing was."""
    try:
        return OnPipe.model_validate_json(path.read_text(encoding="utf-8"))
    except (OSError, ValidationError, UnicodeDecodeError):
        return None


def _specification(figure: Any) -> str:
    specification = json.loads(figure.to_json())
    specification["layout"].pop("template", None)
    return json.dumps(specification)


def _example(name: str) -> str:
    example = resources.files("pipeclamp_identification").joinpath("data", "examples", name)
    return example.read_text(encoding="utf-8")
