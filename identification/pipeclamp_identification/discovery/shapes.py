"""Shapes of force that a term may have: springs, dampers, elements that slip or creep, and what temperature moves.

A shape has no strength of its own: grammar.py makes terms of shapes, alone or scaled by what follows a condition.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

TermFamily = Literal["spring", "damper", "element", "factor"]
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


@dataclass(frozen=True)
class Shape:
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


def _length(meaning: str, *shares: float, of: str = "A_highest") -> Entry:
    return {**LENGTH, "meaning": meaning, "start": tuple(f"{share} * {of}" for share in shares)}


def _exponent(meaning: str, *starts: float, lower: float = 0.0, upper: float = 9.0) -> Entry:
    return {"symbol": "p_x", "unit": "-", "meaning": meaning, "start": starts, "lower": lower, "upper": upper}


def _limit() -> Entry:
    starts = tuple(f"{share} * A_highest" for share in (1.2, 1.6, 3.0))
    meaning = "displacement at which it would grow without bound"
    return {**LENGTH, "meaning": meaning, "start": starts, "lower": "1.05 * A_highest", "upper": "10 * A_highest"}


def springs() -> Iterator[Shape]:
    """Give springs: forces of the displacement that a potential has."""
    power = _exponent("exponent of the displacement", 0.5, 2.0, 5.0, 7.0, lower=0.1)
    yield Shape(
        "power_spring", f"{SIGN_Y} * ({SIZE_Y} / A_0)**p_x",
        "a spring whose force grows with a power of the displacement", (power,), signed=True,
    )  # fmt: skip
    yield Shape(
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
            yield Shape(
                f"stop_{name}_{order}", f"{sign} * ({gone} / A_0)**{order}",
                f"a spring that begins {where} and grows {grows}", (kink,),
            )  # fmt: skip
    reach = _length("displacement by which it changes", 0.1, 0.3, 1.0)
    yield Shape("saturating_spring", "tanh(y / y_x)", "a spring whose force levels off", (reach,), signed=True)
    yield Shape(
        "softening_spring", f"y / ({SIZE_Y} + y_x)", "a spring that softens slowly, its force levelling off in the end",
        (reach,), signed=True,
    )  # fmt: skip
    yield Shape(
        "local_spring", "(y / y_x) * exp(-(y / y_x)**2)", "a spring about the middle only", (reach,), signed=True
    )
    yield Shape(
        "growing_spring", "(exp(y / y_x) - exp(-y / y_x)) / 2", "a spring whose force grows exponentially",
        (_length("displacement by which it grows e times", 0.15, 0.3, 1.0),), signed=True,
    )  # fmt: skip
    yield Shape(
        "periodic_spring", "sin(y / y_x)", "a spring with a valley after each stretch of the way, as detents have",
        (_length("stretch from valley to valley over 2 pi", *PERIOD_STARTS),), signed=True,
    )  # fmt: skip
    growth = _length("displacement by which it grows e times", 0.3, 1.0)
    for side, way in (("positive", "y"), ("negative", "-y")):
        yield Shape(
            f"growing_{side}", f"exp({way} / y_x) - 1",
            f"a force that grows exponentially to the {side} side and levels off to the other", (growth,), signed=True,
        )  # fmt: skip
    for side, closed in CLOSING.items():
        force = f"y / (y_x * {closed})" if side == "both" else f"1 / {closed} - 1"
        yield Shape(
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


PERIOD_STARTS = tuple(round(1 / waves, 4) for waves in (31, 27, 23, 19, 15, 11, 7, 3))
"""Over the largest amplitude: a period is found only from a start that is in step with it, to a third of a turn at the
largest amplitude, so that its inverses are what is equally far apart."""


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


def dampers() -> Iterator[Shape]:
    """Give dampers: forces that never drive the motion, everywhere or where they act."""
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
        yield Shape(f"{name}{place}", f"{factor} * {rate}" if place else rate, f"{words}{where}", (*own, *further),
                     plain=name if place else "")  # fmt: skip


def _velocity(meaning: str, *shares: float) -> Entry:
    return {**SPEED, "meaning": meaning, "start": tuple(f"{share} * A_typical * f_typical" for share in shares)}


LEVEL_AT_SPEED: Entry = {"symbol": "r_x", "unit": "-", "meaning": "level at speed over that next to rest, less 1",
        "start": (0.5, -0.5), "lower": -0.95, "upper": 20.0}  # fmt: skip
AT_SPEED = (
    ("_at_speed", f"(1 + r_x * (1 - exp(-{SIZE_V} / v_x)))", ", going from one level to another with the velocity",
     (_velocity("velocity at which two thirds of the change are made", 1.0, 5.0), LEVEL_AT_SPEED)),
    ("_past_speed", "(1 + r_x * (1 - exp(-(v / v_x)**2)))",
     ", going from one level to another with the square of the velocity",
     (_velocity("velocity at which two thirds of the change are made", 1.0, 5.0), LEVEL_AT_SPEED)),
    ("_by_speed", "(1 + (v / v_x)**2)**(p_x / 2)", ", rising or falling with a power of the velocity beyond one",
     (_velocity("velocity beyond which it rises or falls", 1.0, 5.0),
      _exponent("exponent of the velocity", 0.4, -0.4, lower=-2.0, upper=2.0))),
)  # fmt: skip
"""What holds an element that slips may follow the velocity, as in sliding bearings (Constantinou, Mokha and Reinhorn
1990), under bristles (Canudas de Wit, Olsson, Astroem and Lischinsky 1995) and where yielding takes time (Cowper and
Symonds 1957): name, factor > 0, words, parameters."""

TIME: Entry = {"symbol": "t_x", "unit": "s", "meaning": "time in which it relaxes", "lower": "0.001 / f_highest",
        "upper": "100 / f_lowest", "start": tuple(f"{share} / f_typical" for share in (0.05, 0.2, 0.8))}  # fmt: skip
CREEPS = (0.005, 0.05, 0.5)
"""Shares of a typical cycle in which an element that creeps is relaxed from a typical strain, where fits begin."""
SNAPS_WITHIN = 1 / 6
"""Share of the tests' temperatures within which a stop goes from one place to another."""
LEAST_LIMIT = 0.001
"""Where nothing holds, an element yields within this share of its way."""
STILL, STILL_SQUARED = 1e-10, 1e-20
"""A step, over an element's way and time, in which nothing happens, and its square: nothing is divided by less."""


