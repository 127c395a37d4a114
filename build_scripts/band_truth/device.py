"""A clamp on a test machine and on a pipe, integrated by code of its own: Runge and Kutta's method, step by step.

The clamp is a spring with a cubic part that softens with temperature, damping c |v|^alpha, and, if rough, an elastic
element that slips: what the package's base law has no form for.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

REFERENCE = 293.15
"""K, at which the stiffness is that of the device."""
ROUNDED = 0.02
"""mm/s, below which |v|^alpha is rounded off."""


@dataclass(frozen=True)
class Device:
    """A clamp; mm, N, s.

    Attributes:
        k, k3: stiffness and cubic stiffness.
        softens: exponent by which they follow the temperature.
        c, alpha: damping force at 1 mm/s and its exponent.
        element, slip: stiffness and slip force of the element; 0 where there is none.
    """

    k: float
    k3: float
    softens: float
    c: float
    alpha: float
    element: float
    slip: float

    def mounted(self, random: np.random.Generator, stiffness: float, damping: float) -> Device:
        """Give the device as it is mounted once more, off by shares of these standard deviations."""
        off_k, off_c = 1 + stiffness * random.standard_normal(), 1 + damping * random.standard_normal()
        return replace(
            self, k=off_k * self.k, k3=off_k * self.k3, element=off_k * self.element,
            c=off_c * self.c, slip=off_c * self.slip,
        )  # fmt: skip

    def numbers(self, kelvin: float) -> Array:
        """Give what the integrators take, at a temperature."""
        soft = (kelvin / REFERENCE) ** self.softens
        return np.array([soft * self.k, soft * self.k3, self.c, self.alpha, self.element, self.slip])


def drawn(random: np.random.Generator, rough: bool) -> Device:
    """Draw a device such as real clamps are."""
    k = 10 ** random.uniform(2.5, 3.2)
    element = random.uniform(0.05, 0.2) * k if rough else 0.0
    return Device(
        k, random.uniform(-0.15, 0.3) * k, random.uniform(-0.4, 0.0), random.uniform(0.01, 0.03) * k,
        random.uniform(0.2, 0.7), element, random.uniform(0.1, 0.5) * element,
    )  # fmt: skip


@njit(cache=True)
def _plain(y, v, numbers):
    k, k3, c, alpha = numbers[0], numbers[1], numbers[2], numbers[3]
    return k * y + k3 * y**3 + c * (v * v + ROUNDED**2) ** ((alpha - 1) / 2) * v


@njit(cache=True)
def _rate(z, v, numbers):
    if abs(z) >= numbers[5] and z * v > 0:
        return 0.0
    return numbers[4] * v


@njit(cache=True)
def on_machine(y, v, step, numbers):
    """Give the force along a motion in samples, (n,)."""
    force = np.empty_like(y)
    z = 0.0
    for index in range(len(y)):
        if index:
            z += numbers[4] * (y[index] - y[index - 1])
            z = min(max(z, -numbers[5]), numbers[5])
        force[index] = _plain(y[index], v[index], numbers) + z
    return force


@njit(cache=True)
def _slopes(at, drive, omega, zeta, participation, shape, numbers, slopes):
    """Write the rates of modes' places and speeds and of the element's force, (2 M + 1,)."""
    modes = len(omega)
    y, v = 0.0, 0.0
    for mode in range(modes):
        y += 1e3 * shape[mode] * at[mode]
        v += 1e3 * shape[mode] * at[modes + mode]
    force = _plain(y, v, numbers) + at[2 * modes]
    for mode in range(modes):
        speed = at[modes + mode]
        slopes[mode] = speed
        slopes[modes + mode] = (
            participation[mode] * drive - shape[mode] * force
            - 2 * zeta[mode] * omega[mode] * speed - omega[mode] ** 2 * at[mode]
        )  # fmt: skip
    slopes[2 * modes] = _rate(at[2 * modes], v, numbers)


@njit(cache=True)
def on_pipe(frequency, acceleration, cycles, per_cycle, omega, zeta, participation, shape, numbers, state):
    """Give half the peak-to-peak displacement, mm, in the last two cycles under a sine of the base, m/s2.

    Motion goes on from the state, (2 M + 1,): places and speeds of the modes and the element's force. It is moved to
    the end.
    """
    modes, h = len(omega), 1 / (frequency * per_cycle)
    low, high = np.inf, -np.inf
    at, total, slopes = np.empty_like(state), np.empty_like(state), np.empty_like(state)
    for step in range(cycles * per_cycle):
        for place in range(len(state)):
            total[place], slopes[place] = 0.0, 0.0
        for stage in range(4):
            end = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
            drive = acceleration * np.sin(2 * np.pi * (step + end) / per_cycle)
            for place in range(len(state)):
                at[place] = state[place] + end * h * slopes[place]
            _slopes(at, drive, omega, zeta, participation, shape, numbers, slopes)
            for place in range(len(state)):
                total[place] += (1.0 if stage in (0, 3) else 2.0) * slopes[place]
        for place in range(len(state)):
            state[place] += h / 6 * total[place]
        state[2 * modes] = min(max(state[2 * modes], -numbers[5]), numbers[5])
        if step >= (cycles - 2) * per_cycle:
            y = 0.0
            for mode in range(modes):
                y += 1e3 * shape[mode] * state[mode]
            low, high = min(low, y), max(high, y)
    return (high - low) / 2
