"""Test machines' files made a campaign."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from pipeclamp.api.shown import PathOrName, Shown, flag_of, path_of, text_of
from pipeclamp.api.tests import Tests, read_campaign
from pipeclamp.show.view import View
from pipeclamp_identification.campaign.writing import Format
from pipeclamp_identification.importing.answer import ImportedCampaign
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.base.progress import Progress, silent

if TYPE_CHECKING:
    from pipeclamp.pages.page import Report
    from pipeclamp_models.base.tables import pl


class Import(Shown):
    """What files became: a campaign, or, after a dry run, what it would be.

    Attributes:
        found: what the other rooms of the program work on.

    >>> from pathlib import Path
    >>> from pipeclamp_identification.campaign.bundled import campaign_folder
    >>> exports = campaign_folder(Path("clamp_a_heldout")) / "runs"
    >>> import_files(exports, "clamp_7", dry_run=True)
    <import clamp_7: 18 runs, not written>
    """

    def __init__(self, found: ImportedCampaign) -> None:
        self.found = found

    @property
    def folder(self) -> Path:
        """The campaign's."""
        return self.found.folder

    @property
    def written(self) -> bool:
        """Whether anything was written: not by a dry run, nor where all files were there already."""
        return self.found.written

    @property
    def notes(self) -> tuple[str, ...]:
        """What to know of channels, units and sensors."""
        return self.found.notes()

    def tests(self) -> Tests:
        """Read the campaign.

        Raises:
            UserError: it wasn't written.
        """
        return read_campaign(self.folder)

    def view(self) -> View:
        """Give what `pipeclamp import` tells."""
        from pipeclamp.show.imported import import_view

        return import_view(self.found)

    def page(self) -> Report:
        """Give the page that stands in the campaign's folder."""
        from pipeclamp.pages.imported import import_report

        return import_report(self.found)

    def to_frame(self) -> pl.DataFrame:
        """Give a row a run: file, amplitude (mm), frequency (Hz), temperature (°C), cycles."""
        from pipeclamp.api.shown import frame_of

        return frame_of(self.to_dict()["runs"])

    def __repr__(self) -> str:
        """Give folder and number of runs."""
        return f"<import {self.folder}: {len(self.found.answer().runs)} runs{'' if self.written else ', not written'}>"


@one_thread()
def import_files(
    files: PathOrName | Sequence[PathOrName],
    campaign: PathOrName,
    *,
    columns: str | Mapping[str, str] = "",
    pattern: str = "",
    conditions: PathOrName | None = None,
    rate: float | Literal["none"] | None = None,
    name: str = "",
    notes: str = "",
    format: Format = "parquet",
    skip_unusable: bool = False,
    dry_run: bool = False,
    progress: Progress = silent,
) -> Import:
    """Make a campaign of test machines' files, or add files to one that was made so.

    Args:
        files: one or more files, or folders of them: text, Excel, ODS, MATLAB, TDMS, UFF, MDF4, HDF5, Parquet.
        campaign: the folder to write; one that was imported before gets the files that it doesn't hold yet.
        columns: which channels are ours, as `--columns` takes it ("time=Zeit [ms],force=Last [kN]"), or a dict of it.
        pattern: what the names of files state, "A{amplitude_mm}_f{frequency_Hz}_T{temperature_C}".
        conditions: a table of what was set, a row a file, its name in column `file`.
        rate: samples per second, where no channel holds the time; "none" where time was not measured.
        name, notes: of the campaign; its folder's name by default.
        format: of the records: "parquet", "csv" or "csv.gz".
        skip_unusable: leave out files that are damaged or hold no test; notes, page and campaign.toml name them.
        dry_run: write nothing.
        progress: is told what is being done.

    Returns:
        what the files became; nothing is written unless all of them can be used, or those that can't may be left out.

    Raises:
        UserError: files can't be used (all of them are named, with the reason), or names and units don't tell which
            channel is what (the message ends with what to state).

    >>> from pathlib import Path
    >>> from pipeclamp_identification.campaign.bundled import campaign_folder
    >>> exports = campaign_folder(Path("clamp_a_heldout")) / "runs"
    >>> found = import_files(exports, "clamp_7", dry_run=True)
    >>> found.to_frame()["frequency_Hz"].max() > 1
    True
    """
    from pipeclamp.pages.imported import import_page
    from pipeclamp_identification.fitting.identify import software
    from pipeclamp_identification.importing.request import ImportRequest
    from pipeclamp_identification.importing.stated import stated_options
    from pipeclamp_identification.importing.whole import import_campaign

    given = [files] if isinstance(files, str) or not isinstance(files, Sequence) else files
    paths = [Path(path_of(one, "a file")) for one in given]
    if not paths:
        raise UserError("got no file; expected test machines' files, or a folder of them")
    if isinstance(columns, Mapping):
        columns = ",".join(f"{ours}={channel}" for ours, channel in columns.items())
    stated = text_of(columns, "columns", "time=Zeit [ms],force=Last [kN]")
    table = None if conditions is None else Path(path_of(conditions, "a table of conditions"))
    given_pattern = text_of(pattern, "pattern", "A{amplitude_mm}_f{frequency_Hz}")
    leave_out = flag_of(skip_unusable, "skip_unusable")
    options = stated_options(stated, given_pattern, table, rate, leave_out=lambda unusable: leave_out)
    request = ImportRequest(
        paths, Path(path_of(campaign, "a campaign's folder")), options,
        page=import_page, dry_run=flag_of(dry_run, "dry_run"), name=text_of(name, "name", "clamp 7"),
        notes=text_of(notes, "notes", "after 10 000 cycles"), software=software(), format=format,
        tell=progress,
    )  # fmt: skip
    return Import(import_campaign(request))
