"""What the commands share: options and what they hold, what is shown while they run, how they print and write.

Rich takes longer to load than all of a command's help: it is loaded when something is printed by it.
"""

from __future__ import annotations

import math
import re
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pipeclamp_models.base.errors import UsageError, UserError
from pipeclamp_models.base.files import refuse_file, refuse_folder, write_whole
from pipeclamp_models.base.said import printable
from pipeclamp_models.base.shell import shell_line
from pipeclamp_system.description.trust_mark import is_doubt

if TYPE_CHECKING:
    from rich.console import Console
    from rich.text import Text

    from pipeclamp.show.table import Table
    from pipeclamp.show.view import View
    from pipeclamp_identification.workflow.tests import Tests
    from pipeclamp_models.base.progress import Progress as Tell
    from pipeclamp_models.law.file import LawFile

WIDE = 150
SILENCE_S = 60.0
"""After so long without a word, a log is told what is being done."""
COMMAND = ": pipeclamp "
"""What a line holds that ends with a command."""
MARKED = "bold red"
"""Style of what isn't to be trusted."""


@cache
def console() -> Console:
    """Give what prints on stdout; where that is no terminal, in wide lines."""
    return _plain(width=None if sys.stdout.isatty() else WIDE)


@cache
def errors() -> Console:
    """Give what prints on stderr."""
    return _plain(stderr=True)


def _plain(**options: Any) -> Console:
    """Give a console that takes names as they are: brackets are no markup, and what a terminal would obey is shown."""
    from rich.console import Console

    class Plain(Console):
        def render_str(self, text: str, **how: Any) -> Text:
            return super().render_str(printable(text, keep="\n"), **how)

    return Plain(markup=False, emoji=False, **options)


def file_option(metavar: str, help: str, *names: str) -> Any:
    """Give the option of a file to write, `-o` unless named; one that can't be written is refused before the work."""
    return _output_option(refuse_file, metavar, help, names)


def folder_option(metavar: str, help: str, *names: str) -> Any:
    """Give the option of a new folder, `-o` unless named; one that can't be made is refused before the work."""
    return _output_option(refuse_folder, metavar, help, names)


def _output_option(refuse: Callable[[Path], None], metavar: str, help: str, names: Sequence[str]) -> Any:
    given = names or ("-o", "--output")

    def checked(path: Path | None) -> Path | None:
        if path is not None and str(path) in ("-o", "--output"):
            # `--auto -o LAW2.json`: the option itself takes the file
            rest = line_called().split(f" {path}", 1)
            line = "".join(rest) if rest[-1].strip() else f"{rest[0]} {metavar}"
            raise typer.BadParameter(f"got {path}; expected the file itself. Run: {line}", param_hint=f"'{given[-1]}'")
        if path is not None:
            refuse(path)
        return path

    return typer.Option(*given, metavar=metavar, help=help, callback=checked)


def _refuse_report(path: Path) -> None:
    from pipeclamp.show.report_name import refuse_report_name

    refuse_report_name(path)
    refuse_file(path)


def spare(*inputs: str | Path, outputs: Sequence[Path | None]) -> None:
    """Refuse to write over what a command reads, before the work; and two of its answers into one file.

    A file that is to be succeeded, as a law by that with one more effect, is no such input.

    Raises:
        UsageError: a file of `outputs` is one of the inputs, lies in one of them as a part of the tests, is named by
            one that describes a system or a study, or is named twice.
    """
    written = [path for path in outputs if path]
    resolved = [path.resolve() for path in written]
    for path in written:
        if resolved.count(path.resolve()) > 1:
            raise UsageError(f"{path}: two answers would be written there; expected a file for each")
    there = {path.resolve(): path for path in written if path.exists()}
    if not there:
        return
    from pipeclamp_identification.workflow.inputs import files_of

    for given in map(Path, inputs):
        for file in files_of(given):
            if file.resolve() in there:
                path = there[file.resolve()]
                raise UsageError(f"{path}: the command reads it, and would write over it; expected another file")


