"""The grammar: every term that may be proposed, as a declaration, enumerated.

Four families: a spring (the force is the derivative of a potential), a damper (the force never drives the motion; but
for one that may fall with v it is that of a convex dissipation potential in v, times a factor >= 0 of y), an element
that slips (one state, whose stored energy can only be given back or lost), and a factor > 0 on a coefficient of the
law. A spring, a damper or an element may itself be scaled by a power of a condition. A force in N multiplies what has
no dimension; lengths and times are parameters or reference values.
"""

from __future__ import annotations

import itertools
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from pipeclamp_identification.discovery.conditions import (
    ABOVE_ZERO,
    FOLLOWED,
    LEVEL,
    SCALED,
    Scale,
    followed_signal,
    scales_of,
)
from pipeclamp_identification.discovery.shapes import (
    RATE,
    STRENGTH,
    Entry,
    Shape,
    TermFamily,
    dampers,
    elements,
    moved_by_temperature,
    scaling,
    springs,
)
from pipeclamp_models.equations.effect import Effect
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.declared import effect_of

MOST_PARAMETERS = 4
MOST_TERM_STARTS = 8
LONGEST_ID = 40
ROLES = {"stiffness": "stiffness", "damping": "damping", "slip": "slip force"}


def linear_symbol(family: TermFamily) -> str:
    """Give the symbol of what a term's effect is in proportion to, or nearly."""
    return RATE if family == "factor" else STRENGTH


@dataclass(frozen=True)
class Term:
    """A term of the grammar.

    Attributes:
        family: which kind it is.
        declaration: the term, its strength the first parameter.
        acts_like: what it does, in a test engineer's words.
        shorter: ids of the same term without its scaling, without what says where it acts, and without both.
        grown: ids of terms that act as it does while they are small, and otherwise where they have grown.
    """

    family: TermFamily
    declaration: Declaration
    acts_like: str
    shorter: tuple[str, ...] = ()
    grown: tuple[str, ...] = ()

    @cached_property
    def effect(self) -> Effect:
        """The declaration as an effect, whose expressions are read once for all laws that the term is put into."""
        return effect_of(self.declaration)


def terms(
    varied: Sequence[str], conditions: Mapping[str, float], about: float = 0.0, span_K: float = 200.0
) -> Iterator[Term]:
    """Give every term.

    Args:
        varied: of A, f, T and N those that vary over the tests.
        conditions: further columns that vary, with the largest magnitude of each.
        about: mm, where tests move that are far from zero: there their displacements begin to count.
        span_K: K, by which temperatures of the tests differ, where T varies.
    """
    scales = [None, *(one for name, one in SCALED.items() if name in varied)]
    scales += [scale for name, size in conditions.items() for scale in scales_of(name, size)]
    shapes: list[tuple[TermFamily, Shape]] = [
        *(("spring", shape) for shape in springs()),
        *(("damper", shape) for shape in dampers()),
        *(("element", shape) for shape in elements()),
    ]
    for (family, shape), scale in itertools.product(shapes, scales):
        if 1 + len(shape.parameters) + (scale is not None) <= MOST_PARAMETERS:
            yield _force_term(family, shape, scale, about)
    if "T" in varied:
        for family, shape in moved_by_temperature(span_K):
            yield _force_term(family, shape, None, about)
    signals = [*(name for name in FOLLOWED if name in varied), *conditions]
    for role, signal in itertools.product(ROLES, signals):
        yield from _factors(role, signal, conditions)
    if {"f", "T"} <= set(varied):
        for role in ROLES:
            yield from _factors_shifted_by_temperature(role)


def _force_term(family: TermFamily, shape: Shape, scale: Scale | None, about: float) -> Term:
    """Give a term that adds a force, alone or scaled by what follows A, f, T or a further column."""
    words = f", displacement counted from {about:g} mm" if about else ""
    words += f", scaled with {scale.words}" if scale else ""
    further = (scaling(f"by how much it follows {scale.words}", -0.5, 0.5),) if scale else ()
    strength: Entry = {"symbol": STRENGTH, "unit": "N", "meaning": "force of the term", "start": "0.05 * F_typical"}
    if not shape.signed:
        strength = {**strength, "lower": 0.0}
    scaled = f"{STRENGTH} * {scale.factor}" if scale else STRENGTH
    term = _term(
        family, _name(shape.name, scale), f"{shape.acts_like}{words}",
        parameters=(strength, *shape.parameters, *further), force=f"{scaled} * ({shape.expression})",
        states=(shape.state,) if shape.state else (), energy=shape.energy.replace(STRENGTH, scaled),
        conditions=(scale.condition,) if scale and scale.condition else (), about_mm=about,
    )  # fmt: skip
    names = {shape.name, shape.plain} - {""}
    shorter = {_name(one, each) for one in names for each in {scale, None}} - {_name(shape.name, scale)}
    return replace(term, shorter=tuple(sorted(map(id_of, shorter))))


def _name(shape: str, scale: Scale | None) -> str:
    """Give the name of a term that adds a force."""
    return f"{shape}{f'_by_{scale.name}' if scale else ''}"


