"""The catalogue of effects as people and programs read it: in short, and one effect whole."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable
from typing import TYPE_CHECKING

from pipeclamp.show.table import Table
from pipeclamp_models.base.digits import plain
from pipeclamp_models.base.units import unit_shown
from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.law.outline import Sizes
from pipeclamp_models.realise.catalogue_answer import reference_sizes
from pipeclamp_models.realise.reading.text import effect_statements, symbols_of
from pipeclamp_models.realise.sizes import number_of

if TYPE_CHECKING:
    from pipeclamp_identification.campaign.rig.truth import Truth

PART_WORDS = {
    "base": "term of base laws",
    "clamp": "of the clamp: travels into the FMU",
    "rig": "of the rig: corrects the measurement, stays out of the FMU",
}
TEXT_WIDTH = 78


def overview(effects: Iterable[Effect]) -> Table:
    """Give the catalogue in short."""
    rows = [(effect.name, effect.part, effect.does, ", ".join(effect.imitated_by)) for effect in effects]
    return Table(("id", "part", "what it does", "imitated by"), rows)


def parameter_table(effect: Effect, sizes: Sizes) -> Table:
    """Give an effect's parameters: bounds and typical sizes for loops of these sizes."""
    rows = [
        (one.name, unit_shown(one.unit), one.meaning, _bounds(one, sizes), number_of(one.size, sizes))
        for one in effect.parameters
    ]
    return Table(("parameter", "unit", "meaning", "bounds", "typical"), rows)


def _bounds(parameter: Parameter, sizes: Sizes) -> str:
    lower, upper = (number_of(bound, sizes) for bound in (parameter.lower, parameter.upper))
    if math.isinf(lower) and math.isinf(upper):
        return "none"
    if math.isinf(upper):
        return f"at least {plain(lower, 3)}"
    return f"at most {plain(upper, 3)}" if math.isinf(lower) else f"{plain(lower, 3)} to {plain(upper, 3)}"


def symbol_table(effect: Effect) -> Table:
    """Give what an effect's equations use besides its parameters."""
    rows = [(str(state.symbol), unit_shown(state.unit), f"state: {state.meaning}") for state in effect.states]
    rows += [(str(signal.symbol), unit_shown(signal.unit), signal.meaning) for signal in symbols_of(effect)]
    return Table(("symbol", "unit", "meaning"), rows)


def equation_words(effect: Effect) -> list[str]:
    """Give an effect's equations in plain text, each wrapped under what it gives."""
    lines: list[str] = []
    for one in effect_statements(effect):
        under = textwrap.wrap(
            one.plain, TEXT_WIDTH, initial_indent="    ", subsequent_indent="    ", break_on_hyphens=False
        )
        lines += [f"  {one.words}", *under]
    return lines


def about(effect: Effect) -> list[tuple[str, str]]:
    """Give what is said of an effect in words, each with its heading."""
    alike = ", ".join(effect.imitated_by) or "nothing in the catalogue"
    return [
        ("Looks like, when it is missing", effect.looks_like),
        ("Imitated by", alike),
        ("Told apart by", effect.told_apart_by),
        ("Source", effect.source),
    ]


def about_lines(effect: Effect) -> list[str]:
    """Give what is said of an effect in words, wrapped, under headings."""
    lines: list[str] = []
    for title, words in about(effect):
        lines += ["", title, *textwrap.wrap(words, TEXT_WIDTH, initial_indent="  ", subsequent_indent="  ")]
    return lines


def headline(effect: Effect) -> str:
    """Give an effect's name, what it does and where it belongs."""
    return f"{effect.name}: {effect.does}"


def equation_lines(effect: Effect) -> list[str]:
    """Give what stands before an effect's tables: what it does, where it belongs, its equations."""
    return [headline(effect), PART_WORDS[effect.part], "", "Equation", *equation_words(effect), ""]


def tables_of(effect: Effect) -> list[Table]:
    """Give an effect's tables: its parameters, for the loops of the reference clamp, and what else it uses."""
    symbols = symbol_table(effect)
    return [parameter_table(effect, reference_sizes([effect])), *([symbols] if symbols.rows else [])]


def truth_table(truth: Truth) -> Table:
    """Give the parameters of a virtual clamp that its law's file doesn't state, with where each value is from."""
    rows = [
        (one.name, unit_shown(one.unit), truth.law.values[one.name], truth.whence[one.name], one.meaning)
        for one in truth.law.equations.parameters
        if one.name in truth.whence
    ]
    return Table(("parameter", "unit", "value", "from", "meaning"), rows)
