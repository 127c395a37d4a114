"""States stepped along motions by machine code, which Numba makes of their equations once for each user."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.kept import kept_module

Compiled = Callable[..., Sequence[Any]]


class Walk:
    """How a set of states is stepped along motions, of all rows.

    Attributes:
        states: their places among the law's.
    """

    def __init__(self, states: Sequence[int], held: Compiled, columns: Sequence[int], source: str) -> None:
        self.states = list(states)
        self._held = held
        self._columns = columns
        self._source = source

    def __call__(self, start: Array, moving: Sequence[Array], held: Sequence[Array]) -> Array:
        """Give the states after each sample, (J, R, n).

        Args:
            start: all of the law's states before the first sample, (L, R).
            moving: the update's arguments before the states, each (R, n) or, where it keeps still, (R, 1).
            held: those after the states.
        """
        before = start[:, :, None]
        still = self._held(*moving, *before, *held)
        every = [*moving, *held]
        shape = moving[0].shape
        taken = [np.asarray(each, dtype=np.float64) for each in (*(every[place] for place in self._columns), *still)]
        columns = [each if each.shape == shape else np.broadcast_to(each, shape) for each in taken]
        after = np.empty((len(self.states), *shape))
        _compiled(self._source, len(columns))(np.ascontiguousarray(start[self.states]), after, tuple(columns))
        return after


@cache
def _compiled(source: str, columns: int) -> Callable[[Array, Array, tuple[Array, ...]], None]:
    """Give `walk` of a module's source as machine code, kept beside the module where that has a place."""
    path = kept_module(source)
    try:
        return _compiled_at(path, source, columns)
    except Exception:  # what was kept isn't whole, which only costs time
        if path is None:
            raise
        return _compiled_at(None, source, columns)


def _compiled_at(path: Path | None, source: str, columns: int) -> Callable[[Array, Array, tuple[Array, ...]], None]:
    from numba import njit, types

    module = ModuleType("pipeclamp_walk" if path is None else path.stem)
    sys.modules[module.__name__] = module  # where Numba looks for what it has kept
    exec(compile(source, "walk" if path is None else str(path), "exec"), vars(module))
    for name in ("_larger", "_smaller", "step"):
        setattr(module, name, njit(error_model="numpy")(getattr(module, name)))
    still = types.Array(types.float64, 2, "A", readonly=True)
    signature = types.void(types.float64[:, ::1], types.float64[:, :, ::1], types.UniTuple(still, columns))
    return njit(signature, error_model="numpy", cache=path is not None)(module.walk)
