"""The truth of virtual campaigns: motion, base law and time stepping, written from the published equations alone.

Nothing here may share code with the package that is put to the test: other formulas, other steps, plain NumPy.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

SUBSTEPS = 8
"""Steps of the truth between two samples."""
LEAD_CYCLES = 2
"""Cycles before the record, in which friction forgets the state of rest."""
T0 = 293.15


@dataclass(frozen=True)
class Motion:
    """What the rig does to a batch of R runs of one frequency, in n fine steps.

    Attributes:
        time: s, (n,), zero at the first sample of the record, negative in the lead.
        y, v, a: displacement, velocity, acceleration in mm, s, (R, n).
        tones: order and complex amplitude (R,) in mm of each tone: y = sum Re(tone exp(i order w t)).
        A, T, rho, u, first_cycle: amplitude mm, temperature K, density g/cm3, further condition, cycles seen, (R, 1).
        f: Hz.
        random: (R, 4) standard normal numbers, for what differs from run to run.
        memory: results that don't depend on the effect's size.
    """

    time: Array
    y: Array
    v: Array
    a: Array
    tones: tuple[tuple[int, npt.NDArray[np.complex128]], ...]
    A: Array
    T: Array
    rho: Array
    u: Array
    first_cycle: Array
    f: float
    random: Array
    memory: dict[Hashable, Array] = field(default_factory=dict)

    @property
    def step(self) -> float:
        """Fine step in s."""
        return float(self.time[1] - self.time[0])

    @property
    def cycles_seen(self) -> Array:
        """Load cycles that the specimen has seen, (R, n)."""
        return self.first_cycle + self.f * np.maximum(self.time, 0.0)

    def remember(self, key: Hashable, compute: Callable[[], Array]) -> Array:
        """Give what was computed before under this key, or compute it."""
        if key not in self.memory:
            self.memory[key] = compute()
        return self.memory[key]


def drive(
    tones: Mapping[int, npt.NDArray[np.complex128]], f: float, rate: float, samples: int
) -> tuple[Array, Array, Array, Array]:
    """Give time (n,), and y, v, a (R, n) of a drive of several tones, on the fine steps of the truth.

    Args:
        tones: complex amplitude (R,) in mm by order.
        f: fundamental in Hz.
        rate: samples per second.
        samples: in the record.
    """
    lead = round(LEAD_CYCLES * rate / f) * SUBSTEPS
    time = (np.arange(lead + samples * SUBSTEPS) - lead) / (rate * SUBSTEPS)
    rotation = np.exp(2j * np.pi * f * time)
    channels = []
    for derivative in range(3):
        total = sum(
            tone[:, None] * (2j * np.pi * order * f) ** derivative * rotation**order for order, tone in tones.items()
        )
        channels.append(np.real(total))
    return time, channels[0], channels[1], channels[2]


@dataclass(frozen=True)
class BaseLaw:
    """Coefficients of the base law."""

    k10: float
    k1_A: float
    k1_T: float
    k30: float
    k3_A: float
    k3_T: float
    c0: float
    c_A: float
    c_f: float
    alpha0: float
    alpha_A: float
    alpha_f: float

    def k1(self, motion: Motion) -> Array:
        """Linear stiffness, N/mm, (R, 1)."""
        return self.k10 * motion.A**self.k1_A * (motion.T / T0) ** self.k1_T

    def k3(self, motion: Motion) -> Array:
        """Cubic stiffness, N/mm3, (R, 1)."""
        return self.k30 * motion.A**self.k3_A * (motion.T / T0) ** self.k3_T

    def elastic(self, motion: Motion, x: Array) -> Array:
        """Elastic force, N."""
        return x * (self.k1(motion) + self.k3(motion) * x**2)

    def c(self, motion: Motion) -> Array:
        """Damping coefficient, N at 1 mm/s, (R, 1)."""
        return self.c0 * motion.A**self.c_A * motion.f**self.c_f

    def alpha(self, motion: Motion) -> Array:
        """Exponent of the velocity, (R, 1)."""
        return self.alpha0 * motion.A**self.alpha_A * motion.f**self.alpha_f

    def damping(self, motion: Motion) -> Array:
        """Damping force, N."""
        return self.c(motion) * np.copysign(np.abs(motion.v) ** self.alpha(motion), motion.v)


@dataclass(frozen=True)
class Part:
    """What one hidden effect does: factors on the base law's parts, and what it adds.

    Attributes:
        stiffness, damping: factors on the elastic and the damping force, broadcast to (R, n).
        x: what stands for y in the elastic force, or None.
        ends: of clearances before equal shares of the clamp: where the share's end is, mm, and which end of the
            clearance pushes it (1, -1 or 0), each (R, n).
        force: added to the clamp's force, N.
        channel: what the force channel makes of the force, or None: a function of (motion, force).
    """

    stiffness: Array | float = 1.0
    damping: Array | float = 1.0
    x: Array | None = None
    ends: tuple[tuple[Array, Array], ...] = ()
    force: Array | float = 0.0
    channel: Callable[[Motion, Array], Array] | None = None


def force(base: BaseLaw, motion: Motion, parts: tuple[Part, ...], scatter: tuple[float, float] = (0.0, 0.0)) -> Array:
    """Integrate the force of a batch of runs, on the fine steps.

    Args:
        base: the base law.
        motion: the batch.
        parts: what is hidden in the truth.
        scatter: standard deviation from run to run of stiffness and of damping, as shares.

    Returns:
        (R, n) in N, what an ideal force sensor shows.
    """
    x = next((part.x for part in parts if part.x is not None), motion.y)
    stiffness: Array = 1.0 + scatter[0] * motion.random[:, :1]
    damping: Array = 1.0 + scatter[1] * motion.random[:, 1:2]
    for part in parts:
        stiffness = stiffness * part.stiffness
        damping = damping * part.damping
    added = sum((part.force for part in parts), damping * base.damping(motion))
    total = stiffness * base.elastic(motion, x) + added
    ends = [end for part in parts for end in part.ends]
    if ends:
        shares = [pushed_through(stiffness * base.elastic(motion, place) + added, side) for place, side in ends]
        total = np.mean(shares, axis=0)
    for part in parts:
        if part.channel is not None:
            total = part.channel(motion, total)
    return total


def jenkins(motion: Motion, limits: Array) -> Array:
    """Mean of elastic-slip elements of unit stiffness with these elastic limits, mm, (R, n): clipped step by step."""
    start = np.zeros((len(motion.y), len(limits)))
    moves = np.diff(motion.y, axis=1, prepend=motion.y[:, :1]).T[:, :, None]
    result = np.empty_like(motion.y.T)
    z = start
    for step, move in enumerate(moves):
        z = np.minimum(np.maximum(z + move, -limits), limits)
        result[step] = z.mean(axis=1)
    return result.T


def jenkins_of_two_limits(motion: Motion, up: float, down: float) -> Array:
    """An element of unit stiffness that slips at `up` and at -`down`, mm, (R, n)."""
    result = np.empty_like(motion.y.T)
    z = np.zeros(len(motion.y))
    for step, move in enumerate(np.diff(motion.y, axis=1, prepend=motion.y[:, :1]).T):
        z = np.clip(z + move, -down, up)
        result[step] = z
    return result.T


def flag(motion: Motion, out: float, back: float) -> Array:
    """An element of unit stiffness on each side that gives way at `out`, comes back at `back`, mm, (R, n).

    Phase changes one way from `out` and the other way from `back`, by what it takes to stay between them.
    """
    result = np.empty_like(motion.y.T)
    changed = np.zeros(len(motion.y))
    for step, place in enumerate(motion.y.T):
        side = np.where(changed != 0, np.sign(changed), np.sign(place))
        stretch = side * (place - changed)
        moved = np.maximum(stretch - out, 0.0) - np.minimum(np.maximum(back - stretch, 0.0), np.abs(changed))
        changed = changed + side * moved
        result[step] = place - changed
    return result.T


def iwan(motion: Motion, limit: float, chi: float, peak: float, count: int) -> Array:
    """Slip displacements spread as phi^chi up to `limit`, and a share at it, of unit stiffness, mm, (R, n).

    Evenly spaced elements, many of them, weighted by the spread in their middle.
    """
    limits = limit * (np.arange(count) + 0.5) / count
    weights = limits**chi
    weights *= (1 - peak) / weights.sum()
    limits, weights = np.append(limits, limit), np.append(weights, peak)
    result = np.empty_like(motion.y.T)
    z = np.zeros((len(motion.y), count + 1))
    for step, move in enumerate(np.diff(motion.y, axis=1, prepend=motion.y[:, :1]).T):
        z = np.minimum(np.maximum(z + move[:, None], -limits), limits)
        result[step] = z @ weights
    return result.T


def bouc_wen(motion: Motion, limit: float, n: float, pinch: Callable[[Array, Array], Array] | None = None) -> Array:
    """Hysteresis of unit stiffness, mm, (R, n): dz/dy = 1 - |z/limit|^n while |z| grows, else 1; Heun's rule.

    Args:
        motion: the batch.
        limit: ultimate force over stiffness, mm.
        n: sharpness.
        pinch: a factor on dz/dy, of z/limit and of the direction.
    """
    result = np.empty_like(motion.y.T)
    z = np.zeros(len(motion.y))

    def slope(force: Array, move: Array) -> Array:
        share = np.clip(force / limit, -1.0, 1.0)
        grows = np.where(share * move > 0, 1 - np.abs(share) ** n, 1.0)
        return grows if pinch is None else grows * pinch(share, np.sign(move))

    for step, move in enumerate(np.diff(motion.y, axis=1, prepend=motion.y[:, :1]).T):
        first = slope(z, move)
        z = z + move * (first + slope(z + move * first, move)) / 2
        result[step] = z
    return result.T


def maxwell(motion: Motion, tau: float) -> Array:
    """Maxwell arm of unit stiffness, mm, (R, n): dq/dt = v - q/tau by the implicit midpoint rule."""
    share = motion.step / (2 * tau)
    v = motion.v.T
    mean = (v[1:] + v[:-1]) / 2 * motion.step
    result = np.zeros_like(v)
    q = np.zeros(len(motion.y))
    for step in range(len(mean)):
        q = (q * (1 - share) + mean[step]) / (1 + share)
        result[step + 1] = q
    return result.T


def maxwell_arms(motion: Motion, taus: Array, weights: Array) -> Array:
    """Maxwell arms of stiffnesses `weights` and times `taus`, mm, (R, n), by the implicit midpoint rule.

    The lead is too short for slow arms to forget rest, so they begin as if they had been moved before.
    """
    share = motion.step / (2 * taus)
    v = motion.v.T[:, :, None]
    result = np.zeros_like(motion.v.T)
    q = np.zeros((len(motion.y), len(taus)))
    for order, tone in motion.tones:
        turn = 2j * np.pi * order * motion.f
        q += np.real(tone[:, None] * np.exp(turn * motion.time[0]) * turn * taus / (1 + turn * taus))
    result[0] = q @ weights
    for step in range(len(v) - 1):
        q = (q * (1 - share) + (v[step] + v[step + 1]) / 2 * motion.step) / (1 + share)
        result[step + 1] = q @ weights
    return result.T


def relieved(motion: Motion, stiffness: float, speed_under: Callable[[Array], Array], force: float) -> Array:
    """Force of a spring in series with a dashpot, N, (R, n): dq/dt = k (v - w(q)), by Rosenbrock's linear midpoint.

    Args:
        motion: the batch.
        stiffness: of the spring, N/mm.
        speed_under: gives the dashpot's speed under forces.
        force: N, of the order of the dashpot's; a millionth of it is the step of a slope.
    """
    v = motion.v.T
    result = np.zeros_like(v)
    q = np.zeros(len(motion.y))
    aside = 1e-6 * force
    for step in range(len(v) - 1):
        speed, ahead = speed_under(q), speed_under(q + aside)
        way = stiffness * motion.step * ((v[step] + v[step + 1]) / 2 - speed)
        q = q + way / (1 + stiffness * motion.step / 2 * (ahead - speed) / aside)
        result[step + 1] = q
    return result.T


def pushed_through(force: Array, side: Array) -> Array:
    """Give what of a force comes through a clearance, of which this end pushes: 1, -1 or 0."""
    return np.where(side > 0, np.maximum(force, 0.0), np.where(side < 0, np.minimum(force, 0.0), 0.0))


def behind_clearance(motion: Motion, base: BaseLaw, clearance: float) -> tuple[Array, Array]:
    """Where the end of the base law's clamp is behind a clearance (half of it, mm), and which end pushes it; (R, n).

    Let go, it stays.
    """
    k1, k3, c, alpha = (entry[:, 0] for entry in (base.k1(motion), base.k3(motion), base.c(motion), base.alpha(motion)))
    place, side = np.empty_like(motion.y.T), np.empty_like(motion.y.T)
    w = np.zeros(len(motion.y))

    def force(there: Array, speed: Array) -> Array:
        return there * (k1 + k3 * there**2) + c * np.copysign(np.abs(speed) ** alpha, speed)

    for step, y in enumerate(motion.y.T):
        lower, upper = y - clearance, y + clearance
        up = force(lower, (lower - w) / motion.step) > 0
        down = ~up & (force(upper, (upper - w) / motion.step) < 0)
        w = np.where(up, lower, np.where(down, upper, np.clip(w, lower, upper)))
        place[step], side[step] = w, up * 1.0 - down
    return place.T, side.T


def late(motion: Motion, force: Array, tau: float) -> Array:
    """The force of tau ago, (R, n), linear between the fine steps."""
    return np.stack([np.interp(motion.time - tau, motion.time, row) for row in force])


def first_order(motion: Motion, force: Array, tau: float) -> Array:
    """The force behind a first-order lag, (R, n): exact for steps held over half a fine step each."""
    decay = np.exp(-motion.step / tau)
    result = np.empty_like(force.T)
    shown = force[:, 0]
    for step, value in enumerate(force.T):
        shown = value + (shown - value) * decay
        result[step] = shown
    return result.T
