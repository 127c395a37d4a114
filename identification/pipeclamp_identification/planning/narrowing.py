"""From the pipe back to the test: which loop test narrows the band of the pipe's peak most."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pipeclamp_identification.campaign.drive import DrivePlan
from pipeclamp_identification.diagnosis.further_test.limits import Limits, limits_words
from pipeclamp_identification.diagnosis.further_test.next_test import away_from
from pipeclamp_identification.diagnosis.further_test.outlook import PROFILES, RUNS_OF_A_TEST, SINE
from pipeclamp_identification.planning.loop_tests import LoopTests, loop_tests, noise_words, reach_of, with_tests
from pipeclamp_models.base.arrays import Array, IntArray
from pipeclamp_models.base.errors import UsageError
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.base.toml_file import unknown as unknown_name
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.file import LawFile
from pipeclamp_system.bands.band import Band, band_of, steps_of
from pipeclamp_system.bands.described import unknown_of
from pipeclamp_system.bands.quantities import Unknown
from pipeclamp_system.bands.response import BandedSystem, banded_system
from pipeclamp_system.bands.response import refuse as refuse_bands
from pipeclamp_system.bands.sensitivity import conditions_at
from pipeclamp_system.bands.told import PeakBand
from pipeclamp_system.bands.varied import SHARE_OF_PARAMETER, VariedLaw, gaps
from pipeclamp_system.steady.clamp import SteadyClamp
from pipeclamp_system.steady.described import read_responding, steady_clamps
from pipeclamp_system.steady.response import Curve, amplitudes_of, label, run_response
from pipeclamp_system.steady.states import SteadyState

MOST_TESTS = 5
"""That are proposed one after another."""
WORTH_SHARE = 0.03
"""Share of the band's width that a test must take to be worth its rig time."""
AS_GOOD_SHARE = 0.95
"""A test that narrows by this share of what the best one does is as good: of these the nearest to what was tested."""


@dataclass(frozen=True)
class NextLoopTest:
    """A loop test, and the band of the peak after it.

    Attributes:
        law: name of the law whose clamp is tested.
        clamps: of the pipe, that have it.
        amplitude_mm, frequency_Hz: its conditions.
        temperature_C: likewise; None where the temperature of the law's tests isn't known.
        amplitude, frequency: bands of the peak after it and all tests before, mm and Hz.
    """

    law: str
    clamps: tuple[str, ...]
    amplitude_mm: float
    frequency_Hz: float
    temperature_C: float | None
    amplitude: Band
    frequency: Band

    @property
    def plan(self) -> DrivePlan:
        """What the machine is asked to do."""
        return DrivePlan(PROFILES[SINE], self.amplitude_mm, self.frequency_Hz)


@dataclass(frozen=True, eq=False)
class Map:
    """What every test that was looked at would leave, as the first one.

    Attributes:
        law: whose clamp is tested.
        grid: A (mm), f (Hz), T (K), shape (R,) each.
        share: of the band's width that is left, shape (R,).
        motion: A, f, T of the pipe's motion at its peak.
        tested: the law's range of A, f and, where known, T.
    """

    law: str
    grid: Mapping[str, Array]
    share: Array
    motion: Mapping[str, float]
    tested: Mapping[str, tuple[float, float]]


@dataclass(frozen=True, eq=False)
class BandPlan:
    """Which loop tests narrow the band of a peak.

    Attributes:
        system: name.
        curve: which one, in words; point: the clamp or probe.
        per_cent: that bands hold.
        before: the peak's band.
        tests: one after another, best first; none where none is worth its time.
        floor: band of the amplitude that no number of loop tests of the same kind goes below, mm.
        maps: of each law.
        limits: within which tests were sought, in words, by law.
        noise: what was reckoned with, in words, by law.
        gaps: what the laws' files don't tell, in words.
    """

    system: str
    curve: str
    point: str
    per_cent: float
    before: PeakBand
    tests: tuple[NextLoopTest, ...]
    floor: Band
    maps: tuple[Map, ...]
    limits: Mapping[str, str]
    noise: Mapping[str, str]
    gaps: tuple[str, ...]


