"""Formulas as MathML, which browsers draw by themselves: a page needs no script, no font and no network for them."""

from __future__ import annotations

import html
from typing import Literal

from latex2mathml.converter import convert


def mathml(formula: str, display: Literal["inline", "block"]) -> str:
    """Give a formula's MathML with its LaTeX beside it, for what can't read MathML.

    Args:
        formula: LaTeX.
        display: whether it stands in a line or by itself.
    """
    element: str = convert(formula, display=display)
    return element.replace("<math ", f'<math alttext="{html.escape(formula, quote=True)}" ', 1)
