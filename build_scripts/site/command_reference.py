"""Sphinx extension: the reference of all commands, from the command line itself.

`{commands}` writes a section for each command: what it does, its arguments and options, its example.
"""

from __future__ import annotations

import inspect
import re
from enum import Enum
from pathlib import Path
from typing import Any, get_args, get_type_hints

import typer
from markdown import MarkdownDirective, table
from sphinx.application import Sphinx

from pipeclamp.cli.app import app as command_line

EXAMPLE = re.compile(r"^Example:\s*(.*)$", re.S)


VALUES = {str: "TEXT", int: "N", float: "NUMBER", Path: "PATH"}


def _annotations(command: Any) -> dict[str, Any]:
    """Give the type of each parameter, as its function states it."""
    return get_type_hints(inspect.unwrap(command.callback))


def _value(option: Any, annotation: Any) -> str:
    """What stands behind an option's name."""
    if option.is_flag:
        return ""
    kinds = [kind for kind in (annotation, *get_args(annotation)) if isinstance(kind, type)]
    choices = [str(choice.value) for kind in kinds if issubclass(kind, Enum) for choice in kind]
    if choices:
        return "|".join(choices)
    return option.metavar or next((VALUES[kind] for kind in kinds if kind in VALUES), "VALUE")


def _default(option: Any) -> str:
    default = option.default
    if callable(default) or default in (None, "", False, ()) or option.required:
        return ""
    return f"`{default.value if isinstance(default, Enum) else default}`"


def _option_row(option: Any, annotation: Any) -> tuple[str, str, str]:
    names = ", ".join(f"`{name}`" for name in (*option.opts, *option.secondary_opts))
    value = _value(option, annotation)
    help_text = (option.help or "").rstrip()
    needed = "**needed**" if option.required else _default(option)
    return f"{names} `{value}`" if value else names, needed, help_text


def _usage(name: str, command: Any) -> str:
    annotations = _annotations(command)
    words = [f"pipeclamp {name}"]
    for parameter in command.params:
        if parameter.param_type_name == "argument":
            label = (parameter.metavar or parameter.name.upper()).strip("[]")
            words.append(label if parameter.required else f"[{label}]")
        elif parameter.required:
            words.append(f"{parameter.opts[0]} {_value(parameter, annotations[parameter.name])}")
    return " ".join([*words, "[OPTIONS]"])


def command_lines(name: str, command: Any) -> list[str]:
    """Give one command's section."""
    lines = [f"(command-{name})=", f"### {name}", "", inspect.cleandoc(command.help or ""), ""]
    lines += ["```text", _usage(name, command), "```", ""]
    arguments = [each for each in command.params if each.param_type_name == "argument"]
    options = [each for each in command.params if each.param_type_name == "option" and not each.hidden]
    rows = [
        (f"`{(each.metavar or each.name.upper()).strip('[]')}`", _default(each), (each.help or "").rstrip())
        for each in arguments
    ]
    annotations = _annotations(command)
    rows += [_option_row(each, annotations[each.name]) for each in options if each.name in annotations]
    if rows:
        lines += table(("argument or option", "default", "what it is"), rows)
    found = EXAMPLE.match((command.epilog or "").strip())
    if found:
        lines += ["```", found.group(1), "```", ""]
    return lines


class Commands(MarkdownDirective):
    """All commands, in the order in which `pipeclamp --help` lists them."""

    def lines(self) -> list[str]:
        """Give a section for each."""
        group: Any = typer.main.get_command(command_line)
        return [line for name, command in group.commands.items() for line in command_lines(name, command)]


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("commands", Commands)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
