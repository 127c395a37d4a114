"""What an effect does to a clamp's loops, from its own equation: with it and without it, on motions that show it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.signals import CONDITION
from pipeclamp_models.base.units import CELSIUS, grows_with_force
from pipeclamp_models.equations import symbols
from pipeclamp_models.equations.effect import Effect
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import law_of
from pipeclamp_models.law.law import Law, Structure, bare_for, with_effect
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import Motion, sinusoids
from pipeclamp_models.realise.reading.text import symbols_of
from pipeclamp_models.realise.sizes import law_sizes, number_of

CLAMP = "emwm2"
"""The bundled law whose base law stands for the clamp."""
AMPLITUDE, FREQUENCY, TEMPERATURE = 0.8, 3.0, 20.0 + CELSIUS
AMPLITUDES, FREQUENCIES = (0.3, 0.6, 1.0), (1.0, 5.0, 20.0)
TEMPERATURES_K = tuple(value + CELSIUS for value in (20.0, 150.0, 300.0))
SMALL_AMPLITUDE, MEANS = 0.3, (-0.6, 0.0, 0.6)
"""Amplitude and means of small cycles, mm: within one of them what follows the displacement hardly changes."""
CYCLE_NUMBERS, DENSITIES, COLUMN = (0.0, 300.0, 2000.0), (2.0, 2.286, 2.571), (0.0, 0.5, 1.0)
SEEN_SHARE = 0.08
"""A difference is drawn larger until it is this share of the force: a typical one may be too small to see."""
MAGNIFICATIONS = (1, 2, 5, 10, 20, 50)


@dataclass(frozen=True)
class EffectLoops:
    """Loops of a clamp, R motions of n samples.

    Attributes:
        labels: what is special about each motion.
        displacement: mm, shape (R, n).
        without, with_it: N, shape (R, n); the difference is drawn `times` as large as it is.
        times: the magnification.
    """

    labels: tuple[str, ...]
    displacement: Array
    without: Array
    with_it: Array
    times: int


def loops_with_and_without(effect: Effect, declared: Sequence[Declaration] = ()) -> EffectLoops:
    """Give a clamp's loops with an effect of typical size and without it, on motions that show it.

    Args:
        effect: the effect.
        declared: a user's own effects, of which it may be one.
    """
    bare = replace(bare_for(effect), declared=tuple(declared))
    labels, motion = _motions(effect)
    known = law_of(open_law(CLAMP))
    slow = {name: float(values[-1, 0]) for name, values in motion.slow.items() if name not in ("A", "f", "T")}
    sizes = law_sizes(replace(known, structure=Structure()), AMPLITUDES, FREQUENCIES[:2], TEMPERATURES_K, slow)
    structure = bare if effect.part == "base" else with_effect(bare, effect.name)
    own = {} if effect.part == "base" else {one.name: number_of(one.size, sizes) for one in effect.parameters}
    values = {one.name: number_of(one.size, sizes) for one in structure.equations.composed.parameters}
    values |= {name: value for name, value in known.values.items() if name in values} | own
    others = values | {
        one.name: 0.0 for one in effect.parameters if effect.part == "base" and grows_with_force(one.unit)
    }
    with_it = _force(replace(known, structure=structure, values=values), motion)
    without = _force(replace(known, structure=bare, values=others), motion)
    difference = with_it - without
    share = float(np.max(np.abs(difference)) / np.max(np.abs(with_it)))
    times = next((times for times in MAGNIFICATIONS if times * share > SEEN_SHARE), MAGNIFICATIONS[-1])
    return EffectLoops(labels, motion.y, without, without + times * difference, times)


def _force(law: Law, motion: Motion) -> Array:
    return force_of_equations(law.equations, law.vector(law.equations), (law.v_r, law.y_r), motion).force


def _motions(effect: Effect) -> tuple[tuple[str, ...], Motion]:
    """Give three motions: what the effect follows is varied, a condition, the frequency, the mean or the amplitude."""
    used = {signal.symbol for signal in symbols_of(effect)}
    if effect.part == "base":
        return _over_amplitude()
    for symbol, levels, words in _further(used):
        motion = sinusoids([AMPLITUDE] * len(levels), FREQUENCY, TEMPERATURE)
        slow = {**motion.slow, str(symbol): np.array(levels)[:, None]}
        return tuple(words.format(level) for level in levels), replace(motion, slow=slow)
    if symbols.T in used:
        return tuple(f"{value - CELSIUS:.0f} °C" for value in TEMPERATURES_K), sinusoids(
            AMPLITUDE, FREQUENCY, TEMPERATURES_K
        )
    in_time = used & {symbols.f, symbols.v, symbols.a, symbols.h} and "damping" not in effect.scales
    if in_time or effect.lag != 0:
        return tuple(f"{value:g} Hz" for value in FREQUENCIES), sinusoids(AMPLITUDE, FREQUENCIES, TEMPERATURE)
    if effect.states and effect.force is not None and symbols.y in sp.sympify(effect.force).free_symbols:
        # what has memory carries more or less by where it is
        return _about_means()
    return _over_amplitude()


def _about_means() -> tuple[tuple[str, ...], Motion]:
    motion = sinusoids([SMALL_AMPLITUDE] * len(MEANS), FREQUENCY, TEMPERATURE)
    means = np.array(MEANS)[:, None]
    return tuple(f"{SMALL_AMPLITUDE:g} mm about {mean:g} mm" for mean in MEANS), replace(motion, y=motion.y + means)


def _over_amplitude() -> tuple[tuple[str, ...], Motion]:
    return tuple(f"{value:g} mm" for value in AMPLITUDES), sinusoids(AMPLITUDES, FREQUENCY, TEMPERATURE)


def _further(used: Iterable[sp.Symbol]) -> list[tuple[sp.Symbol, tuple[float, ...], str]]:
    """Give the conditions besides A, f and T that an effect follows, with levels and how to label them."""
    levels = {symbols.N: (CYCLE_NUMBERS, "{:g} cycles"), symbols.rho: (DENSITIES, "{:g} g/cm³")}
    found = [(symbol, *levels[symbol]) for symbol in used if symbol in levels]
    columns = [symbol for symbol in used if str(symbol).startswith(CONDITION)]
    return found + [(symbol, COLUMN, f"{str(symbol).removeprefix(CONDITION)} = {{:g}}") for symbol in columns]
