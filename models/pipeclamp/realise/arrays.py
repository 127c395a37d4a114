"""Equations as vectorised NumPy functions with exact derivatives, compiled by SymPy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt
import sympy as sp
from sympy.printing.numpy import NumPyPrinter

from pipeclamp import symbols
from pipeclamp.law import Equations

Array = npt.NDArray[np.float64]
Compiled = Callable[..., Sequence[Any]]


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


@dataclass(frozen=True)
class ArrayRealisation:
    """Compiled functions of one set of equations.

    Arguments of `coefficients` are the slow signals, the parameters and v_r, y_r; `force` takes the fast signals,
    the states, the coefficients, the parameters and v_r, y_r; `update` the same as `force`; `lag` the parameters. The
    derivative functions
    return one entry for each pair in the matching index tuple; pairs that are absent are zero.
    """

    slow: tuple[str, ...]
    coefficients: Compiled
    coefficient_slopes: Compiled
    coefficient_slope_index: tuple[tuple[int, int], ...]
    force: Compiled
    force_slopes: Compiled
    force_slope_index: tuple[int, ...]
    update: Compiled
    update_with_slopes: Compiled
    update_slope_index: tuple[tuple[int, int], ...]
    energy: Compiled
    lag: Compiled
    lag_slopes: Compiled
    lag_slope_index: tuple[int, ...]


REFERENCES = {symbol: sp.sympify(value) for symbol, value in symbols.REFERENCES.items()}
FAST_ARGUMENTS = tuple(signal.symbol for signal in symbols.FAST if signal.symbol is not symbols.x)


def _compile(arguments: Sequence[sp.Symbol], expressions: Sequence[sp.Expr]) -> Compiled:
    printer = ArrayPrinter({"fully_qualified_modules": False, "inline": True, "allow_unknown_functions": True})
    with_references = [sp.sympify(expression).xreplace(REFERENCES) for expression in expressions]
    compiled: Compiled = sp.lambdify(list(arguments), with_references, modules="numpy", printer=printer, cse=True)
    return compiled


def _nonzero_slopes(
    expressions: Sequence[sp.Expr], by: Sequence[sp.Symbol]
) -> tuple[tuple[tuple[int, int], ...], list[sp.Expr]]:
    """Give the derivatives that don't vanish and their (expression, symbol) indices."""
    index: list[tuple[int, int]] = []
    slopes: list[sp.Expr] = []
    for row, expression in enumerate(expressions):
        for column, symbol in enumerate(by):
            if symbol in expression.free_symbols:
                index.append((row, column))
                slopes.append(sp.diff(expression, symbol))
    return tuple(index), slopes


@lru_cache(maxsize=128)
def realise(equations: Equations) -> ArrayRealisation:
    """Compile the equations; the same equations are compiled once."""
    parameters = [parameter.symbol for parameter in equations.parameters]
    smoothing = [symbols.v_r, symbols.y_r]
    slow = sorted(equations.slow_signals, key=str)
    coefficients = [entry.symbol for entry in equations.coefficients]
    coefficient_expressions = [entry.expression for entry in equations.coefficients]
    states = [state.symbol for state in equations.states]
    updates = [state.update for state in equations.states]
    slow_arguments = [*slow, *parameters, *smoothing]
    fast_arguments = [*FAST_ARGUMENTS, *states, *coefficients, *parameters, *smoothing]
    coefficient_index, coefficient_slopes = _nonzero_slopes(coefficient_expressions, parameters)
    # What the fast functions are differentiated by, in this order: states, coefficients, parameters.
    by = [*states, *coefficients, *parameters]
    force_index, force_slopes = _nonzero_slopes([equations.force], by)
    update_index, update_slopes = _nonzero_slopes(updates, by)
    lag_index, lag_slopes = _nonzero_slopes([equations.lag], parameters)
    return ArrayRealisation(
        slow=tuple(str(symbol) for symbol in slow),
        coefficients=_compile(slow_arguments, coefficient_expressions),
        coefficient_slopes=_compile(slow_arguments, coefficient_slopes),
        coefficient_slope_index=coefficient_index,
        force=_compile(fast_arguments, [equations.force]),
        force_slopes=_compile(fast_arguments, force_slopes),
        force_slope_index=tuple(column for _, column in force_index),
        update=_compile(fast_arguments, updates),
        update_with_slopes=_compile(fast_arguments, [*updates, *update_slopes]),
        update_slope_index=update_index,
        energy=_compile(fast_arguments, [equations.energy]),
        lag=_compile(parameters, [equations.lag]),
        lag_slopes=_compile(parameters, lag_slopes),
        lag_slope_index=tuple(column for _, column in lag_index),
    )
