"""What a person reads of a frequency response: peaks, branches, and how far it is to be trusted."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from pipeclamp_models.base.said import counted
from pipeclamp_models.base.signals import column_of
from pipeclamp_system.description.trust_mark import doubt
from pipeclamp_system.response.curves import Curve, FrequencyResponse, label, peaks_of, stretches
from pipeclamp_system.response.dots import MOST_HALVINGS, Dot
from pipeclamp_system.steady.equivalent import LEAST_LOSS_FACTOR
from pipeclamp_system.steady.harmonics import DOUBTFUL_SHARE
from pipeclamp_system.steady.states import SteadyState, about_missing, span

LACK_OF_DAMPING = (
    "where it isn't bounded, a curve ends as a clamp moves farther than the pipe is long, while pipe and clamps take "
    f"up less than steel does by itself (loss factor {LEAST_LOSS_FACTOR:g}); branches apart aren't sought then. Give "
    "the pipe the damping that it has ([damping] in its file), or its clamps a law with damping"
)
"""Said of a response that nothing bounds."""

SEARCH_ENDED = (
    "further branches were not sought to the end, which takes more work than is allowed: there may be more; a narrower "
    "range of [response] is sought through"
)
"""Said of a curve whose search was cut short."""

AT_AN_END = " (where the range ends)"
"""Said of what is highest there: a resonance may lie beyond."""

UNBOUNDED = " (where it isn't bounded)"
"""Likewise: a curve that rises there without end is followed no farther."""


def response_summary(response: FrequencyResponse) -> str:
    """Give peaks, unstable branches and how well the two ways agree, for a person to read."""
    lines = [f"system {response.name!r}, level 1: {response.excitation}"]
    for curve in response.curves:
        peaks = peaks_of(curve)
        frequencies = [state.frequency for state in curve.states]
        ends = dict.fromkeys(frequencies, "") | {end(frequencies): AT_AN_END for end in (min, max)}
        ends |= {state.frequency: UNBOUNDED for state in curve.states if state.unbounded}
        peak_text = ", ".join(
            # the highest of the states that were found, no more
            f"{name} {peak:.3g} mm at {frequency:.3g} Hz{ends[frequency]}"
            for name, (peak, frequency) in zip(response.points, peaks, strict=True)
        )
        unstable = _spans(stretches(curve.pieces, lambda state: not (state.stable or state.neutral)))
        neutral = _spans(stretches(curve.pieces, lambda state: state.neutral))
        branch = f"; unstable {unstable}" if unstable else ""
        branch += f"; neither stable nor unstable, as nothing damps it, {neutral}" if neutral else ""
        broken = about_missing(curve.followed)
        apart = "".join(
            f"; {about(piece)}"
            for about, of_kind in ((_about_leaving, curve.leaving), (_about_detached, curve.detached))
            for piece in of_kind
        )
        lines.append(
            f"{label(curve.temperature, curve.level)}: peak {peak_text}{branch}{apart}{broken}{_about_search(curve)}"
        )
    lines += [LACK_OF_DAMPING] if any(curve.followed.unbounded for curve in response.curves) else []
    lines += [f"warning: {words}" for words in response.leaves_rest]
    lines += _about_harmonics(response)
    lines += _about_ranges(response)
    lines += _about_dots(response) if response.dots else []
    return "\n".join(lines)


def _about_harmonics(response: FrequencyResponse) -> list[str]:
    """Say how many harmonics were balanced, and what is left out."""
    if not response.clamp_names:
        return []
    states = [state for curve in response.curves for piece in curve.pieces for state in piece]
    if not states:
        return []
    counts = [state.harmonics for state in states]
    balanced = f"{min(counts)}" if min(counts) == max(counts) else f"{min(counts)} to {max(counts)}"
    worst = max(states, key=lambda state: state.truncated)
    line = (
        f"harmonics balanced: {balanced}; those that are left out would move {worst.truncated:.1%} of the motion at "
        f"most, at {worst.frequency:.4g} Hz"
    )
    if worst.truncated <= DOUBTFUL_SHARE:
        return [line]
    pieces = [piece for curve in response.curves for piece in curve.pieces]
    doubtful = _spans(stretches(pieces, lambda state: state.truncated > DOUBTFUL_SHARE))
    more = "the force steps there, or more can't be balanced; co-simulate there"
    if response.stated_harmonics:
        more = "leave harmonics out of [response], so that they follow the motion"
    return [doubt(f"{line}; more than {DOUBTFUL_SHARE:.0%} {doubtful}: {more}")]


def _about_ranges(response: FrequencyResponse) -> list[str]:
    """Say where a clamp's law is used beyond the range of its data."""
    lines = []
    states = [state for curve in response.curves for state in curve.states]
    for index, (name, ranges) in enumerate(zip(response.clamp_names, response.ranges, strict=True)):
        beyond = [state.beyond[index] for state in states if state.beyond[index]]
        if not beyond:
            continue
        parts = []
        for condition, interval in ranges.items():
            values = [one[condition] for one in beyond if condition in one]
            if values:
                low, high = f"{min(values):.4g}", f"{max(values):.4g}"
                found = low if low == high else f"{low} to {high}"
                parts.append(
                    f"{column_of(condition)} = {found} {interval.unit} "
                    f"(data: {interval.minimum:.4g} to {interval.maximum:.4g})"
                )
        share = f"{len(beyond) / len(states):.0%} of the curves' points"
        lines.append(f"{name}: its law is used beyond the range of its data in {share}: {', '.join(parts)}")
    return lines