def plan_tests(
    path: Path,
    limits: Limits | None = None,
    *,
    per_cent: float = 95.0,
    at: str | None = None,
    noise_N: float | None = None,
    progress: Progress = silent,
) -> BandPlan:
    """Give the loop tests that narrow the band of a pipe's peak most, one after another.

    A test is a linear measurement of the law's parameters, and of what the law's form is off there: with their
    covariance it leaves a smaller one. How much it tells of the form where the pipe moves, kriging says. What a
    mounting scatters stays.

    Args:
        path: SYSTEM.toml.
        limits: what the rig can do; where nothing is stated, around what the law was tested at.
        per_cent: that bands hold.
        at: clamp or probe; that of the widest band beside its peak unless told.
        noise_N: rms noise of the force; None for that of the law's tests.
        progress: told what is being done.

    Raises:
        UserError: the system can't be read or solved, no law tells how sure it is, or the rig can drive no test.
        UsageError: the share can't be held by a band, or there is no such clamp or probe.
    """
    refuse_bands(path, per_cent, {})
    _refuse_beforehand(path, limits, at, noise_N)
    response = run_response(path, progress, dots=False)
    system = banded_system(path, response, by_clamp=True)
    points = range(len(response.points)) if at is None else [response.points.index(at)]
    progress("what the peaks follow")
    every = [_wanted(system, curve, point) for curve in response.curves for point in points]
    wanted = max(every, key=lambda one: one.deviation(system.unknown.covariance) / one.amplitude)
    progress("the band as it is")
    before = system.bands(wanted.curve, per_cent).peaks[wanted.point]
    search = _NarrowingSearch(path, system, wanted, before, per_cent, response.clamp_names)
    fields = [search.tests_of(law, limits, noise_N) for law in dict.fromkeys(system.unknown.laws)]
    _refuse_none(fields)
    progress("tests that would narrow it")
    known = [field for field, _ in fields]
    files = {field.law: field.law.file for field in known}
    noises = {file.name: noise_words(file, noise_N) for file in files.values()}
    return BandPlan(
        response.name, label(wanted.curve.temperature, wanted.curve.level), response.points[wanted.point], per_cent,
        before, tuple(search.one_after_another(known)), search.floor(known),
        tuple(search.map_of(field) for field in known if len(field)),
        {field.law.file.name: words for field, words in fields}, noises, gaps(system.unknown.laws),
    )  # fmt: skip


def _refuse_beforehand(path: Path, limits: Limits | None, at: str | None, noise_N: float | None) -> None:
    """Refuse a point that the system hasn't, and limits that no test keeps, before its response is computed."""
    system, where = read_responding(path), str(path)
    points = [*(clamp.at for clamp in system.description.clamps), *system.pipe.probe_names]
    if at is not None and at not in points:
        raise UsageError(f"--at: {unknown_name(at, points, 'clamp or probe')}")
    laws = unknown_of(system.description, path.parent).laws
    fields = []
    for temperature in system.table.temperatures_C or (None,):
        clamps = steady_clamps(system.description, system.pipe, path.parent, temperature, where)
        fields += [_tests_of(law, clamps[laws.index(law)][1], limits, None, noise_N) for law in dict.fromkeys(laws)]
    _refuse_none(fields)


def _tests_of(
    law: VariedLaw, clamp: SteadyClamp, limits: Limits | None, near: Mapping[str, float] | None, noise_N: float | None
) -> tuple[LoopTests, str]:
    """Give the tests of a law's clamp, as of `loop_tests`, and within which limits they are, in words."""
    within = reach_of(law.file, limits, clamp.temperature - CELSIUS)
    return loop_tests(law, within, near, clamp.further, noise_N), limits_words(within)


def _refuse_none(fields: Sequence[tuple[LoopTests, str]]) -> None:
    """Refuse limits, in words, within which there is no test of any law."""
    if not any(len(field) for field, _ in fields):
        said = "; ".join(dict.fromkeys(words for _, words in fields))
        raise UsageError(f"--limits: no sine test keeps all of {said}; expected wider limits")


@dataclass(frozen=True, eq=False)
class _Wanted:
    """A peak: of which curve, at which point, and its derivatives by what isn't known, (Q,)."""

    curve: Curve
    point: int
    amplitude: float
    by_amplitude: Array
    by_frequency: Array
    off: tuple[float, float]

    def deviation(self, covariance: Array) -> float:
        return float(np.sqrt(self.by_amplitude @ covariance @ self.by_amplitude + self.off[1] ** 2))

    @property
    def state(self) -> SteadyState:
        """The highest state."""
        return max(self.curve.states, key=lambda state: amplitudes_of(state)[self.point])


def _wanted(system: BandedSystem, curve: Curve, point: int) -> _Wanted:
    sizes = system.unknown.scales
    piece = max(system.moving(curve)[point], key=lambda one: one.peak()[1])
    by_frequency, by_amplitude = piece.peak_moves(sizes)
    return _Wanted(curve, point, piece.peak()[1], by_amplitude, by_frequency, piece.peak_errors())


@dataclass(frozen=True, eq=False)
class _Known:
    """What is known once some tests were run.

    Attributes:
        covariance: of all that isn't known, (Q, Q).
        files: of each law, whose range holds the tests.
    """

    covariance: Array
    files: Mapping[VariedLaw, LawFile]


