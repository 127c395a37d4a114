"""Marches of states along motions, in the language of LLVM: what a law's equations make of each sample of each row."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import reduce
from typing import TypeVar

import numpy as np
import sympy as sp
from llvmlite import ir
from sympy.functions.elementary.piecewise import ExprCondPair

from pipeclamp_models.equations import symbols
from pipeclamp_models.realise.llvm import DOUBLE, Writer, number
from pipeclamp_models.realise.slopes import needed
from pipeclamp_models.realise.stepping import Definition

INTEGER, BYTE = ir.IntType(64), ir.IntType(8)
ADDRESS = ir.PointerType()
MOVING = frozenset((symbols.y, symbols.v, symbols.a, symbols.y_previous))
"""What changes along a cycle; the states do besides."""

Key = TypeVar("Key")


class MarchWriter:
    """A function in the making that goes through all samples of all rows, and what it takes.

    In machine code it is `function(rows, samples, columns, strides, start, results)`: `columns` are the addresses of
    the arguments' first numbers, `strides` two for each, the bytes from row to row and from sample to sample; `start`
    holds the states before the first sample, (J, R), and `results` takes what is written, (K, R, n), or (K, R).
    """

    def __init__(self, name: str, columns: int) -> None:
        self.module = ir.Module(name)
        takes = [INTEGER, INTEGER, *[ADDRESS] * 4]
        self.function = ir.Function(self.module, ir.FunctionType(ir.VoidType(), takes), name)
        self.rows, self.samples, places, strides, self.start, self.results = self.function.args
        for one in (self.start, self.results):
            one.add_attribute("noalias")
        self.builder = ir.IRBuilder(self.function.append_basic_block())
        self._columns = [
            (self._at(places, ADDRESS, column), *(self._at(strides, INTEGER, 2 * column + way) for way in range(2)))
            for column in range(columns)
        ]

    def _at(self, address: ir.Value, kind: ir.Type, place: int) -> ir.Value:
        return self.builder.load(self.builder.gep(address, [ir.Constant(INTEGER, place)], source_etype=kind), typ=kind)

    def arguments(
        self, names: Sequence[sp.Symbol | None], row: ir.Value, sample: ir.Value
    ) -> dict[sp.Symbol, ir.Value]:
        """Read the arguments at a sample, named in their order; those without a name aren't read."""
        builder, found = self.builder, {}
        for name, (address, by_row, by_sample) in zip(names, self._columns, strict=True):
            if name is not None:
                away = builder.add(builder.mul(row, by_row), builder.mul(sample, by_sample))
                found[name] = builder.load(builder.gep(address, [away], source_etype=BYTE), typ=DOUBLE)
        return found

    def held(self, names: Sequence[Key]) -> dict[Key, ir.Value]:
        """Give places for numbers that go along from sample to sample."""
        return {name: self.builder.alloca(DOUBLE) for name in names}

    def read(self, held: Mapping[Key, ir.Value]) -> dict[Key, ir.Value]:
        """Read the numbers at such places."""
        return {name: self.builder.load(address, typ=DOUBLE) for name, address in held.items()}

    def begin(self, held: Mapping[sp.Symbol, ir.Value], row: ir.Value) -> None:
        """Put the states before the first sample there."""
        builder = self.builder
        for state, address in enumerate(held.values()):
            place = builder.add(builder.mul(ir.Constant(INTEGER, state), self.rows), row)
            started = builder.load(builder.gep(self.start, [place], source_etype=DOUBLE), typ=DOUBLE)
            builder.store(started, address)

    def write(self, result: int, row: ir.Value, value: ir.Value, sample: ir.Value | None = None) -> None:
        """Write a result of a row, at a sample where there is one of each."""
        builder = self.builder
        place = builder.add(builder.mul(ir.Constant(INTEGER, result), self.rows), row)
        if sample is not None:
            place = builder.add(builder.mul(place, self.samples), sample)
        builder.store(value, builder.gep(self.results, [place], source_etype=DOUBLE))

    @contextmanager
    def through(self, count: ir.Value) -> Iterator[ir.Value]:
        """Repeat what is written inside, for each number below a count."""
        builder, before = self.builder, self.builder.block
        head, body, end = (self.function.append_basic_block() for _ in range(3))
        builder.branch(head)
        builder.position_at_end(head)
        index = builder.phi(INTEGER)
        index.add_incoming(ir.Constant(INTEGER, 0), before)
        builder.cbranch(builder.icmp_signed("<", index, count), body, end)
        builder.position_at_end(body)
        yield index
        index.add_incoming(builder.add(index, ir.Constant(INTEGER, 1)), builder.block)
        builder.branch(head)
        builder.position_at_end(end)

    def written(self) -> str:
        """Give the whole module."""
        self.builder.ret_void()
        return str(self.module)


