"""Expressions in the language of LLVM, each value with its slopes: what becomes machine code within a moment.

Slopes are carried along by the rules of differentiation, number by number, so that no derivative grows as a formula.
At a kink the slope is that of the side that the value is taken from.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial, reduce
from typing import TypeVar

import numpy as np
import sympy as sp
from llvmlite import ir
from sympy.codegen.cfunctions import expm1

from pipeclamp_models.equations import symbols
from pipeclamp_models.realise.machine import LIBRARY
from pipeclamp_models.realise.scalar import PRODUCTS
from pipeclamp_models.realise.slopes import needed
from pipeclamp_models.realise.stepping import Definition

DOUBLE, INTEGER, BYTE = ir.DoubleType(), ir.IntType(64), ir.IntType(8)
ADDRESS = ir.PointerType()
INTRINSICS = frozenset({"sqrt", "fabs", "exp", "log", "pow", "sin", "cos"})
"""Functions that LLVM knows itself; others are the C library's."""
COMPARISONS: Mapping[type[sp.Rel], str] = {
    sp.StrictLessThan: "<", sp.LessThan: "<=", sp.StrictGreaterThan: ">", sp.GreaterThan: ">=", sp.Equality: "==",
}  # fmt: skip

Key = TypeVar("Key")
Slopes = Mapping[sp.Symbol, ir.Value]
"""Slopes of a value by some symbols; those that aren't there vanish."""


