"""Which test next: the test whose outcome differs most between rivals, against scatter and against their own doubt."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_identification.campaign.drive import DrivePlan, Profile
from pipeclamp_identification.diagnosis.further_test.limits import Limits, drivable_grid, limits_words, reach, span
from pipeclamp_identification.diagnosis.further_test.outlook import (
    LEAST_DEVIATIONS,
    PROFILES,
    RIDDEN,
    RIDING_SHARE,
    RUNS_OF_A_TEST,
    ConditionArrays,
    Foreseer,
    Outlook,
    foreseer,
    outlook_of,
)
from pipeclamp_identification.diagnosis.problem import Judged
from pipeclamp_identification.diagnosis.verdict import Diagnosis
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.signals import column_of
from pipeclamp_models.base.units import CELSIUS, celsius_of
from pipeclamp_models.equations import symbols
from pipeclamp_models.law.catalogue import effect_id
from pipeclamp_models.realise.motion import Motion
from pipeclamp_models.realise.sizes import about

LEVELS_OF_A_AND_F = 6
"""Amplitudes, and frequencies, between the limits that tests are looked at at."""
LEVELS_OF_T = 4
"""Temperatures between them."""
SURE_DEVIATIONS = 8.0
"""Standard deviations between two rivals from which on a test is sure to tell."""
NEARLY_LOG_CHANCE = 0.8
"""A test whose log chance of a mistake is this share of the best test's tells nearly as much."""
MOST_RIVALS = 4
"""Rivals that one test is sought for, best first."""
BOUND_WIDENING = 4.0
"""Times that a bound on amplitude or frequency is widened, to see whether a test beyond it would tell."""
WARMER_K = 200.0
"""Kelvin by which a bound on the temperature is."""


@dataclass(frozen=True)
class NoTest:
    """No test is proposed, though rivals are left.

    Attributes:
        words: why, and which limit would have to give.
    """

    words: str


@dataclass(frozen=True)
class Proposal:
    """A test and what it would tell.

    Attributes:
        amplitude_mm, frequency_Hz, temperature_C: its conditions; no temperature where that of the tests isn't known.
        about_mm: displacement about which it moves, as the tests do; 0 where that is about zero.
        further: further conditions that matter to a rival: columns of runs.csv, as in a law's signals.
        profile: SINE or RIDDEN.
        separation: expected difference between the predictions of those two rivals that it separates least, in standard
            deviations of scatter and doubt.
        rivals: names, best first.
        motion: the motion, one row.
        forces: what each rival predicts, N, shape (rivals, n).
        timed: whether the tests' time was measured: else the frequency is but that of one cycle a second.
    """

    amplitude_mm: float
    frequency_Hz: float
    temperature_C: float | None
    about_mm: float
    further: Mapping[str, float]
    profile: str
    separation: float
    rivals: tuple[str, ...]
    motion: Motion
    forces: Array
    timed: bool

    @property
    def plan(self) -> DrivePlan:
        """What the machine is asked to do."""
        return DrivePlan(PROFILES[self.profile], self.amplitude_mm, self.frequency_Hz)

    def test_words(self) -> str:
        """Say which test it is."""
        further = "".join(f", {_further_words(name, value)}" for name, value in self.further.items())
        where = f" about {self.about_mm:.3g} mm, as the tests so far" if self.about_mm else ""
        return (
            f"{PROFILES[self.profile].words} at {self.amplitude_mm:.3g} mm{where}"
            f"{rate_words(self.frequency_Hz, self.timed)}, {temperature_words(self.temperature_C)}{further}"
        )

    def words(self) -> str:
        """Say what to do."""
        two = len(self.rivals) == 2
        return (
            f"run {self.test_words()}, {RUNS_OF_A_TEST} times: {rivals_words(self.rivals)} then differ by "
            f"{'' if two else 'at least '}{self.separation:.1f} standard deviations"
        )

    def drive_words(self) -> str:
        """Say what the drive signal asks of the machine."""
        counted = f"; it is counted from {self.about_mm:.3g} mm" if self.about_mm else ""
        return f"{self.plan.words()}{counted}; run it {RUNS_OF_A_TEST} times"


