"""The files that an input is read from: a folder of tests or of measurements, a description that names others."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from pipeclamp_identification.campaign import description as campaign_file
from pipeclamp_identification.campaign import runs_table
from pipeclamp_models.base.errors import UserError


def files_of(given: Path) -> list[Path]:
    """Give the files that an input is read from, itself among them where it is one.

    Of what can't be read none are given beside it: whoever reads it says why.
    """
    if given.is_dir():
        return _in_folder(given)
    return [given, *(_described(given) if given.suffix == ".toml" else [])]


def _in_folder(folder: Path) -> list[Path]:
    try:
        names = _tested(folder) if (folder / campaign_file.FILE_NAME).is_file() else _measured(folder)
    except UserError:
        return []
    return [folder / name for name in names]


def _described(path: Path) -> list[Path]:
    """Give the files that the description of a study or of a coupled system names."""
    # Systems are loaded for their descriptions alone.
    from pipeclamp_system.description.system import files_of_system
    from pipeclamp_system.study.description import files_of_study

    for named_in in (files_of_study, files_of_system):
        with suppress(UserError):
            return named_in(path)
    return []


def _tested(folder: Path) -> list[str]:
    rows = runs_table.read_runs_table(folder, campaign_file.read_description(folder)).rows
    return [campaign_file.FILE_NAME, runs_table.FILE_NAME, *(row.file for row in rows if row.file)]


def _measured(folder: Path) -> list[str]:
    # Pipes are loaded for what was measured on them alone.
    from pipeclamp_identification.on_pipe.measurement import FILE_NAME, read_measurement_description

    _, described = read_measurement_description(folder)
    tables = [
        *(entry.file for entry in described.responses),
        *(entry.file for entry in described.sines),
        *(entry.file for entry in described.records),
    ]
    return [FILE_NAME, *tables]
