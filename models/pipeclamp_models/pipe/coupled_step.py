"""Exact time stepping of modes that axial force and flow couple, for loads that are linear over the step.

q'' + C q' + K q = g(t), C and K any square matrices, g linear from g0 to g1 over a step h. The pipe FMU carries this
module's text, so it uses the standard library alone.
"""

from __future__ import annotations

from operator import mul

TERMS = 16
"""Terms of the power series; with the matrix' norm times the step up to 1/2, the first left out is below 1e-18."""

Matrix = list[list[float]]
Rows = tuple[tuple[float, ...], ...]


def product(a: Matrix, b: Matrix) -> Matrix:
    """Give the product of two matrices."""
    columns = list(zip(*b, strict=True))
    return [[sum(map(mul, row, column)) for column in columns] for row in a]


def total(*weighted: tuple[float, Matrix]) -> Matrix:
    """Give the sum of matrices, each with its factor."""
    factors = [factor for factor, _ in weighted]
    return [
        [sum(map(mul, factors, entries)) for entries in zip(*rows, strict=True)]
        for rows in zip(*[matrix for _, matrix in weighted], strict=True)
    ]


def integrals(generator: Matrix, h: float) -> list[Matrix]:
    """Give e^(A h) and its first three integrals over time from 0 to h.

    The power series at h/2^n is exact to rounding; from the integrals E_j at t those at 2 t follow, because the state
    at t is the start of the second half: E_j(2t) = sum over i of t^i/i! E_(j-i)(t) + E_0 E_j, i below j.
    """
    norm = max(sum(map(abs, row)) for row in generator)
    doublings, t = 0, h
    while t * norm > 0.5:
        t *= 0.5
        doublings += 1
    size = range(len(generator))
    identity = [[1.0 if row == column else 0.0 for column in size] for row in size]
    scaled = total((t, generator))
    power = identity
    # Sums over n of (A t)^n t^j/(n + j)!.
    sums = [total((0.0, identity)) for _ in range(4)]
    factorial = 1.0
    for n in range(TERMS + 1):
        factorial *= max(n, 1)
        weight = 1.0 / factorial
        for j in range(4):
            sums[j] = total((1.0, sums[j]), (weight, power))
            weight *= t / (n + j + 1)
        power = product(power, scaled)
    zeroth, first, second, third = sums
    for _ in range(doublings):
        third = total((1.0, third), (t, second), (t * t / 2, first), (1.0, product(zeroth, third)))
        second = total((1.0, second), (t, first), (1.0, product(zeroth, second)))
        first = total((1.0, first), (1.0, product(zeroth, first)))
        zeroth = product(zeroth, zeroth)
        t *= 2
    return [zeroth, first, second, third]


def transition(stiffness: Rows, damping: Rows, h: float) -> Rows:
    """Give the matrix that maps (q, q', g0, g1) to (q, q', integral of q) over a step, (3 n, 4 n).

    Args:
        stiffness: K, 1/s2, (n, n).
        damping: C, 1/s, (n, n).
        h: step, s, above 0.
    """
    n = len(stiffness)
    # Over (w q, q') with w about the highest frequency the generator's entries are alike, which saves doublings.
    w = max(1.0, max(sum(map(abs, row)) for row in stiffness)) ** 0.5
    still = [0.0] * n
    generator = [[*still, *[w if row == column else 0.0 for column in range(n)]] for row in range(n)]
    generator += [[-k / w for k in stiffness[row]] + [-c for c in damping[row]] for row in range(n)]
    zeroth, first, second, third = integrals(generator, h)
    ends = _rows(zeroth, total((1.0, first), (-1 / h, second)), total((1 / h, second)), w)
    means = _rows(first, total((1.0, second), (-1 / h, third)), total((1 / h, third)), w)
    return (*ends, *means[:n])


def _rows(start: Matrix, held: Matrix, ramp: Matrix, w: float) -> Rows:
    """Give the rows over (q, q', g0, g1) from matrices over (w q, q')."""
    n = len(start) // 2
    scales = [1 / w] * n + [1.0] * n
    return tuple(
        (
            *[scale * w * entry for entry in at_start[:n]],
            *[scale * entry for entry in at_start[n:]],
            *[scale * entry for entry in first[n:]],
            *[scale * entry for entry in last[n:]],
        )
        for scale, at_start, first, last in zip(scales, start, held, ramp, strict=True)
    )


def step_coupled(
    rows: Rows, q: tuple[float, ...], p: tuple[float, ...], g0: tuple[float, ...], g1: tuple[float, ...]
) -> tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]:
    """Step all modes.

    Args:
        rows: what `transition` gave.
        q: modal displacements at the start.
        p: modal velocities at the start.
        g0: modal loads at the start.
        g1: modal loads at the end.

    Returns:
        q and p at the end, and the integral of q over the step, exact for linear loads.
    """
    n, given = len(q), (*q, *p, *g0, *g1)
    moved = tuple([sum(map(mul, row, given)) for row in rows])
    return moved[:n], moved[n : 2 * n], moved[2 * n :]