def rivals_words(rivals: Sequence[str]) -> str:
    """Name those that a test tells apart."""
    return " and ".join(rivals) if len(rivals) == 2 else f"any two of {', '.join(rivals)}"


def rate_words(frequency_Hz: float, timed: bool) -> str:
    """Say at which frequency a test is proposed, behind a comma; nothing where the tests' time was not measured."""
    return f", {frequency_Hz:.3g} Hz" if timed else ""


def temperature_words(temperature_C: float | None) -> str:
    """Say at which temperature a test is proposed."""
    return "the temperature of the tests so far" if temperature_C is None else f"{temperature_C:.3g} °C"


def _further_words(signal: str, value: float) -> str:
    if signal == str(symbols.N):
        return f"after {value:.0f} load cycles"
    if signal == str(symbols.rho):
        return f"density {value:.4g} g/cm³"
    return f"{column_of(signal)} {value:.4g}"


@dataclass(frozen=True)
class _TestSearch:
    """Where the next test is sought, and between whom.

    Attributes:
        diagnosis: the ambiguous one.
        names: of the rivals, best first.
        rivals: the same with their doubt.
        tested: lowest and highest A, f, T (K) of the tests so far.
        further: levels of further conditions.
    """

    diagnosis: Diagnosis
    names: tuple[str, ...]
    rivals: Sequence[Foreseer]
    tested: Mapping[str, tuple[float, float]]
    further: ConditionArrays

    @property
    def timed(self) -> bool:
        """Whether the tests' time was measured."""
        return self.diagnosis.problem.loops.time_measured

    def outlooks(self, limits: Limits, levels: Mapping[str, Array] | None = None) -> list[Outlook]:
        """Tell what tests within limits would tell, of each profile that they let be driven; closed ranges needed.

        Args:
            limits: what the rig can do.
            levels: peak displacement mm, highest frequency Hz or temperature °C that are to be looked at, shape (n,)
                each, instead of some between the limits.
        """
        found = []
        for name, profile in PROFILES.items():
            grid = self._grid(profile, limits, levels or {})
            if len(grid["A"]):
                outlook = outlook_of(name, grid, self.rivals, self.diagnosis)
                found.append(outlook.rows(np.flatnonzero(outlook.peak_forces <= limits.force)))
        return [outlook for outlook in found if len(outlook.mistaken)]

    def _grid(self, profile: Profile, limits: Limits, levels: Mapping[str, Array]) -> ConditionArrays:
        """Give every combination of conditions that keeps the limits."""
        if not self.timed:  # small cycles that ride on a large one bring no rate that means anything
            limits = limits.with_range("f", (limits.frequency[0], limits.frequency[0] * profile.highest_order))
        (A_low, A_high), (f_low, f_high) = limits.amplitude, limits.frequency
        spread = {
            "A": np.geomspace(A_low, A_high / profile.peak_displacement, LEVELS_OF_A_AND_F),
            "f": np.geomspace(f_low, f_high / profile.highest_order, LEVELS_OF_A_AND_F),
            "T": np.linspace(*limits.temperature, LEVELS_OF_T),
        }
        # What was tested is also a place to test, as far as the rig reaches.
        for name, ends in self.tested.items():
            spread[name] = np.concatenate([spread[name], np.array(ends) - (CELSIUS if name == "T" else 0.0)])
        over = {"A": profile.peak_displacement, "f": float(profile.highest_order), "T": 1.0}
        spread |= {name: np.asarray(values / over[name]) for name, values in levels.items()}
        return drivable_grid(profile, spread, limits, self.further)

    def temperature(self, T: float) -> float | None:
        """Give a temperature in degC; none where that of the tests so far isn't known."""
        return None if "T" in self.diagnosis.problem.observations.motion.assumed else celsius_of(T)

    def words_of(self, limits: Limits) -> str:
        """Say within which limits is sought; not of what these tests don't know."""
        known = limits if self.timed else limits.untimed
        return limits_words(known if self.temperature(0.0) is not None else known.with_range("T", (-CELSIUS, math.inf)))

    def proposal(self, outlook: Outlook, row: int) -> Proposal:
        """Give one of the tests that were looked at."""
        A, f, T = (float(outlook.grid[name][row]) for name in ("A", "f", "T"))
        further = {name: float(values[row]) for name, values in outlook.grid.items() if name not in ("A", "f", "T")}
        where = about(self.diagnosis.problem.observations.motion)
        return Proposal(
            A, f, self.temperature(T), where, further, outlook.profile, float(outlook.apart[:, row].min()), self.names,
            outlook.motion.rows(np.array([row])), outlook.forces[:, row], self.timed,
        )  # fmt: skip


