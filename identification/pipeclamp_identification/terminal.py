"""What the commands share: options and what they hold, what is shown while they run, how they print and write."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Table as RichTable

from pipeclamp.errors import UsageError
from pipeclamp.files import refuse_file, refuse_folder, write_whole

if TYPE_CHECKING:
    from pipeclamp.parameter_file import LawFile
    from pipeclamp_identification.findings import Findings
    from pipeclamp_identification.fit import Progress as Tell
    from pipeclamp_identification.report import Section, Table

WIDE = 150
console = Console(width=None if sys.stdout.isatty() else WIDE)
errors = Console(stderr=True)


def file_option(metavar: str, help: str, *names: str) -> Any:
    """Give the option of a file to write, `-o` unless named; one that can't be written is refused before the work."""
    return _output_option(refuse_file, metavar, help, names)


def folder_option(metavar: str, help: str, *names: str) -> Any:
    """Give the option of a new folder, `-o` unless named; one that can't be made is refused before the work."""
    return _output_option(refuse_folder, metavar, help, names)


def _output_option(refuse: Callable[[Path], None], metavar: str, help: str, names: Sequence[str]) -> Any:
    def checked(path: Path | None) -> Path | None:
        if path is not None:
            refuse(path)
        return path

    return typer.Option(*(names or ("-o", "--output")), metavar=metavar, help=help, callback=checked)


LawArgument = Annotated[str, typer.Argument(metavar="LAW", help="Law file, or the name of a bundled law.")]
JsonOption = Annotated[Path | None, file_option("F", "Write the answer as JSON.", "--json")]
ReportOption = Annotated[Path | None, file_option("F.html", "Write a report with pictures.", "--report")]
StrictOption = Annotated[bool, typer.Option("--strict", metavar="", help="A run that can't be used is an error.")]
EffectsOption = Annotated[
    str, typer.Option("--effects", metavar="a,b,...", help="Effects, see `pipeclamp effects`, or F.toml.")
]
DeclaredOption = Annotated[
    list[Path] | None,
    typer.Option("--declared", metavar="F.toml", help="An effect of your own, by declaration; any number of times."),
]


def _processes(jobs: int) -> int:
    if jobs == 0 or jobs < -1:
        raise typer.BadParameter(f"got {jobs}; expected -1 or a number above 0")
    return jobs


JobsOption = Annotated[int, typer.Option(callback=_processes, help="Processes; -1: one a core.")]


def opened_law(name_or_path: str) -> LawFile:
    """Open a law; of one that a newer program made, say so: what it holds may mean something else there.

    Raises:
        UserError: there is no such law, or it isn't one.
    """
    from importlib.metadata import version

    from pipeclamp.bundled import open_law
    from pipeclamp.parameter_file import is_newer

    file = open_law(name_or_path)
    if is_newer(file, own := version("pipeclamp")):
        errors.print(
            f"note: {name_or_path} was made by {file.software}, this is {own}; update, or check what it gives here",
            markup=False, highlight=False, soft_wrap=True,
        )  # fmt: skip
    return file


@contextmanager
def told(title: str) -> Iterator[Tell]:
    """Show what is being done, with the time it takes; on a terminal only, so that logs stay clean."""
    from pipeclamp.one_thread import one_thread

    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    shown = Progress(*columns, console=errors, transient=True, disable=not errors.is_terminal)
    with one_thread(), shown as progress:
        task = progress.add_task(title)
        yield lambda what: progress.update(task, description=f"{title}: {what}")


def show(found: Findings, json_path: Path | None, report: Path | None, title: str, subtitle: str) -> None:
    """Write a command's findings where wanted, and print them."""
    write(json_path, report, found.answer, title, subtitle, found.sections)
    for table in found.tables:
        print_table(table)
    for line in found.lines:
        console.print(line, highlight=False, markup=False)


def write(
    json_path: Path | None,
    report: Path | None,
    answer: dict[str, Any] | None,
    title: str,
    subtitle: str,
    sections: Sequence[Section],
) -> None:
    """Write an answer and a report where they are wanted."""
    if json_path:
        write_whole(json_path, json.dumps(answer, indent=1, allow_nan=False) + "\n")
    if report:
        from pipeclamp_identification.report import write_report

        write_report(report, title, subtitle, sections)


def print_table(table: Table) -> None:
    """Print a table."""
    from pipeclamp_identification.report import cell

    shown = RichTable(title=table.caption or None, title_justify="left", title_style="italic")
    for index, head in enumerate(table.header):
        numeric = any(isinstance(row[index], float) for row in table.rows)
        shown.add_column(head, justify="right" if numeric else "left", overflow="fold")
    for row in table.rows:
        shown.add_row(*(cell(value) for value in row))
    console.print(shown, highlight=False)


def names_in(text: str) -> tuple[str, ...]:
    """Give the names that commas separate."""
    return tuple(name.strip() for name in text.split(",") if name.strip())


def values_in(text: str) -> dict[str, float]:
    """Give the numbers that commas separate, by name.

    Raises:
        UsageError: not all are name=number.
    """
    values = {}
    for entry in names_in(text):
        name, equals, number = entry.partition("=")
        if not equals:
            raise UsageError(f"got {entry!r}; expected name=value, for example k1_T=0")
        values[name.strip()] = numbers_in(number, name)[0]
    return values


def numbers_in(text: str, where: str) -> tuple[float, ...]:
    """Give the numbers that commas separate.

    Raises:
        UsageError: not all are finite numbers; it says `where`.
    """
    try:
        numbers = tuple(float(entry) for entry in names_in(text))
    except ValueError as error:
        raise UsageError(f"{where}: got {text!r}; expected numbers separated by commas") from error
    if not numbers or not all(math.isfinite(number) for number in numbers):
        raise UsageError(f"{where}: got {text!r}; expected finite numbers separated by commas")
    return numbers


def command_called() -> str:
    """Give the command as it was called, paths by their last part, so that it reads the same everywhere."""

    def last(word: str) -> str:
        return ",".join(part if part.startswith("condition:") else Path(part).name or part for part in word.split(","))

    words = [word if word.startswith("-") else last(word) for word in sys.argv[1:]]
    return " ".join(["pipeclamp", *words])
