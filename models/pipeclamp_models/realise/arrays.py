"""Equations as vectorised NumPy functions with exact derivatives, compiled by SymPy."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from sympy.printing.numpy import NumPyPrinter

from pipeclamp_models.equations import symbols
from pipeclamp_models.law.law import Equations
from pipeclamp_models.realise.scalar import ScalarPrinter
from pipeclamp_models.realise.slopes import StageSlopes, in_order, needed, slope_of, slopes_through
from pipeclamp_models.realise.stepping import Definition, exact

NUMPY: Mapping[str, Any] = {name: value for name, value in vars(np).items() if not name.startswith("_")}
"""What compiled equations may call; for NumPy's mere name SymPy would load all of its packages, f2py among them."""
Compiled = Callable[..., Sequence[Any]]
Pair = tuple[int, int]
"""Places of what is differentiated, among its like, and of what it is differentiated by."""


class Slopes(NamedTuple):
    """Derivatives that don't vanish, each of a result by a state, a coefficient or a parameter."""

    by_state: Mapping[Pair, Any]
    by_coefficient: Mapping[Pair, Any]
    by_parameter: Mapping[Pair, Any]

    def filled(self, values: Sequence[Any]) -> Slopes:
        """Give values in place of their positions in a list."""
        return Slopes(*({pair: values[position] for pair, position in block.items()} for block in self))


class ArrayPrinter(NumPyPrinter):  # type: ignore[misc]
    """Print branches as nested `where`, which is many times cheaper than `select`."""

    def _print_Piecewise(self, expression: sp.Piecewise) -> str:
        *branches, (last, _) = expression.args
        text = self._print(last)
        for value, condition in reversed(branches):
            text = f"{self._module_format('numpy.where')}({self._print(condition)}, {self._print(value)}, {text})"
        return str(text)

    def _extremum(self, function: str, arguments: tuple[sp.Expr, ...]) -> str:
        first, *rest = arguments
        text = self._print(first)
        for argument in rest:
            text = f"{self._module_format(function)}({text}, {self._print(argument)})"
        return str(text)

    def _print_Max(self, expression: sp.Max) -> str:
        return self._extremum("numpy.maximum", expression.args)

    def _print_Min(self, expression: sp.Min) -> str:
        return self._extremum("numpy.minimum", expression.args)


