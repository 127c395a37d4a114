"""Sphinx extension: where lines break. A number and its unit stay together; names of effects and options stay whole.

Code with long words, as paths are, is marked for the style sheet, which breaks it where there is no room.
"""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.transforms.post_transforms import SphinxPostTransform

LONGEST_WHOLE = 26
"""Characters of a word that is never broken."""
BEFORE_UNIT = re.compile(r"(?<=\d) (?=(?:%|°C|Hz|mm|ms|kN|N|K|J|s)(?!\w))")
NO_BREAK = "\N{NO-BREAK SPACE}"


class LineBreaks(SphinxPostTransform):
    """Gives code with a longer word the class `long`, and other text no break between a number and its unit."""

    default_priority = 700

    def run(self, **kwargs: Any) -> None:
        """Go through the code and the text of a page."""
        for code in self.document.findall(nodes.literal):
            if any(len(word) > LONGEST_WHOLE for word in code.astext().split()):
                code["classes"].append("long")
        for text in list(self.document.findall(nodes.Text)):
            if not isinstance(text.parent, nodes.literal | nodes.FixedTextElement | nodes.raw | nodes.math):
                text.parent.replace(text, nodes.Text(BEFORE_UNIT.sub(NO_BREAK, text.astext())))


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the transform."""
    app.add_post_transform(LineBreaks)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
