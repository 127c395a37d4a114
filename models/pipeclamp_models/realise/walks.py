"""States stepped along motions by machine code, which LLVM makes of their equations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from pipeclamp_models.base.arrays import Array

Compiled = Callable[..., Sequence[Any]]
STILL = (0, 0)
"""Strides of a number, which is the same at all samples of all rows."""


class MachineMarch:
    """What goes through all samples of all rows; `columns` are the places of what it takes among its arguments."""

    def __init__(self, name: str, columns: Sequence[int], source: str) -> None:
        self._name = name
        self._source = source
        self._columns = columns

    def __call__(
        self, arguments: Sequence[Array | float], start: Array, results: tuple[int, ...], shape: tuple[int, int]
    ) -> Array:
        """Give the results.

        Args:
            arguments: each (R, n) or what broadcasts to it, or a number.
            start: states before the first sample, (J, R).
            results: their shape, (K, R, n) or (K, R), as it was written.
            shape: (R, n).
        """
        from pipeclamp_models.realise.machine import machine_function

        taken = [arguments[place] for place in self._columns]
        numbers = np.array([each for each in taken if isinstance(each, float)])
        arrays = [_spread(each, shape) for each in taken if not isinstance(each, float)]
        of_numbers = iter(range(numbers.ctypes.data, numbers.ctypes.data + numbers.nbytes, numbers.itemsize))
        of_arrays = ((array.ctypes.data, own) for array, own in arrays)
        where = [(next(of_numbers), STILL) if isinstance(each, float) else next(of_arrays) for each in taken]
        places = np.array([place for place, _ in where], dtype=np.uintp)
        strides = np.array([own for _, own in where], dtype=np.int64)
        written = np.empty(results)
        begin = np.ascontiguousarray(start, dtype=np.float64)
        addresses = (each.ctypes.data for each in (places, strides, begin, written))
        machine_function(self._name, self._source)(*shape, *addresses)
        return written


def _spread(argument: Array, shape: tuple[int, int]) -> tuple[Array, tuple[int, ...]]:
    """Give an argument's numbers and its strides as of this shape; NumPy's own way takes as long as a short walk."""
    array = np.asarray(argument, dtype=np.float64)
    if array.shape == shape:
        return array, array.strides
    if array.shape == (shape[0], 1):
        return array, (array.strides[0], 0)
    array = np.broadcast_to(array, shape)
    return array, array.strides


class Walk:
    """How a set of states is stepped along motions.

    Attributes:
        states: their places among the law's.
    """

    def __init__(self, states: Sequence[int], columns: Sequence[int], source: str) -> None:
        self.states = list(states)
        self._march = MachineMarch("walk", columns, source)

    def __call__(self, start: Array, arguments: Sequence[Array | float], shape: tuple[int, int]) -> Array:
        """Give the set's states after each sample, (J, R, n).

        Args:
            start: all of the law's states before the first sample, (L, R).
            arguments: the update's, without the states, each (R, n) or what broadcasts to it, or a number.
            shape: (R, n).
        """
        return self._march(arguments, start[self.states], (len(self.states), *shape), shape)


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

    def __call__(self, start: Array, arguments: Sequence[Array | float], shape: tuple[int, int]) -> AfterMotion:
        """Give what becomes of the set's states; what is taken is as of `Walk`."""
        rows, count = shape[0], len(self.states)
        results = (2 * count + len(self._ends), rows)
        found = self._march(arguments, start[self.states], results, shape)
        slopes = np.zeros((rows, count, count))
        slopes[:, self._ends, self._beginnings] = found[2 * count :].T
        return AfterMotion(found[:count], found[count : 2 * count], slopes)


class StepSlopes:
    """The slopes of steps of a set of states, so many of them."""

    def __init__(self, count: int, columns: Sequence[int], source: str) -> None:
        self._count = count
        self._march = MachineMarch("slopes", columns, source)

    def __call__(self, arguments: Sequence[Array | float], shape: tuple[int, int]) -> Array:
        """Give the slopes at each sample, (K, R, n); arguments are the update's, as of `Walk`."""
        return self._march(arguments, np.empty((0, shape[0])), (self._count, *shape), shape)
