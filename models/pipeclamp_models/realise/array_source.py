"""Source of vectorised NumPy functions of a law's equations, with exact derivatives, written by SymPy."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import sympy as sp
from sympy.printing.numpy import NumPyPrinter

from pipeclamp_models.base.kept import kept
from pipeclamp_models.equations import symbols
from pipeclamp_models.law.compose import Composed
from pipeclamp_models.realise.bounded import bounded
from pipeclamp_models.realise.scalar import PRODUCTS, ScalarPrinter
from pipeclamp_models.realise.slopes import StageSlopes, in_order, needed, slope_of, slopes_through
from pipeclamp_models.realise.stepping import Definition, exact, held_apart

FAST = tuple(signal.symbol for signal in symbols.FAST if signal.symbol is not symbols.x)
SMOOTHING = (symbols.v_r, symbols.y_r)
MOVING = frozenset({symbols.y, symbols.v, symbols.a, symbols.y_previous})
"""What changes from step to step of a march, besides its states and stages."""
Pair = tuple[int, int]
"""Places of what is differentiated, among its like, and of what it is differentiated by."""


WALK = """\
import math


def _larger(one, other):
    return one if one >= other or one != one else other


def _smaller(one, other):
    return one if one <= other or one != one else other


def step({arguments}):
{body}

def walk(start, after, columns):
    for row in range(after.shape[1]):
        {starts}
        for index in range(after.shape[2]):
            {columns}
            {states}, = step({arguments})
            {ends}
"""
"""A module that steps states along motions; what is no number stays none, as in NumPy."""


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


class StepPrinter(ScalarPrinter):
    """Print extrema in which what is no number stays none."""

    def _print_Max(self, expression: sp.Max) -> str:
        return self._nested("_larger", expression.args)

    def _print_Min(self, expression: sp.Min) -> str:
        return self._nested("_smaller", expression.args)

    def _nested(self, function: str, arguments: tuple[sp.Expr, ...]) -> str:
        text, *rest = map(self._print, arguments)
        for other in rest:
            text = f"{function}({text}, {other})"
        return str(text)


@bounded()
def array_source(equations: Composed, function: str) -> dict[str, Any]:
    """Give one function of a law, as JSON holds it.

    What a function has in common with that of another law is written once: an effect's states are stepped alike,
    whatever else the laws have.

    Args:
        equations: the composed law.
        function: one of the functions of `ArrayRealisation`.

    Returns:
        `source`, which defines one function; of derivatives `index` too: places of what is differentiated and of what
        it is differentiated by, of each that doesn't vanish. Of "walks" one entry for each set of states that are
        stepped by themselves: `states`, their places; `held`, a function of the update's arguments; `source`, that of
        `walk(start, after, columns)`; `columns`, which it takes of the update's arguments but for the states; what
        `held` gives comes after.
    """
    asked = _asked(equations, function)
    if function == "walks":
        return {"walks": [_walk(part, asked.states) for part in _stepped_apart(asked)]}
    return _named(asked, function)


def _named(asked: Asked, function: str) -> dict[str, Any]:
    """Write a function; an argument that doesn't stand in it has a name that says so."""
    lean, written = _lean(asked, function)
    names = dict(zip(lean.arguments, written["arguments"], strict=True))
    every = [names.get(symbol, f"_unused_{place}") for place, symbol in enumerate(asked.arguments)]
    source: dict[str, Any] = {"source": f"def {function}({', '.join(every)}):\n{written['body']}"}
    if "index" in written:
        taken = asked.symbols()
        places = [place for place, symbol in enumerate(asked.by) if symbol in taken]
        source["index"] = [(row, places[column]) for row, column in written["index"]]
    return source


def _lean(asked: Asked, function: str) -> tuple[Asked, dict[str, Any]]:
    """Give what is asked for without the symbols that don't stand in it, and what is written of it."""
    taken = asked.symbols()
    lean = replace(
        asked,
        arguments=[symbol for symbol in asked.arguments if symbol in taken],
        by=[symbol for symbol in asked.by if symbol in taken],
        states=[symbol for symbol in asked.states if symbol in taken],
    )
    return lean, kept(f"{function} {lean.content()}", lambda: _written(lean, function))


@dataclass(frozen=True)
class Asked:
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

    def content(self) -> str:
        """Tell all that a function is written from, the same for the same."""
        named = [*self.arguments, *(symbol for symbol, _ in self.stages)]
        return repr([[sp.srepr(each) for each in some] for some in (named, self.by, self.states, self._all())])

    def _all(self) -> list[sp.Expr]:
        return [*(expression for _, expression in self.stages), *self.expressions]


def _asked(equations: Composed, function: str) -> Asked:
    parameters = [parameter.symbol for parameter in equations.parameters]
    states = [state.symbol for state in equations.states]
    coefficients = [entry.symbol for entry in equations.coefficients]
    slow = [*sorted(equations.slow_signals, key=str), *parameters, *SMOOTHING]
    by = [*states, *coefficients, *parameters]
    fast = [*FAST, *by, *SMOOTHING]
    match function:
        case "coefficients" | "coefficient_slopes":
            return Asked(slow, [entry.expression for entry in equations.coefficients], by=parameters)
        case "force" | "force_with_slopes":
            return Asked(fast, [equations.force], by=by)
        case "update" | "update_slopes" | "walks":
            stages = [(stage.symbol, stage.expression) for stage in equations.stages]
            return Asked(fast, [state.update for state in equations.states], stages, by, states)
        case "energy":
            return Asked(fast, [equations.energy])
        case "lag" | "lag_slopes":
            return Asked(parameters, [equations.lag], by=parameters)
    raise ValueError(f"got {function!r}; expected a function of array realisations")


