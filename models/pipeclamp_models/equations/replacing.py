"""Parts of expressions in the place of others, without asking anew which of an extreme's arguments could be left out.

SymPy asks that of each pair of arguments whenever it makes an extreme, by factorising their difference, which takes
longer than all else. Where an expression is only renamed, or split, the answer is the one it got when it was written.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy as sp


def rebuilt(part: sp.Basic, arguments: Sequence[sp.Basic]) -> sp.Basic:
    """Give a part of an expression with other arguments; extremes of anything but numbers keep them all."""
    if isinstance(part, sp.Max | sp.Min) and any(argument.free_symbols for argument in arguments):
        return part.func(*arguments, evaluate=False)
    return part.func(*arguments)


def replaced(expression: sp.Expr, by: Mapping[sp.Basic, sp.Basic]) -> sp.Expr:
    """Give an expression with some of its parts replaced, the largest first, as `xreplace` does."""
    known: dict[sp.Basic, sp.Basic] = {}

    def of(part: sp.Basic) -> sp.Basic:
        if part in by:
            return by[part]
        if not part.args:
            return part
        if part not in known:
            arguments = [of(argument) for argument in part.args]
            same = all(new is old for new, old in zip(arguments, part.args, strict=True))
            known[part] = part if same else rebuilt(part, arguments)
        return known[part]

    return of(expression)
