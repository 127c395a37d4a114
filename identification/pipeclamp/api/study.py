"""A system over many cases."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeclamp.api.shown import PathOrName, Reported, called_from_python, number_or_none, path_of, processes
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_system.study.description import Study, read_study
from pipeclamp_system.study.run import run_study

if TYPE_CHECKING:
    from pipeclamp.pages.page import Report
    from pipeclamp.show.table import Table
    from pipeclamp_identification.workflow.next_step import NextStep
    from pipeclamp_models.base.tables import pl


class Sweep(Reported):
    """A study's cases, and what the system's pipe does in each.

    Attributes:
        origin: the study's description.
        path: the table's file, Parquet.
        study: what the description says.

    `sweep` makes one; its example shows what it holds.
    """

    def __init__(self, study: Study, frame: pl.DataFrame, origin: Path, path: Path) -> None:
        self.study = study
        self.origin = origin
        self.path = path
        self._frame = frame

    def __len__(self) -> int:
        """Count the cases."""
        return self._frame.height

    def to_frame(self) -> pl.DataFrame:
        """Give a row a case: what was varied, amplitudes in mm, and what to know of it; `error` where it has none."""
        return self._frame

    def to_dict(self) -> dict[str, Any]:
        """Give the study's name, what was measured and varied, and the cases as dicts, numbers, text and None."""
        described = self.study.description
        return {
            "study": described.name,
            "measure": described.measure,
            "varied": {place: list(values) for place, values in described.axes.items()},
            "cases": self._frame.fill_nan(None).to_dicts(),
        }

    def page(self) -> Report:
        """Give the page, as `pipeclamp sweep --report` writes it."""
        from pipeclamp.pages.system.study import study_page

        return study_page(self.study, self._frame, self._following())

    def _following(self) -> NextStep:
        from pipeclamp_identification.workflow.systems.next_in_system import after_sweep

        return after_sweep(self.study, self._frame, self.origin, str(self.path))

    def _told(self) -> tuple[Sequence[Table], Sequence[str]]:
        answer, *_ = self.page().sections
        following = self._following()
        lines = [line for line in answer.paragraphs if line not in following.before()]
        return [], [*lines, following.words()]

    def __repr__(self) -> str:
        """Give the study's name and how many cases there are."""
        return f"<sweep {self.study.description.name}: {len(self)} cases>"


@called_from_python()
@one_thread()
def sweep(
    study: PathOrName,
    path: PathOrName,
    *,
    jobs: int = -1,
    dask: str | None = None,
    bands: float | None = None,
    progress: Progress = silent,
) -> Sweep:
    """Vary a system over many cases; where it was stopped, the same call goes on.

    Args:
        study: the system and what is varied in it, STUDY.toml.
        path: the table to write, Parquet; beside it stand the finished cases until all are.
        jobs: processes that share the work; -1 for as many as there are cores.
        dask: address of a Dask scheduler that takes the cases instead.
        bands: per cent that the bands of amplitudes are to hold, such as 95; None for none.
        progress: is told how many cases are done.

    Raises:
        UserError: a file can't be read, a place isn't there, no law tells how sure it is, or the table can't be
            written.

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
    ...     written = Path(folder, "system.toml").write_text('''
    ... name = "cantilever with a clamp"
    ... pipe = { file = "pipe.toml" }
    ... clamps = [{ at = "clamp1", law = "emwm2", temperature_C = 20.0, amplitude_mm = 0.5, frequency_Hz = 3.0 }]
    ... excitation = { kind = "sine", acceleration_m_s2 = 4.0, frequency_Hz = 20.0 }
    ... run = { stop_s = 2.0, step_s = 0.001 }
    ... ''')
    ...     written = Path(folder, "study.toml").write_text('''
    ... name = "temperatures"
    ... system = "system.toml"
    ... vary = { "system.clamps.clamp1.temperature_C" = [20.0, 150.0] }
    ... ''')
    ...     found = sweep(Path(folder) / "study.toml", Path(folder) / "study.parquet", jobs=1)
    >>> found
    <sweep temperatures: 2 cases>
    >>> found.to_frame()["clamp1.s [mm]"].is_sorted()
    True
    """
    origin, target = Path(path_of(study, "the description of a study, STUDY.toml")), Path(path_of(path, "a file"))
    jobs = processes(jobs)
    read = read_study(origin, number_or_none(bands, "bands", "per cent"))

    def tell(done: int, count: int) -> None:
        progress(f"{done} of {count} cases")

    return Sweep(read, run_study(read, target, jobs, dask, tell), origin, target)
