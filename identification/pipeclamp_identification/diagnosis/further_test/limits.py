"""What a rig can do: bounds that the whole motion of a proposed test keeps, and where such tests are sought."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_identification.campaign.drive import Profile
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UsageError
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.realise.motion import Motion

Range = tuple[float, float]

EXAMPLE = "A=0.1..2,f=0.5..20,T=20..300,v=..300"
REACH_A = (0.5, 1.5)
"""Without a stated limit: amplitudes from half the smallest to one and a half times the largest tested."""
REACH_F = (0.5, 2.0)
"""Without a stated limit: frequencies from half the lowest to twice the highest tested."""
CONDITION_DIGITS = 3
"""Significant digits of a proposed test's conditions: what is said is what the drive signal does."""
HAIR = 1e-9
"""Share by which a condition may lie beyond an end of its limits."""


@dataclass(frozen=True)
class Limits:
    """What the rig can do; where nothing is stated, infinite.

    Attributes:
        amplitude: mm: the least amplitude that it keeps well, and the largest displacement of the whole motion, small
            cycles that ride on a large one included.
        frequency: Hz: the lowest frequency that it drives, and the highest of all tones of the motion.
        temperature: degC, lowest and highest.
        velocity: mm/s, the largest of the whole motion.
        force: N, the largest that any rival foretells.
    """

    amplitude: Range = (0.0, math.inf)
    frequency: Range = (0.0, math.inf)
    temperature: Range = (-math.inf, math.inf)
    velocity: float = math.inf
    force: float = math.inf

    def range(self, symbol: str) -> Range:
        """Give the range of A, f or T."""
        found: Range = getattr(self, RANGES[symbol])
        return found

    @property
    def untimed(self) -> Limits:
        """The limits but for those that mean nothing where no time was measured."""
        return replace(self, frequency=(0.0, math.inf), velocity=math.inf)

    def with_range(self, symbol: str, ends: Range) -> Limits:
        """Give the limits with another range of A, f or T."""
        return Limits(**{**vars(self), RANGES[symbol]: ends})


RANGES = {"A": "amplitude", "f": "frequency", "T": "temperature"}
QUANTITY_WORDS = {"v": "velocity", "F": "force"}
SUCH_AS = {"A": "2", "f": "20", "T": "300", "v": "300", "F": "5000"}
LIMIT_UNITS = {"A": "mm", "f": "Hz", "T": "°C", "v": "mm/s", "F": "N"}
ALL_ABOVE = {"A": 0.0, "f": 0.0, "T": -CELSIUS, "v": 0.0, "F": 0.0}
"""What both ends lie above."""
NUMBER = r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?"


def parse_limits(text: str) -> Limits:
    """Read limits such as `A=0.1..2,f=0.5..20,T=20..300,v=..300`; an end that isn't stated isn't limited.

    Raises:
        UsageError: the text is not of this form; it says what to write.
    """
    found: dict[str, Range] = {}
    for entry in text.split(","):
        name, _, ends = (part.strip() for part in entry.partition("="))
        if name not in LIMIT_UNITS or not ends:
            known = ", ".join(f"{symbol} ({unit})" for symbol, unit in LIMIT_UNITS.items())
            raise UsageError(
                f"--limits: got {entry.strip()!r}; expected {EXAMPLE} or some of it; known are {known}, and decimals "
                "take a point"
            )
        if name in found:
            raise UsageError(f"--limits: got {name} twice in {text!r}; expected it once, as in {EXAMPLE}")
        found[name] = _ends(name, ends)
    _, velocity = found.get("v", (0.0, math.inf))
    _, force = found.get("F", (0.0, math.inf))
    limits = Limits(velocity=velocity, force=force)
    for name in found.keys() & RANGES.keys():
        limits = limits.with_range(name, found[name])
    return limits


