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
def _acceleration(q, w, z, omega, zeta, participation, shape, drive, numbers):
    y, v = 0.0, 0.0
    for mode in range(len(q)):
        y += 1e3 * shape[mode] * q[mode]
        v += 1e3 * shape[mode] * w[mode]
    force = _plain(y, v, numbers) + z
    given = np.empty_like(q)
    for mode in range(len(q)):
        given[mode] = (
            participation[mode] * drive - shape[mode] * force
            - 2 * zeta[mode] * omega[mode] * w[mode] - omega[mode] ** 2 * q[mode]
        )  # fmt: skip
    return given, _rate(z, v, numbers)


@njit(cache=True)
def on_pipe(frequency, acceleration, cycles, per_cycle, omega, zeta, participation, shape, numbers):
    """Give half the peak-to-peak displacement, mm, in the last two cycles under a sine of the base, m/s2."""
    q, w, z = np.zeros_like(omega), np.zeros_like(omega), 0.0
    h = 1 / (frequency * per_cycle)
    low, high = np.inf, -np.inf
    for step in range(cycles * per_cycle):
        ends = (0.0, 0.5, 0.5, 1.0)
        sum_q, sum_w, sum_z = np.zeros_like(q), np.zeros_like(q), 0.0
        slope_q, slope_w, slope_z = np.zeros_like(q), np.zeros_like(q), 0.0
        for stage in range(4):
            drive = acceleration * np.sin(2 * np.pi * (step + ends[stage]) / per_cycle)
            at_q, at_w = q + ends[stage] * h * slope_q, w + ends[stage] * h * slope_w
            at_z = z + ends[stage] * h * slope_z
            slope_q = at_w
            slope_w, slope_z = _acceleration(at_q, at_w, at_z, omega, zeta, participation, shape, drive, numbers)
            weight = 1.0 if stage in (0, 3) else 2.0
            sum_q, sum_w, sum_z = sum_q + weight * slope_q, sum_w + weight * slope_w, sum_z + weight * slope_z
        q, w = q + h / 6 * sum_q, w + h / 6 * sum_w
        z = min(max(z + h / 6 * sum_z, -numbers[5]), numbers[5])
        if step >= (cycles - 2) * per_cycle:
            y = 0.0
            for mode in range(len(q)):
                y += 1e3 * shape[mode] * q[mode]
            low, high = min(low, y), max(high, y)
    return (high - low) / 2
