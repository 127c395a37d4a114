"""Equations as vectorised NumPy functions with exact derivatives, written by SymPy once and kept."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from pipeclamp_models.base.kept import kept
from pipeclamp_models.law.law import Equations
from pipeclamp_models.realise.walks import Compiled, Course, StepSlopes, Turn, Walk

FAST_ARGUMENTS = ("y", "v", "a", "y_previous", "h")
"""The fast signals that functions take, in order."""
NUMPY: Mapping[str, Any] = {name: value for name, value in vars(np).items() if not name.startswith("_")}
"""What functions of arrays may call."""
Pair = tuple[int, int]
"""Places of what is differentiated, among its like, and of what it is differentiated by."""


class InParts:
    """A function of arrays in parts, each of which takes some of its arguments and adds to some of its results."""

    def __init__(self, parts: Sequence[Mapping[str, Any]], results: int) -> None:
        self._written = parts
        self._parts = [(_defined(part["source"]), part["columns"], part["places"]) for part in parts]
        self._results = range(results)
        self._with: dict[int, InParts] = {}

    def __call__(self, *arguments: Any) -> list[Any]:
        """Give the results; what no part adds to is zero."""
        found: dict[int, Any] = {}
        for function, columns, places in self._parts:
            for place, value in zip(places, function(*[arguments[column] for column in columns]), strict=True):
                found[place] = found[place] + value if place in found else value
        return [found.get(place, 0.0) for place in self._results]

    def taking(self, column: int) -> InParts:
        """Give those of its parts that take an argument, alone: the others stay as it changes."""
        if column not in self._with:
            taking = [part for part in self._written if column in part["columns"]]
            self._with[column] = InParts(taking, len(self._results))
        return self._with[column]

    @cached_property
    def columns(self) -> tuple[int, ...]:
        """Places of the arguments that any part takes."""
        return tuple(sorted({column for _, columns, _ in self._parts for column in columns}))


class ArrayRealisation:
    """Functions of one set of equations, each compiled when it is first asked for.

    Arguments of `coefficients` are the slow signals, the parameters and v_r, y_r; `force` takes the fast signals,
    the states, the coefficients, the parameters and v_r, y_r; `update` the same as `force`; `lag` the parameters. The
    derivative functions return a list; the matching index, or places, say what stands where; what is absent is zero.
    What goes along motions, `walks`, `turns`, `courses` and `update_slopes`, is machine code.
    """

    def __init__(self, equations: Equations) -> None:
        self._equations = equations
        self._written: dict[str, Mapping[str, Any]] = {}
        self.slow = tuple(sorted(equations.slow_signals))

    @cached_property
    def coefficients(self) -> Compiled:
        """The coefficients."""
        return self._compiled("coefficients")

    @cached_property
    def coefficient_slope_index(self) -> tuple[Pair, ...]:
        """(coefficient, parameter) of each derivative in `coefficients_with_slopes`."""
        return self._index("coefficients_with_slopes")

    @cached_property
    def coefficients_with_slopes(self) -> Compiled:
        """The coefficients, then their derivatives by the parameters: the powers are common."""
        return self._compiled("coefficients_with_slopes")

    @cached_property
    def force(self) -> InParts:
        """The force in N, of states after their update."""
        return self._compiled("force")

    @cached_property
    def force_slope_index(self) -> tuple[int, ...]:
        """Of each derivative in `force_with_slopes` what it is by: its place among states, coefficients, parameters."""
        return tuple(column for _, column in self._index("force_with_slopes"))

    @cached_property
    def force_with_slopes(self) -> InParts:
        """The force, then its derivatives by states, coefficients and parameters: most of the work is common."""
        return self._compiled("force_with_slopes")

    @cached_property
    def update(self) -> Compiled:
        """The states after a step."""
        return self._compiled("update")

    @cached_property
    def update_slope_index(self) -> tuple[Pair, ...]:
        """(state, state before) of each of all `update_slopes`."""
        return tuple((row, column) for one in self.written("update_slopes")["parts"] for row, column in one["index"])

    @cached_property
    def update_slopes(self) -> Sequence[StepSlopes]:
        """The derivatives of the states after a step by those before it, by those states that need each other."""
        return [
            StepSlopes(len(one["index"]), one["columns"], one["source"])
            for one in self.written("update_slopes")["parts"]
        ]

    @cached_property
    def walks(self) -> Sequence[Walk]:
        """How the states are stepped along motions, those together that need each other."""
        return [Walk(one["states"], one["columns"], one["source"]) for one in self.written("walks")["parts"]]

    @cached_property
    def turns(self) -> Sequence[Turn]:
        """What whole motions make of the states, those together that need each other."""
        return [
            Turn(one["states"], one["columns"], one["index"], one["source"]) for one in self.written("turns")["parts"]
        ]

    @cached_property
    def courses(self) -> Sequence[Course]:
        """How states and their slopes go along motions, those together that need each other."""
        return [
            Course(one["states"], one["columns"], one["index"], one["source"])
            for one in self.written("courses")["parts"]
        ]

    @cached_property
    def energy(self) -> Compiled:
        """The stored energy in N mm."""
        return self._compiled("energy")

    @property
    def in_time(self) -> bool:
        """Whether the measured force has no lag."""
        return not self._equations.outline.late

    @cached_property
    def lag(self) -> Compiled:
        """The time in s by which the measured force is late."""
        return self._compiled("lag")

    @cached_property
    def lag_slope_index(self) -> tuple[int, ...]:
        """Parameter of each of `lag_slopes`."""
        return tuple(column for _, column in self._index("lag_slopes"))

    @cached_property
    def lag_slopes(self) -> Compiled:
        """The lag's derivatives by the parameters."""
        return self._compiled("lag_slopes")

    def written(self, function: str) -> Mapping[str, Any]:
        """Give what `array_source` writes of a function."""
        if function not in self._written:

            def write() -> Mapping[str, Any]:
                from pipeclamp_models.realise.array_source import array_source

                return array_source(self._equations.composed, function)

            self._written[function] = kept(f"{function} {self._equations.key}", write)
        return self._written[function]

    def _compiled(self, function: str) -> InParts:
        written = self.written(function)
        return InParts(written["parts"], written["results"])

    def _index(self, function: str) -> tuple[Pair, ...]:
        return tuple((row, column) for row, column in self.written(function)["index"])


@lru_cache(maxsize=1024)
def _defined(source: str) -> Compiled:
    """Give the function of arrays that a source defines; laws have most of their parts in common."""
    defined: dict[str, Compiled] = {}
    exec(source, dict(NUMPY), defined)
    (compiled,) = defined.values()
    return compiled


@lru_cache(maxsize=128)
def realise(equations: Equations) -> ArrayRealisation:
    """Give the equations as array functions; the same equations are compiled once."""
    return ArrayRealisation(equations)
