"""The grammar: every term that may be proposed, as a declaration, enumerated.

Four families: a spring (the force is the derivative of a potential), a damper (the force never drives the motion; but
for one that may fall with v it is that of a convex dissipation potential in v, times a factor >= 0 of y), an element
that slips (one state, whose stored energy can only be given back or lost), and a factor > 0 on a coefficient of the
law. A spring, a damper or an element may itself be scaled by a power of a condition. A force in N multiplies what has
no dimension; lengths and times are parameters or reference values.
"""

from __future__ import annotations

import itertools
import re
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

from pipeclamp_models.equations.effect import Effect
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.declared import effect_of

Family = Literal["spring", "damper", "element", "factor"]
Entry = Mapping[str, object]

STRENGTH, RATE = "F_x", "s_x"
"""Symbols of the force that a term adds, N, and of the exponent of a factor."""
SIGN_Y, SIGN_V = "(y / sqrt(y**2 + y_r**2))", "(v / sqrt(v**2 + v_r**2))"
SIZE_Y, SIZE_V = "sqrt(y**2 + y_r**2)", "sqrt(v**2 + v_r**2)"
LENGTH = {"symbol": "y_x", "unit": "mm", "lower": "0.01 * A_typical", "upper": "3 * A_highest"}
SPEED = {
    "symbol": "v_x",
    "unit": "mm/s",
    "lower": "0.01 * A_typical * f_typical",
    "upper": "100 * A_highest * f_highest",
}
NARROWEST_CLEARANCE = 0.03
"""Share of a clearance that is never closed: a pole is cut off there, beyond the tests' range."""
MOST_PARAMETERS = 4
MOST_TERM_STARTS = 8
LONGEST_ID = 40
ROLES = {"stiffness": "stiffness", "damping": "damping", "slip": "slip force"}


def linear_symbol(family: Family) -> str:
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

    family: Family
    declaration: Declaration
    acts_like: str
    shorter: tuple[str, ...] = ()
    grown: tuple[str, ...] = ()

    @cached_property
    def effect(self) -> Effect:
        """The declaration as an effect, whose expressions are read once for all laws that the term is put into."""
        return effect_of(self.declaration)


@dataclass(frozen=True)
class _Shape:
    """A force without its strength: an expression, its parameters, words, and the state that it needs.

    `plain` is the name of the same one that acts everywhere; empty where this one does.
    """

    name: str
    expression: str
    acts_like: str
    parameters: tuple[Entry, ...] = ()
    state: Entry | None = None
    energy: str = ""
    signed: bool = False
    plain: str = ""


def terms(varied: Sequence[str], conditions: Mapping[str, float]) -> Iterator[Term]:
    """Give every term.

    Args:
        varied: of A, f, T and N those that vary over the tests.
        conditions: further columns that vary, with the largest magnitude of each.
    """
    scales = [None, *(one for name, one in SCALED.items() if name in varied)]
    scales += [scale for name, size in conditions.items() for scale in scales_of(name, size)]
    shapes: list[tuple[Family, _Shape]] = [
        *(("spring", shape) for shape in _springs()),
        *(("damper", shape) for shape in _dampers()),
        *(("element", shape) for shape in _elements()),
    ]
    for (family, shape), scale in itertools.product(shapes, scales):
        if 1 + len(shape.parameters) + (scale is not None) <= MOST_PARAMETERS:
            yield _force_term(family, shape, scale)
    if "T" in varied:
        for family, shape in _moved_by_temperature():
            yield _force_term(family, shape, None)
    signals = [*(name for name in FOLLOWED_CONDITIONS if name in varied), *conditions]
    for role, signal in itertools.product(ROLES, signals):
        yield from _factors(role, signal, conditions)


@dataclass(frozen=True)
class Scale:
    """What a term that adds a force is scaled by.

    Attributes:
        name: as ids have it.
        factor: > 0, with the exponent `s_x`.
        words: what it is.
        condition: the further column that it needs; empty where it is A, f or T.
    """

    name: str
    factor: str
    words: str
    condition: str = ""


SCALED = {
    "A": Scale("A", "(A / A_0)**s_x", "the amplitude"),
    "f": Scale("f", "(f / f_0)**s_x", "the frequency"),
    "T": Scale("T", "(T / T_0)**s_x", "the temperature"),
}
"""By A, f and T."""


