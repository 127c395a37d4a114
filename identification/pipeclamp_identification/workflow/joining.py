"""Several campaigns of one clamp made one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from pipeclamp_identification.campaign.bundled import campaign_folder
from pipeclamp_identification.campaign.reading import Campaign, read_campaign
from pipeclamp_identification.campaign.writing import Format, joined_runs, write_campaign
from pipeclamp_models.base.progress import Progress, silent


def join_campaigns(
    campaigns: Sequence[Path],
    folder: Path,
    *,
    strict: bool = False,
    format: Format = "csv",
    read: Callable[[Campaign], None] = lambda campaign: None,
    progress: Progress = silent,
) -> int:
    """Write the runs of several campaigns as one, whole or not at all.

    Args:
        campaigns: folders or names of bundled campaigns, one at least; runs that can't be used are left out.
        folder: the campaign to write; it must not exist.
        strict: a run that can't be used is an error.
        format: of the records.
        read: is given each campaign that was read.
        progress: is told each run.

    Returns:
        the number of runs.

    Raises:
        UserError: a campaign can't be read, they don't fit together, or the folder can't be written.
    """
    tests = []
    for one in campaigns:
        tests.append(read_campaign(campaign_folder(one), strict=strict))
        read(tests[-1])
    return write_campaign(
        folder, joined_runs(tests), name=folder.name, notes=f"Joined of {', '.join(one.name for one in tests)}",
        format=format, progress=progress, time_measured=all(one.time_measured for one in tests),
    )  # fmt: skip
