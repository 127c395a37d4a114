"""Terms that a term may be refined to: one number of its form freed, one corner made smooth, one parameter moved.

A term of the grammar fixes some numbers, so that all may be enumerated. Once it is found, each of them can be asked
for by itself: an exponent, how smoothly it begins, whether a length, a velocity, a time, a level or its strength
follows a condition. What is refined stays what it was: a factor >= 0 stays one, and a potential stays one of y alone.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Iterator, Mapping, Sequence

from pipeclamp_identification.discovery.conditions import LEVEL, SCALED, STEEPNESS, Scale, scales_of
from pipeclamp_identification.discovery.grammar import MOST_PARAMETERS, Term, id_of, linear_symbol
from pipeclamp_identification.discovery.shapes import LENGTH, RATE, SPEED, STRENGTH, Entry
from pipeclamp_models.law.declaration import Declaration, ParameterTable

EXPONENT, SMOOTH, MOVED = ("e_x", "j_x"), ("d_x", "f_x"), ("n_x", "i_x", "o_x")
"""Symbols of what a refined term has more, the first that it hasn't got."""
FIXED_EXPONENT = re.compile(r"\)\*\*(\d+(?:\.\d+)?)(?![\w.])")
"""A group's fixed exponent."""
SMALLEST_BASIS = 0.001
"""What is raised to a free exponent is never less: its slope by the exponent is finite."""
FREEST = 4.0
"""A freed exponent lies between its fixed value over this and times this."""
EXPONENTS, WIDTHS, MOVES = (1.0,), (0.1, 0.5), (0.0,)
"""From where they are fitted: shares of the fixed exponent and of the place of a corner, and powers of a condition."""
YIELDS = re.compile(r"\((z_x - .+)\) \* exp\(-(abs\(y - y_previous\) / \(.+ \* (max\(.+, [\d.]+\))\))\)$")
"""How an element that yields smoothly nears what holds it: what is left to it, the way over its own, what holds it."""
SINE, OVERTONE, OVERTONES = re.compile(r"sin\(y / (y_x|\(.+?\))\)"), "b_x", (0.3, -0.3)
"""What is periodic along the way, the symbol of its overtone's share, and from where that is fitted."""
NEARLY_ONE, BENDS = 1.001, (0.6, 1.6)
"""An exponent at which what is left falls exponentially, and from where it is fitted: one itself is a limit."""
SMOOTHEST = {LENGTH["unit"]: LENGTH, SPEED["unit"]: SPEED}
"""Bounds of the width in which a corner is made smooth, by its unit."""


def refinements(
    term: Term, values: Mapping[str, float], varied: Sequence[str], conditions: Mapping[str, float]
) -> Iterator[tuple[Term, Sequence[float]]]:
    """Give each refined form of a term, with values of its new parameter, the last one, to begin from.

    Args:
        term: the term.
        values: of its parameters, where it is fitted.
        varied: of A, f and T those that vary over the tests.
        conditions: further columns that vary, with the largest magnitude of each.
    """
    if len(term.declaration.parameters) >= MOST_PARAMETERS:
        return
    for number, (group, exponent) in enumerate(_powers(_text(term.declaration))):
        yield _freed(term, group, exponent, number), [share * exponent for share in EXPONENTS]
    for number, (corner, table) in enumerate(_corners(term.declaration)):
        yield _smooth(term, corner, table, number), [share * abs(values[table.symbol]) for share in WIDTHS]
    if any(YIELDS.search(one.update) for one in term.declaration.states):
        yield _bent(term), BENDS
    if SINE.search(term.declaration.force or "") and OVERTONE not in values:
        yield _with_overtone(term), OVERTONES
    scales = [one for name, one in SCALED.items() if name in varied]
    scales += [one for name, size in conditions.items() for one in scales_of(name, size)]
    moved = [one for one in term.declaration.parameters if one.unit != "-" or one.symbol == linear_symbol(term.family)]
    for table, scale in itertools.product(moved, scales):
        if not _follows(term, table, scale):
            yield _moved(term, table, scale), MOVES


