"""Sphinx extension: the reference of a file or an answer, from the pydantic model that reads or writes it.

`{schema} package.module.Model` writes a table of the model's keys, and one of each table inside it, under the heading
"Keys" or the one that is given.
"""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import Any, ClassVar

from docutils.parsers.rst import directives
from markdown import MarkdownDirective, table
from pydantic import BaseModel
from sphinx.application import Sphinx

from pipeclamp_models.base.answer import AnswerModel
from pipeclamp_models.base.toml_file import TomlTable

BOUNDS = {
    "gt": "> {}", "exclusiveMinimum": "> {}", "ge": "≥ {}", "minimum": "≥ {}", "lt": "< {}", "exclusiveMaximum": "< {}",
    "le": "≤ {}", "maximum": "≤ {}",
}  # fmt: skip
TYPES = {"number": "number", "integer": "whole number", "string": "text", "boolean": "`true` or `false`"}
ATTRIBUTES = re.compile(r"^Attributes:\n((?:[ ]{4}.*\n?|\n)*)", re.M)
ATTRIBUTE = re.compile(r"^ {4}([\w, ]+): ((?:.*\n?)(?: {5,}.*\n?)*)", re.M)


def _said(docstring: str) -> tuple[str, dict[str, str]]:
    """Split a docstring into its text and what it says of each attribute."""
    text = inspect.cleandoc(docstring or "")
    found = ATTRIBUTES.search(text)
    if not found:
        return text, {}
    entries = ATTRIBUTE.findall(found.group(1))
    attributes = {name.strip(): " ".join(words.split()) for names, words in entries for name in names.split(",")}
    return ATTRIBUTES.sub("", text).strip(), attributes


def _words(schema: dict[str, Any], anchor: str, titles: Mapping[str, str]) -> str:
    """Say what a value may be."""
    if "$ref" in schema:
        name = schema["$ref"].rsplit("/", 1)[1]
        shown = "these keys" if ", " in titles[name] else titles[name]
        return f"[{shown}](#{anchor}-{name.lower()})"
    if "const" in schema:
        return f"`{json.dumps(schema['const'])}`"
    if "enum" in schema:
        return " or ".join(f"`{json.dumps(value)}`" for value in schema["enum"])
    for kind in ("anyOf", "oneOf"):
        if kind in schema:
            choices = [_words(choice, anchor, titles) for choice in schema[kind] if choice.get("type") != "null"]
            return " or ".join(dict.fromkeys(choices))
    if schema.get("type") == "array":
        if "prefixItems" in schema:
            return "[" + ", ".join(_words(item, anchor, titles) for item in schema["prefixItems"]) + "]"
        return f"list of {_words(schema.get('items', {}), anchor, titles)}"
    if schema.get("type") == "object":
        inside = schema.get("additionalProperties")
        return f"table: a name, then {_words(inside, anchor, titles)}" if isinstance(inside, dict) else "table"
    bounds = [words.format(f"{schema[key]:g}") for key, words in BOUNDS.items() if key in schema]
    return " ".join([TYPES.get(schema.get("type", ""), "any value"), *bounds])


def _section(schema: dict[str, Any], anchor: str, titles: Mapping[str, str], is_read: bool) -> list[str]:
    """Give a model's text and the table of its keys; of what is read, what may be left out too."""
    text, said = _said(schema.get("description", ""))
    needed = schema.get("required", ())
    rows = []
    for key, value in schema.get("properties", {}).items():
        default = value.get("default")
        plain = default not in (None, "", []) and not isinstance(default, dict)
        without = "**needed**" if key in needed else f"`{json.dumps(default)}`" if plain else ""
        rows.append((f"`{key}`", _words(value, anchor, titles), without, value.get("description", said.get(key, ""))))
    shown = [0, 1, *([2] if is_read else []), *([3] if any(row[3] for row in rows) else [])]
    header = ("key", "value", "default", "meaning")
    return [text, "", *table([header[place] for place in shown], [[row[place] for place in shown] for row in rows])]


def _inside(schema: dict[str, Any], path: str) -> Iterator[tuple[str, str]]:
    """Give the models that a value may hold, each with its place."""
    if "$ref" in schema:
        yield schema["$ref"].rsplit("/", 1)[1], path
    for kind in ("anyOf", "oneOf", "prefixItems"):
        for choice in schema.get(kind, ()):
            yield from _inside(choice, path)
    if "items" in schema:
        yield from _inside(schema["items"], f"{path}[]")
    if isinstance(schema.get("additionalProperties"), dict):
        yield from _inside(schema["additionalProperties"], f"{path}.NAME")


def _places(schema: dict[str, Any]) -> dict[str, list[str]]:
    """Give each model's places in the file, in the file's order."""
    found: dict[str, list[str]] = {}
    waiting = [("", schema)]
    while waiting:
        path, model = waiting.pop(0)
        for key, value in model.get("properties", {}).items():
            for name, place in _inside(value, f"{path}.{key}".lstrip(".")):
                new = name not in found
                found.setdefault(name, []).append(place)
                if new:
                    waiting.append((place, schema["$defs"][name]))
    return found


def _title(place: str, is_toml: bool) -> str:
    """Give a place as the file writes it: `[[clamps]]` in TOML, `runs[]` in JSON."""
    if not is_toml or "." in place:
        return f"`{place}`"
    return f"`[[{place.removesuffix('[]')}]]`" if place.endswith("[]") else f"`[{place}]`"


def schema_lines(model: type[BaseModel], page: str, heading: str) -> list[str]:
    """Give the Markdown of a model and of all that it holds."""
    schema = model.model_json_schema()
    anchor = f"{page}-{model.__name__}".lower().replace("/", "-")
    places = _places(schema)
    titles = {
        name: ", ".join(dict.fromkeys(_title(place, issubclass(model, TomlTable)) for place in found))
        for name, found in places.items()
    }
    is_read = not issubclass(model, AnswerModel)
    lines = [f"## {heading}", "", *_section(schema, anchor, titles, is_read)]
    for name, title in titles.items():
        part = schema["$defs"][name]
        lines += [f"({anchor}-{name.lower()})=", f"### {title}", ""]
        has_keys = "properties" in part
        lines += _section(part, anchor, titles, is_read) if has_keys else [_words(part, anchor, titles), ""]
    return lines


class Schema(MarkdownDirective):
    """A pydantic model's keys."""

    required_arguments = 1
    option_spec: ClassVar = {"heading": directives.unchanged}

    def lines(self) -> list[str]:
        """Give the tables of the model that is named."""
        module, _, name = self.arguments[0].rpartition(".")
        return schema_lines(getattr(import_module(module), name), self.env.docname, self.options.get("heading", "Keys"))


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("schema", Schema)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
