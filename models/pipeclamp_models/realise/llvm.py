"""Expressions in the language of LLVM, each value with its slopes: what becomes machine code within a moment.

Slopes are carried along by the rules of differentiation, number by number, so that no derivative grows as a formula.
At a kink the slope is that of the side that the value is taken from.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial, reduce

import sympy as sp
from llvmlite import ir
from sympy.codegen.cfunctions import expm1

from pipeclamp_models.equations import symbols
from pipeclamp_models.realise.machine import LIBRARY
from pipeclamp_models.realise.scalar import PRODUCTS
from pipeclamp_models.realise.stepping import Definition

DOUBLE = ir.DoubleType()
INTRINSICS = frozenset({"sqrt", "fabs", "exp", "log", "pow", "sin", "cos"})
"""Functions that LLVM knows itself; others are the C library's."""
COMPARISONS: Mapping[type[sp.Rel], str] = {
    sp.StrictLessThan: "<", sp.LessThan: "<=", sp.StrictGreaterThan: ">", sp.GreaterThan: ">=", sp.Equality: "==",
}  # fmt: skip

Slopes = Mapping[sp.Symbol, ir.Value]
"""Slopes of a value by some symbols; those that aren't there vanish."""


class Writer:
    """Writes values of expressions, and their slopes, where a builder stands; what was written once is used again.

    Attributes:
        builder: of the function.
        definitions: what symbols stand for whose values aren't known.
        by: symbols that are differentiated by.
        outside: what was written before, outside of the loop that this one writes in.
    """

    def __init__(
        self,
        builder: ir.IRBuilder,
        known: Mapping[sp.Symbol, ir.Value],
        definitions: Sequence[Definition] = (),
        by: Sequence[sp.Symbol] = (),
        outside: Writer | None = None,
    ) -> None:
        self.builder = builder
        self.definitions = dict(definitions)
        self.by = frozenset(by)
        self._values: dict[sp.Basic, ir.Value] = {**(outside._values if outside else {}), **known}
        self._slopes: dict[sp.Basic, Slopes] = {
            **(outside._slopes if outside else {}),
            **{symbol: {} for symbol in known},
        }
        self._slopes |= {symbol: {symbol: number(1.0)} for symbol in self.by & set(known)}

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
                return number(float(symbols.REFERENCES[one]))
            case sp.Number() | sp.NumberSymbol():
                return number(float(one))
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
                above, below = (builder.fcmp_ordered(side, argument, number(0.0)) for side in (">", "<"))
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
        return self.slopes(expression).get(symbol, number(0.0))

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
                below = builder.fcmp_ordered("<", argument, number(0.0))
                return builder.select(below, number(-1.0), number(1.0))
            case sp.exp():
                return self.value(one)
            case expm1():
                return self._call("exp", argument)
            case sp.log():
                return builder.fdiv(number(1.0), argument)
            case sp.sin():
                return self._call("cos", argument)
            case sp.cos():
                return builder.fneg(self._call("sin", argument))
            case sp.tan():
                return builder.fadd(number(1.0), self._square(self.value(one)))
            case sp.atan():
                return builder.fdiv(number(1.0), builder.fadd(number(1.0), self._square(argument)))
            case sp.tanh():
                return builder.fsub(number(1.0), self._square(self.value(one)))
        raise NotImplementedError(f"the slope of {one.func.__name__}")

    def _square(self, value: ir.Value) -> ir.Value:
        return self.builder.fmul(value, value)

    def _power(self, base: ir.Value, exponent: sp.Expr) -> ir.Value:
        builder = self.builder
        if exponent.is_Number and exponent < 0:
            return builder.fdiv(number(1.0), self._power(base, -exponent))
        if exponent == sp.Rational(1, 2):
            return self._call("sqrt", base)
        if exponent == 1 or exponent in PRODUCTS:
            return reduce(builder.fmul, [base] * int(exponent))
        return self._call("pow", base, self.value(exponent))

    def _of_power(self, one: sp.Pow) -> Slopes:
        base, exponent = one.base, one.exp
        builder = self.builder
        by_base = self._times(lambda: builder.fmul(self.value(exponent), self._power_less_one(one)), base)

        def by_exponent() -> ir.Value:
            # x^e log x vanishes where x does
            whole = self.value(one)
            steep = builder.fmul(whole, self._call("log", self.value(base)))
            return builder.select(builder.fcmp_ordered("==", whole, number(0.0)), whole, steep)

        return self._sum(iter((by_base, self._times(by_exponent, exponent))))

    def _power_less_one(self, one: sp.Pow) -> ir.Value:
        """Write x^(e - 1): of an exponent that isn't a number as x^e/x, for a power takes as long as all beside it."""
        builder, base = self.builder, self.value(one.base)
        if one.exp.is_Number:
            return self._power(base, one.exp - 1)
        exponent, zero, one_alone = self.value(one.exp), number(0.0), number(1.0)
        above, below = (builder.fcmp_ordered(side, exponent, one_alone) for side in (">", "<"))
        at_zero = builder.select(above, zero, builder.select(below, number(math.inf), one_alone))
        return builder.select(builder.fcmp_ordered("==", base, zero), at_zero, builder.fdiv(self.value(one), base))

    def _extremum(self, one: sp.Max | sp.Min) -> ir.Value:
        """Write the largest or smallest of several; what is no number stays none."""
        value = self.value(one.args[0])
        for other in one.args[1:]:
            value = self.builder.select(self._stays(one, value, other), value, self.value(other))
        return value

    def _of_extremum(self, one: sp.Max | sp.Min) -> Slopes:
        value, slopes = self.value(one.args[0]), self.slopes(one.args[0])
        for other in one.args[1:]:
            stays, rivals, zero = self._stays(one, value, other), self.slopes(other), number(0.0)
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
        chosen = number(float("nan"))
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


def number(value: float) -> ir.Constant:
    """Write a number."""
    return ir.Constant(DOUBLE, value)


def _ordered(some: set[sp.Symbol]) -> list[sp.Symbol]:
    return sorted(some, key=str)
