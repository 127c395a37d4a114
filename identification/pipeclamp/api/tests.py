"""Loop tests of a clamp, read from a campaign's folder."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from pipeclamp.api.shown import PathOrName, Shown, flag_of, frame_of, path_of
from pipeclamp.show.view import View
from pipeclamp_identification.metrics_only.campaign import MetricRun
from pipeclamp_identification.workflow.reading import read_tests
from pipeclamp_identification.workflow.tests import Tests as AnyTests
from pipeclamp_models.base.digits import plain
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.one_thread import one_thread

if TYPE_CHECKING:
    from pipeclamp.pages.page import Report
    from pipeclamp_models.base.tables import pl


class Tests(Shown):
    """The loop tests of one clamp: records, or metrics alone.

    Attributes:
        origin: the folder or the bundled name that they were read from.
        tests: what the other rooms of the program work on.

    >>> print(read_campaign("clamp_a"))
    clamp_a: 48 runs, A 0.195 to 1.01 mm, f 1 to 5 Hz, T 18.6 to 302 °C
    >>> len(read_campaign("clamp_a")), next(iter(read_campaign("clamp_a")))
    (48, 'A0p2_f1_T20')
    """

    __test__ = False  # no test of pytest's, whatever its name

    def __init__(self, tests: AnyTests, origin: str) -> None:
        self.tests = tests
        self.origin = origin

    @property
    def name(self) -> str:
        """The campaign's name."""
        return self.tests.name

    @property
    def left_out(self) -> tuple[str, ...]:
        """Runs that can't be used, each with the reason."""
        return tuple(map(str, self.tests.left_out))

    @property
    def remarks(self) -> tuple[str, ...]:
        """What to know of the runs, those of free motion among them, which only `compare` takes."""
        known = self.tests.of_sines() if self.tests.has_loops else self.tests
        return tuple(known.remarks)

    @property
    def runs(self) -> tuple[str, ...]:
        """Names of the runs that can be used, as in runs.csv; those of free motion last."""
        return (*(run.name for run in self._loops), *self.tests.free_runs)

    def __len__(self) -> int:
        """Count the runs that can be used."""
        return len(self.runs)

    def __iter__(self) -> Iterator[str]:
        """Go through their names: `for run in tests: tests.record(run)`."""
        return iter(self.runs)

    @one_thread()
    def save_metrics(self, folder: PathOrName) -> Path:
        """Write the loops' dW and W as a campaign without records, a new folder, as `pipeclamp metrics -o` does.

        Laws can be identified from it: `identify(tests.save_metrics("metrics"))`. Runs whose loops make energy are left
        out, and its notes name them.

        Raises:
            UserError: no run is left, the folder exists, or its parent can't be written.
        """
        from pipeclamp_identification.metrics_only.writing import write_metrics

        target = Path(path_of(folder, "a folder"))
        write_metrics(target, self.tests.metrics())
        return target

    @one_thread()
    def view(self) -> View:
        """Give the loops' metrics, as `pipeclamp metrics` tells them."""
        from pipeclamp.show.views import metrics_view

        return metrics_view(self.tests)

    def page(self) -> Report:
        """Give the page of the loops' metrics, as `pipeclamp metrics --report` writes it."""
        from pipeclamp.pages.page import Report
        from pipeclamp.pages.sections import metrics_page
        from pipeclamp_identification.workflow.next_command import after_import

        sections = metrics_page(self.tests, after_import(self.origin))
        return Report(f"Loop metrics of {self.name}", self.tests.notes, sections)

    def to_frame(self) -> pl.DataFrame:
        """Give a row a run: conditions (mm, Hz, °C), dW and W (J), loss factor, stiffness (N/mm), scatter."""
        return frame_of(self.to_dict()["runs"])

    @one_thread()
    def record(self, run: str) -> pl.DataFrame:
        """Give the samples of a run's record: time_s, displacement_mm, force_N, temperature_C where it was measured.

        All of them, the ramp-in too, in these units; where the fault of a sensor could be repaired, repaired.

        Args:
            run: its name in runs.csv, as in `to_frame`.

        Raises:
            UserError: there is no such run, or the tests are metrics alone.

        >>> read_campaign("clamp_a").record("A1_f3_T20").columns
        ['time_s', 'displacement_mm', 'force_N']
        """
        from pipeclamp_models.base.tables import pl

        return pl.DataFrame(dict(self.tests.record(run)))

    def __repr__(self) -> str:
        """Give name and number of runs."""
        return f"<tests {self.name}: {self._count()}, {len(self.left_out)} left out>"

    def __str__(self) -> str:
        """Say how many runs there are, over which conditions, which are left out, and what to know of them."""
        runs = self._loops
        temperatures = [run.setup.temperature_C for run in runs]
        spans = [
            _span("A", "mm", [run.amplitude_mm for run in runs]),
            _span("f", "Hz", [run.frequency_Hz for run in runs]),
            _span("T", "°C", [round(T, 1) for T in temperatures if T is not None]),
        ]
        known = len(runs) - temperatures.count(None)
        spans[2] += f" ({known} of {len(runs)} runs)" if 0 < known < len(runs) else ""
        specimens = len({run.setup.specimen for run in runs})
        several = [f"{specimens} specimens"] if specimens > 1 else []
        words = f"{self.name}: {', '.join([self._count(), *several, *filter(None, spans)])}"
        return "\n".join([words, *self.left_out, *self.remarks])

    def _count(self) -> str:
        """Say how many runs there are, and how many of them have no loops."""
        free = len(self.tests.free_runs)
        return f"{len(self._loops) + free} runs{f', {free} of free motion' if free else ''}"

    @cached_property
    def _loops(self) -> Sequence[MetricRun]:
        return self.tests.metrics().runs if self.tests.has_loops else ()


def _span(symbol: str, unit: str, values: Sequence[float]) -> str:
    """Say from where to where a condition goes; nothing where it isn't known."""
    if not values:
        return ""
    low, high = plain(min(values), 3), plain(max(values), 3)
    return f"{symbol} {low} {unit}" if low == high else f"{symbol} {low} to {high} {unit}"


@one_thread()
def read_campaign(campaign: PathOrName, *, strict: bool = False) -> Tests:
    """Read the loop tests of a clamp: records, or metrics where there are no records.

    Args:
        campaign: the folder with campaign.toml and runs.csv, or the name of a bundled campaign.
        strict: a run that can't be used is an error, else it is left out and listed in `left_out`.

    Returns:
        the tests; displacement in mm, force in N, temperature in °C.

    Raises:
        UserError: a file is missing or not as expected, or no run can be used.

    >>> read_campaign("clamp_a")
    <tests clamp_a: 48 runs, 0 left out>
    """
    origin = path_of(campaign, "a campaign's folder")
    return Tests(read_tests(Path(origin), strict=flag_of(strict, "strict")), origin)


def tested(tests: Tests | PathOrName) -> Tests:
    """Give tests as they are, or read them.

    Raises:
        UserError: they are several, or can't be read.
    """
    if isinstance(tests, list | tuple):
        raise UserError(f"got {len(tests)} campaigns in a list; expected one: pc.join makes one of several")
    return tests if isinstance(tests, Tests) else read_campaign(tests)