def elements() -> Iterator[Shape]:
    """Give elements with one state, or none: they slip, creep or level off, and give back no more than they store."""
    way: Entry = {"symbol": "w_x", "unit": "mm", "meaning": "way by which it is strained", "lower": "0.001 * A_typical",
           "upper": "3 * A_highest", "start": ("0.1 * A_typical", "0.5 * A_typical")}  # fmt: skip
    trial = "z_x + (y - y_previous) / w_x"

    def state(update: str) -> Entry:
        return {"symbol": "z_x", "unit": "-", "meaning": "strain of the element", "update": update}

    stored = f"{STRENGTH} * w_x * z_x**2 / 2"
    for place, factor, where, further in (*WHERE_IT_ACTS, *AT_SPEED):
        limit = factor.replace("y_x", "q_x")
        own = tuple({**one, "symbol": "q_x"} if one["symbol"] == "y_x" else one for one in further)
        yield Shape(
            f"slip{place}", "z_x", f"dry friction{where or ' of one strength'}", (way, *own),
            state(f"min(max({trial}, -({limit})), {limit})"), stored, plain="slip" if place else "",
        )  # fmt: skip
        way_on, whole = "sign(y - y_previous)", f"({limit})"
        left = f"exp(-abs(y - y_previous) / (w_x * max({whole}, {LEAST_LIMIT})))"
        yield Shape(
            f"smooth_slip{place}", "z_x", f"dry friction that yields smoothly{where}", (way, *own),
            state(f"{way_on} * {whole} + (z_x - {way_on} * {whole}) * {left}"), stored,
            plain="smooth_slip" if place else "",
        )  # fmt: skip
    for power, words in ((0.5, "softens"), (2, "stiffens"), (3, "stiffens much")):
        yield Shape(
            f"bent_slip_{str(power).replace('.', 'p')}", f"z_x * sqrt(z_x**2 + 1e-6)**{power - 1}",
            f"dry friction through a spring that {words}", (way,), state(f"min(max({trial}, -1), 1)"),
        )  # fmt: skip
    play: Entry = {"symbol": "g_x", "unit": "-", "meaning": "share of the way that is play", "start": (0.3, 0.7),
            "lower": 0.0, "upper": 0.95}  # fmt: skip
    yield Shape(
        "slip_after_play", "(max(z_x - g_x, 0) - max(-z_x - g_x, 0)) / (1 - g_x)",
        "dry friction through a spring with play", (way, play), state(f"min(max({trial}, -1), 1)"),
    )  # fmt: skip
    # with a way of its own, too, its strength would be no number of its own: both scale what it stores
    strained = "z_x + (y - y_previous) / A_0"
    for power in (1, 2):
        typical = f"(A_typical / A_0)**{power}"
        time: Entry = {"symbol": "t_x", "unit": "s", "meaning": "time in which it relaxes from A_0",
                "lower": f"1e-5 * {typical} / f_highest", "upper": f"1000 * {typical} / f_lowest",
                "start": tuple(f"{share} * {typical} / f_typical" for share in CREEPS)}  # fmt: skip
        yield Shape(
            f"relaxing_{power}", "z_x",
            f"a spring whose force creeps away, the faster the larger it is (power {power + 1})", (time,),
            state(f"({strained}) / (1 + h / t_x * abs({strained})**{power})"), f"{STRENGTH} * A_0 * z_x**2 / 2",
        )  # fmt: skip
    # activated flow (Eyring 1936), in proportion to a small force and far faster under a large one: over a step of even
    # motion the strain u follows du/dt = v / q - sinh(u) / t, of which z = tanh(u / 2) solves a Riccati equation
    way_over, time_over = "(y - y_previous) / q_x", "h / t_x"
    size = f"sqrt(({way_over})**2 + ({time_over})**2 + {STILL_SQUARED})"
    eased, strain = f"tanh({size} / 2) / {size}", "log((1 + z_x) / (1 - z_x))"
    yield Shape(
        "activated_relaxing", strain,
        "a spring whose force creeps away in a time, and far faster where it is strained far",
        (TIME, {**_length("strain beyond which it creeps far faster", 0.05, 0.2), "symbol": "q_x"}),
        state(f"(z_x * (1 - {time_over} * {eased}) + {way_over} * {eased}) / "
              f"(1 + ({time_over} + {way_over} * z_x) * {eased})"),
        f"{STRENGTH} * q_x * {strain}**2 / 2",
    )  # fmt: skip
    # structure that shear breaks and rest builds up (Moore 1959): exact over a step of even motion
    broken = "abs(y - y_previous) / q_x"
    both = f"(h / t_x + {broken} + {STILL})"
    worn: Entry = {"symbol": "z_x", "unit": "-", "meaning": "share of its structure that is broken",
            "update": f"z_x * exp(-{both}) + (1 - exp(-{both})) * {broken} / {both}"}  # fmt: skip
    rest: Entry = {**TIME, "meaning": "time in which it builds up again at rest"}
    worn_by: Entry = {**_length("way along which it breaks", 0.3, 3.0), "symbol": "q_x", "upper": "100 * A_highest"}
    for name, rate, words, own in (
        ("dry", SIGN_V, "dry friction that", ()), ("viscous", "v / v_0", "viscous damping that", ()),
        ("saturating", "tanh(v / v_x)", "damping that levels off with velocity,",
         (_velocity("velocity by which it levels off", 0.1, 1.0),)),
    ):  # fmt: skip
        yield Shape(
            f"thixotropic_{name}", f"(1 - z_x) * {rate}",
            f"{words} weakens as it moves and recovers at rest", (rest, worn_by, *own), worn,
        )  # fmt: skip
    # at rest it is a spring, which gives back what it took; it rises with v, so that what v adds acts against v
    shifted = f"(v / v_x + r_x * {SIGN_Y})"
    yield Shape(
        "shifted_damping", f"{shifted} / sqrt(1 + {shifted} * {shifted})",
        "damping that levels off with velocity, larger on the way out than on the way back",
        (_velocity("velocity by which it changes", 0.3, 2.0),
         {"symbol": "r_x", "unit": "-", "meaning": "velocity on the way back at which nothing holds, over that one",
          "start": (0.3, 1.0), "lower": 0.0, "upper": 5.0}),
        energy=f"{STRENGTH} * r_x / sqrt(1 + r_x**2) * {SIZE_Y}",
    )  # fmt: skip


