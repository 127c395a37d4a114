"""The test on which a found term and its rival differ most."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from pipeclamp_identification.diagnosis.thresholds import MATERIAL_NOISE_SHARE
from pipeclamp_identification.fitting.observations import loop_motion
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_identification.signals.levels import SAME_SHARE, number_levels
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.digits import newtons
from pipeclamp_models.base.signals import condition_signal
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.law import Law
from pipeclamp_models.realise.force import force_of_law
from pipeclamp_models.realise.motion import Motion, sinusoids
from pipeclamp_models.realise.sizes import about

BEYOND_A, BEYOND_F = 1.25, 2.0
"""How far beyond the tests a test may lie, as a share of the largest amplitude and of the highest frequency."""


def telling_test(one: Law, other: Law, loops: Loops) -> str:
    """Say which sine would tell two laws apart best, within and a little beyond the tests' range.

    Nothing where they differ by less than is material in all of them: which is taken makes no difference there.

    Args:
        one, other: the laws.
        loops: the tests that both fit as well.
    """
    motion = _tests(loops)
    difference = force_of_law(one, motion).force - force_of_law(other, motion).force
    size = np.sqrt(np.mean(difference**2, axis=1))
    best = int(np.nanargmax(size))
    scatter = float(np.median(loops.scatter_rms_N))
    if size[best] <= MATERIAL_NOISE_SHARE * scatter:
        return ""
    A, f, T = (float(motion.slow[name][best, 0]) for name in ("A", "f", "T"))
    at = f"A = {A:.3g} mm, f = {f:.3g} Hz" + (f", T = {T - CELSIUS:.3g} °C" if "T" not in motion.assumed else "")
    times = f", {size[best] / scatter:.2g} times the scatter" if scatter > 0 else ""
    return f"{at}: there they differ by {newtons(size[best])}{times}"


def _tests(loops: Loops) -> Motion:
    amplitudes = _levels(loops.amplitude_mm, BEYOND_A)
    frequencies = _levels(loops.frequency_Hz, BEYOND_F)
    known = bool(np.all(np.isfinite(loops.temperature_K)))
    temperatures = _between(loops.temperature_K) if known else [20.0 + CELSIUS]
    A, f, T = np.array(list(itertools.product(amplitudes, frequencies, temperatures))).T
    motion = sinusoids(A, f, T, about=about(loop_motion(loops)))
    middle = {condition_signal(name): float(np.median(values)) for name, values in loops.conditions.items()}
    if np.all(np.isfinite(loops.cycle)):
        middle["N"] = float(np.median(loops.cycle))
    if np.all(np.isfinite(loops.density_g_cm3)):
        middle["rho"] = float(np.median(loops.density_g_cm3))
    further = {name: np.full((len(A), 1), value) for name, value in middle.items()}
    return replace(motion, slow={**motion.slow, **further}, assumed=frozenset() if known else frozenset({"T"}))


def _between(temperatures: Array) -> list[float]:
    """Give the lowest and the highest, and the middle of each two neighbours: there none was tested."""
    tested = [float(np.mean(temperatures[level.rows])) for level in number_levels(temperatures, relative=SAME_SHARE)]
    return sorted({tested[0], tested[-1], *((low + high) / 2 for low, high in itertools.pairwise(tested))})


def _levels(values: Array, beyond: float) -> list[float]:
    low, high = float(np.min(values)), float(np.max(values))
    return sorted({low, float(np.sqrt(low * high)), high, beyond * high})