def _follows(term: Term, table: ParameterTable, scale: Scale) -> bool:
    """Tell whether a parameter follows the very condition already.

    Of a factor over it, and of a strength that changes about a level of it, that level moving with it says nothing.
    """
    declaration, of_strength = term.declaration, table.symbol in (STRENGTH, LEVEL, STEEPNESS)
    if of_strength and scale.factor in (declaration.force or ""):
        return True
    bent = of_strength and any(one.symbol == LEVEL for one in declaration.parameters)
    text = "; ".join([declaration.force or "" if bent else "", *(one.factor for one in declaration.scales)])
    return bool(_signals(scale.factor) & _signals(text))


def _signals(expression: str) -> set[str]:
    """Give the names in an expression, but for functions and a scaling's own rate."""
    return set(re.findall(r"\b[A-Za-z]\w*", expression)) - {"abs", "exp", RATE}


def _new(symbols: Sequence[str], term: Term) -> str:
    """Give the first of symbols that a term hasn't got."""
    own = {one.symbol for one in term.declaration.parameters}
    return next(symbol for symbol in symbols if symbol not in own)


def _text(declaration: Declaration) -> str:
    """Give all expressions of a term, but for its energy, which follows from the others."""
    scales = (one.factor for one in declaration.scales)
    return "; ".join([declaration.force or "", *scales, *(one.update for one in declaration.states)])


def _powers(text: str) -> list[tuple[str, float]]:
    """Give the groups that are raised to a fixed exponent, each once."""
    found: dict[str, float] = {}
    for match in FIXED_EXPONENT.finditer(text):
        begin = _opening(text, match.start())
        function = re.search(r"[a-z]+$", text[:begin])
        found.setdefault(text[function.start() if function else begin : match.start() + 1], float(match[1]))
    return list(found.items())


def _opening(text: str, closing: int) -> int:
    depth = 0
    for place in range(closing, -1, -1):
        depth += {")": 1, "(": -1}.get(text[place], 0)
        if depth == 0:
            return place
    raise ValueError(f"no bracket opens what is closed at {closing} of {text!r}")


def _corners(declaration: Declaration) -> list[tuple[str, ParameterTable]]:
    """Give each `max(..., 0)` at a length or a velocity of the term, outermost only, and that parameter."""
    text, found = _text(declaration), {}
    place = 0
    while (place := text.find("max(", place)) >= 0:
        end = _closing(text, place + 3)
        inner = text[place + 4 : end]
        own = [one for one in declaration.parameters if re.search(rf"\b{one.symbol}\b", inner)]
        if inner.endswith(", 0") and own and own[0].unit in SMOOTHEST:
            found[inner.removesuffix(", 0")] = own[0]
            place = end
        else:
            place += 1
    return list(found.items())


def _closing(text: str, opening: int) -> int:
    depth = 0
    for place in range(opening, len(text)):
        depth += {"(": 1, ")": -1}.get(text[place], 0)
        if depth == 0:
            return place
    raise ValueError(f"no bracket closes what is opened at {opening} of {text!r}")


def _freed(term: Term, group: str, exponent: float, number: int) -> Term:
    symbol = _new(EXPONENT, term)
    if group.startswith("max(") and not group.endswith(", 0)"):
        power = f"{group}**{symbol}"
    elif group.lstrip("(").startswith(("max(", "abs(")):  # zero stays zero: one direction of a damping does nothing
        power = f"({group} * ({group} + {SMALLEST_BASIS})**({symbol} - 1))"
    else:
        power = f"(abs({group}) + {SMALLEST_BASIS})**{symbol}"
    entry: Entry = {"symbol": symbol, "unit": "-", "meaning": "exponent", "start": exponent,
                    "lower": exponent / FREEST, "upper": exponent * FREEST}  # fmt: skip
    old = re.compile(re.escape(group) + r"\*\*\d+(?:\.\d+)?(?![\w.])")
    return _refined(
        term, f"power{number or ''}", "with an exponent of its own", entry,
        lambda text: old.sub(lambda _: power, text),
    )  # fmt: skip


