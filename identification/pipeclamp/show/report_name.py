"""What a report may not be called."""

from __future__ import annotations

from pathlib import Path

from pipeclamp_models.base.errors import UsageError

OTHER_FORMATS = (".pdf", ".ps", ".png", ".svg", ".jpg", ".docx", ".odt")
"""Endings that promise something else than a page."""


def refuse_report_name(path: Path) -> None:
    """Refuse a name that promises something else than a page.

    Raises:
        UsageError: it ends as a file of another format.
    """
    if path.suffix.lower() in OTHER_FORMATS:
        raise UsageError(f"{path}: a report is an HTML page; expected a name that ends in .html; a browser prints PDF")
