"""Source of vectorised NumPy functions of a law's equations, with exact derivatives, written by SymPy."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import sympy as sp
from sympy.printing.numpy import NumPyPrinter

from pipeclamp_models.base.kept import kept
from pipeclamp_models.equations import symbols
from pipeclamp_models.equations.replacing import replaced
from pipeclamp_models.law.compose import Composed
from pipeclamp_models.realise.bounded import bounded
from pipeclamp_models.realise.marches import course_source, slopes_source, turn_source, walk_source
from pipeclamp_models.realise.scalar import PRODUCTS
from pipeclamp_models.realise.slopes import in_order, needed, slope_of
from pipeclamp_models.realise.stepping import Definition, exact

FAST = tuple(signal.symbol for signal in symbols.FAST if signal.symbol is not symbols.x)
SMOOTHING = (symbols.v_r, symbols.y_r)
SLOPES_ALONE = ("lag_slopes",)
"""Functions that give derivatives."""
WITH_SLOPES = ("coefficients_with_slopes", "force_with_slopes", *SLOPES_ALONE)
"""Functions that give derivatives, some after the values themselves."""
Pair = tuple[int, int]
"""Places of what is differentiated, among its like, and of what it is differentiated by."""


class ArrayPrinter(NumPyPrinter):  # type: ignore[misc]
    """Print branches as nested `where` and small powers as products, which is many times cheaper than otherwise."""

    def _print_Pow(self, expression: sp.Pow, rational: bool = False) -> str:
        base, exponent = expression.as_base_exp()
        if base.is_Symbol and exponent in PRODUCTS:
            return f"({'*'.join([self._print(base)] * int(exponent))})"
        return str(super()._print_Pow(expression, rational))

    def _print_Piecewise(self, expression: sp.Piecewise) -> str:
        *branches, (last, _) = expression.args
        text = self._print(last)
        for value, condition in reversed(branches):
            text = f"{self._module_format('numpy.where')}({self._print(condition)}, {self._print(value)}, {text})"
        return str(text)

    def _in_turn(self, function: str, arguments: tuple[sp.Basic, ...]) -> str:
        """Print a function of two as one of several: arrays of different shapes go together in it."""
        first, *rest = arguments
        text = self._print(first)
        for argument in rest:
            text = f"{self._module_format(function)}({text}, {self._print(argument)})"
        return str(text)

    def _print_Max(self, expression: sp.Max) -> str:
        return self._in_turn("numpy.maximum", expression.args)

    def _print_Min(self, expression: sp.Min) -> str:
        return self._in_turn("numpy.minimum", expression.args)

    def _print_And(self, expression: sp.And) -> str:
        return self._in_turn("numpy.logical_and", expression.args)

    def _print_Or(self, expression: sp.Or) -> str:
        return self._in_turn("numpy.logical_or", expression.args)


@bounded()
def array_source(equations: Composed, function: str) -> dict[str, Any]:
    """Give one function of a law, as JSON holds it.

    What a function has in common with that of another law is written once: an effect's states are stepped alike,
    whatever else the laws have.

    Args:
        equations: the composed law.
        function: one of the functions of `ArrayRealisation`.

    Returns:
        `parts`, each of what is written by itself. Of "walks", "turns", "courses" and "update_slopes" these are sets of
        states that need each other: `source` in LLVM's language; `columns`, what it takes of the update's arguments,
        but for slopes those without the states, whose places are `states`; of slopes, turns and courses `index`, the
        places of each that doesn't vanish: of the state, within the set but for slopes, and of what it is
        differentiated by, for turns a state of the set, else among all states, coefficients and parameters. Of the
        other functions they are the summands of the force, the coefficients, or sets of states: `source`, which defines
        one function of arrays; `columns`, what it takes of the arguments; `places`, to which of all results each of its
        own is added. These functions have an `index` of all their derivatives.
    """
    asked = _asked(equations, function)
    match function:
        case "walks":
            parts = [
                _marched(part, asked, "walk", lambda *of: {"source": walk_source(*of)})
                for part in _stepped_apart(asked)
            ]
        case "turns":
            parts = [_marched(part, asked, "turn", partial(_with_index, turn_source)) for part in _stepped_apart(asked)]
        case "courses":
            parts = [_course(part, asked) for part in _stepped_apart(asked)]
        case "update_slopes":
            parts = [_step_slopes(part, asked) for part in _stepped_apart(asked)]
        case _:
            return _in_parts(asked, function)
    return {"parts": parts}


def _in_parts(asked: AskedFunction, function: str) -> dict[str, Any]:
    """Write a function of arrays, each part of it by itself: see `array_source`."""
    parts = [(rows, _part(part, asked, function)) for rows, part in _apart(asked)]
    values = 0 if function in SLOPES_ALONE else len(asked.expressions)
    index = sorted({(rows[row], column) for rows, part in parts for row, column in part["index"]})
    places = {pair: values + place for place, pair in enumerate(index)}
    return {
        "results": values + len(index),
        "index": index,
        "parts": [
            {
                "source": part["source"],
                "columns": part["columns"],
                "places": [*(rows if values else ()), *(places[rows[row], column] for row, column in part["index"])],
            }
            for rows, part in parts
        ],
    }


def _part(part: AskedFunction, asked: AskedFunction, function: str) -> dict[str, Any]:
    """Write a part: `source`, its columns of all arguments, and the `index` of its derivatives."""
    lean = part.lean()
    written = kept(f"{function} {lean.content()}", lambda: _written(lean, function))
    return {
        "source": written["source"],
        "columns": [asked.arguments.index(symbol) for symbol in lean.arguments],
        "index": [(row, asked.by.index(lean.by[column])) for row, column in written["index"]],
    }


@dataclass(frozen=True)
class AskedFunction:
    """What a function is asked for.

    Attributes:
        arguments: of the function, in order.
        expressions: the results, or what is differentiated.
        stages: what is computed before, in order.
        by: what is differentiated by, in order.
        states: those that are stepped.
    """

    arguments: Sequence[sp.Symbol]
    expressions: Sequence[sp.Expr]
    stages: Sequence[Definition] = ()
    by: Sequence[sp.Symbol] = ()
    states: Sequence[sp.Symbol] = ()

    def symbols(self) -> set[sp.Symbol]:
        """Give all symbols that stand in it."""
        return set().union(*(each.free_symbols for each in self._all()))

    def lean(self) -> AskedFunction:
        """Give the same without the symbols that don't stand in it."""
        taken = self.symbols()
        return replace(
            self,
            arguments=[symbol for symbol in self.arguments if symbol in taken],
            by=[symbol for symbol in self.by if symbol in taken],
            states=[symbol for symbol in self.states if symbol in taken],
        )

    def content(self) -> str:
        """Tell all that a function is written from, the same for the same."""
        named = [*self.arguments, *(symbol for symbol, _ in self.stages)]
        return repr([[sp.srepr(each) for each in some] for some in (named, self.by, self.states, self._all())])

    def _all(self) -> list[sp.Expr]:
        return [*(expression for _, expression in self.stages), *self.expressions]


