"""Whether a law dissipates over closed cycles in its range, tried with the source that the FMU runs.

Cycles are tried at the ends of the range and between them, then sought by an optimiser, which varies A, f, T and the
shape of the motion: no grid has every place where a law might feed energy in.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, ClassVar

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.realise.scalar_law import ScalarLaw

Interval = tuple[float, float]

GRID_POINTS = {"A": 4, "f": 3, "T": 5}
"""Points of the grid along each range, both ends included."""

COARSE, FINE = 128, 2048
"""Samples per cycle, and those of a second look where the coarse ones don't show dissipation clearly."""

SOUGHT = 25
"""Generations in which a cycle that feeds energy in is sought."""

CLEAR_SHARE = 1e-2
"""Dissipation, as a share of the energy moved, that needs no second look; fed in, it needs no worse cycle."""

TIMES_FINER = 4
"""Times the fine samples: what a step of force costs the quadrature falls with it, what a law feeds in stays."""

RESOLVED_SHARE = 1e-5
"""Share of the energy moved below which the fine quadrature can't tell dissipation from none: kinks cost it 1e-6."""

ROUNDING_ENERGY = 1e-25
"""N mm: what 1e6 N/mm take up over the rounding of a millimetre. Less moves where a clearance is just touched."""


@dataclass(frozen=True)
class Cycle:
    """A closed motion y/A = offset + sum of a_n sin(n theta + phase_n); it stays within A.

    Attributes:
        name: for messages.
        harmonics: (n, a_n, phase_n).
        offset: mean displacement over A.
    """

    name: str
    harmonics: tuple[tuple[int, float, float], ...]
    offset: float = 0.0

    BETWEEN: ClassVar[float] = 0.0
    """Where in each of its steps a motion is sampled."""

    def at(self, share: float) -> tuple[float, float]:
        """Give y/A and v/(2 pi f A) after a share of the cycle."""
        theta = 2 * math.pi * share
        y = self.offset + sum(a * math.sin(n * theta + phase) for n, a, phase in self.harmonics)
        return y, sum(n * a * math.cos(n * theta + phase) for n, a, phase in self.harmonics)


@dataclass(frozen=True)
class SawTooth:
    """A closed motion that is quick one way and slow the other, for laws without memory: it turns back at once.

    What pushes along one way gains most where the other way, which costs, is slow.

    Attributes:
        size: half its range over A; below 0 where it is quick towards -y.
        offset: mean displacement over A.
        quick: share of the cycle that the quick way takes, in 64ths: of whole samples.
    """

    size: float
    offset: float
    quick: float

    name: ClassVar[str] = "a saw-tooth"
    BETWEEN: ClassVar[float] = 0.5

    def at(self, share: float) -> tuple[float, float]:
        """Give y/A and v/(2 pi f A) after a share of the cycle."""
        if share < self.quick:
            done, speed = share / self.quick, 1 / self.quick
        else:
            done, speed = (1 - share) / (1 - self.quick), -1 / (1 - self.quick)
        return self.offset + self.size * (2 * done - 1), self.size * speed / math.pi


ClosedMotion = Cycle | SawTooth
"""A closed motion over which a law is accounted for."""


CYCLES_ACCOUNTED = (
    Cycle("a sinusoid", ((1, 1.0, 0.0),)),
    Cycle("a tenth of a sinusoid", ((1, 0.1, 0.0),)),
    Cycle("a small sinusoid on a large offset", ((1, 0.1, 0.0),), 0.9),
    Cycle("a sinusoid with a third harmonic", ((1, 0.6, 0.0), (3, 0.4, 1.0))),
    Cycle("a sinusoid with a second harmonic and an offset", ((1, 0.5, 0.0), (2, 0.2, 0.5)), -0.3),
)


@dataclass(frozen=True)
class Balance:
    """What a cycle did: dissipated energy and moved energy (integral of |F dy|), N mm."""

    dissipated: float
    moved: float

    @property
    def share(self) -> float:
        """Dissipated over moved energy."""
        return self.dissipated / self.moved if self.moved > ROUNDING_ENERGY else 0.0


