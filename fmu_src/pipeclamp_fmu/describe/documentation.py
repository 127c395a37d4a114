"""The page that travels inside an FMU: equations, parameters, range, and how to use it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from jinja2 import Environment, Template

from pipeclamp_fmu.describe.model_description import Quantity
from pipeclamp_models.base.units import unit_shown

PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>{{ title }}</title>
<style>
body { font-family: sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; line-height: 1.4 }
p { overflow-wrap: anywhere }
.wide { overflow-x: auto }
table { border-collapse: collapse; margin: 1em 0 }
th, td { border: 1px solid #bbb; padding: 0.25em 0.6em; text-align: left; vertical-align: top }
pre { background: #f3f3f3; padding: 0.8em; white-space: pre-wrap }
.bars { width: 100%; max-width: 48em }
.bars td:first-child { width: 75%; padding-left: 0; padding-right: 0 }
.label { padding: 0 0.6em 0.2em; overflow-wrap: anywhere }
.track { position: relative; height: 1.3em }
.left, .fallen, .risen, .mark { position: absolute; top: 0; bottom: 0 }
.left { background: #3b6ea5 }
.fallen { background: #c4d8ec }
.risen { background: #c0504d }
.mark { border-left: 2px dashed #222 }
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
{% if section.rows %}<div class="wide"><table>
<tr>{% for cell in section.header %}<th>{{ cell }}</th>{% endfor %}</tr>
{% for row in section.rows %}<tr>{% for cell in row %}<td>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}</table></div>
{% endif -%}
{% if section.bars %}<p>{{ section.bars.caption }}</p>
<table class="bars">
<tr>{% for cell in section.bars.header %}<th>{{ cell }}</th>{% endfor %}</tr>
{% for bar in section.bars.rows %}<tr><td><div class="label">{{ bar.label }}</div><div class="track">
<div class="left" style="left: 0; width: {{ width(bar.lower) }}"></div>
{% if bar.level != bar.before -%}
<div class="{{ bar.turn }}" style="left: {{ width(bar.lower) }}; width: {{ width(bar.upper - bar.lower) }}"></div>
{% endif -%}
{% if section.bars.mark is not none %}<div class="mark" style="left: {{ width(section.bars.mark) }}"></div>
{% endif %}</div></td>{% for cell in bar.cells %}<td>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}</table>
{% endif -%}
{% endfor %}</body>
</html>
"""


@dataclass(frozen=True)
class Bar:
    """A row of a waterfall: what is left and what there was before, as shares of the whole width; further cells."""

    label: str
    level: float
    before: float
    cells: Sequence[str] = ()

    @property
    def lower(self) -> float:
        """The lower of both."""
        return min(self.level, self.before)

    @property
    def upper(self) -> float:
        """The upper of both."""
        return max(self.level, self.before)

    @property
    def turn(self) -> str:
        """The look of what lies between."""
        return "fallen" if self.level < self.before else "risen"


@dataclass(frozen=True)
class Bars:
    """A waterfall, a row each step, with a line at a share of the width; the header counts label and cells."""

    caption: str
    header: Sequence[str]
    rows: Sequence[Bar]
    mark: float | None = None


@dataclass(frozen=True)
class DocumentedSection:
    """A part of the page: text, equations, a table, a waterfall; what is empty is left out."""

    heading: str
    paragraphs: Sequence[str] = ()
    equations: Sequence[str] = ()
    header: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = ()
    bars: Bars | None = None


def variables_section(described: Mapping[str, Quantity]) -> DocumentedSection:
    """Give the table of an FMU's variables, by name."""
    rows = [(name, unit_shown(entry.unit) or "-", entry.description) for name, entry in described.items()]
    return DocumentedSection("Variables", (), (), ("name", "unit", "meaning"), rows)


def page(title: str, introduction: Sequence[str], sections: Sequence[DocumentedSection]) -> str:
    """Give the page as HTML, everything in it escaped."""
    return _template().render(
        title=title, introduction=introduction, sections=sections, width=lambda share: f"{100 * share:.2f}%"
    )


@cache
def _template() -> Template:
    """Compile the page's template."""
    return Environment(autoescape=True, keep_trailing_newline=True).from_string(PAGE)
