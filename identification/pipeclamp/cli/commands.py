"""The commands as a group: their help, and what is said of a line that can't be read."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from typing import Any

import typer
from typer.core import TyperGroup

from pipeclamp.cli.terminal import line_called

WHOLE_SENTENCE = 1000
"""More characters than what any command says of itself has."""

_usage_error: Any = typer.BadParameter.__bases__[0]
"""What Typer raises where a command line can't be read; of its kinds it exports this one's child alone."""


def _say_the_line(error: Any, parameters: Sequence[Any]) -> None:
    """Where an option is missing, or the file that it takes, add the whole line to run to what is said."""
    missing = getattr(error, "param", None) if hasattr(error, "param_type") else None
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


class Commands(TyperGroup):
    """The commands, each with its whole sentence in the program's help: wrapped, not cut."""

    def invoke(self, ctx: typer.Context) -> Any:  # type: ignore[override]
        """Run the command; where an option is missing, or what it takes, say the whole line to run."""
        try:
            return super().invoke(ctx)
        except _usage_error as error:
            _say_the_line(error, self.commands[ctx.invoked_subcommand].params if ctx.invoked_subcommand else ())
            raise

    def format_commands(self, ctx: typer.Context, formatter: Any) -> None:  # type: ignore[override]
        """List the commands."""
        shown = ((name, self.commands[name]) for name in self.list_commands(ctx))
        rows = [(name, command.get_short_help_str(WHOLE_SENTENCE)) for name, command in shown if not command.hidden]
        with formatter.section("Commands"):
            formatter.write_dl(rows)