def moved_about(law: ScalarLaw, place: float) -> ScalarLaw:
    """Give a law whose displacements count from where its tests moved, mm: all closed motions lie within A of there."""

    def step(
        k: Any, state: tuple[float, ...], y_previous: float, y: float, v: float, h: float
    ) -> tuple[float, float, tuple[float, ...]]:
        return law.step(k, state, place + y_previous, place + y, v, h)

    return replace(law, step=step) if place else law


def balance(law: ScalarLaw, cycle: ClosedMotion, where: Sequence[float], samples: int) -> Balance:
    """Run a cycle twice, so that memory has settled, and account for the second time round.

    What a law without memory does at rest depends on the displacement alone, so that it gives back what it took: only
    the rest is accounted for, and a step of force costs the quadrature nothing.

    Args:
        law: the law.
        cycle: the motion.
        where: amplitude (mm) and frequency (Hz) of the motion and of the law's coefficients, temperature (K), further
            conditions in the law's units.
        samples: per cycle.
    """
    A, f, *_ = where
    k = law.coefficients(*where)
    h = 1 / (f * samples)
    angular = 2 * math.pi * f
    motion = [(A * y, A * angular * v) for y, v in _over_amplitude(cycle, samples)]
    state = tuple(start for _, start in law.states)
    y_previous = motion[0][0]
    law.step(k, state, y_previous, y_previous, 0.0, 0.0)  # as where conditions change: it must have a value there
    work = moved = before = energy = 0.0
    for turn in range(2 if law.states else 1):
        work = moved = 0.0
        for y, v in motion:
            force, energy, state = law.step(k, state, y_previous, y, v, h)
            still = 0.0 if law.states else law.step(k, state, y, y, 0.0, h)[0]
            work += (force - still) * v * h
            moved += abs(force * v) * h
            y_previous = y
        if turn == 0:
            before = energy
    return Balance(work - (energy - before) if law.states else work, moved)


@lru_cache(maxsize=16)
def _over_amplitude(cycle: ClosedMotion, samples: int) -> list[tuple[float, float]]:
    """Give y/A and v/(2 pi f A) at so many samples; a grid asks for the same cycles under all its conditions."""
    return [cycle.at((index + cycle.BETWEEN) / samples) for index in range(samples)]


def _points(interval: Interval, count: int) -> list[float]:
    low, high = interval
    shares = [index / (count - 1) for index in range(count)] if high > low else [0.0]
    return [low * (1 - share) + high * share for share in shares]


def conditions(
    range_A: Interval, range_f: Interval, range_T: Interval, *further: Interval
) -> Iterator[tuple[float, ...]]:
    """Give the grid of A (mm), f (Hz), T (K) and the ends of further conditions on which cycles are tried."""
    return itertools.product(
        _points(range_A, GRID_POINTS["A"]),
        _points(range_f, GRID_POINTS["f"]),
        _points(range_T, GRID_POINTS["T"]),
        *(_points(interval, 2) for interval in further),
    )


def require_dissipation(
    name: str,
    law: ScalarLaw,
    range_A: Interval,
    range_f: Interval,
    range_T: Interval,
    *further: Interval,
    begin: Sequence[tuple[ClosedMotion, tuple[float, ...]]] = (),
    proved: bool = False,
) -> None:
    """Refuse a law that gives energy over some closed cycle in its range.

    Args:
        name: the law's name, for the message.
        law: the law.
        range_A: mm.
        range_f: Hz.
        range_T: K.
        further: of further conditions, in the law's units.
        begin: cycles, and the conditions for them, that are tried besides.
        proved: whether it is proved that there is none: then only values that aren't finite are looked for.

    Raises:
        UserError: a cycle dissipates less than nothing, or the law has no finite value on it.
    """
    worst: tuple[float, ClosedMotion, tuple[float, ...], Balance] | None = None
    grid = itertools.product(CYCLES_ACCOUNTED, conditions(range_A, range_f, range_T, *further))
    tried = itertools.chain(begin, grid)
    if proved:
        for cycle, where in tried:
            _finite(name, law, cycle, where, COARSE)
        return
    for cycle, where in tried:
        result = _accounted(name, law, cycle, where)
        if worst is None or result.share < worst[0]:
            worst = (result.share, cycle, where, result)
        if result.share < -CLEAR_SHARE:
            break
    if worst is not None and worst[0] >= -RESOLVED_SHARE:
        for cycle, where in _sought(law, (range_A, range_f, range_T, *further)):
            result = _accounted(name, law, cycle, where)
            worst = min(worst, (result.share, cycle, where, result), key=lambda found: found[0])
    if worst is not None and worst[0] < -RESOLVED_SHARE:
        _, cycle, where, result = worst
        raise UserError(
            f"law {name!r} would create energy: {_at(cycle, where)} gives {-1e-3 * result.dissipated:.3g} J per cycle "
            f"({-100 * worst[0]:.3g}% of the energy moved); expected dissipation above 0 over every closed cycle. "
            f"{REMEDY}"
        )