def next_test(diagnosis: Diagnosis, limits: Limits | None = None) -> Proposal | NoTest | None:
    """Give the test that separates the rivals of an ambiguous diagnosis best; None where there are none.

    Of two rivals one is taken for true and the other refitted to what the first foretells. What the refit can make up
    for, what scatters, and what either effect's form may leave over don't count. Of all pairs, the Bhattacharyya bound
    sums the chance exp(-d^2/8) of taking one for the other. Of the tests that surely tell, or tell nearly as much as
    the best, the one nearest to what was tested is proposed: the farther away, the less holds what laws foretell.
    Where none within the limits tells, it is said which limit would have to give.
    """
    if diagnosis.verdict != "ambiguous":
        return None
    names = diagnosis.effects[:MOST_RIVALS]
    rivals = [foreseer(_of(name, diagnosis), diagnosis) for name in names]
    so_far = diagnosis.problem.observations.motion
    tested = {name: span(so_far, name) for name in ("A", "f", "T")}
    search = _TestSearch(diagnosis, names, rivals, tested, _further_levels(rivals, diagnosis))
    within = reach(so_far, limits, timed=search.timed)
    outlooks = search.outlooks(within)
    if not any(outlook.tells.any() for outlook in outlooks):
        return NoTest(_why_none(search, within, outlooks))
    mistaken = np.concatenate([outlook.mistaken for outlook in outlooks])
    away = np.concatenate(
        [away_from(outlook.grid, tested) + (RIDING_SHARE if outlook.profile == RIDDEN else 0.0) for outlook in outlooks]
    )
    enough = mistaken <= max(-(SURE_DEVIATIONS**2) / 8, NEARLY_LOG_CHANCE * float(mistaken.min()))
    best = int(np.lexsort((mistaken, np.where(enough, away, np.inf)))[0])
    place, row = [(place, row) for place, one in enumerate(outlooks) for row in range(len(one.mistaken))][best]
    return search.proposal(outlooks[place], row)


def _why_none(search: _TestSearch, limits: Limits, outlooks: Sequence[Outlook]) -> str:
    """Say why no test is proposed, and which limit would have to give, and how much."""
    gives = [words for bound in _bounds(search, limits) if (words := _gives(search, bound))]
    if outlooks:
        best = max(outlooks, key=lambda outlook: float(outlook.apart.max()))
        row = int(np.argmax(best.apart.max(axis=0)))
        proposal = search.proposal(best, row)
        why = (
            f"no test within {search.words_of(limits)} tells {rivals_words(search.names)} apart: by the best, "
            f"{proposal.test_words()}, they differ by {float(best.apart.max()):.1f} standard deviations, and "
            f"{LEAST_DEVIATIONS:g} are needed"
        )
    else:
        why = f"no motion keeps all of {search.words_of(limits)}"
    if not gives:
        return f"{why}; no single limit that gives way would help"
    return f"{why}; it would take {' or '.join(gives)}"


@dataclass(frozen=True)
class _Bound:
    """One end of the limits, and what lies beyond it.

    Attributes:
        end: how it is stated, to be filled in.
        upper: whether it is an upper end.
        symbol: A, f, T, v or F.
        limits: with this end given way.
        levels: to look at.
    """

    end: str
    upper: bool
    symbol: str
    limits: Limits
    levels: Mapping[str, Array]