LawArgument = Annotated[str, typer.Argument(metavar="LAW", help="Law file, or the name of a bundled law.")]
CampaignFolder = Annotated[
    Path, typer.Argument(metavar="CAMPAIGN", help="Folder with campaign.toml and runs.csv, or a bundled campaign.")
]
JsonOption = Annotated[Path | None, file_option("F", "Write the answer as JSON.", "--json")]
ReportOption = Annotated[
    Path | None, _output_option(_refuse_report, "F.html", "Write a report with pictures.", ("--report",))
]
StrictOption = Annotated[bool, typer.Option("--strict", metavar="", help="A run that can't be used is an error.")]
EffectsOption = Annotated[
    str, typer.Option("--effects", metavar="a,b,...", help="Effects, see `pipeclamp effects`, or F.toml.")
]
DeclaredOption = Annotated[
    list[Path] | None,
    typer.Option("--declared", metavar="F.toml", help="An effect of your own, by declaration; any number of times."),
]
BandsOption = Annotated[
    float | None,
    typer.Option(metavar="PER_CENT", help="With bands that hold so many per cent, such as 95."),
]
LimitsOption = Annotated[
    str,
    typer.Option(
        "--limits",
        metavar="A=0.1..2,f=0.5..20,T=20..300,v=..300",
        help="What the rig can do, for the whole motion of the next test: mm, Hz, °C, mm/s; F=..5000, N.",
    ),
]


def _processes(jobs: int) -> int:
    if jobs == 0 or jobs < -1:
        raise typer.BadParameter(f"got {jobs}; expected -1 or a number above 0")
    return jobs


JobsOption = Annotated[int, typer.Option(callback=_processes, help="Processes; -1: one a core.")]


def is_stated(context: typer.Context, name: str) -> bool:
    """Tell whether an option was given, rather than left at its default."""
    source = context.get_parameter_source(name)
    return source is not None and source.name != "DEFAULT"


def opened_law(name_or_path: str) -> LawFile:
    """Open a law; of one that a newer program made, say so: what it holds may mean something else there.

    Raises:
        UserError: there is no such law, or it isn't one.
    """
    from importlib.metadata import version

    from pipeclamp_identification.campaign.bundled import bundled_campaigns
    from pipeclamp_models.law.bundled import open_law
    from pipeclamp_models.law.file import is_newer

    if Path(name_or_path).is_dir() and not (Path(name_or_path) / "runs.csv").exists():
        raise UserError(f"{name_or_path}: a folder; expected a law's file")
    if name_or_path in bundled_campaigns() or Path(name_or_path).is_dir():
        raise UserError(f"{name_or_path}: a campaign; expected a law there: the law comes first, the tests after it")
    file = open_law(name_or_path)
    if is_newer(file, own := version("pipeclamp")):
        note(f"{name_or_path} was made by {file.software}, this is {own}; update, or check what it gives here")
    return file


@contextmanager
def showing_progress(title: str) -> Iterator[Tell]:
    """Show what is being done, with the time it takes; in a log, a line where a minute has passed without one."""
    if not errors().is_terminal:
        yield each_minute(title)
        return
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description}", markup=False), TimeElapsedColumn())
    with Progress(*columns, console=errors(), transient=True) as progress:
        task = progress.add_task(title)
        yield lambda what: progress.update(task, description=printable(f"{title}: {what}"))


def each_minute(title: str, clock: Callable[[], float] = time.monotonic) -> Tell:
    """Give what tells a log what is being done, in a line with the time so far, once in a minute at most."""
    begun = told = clock()

    def tell(what: str) -> None:
        nonlocal told
        if (now := clock()) - told >= SILENCE_S:
            told = now
            put(f"{now - begun:.0f} s: {printable(f'{title}: {what}')}", to=errors())

    return tell


def show(view: View, json_path: Path | None) -> None:
    """Write a command's answer where wanted, and print what it found."""
    if json_path:
        write_whole(json_path, view.answer.json_text())
    for table in view.tables:
        print_table(table)
    say(view.lines)