def _accounted(name: str, law: ScalarLaw, cycle: ClosedMotion, where: tuple[float, ...]) -> Balance:
    """Account for a cycle, finely where it doesn't dissipate clearly.

    Raises:
        UserError: the law has no finite value on it.
    """
    result = _finite(name, law, cycle, where, COARSE)
    if result.share < CLEAR_SHARE:
        result = _finite(name, law, cycle, where, FINE)
    if result.share < -RESOLVED_SHARE and law.states:
        finer = _finite(name, law, cycle, where, TIMES_FINER * FINE)
        shrunk = abs(finer.share) < abs(result.share) / 2
        result = Balance(0.0, finer.moved) if shrunk else finer
    return result


def _finite(name: str, law: ScalarLaw, cycle: ClosedMotion, where: tuple[float, ...], samples: int) -> Balance:
    """Account for a cycle at so many samples.

    Raises:
        UserError: the law has no finite value on it.
    """
    try:
        result = balance(law, cycle, where, samples)
    except (ArithmeticError, ValueError, TypeError) as error:
        raise UserError(f"law {name!r} has no value for {_at(cycle, where)} ({error}); {REMEDY}") from error
    if not math.isfinite(result.dissipated):
        raise UserError(f"law {name!r} has no finite force for {_at(cycle, where)}; {REMEDY}")
    return result


def _sought(law: ScalarLaw, ranges: Sequence[Interval]) -> Iterator[tuple[ClosedMotion, tuple[float, ...]]]:
    """Seek the cycle and the conditions with the least dissipation, of each kind of cycle."""

    def of_sines(size: float, shift: float, third: float, phase: float) -> ClosedMotion:
        harmonics = ((1, size * (1 - third), 0.0), (3, size * third, phase))
        return Cycle("a motion", harmonics, shift * (1 - size))

    def saw_tooth(size: float, shift: float, quick: float) -> ClosedMotion:
        return SawTooth(size, shift * (1 - abs(size)), round(quick) / 64)

    yield _least(law, of_sines, [(0.02, 1.0), (-1.0, 1.0), (0.0, 0.6), (0.0, math.pi)], ranges)
    if not law.states:
        yield _least(law, saw_tooth, [(-1.0, 1.0), (-1.0, 1.0), (1.0, 32.0)], ranges)


def _least(
    law: ScalarLaw, motion_of: Callable[..., ClosedMotion], shape: Sequence[Interval], ranges: Sequence[Interval]
) -> tuple[ClosedMotion, tuple[float, ...]]:
    """Seek by differential evolution.

    Args:
        law: the law.
        motion_of: gives a motion of its shape.
        shape: ranges of what a motion's shape is given by; ranges: of the conditions.
    """
    # needed for laws alone of which nothing is proved
    from scipy.optimize import differential_evolution

    def met(place: Sequence[float]) -> tuple[ClosedMotion, tuple[float, ...]]:
        return motion_of(*place[: len(shape)]), tuple(place[len(shape) :])

    def share(place: Sequence[float]) -> float:
        try:
            found = balance(law, *met(place), COARSE).share
        except (ArithmeticError, ValueError, TypeError):
            return 1.0
        return found if math.isfinite(found) else 1.0

    found = differential_evolution(
        share, [*shape, *ranges], popsize=6, maxiter=SOUGHT, seed=0, tol=1e-6, polish=False, init="sobol"
    )
    return met(found.x.tolist())


REMEDY = "Identify the law again with other effects or bounds, or give it a narrower range"


def _at(cycle: ClosedMotion, where: tuple[float, ...]) -> str:
    A, f, T, *further = where
    more = f", further conditions {', '.join(f'{value:g}' for value in further)}" if further else ""
    return f"{cycle.name} within A = {A:g} mm at f = {f:g} Hz, T = {T:g} K{more}"