def _bounds(search: _TestSearch, limits: Limits) -> Iterator[_Bound]:
    """Give the ends of limits that could give way, one at a time."""
    for symbol in ("A", "f") if search.timed else ("A",):
        low, high = limits.range(symbol)
        for upper, ends in ((True, (high, BOUND_WIDENING * high)), (False, (low / BOUND_WIDENING, low))):
            wide = limits.with_range(symbol, (min(low, ends[0]), max(high, ends[1])))
            end = f"{symbol}=..{{}}" if upper else f"{symbol}={{}}.."
            yield _Bound(end, upper, symbol, wide, {symbol: np.geomspace(*ends, LEVELS_OF_A_AND_F)})
    low, high = limits.temperature
    if search.temperature(0.0) is not None:
        for upper, ends in ((True, (high, high + WARMER_K)), (False, (max(low - WARMER_K, -CELSIUS + 1.0), low))):
            wide = limits.with_range("T", (min(low, ends[0]), max(high, ends[1])))
            yield _Bound(
                "T=..{}" if upper else "T={}..", upper, "T", wide, {"T": np.linspace(*ends, LEVELS_OF_A_AND_F)}
            )
    if np.isfinite(limits.velocity):
        yield _Bound("v=..{}", True, "v", replace(limits, velocity=np.inf), {})
    if np.isfinite(limits.force):
        yield _Bound("F=..{}", True, "F", replace(limits, force=np.inf), {})


def _gives(search: _TestSearch, bound: _Bound) -> str:
    """Say how far a bound must give way for a test to tell; nothing where that doesn't help."""
    asked = [
        _asked(outlook, bound.symbol, upper=bound.upper)[outlook.tells]
        for outlook in search.outlooks(bound.limits, bound.levels)
    ]
    every = np.concatenate([np.empty(0), *asked])
    if not len(every):
        return ""
    return bound.end.format(f"{float(every.min() if bound.upper else every.max()):.3g}")


def _asked(outlook: Outlook, symbol: str, *, upper: bool) -> Array:
    """Give what tests ask of one of the limits, in its unit, shape (R,)."""
    profile, A, f = PROFILES[outlook.profile], outlook.grid["A"], outlook.grid["f"]
    match symbol:
        case "A":
            return A * profile.peak_displacement if upper else A
        case "f":
            return f * profile.highest_order if upper else f
        case "T":
            return outlook.grid["T"] - CELSIUS
        case "v":
            return profile.peak_velocity * A * f
    return outlook.peak_forces


def _of(name: str, diagnosis: Diagnosis) -> Judged:
    """Give the best candidate of an id."""
    return next(candidate for candidate in diagnosis.candidates if effect_id(candidate.effects[0]) == effect_id(name))


def _further_levels(rivals: Sequence[Foreseer], diagnosis: Diagnosis) -> dict[str, Array]:
    """Give the levels of each further condition that a rival follows: as tested; of load cycles those yet to come."""
    tested = diagnosis.problem.observations.motion.slow
    followed = {signal for rival in rivals for signal in rival.judged.result.equations.slow_signals}
    levels = {}
    for name in sorted(followed - {"A", "f", "T"}):
        values = tested[name]
        seen = np.quantile(values, [0.0, 0.5, 1.0])
        levels[name] = np.unique(seen[2] * np.array([1.0, 2.0, 4.0]) if name == str(symbols.N) else seen)
    return levels


def away_from(grid: ConditionArrays, tested: Mapping[str, tuple[float, float]]) -> Array:
    """Give how far outside of what was tested conditions lie, shape (R,): octaves of A and f, hundreds of kelvin."""
    away = np.zeros(len(grid["A"]))
    for name, (low, high) in tested.items():
        values = grid[name]
        outside = np.clip(values, low, high)
        away += np.abs(values - outside) / 100 if name == "T" else np.abs(np.log2(values / outside))
    return away
