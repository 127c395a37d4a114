"""A law in the form in which laws enter the clamp slave: what the builder replaces by a generated one.

`clamp_slave` imports from here so that it is an ordinary module, linted, type-checked and usable without an FMU. No
number of a law is in it: those are read from the file of values.
"""

from __future__ import annotations

from collections.abc import Sequence

FURTHER: tuple[tuple[str, str, float, bool], ...] = ()
"""Further conditions: name, the law's unit, that unit in the FMU's, whether it must be above 0."""
COUNTED = -1
"""Place among them of the load cycles that the clamp has seen, -1 for none."""
PARTS = 1
"""In how many a step is walked: more than one where its memory jumps."""
COEFFICIENTS = ("k10", "k1_A", "k30", "c0", "c_T", "alpha0", "alpha_f", "k_s", "z_s", "v_r")
"""Names of the law's coefficients, in the order in which it takes them."""

STATES: tuple[tuple[str, float], ...] = (("z", 0.0),)
CONDITIONS: tuple[str, ...] = ()
"""Names of the further conditions in the law's source."""


def coefficients(p: Sequence[float], A: float, f: float, T: float, *further: float) -> tuple[float, ...]:
    """Give what holds through a step, for A in mm, f in Hz, T in K, and further conditions."""
    k10, k1_A, k30, c0, c_T, alpha0, alpha_f, k_s, z_s, v_r = p
    return (k10 * A**k1_A, k30, c0 * (T / 293.15) ** c_T, (alpha0 * f**alpha_f - 1.0) / 2, k_s, z_s, v_r**2)


def step(
    k: tuple[float, ...], state: tuple[float, ...], y_previous: float, y: float, v: float, h: float
) -> tuple[float, float, tuple[float, ...]]:
    """Give force (N), stored energy (N mm), new state after a move from `y_previous` to `y` (mm) in `h` seconds."""
    k1, k3, c, exponent, k_s, z_s, smoothing = k
    (z,) = state
    z = min(max(z + k_s * (y - y_previous), -z_s), z_s)
    force = k1 * y + k3 * y**3 + c * v * (v * v + smoothing) ** exponent + z
    return force, k1 * y * y / 2 + k3 * y**4 / 4 + z * z / (2.0 * k_s), (z,)
