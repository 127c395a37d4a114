"""What the API's results have in common: how they are told, and written."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from html import escape
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from pipeclamp.show.table import Table, cell
from pipeclamp.show.view import View
from pipeclamp_models.base.errors import UserError

if TYPE_CHECKING:
    from pipeclamp.pages.page import Report
    from pipeclamp_identification.diagnosis.further_test.limits import Limits
    from pipeclamp_models.base.tables import pl

LEFT = "text-align: left"

Named = TypeVar("Named")
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


def file_of(given: object) -> Path:
    """Give the file or folder that a result is to be written to.

    Raises:
        UserError: it is neither text nor a path.
    """
    return Path(path_of(given, "a file or folder to write"))


def declarations_of(given: object) -> list[Path]:
    """Give the declarations of effects that a user named, one or several.

    Raises:
        UserError: one is neither text nor a path.
    """
    each = given if isinstance(given, Iterable) and not isinstance(given, str | PathLike) else (given,)
    return [Path(path_of(one, "a declaration")) for one in each]


def flag_of(given: object, what: str) -> bool:
    """Give what a user switched on or off; what is named in the error.

    Raises:
        UserError: it is neither True nor False: what else holds, such as the text "no", is no answer.
    """
    if isinstance(given, bool | np.bool_):
        return bool(given)
    raise UserError(f"{what}: got {given!r}; expected True or False")


def text_of(given: object, what: str, example: str) -> str:
    """Give what a user stated as text.

    Raises:
        UserError: it is none; what it is of is named in the error, with an example of what was expected.
    """
    if isinstance(given, str):
        return given
    raise UserError(f"{what}: got {given!r}; expected text such as {example!r}")


def limits_of(given: object) -> Limits | None:
    """Give what a user stated that the rig can do; None for nothing.

    Raises:
        UserError: it is no text, or none of limits.
    """
    from pipeclamp_identification.diagnosis.further_test.limits import parse_limits

    return parse_limits(text_of(given, "limits", "A=0.1..2,f=0.5..20,T=20..300")) if given else None


def number_of(given: object, what: str, unit: str = "") -> float:
    """Give a number that a user stated; what it is of, and in which unit, is named in the error.

    Raises:
        UserError: it is no finite number.
    """
    known = isinstance(given, int | float | np.integer | np.floating) and not isinstance(given, bool)
    if known and math.isfinite(number := float(given)):  # type: ignore[arg-type]
        return number
    raise UserError(f"{what}: got {given!r}; expected a finite number{f' of {unit}' if unit else ''}")


def count_of(given: object, what: str) -> int:
    """Give a whole number of 0 or more that a user stated.

    Raises:
        UserError: it is none.
    """
    if isinstance(given, int | float | np.integer | np.floating) and not isinstance(given, bool):
        number = float(given)
        if number >= 0 and number.is_integer():
            return int(number)
    raise UserError(f"{what}: got {given!r}; expected a whole number")


def number_or_none(given: object, what: str, unit: str = "") -> float | None:
    """Give a number that a user may have left out, as `number_of` does."""
    return None if given is None else number_of(given, what, unit)


def numbers_by_name(given: object, what: str, example: str) -> dict[str, float]:
    """Give numbers that a user stated by name; None for none.

    Raises:
        UserError: they aren't a dict of finite numbers; the example is named as what was expected.
    """
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise UserError(f"{what}: got {given!r}; expected numbers by name, such as {example}")
    return {str(name): number_of(value, f"{what}[{name!r}]") for name, value in given.items()}


def several(given: PathOrName | Sequence[Named]) -> Sequence[PathOrName | Named]:
    """Give what a user named as several: a name by itself is one, not its letters; what is neither is refused where
    it's read."""
    return (given,) if isinstance(given, str | PathLike) or not isinstance(given, Sequence) else given


def processes(jobs: object) -> int:
    """Give the number of processes that a user asked for; -1 for as many as there are cores.

    Raises:
        UserError: it is none.
    """
    if isinstance(jobs, int) and not isinstance(jobs, bool) and (jobs == -1 or jobs > 0):
        return jobs
    raise UserError(f"jobs: got {jobs!r}; expected -1, or a whole number above 0")


def plain_call(name: str, first: str, **arguments: object) -> str:
    """Give a call as text, for what it makes: files by the last part of their path, arguments that say something."""
    said = [f"{key}={value!r}" for key, value in arguments.items() if value]
    return f"pc.{name}({', '.join([repr(Path(first).name), *said])})"


@contextmanager
def called_from_python(**names: str) -> Iterator[None]:
    """Tell a user's mistake in the words of a call, as a decorator: `limits` in the place of `--limits`.

    Args:
        names: what an option is called here, where it isn't called alike.
    """
    try:
        yield
    except UserError as error:
        error.args = (_in_python(str(error), names),)
        raise


def _in_python(text: str, names: Mapping[str, str]) -> str:
    """Give a message with arguments in the place of options; of a command's line nothing is changed."""

    def argument(found: re.Match[str]) -> str:
        option, entry, value = found.group(1).replace("-", "_"), found.group(2), found.group(3)
        name = names.get(option, option)
        return f"{name}={{'{entry}': ...}}" if entry else f"{name}={value}" if value else name

    if "pipeclamp " in text:
        return text
    for key, name in names.items():
        text = re.sub(rf"\b{key}\.(?=')", f"{name} ", text)  # a key of a file
    return re.sub(r"(?<![\w-])--([a-z][a-z-]*)(?: (\w+)=\.\.\.| (\d+)\b)?", argument, text)


class Told:
    """A result that is told in tables and sentences."""

    def _told(self) -> tuple[Sequence[Table], Sequence[str]]:
        """Give its tables, and its lines."""
        raise NotImplementedError

    def __str__(self) -> str:
        """Give what a terminal shows below the command's tables."""
        return "\n".join(self._told()[1])

    def _repr_html_(self) -> str:
        """Give what a notebook shows."""
        tables, lines = self._told()
        return "".join(f"<p>{escape(line)}</p>" for line in lines if line) + "".join(map(html_table, tables))


class Reported(Told):
    """A result that has a page, too."""

    def page(self) -> Report:
        """Give its page."""
        raise NotImplementedError

    def report(self, path: PathOrName) -> Path:
        """Write the page with pictures, whole or not at all, and give its path; it opens without a network.

        Raises:
            UserError: it can't be written there.
        """
        from pipeclamp.pages.page import write_report

        target = file_of(path)
        write_report(target, *self.page())
        return target


class Shown(Reported):
    """A result whose command has an answer for programs."""

    def view(self) -> View:
        """Give its answer, tables and lines."""
        raise NotImplementedError

    def _told(self) -> tuple[Sequence[Table], Sequence[str]]:
        view = self.view()
        return view.tables, view.lines

    def to_dict(self) -> dict[str, Any]:
        """Give what --json writes: dicts, lists, text, numbers and None; `pipeclamp schema` gives its schema."""
        return self.view().answer.to_dict()


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
