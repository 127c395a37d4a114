"""States stepped along motions by machine code, which LLVM makes of their equations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from pipeclamp_models.base.arrays import Array

Compiled = Callable[..., Sequence[Any]]
STILL = (0, 0)
"""Strides of a number, which is the same at all samples of all rows."""


class Taken:
    """Arguments as machine code takes them: where their first numbers lie, and the bytes to the next.

    Attributes:
        shape: (R, n).
    """

    def __init__(self, arguments: Sequence[Array | float], shape: tuple[int, int]) -> None:
        self._arguments = arguments
        self._unknown = set(range(len(arguments)))
        self._places = np.empty(len(arguments), dtype=np.uintp)
        self._strides = np.empty((len(arguments), 2), dtype=np.int64)
        self._alive: list[npt.NDArray[Any]] = []
        self._asked: dict[tuple[int, ...], tuple[int, int]] = {}
        self.shape = shape

    def where(self, columns: tuple[int, ...]) -> tuple[int, int]:
        """Give where two tables of some arguments lie, as long as this lives: of their addresses, (N,), and of their
        strides from row to row and from sample to sample, in bytes, (N, 2)."""
        if columns not in self._asked:
            for column in self._unknown.intersection(columns):
                argument = self._arguments[column]
                number = isinstance(argument, float)
                array, strides = (np.array(argument), STILL) if number else _spread(np.asarray(argument), self.shape)
                self._alive.append(array)
                self._places[column], self._strides[column] = array.ctypes.data, strides
            self._unknown.difference_update(columns)
            tables = self._places.take(columns), self._strides.take(columns, axis=0)
            self._alive += tables
            self._asked[columns] = tables[0].ctypes.data, tables[1].ctypes.data
        return self._asked[columns]


def _spread(argument: Array, shape: tuple[int, int]) -> tuple[Array, tuple[int, ...]]:
    """Give an argument's numbers and its strides as of this shape; NumPy's own way takes as long as a short walk."""
    array = np.asarray(argument, dtype=np.float64)
    if array.shape == shape:
        return array, array.strides
    if array.shape == (shape[0], 1):
        return array, (array.strides[0], 0)
    array = np.broadcast_to(array, shape)
    return array, array.strides


class MachineMarch:
    """What goes through all samples of all rows; `columns` are the places of what it takes among its arguments."""

    def __init__(self, name: str, columns: Sequence[int], source: str) -> None:
        self._name = name
        self._source = source
        self._columns = tuple(columns)

    @cached_property
    def _function(self) -> Callable[..., None]:
        from pipeclamp_models.realise.machine import machine_function

        return machine_function(self._name, self._source)

    def __call__(self, taken: Taken, start: Array, results: tuple[int, ...]) -> Array:
        """Give the results.

        Args:
            taken: the arguments, each (R, n) or what broadcasts to it, or a number.
            start: states before the first sample, (J, R).
            results: their shape, (K, R, n) or (K, R), as it was written.
        """
        written = np.empty(results)
        begin = np.ascontiguousarray(start, dtype=np.float64)
        self._function(*taken.shape, *taken.where(self._columns), begin.ctypes.data, written.ctypes.data)
        return written


class Walk:
    """How a set of states is stepped along motions.

    Attributes:
        states: their places among the law's.
    """

    def __init__(self, states: Sequence[int], columns: Sequence[int], source: str) -> None:
        self.states = list(states)
        self._march = MachineMarch("walk", columns, source)

    def __call__(self, start: Array, taken: Taken) -> Array:
        """Give the set's states after each sample, (J, R, n).

        Args:
            start: all of the law's states before the first sample, (L, R).
            taken: the update's arguments, without the states.
        """
        return self._march(taken, start[self.states], (len(self.states), *taken.shape))


class AfterMotion(NamedTuple):
    """States (J, R) after a whole motion, how large each became (J, R), and slopes by those before it (R, J, J)."""

    states: Array
    largest: Array
    by_start: Array


class Turn:
    """What a whole motion makes of a set of states.

    Attributes:
        states: their places among the law's.
    """

    def __init__(self, states: Sequence[int], columns: Sequence[int], index: Sequence[Sequence[int]], source: str):
        self.states = list(states)
        self._ends, self._beginnings = (list(each) for each in zip(*index, strict=True))
        self._march = MachineMarch("turn", columns, source)

    def __call__(self, start: Array, taken: Taken) -> AfterMotion:
        """Give what becomes of the set's states; what is taken is as of `Walk`."""
        rows, count = taken.shape[0], len(self.states)
        found = self._march(taken, start[self.states], (2 * count + len(self._ends), rows))
        slopes = np.zeros((rows, count, count))
        slopes[:, self._ends, self._beginnings] = found[2 * count :].T
        return AfterMotion(found[:count], found[count : 2 * count], slopes)


class Along(NamedTuple):
    """States after each sample, (J, R, n), and their slopes there.

    The slopes that don't vanish are by the states before the first sample and by the other arguments, which keep still:
    (R, n) each, by the places of the state and of what it is differentiated by.
    """

    states: Array
    slopes: dict[tuple[int, int], Array]


class Course:
    """How a set of states, and small changes of them, go along motions.

    Attributes:
        states: their places among the law's.
    """

    def __init__(self, states: Sequence[int], columns: Sequence[int], index: Sequence[Sequence[int]], source: str):
        self.states = list(states)
        self._index = [(self.states[end], by) for end, by in index]
        self._march = MachineMarch("course", columns, source)

    def __call__(self, start: Array, taken: Taken) -> Along:
        """Give the set's states and their slopes; what is taken is as of `Walk`."""
        count = len(self.states)
        found = self._march(taken, start[self.states], (count + len(self._index), *taken.shape))
        return Along(found[:count], dict(zip(self._index, found[count:], strict=True)))


class StepSlopes:
    """The slopes of a step of a set of states by those before it, so many of them."""

    def __init__(self, count: int, columns: Sequence[int], source: str) -> None:
        self._count = count
        self._march = MachineMarch("slopes", columns, source)

    def __call__(self, taken: Taken) -> Array:
        """Give the slopes at each sample, (K, R, n), of all of the update's arguments."""
        return self._march(taken, np.empty((0, taken.shape[0])), (self._count, *taken.shape))