def _ends(name: str, text: str) -> Range:
    """Read `low..high`, `low..` or `..high`."""

    def refused(why: str, low: str, high: str) -> UsageError:
        return UsageError(f"--limits: got '{name}={text}'; expected {why}; write {name}={low}..{high}")

    match = re.fullmatch(rf"({NUMBER})?\s*\.\.\s*({NUMBER})?", text)
    if match is None or not any(match.groups()):
        # a hyphen between two numbers is no sign
        told = re.findall(NUMBER, re.sub(r"(?<=[\d\s])-", " ", text))
        told = [number for number in told if float(number) > ALL_ABOVE[name]] or [SUCH_AS[name]]
        low = told[0] if len(told) > 1 and name in RANGES else ""
        raise refused("numbers with a point and .. between them, one of which may be left out", low, told[-1])
    low, high = match.groups(default="")
    if low and name in QUANTITY_WORDS:
        raise refused(f"the largest {QUANTITY_WORDS[name]} alone", "", high or low)
    numbers = [float(end) for end in (low, high) if end]
    if min(numbers) <= ALL_ABOVE[name]:
        above = "" if low and float(low) <= ALL_ABOVE[name] else low
        end = high if high and float(high) > ALL_ABOVE[name] else SUCH_AS[name]
        raise refused(f"what lies above {ALL_ABOVE[name]:g} {LIMIT_UNITS[name]}", above, end)
    if numbers[0] > numbers[-1]:
        raise refused("the lower end first", high, low)
    return float(low or ALL_ABOVE[name]), float(high or math.inf)


def limits_words(limits: Limits) -> str:
    """Say what a rig can do, as `parse_limits` reads it; ends that aren't limited are left out."""
    words = []
    for symbol in RANGES:
        low, high = limits.range(symbol)
        ends = f"{low:.3g}" if low > ALL_ABOVE[symbol] else "", f"{high:.3g}" if math.isfinite(high) else ""
        words += ["{}={}..{}".format(symbol, *ends)] if any(ends) else []
    largest = {symbol: getattr(limits, name) for symbol, name in QUANTITY_WORDS.items()}
    return ",".join([*words, *(f"{symbol}=..{end:.3g}" for symbol, end in largest.items() if math.isfinite(end))])


def reach(tested: Motion, stated: Limits | None, *, timed: bool = True) -> Limits:
    """Give where the next test is sought: within the stated limits; where one is open, around what was tested.

    Where the temperature of the tests isn't known, it stays the assumed one: laws foretell nothing of another.

    Args:
        tested: the motions so far.
        stated: what the rig can do.
        timed: whether their time was measured.

    Returns:
        limits whose ranges of amplitude, frequency and temperature are finite.
    """
    A, f, T = (span(tested, name) for name in ("A", "f", "T"))
    celsius = (T[0] - CELSIUS, T[1] - CELSIUS)
    return reach_around(A, f, celsius, stated, warmed="T" not in tested.assumed, timed=timed)


def reach_around(
    A: Range, f: Range, celsius: Range, stated: Limits | None, *, warmed: bool = True, timed: bool = True
) -> Limits:
    """Give where tests are sought: within the stated limits; where one is open, around what was tested.

    Args:
        A, f, celsius: lowest and highest amplitude (mm), frequency (Hz) and temperature (degC) so far.
        stated: what the rig can do.
        warmed: whether another temperature than those may be tested at all.
        timed: whether the tests' time was measured. Otherwise a cycle counts for a second, at any rate that the rig is
            driven: the frequency stays what it is called, and no limit bounds it or the velocity.
    """
    stated = stated or Limits()
    if not timed:
        middle = math.sqrt(f[0] * f[1])
        f, stated = (middle, middle), replace(stated.untimed, frequency=(middle, middle))
    return replace(
        stated,
        amplitude=_closed(stated.amplitude, (REACH_A[0] * A[0], REACH_A[1] * A[1]), 0.0),
        frequency=_closed(stated.frequency, (REACH_F[0] * f[0], REACH_F[1] * f[1]), 0.0),
        temperature=_closed(stated.temperature, celsius, -CELSIUS) if warmed else celsius,
    )


