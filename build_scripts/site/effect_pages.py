"""Sphinx extension: one page per effect, written from its file when the site is built.

The pages stand in `docs/reference/effects/generated`, which is no part of the repository. `{effect-table}` writes the
overview.
"""

from __future__ import annotations

import re
from pathlib import Path

from effect_loops import draw
from markdown import MarkdownDirective, table
from sphinx.application import Sphinx
from sphinx.util import logging

from pipeclamp.show.effects import PART_WORDS, parameter_table, symbol_table
from pipeclamp.show.table import Table, cell
from pipeclamp_models.equations.effect import Effect
from pipeclamp_models.law.catalogue import listed
from pipeclamp_models.realise.catalogue_answer import reference_sizes
from pipeclamp_models.realise.effect_loops import CLAMP
from pipeclamp_models.realise.reading.text import effect_statements

FOLDER = Path("reference") / "effects" / "generated"


def _link(name: str, folder: str = "") -> str:
    return f"[{name}]({folder}{name}.md)"


def _rows(shown: Table) -> list[str]:
    """Give a table's lines; symbols as they are written in files."""
    code = [head in ("parameter", "symbol") for head in shown.header]
    return table(
        shown.header,
        [
            [f"`{cell(value)}`" if is_code else cell(value) for value, is_code in zip(row, code, strict=True)]
            for row in shown.rows
        ],
    )


def _sentence(words: str) -> str:
    """Begin with a capital letter."""
    return f"{words[0].upper()}{words[1:]}"


def _equations(effect: Effect) -> list[str]:
    """Give the equations, each with what it is, and the symbols in them."""
    names = tuple(map(str, (*(one.symbol for one in effect.coefficients), *effect.within_steps)))
    lines = ["## Equation", ""]
    for one in effect_statements(effect):
        words = one.words if one.words.startswith(names) else _sentence(one.words)
        lines += [f"{words}:", "", "$$", one.latex, "$$", ""]
    shown = symbol_table(effect)
    return lines + (_rows(shown) if shown.rows else [])


def _source(effect: Effect) -> list[str]:
    """Give the publications, a line each, with links where they have a DOI."""
    linked = re.sub(r"doi (10\.[\w.]+/\w+)", r"[doi \1](https://doi.org/\1)", effect.source)
    return ["## Source", "", *(f"- {_sentence(part)}" for part in linked.split("; ")), ""]


def page(effect: Effect, picture: str, times: int) -> str:
    """Give an effect's page, with the picture of its loops, whose difference is drawn so many times as large."""
    larger = f" The difference is drawn {times} times as large as it is." if times > 1 else ""
    part, drawn = (
        ("A", "A base law that has this term, and the same with the term's force at zero.")
        if effect.part == "base"
        else ("An effect", f"The base law of the bundled clamp `{CLAMP}`, and the effect in a typical size.")
    )
    alike = ", ".join(_link(name) for name in effect.imitated_by) or "nothing in the catalogue"
    lines = [
        f"# {effect.id}", "",
        f"{_sentence(effect.does)}. {part} {PART_WORDS[effect.part]}.", "",
        *_equations(effect),
        "## Loop with and without it", "",
        f"```{{figure}} {picture}", ":alt: Three loops of a clamp, each with and without the effect",
        ":figclass: loops", "",
        f"{drawn}{larger}", "```", "",
        "## How to know it", "",
        f"**Looks like, when it is missing:** {effect.looks_like}.", "",
        f"**Imitated by:** {alike}.", "",
        f"**Told apart by:** {effect.told_apart_by}.", "",
        "## Parameters", "",
        *_rows(parameter_table(effect, reference_sizes([effect]))),
        f"Bounds and typical sizes are those for the bundled clamp `{CLAMP}`; they follow the size of the data.", "",
    ]  # fmt: skip
    if effect.part != "base":
        lines += ["```", f"pipeclamp add law.json {effect.name} my_campaign -o law2.json", "```", ""]
    lines += _source(effect)
    return "\n".join([*lines, f"All of this page stands in `models/pipeclamp_models/effects/{effect.id}.py`.", ""])


def write_pages(app: Sphinx) -> None:
    """Write the page and picture of each effect, where they aren't as they should be."""
    folder = Path(app.srcdir) / FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    wanted = set()
    for effect in listed():
        picture, place = folder / f"{effect.id}.svg", folder / f"{effect.id}.md"
        loops = draw(effect, picture)
        text = page(effect, picture.name, loops.times)
        if not place.is_file() or place.read_text(encoding="utf-8") != text:
            place.write_text(text, encoding="utf-8")
        wanted |= {picture, place}
    for old in set(folder.iterdir()) - wanted:
        old.unlink()
    logging.getLogger(__name__).info("effects: %d pages", len(wanted) // 2)


class EffectTable(MarkdownDirective):
    """The catalogue, each effect with a link to its page."""

    def lines(self) -> list[str]:
        """Give the table and, for the site's contents, the pages."""
        rows = []
        for effect in listed():
            alike = ", ".join(_link(name, "generated/") for name in effect.imitated_by)
            rows.append((_link(effect.id, "generated/"), effect.part, effect.does, alike))
        overview = table(("effect", "part", "what it does", "imitated by"), rows)
        pages = [f"generated/{effect.id}" for effect in listed()]
        return [*overview, "```{toctree}", ":hidden:", "", *pages, "```", ""]


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive, and write the pages before any is read."""
    app.connect("builder-inited", write_pages)
    app.add_directive("effect-table", EffectTable)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
