"""The motion of a test rig and the time stepping of virtual devices: plain NumPy, classic Runge-Kutta of fixed step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Rates = Callable[[int, Array], Array]
"""Time derivatives (S, R) of the states, from the index of a half step and the states (S, R)."""


@dataclass(frozen=True)
class Drive:
    """What a rig does to R runs of one frequency, in n steps; channels are given at every half step.

    Attributes:
        step: s.
        y, v, a: displacement, velocity, acceleration in mm, s, (2 n + 1, R); all begin at rest.
        f: Hz.
        T: temperature of each run, degC, (R,).
        u: further test condition of each run, (R,); zero where there is none.
    """

    step: float
    y: Array
    v: Array
    a: Array
    f: float
    T: Array
    u: Array

    @property
    def runs(self) -> int:
        """Number of runs."""
        return self.y.shape[1]

    @property
    def whole(self) -> tuple[Array, Array, Array]:
        """y, v, a at the whole steps, (n + 1, R)."""
        return self.y[::2], self.v[::2], self.a[::2]


def ramped(
    tones: dict[int, npt.NDArray[np.complex128]], f: float, step: float, steps: int, ramp_cycles: float
) -> tuple[Array, Array, Array]:
    """Give y, v, a (2 steps + 1, R) of a periodic drive that a raised cosine brings in from rest.

    Args:
        tones: complex amplitude (R,) in mm by order: y = sum of Re(tone exp(i order w t)).
        f: fundamental, Hz.
        step: s.
        steps: how many.
        ramp_cycles: length of the ramp in cycles of the drive.
    """
    t = np.arange(2 * steps + 1) * (step / 2)
    w = 2 * np.pi * f
    y, v, a = (
        sum(
            np.real(tone * (1j * order * w) ** derivative * np.exp(1j * order * w * t)[:, None])
            for order, tone in tones.items()
        )
        for derivative in range(3)
    )
    duration = ramp_cycles / f
    turn = np.pi / duration
    during = t < duration
    share = np.where(during, (1 - np.cos(turn * t)) / 2, 1.0)[:, None]
    rise = np.where(during, turn * np.sin(turn * t) / 2, 0.0)[:, None]
    bend = np.where(during, turn**2 * np.cos(turn * t) / 2, 0.0)[:, None]
    return share * y, share * v + rise * y, share * a + 2 * rise * v + bend * y


def march(rates: Rates, start: Array, drive: Drive) -> Array:
    """Integrate states by the classic fourth-order Runge-Kutta method; give them at the whole steps, (n + 1, S, R)."""
    h = drive.step
    steps = len(drive.y) // 2
    result = np.empty((steps + 1, *start.shape))
    z = start.copy()
    result[0] = z
    for number in range(steps):
        here = 2 * number
        k1 = rates(here, z)
        k2 = rates(here + 1, z + h / 2 * k1)
        k3 = rates(here + 1, z + h / 2 * k2)
        k4 = rates(here + 2, z + h * k3)
        z = z + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        result[number + 1] = z
    return result


def slipping(path: Array, limits: Array) -> Array:
    """Give the stretch of elastic-slip elements along a path, mm: clipped step by step.

    Args:
        path: (n, R) in mm.
        limits: elastic limit of each element, mm, (E, 1) or (E, R).

    Returns:
        (n, E, R)
    """
    result = np.empty((len(path), len(limits), path.shape[1]))
    z = np.zeros(result.shape[1:])
    result[0] = z
    for number, move in enumerate(np.diff(path, axis=0), 1):
        z = np.minimum(np.maximum(z + move, -limits), limits)
        result[number] = z
    return result
