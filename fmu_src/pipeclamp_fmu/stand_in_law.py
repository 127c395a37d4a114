"""A law in the form in which laws enter the clamp slave: what the builder replaces by a generated one.

`clamp_slave` imports from here so that it is an ordinary module, linted, type-checked and usable without an FMU. The
numbers are round ones of the size of the published clamp; they are nobody's measurements.
"""

from __future__ import annotations

LAW_NAME = "stand-in"
RANGE_A = (0.2, 1.0)
RANGE_f = (1.0, 5.0)
RANGE_T = (293.15, 573.15)
FURTHER: tuple[tuple[str, float, tuple[float, float], bool, float], ...] = ()
"""Further conditions: name, law's unit in the FMU's, range in the law's unit, whether it must be above 0, start."""
COUNTED = -1
"""Place among them of the load cycles that the clamp has seen, -1 for none."""

STATES: tuple[tuple[str, float], ...] = (("z", 0.0),)


def coefficients(A: float, f: float, T: float, *further: float) -> tuple[float, ...]:
    """Give (k1, k3, c, (alpha - 1)/2) for A in mm, f in Hz, T in K, and further conditions."""
    return (1200.0 * A**-0.2, 150.0, 180.0 * (T / 293.15) ** -0.3, (0.47 * f**0.012 - 1.0) / 2)


def step(
    k: tuple[float, ...], state: tuple[float, ...], y_previous: float, y: float, v: float, h: float
) -> tuple[float, float, tuple[float, ...]]:
    """Give force (N), stored energy (N mm), new state after a move from `y_previous` to `y` (mm) in `h` seconds."""
    k1, k3, c, exponent = k
    (z,) = state
    z = min(max(z + 500.0 * (y - y_previous), -60.0), 60.0)
    force = k1 * y + k3 * y**3 + c * v * (v * v + 0.0126**2) ** exponent + z
    return force, k1 * y * y / 2 + k3 * y**4 / 4 + z * z / 1000.0, (z,)
