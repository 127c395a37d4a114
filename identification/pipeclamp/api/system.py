"""Pipe and clamps, co-simulated."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeclamp.api.shown import PathOrName, path_of
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.base.tables import pl
from pipeclamp_models.base.toml_file import unknown
from pipeclamp_system.cosim.result import CosimResult, write_result
from pipeclamp_system.cosim.run import run_system
from pipeclamp_system.cosim.summary import summary_of

if TYPE_CHECKING:
    from pipeclamp.pages.page import Section
    from pipeclamp_identification.workflow.next_step import NextStep
    from pipeclamp_system.bands.ensemble import RunBands


class Cosimulation:
    """What a co-simulation gave.

    Attributes:
        origin: the system's description.
        result: all columns, units, the energy balance, and what is to be doubted.
        bands: how sure it is, where that was asked for.
    """

    def __init__(self, result: CosimResult, origin: Path, bands: RunBands | None = None) -> None:
        self.result = result
        self.bands = bands
        self.origin = origin

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
        target = Path(path)
        write_result(self.result, target)
        return target

    def report(self, path: PathOrName) -> Path:
        """Write the page with pictures, whole or not at all, and give its path.

        Raises:
            UserError: it can't be written there.
        """
        from pipeclamp.pages.page import write_report

        target = Path(path)
        write_report(target, f"Co-simulation: {self.result.name}", self.origin.name, self._sections())
        return target

    def _sections(self) -> Sequence[Section]:
        from pipeclamp.pages.system.cosim import cosim_sections

        return cosim_sections(self.result, self.bands, self._following())

    def _following(self) -> NextStep:
        from pipeclamp_identification.workflow.next_in_system import after_cosim

        return after_cosim(self.result, self.origin, "cosim.csv", bands=self.bands.per_cent if self.bands else None)

    def __str__(self) -> str:
        """Say what came out, and what isn't to be trusted."""
        from pipeclamp.pages.system.cosim import answer_first

        banded = self.bands.words() if self.bands else ()
        return "\n".join([*answer_first(summary_of(self.result).splitlines()), *banded, self._following().words()])

    def __repr__(self) -> str:
        """Give the system, and whether the result can be trusted."""
        return f"<co-simulation of {self.result.name}: {'trusted' if self.trusted else 'NOT TO BE TRUSTED'}>"

    def _repr_html_(self) -> str:
        """Give what a notebook shows."""
        return "".join(f"<p>{escape(line)}</p>" for line in str(self).splitlines())


@one_thread()
def cosim(system: PathOrName, *, bands: float | None = None) -> Cosimulation:
    """Couple a pipe FMU with clamp FMUs and run them.

    Args:
        system: description of the coupled system, SYSTEM.toml; paths in it are relative to its folder.
        bands: per cent that the bands of its columns are to hold, such as 95, by an ensemble of runs; None for none.

    Raises:
        UserError: the system can't be read, built or run, or no law tells how sure it is.

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
    path = Path(path_of(system, "the description of a system"))
    result = run_system(path)
    if bands is None:
        return Cosimulation(result, path)
    from pipeclamp_system.bands.ensemble import run_bands

    banded = run_bands(path, result, bands)
    return Cosimulation(banded.result, path, banded)