def walk_source(
    arguments: Sequence[sp.Symbol],
    states: Sequence[sp.Symbol],
    updates: Sequence[sp.Expr],
    stages: Sequence[Definition],
) -> str:
    """Write a march that steps states, and gives those after each sample.

    Args:
        arguments: what the updates take besides the states.
        states: those that are stepped.
        updates: the states after a step.
        stages: what is computed on the way.
    """
    march = MarchWriter("walk", len(arguments))
    kept = march.held(states)
    with march.through(march.rows) as row:
        march.begin(kept, row)
        with march.through(march.samples) as sample:
            known = {**march.arguments(arguments, row, sample), **march.read(kept)}
            writer = Writer(march.builder, known, stages)
            for place, (state, update) in enumerate(zip(states, updates, strict=True)):
                value = writer.value(update)
                march.builder.store(value, kept[state])
                march.write(place, row, value, sample)
    return march.written()


def turn_source(
    arguments: Sequence[sp.Symbol],
    states: Sequence[sp.Symbol],
    updates: Sequence[sp.Expr],
    stages: Sequence[Definition],
) -> tuple[str, list[tuple[int, int]]]:
    """Write a march that steps states and gives of each row those at its end, how large each became, and slopes.

    The slopes are those of the states at the end by those at the beginning: the steps' slopes, multiplied on the way.
    What is taken is as of `walk_source`, but all that is no motion keeps still along a row; places of end and beginning
    of each slope that doesn't vanish come with it.
    """
    march = MarchWriter("turn", len(arguments))
    builder, index = march.builder, _reached(states, updates, stages)
    kept, largest, product = march.held(states), march.held(states), march.held(index)
    with march.through(march.rows) as row:
        march.begin(kept, row)
        for address in largest.values():
            builder.store(number(0.0), address)
        for (end, beginning), address in product.items():
            builder.store(number(float(end == beginning)), address)
        still = _still(march, row, arguments, states, updates, stages)
        with march.through(march.samples) as sample:
            so_far = march.read(product)
            known = {**march.arguments(_moving(arguments), row, sample), **march.read(kept)}
            writer = Writer(builder, known, stages, states, still)
            for state, update in zip(states, updates, strict=True):
                value = writer.value(update)
                builder.store(value, kept[state])
                size, most = writer.size(value), builder.load(largest[state], typ=DOUBLE)
                # what is no number stays none
                builder.store(builder.select(builder.fcmp_ordered(">=", most, size), most, size), largest[state])
            for end, beginning in index:
                slopes = writer.slopes(updates[end])
                terms = [
                    builder.fmul(slopes[state], so_far[between, beginning])
                    for between, state in enumerate(states)
                    if state in slopes and (between, beginning) in so_far
                ]
                builder.store(reduce(builder.fadd, terms, number(0.0)), product[end, beginning])
        for result, address in enumerate([*kept.values(), *largest.values(), *product.values()]):
            march.write(result, row, builder.load(address, typ=DOUBLE))
    return march.written(), index


def course_source(
    arguments: Sequence[sp.Symbol],
    states: Sequence[sp.Symbol],
    updates: Sequence[sp.Expr],
    stages: Sequence[Definition],
    by: Sequence[sp.Symbol],
) -> tuple[str, list[tuple[int, int]]]:
    """Write a march that steps states and gives those after each sample, then their slopes there.

    The slopes are by the states before the first sample, and by others of the arguments: the steps' slopes, gathered on
    the way. What is taken is as of `turn_source`; of each slope that doesn't vanish the places come with it, of the
    state and of what it is differentiated by, among the states and, after them, the others.
    """
    march = MarchWriter("course", len(arguments))
    builder = march.builder
    index = [*_reached(states, updates, stages), *_reached_from(by, states, updates, stages)]
    kept, gathered = march.held(states), march.held(index)
    with march.through(march.rows) as row:
        march.begin(kept, row)
        for (state, source), address in gathered.items():
            builder.store(number(float(state == source)), address)
        still = _still(march, row, arguments, states, updates, stages, by)
        with march.through(march.samples) as sample:
            so_far = march.read(gathered)
            known = {**march.arguments(_moving(arguments), row, sample), **march.read(kept)}
            writer = Writer(builder, known, stages, [*states, *by], still)
            for place, (state, update) in enumerate(zip(states, updates, strict=True)):
                value = writer.value(update)
                builder.store(value, kept[state])
                march.write(place, row, value, sample)
            for result, (end, source) in enumerate(index, start=len(states)):
                slopes = writer.slopes(updates[end])
                terms = [
                    builder.fmul(slopes[state], so_far[between, source])
                    for between, state in enumerate(states)
                    if state in slopes and (between, source) in so_far
                ]
                if source >= len(states) and by[source - len(states)] in slopes:
                    terms.append(slopes[by[source - len(states)]])
                slope = reduce(builder.fadd, terms, number(0.0))
                builder.store(slope, gathered[end, source])
                march.write(result, row, slope, sample)
    return march.written(), index