def scales_of(column: str, size: float) -> tuple[Scale, ...]:
    """Give by what a term may follow a further column: exponentially, or with a power of it, which a field has."""
    name, share = _named(column), f"{_named(column)} / {size:.6g}"
    return (
        Scale(name, f"exp(s_x * {share})", column, column),
        Scale(f"{name}_power", f"(abs({share}) + {ABOVE_ZERO})**s_x", f"a power of {column}", column),
    )


ABOVE_ZERO = 0.001
"""Share of a further column's largest value that is added to it, for it may be zero."""


def _length(meaning: str, *shares: float, of: str = "A_highest") -> Entry:
    return {**LENGTH, "meaning": meaning, "start": tuple(f"{share} * {of}" for share in shares)}


def _exponent(meaning: str, *starts: float, lower: float = 0.0, upper: float = 9.0) -> Entry:
    return {"symbol": "p_x", "unit": "-", "meaning": meaning, "start": starts, "lower": lower, "upper": upper}


def _limit() -> Entry:
    starts = tuple(f"{share} * A_highest" for share in (1.2, 1.6, 3.0))
    meaning = "displacement at which it would grow without bound"
    return {**LENGTH, "meaning": meaning, "start": starts, "lower": "1.05 * A_highest", "upper": "10 * A_highest"}


def _springs() -> Iterator[_Shape]:
    power = _exponent("exponent of the displacement", 0.5, 2.0, 5.0, 7.0, lower=0.1)
    yield _Shape(
        "power_spring", f"{SIGN_Y} * ({SIZE_Y} / A_0)**p_x",
        "a spring whose force grows with a power of the displacement", (power,), signed=True,
    )  # fmt: skip
    yield _Shape(
        "one_way_power", f"({SIZE_Y} / A_0)**p_x", "a force to one side that grows with a power of the displacement",
        (_exponent("exponent of the displacement", 1.0, 2.0, 4.0, lower=0.1),), signed=True,
    )  # fmt: skip
    kink = _length("displacement from which it acts", 0.15, 0.4, 0.7)
    for order, grows in ((1, "linearly"), (2, "with the square"), (3, "with the cube")):
        for name, gone, where in (
            ("both", f"max({SIZE_Y} - y_x, 0)", "beyond a displacement on both sides"),
            ("positive", "max(y - y_x, 0)", "beyond a displacement on the positive side"),
            ("negative", "max(-y - y_x, 0)", "beyond a displacement on the negative side"),
        ):
            sign = {"both": SIGN_Y, "positive": "1", "negative": "-1"}[name]
            yield _Shape(
                f"stop_{name}_{order}", f"{sign} * ({gone} / A_0)**{order}",
                f"a spring that begins {where} and grows {grows}", (kink,),
            )  # fmt: skip
    reach = _length("displacement by which it changes", 0.1, 0.3, 1.0)
    yield _Shape("saturating_spring", "tanh(y / y_x)", "a spring whose force levels off", (reach,), signed=True)
    yield _Shape(
        "softening_spring", f"y / ({SIZE_Y} + y_x)", "a spring that softens slowly, its force levelling off in the end",
        (reach,), signed=True,
    )  # fmt: skip
    yield _Shape(
        "local_spring", "(y / y_x) * exp(-(y / y_x)**2)", "a spring about the middle only", (reach,), signed=True
    )
    yield _Shape(
        "growing_spring", "(exp(y / y_x) - exp(-y / y_x)) / 2", "a spring whose force grows exponentially",
        (_length("displacement by which it grows e times", 0.15, 0.3, 1.0),), signed=True,
    )  # fmt: skip
    yield _Shape(
        "periodic_spring", "sin(y / y_x)", "a spring with a valley after each stretch of the way, as detents have",
        (_length("stretch from valley to valley over 2 pi", *PERIOD_STARTS),), signed=True,
    )  # fmt: skip
    growth = _length("displacement by which it grows e times", 0.3, 1.0)
    for side, way in (("positive", "y"), ("negative", "-y")):
        yield _Shape(
            f"growing_{side}", f"exp({way} / y_x) - 1",
            f"a force that grows exponentially to the {side} side and levels off to the other", (growth,), signed=True,
        )  # fmt: skip
    for side, closed in CLOSING.items():
        force = f"y / (y_x * {closed})" if side == "both" else f"1 / {closed} - 1"
        yield _Shape(
            f"closing_spring_{side}", force,
            f"a spring whose force grows without bound towards a displacement on {SIDES[side]}", (_limit(),),
            signed=True,
        )  # fmt: skip


