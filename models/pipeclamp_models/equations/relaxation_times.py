"""Relaxation times: over the temperature as Williams, Landel and Ferry's, and where tests may bring them into view."""

import sympy as sp

from pipeclamp_models.equations.symbols import T_0, T_highest, T_lowest, f_highest, f_lowest

SLOPE = -4.0
"""Log change of relaxation times in 100 K: an elastomer's, some 50 K above its glass transition."""
ABOVE_STILL = 120.0
"""K, how far above the temperature below which nothing relaxes."""
STILL = sp.Rational(1, 10)
"""Share of that above its lower end at which times are held: within it they would pass all bounds."""


def log_factor(difference: sp.Expr, slope: sp.Expr, above_still: sp.Expr) -> sp.Expr:
    """Give ln a_T, by which relaxation times change with the temperature.

    Args:
        difference: of the temperature from the one that the times are stated at, K.
        slope: the change's slope there, in 100 K.
        above_still: how far that lies above the temperature below which nothing relaxes any more, K.
    """
    held = sp.Max(difference, (STILL - 1) * above_still)
    return slope * held / 100 / (1 + held / above_still)


slowest, fastest = 1 / (2 * sp.pi * f_lowest), 1 / (2 * sp.pi * f_highest)
STARTS = (slowest, sp.sqrt(slowest * fastest), fastest)
LOWER, UPPER = fastest / 20, slowest * 20
"""Faster ones act as a dashpot, slower ones as a spring, in every test."""

NEAREST = sp.Min(sp.Max(T_0, T_lowest), T_highest)
"""Of the temperatures tested the one nearest to T0, that the times are stated at."""
COLDEST, HOTTEST = (sp.exp(-log_factor(end - NEAREST, SLOPE, ABOVE_STILL)) for end in (T_lowest, T_highest))
"""Factors on a time that is seen near T0, for one that is seen at the coldest or the hottest test."""