def _smooth(term: Term, corner: str, table: ParameterTable, number: int) -> Term:
    bounds, symbol = SMOOTHEST[table.unit], _new(SMOOTH, term)
    entry: Entry = {"symbol": symbol, "unit": table.unit, "meaning": "width in which it begins",
                    "start": bounds["lower"], "lower": f"0.1 * {bounds['lower']}",
                    "upper": bounds["upper"]}  # fmt: skip
    return _refined(
        term, f"smooth{number or ''}", "beginning smoothly", entry,
        lambda text: text.replace(f"max({corner}, 0)", f"((sqrt(({corner})**2 + {symbol}**2) + {corner}) / 2)"),
    )  # fmt: skip


def _bent(term: Term) -> Term:
    """Free Dahl's exponent (1968): of a way, what is left to yield falls in proportion to that power of itself."""
    symbol = _new(EXPONENT, term)
    entry: Entry = {"symbol": symbol, "unit": "-", "meaning": "exponent of what is left to yield", "start": NEARLY_ONE,
                    "lower": 1 / FREEST, "upper": FREEST}  # fmt: skip

    def changed(text: str) -> str:
        found = YIELDS.search(text)
        if found is None:
            return text
        left, way, most = found.groups()
        share = f"(abs({left}) / {most} + {SMALLEST_BASIS})"
        falls = f"max(1 + ({symbol} - 1) * {share}**({symbol} - 1) * {way}, 0)**(1 / (1 - {symbol}))"
        return f"{text[: found.start()]}({left}) * {falls}"

    return _refined(term, "yielding", "as a power of what is left to yield", entry, changed)


def _with_overtone(term: Term) -> Term:
    """Give what is periodic its first overtone: valleys needn't be as broad as the tops between them."""
    entry: Entry = {"symbol": OVERTONE, "unit": "-", "meaning": "overtone over the sine", "start": 0.0, "neutral": 0.0,
                    "lower": -FREEST, "upper": FREEST}  # fmt: skip
    return _refined(
        term, "overtone", "and an overtone of half the stretch", entry,
        lambda text: SINE.sub(rf"(sin(y / \1) + {OVERTONE} * sin(2 * y / \1))", text),
    )  # fmt: skip


def _moved(term: Term, table: ParameterTable, scale: Scale) -> Term:
    moved = _new(MOVED, term)
    moves = scale.factor.replace(RATE, moved)
    entry: Entry = {"symbol": moved, "unit": "-", "meaning": f"by how much the {table.meaning} follows {scale.words}",
                    "start": 0.1, "lower": -20.0, "upper": 20.0, "neutral": 0.0}  # fmt: skip
    symbol = re.compile(rf"\b{table.symbol}\b")
    return _refined(
        term, f"{table.symbol[:-2]}_by_{scale.name}", f"its {table.meaning} scaled with {scale.words}", entry,
        lambda text: symbol.sub(f"({table.symbol} * {moves})", text), scale.condition,
    )  # fmt: skip


def _refined(
    term: Term, name: str, words: str, entry: Entry, changed: Callable[[str], str], condition: str = ""
) -> Term:
    """Give a term with one parameter more.

    Args:
        term: the term as it was.
        name: of what is new, as ids have it.
        words: the same for people.
        entry: the new parameter.
        changed: gives an expression as it is then.
        condition: the further column that it needs; empty where it needs none.
    """
    old = term.declaration
    acts_like = f"{term.acts_like}, {words}"
    declaration = Declaration.model_validate({
        **old.model_dump(exclude_defaults=True),
        "id": id_of(f"{old.id.removeprefix('found_')}_{name}"), "title": acts_like, "looks_like": acts_like,
        "parameters": (*(one.model_dump() for one in old.parameters), entry),
        "force": changed(old.force) if old.force else old.force,
        "scales": tuple({**one.model_dump(), "factor": changed(one.factor)} for one in old.scales),
        "states": tuple({**one.model_dump(), "update": changed(one.update)} for one in old.states),
        "energy": changed(old.energy) if old.energy else old.energy,
        "conditions": tuple(dict.fromkeys([*old.conditions, *([condition] if condition else [])])),
    })  # fmt: skip
    return Term(term.family, declaration, acts_like, (old.id, *term.shorter))