CLOSING = {
    "positive": f"max(1 - y / y_x, {NARROWEST_CLEARANCE})",
    "negative": f"max(1 + y / y_x, {NARROWEST_CLEARANCE})",
    "both": f"max(1 - (y / y_x)**2, {NARROWEST_CLEARANCE})",
}
"""Share of a clearance that is left, by the side on which it closes."""
SIDES = {"positive": "the positive side", "negative": "the negative side", "both": "both sides"}


PERIOD_STARTS = (0.03, 0.045, 0.07, 0.1, 0.15, 0.22, 0.33, 0.5)
"""Over the largest amplitude: a period is found only from a start that is near it."""


WHERE_IT_ACTS = (
    ("", "1", "", ()),
    ("_off_middle", f"({SIZE_Y} / A_0)**r_x", ", growing with a power of the displacement",
     ({"symbol": "r_x", "unit": "-", "meaning": "exponent of the displacement", "start": (1.0, 2.0, 4.0), "lower": 0.1,
       "upper": 8.0},)),
    ("_in_middle", "exp(-(y / y_x)**2)", ", about the middle only",
     (_length("displacement by which it fades", 0.2, 0.6),)),
    ("_beyond", f"(max({SIZE_Y} - y_x, 0) / A_0)**1", ", beyond a displacement on both sides",
     (_length("displacement from which it acts", 0.2, 0.5),)),
    ("_positive_side", "(max(y - y_x, 0) / A_0)**1", ", beyond a displacement on the positive side",
     (_length("displacement from which it acts", 0.05, 0.5),)),
    ("_negative_side", "(max(-y - y_x, 0) / A_0)**1", ", beyond a displacement on the negative side",
     (_length("displacement from which it acts", 0.05, 0.5),)),
    ("_rising", "(1 + y / y_x)**2", ", rising smoothly to the positive side",
     (_length("displacement by which it rises fourfold", 0.8, 2.0),)),
    ("_falling", "(1 - y / y_x)**2", ", rising smoothly to the negative side",
     (_length("displacement by which it rises fourfold", 0.8, 2.0),)),
    ("_outside", "(y / y_x)**2 / (1 + (y / y_x)**2)", ", pinched about the middle and level farther out",
     (_length("displacement at which half of it acts", 0.1, 0.4),)),
    *((f"_closing_{side}", f"1 / {closed}**2", f", growing without bound towards a displacement on {SIDES[side]}",
       (_limit(),)) for side, closed in CLOSING.items()),
)  # fmt: skip
"""Where a damper or a slip force acts: name, factor >= 0 of y, words, parameters."""


def _dampers() -> Iterator[_Shape]:
    speed = "velocity by which it changes"
    rates = (
        ("dry_damping", SIGN_V, "dry friction without elasticity", ()),
        ("viscous_damping", "v / v_0", "damping in proportion to the velocity", ()),
        ("square_damping", f"v * {SIZE_V} / v_0**2", "damping by the square of the velocity", ()),
        ("damping", f"{SIGN_V} * ({SIZE_V} / v_0)**p_x", "damping by a power of the velocity",
         (_exponent("exponent of the velocity", 0.2, 1.0, 2.0, 3.0, upper=5.0),)),
        ("saturating_damping", "tanh(v / v_x)", "damping that levels off with velocity", (_velocity(speed, 0.3, 2.0),)),
        ("thinning_damping", f"v / ({SIZE_V} + v_x)", "damping that thins with velocity, levelling off in the end",
         (_velocity(speed, 0.3, 2.0),)),
        ("bent_damping", "v / v_0 * (1 + (v / v_x)**2)**(-p_x / 2)",
         "damping that bends beyond a velocity, where it thins, levels off or falls",
         (_velocity(speed, 0.5, 3.0), _exponent("exponent that is lost beyond it", 0.6, 2.0, upper=3.0))),
        ("relief_damping", f"{SIGN_V} * (max({SIZE_V} - v_x, 0) / v_0)**1", "damping that begins beyond a velocity",
         (_velocity("velocity from which it acts", 1.0, 4.0),)),
        ("forward_damping", "(max(v, 0) / v_0)**1", "damping while the displacement rises only", ()),
        ("backward_damping", "-(max(-v, 0) / v_0)**1", "damping while the displacement falls only", ()),
        ("forward_square", "(max(v, 0) / v_0)**2", "square damping while the displacement rises only", ()),
        ("backward_square", "-(max(-v, 0) / v_0)**2", "square damping while the displacement falls only", ()),
    )  # fmt: skip
    for (name, rate, words, own), (place, factor, where, further) in itertools.product(rates, WHERE_IT_ACTS):
        yield _Shape(f"{name}{place}", f"{factor} * {rate}" if place else rate, f"{words}{where}", (*own, *further),
                     plain=name if place else "")  # fmt: skip


