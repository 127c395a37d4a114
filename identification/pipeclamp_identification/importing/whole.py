"""An import from its files to the campaign in its place, whole or not at all: of records, or of results."""

from __future__ import annotations

from pathlib import Path

from pipeclamp_identification.importing.answer import ImportedCampaign
from pipeclamp_identification.importing.records.whole import import_records
from pipeclamp_identification.importing.request import ImportRequest
from pipeclamp_identification.importing.results.whole import import_results
from pipeclamp_identification.importing.unusable import ResultsFileError
from pipeclamp_identification.importing.writing import existing_campaign
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import set_aside
from pipeclamp_models.base.shell import quoted


def import_campaign(request: ImportRequest) -> ImportedCampaign:
    """Import files into a campaign; files that it holds already change nothing.

    Raises:
        UserError: a file, or what the campaign would be, can't serve; or it wasn't confirmed.
    """
    folder = request.folder
    if not request.dry_run:
        _refuse_to_leave(folder)
    if _holds_results(folder if folder.exists() else set_aside(folder)):
        return import_results(request)
    try:
        return import_records(request)
    except ResultsFileError:
        return import_results(request)


def _refuse_to_leave(folder: Path) -> None:
    """Refuse a campaign's folder in which the command was called: another takes its place, in which nobody is.

    Raises:
        UserError: it is.
    """
    called_in = Path.cwd()
    if folder.exists() and folder.resolve() in (called_in, *called_in.parents):
        whole = folder.resolve()
        raise UserError(
            f"{folder}: is replaced as a whole, and the command was called in it; expected it from outside: "
            f"cd {quoted(str(whole.parent))}, then -o {quoted(whole.name)}"
        )


def _holds_results(folder: Path) -> bool:
    """Tell whether a campaign that was imported lies there, of tests without records."""
    existing = existing_campaign(folder) if folder.is_dir() else None
    return existing is not None and not existing.holds_records