def _asked(equations: Composed, function: str) -> AskedFunction:
    parameters = [parameter.symbol for parameter in equations.parameters]
    states = [state.symbol for state in equations.states]
    coefficients = [entry.symbol for entry in equations.coefficients]
    slow = [*sorted(equations.slow_signals, key=str), *parameters, *SMOOTHING]
    by = [*states, *coefficients, *parameters]
    fast = [*FAST, *by, *SMOOTHING]
    match function:
        case "coefficients" | "coefficients_with_slopes":
            return AskedFunction(slow, [entry.expression for entry in equations.coefficients], by=parameters)
        case "force" | "force_with_slopes":
            return AskedFunction(fast, [equations.force], by=by)
        case "update" | "update_slopes" | "walks" | "turns" | "courses":
            stages = [(stage.symbol, stage.expression) for stage in equations.stages]
            by = states if function == "update_slopes" else by
            return AskedFunction(fast, [state.update for state in equations.states], stages, by, states)
        case "energy":
            return AskedFunction(fast, [equations.energy])
        case "lag" | "lag_slopes":
            return AskedFunction(parameters, [equations.lag], by=parameters)
    raise ValueError(f"got {function!r}; expected a function of array realisations")


def _written(asked: AskedFunction, function: str) -> dict[str, Any]:
    """Write a function of arrays: `source`, and the `index` of what it gives derivatives of."""
    index, slopes = _nonzero_slopes(asked.expressions, asked.by) if function in WITH_SLOPES else ((), [])
    values = () if function in SLOPES_ALONE else asked.expressions
    return {"source": _source(asked.arguments, [*values, *slopes], asked.stages), "index": index}


def _apart(asked: AskedFunction) -> list[tuple[list[int], AskedFunction]]:
    """Give the summands of what is asked for, or its sets of states, each with its places among the results."""
    if asked.states:
        return [([asked.states.index(symbol) for symbol in part.states], part) for part in _stepped_apart(asked)]
    return [
        ([row], replace(asked, expressions=[summand]))
        for row, expression in enumerate(asked.expressions)
        for summand in sp.Add.make_args(expression)
    ]


