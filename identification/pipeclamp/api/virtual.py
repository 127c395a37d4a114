"""Tests that are made rather than measured: a virtual rig's, and several campaigns in one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeclamp.api.law import Law, opened
from pipeclamp.api.shown import (
    PathOrName,
    Told,
    called_from_python,
    count_of,
    flag_of,
    number_of,
    numbers_by_name,
    path_of,
    plain_call,
    several,
)
from pipeclamp.api.tests import Tests, read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan
from pipeclamp_identification.campaign.rig.truth import SET
from pipeclamp_identification.campaign.writing import Format
from pipeclamp_identification.workflow.joining import join_campaigns
from pipeclamp_identification.workflow.next_command import after_import
from pipeclamp_identification.workflow.virtual_campaign import (
    VirtualCampaign,
    make_virtual_campaign,
    refuse_stated_twice,
)
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.base.said import counted
from pipeclamp_models.base.toml_file import unknown
from pipeclamp_models.base.units import unit_shown
from pipeclamp_models.law.declaration_files import read_effects

if TYPE_CHECKING:
    from pipeclamp.show.table import Table
    from pipeclamp_models.base.tables import pl


OF_RUNS = ("amplitudes", "frequencies", "temperatures", "drive", "runs")
"""What a plan says of its runs, by arguments of their own."""
SETTINGS = {one.name: one.type for one in fields(TestPlan) if one.name not in OF_RUNS}
"""How the rig moves and how well it measures: names, and types as texts."""


class Rig(Told):
    """A virtual campaign that was written, and what its clamp obeys.

    Attributes:
        made: what the other rooms of the program work on.

    `rig` makes one; its example shows what it holds.
    """

    def __init__(self, made: VirtualCampaign) -> None:
        self.made = made

    @property
    def folder(self) -> Path:
        """The campaign's."""
        return self.made.folder

    @property
    def beyond(self) -> tuple[str, ...]:
        """Which of its conditions lie beyond the data of the law that stands for the clamp."""
        return self.made.beyond

    def tests(self) -> Tests:
        """Read the campaign."""
        return read_campaign(self.folder)

    def to_frame(self) -> pl.DataFrame:
        """Give a row a parameter of the clamp: value, unit, meaning, and whether it is of the law's file, was given, or
        is a typical size."""
        from pipeclamp_models.base.tables import pl

        law, whence = self.made.truth.law, self.made.truth.whence
        words = {None: "law", SET: "given"}
        return pl.DataFrame(
            [
                {
                    "parameter": one.name, "value": law.values[one.name], "unit": one.unit,
                    "from": words.get(whence.get(one.name), "typical size"), "meaning": one.meaning,
                }
                for one in law.equations.parameters
            ]
        )  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Give folder, number of runs, the clamp's parameters, further conditions, and what lies beyond the law."""
        return {
            "folder": str(self.folder),
            "runs": self.made.count,
            "parameters": self.to_frame().to_dicts(),
            "conditions": dict(self.made.truth.conditions),
            "beyond": list(self.beyond),
        }

    def _told(self) -> tuple[Sequence[Table], Sequence[str]]:
        from pipeclamp.show.effects import truth_table

        tables = [truth_table(self.made.truth)] if self.made.truth.whence else []
        beyond = [f"Beyond the law's data: {words}" for words in self.beyond]
        return tables, [*beyond, *self._sizes(), f"{self.folder}: {counted(self.made.count, 'run')}", self._next()]

    def _sizes(self) -> list[str]:
        """Say the parameters that the law's file doesn't hold."""
        sizes = [
            f"{row['parameter']} = {row['value']:.4g} {unit_shown(row['unit'])} ({row['from']})"
            for row in self.to_frame().to_dicts()
            if row["from"] != "law"
        ]
        return [f"Beside the law's file: {', '.join(sizes)}"] if sizes else []

    def _next(self) -> str:
        return f"Next: {after_import(str(self.folder))}"

    def __repr__(self) -> str:
        """Give the folder and how many runs there are."""
        return f"<virtual campaign {self.folder.name}: {counted(self.made.count, 'run')}>"