def _about_dots(response: FrequencyResponse) -> list[str]:
    """Say how well the co-simulations agree, in which steps, and which of them aren't to be trusted."""
    steps = [1e3 * dot.step for dot in response.dots]
    sound = [dot for dot in response.dots if dot.settled and dot.trusted]
    good = [dot.difference for dot in sound if dot.repeats and dot.has_branch]
    lines = [
        f"{counted(len(response.dots), 'co-simulation')} in steps of {min(steps):.3g} to {max(steps):.3g} ms; "
        f"those that settled and can be trusted ({len(good)}) differ by at most {max(good, default=0.0):.2%} from "
        "the stable branches"
    ]
    odd = [dot for dot in sound if not dot.repeats]
    if odd:
        lines.append(
            f"{len(odd)} co-simulations don't repeat from cycle to cycle: subharmonic or irregular motion, which "
            f"no curve holds ({_places(odd)})"
        )
    alone = [dot for dot in sound if dot.repeats and not dot.has_branch]
    if alone:
        lines.append(
            f"{len(alone)} co-simulations settle where no stable branch was found: one is missing there "
            f"({_places(alone)})"
        )
    doubtful = response.doubtful_dots
    if doubtful:
        places = _places(doubtful)
        lines.append(
            doubt(
                f"{len(doubtful)} co-simulations, drawn as crosses: 1/{2**MOST_HALVINGS} of step_s "
                f"is still too long a step for them; use a smaller step_s or scheme = 'implicit' ({places})"
            )
        )
    return lines


def _places(dots: Sequence[Dot]) -> str:
    """Say where dots lie."""
    return "; ".join(f"{label(dot.temperature, dot.level)}, {dot.frequency:.4g} Hz" for dot in dots)


def _spans(ranges: Iterable[tuple[float, float]]) -> str:
    """Say ranges of frequencies, Hz."""
    return ", ".join(span(low, high) for low, high in ranges)


def _about_search(curve: Curve) -> str:
    """Say that further branches were not sought to the end."""
    return "" if curve.sought_whole else f"; {SEARCH_ENDED}"


def _about_detached(branch: Sequence[SteadyState]) -> str:
    """Say where a branch lies that nothing joins to the others."""
    return f"a branch apart {_where(branch)}"


def _about_leaving(branch: Sequence[SteadyState]) -> str:
    """Say where a branch lies that leaves another one, and how far it is off the middle."""
    off = max(float(np.abs(state.clamps[:, 0]).max()) for state in branch)
    return f"a less symmetric branch {_where(branch)}, off the middle by up to {off:.2g} mm at a clamp"


def _where(branch: Sequence[SteadyState]) -> str:
    """Say which frequencies a branch spans, and whether none of it is stable."""
    frequencies = [state.frequency for state in branch]
    stable = "" if any(state.stable or state.neutral for state in branch) else " (all of it unstable)"
    return f"{span(min(frequencies), max(frequencies))}{stable}"
