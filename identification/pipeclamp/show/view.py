"""How what was found is told: its typed answer, lines and tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pipeclamp.show.table import Table
from pipeclamp_models.base.answer import AnswerModel


@dataclass(frozen=True)
class View:
    """What a command found, as it is told without pictures.

    Attributes:
        answer: for --json and for Python.
        tables: printed.
        lines: printed after them, most important first.
        whole: whether the tables hold every run.
    """

    answer: AnswerModel
    tables: Sequence[Table]
    lines: Sequence[str]
    whole: bool = True