@called_from_python(set="values")
@one_thread()
def rig(
    law: Law | PathOrName,
    campaign: PathOrName,
    *,
    effects: PathOrName | Sequence[PathOrName] = (),
    values: Mapping[str, float] | None = None,
    amplitudes: Sequence[float] | None = None,
    frequencies: Sequence[float] | None = None,
    temperatures: Sequence[float] | None = None,
    drive: PathOrName | None = None,
    plan: PathOrName | None = None,
    format: Format = "csv",
    progress: Progress = silent,
    **settings: float,
) -> Rig:
    """Make a virtual campaign of a law: would this test plan see that effect?

    Args:
        law: the law that the clamp obeys, or its file or bundled name.
        campaign: the folder to write; it must not exist.
        effects: effects to add to it, by name, one or several, or declarations of your own by path (F.toml).
        values: sizes of parameters by name, in the units that `effects` states, and further columns of runs.csv;
            parameters of effects that aren't named get typical sizes.
        amplitudes: mm; 0.2, 0.5, 0.8 and 1 unless told. Every combination with frequencies and temperatures is a run.
        frequencies: Hz; 1, 3 and 5 unless told.
        temperatures: °C; 20, 100, 200 and 300 unless told.
        drive: a drive signal that every run follows, as `diagnosis.save_drive` writes it.
        plan: a campaign that was planned, as `PlannedCampaign.save` writes it, whose runs these are, in its order.
        format: of the records: "csv", "csv.gz" or "parquet".
        progress: is told each run.
        settings: repeats of each combination (1); cycles (5) and ramp_cycles (0) of a record; rate, samples per second
            (1000); about, the displacement that the runs move about (mm; as the law's tests); force_noise (3 N) and
            displacement_noise (0.0002 mm), rms; force_step (0.1 N) and displacement_step (0.0001 mm), quantisation;
            distortion, third harmonic of the drive, share (0.005); riding, small cycles on the large one, share (0),
            and riding_order (7); amplitude_error, share (0.005), and temperature_error (1 K), rms; force_drift (N/s),
            displacement_drift (mm/s), force_gain_drift (share per second); force_range (N) and displacement_range (mm),
            where sensors end, 0 for nowhere; specimens (0) and specimen_scatter, share; seed of the random numbers (0).

    Raises:
        UserError: law, effects, values and plan don't go together, or the folder is there or can't be written.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     made = rig("emwm2", Path(folder) / "virtual", effects="viscous", amplitudes=[0.5], frequencies=[2, 4],
    ...                temperatures=[20], rate=200)
    ...     tests = made.tests()
    >>> tests
    <tests virtual: 2 runs, 0 left out>
    >>> made.to_frame().row(-1, named=True)["from"]
    'typical size'
    """
    signal, planned = (None if one is None else Path(path_of(one, "a file")) for one in (drive, plan))
    given: dict[str, Any] = {
        name: _levels(numbers, name)
        for name, numbers in (("amplitudes", amplitudes), ("frequencies", frequencies), ("temperatures", temperatures))
        if numbers is not None
    }
    given |= {name: _setting(name, value) for name, value in settings.items()}
    refuse_stated_twice({*given, *(["drive"] if signal else [])}, signal, planned)
    names, declarations = read_effects([path_of(one, "an effect") for one in several(effects)], ())
    known, folder = opened(law), Path(path_of(campaign, "a folder"))
    return Rig(
        make_virtual_campaign(
            known.file, folder, TestPlan(**given), effects=names, declared=declarations,
            notes=f"Virtual rig: {plain_call('rig', known.origin, effects=names, values=values, **given)}",
            values=numbers_by_name(values, "values", '{"c1": 2.0}'), drive=signal, plan=planned, format=format,
            progress=progress,
        )
    )  # fmt: skip


def _levels(given: object, what: str) -> tuple[float, ...]:
    """Give the amplitudes, frequencies or temperatures that a user stated, one or several.

    Raises:
        UserError: they are no finite numbers.
    """
    if isinstance(given, str | Mapping) or not isinstance(given, Iterable):
        return (number_of(given, what),)
    return tuple(number_of(one, what) for one in given)


def _setting(name: str, value: object) -> float:
    """Give a setting of the rig that a user stated.

    Raises:
        UserError: there is none of that name, or it is no finite number, or no whole one where it counts.
    """
    if name not in SETTINGS:
        raise UserError(f"rig: {unknown(name, list(SETTINGS), 'setting')}")
    return count_of(value, name) if SETTINGS[name] == "int" else number_of(value, name)


@called_from_python()
@one_thread()
def join(
    campaigns: Iterable[Tests | PathOrName],
    campaign: PathOrName,
    *,
    strict: bool = False,
    format: Format = "csv",
    progress: Progress = silent,
) -> Tests:
    """Make several campaigns of one clamp one: the tests so far and the next one.

    Args:
        campaigns: tests, or their folders or bundled names; runs that can't be used are left out.
        campaign: the folder to write; it must not exist.
        strict: a run that can't be used is an error.
        format: of the records: "csv", "csv.gz" or "parquet".
        progress: is told each run.

    Returns:
        all tests, read from the folder.

    Raises:
        UserError: a campaign can't be read, holds no records, or doesn't fit the others, one record is there twice, or
            the folder is there or can't be written.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     join(["clamp_a", "clamp_a_heldout"], Path(folder) / "all", format="parquet")
    <tests all: 66 runs, 0 left out>
    """
    if isinstance(campaigns, str | Path | Tests) or not isinstance(campaigns, Iterable):
        raise UserError(f"join: got {campaigns!r}; expected several campaigns, in a list")
    paths = [Path(one.origin if isinstance(one, Tests) else path_of(one, "a campaign's folder")) for one in campaigns]
    if not paths:
        raise UserError("join: got no campaign; expected the folders of several, in a list")
    folder = Path(path_of(campaign, "a folder"))
    join_campaigns(paths, folder, strict=flag_of(strict, "strict"), format=format, progress=progress)
    return read_campaign(folder)
