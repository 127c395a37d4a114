"""The commands as a group: their help, and what is said of a line that can't be read."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import typer
from typer.core import TyperGroup

from pipeclamp.cli.terminal import line_called
from pipeclamp_models.base.shell import shell_line

WHOLE_SENTENCE = 1000
"""More characters than what any command says of itself has."""

_usage_error: Any = typer.BadParameter.__bases__[0]
"""What Typer raises where a command line can't be read; of its kinds it exports this one's child alone."""


def _say_what_was_got(error: Any) -> None:
    """Where an option takes a number, say what stood there: a comma for a decimal point, most often."""
    refused = error.__cause__
    if not hasattr(refused, "errors"):
        return
    first = refused.errors(include_url=False)[0]
    expected = {"float_parsing": "a number, with a point", "int_parsing": "a whole number"}.get(first["type"])
    if expected is None:
        error.message = error.message.removeprefix("Value error, ")
        return
    got = str(first["input"])
    pointed = got.replace(",", ".")
    error.message = f"got {got!r}; expected {expected}{f': {pointed}' if _is_decimal(pointed) and ',' in got else ''}"


def _is_decimal(text: str) -> bool:
    return re.fullmatch(r"[+-]?\d+\.\d+", text) is not None


def _last_missing(error: Any) -> None:
    """Where one word was given for several arguments, of which the first takes many, name the one that is missing.

    The word counts as the last argument, and the first would be called missing.
    """
    first = error.param
    if first.nargs != -1 or error.ctx is None:
        return
    given, _, _ = error.ctx.command.make_parser(error.ctx).parse_args(sys.argv[2:])
    behind = [each for each in error.ctx.command.params if each.param_type_name == "argument" and each is not first]
    if any(given.get(each.name) for each in behind):
        error.param = behind[-1]


def _say_the_line(error: Any, parameters: Sequence[Any]) -> None:
    """Where an option is missing, or the file that it takes, add the whole line to run to what is said."""
    missing = getattr(error, "param", None) if hasattr(error, "param_type") else None
    if missing is not None and missing.param_type_name == "argument":
        _last_missing(error)
    if missing is not None and missing.param_type_name == "option":
        error.message = f"Run: {line_called()} {missing.opts[0]} {missing.metavar}"
    option = getattr(error, "option_name", "")
    known = next((each for each in parameters if option in each.opts), None)
    if known is not None and sys.argv[-1] == option:
        error.message = f"{error.message} Run: {line_called()} {known.metavar}"
    if option == "-o" and known is None:
        single = (each for each in parameters if each.param_type_name == "option" and not each.multiple)
        files = [f"{each.opts[0]} {each.metavar}" for each in single if re.fullmatch(r"\w+\.\w+", each.metavar or "")]
        error.message = f"{error.message}; files are written by {', '.join(files)}" if files else error.message


def _say_join(error: Any) -> None:
    """Where several campaigns were given to a command that takes one, say which command makes one of them."""
    if error.ctx is None or not error.message.startswith("Got unexpected extra argument"):
        return
    given, over, _ = error.ctx.command.make_parser(error.ctx).parse_args(sys.argv[2:])
    campaigns = [given.get("campaign"), *over]
    if all(map(_is_campaign, campaigns)):
        line = shell_line("join", *campaigns, "-o", "all_tests")
        error.message = f"{error.message}; of several campaigns one is made by: {line}"


def _is_campaign(word: object) -> bool:
    """Tell whether a word names a campaign."""
    # For a mistake alone: it loads what reads campaigns.
    from pipeclamp_identification.campaign.bundled import bundled_campaigns

    return isinstance(word, str) and ((Path(word) / "runs.csv").is_file() or word in bundled_campaigns())


class Commands(TyperGroup):
    """The commands, each with its whole sentence in the program's help: wrapped, not cut."""

    def invoke(self, ctx: typer.Context) -> Any:  # type: ignore[override]
        """Run the command; where an option is missing, or what it takes, say the whole line to run."""
        try:
            return super().invoke(ctx)
        except _usage_error as error:
            _say_what_was_got(error)
            _say_join(error)
            _say_the_line(error, self.commands[ctx.invoked_subcommand].params if ctx.invoked_subcommand else ())
            raise

    def format_commands(self, ctx: typer.Context, formatter: Any) -> None:  # type: ignore[override]
        """List the commands."""
        shown = ((name, self.commands[name]) for name in self.list_commands(ctx))
        rows = [(name, command.get_short_help_str(WHOLE_SENTENCE)) for name, command in shown if not command.hidden]
        with formatter.section("Commands"):
            formatter.write_dl(rows)
