"""The sizes of tests' data or of a law's loops: starts, bounds and typical sizes of parameters are stated in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from math import floor, log10
from typing import TYPE_CHECKING

import numpy as np

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.signals import CONDITION, REFERENCES, size_of
from pipeclamp_models.law.file import LawFile, law_of
from pipeclamp_models.law.law import Law
from pipeclamp_models.law.outline import Sizes
from pipeclamp_models.realise.force import force_of_law
from pipeclamp_models.realise.motion import Motion, sinusoids

if TYPE_CHECKING:
    import sympy as sp

SAMPLES_PER_CYCLE = 128
"""Samples of a cycle that tell the size of a law's force."""
CYCLES_OF_A_SERIES = 1000.0
"""Load cycles of a test series, where nothing says how many."""
FIRST_CYCLE = 0.5
"""Load cycles in the middle of the first one."""
ABOUT_ZERO = 0.25
"""Share of the amplitude within which tests move about zero; those that load a part to one side move about 1."""


def data_sizes(motion: Motion, force_amplitude: Array) -> Sizes:
    """Give the sizes of R runs.

    Args:
        motion: of the runs.
        force_amplitude: N, shape (R,).
    """
    slow = motion.slow
    A, f, T = (slow[name][:, 0] for name in ("A", "f", "T"))
    bottom, top = _ends(motion)
    cycles = slow.get("N", np.array([FIRST_CYCLE]))
    return {
        "N_lowest": max(FIRST_CYCLE, float(np.min(cycles))),
        "N_highest": max(1.0, float(np.max(cycles))),
        "A_typical": float(np.median(A)),
        "A_highest": float(np.max(A)),
        "y_middle": (top + bottom) / 2,
        "y_reach": (top - bottom) / 2,
        "F_typical": float(np.median(force_amplitude)),
        "f_typical": float(np.median(f)),
        "f_lowest": float(np.min(f)),
        "f_highest": float(np.max(f)),
        "T_lowest": float(np.min(T)),
        "T_highest": float(np.max(T)),
        **{name: float(value) for name, value in REFERENCES.items()},
        **{
            size_of(name): max(float(np.max(np.abs(values))), 1e-12)
            for name, values in slow.items()
            if name.startswith(CONDITION) and np.all(np.isfinite(values))
        },
    }


def about(motion: Motion) -> float:
    """Give the displacement about which R runs move, mm: that of the middle run; 0 where it is about zero.

    It is read by people: digits that are small beside the amplitudes are left out.
    """
    place, A = np.mean(motion.y, axis=1), float(np.median(motion.slow["A"]))
    middle = float(np.sort(place)[(len(place) - 1) // 2])
    return round(middle, 1 - floor(log10(A))) if abs(middle) > ABOUT_ZERO * A else 0.0


def _ends(motion: Motion) -> tuple[float, float]:
    """Give the displacements between which R runs move, mm."""
    place, A = np.mean(motion.y, axis=1), motion.slow["A"][:, 0]
    return float(np.min(place - A)), float(np.max(place + A))


def law_sizes(
    law: Law,
    amplitudes: Sequence[float],
    frequencies: Sequence[float],
    temperatures: Sequence[float],
    further: Mapping[str, float],
    about: float = 0.0,
) -> Sizes:
    """Give the sizes of the loops of a law, in every combination of amplitude, frequency and temperature.

    Args:
        law: the law.
        amplitudes: mm; frequencies: Hz; temperatures: K.
        further: further slow signals by name, the same in all loops.
        about: displacement about which they move, mm.

    Raises:
        UserError: the law depends on a slow signal that isn't given.
    """
    A, f, T = (grid.ravel() for grid in np.meshgrid(amplitudes, frequencies, temperatures))
    motion = sinusoids(A, f, T, SAMPLES_PER_CYCLE, about)
    added = {name: np.full_like(motion.slow["A"], value) for name, value in further.items()}
    motion = replace(motion, slow={**motion.slow, **added})
    sizes = data_sizes(motion, np.ptp(force_of_law(law, motion).force, axis=1) / 2)
    return {**sizes, "N_lowest": FIRST_CYCLE}


def file_sizes(file: LawFile, conditions: Sequence[str] = ()) -> Sizes:
    """Give the sizes of the loops of a law over its range; further conditions, by their signals' names, count as 1."""
    ends = {name: (interval.minimum, interval.maximum) for name, interval in file.range.items()}
    A, f, T = (ends.get(name, (293.15, 293.15)) for name in ("A", "f", "T"))
    further = {
        "N": CYCLES_OF_A_SERIES,
        "rho": REFERENCES["rho_0"],
        **dict.fromkeys(conditions, 1.0),
    }
    return law_sizes(law_of(file), A, f, T, further, file.about)


def number_of(value: sp.Expr | float, sizes: Sizes) -> float:
    """Give a start, bound or typical size as a number."""
    if isinstance(value, int | float):
        return float(value)
    needed = sorted((symbol for symbol in value.free_symbols if str(symbol) in sizes), key=str)
    return _number(value, tuple((symbol, sizes[str(symbol)]) for symbol in needed))


@lru_cache(maxsize=4096)
def _number(value: sp.Expr, sizes: tuple[tuple[sp.Symbol, float], ...]) -> float:
    """Give a number, once: each fit to the same tests asks for the same ones several times."""
    return float(value.subs(sizes))
