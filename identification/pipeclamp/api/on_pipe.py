"""Pipe and clamps held against what was measured on the pipe."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from pipeclamp.api.shown import PathOrName, Shown, called_from_python, frame_of, number_or_none, path_of
from pipeclamp.api.system import A_SYSTEM
from pipeclamp.show.view import View
from pipeclamp_identification.attribution.attributed import Attributed
from pipeclamp_identification.workflow.systems.held import hold_on_pipe
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.base.progress import Progress, silent

if TYPE_CHECKING:
    from pipeclamp.pages.page import Report
    from pipeclamp_identification.workflow.next_step import NextStep
    from pipeclamp_models.base.tables import pl


class PipeComparison(Shown):
    """How much pipe and clamps err against what was measured, where, and which parameter may be wrong.

    Attributes:
        system, measured: SYSTEM.toml, and the measurement's folder.
        found: errors and verdict, as the other rooms of the program work on them.

    `compare_pipe` makes one; its example shows it.
    """

    def __init__(self, found: Attributed, system: Path, measured: Path) -> None:
        self.found = found
        self.system = system
        self.measured = measured

    @property
    def nrmse(self) -> float:
        """Rms error of the model as stated, over the rms of what was measured: of sines where there are any."""
        found: float = self.to_dict()["nrmse"]
        return found

    @property
    def verdict(self) -> str | None:
        """One of complete, wrong, ambiguous, unknown; None where too little was measured to ask."""
        return None if self.found.attribution is None else self.found.attribution.verdict

    def _following(self, *, reported: bool) -> NextStep:
        from pipeclamp_identification.workflow.systems.next_on_pipe import after_pipe_comparison

        return after_pipe_comparison(self.found, str(self.system), str(self.measured), reported=reported)

    @cached_property
    def _view(self) -> View:
        from pipeclamp.show.on_pipe import attributed_view

        return attributed_view(self.found, self._following(reported=False))

    def view(self) -> View:
        """Give answer, tables and sentences, as `pipeclamp compare` tells them."""
        return self._view

    def page(self) -> Report:
        """Give the page, as `pipeclamp compare --report` writes it."""
        from pipeclamp.pages.system.on_pipe import attributed_page

        return attributed_page(self.found, self._following(reported=True))

    def to_frame(self) -> pl.DataFrame:
        """Give a row a sine that was measured, its conditions and error; of records alone, a row a record."""
        answer = self.to_dict()
        return frame_of(answer["sines"] or answer["records"])

    def candidates(self) -> pl.DataFrame:
        """Give a row a parameter, or two, that may be wrong, best first: its refitted value, and what it leaves.

        Raises:
            UserError: too little was measured to ask.
        """
        attribution = self.to_dict()["attribution"]
        if attribution is None:
            raise UserError("candidates: too little was measured to ask which parameter may be wrong")
        rows = attribution["candidates"]
        return frame_of([{**row, "parameters": ", ".join(row["parameters"])} for row in rows])

    def __repr__(self) -> str:
        """Give system and measurement, error and verdict."""
        names = f"{self.found.compared.system.name} with {self.found.compared.description.name}"
        return f"<comparison of {names}: error {self.nrmse:.2%}{f', {self.verdict}' if self.verdict else ''}>"


@called_from_python()
@one_thread()
def compare_pipe(
    system: PathOrName, measured: PathOrName, *, bands: float | None = None, progress: Progress = silent
) -> PipeComparison:
    """Hold a pipe with its clamps against what was measured on it: how much it errs, where, and what may be wrong.

    Args:
        system: description of the coupled system, SYSTEM.toml.
        measured: folder with measurement.toml.
        bands: per cent that the model's bands at measured sines are to hold, such as 95; None for none.
        progress: is told what is being done.

    Raises:
        UserError: the system or the measurement can't be read, or no law tells how sure it is.

    >>> compare_pipe("system.toml", "measured")  # doctest: +SKIP
    <comparison of cantilever with shaker test: error 4.1%, complete>
    """
    path, folder = Path(path_of(system, A_SYSTEM)), Path(path_of(measured, "the folder of a measurement"))
    found = hold_on_pipe(path, folder, number_or_none(bands, "bands", "per cent"), progress)
    return PipeComparison(found, path, folder)
