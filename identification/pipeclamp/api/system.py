"""Pipe and clamps, co-simulated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeclamp.api.shown import (
    PathOrName,
    Reported,
    called_from_python,
    file_of,
    number_or_none,
    numbers_by_name,
    path_of,
)
from pipeclamp_identification.workflow.systems.computed import CoSimulated, co_simulate
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.base.tables import pl
from pipeclamp_models.base.toml_file import unknown
from pipeclamp_system.cosim.result import write_result
from pipeclamp_system.cosim.summary import summary_of

if TYPE_CHECKING:
    from pipeclamp.pages.page import Report
    from pipeclamp.show.table import Table
    from pipeclamp_identification.workflow.next_step import NextStep

A_SYSTEM = "the description of a system, SYSTEM.toml"
"""What `cosim` and its like expect."""
PLACES = '{"system.clamps.clamp1.temperature_C": 150.0}'
"""Values by place, for an error."""


class Cosimulation(Reported):
    """What a co-simulation gave.

    Attributes:
        origin: the system's description.
        values: what was other than it states, by place.
        result: all columns, units, the energy balance, and what is to be doubted.
        bands: how sure it is, where that was asked for.
    """

    def __init__(self, found: CoSimulated, origin: Path, values: Mapping[str, float]) -> None:
        self.result = found.result
        self.bands = found.bands
        self.origin = origin
        self.values = dict(values)

    @property
    def trusted(self) -> bool:
        """Whether the macro step is short enough, and neither energy nor motion is lost beyond the stated share."""
        return self.result.trusted

    def amplitude(self, place: str) -> float:
        """Give the amplitude of the displacement at a clamp or probe in the last fifth of the run, mm.

        Raises:
            UserError: there is no such clamp or probe.
        """
        places = [name.removesuffix(".s") for name in self.result.columns if name.endswith(".s")]
        if place not in places:
            raise UserError(f"amplitude: {unknown(place, places, 'clamp or probe')}")
        return 1e3 * self.result.amplitude(f"{place}.s")

    def to_frame(self) -> pl.DataFrame:
        """Give the columns of the result, a row a communication point, SI units; names as in the CSV, without units."""
        return pl.DataFrame({name: np.asarray(values) for name, values in self.result.columns.items()})

    def to_dict(self) -> dict[str, Any]:
        """Give the columns as lists, by name, with their units."""
        return {
            "system": self.result.name,
            "trusted": self.trusted,
            "units": dict(self.result.units),
            "columns": {name: np.asarray(values).tolist() for name, values in self.result.columns.items()},
        }

    def save(self, path: PathOrName) -> Path:
        """Write the result as CSV with names and units, whole or not at all, and give its path.

        Raises:
            UserError: it can't be written there.
        """
        target = file_of(path)
        write_result(self.result, target)
        return target

    def page(self) -> Report:
        """Give the page, as `pipeclamp cosim --report` writes it."""
        from pipeclamp.pages.system.cosim import cosim_page

        return cosim_page(self.result, self.origin.name, self.bands, self._following())

    def _following(self) -> NextStep:
        from pipeclamp_identification.workflow.systems.next_in_system import after_cosim

        step = after_cosim(self.result, self.origin, "cosim.csv", bands=self.bands.per_cent if self.bands else None)
        return step.once(f"once {self._values_words()} stands in its file") if self.values else step

    def _values_words(self) -> str:
        return ", ".join(f"{place} = {value:g}" for place, value in self.values.items())

    def _told(self) -> tuple[Sequence[Table], Sequence[str]]:
        """Say what came out, and what isn't to be trusted."""
        from pipeclamp.pages.system.cosim import answer_first

        banded = self.bands.words() if self.bands else ()
        given = [f"With {self._values_words()}."] if self.values else []
        return [], [*given, *answer_first(summary_of(self.result).splitlines()), *banded, self._following().words()]

    def __repr__(self) -> str:
        """Give the system, and whether the result can be trusted."""
        return f"<co-simulation of {self.result.name}: {'trusted' if self.trusted else 'NOT TO BE TRUSTED'}>"


@called_from_python(vary="values")
@one_thread()
def cosim(
    system: PathOrName,
    *,
    bands: float | None = None,
    values: Mapping[str, float] | None = None,
    progress: Progress = silent,
) -> Cosimulation:
    """Couple a pipe FMU with clamp FMUs and run them.

    Args:
        system: description of the coupled system, SYSTEM.toml; paths in it are relative to its folder.
        bands: per cent that the bands of its columns are to hold, such as 95, by an ensemble of runs; None for none.
        values: other values than the files state, by place as in a study's [vary]:
            {"system.clamps.clamp1.temperature_C": 150.0, "pipe.flow.velocity_m_s": 2.0}; the pipe must be a PIPE.toml.
        progress: is told what is being done.

    Raises:
        UserError: the system can't be read, built or run, a place isn't there, or no law tells how sure it is.

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
    ... excitation = { kind = "sine", acceleration_m_s2 = 1.0, frequency_Hz = 3.0 }
    ... run = { stop_s = 2.0, step_s = 0.001 }
    ... ''')
    ...     result = cosim(Path(folder) / "system.toml")
    >>> result
    <co-simulation of cantilever with a clamp: trusted>
    """
    path, given = Path(path_of(system, A_SYSTEM)), numbers_by_name(values, "values", PLACES)
    return Cosimulation(co_simulate(path, number_or_none(bands, "bands", "per cent"), progress, given), path, given)