class _NarrowingSearch:
    """The tests that narrow the band of one peak."""

    def __init__(
        self, path: Path, system: BandedSystem, wanted: _Wanted, before: PeakBand, per_cent: float,
        names: Sequence[str],
    ) -> None:  # fmt: skip
        self._system, self._wanted, self._before = system, wanted, before
        self._unknown: Unknown = system.unknown
        self._steps, self._names = steps_of(per_cent), names
        self._state = wanted.state
        temperature = wanted.curve.temperature
        found = steady_clamps(system.description, system.pipe, path.parent, temperature, str(path))
        self._clamps = [clamp for _, clamp in found]
        self._at = [conditions_at(clamp, self._state, place) for place, clamp in enumerate(self._clamps)]
        self._now = _Known(self._unknown.covariance, {law: law.file for law in dict.fromkeys(self._unknown.laws)})

    def tests_of(self, law: VariedLaw, limits: Limits | None, noise_N: float | None) -> tuple[LoopTests, str]:
        """Give the tests of a law's clamp, and within which limits they are, in words."""
        clamp = self._clamps[self._unknown.laws.index(law)]
        return _tests_of(law, clamp, limits, self._motion(law), noise_N)

    def one_after_another(self, fields: Sequence[LoopTests]) -> list[NextLoopTest]:
        """Give tests, each the best once those before it were run."""
        known, found = self._now, list[NextLoopTest]()
        while len(found) < MOST_TESTS:
            deviation = self._deviation(known)
            told = [self._told_of(field, known) for field in fields]
            left = [self._left(one, known) for one in told]
            place, row = self._best(fields, left, deviation, known)
            if not left[place].size or 1 - left[place][row] / deviation < WORTH_SHARE:
                break
            known = self._after(told[place], row, known)
            found.append(self._told(fields[place], row, known))
        return found

    def floor(self, fields: Sequence[LoopTests]) -> Band:
        """Give the band when the laws' parameters are known, and each test within the limits was run."""
        files = {
            **self._now.files,
            **{
                field.law: with_tests(field.law.file, [field.conditions(row) for row in range(len(field))])
                for field in fields
            },
        }
        tested = [field.law for field in fields if len(field)]
        own = self._unknown.of_kind("parameters")
        covariance = self._now.covariance.copy()
        for law in tested:
            covariance = self._with_form(covariance, law, files[law])
        for place, quantity in enumerate(self._unknown.quantities):
            if own[place] and self._unknown.laws[quantity.clamps[0]] in tested:
                covariance[place] = covariance[:, place] = 0.0
        return self._amplitude(covariance)

    def map_of(self, field: LoopTests) -> Map:
        """Give what every test of a law leaves."""
        interval = field.law.file.range
        tested = {name: (one.minimum, one.maximum) for name, one in interval.items() if name in field.grid}
        share = self._left(self._told_of(field, self._now), self._now) / self._deviation(self._now)
        return Map(field.law.file.name, field.grid, share, self._motion(field.law), tested)

    def _motion(self, law: VariedLaw) -> dict[str, float]:
        """Give A, f and T at the peak, of that clamp of a law which moves most."""
        own = [place for place, other in enumerate(self._unknown.laws) if other is law]
        place = max(own, key=lambda one: amplitudes_of(self._state)[one])
        return {
            "A": amplitudes_of(self._state)[place], "f": self._state.frequency, "T": self._clamps[place].temperature
        }  # fmt: skip

    def _best(
        self, fields: Sequence[LoopTests], left: Sequence[Array], deviation: float, known: _Known
    ) -> tuple[int, int]:
        """Give the field and the row of the best test."""
        lowest = min(float(one.min(initial=np.inf)) for one in left)
        enough = deviation - AS_GOOD_SHARE * (deviation - lowest)
        choices = []
        for place, (field, one) in enumerate(zip(fields, left, strict=True)):
            tested = {
                name: (interval.minimum, interval.maximum)
                for name, interval in known.files[field.law].range.items()
                if name in field.grid
            }
            away = away_from(field.grid, tested)
            choices += [(float(away[row]), float(one[row]), place, int(row)) for row in np.flatnonzero(one <= enough)]
        *_, place, row = min(choices)
        return place, row

    def _left(self, told: LoopTests, known: _Known) -> Array:
        """Give the peak's standard deviation after each test of a field, as `_told_of` gives it, mm, shape (R,)."""
        own = self._own(told.law)
        less = told.less(known.covariance[np.ix_(own, own)], self._wanted.by_amplitude[own])
        return np.asarray(np.sqrt(np.maximum(self._deviation(known) ** 2 - less, 0.0)))

    def _after(self, told: LoopTests, row: int, known: _Known) -> _Known:
        """Give what is known after one more test of a field, as `_told_of` gives it."""
        own, covariance = self._own(told.law), known.covariance.copy()
        covariance[np.ix_(own, own)] = told.after(known.covariance[np.ix_(own, own)], row)
        file = with_tests(known.files[told.law], [told.conditions(row)])
        return _Known(covariance, {**known.files, told.law: file})

    def _told_of(self, field: LoopTests, known: _Known) -> LoopTests:
        """Give tests that tell of a law's form on the pipe too, in the order of `_own`."""
        places = self._form(field.law).reshape(-1, len(SHARE_OF_PARAMETER))
        if not places.size:
            return field
        used = [self._used(self._unknown.quantities[first].clamps[0]) for first in places[:, 0]]
        deviations = np.sqrt(np.diag(known.covariance))[places]
        return field.with_form(replace(field.law, file=known.files[field.law]), used, deviations)

    def _used(self, clamp: int) -> dict[str, float]:
        """Give the conditions at which a clamp's law is used, by name."""
        return {**self._at[clamp], **self._state.beyond[clamp]}

    def _own(self, law: VariedLaw) -> IntArray:
        """Give which quantities are a law's parameters, in the order of its names, and then its form's."""
        kind = self._unknown.of_kind("parameters")
        own = [
            place
            for place, quantity in enumerate(self._unknown.quantities)
            if kind[place] and self._unknown.laws[quantity.clamps[0]] is law
        ]
        return np.array([*own, *self._form(law)], dtype=np.intp)

    def _form(self, law: VariedLaw) -> IntArray:
        """Give which quantities say how a law's form is off, clamp by clamp, in the order of `SHARE_OF_PARAMETER`."""
        order = list(SHARE_OF_PARAMETER)
        own = [
            (quantity.clamps[0], order.index(quantity.parameter), place)
            for place, quantity in enumerate(self._unknown.quantities)
            if quantity.kind == "form" and not quantity.lean and self._unknown.laws[quantity.clamps[0]] is law
        ]
        return np.array([place for *_, place in sorted(own)], dtype=np.intp)

    def _with_form(self, covariance: Array, law: VariedLaw, file: LawFile) -> Array:
        """Give the covariance where a law's tests tell of its form what a file says."""
        factors = np.ones(len(covariance))
        for place in self._form(law):
            quantity = self._unknown.quantities[place]
            used, share = self._used(quantity.clamps[0]), SHARE_OF_PARAMETER[quantity.parameter]
            then, now = (getattr(replace(law, file=one).form_at(used), share) for one in (law.file, file))
            factors[place] = now / then if then > 0 else 1.0
        return np.asarray(covariance * np.outer(factors, factors))

    def _deviation(self, known: _Known) -> float:
        return self._wanted.deviation(known.covariance)

    def _amplitude(self, covariance: Array) -> Band:
        """Give the band of the peak's amplitude, each side as far beside the straight one as that before all tests."""
        return self._bent(self._before.amplitude, self._wanted.by_amplitude, covariance, self._wanted.off[1])

    def _bent(self, before: Band, slopes: Array, covariance: Array, off: float) -> Band:
        band = band_of(before.value, slopes, replace(self._unknown, covariance=covariance), self._steps, off)
        share = band.deviation / before.deviation if before.deviation > 0 else 1.0
        low, high = (before.middle + share * (end - before.middle) for end in (before.low, before.high))
        return replace(band, low=low, high=high, middle=before.middle)

    def _told(self, field: LoopTests, row: int, known: _Known) -> NextLoopTest:
        conditions, file = field.conditions(row), field.law.file
        clamps = tuple(name for name, law in zip(self._names, self._unknown.laws, strict=True) if law is field.law)
        frequency = self._bent(self._before.frequency, self._wanted.by_frequency, known.covariance, self._wanted.off[0])
        return NextLoopTest(
            file.name, clamps, conditions["A"], conditions["f"],
            conditions["T"] - CELSIUS if "T" in file.range else None, self._amplitude(known.covariance), frequency,
        )  # fmt: skip


def test_words(test: NextLoopTest) -> str:
    """Say which test it is."""
    warm = "the temperature of the tests so far" if test.temperature_C is None else f"{test.temperature_C:.3g} °C"
    return (
        f"{PROFILES[SINE].words} of the clamp of {test.law} at {test.amplitude_mm:.3g} mm, {test.frequency_Hz:.3g} Hz, "
        f"{warm}, {RUNS_OF_A_TEST} times"
    )
