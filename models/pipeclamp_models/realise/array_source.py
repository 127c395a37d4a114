"""Source of vectorised NumPy functions of a law's equations, with exact derivatives, written by SymPy."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import sympy as sp
from sympy.printing.numpy import NumPyPrinter

from pipeclamp_models.base.kept import kept
from pipeclamp_models.equations import symbols
from pipeclamp_models.law.compose import Composed
from pipeclamp_models.realise.bounded import bounded
from pipeclamp_models.realise.llvm import slopes_source, turn_source, walk_source
from pipeclamp_models.realise.scalar import PRODUCTS
from pipeclamp_models.realise.slopes import in_order, needed, slope_of
from pipeclamp_models.realise.stepping import Definition, exact

FAST = tuple(signal.symbol for signal in symbols.FAST if signal.symbol is not symbols.x)
SMOOTHING = (symbols.v_r, symbols.y_r)
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
        it is differentiated by, of each that doesn't vanish. Of "walks", "turns" and "update_slopes" one entry for each
        set of states that are stepped by themselves: `source` in LLVM's language; `columns`, what it takes of the
        update's arguments, for walks and turns those without the states, whose places are `states`; of slopes `index`,
        of turns too: end and beginning of each within the set.
    """
    asked = _asked(equations, function)
    if function == "walks":
        return {
            "walks": [
                _marched(part, asked, "walk", lambda *of: {"source": walk_source(*of)})
                for part in _stepped_apart(asked)
            ]
        }
    if function == "turns":
        return {"turns": [_marched(part, asked, "turn", _turn) for part in _stepped_apart(asked)]}
    if function == "update_slopes":
        return {"parts": [_step_slopes(part, asked) for part in _stepped_apart(asked)]}
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
    lean = asked.lean()
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

    def lean(self) -> Asked:
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
        case "update" | "update_slopes" | "walks" | "turns":
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


def _marched(part: Asked, asked: Asked, name: str, write: Callable[..., Mapping[str, Any]]) -> dict[str, Any]:
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


def _turn(*of: Any) -> dict[str, Any]:
    """Write what a whole motion makes of a set of states, with its slopes."""
    source, index = turn_source(*of)
    return {"source": source, "index": index}


def _step_slopes(part: Asked, asked: Asked) -> dict[str, Any]:
    """Write the slopes of a set of states that are stepped by themselves: see `array_source`."""
    lean = part.lean()
    source, index = kept(
        f"slopes {lean.content()}", lambda: slopes_source(lean.arguments, lean.by, lean.expressions, lean.stages)
    )
    return {
        "columns": [asked.arguments.index(symbol) for symbol in lean.arguments],
        "source": source,
        "index": [(asked.states.index(part.states[row]), asked.by.index(lean.by[column])) for row, column in index],
    }


def _source(
    arguments: Sequence[sp.Symbol], expressions: Sequence[sp.Expr], before: Sequence[Definition] = ()
) -> dict[str, Any]:
    """Write a function of arrays that gives a list, with what is computed before the results, in order."""
    printer = ArrayPrinter({"fully_qualified_modules": False, "inline": True, "allow_unknown_functions": True})
    with_references = [exact(expression) for expression in expressions]
    # Numbered names for arguments: no effect's symbol can then hide a function of NumPy or a common part, and terms
    # stand in the arguments' order. SymPy's dummies would do the first, but are numbered by what was done before.
    named = {symbol: sp.Symbol(f"_{place:03d}") for place, symbol in enumerate(arguments)}

    def common_parts(whole: Sequence[sp.Expr]) -> tuple[list[Definition], Sequence[sp.Expr]]:
        parts, reduced = in_order([(symbol, exact(expression)) for symbol, expression in before], whole)
        return [(symbol, part.xreplace(named)) for symbol, part in parts], [part.xreplace(named) for part in reduced]

    function = sp.lambdify(
        list(named.values()),
        with_references,
        modules=[{}],
        printer=printer,
        cse=common_parts,
    )
    body = inspect.getsource(function).partition("\n")[2]
    return {"arguments": [str(symbol) for symbol in named.values()], "body": body}


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
