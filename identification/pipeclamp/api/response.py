"""The frequency response of pipe and clamps, and a system over many cases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeclamp.api.shown import (
    PathOrName,
    Reported,
    called_from_python,
    file_of,
    number_or_none,
    numbers_by_name,
    path_of,
)
from pipeclamp.api.system import A_SYSTEM
from pipeclamp_identification.workflow.systems.computed import Responded, respond
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.base.said import counted
from pipeclamp_system.response.curves import FrequencyResponse, peaks_of
from pipeclamp_system.response.summary import response_summary
from pipeclamp_system.response.table import response_frame, write_response

if TYPE_CHECKING:
    from pipeclamp.pages.page import Report
    from pipeclamp.show.table import Table
    from pipeclamp_identification.workflow.next_step import NextStep
    from pipeclamp_models.base.tables import pl
    from pipeclamp_system.bands.response_bands import ResponseBands


class Response(Reported):
    """A frequency response: steady states, stable or not, and co-simulations on them.

    Attributes:
        origin: the system's description.
        found: curves, co-simulations, and what is to be doubted.
        bands: how sure it is, where that was asked for.

    `response` makes one; its example shows what it holds.
    """

    def __init__(self, responded: Responded, origin: Path) -> None:
        self.found: FrequencyResponse = responded.found
        self.bands: ResponseBands | None = responded.bands
        self.origin = origin

    @property
    def points(self) -> tuple[str, ...]:
        """Names of clamps and probes."""
        return self.found.points

    def peaks(self) -> pl.DataFrame:
        """Give a row a curve and clamp or probe: its highest state.

        Returns:
            temperature_C (None: as each clamp's own), level, point, amplitude_mm, frequency_Hz; with bands their ends
            too: amplitude_low_mm, amplitude_high_mm, frequency_low_Hz, frequency_high_Hz.
        """
        from pipeclamp_models.base.tables import pl

        rows: list[dict[str, Any]] = []
        for place, curve in enumerate(self.found.curves):
            for index, (point, (amplitude, frequency)) in enumerate(zip(self.points, peaks_of(curve), strict=True)):
                row = {"temperature_C": curve.temperature, "level": curve.level, "point": point}
                row |= {"amplitude_mm": amplitude, "frequency_Hz": frequency}
                if self.bands:
                    peak = self.bands.curves[place].peaks[index]
                    row |= {"amplitude_low_mm": peak.amplitude.low, "amplitude_high_mm": peak.amplitude.high}
                    row |= {"frequency_low_Hz": peak.frequency.low, "frequency_high_Hz": peak.frequency.high}
                rows.append(row)
        return pl.DataFrame(rows, schema_overrides={"temperature_C": pl.Float64})

    def to_frame(self) -> pl.DataFrame:
        """Give a row a state of the curves and a co-simulation, with the columns of the CSV: "frequency [Hz]", ..."""
        return response_frame(self.found, self.bands.columns() if self.bands else None)

    def to_dict(self) -> dict[str, Any]:
        """Give system, excitation, peaks and all rows as dicts, lists, text, numbers and None."""
        return {
            "system": self.found.name,
            "excitation": self.found.excitation,
            "peaks": self.peaks().to_dicts(),
            "rows": self.to_frame().fill_nan(None).to_dicts(),
        }

    def save(self, path: PathOrName) -> Path:
        """Write curves and co-simulations as CSV, whole or not at all, as the command does, and give the path.

        Raises:
            UserError: it can't be written there.
        """
        target = file_of(path)
        write_response(self.found, target, self.bands.columns() if self.bands else None)
        return target

    def page(self) -> Report:
        """Give the page, as `pipeclamp response --report` writes it."""
        from pipeclamp.pages.system.response import response_page

        return response_page(self.found, self.origin.name, self.bands, self._following())

    def _following(self) -> NextStep:
        from pipeclamp_identification.workflow.systems.next_in_system import after_response

        bands = self.bands.per_cent if self.bands else None
        return after_response(self.found, self.origin, "response.csv", bands=bands)

    def _told(self) -> tuple[Sequence[Table], Sequence[str]]:
        from pipeclamp.pages.system.cosim import answer_first

        banded = self.bands.words() if self.bands else ()
        return [], [*answer_first(response_summary(self.found).splitlines()), *banded, self._following().words()]

    def __repr__(self) -> str:
        """Give the system and how many curves there are."""
        return (
            f"<response of {self.found.name}: {counted(len(self.found.curves), 'curve')} at {', '.join(self.points)}>"
        )


@called_from_python(limit="limits")
@one_thread()
def response(
    system: PathOrName,
    *,
    bands: float | None = None,
    limits: Mapping[str, float] | None = None,
    progress: Progress = silent,
) -> Response:
    """Give the frequency response of a pipe with its clamps: steady states, and co-simulations on them.

    Args:
        system: description of the coupled system, SYSTEM.toml, with [response].
        bands: per cent that the bands of curves and peaks are to hold, such as 95; None for none.
        limits: with bands: mm that clamps or probes may move, by name, such as {"clamp1": 0.8}: how likely they move
            farther.
        progress: is told what is being done.

    Raises:
        UserError: the system can't be read or built, has no sine, no law or nothing to show, a co-simulation fails, or
            no law tells how sure it is.

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
    ... response = { from_Hz = 18.0, to_Hz = 20.0, dots = 0, harmonics = 3 }
    ... ''')
    ...     found = response(Path(folder) / "system.toml")
    >>> found
    <response of cantilever with a clamp: 1 curve at clamp1>
    >>> found.peaks().columns
    ['temperature_C', 'level', 'point', 'amplitude_mm', 'frequency_Hz']
    """
    path, ends = Path(path_of(system, A_SYSTEM)), numbers_by_name(limits, "limits", '{"clamp1": 0.8}')
    return Response(respond(path, number_or_none(bands, "bands", "per cent"), ends, progress), path)