class ArrayRealisation:
    """Functions of one set of equations, each compiled when it is first asked for.

    Arguments of `coefficients` are the slow signals, the parameters and v_r, y_r; `force` takes the fast signals,
    the states, the coefficients, the parameters and v_r, y_r; `update` the same as `force`; `lag` the parameters. The
    derivative functions return a list; the matching index, or places, say what stands where; what is absent is zero.
    """

    def __init__(self, equations: Equations) -> None:
        self._equations = equations
        self._parameters = [parameter.symbol for parameter in equations.parameters]
        self._states = [state.symbol for state in equations.states]
        self._updates = [state.update for state in equations.states]
        self._stages = [(stage.symbol, stage.expression) for stage in equations.stages]
        self._coefficients = [entry.symbol for entry in equations.coefficients]
        self._expressions = [entry.expression for entry in equations.coefficients]
        slow = sorted(equations.slow_signals, key=str)
        smoothing = [symbols.v_r, symbols.y_r]
        self._slow_arguments = [*slow, *self._parameters, *smoothing]
        self._fast_arguments = [*FAST_ARGUMENTS, *self._states, *self._coefficients, *self._parameters, *smoothing]
        self.slow = tuple(str(symbol) for symbol in slow)

    @cached_property
    def coefficients(self) -> Compiled:
        """The coefficients."""
        return _compile(self._slow_arguments, self._expressions)

    @cached_property
    def _coefficient_slopes(self) -> tuple[tuple[Pair, ...], list[sp.Expr]]:
        return _nonzero_slopes(self._expressions, self._parameters)

    @property
    def coefficient_slope_index(self) -> tuple[Pair, ...]:
        """(coefficient, parameter) of each of `coefficient_slopes`."""
        return self._coefficient_slopes[0]

    @cached_property
    def coefficient_slopes(self) -> Compiled:
        """The coefficients' derivatives by the parameters."""
        return _compile(self._slow_arguments, self._coefficient_slopes[1])

    @cached_property
    def force(self) -> Compiled:
        """The force in N, of states after their update."""
        return _compile(self._fast_arguments, [self._equations.force])

    @cached_property
    def _force_slopes(self) -> tuple[Slopes, list[sp.Expr]]:
        index, found = _nonzero_slopes([self._equations.force], self._by)
        return self._places(index), found

    @property
    def force_slope_places(self) -> Slopes:
        """Where each derivative stands in `force_slopes`; the force is result 0."""
        return self._force_slopes[0]

    @cached_property
    def force_slopes(self) -> Compiled:
        """The force's derivatives by states, coefficients and parameters."""
        return _compile(self._fast_arguments, self._force_slopes[1])

    @cached_property
    def update(self) -> Compiled:
        """The states after a step."""
        return _compile(self._fast_arguments, self._updates, self._stages)

    @cached_property
    def _update_slopes(self) -> tuple[Slopes, list[sp.Expr], list[Definition]]:
        by = self._by
        stages, slopes_of_stages = slopes_through(self._stages, by)
        index, found = _nonzero_slopes(self._updates, by, slopes_of_stages)
        return self._places(index), found, needed(stages, found)

    @property
    def update_slope_places(self) -> Slopes:
        """Where each derivative stands in `update_slopes`; results are the states after a step."""
        return self._update_slopes[0]

    @cached_property
    def update_slopes(self) -> Compiled:
        """The derivatives of the states after a step."""
        return _compile(self._fast_arguments, self._update_slopes[1], self._update_slopes[2])

    @cached_property
    def update_of_numbers(self) -> Compiled:
        """The states after a step, of plain numbers; raises what Python's arithmetic raises."""
        return _compile(self._fast_arguments, self._updates, self._stages, numbers=True)

    @cached_property
    def energy(self) -> Compiled:
        """The stored energy in N mm."""
        return _compile(self._fast_arguments, [self._equations.energy])

    @property
    def in_time(self) -> bool:
        """Whether the measured force has no lag."""
        return bool(self._equations.lag == 0)

    @cached_property
    def lag(self) -> Compiled:
        """The time in s by which the measured force is late."""
        return _compile(self._parameters, [self._equations.lag])

    @cached_property
    def _lag_slopes(self) -> tuple[tuple[Pair, ...], list[sp.Expr]]:
        return _nonzero_slopes([self._equations.lag], self._parameters)

    @property
    def lag_slope_index(self) -> tuple[int, ...]:
        """Parameter of each of `lag_slopes`."""
        return tuple(column for _, column in self._lag_slopes[0])

    @cached_property
    def lag_slopes(self) -> Compiled:
        """The lag's derivatives by the parameters."""
        return _compile(self._parameters, self._lag_slopes[1])

    @property
    def _by(self) -> list[sp.Symbol]:
        """What changes within a step is differentiated by these."""
        return [*self._states, *self._coefficients, *self._parameters]

    def _places(self, index: Sequence[Pair]) -> Slopes:
        """Give where each derivative by a state, a coefficient or a parameter stands."""
        coefficients, parameters = len(self._states), len(self._states) + len(self._coefficients)
        by_state: dict[Pair, int] = {}
        by_coefficient: dict[Pair, int] = {}
        by_parameter: dict[Pair, int] = {}
        for position, (result, column) in enumerate(index):
            if column < coefficients:
                by_state[result, column] = position
            elif column < parameters:
                by_coefficient[result, column - coefficients] = position
            else:
                by_parameter[result, column - parameters] = position
        return Slopes(by_state, by_coefficient, by_parameter)


FAST_ARGUMENTS = tuple(signal.symbol for signal in symbols.FAST if signal.symbol is not symbols.x)


def _compile(
    arguments: Sequence[sp.Symbol],
    expressions: Sequence[sp.Expr],
    before: Sequence[Definition] = (),
    *,
    numbers: bool = False,
) -> Compiled:
    """Compile expressions for arrays or for plain numbers, with what is computed before them, in order."""
    modules = {"math": math} if numbers else NUMPY
    settings = {"fully_qualified_modules": numbers, "inline": True, "allow_unknown_functions": True}
    printer = ScalarPrinter(settings) if numbers else ArrayPrinter(settings)
    with_references = [exact(expression) for expression in expressions]

    def common_parts(whole: Sequence[sp.Expr]) -> tuple[list[Definition], Sequence[sp.Expr]]:
        return in_order([(symbol, exact(expression)) for symbol, expression in before], whole)

    # Dummies for arguments: no effect's symbol can then hide a function of NumPy or a common part.
    compiled: Compiled = sp.lambdify(
        list(arguments), with_references, modules=modules, printer=printer, cse=common_parts, dummify=True
    )
    return compiled


def _nonzero_slopes(
    expressions: Sequence[sp.Expr], by: Sequence[sp.Symbol], through: StageSlopes | None = None
) -> tuple[tuple[Pair, ...], list[sp.Expr]]:
    """Give the derivatives that don't vanish and their (expression, symbol) indices.

    Args:
        expressions: what is differentiated.
        by: by these symbols.
        through: stages that the expressions are in, with their own derivatives.
    """
    index: list[Pair] = []
    slopes: list[sp.Expr] = []
    for row, expression in enumerate(expressions):
        for column, symbol in enumerate(by):
            slope = slope_of(expression, symbol, through or {})
            if slope is not None:
                index.append((row, column))
                slopes.append(slope)
    return tuple(index), slopes


@lru_cache(maxsize=128)
def realise(equations: Equations) -> ArrayRealisation:
    """Give the equations as array functions; the same equations are compiled once."""
    return ArrayRealisation(equations)