class Writer:
    """Writes values of expressions, and their slopes, where a builder stands; what was written once is used again.

    Attributes:
        builder: of the function.
        definitions: what symbols stand for whose values aren't known.
        by: symbols that are differentiated by.
    """

    def __init__(
        self,
        builder: ir.IRBuilder,
        known: Mapping[sp.Symbol, ir.Value],
        definitions: Sequence[Definition] = (),
        by: Sequence[sp.Symbol] = (),
    ) -> None:
        self.builder = builder
        self.definitions = dict(definitions)
        self.by = frozenset(by)
        self._values: dict[sp.Basic, ir.Value] = dict(known)
        self._slopes: dict[sp.Basic, Slopes] = {symbol: {} for symbol in known}
        self._slopes |= {symbol: {symbol: _number(1.0)} for symbol in self.by & set(known)}

    def value(self, expression: sp.Basic) -> ir.Value:
        """Write the value of an expression, or the truth of a comparison."""
        if expression not in self._values:
            self._values[expression] = self._written(expression)
        return self._values[expression]

    def slopes(self, expression: sp.Expr) -> Slopes:
        """Write the slopes of an expression."""
        if expression not in self._slopes:
            self._slopes[expression] = self._differentiated(expression)
        return self._slopes[expression]

    def size(self, value: ir.Value) -> ir.Value:
        """Write how large a value is, whatever its sign."""
        return self._call("fabs", value)

    def _written(self, one: sp.Basic) -> ir.Value:
        builder = self.builder
        match one:
            case sp.Symbol() if one in self.definitions:
                return self.value(self.definitions[one])
            case sp.Symbol():
                return _number(float(symbols.REFERENCES[one]))
            case sp.Number() | sp.NumberSymbol():
                return _number(float(one))
            case sp.Add():
                return reduce(builder.fadd, map(self.value, one.args))
            case sp.Mul():
                return reduce(builder.fmul, map(self.value, one.args))
            case sp.Pow():
                return self._power(self.value(one.base), one.exp)
            case sp.Abs():
                return self._call("fabs", self.value(one.args[0]))
            case sp.sign():
                argument = self.value(one.args[0])
                above, below = (builder.fcmp_ordered(side, argument, _number(0.0)) for side in (">", "<"))
                return builder.fsub(builder.uitofp(above, DOUBLE), builder.uitofp(below, DOUBLE))
            case sp.Max() | sp.Min():
                return self._extremum(one)
            case sp.Piecewise():
                return self._chosen(one, self.value)
            case sp.And() | sp.Or():
                join = builder.and_ if isinstance(one, sp.And) else builder.or_
                return reduce(join, map(self.value, one.args))
            case sp.Not():
                return builder.not_(self.value(one.args[0]))
            case sp.logic.boolalg.BooleanAtom():
                return ir.Constant(ir.IntType(1), bool(one))
            case sp.Unequality():
                return builder.fcmp_unordered("!=", *map(self.value, one.args))
            case sp.Rel():
                return builder.fcmp_ordered(COMPARISONS[type(one)], *map(self.value, one.args))
        return self._call(one.func.__name__, *map(self.value, one.args))

    def _differentiated(self, one: sp.Expr) -> Slopes:
        if not self.by or (not one.args and one not in self.definitions):
            return {}
        match one:
            case sp.Symbol():
                return self.slopes(self.definitions[one])
            case sp.Add():
                return self._sum(map(self.slopes, one.args))
            case sp.Mul():
                return self._sum(self._times(self._without(one, place), part) for place, part in enumerate(one.args))
            case sp.Pow():
                return self._of_power(one)
            case sp.sign():
                return {}
            case sp.Max() | sp.Min():
                return self._of_extremum(one)
            case sp.Piecewise():
                used = {symbol for value, _ in one.args for symbol in self.slopes(value)}
                return {symbol: self._chosen(one, partial(self._slope, symbol)) for symbol in _ordered(used)}
        return self._times(lambda: self._factor(one), one.args[0])

    def _slope(self, symbol: sp.Symbol, expression: sp.Expr) -> ir.Value:
        return self.slopes(expression).get(symbol, _number(0.0))

    def _sum(self, several: Iterator[Slopes]) -> Slopes:
        total: dict[sp.Symbol, ir.Value] = {}
        for slopes in several:
            for symbol, slope in slopes.items():
                total[symbol] = self.builder.fadd(total[symbol], slope) if symbol in total else slope
        return total

    def _times(self, factor: Callable[[], ir.Value], inner: sp.Expr) -> Slopes:
        """Write the slopes of what has an inner expression, by which its own slope is `factor`."""
        slopes = self.slopes(inner)
        if not slopes:
            return {}
        value = factor()
        return {symbol: self.builder.fmul(value, slope) for symbol, slope in slopes.items()}

    def _without(self, product: sp.Mul, place: int) -> Callable[[], ir.Value]:
        others = [factor for other, factor in enumerate(product.args) if other != place]
        return lambda: reduce(self.builder.fmul, map(self.value, others))

    def _factor(self, one: sp.Expr) -> ir.Value:
        """Write the slope of a function by its argument."""
        builder, argument = self.builder, self.value(one.args[0])
        match one:
            case sp.Abs():
                below = builder.fcmp_ordered("<", argument, _number(0.0))
                return builder.select(below, _number(-1.0), _number(1.0))
            case sp.exp():
                return self.value(one)
            case expm1():
                return self._call("exp", argument)
            case sp.log():
                return builder.fdiv(_number(1.0), argument)
            case sp.sin():
                return self._call("cos", argument)
            case sp.cos():
                return builder.fneg(self._call("sin", argument))
            case sp.tan():
                return builder.fadd(_number(1.0), self._square(self.value(one)))
            case sp.atan():
                return builder.fdiv(_number(1.0), builder.fadd(_number(1.0), self._square(argument)))
            case sp.tanh():
                return builder.fsub(_number(1.0), self._square(self.value(one)))
        raise NotImplementedError(f"the slope of {one.func.__name__}")

    def _square(self, value: ir.Value) -> ir.Value:
        return self.builder.fmul(value, value)

    def _power(self, base: ir.Value, exponent: sp.Expr) -> ir.Value:
        builder = self.builder
        if exponent.is_Number and exponent < 0:
            return builder.fdiv(_number(1.0), self._power(base, -exponent))
        if exponent == sp.Rational(1, 2):
            return self._call("sqrt", base)
        if exponent == 1 or exponent in PRODUCTS:
            return reduce(builder.fmul, [base] * int(exponent))
        return self._call("pow", base, self.value(exponent))

    def _of_power(self, one: sp.Pow) -> Slopes:
        base, exponent = one.base, one.exp
        builder = self.builder
        by_base = self._times(
            lambda: builder.fmul(self.value(exponent), self._power(self.value(base), exponent - 1)), base
        )

        def by_exponent() -> ir.Value:
            # x^e log x vanishes where x does
            whole = self.value(one)
            steep = builder.fmul(whole, self._call("log", self.value(base)))
            return builder.select(builder.fcmp_ordered("==", whole, _number(0.0)), whole, steep)

        return self._sum(iter((by_base, self._times(by_exponent, exponent))))

    def _extremum(self, one: sp.Max | sp.Min) -> ir.Value:
        """Write the largest or smallest of several; what is no number stays none."""
        value = self.value(one.args[0])
        for other in one.args[1:]:
            value = self.builder.select(self._stays(one, value, other), value, self.value(other))
        return value

    def _of_extremum(self, one: sp.Max | sp.Min) -> Slopes:
        value, slopes = self.value(one.args[0]), self.slopes(one.args[0])
        for other in one.args[1:]:
            stays, rivals, zero = self._stays(one, value, other), self.slopes(other), _number(0.0)
            slopes = {
                symbol: self.builder.select(stays, slopes.get(symbol, zero), rivals.get(symbol, zero))
                for symbol in {**slopes, **rivals}
            }
            value = self.builder.select(stays, value, self.value(other))
        return slopes

    def _stays(self, one: sp.Max | sp.Min, value: ir.Value, other: sp.Expr) -> ir.Value:
        builder = self.builder
        beyond = builder.fcmp_ordered(">=" if isinstance(one, sp.Max) else "<=", value, self.value(other))
        return builder.or_(beyond, builder.fcmp_unordered("!=", value, value))

    def _chosen(self, choice: sp.Piecewise, what: Callable[[sp.Expr], ir.Value]) -> ir.Value:
        """Write what belongs to the first branch whose condition holds."""
        chosen = _number(float("nan"))
        for expression, condition in reversed(choice.args):
            chosen = what(expression) if condition == sp.true else self.builder.select(
                self.value(condition), what(expression), chosen
            )  # fmt: skip
        return chosen

    def _call(self, name: str, *arguments: ir.Value) -> ir.Value:
        module = self.builder.module
        if name in INTRINSICS:
            function = module.declare_intrinsic(
                f"llvm.{name}", [DOUBLE], ir.FunctionType(DOUBLE, [DOUBLE] * len(arguments))
            )
        elif name in LIBRARY:
            function = module.globals.get(name) or ir.Function(module, ir.FunctionType(DOUBLE, [DOUBLE]), name)
        else:
            raise NotImplementedError(f"machine code of {name}")
        return self.builder.call(function, arguments)