def _moving(arguments: Sequence[sp.Symbol]) -> list[sp.Symbol | None]:
    """Name the arguments that change along a row."""
    return [symbol if symbol in MOVING else None for symbol in arguments]


def _still(
    march: MarchWriter,
    row: ir.Value,
    arguments: Sequence[sp.Symbol],
    states: Sequence[sp.Symbol],
    updates: Sequence[sp.Expr],
    stages: Sequence[Definition],
    by: Sequence[sp.Symbol] = (),
) -> Writer:
    """Write what keeps still along a row, once for all of its samples: powers and exponentials take the most time."""
    known = march.arguments(
        [None if symbol in MOVING else symbol for symbol in arguments], row, ir.Constant(INTEGER, 0)
    )
    moving, on_the_way = {*MOVING, *states}, needed(stages, updates)
    for symbol, expression in on_the_way:
        if expression.free_symbols & moving:
            moving.add(symbol)
    writer = Writer(march.builder, known, stages, by)
    for expression in (*(expression for _, expression in on_the_way), *updates):
        for part in _largest_without(moving, expression):
            writer.value(part)
            if isinstance(part, sp.Expr):
                writer.slopes(part)
    return writer


def _largest_without(moving: set[sp.Symbol], expression: sp.Basic) -> Iterator[sp.Basic]:
    """Give the largest parts of an expression in which none of these symbols stands."""
    if expression.free_symbols & moving or isinstance(expression, ExprCondPair):
        for part in expression.args:
            yield from _largest_without(moving, part)
    elif expression.args:
        yield expression


def _reached(
    states: Sequence[sp.Symbol], updates: Sequence[sp.Expr], stages: Sequence[Definition]
) -> list[tuple[int, int]]:
    """Give the pairs of states of which the first depends on the second, in however many steps, and each on itself."""
    reached = np.eye(len(states), dtype=np.bool_)
    for place, used in enumerate(_used(updates, stages)):
        reached[place] |= [symbol in used for symbol in states]
    for between in range(len(states)):
        reached |= np.outer(reached[:, between], reached[between])
    return [(int(end), int(beginning)) for end, beginning in np.argwhere(reached)]


def _reached_from(
    by: Sequence[sp.Symbol],
    states: Sequence[sp.Symbol],
    updates: Sequence[sp.Expr],
    stages: Sequence[Definition],
) -> list[tuple[int, int]]:
    """Give the same of states that depend on other symbols, whose places are counted on after those of the states."""
    used, through = _used(updates, stages), _reached(states, updates, stages)
    pairs = {(end, place) for place, symbol in enumerate(by) for end, state in through if symbol in used[state]}
    return sorted((end, len(states) + place) for end, place in pairs)


def _used(updates: Sequence[sp.Expr], stages: Sequence[Definition]) -> list[set[sp.Basic]]:
    """Give the symbols that each update depends on, by way of the stages too."""
    return [
        set().union(*(part.free_symbols for _, part in needed(stages, [update])), update.free_symbols)
        for update in updates
    ]


def slopes_source(
    arguments: Sequence[sp.Symbol],
    by: Sequence[sp.Symbol],
    expressions: Sequence[sp.Expr],
    stages: Sequence[Definition],
) -> tuple[str, list[tuple[int, int]]]:
    """Write a march that gives the slopes of expressions, with the places of expression and symbol of each.

    Args:
        arguments: all that the expressions take.
        by: symbols that are differentiated by.
        expressions: what is differentiated.
        stages: what is computed on the way.
    """
    march = MarchWriter("slopes", len(arguments))
    index: list[tuple[int, int]] = []
    with march.through(march.rows) as row, march.through(march.samples) as sample:
        known = march.arguments(arguments, row, sample)
        writer = Writer(march.builder, known, stages, by)
        for place, expression in enumerate(expressions):
            slopes = writer.slopes(expression)
            for column, symbol in enumerate(by):
                if symbol in slopes:
                    march.write(len(index), row, slopes[symbol], sample)
                    index.append((place, column))
    return march.written(), index
