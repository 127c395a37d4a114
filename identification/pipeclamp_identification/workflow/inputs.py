"""The files that a folder of tests or of measurements is read from."""

from __future__ import annotations

from pathlib import Path

from pipeclamp_identification.campaign import description as campaign_file
from pipeclamp_identification.campaign import runs_table
from pipeclamp_models.base.errors import UserError


def files_of(folder: Path) -> list[Path]:
    """Give the files that a folder is read from; none where it can't be read: whoever reads it says why."""
    try:
        names = _tested(folder) if (folder / campaign_file.FILE_NAME).is_file() else _measured(folder)
    except UserError:
        return []
    return [folder / name for name in names]


def _tested(folder: Path) -> list[str]:
    rows = runs_table.read_runs_table(folder, campaign_file.read_description(folder)).rows
    return [campaign_file.FILE_NAME, runs_table.FILE_NAME, *(row.file for row in rows if row.file)]


def _measured(folder: Path) -> list[str]:
    # Pipes are loaded for what was measured on them alone.
    from pipeclamp_identification.on_pipe.measurement import FILE_NAME, read_description

    _, described = read_description(folder)
    tables = [
        *(entry.file for entry in described.responses),
        *(entry.file for entry in described.sines),
        *(entry.file for entry in described.records),
    ]
    return [FILE_NAME, *tables]
