"""The page that travels inside an FMU: equations, parameters, range, and how to use it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from jinja2 import Environment

PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>{{ title }}</title>
<style>
body { font-family: sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; line-height: 1.4 }
table { border-collapse: collapse; margin: 1em 0 }
th, td { border: 1px solid #bbb; padding: 0.25em 0.6em; text-align: left; vertical-align: top }
pre { background: #f3f3f3; padding: 0.8em; white-space: pre-wrap }
</style>
</head>
<body>
<h1>{{ title }}</h1>
{% for paragraph in introduction %}<p>{{ paragraph }}</p>
{% endfor -%}
{% for section in sections %}<h2>{{ section.heading }}</h2>
{% for paragraph in section.paragraphs %}<p>{{ paragraph }}</p>
{% endfor -%}
{% if section.equations %}<pre>{{ section.equations | join("\\n") }}</pre>
{% endif -%}
{% if section.rows %}<table>
<tr>{% for cell in section.header %}<th>{{ cell }}</th>{% endfor %}</tr>
{% for row in section.rows %}<tr>{% for cell in row %}<td>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}</table>
{% endif -%}
{% endfor %}</body>
</html>
"""


@dataclass(frozen=True)
class Section:
    """A part of the page: text, then equations, then a table; what is empty is left out."""

    heading: str
    paragraphs: Sequence[str] = ()
    equations: Sequence[str] = ()
    header: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = ()


def page(title: str, introduction: Sequence[str], sections: Sequence[Section]) -> str:
    """Give the page as HTML, everything in it escaped."""
    template = Environment(autoescape=True, keep_trailing_newline=True).from_string(PAGE)
    return template.render(title=title, introduction=introduction, sections=sections)
