"""What the API's results have in common: how they are told, and written."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeclamp.show.table import Table, cell
from pipeclamp.show.view import View
from pipeclamp_models.base.errors import UserError

if TYPE_CHECKING:
    from pipeclamp.pages.page import Report
    from pipeclamp_models.base.tables import pl

LEFT = "text-align: left"

PathOrName = str | PathLike[str]
"""Path of a file or folder, or the name of something that comes with the program."""


def path_of(given: object, what: str) -> str:
    """Give what a user named as text.

    Raises:
        UserError: it is neither text nor a path.
    """
    if isinstance(given, str | PathLike):
        return str(given)
    raise UserError(f"got {given!r}; expected {what}, or its path or name")


class Shown:
    """A result that is told in sentences and tables."""

    def view(self) -> View:
        """Give its answer, tables and lines."""
        raise NotImplementedError

    def page(self) -> Report:
        """Give its page."""
        raise NotImplementedError

    def to_dict(self) -> dict[str, Any]:
        """Give what --json writes: dicts, lists, text, numbers and None; `pipeclamp schema` gives its schema."""
        return self.view().answer.to_dict()

    def report(self, path: PathOrName) -> Path:
        """Write the page with pictures, whole or not at all, and give its path; it opens without a network.

        Raises:
            UserError: it can't be written there.
        """
        from pipeclamp.pages.page import write_report

        target = Path(path)
        write_report(target, *self.page())
        return target

    def __str__(self) -> str:
        """Give what a terminal shows below the command's tables."""
        return "\n".join(self.view().lines)

    def _repr_html_(self) -> str:
        """Give what a notebook shows."""
        view = self.view()
        lines = "".join(f"<p>{escape(line)}</p>" for line in view.lines)
        return lines + "".join(map(html_table, view.tables))


def html_table(table: Table) -> str:
    """Give a table as HTML; words begin on the left, where a notebook would put them on the right."""
    words = [any(isinstance(row[column], str) for row in table.rows) for column in range(len(table.header))]
    looks = [f' style="{LEFT}"' if are else "" for are in words]
    head = "".join(f'<th scope="col"{look}>{escape(name)}</th>' for name, look in zip(table.header, looks, strict=True))
    rows = "".join(
        f"<tr>{''.join(f'<td{look}>{escape(cell(value))}</td>' for value, look in zip(row, looks, strict=True))}</tr>"
        for row in table.rows
    )
    caption = f'<caption style="{LEFT}">{escape(table.caption)}</caption>' if table.caption else ""
    return f'<table style="margin-top: 1em">{caption}<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>'


def frame_of(rows: Sequence[dict[str, Any]]) -> pl.DataFrame:
    """Give rows as a polars frame; entries that hold more than one value are left out."""
    from pipeclamp_models.base.tables import pl

    plain = [{name: value for name, value in row.items() if not isinstance(value, dict | list)} for row in rows]
    return pl.from_dicts(plain, infer_schema_length=None)
