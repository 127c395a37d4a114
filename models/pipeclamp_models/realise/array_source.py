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
        it is differentiated by, of each that doesn't vanish.
    """
    asked = _asked(equations, function)
    taken = asked.symbols()
    arguments = [symbol for symbol in asked.arguments if symbol in taken]
    places = [place for place, symbol in enumerate(asked.by) if symbol in taken]
    states = [symbol for symbol in asked.states if symbol in taken]
    lean = replace(asked, arguments=arguments, by=[asked.by[place] for place in places], states=states)
    written = kept(f"{function} {lean.content()}", lambda: _written(lean, function))
    names = dict(zip(arguments, written["arguments"], strict=False))
    further = written["arguments"][len(arguments) :]
    every = [names.get(symbol, f"_unused_{place}") for place, symbol in enumerate(asked.arguments)]
    source: dict[str, Any] = {"source": f"def {function}({', '.join([*every, *further])}):\n{written['body']}"}
    if "index" in written:
        source["index"] = [(row, places[column]) for row, column in written["index"]]
    return source


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
        case "update" | "update_slopes" | "held" | "march" | "march_of_numbers":
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
        case "march" | "march_of_numbers":
            held, stages, updates = _along_a_march(asked)
            arguments = [*asked.arguments, *(symbol for symbol, _ in held)]
            return _source(arguments, updates, stages, numbers=function == "march_of_numbers")
    return _source(asked.arguments, asked.expressions, asked.stages)


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
    """Write a function of arrays or of plain numbers, with what is computed before the results, in order."""
    settings = {"fully_qualified_modules": numbers, "inline": True, "allow_unknown_functions": True}
    printer = ScalarPrinter(settings) if numbers else ArrayPrinter(settings)
    with_references = [exact(expression) for expression in expressions]
    # Numbered names for arguments: no effect's symbol can then hide a function of NumPy or a common part, and terms
    # stand in the arguments' order. SymPy's dummies would do the first, but are numbered by what was done before.
    named = {symbol: sp.Symbol(f"_{place:03d}") for place, symbol in enumerate(arguments)}

    def common_parts(whole: Sequence[sp.Expr]) -> tuple[list[Definition], list[sp.Expr]]:
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