def _closed(stated: Range, around: Range, coldest: float) -> Range:
    """Give a range whose open ends are those around what was tested, as far as the stated end lets them."""
    low = stated[0] if stated[0] > coldest else min(around[0], stated[1])
    high = stated[1] if math.isfinite(stated[1]) else max(around[1], low)
    return low, high


def span(motion: Motion, signal: str) -> Range:
    """Give the lowest and highest value of a slow signal."""
    return float(np.min(motion.slow[signal])), float(np.max(motion.slow[signal]))


def drivable(profile: Profile, A: Array, f: Array, limits: Limits) -> tuple[Array, Array]:
    """Give combinations of amplitude and frequency whose whole motion keeps the limits of the rig.

    Amplitudes that are too large for a motion's peaks, at a frequency or at all, give way to the largest that isn't.

    Args:
        profile: shape of the motion.
        A, f: levels of the fundamental that are wished for, mm and Hz, one-dimensional.
        limits: what the rig can do.

    Returns:
        A, f: shape (n,) each, of those pairs that are left; none where the shape can't be driven at all.
    """
    pairs = []
    (A_low, A_high), (f_low, f_high) = limits.amplitude, limits.frequency
    for frequency in stated_levels(f, f_low, f_high / profile.highest_order):
        most = min(A_high / profile.peak_displacement, limits.velocity / (profile.peak_velocity * frequency))
        pairs += [(amplitude, frequency) for amplitude in stated_levels(A, A_low, most)]
    found = np.array(pairs, dtype=np.float64).reshape(-1, 2)
    return found[:, 0], found[:, 1]


def drivable_grid(
    profile: Profile, levels: Mapping[str, Array], limits: Limits, further: Mapping[str, Array] | None = None
) -> dict[str, Array]:
    """Give every combination of conditions that keeps the limits.

    Args:
        profile: shape of the motion.
        levels: that are wished for: A (mm), f (Hz) and T (degC).
        limits: what the rig can do.
        further: levels of further conditions, by slow signal.

    Returns:
        slow signals by name, shape (R,) each, T in K; none where the shape can't be driven at all.
    """
    A, f = drivable(profile, levels["A"], levels["f"], limits)
    T = stated_levels(levels["T"], *limits.temperature) + CELSIUS
    every = {"pair": np.arange(len(A)), "T": T, **(further or {})}
    rows = np.array(list(itertools.product(*every.values()))).reshape(-1, len(every))
    columns = dict(zip(every, rows.T, strict=True))
    pair = columns.pop("pair").astype(np.intp)
    return {"A": A[pair], "f": f[pair], **columns}


def stated_levels(values: Array, low: float, high: float) -> Array:
    """Give levels between two ends, as they are said, to three digits; levels beyond an end move to it.

    Args:
        values: levels, shape (n,), in the unit of the ends.
        low, high: the ends.

    Returns:
        levels in rising order, each once; empty where the ends leave nothing between them.
    """
    # a hair wider, so that an end which is three digits long stays what it is; temperatures may lie below zero
    lowest, highest = low - HAIR * abs(low), high + HAIR * abs(high)
    if low > highest:
        return np.empty(0)
    within = np.clip(values, low, max(low, high))
    unit = 10.0 ** (np.floor(np.log10(np.maximum(np.abs(within), 1e-300))) - CONDITION_DIGITS + 1)
    nearest = np.round(within / unit)
    nearest = np.where(nearest * unit > high, np.floor(high / unit + 1e-9), nearest)
    nearest = np.where(nearest * unit < low, np.ceil(low / unit - 1e-9), nearest)
    said = np.round(nearest * unit, 12)
    # ends closer to each other than three digits can say
    return np.unique(np.where((said > highest) | (said < lowest), within, said))