def _stepped_apart(asked: AskedFunction) -> list[AskedFunction]:
    """Give the states in sets that are stepped by themselves, each with the stages that it needs."""
    sets: list[set[sp.Symbol]] = []
    for symbol, update in zip(asked.states, asked.expressions, strict=True):
        way = [expression for _, expression in needed(asked.stages, [update])]
        used = {symbol}.union(*(expression.free_symbols for expression in (update, *way))) & set(asked.states)
        sets = [*(one for one in sets if not one & used), used.union(*(one for one in sets if one & used))]
    updates = dict(zip(asked.states, asked.expressions, strict=True))
    found = []
    for one in sets:
        states = [symbol for symbol in asked.states if symbol in one]
        own = [updates[symbol] for symbol in states]
        found.append(replace(asked, expressions=own, stages=needed(asked.stages, own), states=states))
    return found


def _marched(
    part: AskedFunction, asked: AskedFunction, name: str, write: Callable[..., Mapping[str, Any]]
) -> dict[str, Any]:
    """Write a march of a set of states, with the places of the states and of what it takes: see `array_source`."""
    lean = part.lean()
    taken = [symbol for symbol in lean.arguments if symbol not in part.states]
    others = [symbol for symbol in asked.arguments if symbol not in asked.states]
    return {
        "states": [asked.states.index(symbol) for symbol in part.states],
        "columns": [others.index(symbol) for symbol in taken],
        **kept(
            f"{name} {[*map(str, part.states)]} {lean.content()}",
            lambda: write(taken, part.states, lean.expressions, lean.stages),
        ),
    }


def _course(part: AskedFunction, asked: AskedFunction) -> dict[str, Any]:
    """Write the course of a set of states, with its slopes: see `array_source`."""
    others = [symbol for symbol in part.lean().by if symbol not in part.states]
    written = _marched(part, asked, "course", partial(_with_index, partial(course_source, by=others)))
    by = [*part.states, *others]
    return {**written, "index": [(row, asked.by.index(by[column])) for row, column in written["index"]]}


def _with_index(write: Callable[..., tuple[str, list[Pair]]], *of: Any) -> dict[str, Any]:
    """Write a march that gives slopes, with their places."""
    source, index = write(*of)
    return {"source": source, "index": index}


def _step_slopes(part: AskedFunction, asked: AskedFunction) -> dict[str, Any]:
    """Write the slopes of a step of a set of states by those before it: see `array_source`."""
    lean = part.lean()
    source, index = kept(
        f"slopes {lean.content()}", lambda: slopes_source(lean.arguments, lean.by, lean.expressions, lean.stages)
    )
    return {
        "columns": [asked.arguments.index(symbol) for symbol in lean.arguments],
        "source": source,
        "index": [(asked.states.index(part.states[row]), asked.by.index(lean.by[column])) for row, column in index],
    }


def _source(arguments: Sequence[sp.Symbol], expressions: Sequence[sp.Expr], before: Sequence[Definition] = ()) -> str:
    """Write a function of arrays that gives a list, with what is computed before the results, in order."""
    printer = ArrayPrinter({"fully_qualified_modules": False, "inline": True, "allow_unknown_functions": True})
    with_references = [exact(expression) for expression in expressions]
    # Numbered names for arguments: no effect's symbol can then hide a function of NumPy or a common part, and terms
    # stand in the arguments' order. SymPy's dummies would do the first, but are numbered by what was done before.
    named = {symbol: sp.Symbol(f"_{place:03d}") for place, symbol in enumerate(arguments)}

    def common_parts(whole: Sequence[sp.Expr]) -> tuple[list[Definition], Sequence[sp.Expr]]:
        parts, reduced = in_order([(symbol, exact(expression)) for symbol, expression in before], whole)
        return [(symbol, replaced(part, named)) for symbol, part in parts], [replaced(part, named) for part in reduced]

    function = sp.lambdify(
        list(named.values()),
        with_references,
        modules=[{}],
        printer=printer,
        cse=common_parts,
    )
    return inspect.getsource(function)


def _nonzero_slopes(expressions: Sequence[sp.Expr], by: Sequence[sp.Symbol]) -> tuple[tuple[Pair, ...], list[sp.Expr]]:
    """Give the derivatives of expressions by symbols that don't vanish, and their (expression, symbol) indices."""
    index: list[Pair] = []
    slopes: list[sp.Expr] = []
    for row, expression in enumerate(expressions):
        for column, symbol in enumerate(by):
            slope = slope_of(expression, symbol, {})
            if slope is not None:
                index.append((row, column))
                slopes.append(slope)
    return tuple(index), slopes