def _written(asked: Asked, function: str) -> dict[str, Any]:
    """Write a function: `arguments`, its names of them, `body`, the lines after the first, and `index`."""
    match function:
        case "coefficient_slopes" | "lag_slopes":
            index, slopes = _nonzero_slopes(asked.expressions, asked.by)
            return {**_source(asked.arguments, slopes), "index": index}
        case "force_with_slopes":
            index, slopes = _nonzero_slopes(asked.expressions, asked.by)
            return {**_source(asked.arguments, [*asked.expressions, *slopes]), "index": index}
        case "update_slopes":
            way, slopes_of_stages = slopes_through(asked.stages, asked.by)
            index, slopes = _nonzero_slopes(asked.expressions, asked.by, slopes_of_stages)
            return {**_source(asked.arguments, slopes, needed(way, slopes)), "index": index}
        case "held":
            return _source(asked.arguments, [expression for _, expression in _along_a_march(asked)[0]])
        case "step":
            held, stages, updates = _along_a_march(asked)
            return _source([*asked.arguments, *(symbol for symbol, _ in held)], updates, stages, numbers=True)
    return _source(asked.arguments, asked.expressions, asked.stages)


def _stepped_apart(asked: Asked) -> list[Asked]:
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


def _walk(asked: Asked, every: Sequence[sp.Symbol]) -> dict[str, Any]:
    """Write how a set of states is stepped along motions: see `array_source`.

    Args:
        asked: the set.
        every: the states of the law.
    """
    lean, written = _lean(asked, "step")
    names = dict(zip(lean.arguments, written["arguments"], strict=False))
    others = [symbol for symbol in asked.arguments if symbol not in every]
    taken = [symbol for symbol in lean.arguments if symbol not in asked.states]
    columns = [names[symbol] for symbol in taken] + written["arguments"][len(lean.arguments) :]
    states = [names.get(symbol, f"unread_{place}") for place, symbol in enumerate(asked.states)]
    source = WALK.format(
        arguments=", ".join(written["arguments"]),
        body=written["body"],
        starts="\n        ".join(f"{name} = start[{place}, row]" for place, name in enumerate(states)),
        columns="\n            ".join(f"{name} = columns[{place}][row, index]" for place, name in enumerate(columns)),
        states=", ".join(states),
        ends="\n            ".join(f"after[{place}, row, index] = {name}" for place, name in enumerate(states)),
    )
    return {
        "states": [every.index(symbol) for symbol in asked.states],
        "held": _named(asked, "held")["source"],
        "columns": [others.index(symbol) for symbol in taken],
        "source": source,
    }


def _along_a_march(asked: Asked) -> tuple[list[Definition], list[Definition], list[sp.Expr]]:
    """Set apart what stands still from step to step; give it with its symbols, and stages and updates in these."""
    names = [symbol for symbol, _ in asked.stages]
    within = [exact(expression) for expression in (*(expression for _, expression in asked.stages), *asked.expressions)]
    found, reduced = held_apart(within, {*MOVING, *asked.states, *names})
    held = [(symbol, expression) for symbol, expression in found if symbol != expression]
    return held, list(zip(names, reduced[: len(names)], strict=True)), reduced[len(names) :]


def _source(
    arguments: Sequence[sp.Symbol],
    expressions: Sequence[sp.Expr],
    before: Sequence[Definition] = (),
    *,
    numbers: bool = False,
) -> dict[str, Any]:
    """Write a function of arrays or of plain numbers, with what is computed before the results, in order.

    That of arrays gives a list, that of numbers a tuple, which compilers prefer.
    """
    settings = {"fully_qualified_modules": numbers, "inline": True, "allow_unknown_functions": True}
    printer = StepPrinter(settings) if numbers else ArrayPrinter(settings)
    with_references = [exact(expression) for expression in expressions]
    # Numbered names for arguments: no effect's symbol can then hide a function of NumPy or a common part, and terms
    # stand in the arguments' order. SymPy's dummies would do the first, but are numbered by what was done before.
    named = {symbol: sp.Symbol(f"_{place:03d}") for place, symbol in enumerate(arguments)}

    def common_parts(whole: Sequence[sp.Expr]) -> tuple[list[Definition], Sequence[sp.Expr]]:
        parts, reduced = in_order([(symbol, exact(expression)) for symbol, expression in before], whole)
        results = [part.xreplace(named) for part in reduced]
        return [(symbol, part.xreplace(named)) for symbol, part in parts], tuple(results) if numbers else results

    function = sp.lambdify(
        list(named.values()),
        with_references,
        modules=[{}],
        printer=printer,
        cse=common_parts,
    )
    body = inspect.getsource(function).partition("\n")[2]
    return {"arguments": [str(symbol) for symbol in named.values()], "body": body}


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