def _velocity(meaning: str, *shares: float) -> Entry:
    return {**SPEED, "meaning": meaning, "start": tuple(f"{share} * A_typical * f_typical" for share in shares)}


TIME: Entry = {"symbol": "t_x", "unit": "s", "meaning": "time in which it relaxes", "lower": "0.001 / f_highest",
        "upper": "100 / f_lowest", "start": ("0.03 / f_typical", "0.3 / f_typical")}  # fmt: skip
LEAST_LIMIT = 0.001
"""Where nothing holds, an element yields within this share of its way."""


def _elements() -> Iterator[_Shape]:
    way: Entry = {"symbol": "w_x", "unit": "mm", "meaning": "way by which it is strained", "lower": "0.001 * A_typical",
           "upper": "3 * A_highest", "start": ("0.1 * A_typical", "0.5 * A_typical")}  # fmt: skip
    trial = "z_x + (y - y_previous) / w_x"

    def state(update: str) -> Entry:
        return {"symbol": "z_x", "unit": "-", "meaning": "strain of the element", "update": update}

    stored = f"{STRENGTH} * w_x * z_x**2 / 2"
    for place, factor, where, further in WHERE_IT_ACTS:
        limit = factor.replace("y_x", "q_x")
        own = tuple({**one, "symbol": "q_x"} if one["symbol"] == "y_x" else one for one in further)
        yield _Shape(
            f"slip{place}", "z_x", f"dry friction{where or ' of one strength'}", (way, *own),
            state(f"min(max({trial}, -({limit})), {limit})"), stored, plain="slip" if place else "",
        )  # fmt: skip
        way_on, whole = "sign(y - y_previous)", f"({limit})"
        left = f"exp(-abs(y - y_previous) / (w_x * max({whole}, {LEAST_LIMIT})))"
        yield _Shape(
            f"smooth_slip{place}", "z_x", f"dry friction that yields smoothly{where}", (way, *own),
            state(f"{way_on} * {whole} + (z_x - {way_on} * {whole}) * {left}"), stored,
            plain="smooth_slip" if place else "",
        )  # fmt: skip
    for power, words in ((0.5, "softens"), (2, "stiffens"), (3, "stiffens much")):
        yield _Shape(
            f"bent_slip_{str(power).replace('.', 'p')}", f"z_x * sqrt(z_x**2 + 1e-6)**{power - 1}",
            f"dry friction through a spring that {words}", (way,), state(f"min(max({trial}, -1), 1)"),
        )  # fmt: skip
    play: Entry = {"symbol": "g_x", "unit": "-", "meaning": "share of the way that is play", "start": (0.3, 0.7),
            "lower": 0.0, "upper": 0.95}  # fmt: skip
    yield _Shape(
        "slip_after_play", "(max(z_x - g_x, 0) - max(-z_x - g_x, 0)) / (1 - g_x)",
        "dry friction through a spring with play", (way, play), state(f"min(max({trial}, -1), 1)"),
    )  # fmt: skip
    for power in (1, 2):
        yield _Shape(
            f"relaxing_{power}", "z_x",
            f"a spring whose force creeps away, the faster the larger it is (power {power + 1})", (way, TIME),
            state(f"({trial}) / (1 + h / t_x * abs({trial})**{power})"), stored,
        )  # fmt: skip