def moved_by_temperature(span_K: float) -> Iterator[tuple[TermFamily, Shape]]:
    """Give springs that begin at a place, and elements that relax in a time, which temperature moves.

    Args:
        span_K: by which the tests' temperatures differ, K.
    """
    warmer = "(T - T_0) / 100"
    moves: Entry = {**LENGTH, "symbol": "m_x", "meaning": "by which it is nearer for each 100 K", "neutral": 0.0,
             "lower": "-A_highest", "upper": "A_highest", "start": ("0.1 * A_highest", "-0.1 * A_highest")}  # fmt: skip
    kink = _length("displacement from which it acts at 20 °C", 0.3, 0.6, 0.9)
    # of four levels tested, what changes faster than within a sixth of them all shows nothing of how fast
    past = f"((T - l_x) / {span_K * SNAPS_WITHIN:.6g})"
    cold: Entry = {**kink, "meaning": "displacement from which it acts when cold"}
    snaps: Entry = {**moves, "meaning": "by which it is nearer when hot", "follows": ("T",), "levels": 3,
             "start": ("0.25 * A_highest", "-0.25 * A_highest")}  # fmt: skip
    levels = tuple(f"T_lowest + {share} * (T_highest - T_lowest)" for share in (0.3, 0.6))
    level: Entry = {"symbol": "l_x", "unit": "K", "meaning": "temperature about which it moves", "start": levels,
             "lower": "T_lowest", "upper": "T_highest"}  # fmt: skip
    for name, place, words, own in (
        ("moved", f"y_x - m_x * {warmer}", "which temperature moves", (kink, moves)),
        ("snapped", f"y_x - m_x * (1 + {past} / sqrt(1 + {past} * {past})) / 2",
         "which goes from one place to another about a temperature", (cold, snaps, level)),
    ):  # fmt: skip
        for (order, grows), (side, sign, gone, where) in itertools.product(
            ((1, "linearly"), (2, "with the square")),
            (
                ("both", SIGN_Y, f"{SIZE_Y} - max({place}, 0)", "both sides"),
                ("positive", "1", f"y - ({place})", SIDES["positive"]),
                ("negative", "-1", f"-y - ({place})", SIDES["negative"]),
            ),
        ):
            yield "spring", Shape(
                f"{name}_stop_{side}_{order}", f"{sign} * (max({gone}, 0) / A_0)**{order}",
                f"a spring that begins beyond a displacement on {where}, {words}, and grows {grows}", own,
            )  # fmt: skip
    trial = "z_x + (y - y_previous) / A_0"
    yield "element", Shape(
        "warm_relaxing", "z_x", "a spring whose force creeps away in a time that temperature changes",
        (TIME, scaling("by how much the time's logarithm falls for each 100 K", 0.5, -0.5)),
        {"symbol": "z_x", "unit": "-", "meaning": "strain of the element",
         "update": f"({trial}) / (1 + h / t_x * exp(s_x * {warmer}))"},
        f"{STRENGTH} * A_0 * z_x**2 / 2",
    )  # fmt: skip


def scaling(meaning: str, *starts: float) -> Entry:
    """Give the exponent of a factor, zero where it is one."""
    return {
        "symbol": RATE,
        "unit": "-",
        "meaning": meaning,
        "start": starts,
        "lower": -5.0,
        "upper": 5.0,
        "neutral": 0.0,
    }
