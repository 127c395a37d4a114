"""What a report may be called."""

from __future__ import annotations

from pathlib import Path

from pipeclamp_models.base.errors import UsageError

ENDINGS = (".html", ".htm")


def refuse_report_name(path: Path) -> None:
    """Refuse a name that a page can't have.

    Raises:
        UsageError: it doesn't end in .html.
    """
    if path.suffix.lower() not in ENDINGS:
        raise UsageError(f"{path}: a report is an HTML page; expected a name that ends in .html; a browser prints PDF")
