"""Control of the macro step by the coupling's energy error.

The energy error says where pipe and clamps see different forces and motions; it doesn't see an error of phase alone.
"""

from __future__ import annotations

from collections.abc import Iterator

from pipeclamp_system.coupling.march import Advance, Point, System, initial_point

MOST_HALVINGS = 10
"""A step is halved at most so many times; the shortest one is taken whatever its error."""

CALM, CALM_STEPS = 0.15, 20
"""A step is doubled after so many steps in a row whose error was below this share of the tolerance.

So many, because the power that is exchanged passes zero twice a cycle, where every step looks good.
"""

STARTING, STARTING_HALVINGS = 8, 5
"""Out of rest no power is there to judge an error by: so many steps are taken as they are, at the longest's 1/32."""


def energy_error(start: Point, end: Point) -> tuple[float, float]:
    """Give the energy that the coupling made in a step and the power that was exchanged, J and W.

    The clamps are taken to receive the trapezoid of their forces over the straight way; the pipe gives the forces that
    it was told, linear over its motion, which is cubic (Hermite) between the ends. So what both bend in a step counts.
    """
    h = end.time - start.time
    made = power = 0.0
    told = zip(start.told, end.told, strict=True)
    forces = zip(start.force, end.force, strict=True)
    places = zip(start.displacement, end.displacement, strict=True)
    speeds = zip(start.velocity, end.velocity, strict=True)
    for (g0, g1), (f0, f1), (s0, s1), (v0, v1) in zip(told, forces, places, speeds, strict=True):
        mean = (s0 + s1) / 2 + h * (v0 - v1) / 12
        made += (f0 + f1) / 2 * (s1 - s0) - (g0 * (s1 - s0) + (g1 - g0) * (s1 - mean))
        power += abs(f1 * v1)
    return abs(made), power


def march_controlled(
    system: System, advance: Advance, longest: float, stop: float, tolerance: float
) -> Iterator[Point]:
    """Step a coupled system through time in steps as long as the coupling's energy error allows.

    Steps are the longest one or a power of two shorter. A step is taken again, half as long, where the energy that the
    coupling made exceeds `tolerance` of what pipe and clamps could have exchanged in it (the largest power so far).

    Args:
        system: participants that are initialised at time 0.
        advance: a scheme that rolls back.
        longest: longest step, s.
        stop: end, s.
        tolerance: share of the exchanged energy.

    Raises:
        UserError: as the scheme.
    """
    participants = (system.pipe, *system.clamps)
    point = initial_point(system)
    advance.accept(point)
    yield point
    halvings, calm, largest_power = STARTING_HALVINGS, 0, 0.0
    while point.time < stop * (1 - 1e-12):
        h = longest / 2**halvings
        h = min(h, stop - point.time) if stop - point.time < h * (1 - 1e-9) else h
        trial = advance.advance(point, point.time, h)
        made, power = energy_error(point, trial)
        allowed = tolerance * max(largest_power, power) * h
        if made > allowed and halvings < MOST_HALVINGS and point.index >= STARTING:
            halvings, calm = halvings + 1, 0
            for participant in participants:
                participant.restore()
            continue
        calm = calm + 1 if made <= CALM * allowed else 0
        if calm >= CALM_STEPS and halvings:
            halvings, calm = halvings - 1, 0
        largest_power = max(largest_power, power)
        advance.accept(trial)
        point = trial
        yield point
