"""The search for the loop tests that narrow the band of one peak most, one after another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pipeclamp_identification.diagnosis.further_test.limits import Limits, limits_words
from pipeclamp_identification.diagnosis.further_test.next_test import away_from
from pipeclamp_identification.planning.band_plan import Map, NextLoopTest
from pipeclamp_identification.planning.loop_tests import LoopTests, loop_tests, reach_of, with_tests
from pipeclamp_models.base.arrays import Array, IntArray
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.file import LawFile
from pipeclamp_system.bands.band import Band, band_of, steps_of
from pipeclamp_system.bands.quantities import Unknown
from pipeclamp_system.bands.response import BandedSystem
from pipeclamp_system.bands.response_bands import PeakBand
from pipeclamp_system.bands.sensitivity import conditions_at
from pipeclamp_system.bands.varied import SHARE_OF_PARAMETER, VariedLaw
from pipeclamp_system.response.curves import Curve
from pipeclamp_system.steady.clamp import SteadyClamp
from pipeclamp_system.steady.described import steady_clamps
from pipeclamp_system.steady.states import SteadyState, amplitudes_of

MOST_TESTS = 5
"""That are proposed one after another."""
WORTH_SHARE = 0.03
"""Share of the band's width that a test must take to be worth its rig time."""
AS_GOOD_SHARE = 0.95
"""A test that narrows by this share of what the best one does is as good: of these the nearest to what was tested."""


def tests_of_clamp(
    law: VariedLaw, clamp: SteadyClamp, limits: Limits | None, near: Mapping[str, float] | None, noise_N: float | None
) -> tuple[LoopTests, str]:
    """Give the tests of a law's clamp, as of `loop_tests`, and within which limits they are, in words."""
    within = reach_of(law.file, limits, clamp.temperature - CELSIUS)
    return loop_tests(law, within, near, clamp.further, noise_N), limits_words(within)


@dataclass(frozen=True, eq=False)
class Wanted:
    """A peak: of which curve, at which point, and its derivatives by what isn't known, (Q,)."""

    curve: Curve
    point: int
    amplitude: float
    by_amplitude: Array
    by_frequency: Array
    off: tuple[float, float]

    def deviation(self, covariance: Array) -> float:
        """Give its deviation by a covariance of what isn't known, (Q, Q), and by its own error, mm."""
        return float(np.sqrt(self.by_amplitude @ covariance @ self.by_amplitude + self.off[1] ** 2))

    @property
    def state(self) -> SteadyState:
        """The highest state."""
        return max(self.curve.states, key=lambda state: amplitudes_of(state)[self.point])


def wanted_peak(system: BandedSystem, curve: Curve, point: int) -> Wanted:
    """Give the peak of a curve at a point."""
    sizes = system.unknown.scales
    piece = max(system.moving(curve)[point], key=lambda one: one.peak()[1])
    by_frequency, by_amplitude = piece.peak_moves(sizes)
    return Wanted(curve, point, piece.peak()[1], by_amplitude, by_frequency, piece.peak_errors())


@dataclass(frozen=True, eq=False)
class _Known:
    """What is known once some tests were run.

    Attributes:
        covariance: of all that isn't known, (Q, Q).
        files: of each law, whose range holds the tests.
    """

    covariance: Array
    files: Mapping[VariedLaw, LawFile]


class NarrowingSearch:
    """The tests that narrow the band of one peak."""

    def __init__(
        self, path: Path, system: BandedSystem, wanted: Wanted, before: PeakBand, per_cent: float,
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
        return tests_of_clamp(law, clamp, limits, self._motion(law), noise_N)

    def one_after_another(self, fields: Sequence[LoopTests]) -> list[NextLoopTest]:
        """Give tests, each the best once those before it were run."""
        known, found = self._now, list[NextLoopTest]()
        while len(found) < MOST_TESTS:
            deviation = self._deviation(known)
            telling = [self._telling_of_form(field, known) for field in fields]
            left = [self._left(tests, known) for tests in telling]
            place, row = self._best(fields, left, deviation, known)
            if not left[place].size or 1 - left[place][row] / deviation < WORTH_SHARE:
                break
            known = self._after(telling[place], row, known)
            found.append(self._proposal(fields[place], row, known))
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
        share = self._left(self._telling_of_form(field, self._now), self._now) / self._deviation(self._now)
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

    def _left(self, tests: LoopTests, known: _Known) -> Array:
        """Give the peak's standard deviation after each of tests, as `_telling_of_form` gives them, mm, shape (R,)."""
        own = self._own(tests.law)
        less = tests.less(known.covariance[np.ix_(own, own)], self._wanted.by_amplitude[own])
        return np.asarray(np.sqrt(np.maximum(self._deviation(known) ** 2 - less, 0.0)))

    def _after(self, tests: LoopTests, row: int, known: _Known) -> _Known:
        """Give what is known after one more of tests, as `_telling_of_form` gives them."""
        own, covariance = self._own(tests.law), known.covariance.copy()
        covariance[np.ix_(own, own)] = tests.after(known.covariance[np.ix_(own, own)], row)
        file = with_tests(known.files[tests.law], [tests.conditions(row)])
        return _Known(covariance, {**known.files, tests.law: file})

    def _telling_of_form(self, field: LoopTests, known: _Known) -> LoopTests:
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

    def _proposal(self, field: LoopTests, row: int, known: _Known) -> NextLoopTest:
        conditions, file = field.conditions(row), field.law.file
        clamps = tuple(name for name, law in zip(self._names, self._unknown.laws, strict=True) if law is field.law)
        frequency = self._bent(self._before.frequency, self._wanted.by_frequency, known.covariance, self._wanted.off[0])
        return NextLoopTest(
            file.name, clamps, conditions["A"], conditions["f"],
            conditions["T"] - CELSIUS if "T" in file.range else None, self._amplitude(known.covariance), frequency,
        )  # fmt: skip
