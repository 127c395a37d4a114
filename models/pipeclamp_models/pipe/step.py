"""Exact time stepping of vibration modes for loads that are linear over the step.

One mode: q'' + damping q' + omega^2 q = g(t), damping = 2 zeta omega in 1/s, g linear from g0 to g1 over a step h.
Valid for every omega and damping from 0 on: rigid body, underdamped, critically damped and overdamped modes alike.
The pipe FMU carries this module's text, so it uses the standard library alone.
"""

from __future__ import annotations

TERMS = 14
"""Terms of the power series; with omega h and damping h up to 1/2, the first left out is below 1e-17 of the sum."""

Coefficients = tuple[float, float, float, float, float, float, float, float, float, float, float, float]
"""(q, p, g0, g1) -> q at the end, then -> p = q' at the end, then -> the integral of q over the step."""


def responses(omega: float, damping: float, h: float) -> tuple[float, float, float, float, float]:
    """Give a mode's response to an impulse and its first three integrals.

    Args:
        omega: natural angular frequency, rad/s; 0 for a rigid body mode.
        damping: 2 zeta omega, 1/s.
        h: time since the impulse, s.

    Returns:
        (velocity, displacement, its integral, its second integral, its third integral) at h after a unit impulse:
        e^(-zeta omega h) sin(omega_d h)/omega_d is the second. The power series at h/2^n is exact to rounding, and the
        response at 2 h follows from the one at h (the state there is the start of the second half).
    """
    stiffness = omega * omega
    doublings = 0
    t = h
    while t * omega > 0.5 or t * damping > 0.5:
        t *= 0.5
        doublings += 1
    term, following = t, -damping * t * t / 2
    velocity = displacement = first = second = third = 0.0
    for n in range(1, TERMS + 1):
        velocity += n * term
        displacement += term
        first += term / (n + 1)
        second += term / ((n + 1) * (n + 2))
        third += term / ((n + 1) * (n + 2) * (n + 3))
        term, following = (
            following,
            -(damping * t * following + stiffness * t * t * term / (n + 1)) / (n + 2),
        )
    velocity /= t
    first *= t
    second *= t * t
    third *= t * t * t
    for _ in range(doublings):
        held = velocity + damping * displacement  # response to a unit displacement at the start
        third += t * (second + t * first / 2) + held * third + displacement * second
        second += t * first + held * second + displacement * first
        first += held * first + displacement * displacement
        velocity, displacement = (
            velocity * velocity - stiffness * displacement * displacement,
            displacement * (held + velocity),
        )
        t *= 2
    return velocity, displacement, first, second, third


def coefficients(omega: float, damping: float, h: float) -> Coefficients:
    """Give what one mode's exact step is made of; the same for all steps of one length.

    Args:
        omega: natural angular frequency, rad/s; 0 for a rigid body mode.
        damping: 2 zeta omega, 1/s.
        h: step, s, above 0.
    """
    velocity, displacement, first, second, third = responses(omega, damping, h)
    stiffness = omega * omega
    return (
        velocity + damping * displacement,
        displacement,
        first - second / h,
        second / h,
        -stiffness * displacement,
        velocity,
        displacement - first / h,
        first / h,
        h - stiffness * second,
        first,
        second - third / h,
        third / h,
    )


def step(k: Coefficients, q: float, p: float, g0: float, g1: float) -> tuple[float, float, float]:
    """Step one mode.

    Args:
        k: what `coefficients` gave.
        q: modal displacement at the start.
        p: modal velocity q' at the start.
        g0: modal load at the start.
        g1: modal load at the end.

    Returns:
        q and p at the end, and the integral of q over the step, exact for a linear load.
    """
    return (
        k[0] * q + k[1] * p + k[2] * g0 + k[3] * g1,
        k[4] * q + k[5] * p + k[6] * g0 + k[7] * g1,
        k[8] * q + k[9] * p + k[10] * g0 + k[11] * g1,
    )


def work(load0: float, load1: float, s0: float, s1: float, mean: float) -> float:
    """Give the work of a load that is linear over a step, exactly (the integral of load times velocity, by parts).

    Args:
        load0: load at the start, N.
        load1: load at the end, N.
        s0: displacement of its point at the start, m.
        s1: displacement at the end, m.
        mean: mean displacement over the step (integral over h), m.
    """
    return load0 * (s1 - s0) + (load1 - load0) * (s1 - mean)