def _moved_by_temperature() -> Iterator[tuple[Family, _Shape]]:
    """Give springs that begin at a place, and elements that relax in a time, which temperature moves."""
    warmer = "(T - T_0) / 100"
    moves: Entry = {**LENGTH, "symbol": "m_x", "meaning": "by which it is nearer for each 100 K", "neutral": 0.0,
             "lower": "-A_highest", "upper": "A_highest", "start": ("0.1 * A_highest", "-0.1 * A_highest")}  # fmt: skip
    kink = _length("displacement from which it acts at 20 °C", 0.3, 0.6, 0.9)
    place = f"y_x - m_x * {warmer}"
    for order, grows in ((1, "linearly"), (2, "with the square")):
        for name, sign, gone, where in (
            ("both", SIGN_Y, f"{SIZE_Y} - max({place}, 0)", "both sides"),
            ("positive", "1", f"y - ({place})", SIDES["positive"]),
            ("negative", "-1", f"-y - ({place})", SIDES["negative"]),
        ):
            yield "spring", _Shape(
                f"moved_stop_{name}_{order}", f"{sign} * (max({gone}, 0) / A_0)**{order}",
                f"a spring that begins beyond a displacement on {where}, which temperature moves, and grows {grows}",
                (kink, moves),
            )  # fmt: skip
    trial = "z_x + (y - y_previous) / A_0"
    yield "element", _Shape(
        "warm_relaxing", "z_x", "a spring whose force creeps away in a time that temperature changes",
        ({**TIME, "start": tuple(f"{share} / f_typical" for share in (0.05, 0.2, 0.8))},
         _scaling("by how much the time's logarithm falls for each 100 K", 0.5, -0.5)),
        {"symbol": "z_x", "unit": "-", "meaning": "strain of the element",
         "update": f"({trial}) / (1 + h / t_x * exp(s_x * {warmer}))"},
        f"{STRENGTH} * A_0 * z_x**2 / 2",
    )  # fmt: skip


def _force_term(family: Family, shape: _Shape, scale: Scale | None) -> Term:
    """Give a term that adds a force, alone or scaled by what follows A, f, T or a further column."""
    words = f", scaled with {scale.words}" if scale else ""
    further = (_scaling(f"by how much it follows {scale.words}", -0.5, 0.5),) if scale else ()
    strength: Entry = {"symbol": STRENGTH, "unit": "N", "meaning": "force of the term", "start": "0.05 * F_typical"}
    if not shape.signed:
        strength = {**strength, "lower": 0.0}
    scaled = f"{STRENGTH} * {scale.factor}" if scale else STRENGTH
    term = _term(
        family, _name(shape.name, scale), f"{shape.acts_like}{words}",
        parameters=(strength, *shape.parameters, *further), force=f"{scaled} * ({shape.expression})",
        states=(shape.state,) if shape.state else (), energy=shape.energy.replace(STRENGTH, scaled),
        conditions=(scale.condition,) if scale and scale.condition else (),
    )  # fmt: skip
    names = {shape.name, shape.plain} - {""}
    shorter = {_name(one, each) for one in names for each in {scale, None}} - {_name(shape.name, scale)}
    return replace(term, shorter=tuple(sorted(map(id_of, shorter))))


def _name(shape: str, scale: Scale | None) -> str:
    """Give the name of a term that adds a force."""
    return f"{shape}{f'_by_{scale.name}' if scale else ''}"


FOLLOWED_CONDITIONS = {
    "A": ("A / A_0", "0.5 * A_typical", "A_typical", "A_highest", "mm", "amplitude"),
    "f": ("f / f_0", "f_lowest", "f_typical", "f_highest", "Hz", "frequency"),
    "T": ("(T - T_0) / 100", "T_lowest + 0.3 * (T_highest - T_lowest)", "T_lowest + 0.6 * (T_highest - T_lowest)",
          "(T_highest - T_lowest)", "K", "temperature"),
    "N": ("N / 1000", "0.1 * N_highest", "0.4 * N_highest", "N_highest", "-", "number of cycles"),
}  # fmt: skip
"""Signals that a factor may follow: without its dimension, two levels at which it may bend, its range, unit, name."""


