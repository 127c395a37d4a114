"""States stepped along motions by machine code, which LLVM makes of their equations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from pipeclamp_models.base.arrays import Array

Compiled = Callable[..., Sequence[Any]]
STILL = (0, 0)
"""Strides of a number, which is the same at all samples of all rows."""


class Taken:
    """Arguments as machine code takes them: where their first numbers lie, and the bytes to the next.

    Attributes:
        shape: (R, n).
        places: addresses, shape (N,).
        strides: from row to row and from sample to sample, shape (N, 2).
    """

    def __init__(self, arguments: Sequence[Array | float], shape: tuple[int, int]) -> None:
        numbers = np.array([each for each in arguments if isinstance(each, float)])
        arrays = [_spread(each, shape) for each in arguments if not isinstance(each, float)]
        of_numbers = iter(range(numbers.ctypes.data, numbers.ctypes.data + numbers.nbytes, numbers.itemsize))
        of_arrays = ((array.ctypes.data, own) for array, own in arrays)
        where = [(next(of_numbers), STILL) if isinstance(each, float) else next(of_arrays) for each in arguments]
        self._alive = (numbers, arrays)
        self.shape = shape
        self.places = np.array([place for place, _ in where], dtype=np.uintp)
        self.strides = np.array([own for _, own in where], dtype=np.int64)


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
        self._columns = np.array(columns, dtype=np.intp)

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
        places, strides = taken.places[self._columns], taken.strides[self._columns]
        written = np.empty(results)
        begin = np.ascontiguousarray(start, dtype=np.float64)
        self._function(*taken.shape, *(each.ctypes.data for each in (places, strides, begin, written)))
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
