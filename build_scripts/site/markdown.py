"""A Sphinx directive that writes Markdown, and what such Markdown needs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.util.docutils import SphinxDirective


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Give the lines of a table."""
    lines = (header, ["---"] * len(header), *rows)
    return ["| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines] + [""]


class MarkdownDirective(SphinxDirective):
    """A directive whose `lines` are read as Markdown in its place, headings included."""

    def lines(self) -> list[str]:
        """Give the Markdown."""
        raise NotImplementedError

    def run(self) -> list[nodes.Node]:
        """Read it."""
        source = f"{self.env.doc2path(self.env.docname)}:{self.name}"
        place = nodes.section()
        place.document = self.state.document
        self.state.nested_parse(StringList(self.lines(), source), self.content_offset, place, match_titles=True)
        return place.children