def _factors(role: str, signal: str, conditions: Mapping[str, float]) -> Iterator[Term]:
    """Give factors > 0 on a coefficient of the law: power, exponential, bent, from a level on, levelling off."""
    if signal in conditions:
        plain, unit, name, size = _named(signal), "in its name", signal, f"{conditions[signal]:.6g}"
        pure, bends = f"{plain} / {size}", tuple[object, ...](share * conditions[signal] for share in (0.3, 0.6))
        above, reach = f"abs({pure}) + {ABOVE_ZERO}", size
    else:
        pure, low, high, reach, unit, name = FOLLOWED_CONDITIONS[signal]
        bends = (low, high)
        plain, size = signal, {"A": "A_0", "f": "f_0", "T": "100", "N": "1000"}[signal]
        above = {"T": "T / T_0", "N": "1 + N"}.get(signal, pure)
    level: Entry = {"symbol": "l_x", "unit": unit, "meaning": f"level of {signal} at which it changes", "start": bends}
    width: Entry = {"symbol": "w_x", "unit": unit, "meaning": f"change of {signal} in which it steps",
             "start": (f"0.05 * {reach}", f"0.15 * {reach}"), "lower": f"0.01 * {reach}", "upper": reach}  # fmt: skip
    past = f"(max({plain} - l_x, 0) / {size})**1"
    forms: list[tuple[str, str, str, tuple[Entry, ...]]] = [
        ("power", f"log({above})", "changes with a power of", ()),
        ("exponential", pure, "changes exponentially with", ()),
        ("bent", f"({pure})**2", "changes with the square of", ()),
        ("beyond", past, "changes exponentially beyond a level of", (level,)),
        ("levelling", f"{plain} / (abs({plain}) + abs(l_x))", "changes and levels off with", (level,)),
        ("step", f"(1 + tanh(({plain} - l_x) / w_x)) / 2", "steps at a level of", (level, width)),
    ]
    if signal != "T":
        forms.append(("growing", f"log(1 + abs({plain} / l_x))", "changes beyond a level with a power of", (level,)))
    if signal in ("A", "f"):
        peak = f"2 * {plain} * l_x / ({plain}**2 + l_x**2)"
        forms.append(("peak", peak, "has a peak, or a trough, at a level of", (level,)))
    condition = signal if signal in conditions else ""
    beyond, linear = (f"{role}_{form}_{plain}" for form in ("beyond", "linear"))
    for form, exponent, words, parameters in forms:
        term = _factor(
            role, f"{role}_{form}_{plain}", f"exp({RATE} * ({exponent}))", f"{words} the {name}",
            (_scaling("how much the logarithm changes", 0.1), *parameters), condition,
        )  # fmt: skip
        yield replace(term, grown=(id_of(linear),)) if form == "beyond" else term
    each = {"A": "mm", "f": "Hz", "T": "100 K", "N": "1000 cycles"}.get(signal, f"{size} of {name}")
    growth = {**_scaling(f"growth, as a share, for each {each}", 0.1), "lower": 0.0}
    words = f"grows linearly beyond a level of the {name}"
    term = _factor(role, linear, f"1 + {RATE} * {past}", words, (growth, level), condition)
    yield replace(term, grown=(id_of(beyond),))


def _factor(role: str, name: str, factor: str, words: str, parameters: tuple[Entry, ...], condition: str) -> Term:
    """Give a factor on a coefficient of the law; the further column that it needs is empty where it needs none."""
    return _term(
        "factor", name, f"{ROLES[role]} that {words}", parameters=parameters,
        scales=({"coefficient": role, "factor": factor},), conditions=(condition,) if condition else (),
    )  # fmt: skip


def _scaling(meaning: str, *starts: float) -> Entry:
    return {
        "symbol": RATE,
        "unit": "-",
        "meaning": meaning,
        "start": starts,
        "lower": -5.0,
        "upper": 5.0,
        "neutral": 0.0,
    }


def _named(column: str) -> str:
    """Give the name that a further column has in expressions."""
    return re.sub(r"\W", "_", column)


def _term(
    family: Family, name: str, acts_like: str, *, parameters: Sequence[Mapping[str, object]], **content: object
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