def _number(value: float) -> ir.Constant:
    return ir.Constant(DOUBLE, value)


def _ordered(some: set[sp.Symbol]) -> list[sp.Symbol]:
    return sorted(some, key=str)


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

    def arguments(self, names: Sequence[sp.Symbol], row: ir.Value, sample: ir.Value) -> dict[sp.Symbol, ir.Value]:
        """Read the arguments at a sample, named in their order."""
        builder, found = self.builder, []
        for address, by_row, by_sample in self._columns:
            away = builder.add(builder.mul(row, by_row), builder.mul(sample, by_sample))
            found.append(builder.load(builder.gep(address, [away], source_etype=BYTE), typ=DOUBLE))
        return dict(zip(names, found, strict=True))

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
    What is taken is as of `walk_source`; places of end and beginning of each slope that doesn't vanish come with it.
    """
    march = MarchWriter("turn", len(arguments))
    builder, index = march.builder, _reached(states, updates, stages)
    kept, largest, product = march.held(states), march.held(states), march.held(index)
    with march.through(march.rows) as row:
        march.begin(kept, row)
        for address in largest.values():
            builder.store(_number(0.0), address)
        for (end, beginning), address in product.items():
            builder.store(_number(float(end == beginning)), address)
        with march.through(march.samples) as sample:
            so_far = march.read(product)
            known = {**march.arguments(arguments, row, sample), **march.read(kept)}
            writer = Writer(builder, known, stages, states)
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
                builder.store(reduce(builder.fadd, terms, _number(0.0)), product[end, beginning])
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

    The slopes are by the states before the first sample, and by others of the arguments, which keep still: the steps'
    slopes, gathered on the way. What is taken is as of `walk_source`; of each slope that doesn't vanish the places come
    with it, of the state and of what it is differentiated by, among the states and, after them, the others.
    """
    march = MarchWriter("course", len(arguments))
    builder = march.builder
    index = [*_reached(states, updates, stages), *_reached_from(by, states, updates, stages)]
    kept, gathered = march.held(states), march.held(index)
    with march.through(march.rows) as row:
        march.begin(kept, row)
        for (state, source), address in gathered.items():
            builder.store(_number(float(state == source)), address)
        with march.through(march.samples) as sample:
            so_far = march.read(gathered)
            known = {**march.arguments(arguments, row, sample), **march.read(kept)}
            writer = Writer(builder, known, stages, [*states, *by])
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
                slope = reduce(builder.fadd, terms, _number(0.0))
                builder.store(slope, gathered[end, source])
                march.write(result, row, slope, sample)
    return march.written(), index


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