def _factors(role: str, signal: str, conditions: Mapping[str, float]) -> Iterator[Term]:
    """Give factors > 0 on a coefficient of the law: power, exponential, bent, from a level on, levelling off."""
    followed = followed_signal(signal, conditions)
    plain, pure, name = followed.symbol, followed.pure, followed.name
    above = {"T": "T / T_0", "N": "1 + N"}.get(signal, f"abs({pure}) + {ABOVE_ZERO}" if followed.column else pure)
    level: Entry = {"symbol": LEVEL, "unit": followed.unit, "meaning": f"level of {signal} at which it changes",
             "start": followed.bends}  # fmt: skip
    stepped: Entry = {**level, **followed.within_tests}
    past = f"(max({plain} - l_x, 0) / {followed.step})**1"
    forms: list[tuple[str, str, str, tuple[Entry, ...]]] = [
        ("power", f"log({above})", "changes with a power of", ()),
        ("exponential", pure, "changes exponentially with", ()),
        ("bent", f"({pure})**2", "changes with the square of", ()),
        ("beyond", past, "changes exponentially beyond a level of", (level,)),
        ("levelling", f"{plain} / (abs({plain}) + abs(l_x))", "changes and levels off with", (level,)),
        ("step", f"(1 + tanh({followed.past})) / 2", "steps at a level of", (stepped, followed.steepness(0.05, 0.15))),
    ]
    if signal != "T":
        forms.append(("growing", f"log(1 + abs({plain} / l_x))", "changes beyond a level with a power of", (level,)))
    if signal in ("A", "f"):
        peak = f"2 * {plain} * l_x / ({plain}**2 + l_x**2)"
        forms.append(("peak", peak, "has a peak, or a trough, at a level of", (level,)))
    beyond, linear = (f"{role}_{form}_{plain}" for form in ("beyond", "linear"))
    for form, exponent, words, parameters in forms:
        term = _factor(
            role, f"{role}_{form}_{plain}", f"exp({RATE} * ({exponent}))", f"{words} the {name}",
            (scaling("how much the logarithm changes", 0.1), *parameters), followed.column,
        )  # fmt: skip
        yield replace(term, grown=(id_of(linear),)) if form == "beyond" else term
    growth = {**scaling(f"growth, as a share, for each {followed.step_in_words}", 0.1), "lower": 0.0}
    words = f"grows linearly beyond a level of the {name}"
    term = _factor(role, linear, f"1 + {RATE} * {past}", words, (growth, level), followed.column)
    yield replace(term, grown=(id_of(beyond),))


def _factors_shifted_by_temperature(role: str) -> Iterator[Term]:
    """Give factors > 0 on a coefficient that change about a frequency which temperature moves, as relaxations have it.

    A power of f needs none: its shift is an exponential of T.
    """
    level: Entry = {"symbol": "l_x", "unit": "Hz", "meaning": "frequency at which it changes at 20 °C",
             "start": FOLLOWED["f"].bends, "lower": "0.001 * f_lowest", "upper": "1000 * f_highest"}  # fmt: skip
    shift: Entry = {"symbol": "m_x", "unit": "-", "meaning": "growth of that frequency's logarithm for each 100 K",
             "neutral": 0.0, "start": (1.5, 4.0, -1.5), "lower": -10.0, "upper": 10.0}  # fmt: skip
    share = "(f / (l_x * exp(m_x * (T - T_0) / 100)))"
    forms = (
        ("peak", f"2 * {share} / (1 + {share}**2)", "has a peak, or a trough, at a frequency"),
        ("levelling", f"{share} / (1 + {share})", "changes from one level to another about a frequency"),
        ("growing", f"log(1 + {share})", "changes with a power of the frequency beyond one"),
    )
    for form, exponent, words in forms:
        yield _factor(
            role, f"{role}_{form}_f_shifted_by_T", f"exp({RATE} * ({exponent}))", f"{words} that temperature moves",
            (scaling("how much the logarithm changes", 0.1), level, shift), "",
        )  # fmt: skip


def _factor(role: str, name: str, factor: str, words: str, parameters: tuple[Entry, ...], condition: str) -> Term:
    """Give a factor on a coefficient of the law; the further column that it needs is empty where it needs none."""
    return _term(
        "factor", name, f"{ROLES[role]} that {words}", parameters=parameters,
        scales=({"coefficient": role, "factor": factor},), conditions=(condition,) if condition else (),
    )  # fmt: skip


def _term(
    family: TermFamily, name: str, acts_like: str, *, parameters: Sequence[Mapping[str, object]], **content: object
) -> Term:
    """Give a term; its parameters start from each combination of their starts, of many from some."""
    starts = [one["start"] if isinstance(one["start"], tuple) else (one["start"],) for one in parameters]
    grid = _some_of_each(starts)
    tables = [
        {**one, "start": tuple(each)} for one, each in zip(parameters, zip(*grid, strict=True), strict=True)
    ]  # fmt: skip
    declaration = Declaration.model_validate(
        {"id": id_of(name), "title": acts_like, "looks_like": acts_like, "parameters": tables, **content}
    )
    return Term(family, declaration, acts_like)


def _some_of_each(starts: Sequence[Sequence[object]]) -> list[tuple[object, ...]]:
    """Give combinations of starts, `MOST_TERM_STARTS` or about as many, in which each start of each parameter comes."""
    places = list(itertools.product(*(range(len(own)) for own in starts)))
    every = -(-len(places) // MOST_TERM_STARTS)
    # diagonals of the grid: every second of a list would leave out every second start of the last parameter
    chosen = (place for place in places if sum(place) % every == 0)
    return [tuple(own[at] for own, at in zip(starts, place, strict=True)) for place in chosen]


def id_of(name: str) -> str:
    """Give a declaration's id: the name, where it is too long its beginning and a mark of its own."""
    whole = f"found_{name.lower()}"
    return whole if len(whole) <= LONGEST_ID else f"{whole[: LONGEST_ID - 5]}_{zlib.crc32(whole.encode()) % 10_000:04d}"
