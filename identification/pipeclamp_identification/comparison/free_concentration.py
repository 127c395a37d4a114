"""Where the error along free motions sits, in sentences."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from pipeclamp_identification.comparison.concentration import PLACE_SETS, shares_words
from pipeclamp_identification.comparison.conditions import Condition
from pipeclamp_identification.comparison.densest_region import (
    Factor,
    Region,
    condition_factors,
    densest,
    region_sentence,
)
from pipeclamp_identification.comparison.free_breakdown import (
    DIRECTIONS,
    PLACE_NAMES,
    STANDING,
    Classes,
    FreeSamples,
    amplitude_classes,
    by_component,
    by_time,
    speed_classes,
)
from pipeclamp_identification.fitting.misfit import overall_nrmse
from pipeclamp_models.base.arrays import BoolArray, IntArray
from pipeclamp_models.base.digits import plain

QUARTERS = ("first", "second", "third", "last")
THIRDS = 3
SIDES = ("at negative displacement", "at positive displacement")
OFTEN = 0.05
"""Share of the time above which it is said that A or f lay outside the law's range, and of the squared error above
which it is said what a constant force costs."""
FAR_MORE = 1.3
"""Times its error on sines that a law errs by along another motion where it doesn't carry over."""


def free_region(samples: Sequence[FreeSamples], conditions: Sequence[Condition]) -> Region | None:
    """Find where the error along free motions sits; None where it is spread evenly, or there is none."""
    speed, amplitude = speed_classes(samples, THIRDS), amplitude_classes(samples, THIRDS)
    shape = (len(PLACE_NAMES), len(DIRECTIONS), len(SIDES), THIRDS, THIRDS, len(QUARTERS))
    cells = int(np.prod(shape))
    excess, even = np.zeros((2, len(samples), cells))
    for row, one in enumerate(samples):
        where = (
            one.place, one.direction, (one.misfit.y > 0).astype(np.intp), speed.of[row], amplitude.of[row],
            one.time_part(len(QUARTERS)),
        )  # fmt: skip
        cell = np.ravel_multi_index(where, shape)
        excess[row] = np.bincount(cell, one.squared_error, cells)
        even[row] = np.bincount(cell, minlength=cells) * (one.misfit.squared_force / len(cell))
    if not np.any(excess > 0.0):
        return None
    places = np.indices(shape).reshape(len(shape), cells)
    factors = [
        *_motion_factors(places, len(samples), speed, amplitude),
        *condition_factors(conditions, len(samples), cells),
    ]
    return densest(excess, even, factors)


def _motion_factors(places: IntArray, runs: int, speed: Classes, amplitude: Classes) -> Iterator[Factor]:
    """Give the ways to confine a region along motions; `places` say where each cell lies, (6, cells)."""
    everywhere = np.ones(runs)

    def factor(name: str, words: str, inside: BoolArray) -> Factor:
        return Factor(name, words, everywhere, inside.astype(np.float64))

    place, direction, side, fast, large, quarter = places
    for members, words in PLACE_SETS:
        yield factor("place", words, np.isin(place, members))
    yield factor("place", "while the clamp nearly stands still", place == STANDING)
    for index, words in enumerate(DIRECTIONS):
        yield factor("direction", f"while {words}", direction == index)
    for index, words in enumerate(SIDES):
        yield factor("side", words, side == index)
    for classes, of in ((speed, fast), (amplitude, large)):
        for first, last in ((0, 0), (0, 1), (1, 1), (1, 2), (2, 2)):
            low, high = (f"{plain(classes.edges[edge], 2)} {classes.unit}" for edge in (first, last + 1))
            span = f"up to {high}" if first == 0 else f"from {low} up" if last == 2 else f"from {low} to {high}"
            yield factor(classes.name, f"at a {classes.name} {span}", (of >= first) & (of <= last))
    for index, words in enumerate(QUARTERS):
        yield factor("time", f"in the {words} quarter of the record", quarter == index)
    for index, words in enumerate(("first", "second")):
        yield factor("time", f"in the {words} half of the record", quarter // 2 == index)


def free_words(samples: Sequence[FreeSamples], conditions: Sequence[Condition]) -> list[str]:
    """Say where the error along free motions sits, what it goes with, and where A and f left the law's range."""
    components = by_component(samples)
    words = [f"Free motion: {region_sentence(free_region(samples, conditions), by_time(samples))}"]
    if components.squared_error > 0.0:
        words.append(f"Free motion, by component: {shares_words(components)}.")
    for index, (symbol, unit) in enumerate((("A", "mm"), ("f", "Hz"))):
        low, high = samples[0].misfit.ranges[index]
        share = outside_share(samples, index)
        if share > OFTEN:
            words.append(
                f"Free motion: for {share:.0%} of the time the tracked {symbol} lies outside the law's range, "
                f"{low:.4g} to {high:.4g} {unit}, and the law is taken at its end; {error_outside(samples, index):.0%} "
                "of the squared error lies there."
            )
    words += _memory_words(samples)
    return words + [text for one in samples if (text := _constant_words(one))]


def _memory_words(samples: Sequence[FreeSamples]) -> list[str]:
    """Say that a law without memory doesn't carry over from sines, where it errs far more than on them."""
    error, on_sines = overall_nrmse([one.misfit for one in samples]), samples[0].misfit.on_sines
    if samples[0].misfit.remembers or on_sines is None or error <= FAR_MORE * on_sines:
        return []
    return [
        f"Free motion: the law errs by {error:.2%} here, and on its sines by {on_sines:.2%}. It has no memory: of what "
        "has passed it knows A and f alone, which stand for the past along sines only. If the device has friction, a "
        "law with states (identify --base memory, or what diagnose adds) follows such motions better."
    ]


def _constant_words(one: FreeSamples) -> str:
    """Say what a constant force of the law costs along a motion; nothing where it doesn't cost a material part."""
    run = one.misfit
    if run.nrmse_without is None or run.nrmse_without**2 > (1 - OFTEN) * run.nrmse**2:
        return ""
    return (
        f"Free motion: at rest and unloaded the law has a constant force, {plain(run.at_rest, 4)} N, along {run.run}; "
        f"without it the error there would be {run.nrmse_without:.2%} in place of {run.nrmse:.2%}. Sines in which the "
        "clamp always slips don't tell a constant force from slip forces that differ between the directions."
    )


def outside_share(samples: Sequence[FreeSamples], index: int) -> float:
    """Give the share of the time for which the tracked A (index 0) or f (1) lies outside the law's range."""
    return float(np.mean(np.concatenate([_outside(one, index) for one in samples])))


def error_outside(samples: Sequence[FreeSamples], index: int) -> float:
    """Give the share of the squared error that lies where the tracked A or f is outside the law's range."""
    outside = sum(float(np.sum(one.squared_error[_outside(one, index)])) for one in samples)
    total = sum(one.misfit.squared_error for one in samples)
    return outside / total if total > 0.0 else 0.0


def _outside(one: FreeSamples, index: int) -> BoolArray:
    """Tell at which samples the tracked A (index 0) or f (1) lies outside the law's range, shape (n,)."""
    low, high = one.misfit.ranges[index]
    values = (one.misfit.amplitude, one.misfit.frequency)[index]
    return np.asarray((values < low) | (values > high))
