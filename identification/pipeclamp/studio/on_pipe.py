"""The law on a pipe: its frequency response with the clamp cold and hot, as files that `pipeclamp response` reads."""

from __future__ import annotations

import json
import math
from importlib import resources
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from pipeclamp_models.base.answer import AnswerModel
from pipeclamp_models.base.files import write_whole
from pipeclamp_models.base.progress import Progress
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.file import LawFile, read_law

PIPE = "pipe.toml"
"""The pipe's description: an example's where the folder has none; it may be changed there."""
RESPONSE = """
[response]
# The pipe's first resonance lies here whatever the clamp's stiffness, and the clamp moves within most laws' data.
from_Hz = 3.5
to_Hz = 5.5
levels = [0.1, 0.25]
dots = 0
"""


class OnPipe(AnswerModel):
    """A response as it is shown: in words, and as pictures of Plotly with what each shows."""

    words: tuple[str, ...]
    pictures: tuple[tuple[str, str], ...]


def system_text(file: LawFile, law: str) -> str:
    """Give the description of the example's pipe with a law's clamp, at the ends of the law's temperatures."""
    example = _example("system.toml").replace("clamp_a.json", law)
    T = file.range.get("T")
    # rounded inwards: beyond them is beyond the law's data
    ends = {math.ceil(10 * (T.minimum - CELSIUS)) / 10, math.floor(10 * (T.maximum - CELSIUS)) / 10} if T else set()
    temperatures = sorted(ends)
    told = f"temperatures_C = {temperatures}\n" if temperatures else ""
    return f"{example.rstrip()}\n{RESPONSE}{told}"


def respond(tell: Progress, *, law: str, system: str, output: str, shown: str) -> dict[str, Any]:
    """Describe the pipe with the law's clamp, find its response, and write description, curves and pictures."""
    from pipeclamp.pages.alternative import words_of
    from pipeclamp.pages.system.response import response_picture
    from pipeclamp_system.steady.response import run_response, write_response

    path = Path(system)
    if not (path.parent / PIPE).exists():
        write_whole(path.parent / PIPE, _example(PIPE))
    write_whole(path, system_text(read_law(Path(law)), Path(law).name))
    found = run_response(path, tell)
    write_response(found, Path(output))
    figures = [response_picture(found, index).update_layout(height=None) for index in range(len(found.points))]
    pictures = tuple((_specification(figure), words_of(figure)) for figure in figures)
    write_whole(Path(shown), OnPipe(words=tuple(found.summary().splitlines()), pictures=pictures).json_text())
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