def put(line: str, *, to: Console | None = None, style: str | None = None) -> None:
    """Print a line; on a terminal broken between words, and what goes on below its beginning.

    A command stays in one line, as it is copied; so does a path, being one word.
    """
    from pipeclamp.show.layout import hanging

    target = to or console()
    broken = hanging(line, target.width) if target.is_terminal and COMMAND not in line else line
    target.print(broken, style=style, highlight=False, soft_wrap=True)


def warn(words: str) -> None:
    """Print on stderr what a user should look at."""
    put(f"warning: {words}", to=errors(), style="yellow")


def note(words: str) -> None:
    """Print on stderr what is good to know."""
    put(f"note: {words}", to=errors())


def print_next(following: str) -> None:
    """Print the command to run next, in one line, as it is copied."""
    put(f"Next: {following}")


def say(lines: Iterable[str]) -> None:
    """Print what came out, and on stderr what isn't to be trusted: a mark on a page stands on the terminal too."""
    for line in lines:
        doubtful = is_doubt(line)
        put(line, to=errors() if doubtful else None, style=MARKED if doubtful else None)


def print_table(table: Table, width: int | None = None) -> None:
    """Print a table, in no more than so many columns; one that is too wide by its numbers alone row by row."""
    from rich.table import Table as RichTable
    from rich.text import Text

    from pipeclamp.show.layout import layout, row_by_row
    from pipeclamp.show.table import cell

    room = min(width or console().width, console().width)
    texts = [[printable(cell(value), keep="\n") for value in row] for row in table.rows]
    numeric = [any(isinstance(row[index], float) for row in table.rows) for index in range(len(table.header))]
    laid = layout(table.header, texts, numeric, room)
    if laid is None:
        for line in row_by_row(table.header, texts, table.caption, room):
            console().print(line, highlight=False)
        return
    look: dict[str, Any] = {} if laid.ruled else {"box": None, "pad_edge": False}
    shown = RichTable(title=table.caption or None, title_justify="left", title_style="italic", **look)
    for head, number, size in zip(laid.header, numeric, laid.widths, strict=True):
        shown.add_column(head, justify="right" if number else "left", no_wrap=True, width=size)
    for row in laid.rows:
        shown.add_row(*map(Text, row))
    console().print(shown, highlight=False, width=room)


def names_in(text: str) -> tuple[str, ...]:
    """Give the names that commas separate."""
    return tuple(name.strip() for name in text.split(",") if name.strip())


def values_in(text: str, option: str) -> dict[str, float]:
    """Give the numbers that commas separate, by name.

    Raises:
        UsageError: not all are name=number, or a name comes twice; it says the option.
    """
    values: dict[str, float] = {}
    for entry in names_in(text):
        before, equals, number = entry.partition("=")
        name = before.strip()
        if not equals:
            point = "; a decimal has a point" if entry.isdecimal() and values else ""
            raise UsageError(f"{option}: got {entry!r} in {text!r}; expected name=value, for example k1_T=0{point}")
        if name in values:
            raise UsageError(f"{option}: {name} is given twice in {text!r}; expected each name once")
        values[name] = numbers_in(number, f"{option}: {name}")[0]
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
        return ",".join(part if re.match(r"\w\w+:", part) else Path(part).name or part for part in word.split(","))

    words = [word if word.startswith("-") else last(word) for word in sys.argv[1:]]
    return printable(shell_line(*words))


def line_called() -> str:
    """Give the command as it was called, as a shell takes it again."""
    return shell_line(*sys.argv[1:])


def read_and_tell(folder: Path, strict: bool, tell: Tell, *, free: bool = False) -> Tests:
    """Read tests and say what to know of them; runs of free motion only where they serve."""
    from pipeclamp_identification.workflow.reading import read_tests

    tell(f"read {folder}")
    tests = read_tests(folder, strict=strict)
    if not free:
        tests = tests.of_sines()
    for entry in tests.left_out:
        warn(str(entry))
    for words in tests.remarks:
        note(words)
    return tests
