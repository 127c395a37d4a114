"""Loop tests that could be run, and what each would tell of a law's parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pipeclamp_identification.campaign.rig.plan import TestPlan
from pipeclamp_identification.diagnosis.further_test.limits import Limits, drivable_grid, reach_around
from pipeclamp_identification.diagnosis.further_test.outlook import (
    HARMONICS_FORETOLD,
    PROFILES,
    RUNS_OF_A_TEST,
    SINE,
    sensor_noise,
)
from pipeclamp_identification.fitting.observations import harmonic_slopes
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.file import Interval, KrigedShare, LawFile, LocalForm, law_of
from pipeclamp_models.law.local_form import Kriged
from pipeclamp_models.law.range import as_in_range, celsius_tested
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import sinusoids
from pipeclamp_system.bands.varied import SHARE_OF_PARAMETER, VariedLaw

PLANNED_LEVELS_OF_A_AND_F = 7
"""Of amplitude and of frequency at which tests are sought."""
PLANNED_LEVELS_OF_T = 4
"""Of temperature."""
RIG = TestPlan()
"""What a rig is taken for where nothing tells."""


@dataclass(frozen=True, eq=False)
class LoopTests:
    """R tests of a law's clamp that could be run next.

    Attributes:
        law: the law with what isn't known of it.
        grid: their conditions, A (mm), f (Hz), T (K), shape (R,) each.
        slopes: of what a test measures by the law's parameters, N, shape (P, R, m).
        error: covariance of what the mean of a test's repeats measures about the law, by noise and scatter, N2, shape
            (R, m, m).
        off: changes of what a test measures by the shares by which the law's form is off there, in the order of
            `SHARE_OF_PARAMETER`, N, shape (2, R, m).
        further: other conditions of the tests, by name.
    """

    law: VariedLaw
    grid: Mapping[str, Array]
    slopes: Array
    error: Array
    off: Array
    further: Mapping[str, float] = field(default_factory=dict)

    def __len__(self) -> int:
        """Give how many there are."""
        return len(self.grid["A"])

    def conditions(self, row: int) -> dict[str, float]:
        """Give the conditions of a test, by name."""
        return {**self.further, **{name: float(values[row]) for name, values in self.grid.items()}}

    def with_form(self, law: VariedLaw, used: Sequence[Mapping[str, float]], deviations: Array) -> LoopTests:
        """Give the same with the shares by which the law's form is off where it is used, after its parameters.

        What a test says of the form there is what it has in common with the form where the law is used; the rest of
        it is an error of the test, which repeats don't change.

        Args:
            law: the law with all its tests so far.
            used: conditions at U places.
            deviations: standard deviations of the shares there, in the units that their covariance will be given in;
                shape (U, 2).
        """
        slopes, error = np.zeros((*deviations.shape, *self.error.shape[:2])), self.error.copy()
        for row in range(len(self)):
            told = [law.form_told(self.conditions(row), one) for one in used]
            for place, share in enumerate(SHARE_OF_PARAMETER.values()):
                there = told[0][share][0]
                alike = np.array([one[share][1] for one in told])
                direction = there * self.off[place, row]
                for number in np.flatnonzero(deviations[:, place]).tolist():
                    slopes[number, place, row] = alike[number] / deviations[number, place] / len(used) * direction
                error[row] += (1 - np.mean(alike) ** 2) * np.outer(direction, direction)
        every = np.concatenate([self.slopes, slopes.reshape(-1, *self.error.shape[:2])])
        return replace(self, slopes=every, error=error)

    def less(self, covariance: Array, wanted: Array) -> Array:
        """Give by how much each test makes the variance of a number smaller, shape (R,).

        Args:
            covariance: of the law's parameters before the test, shape (P, P).
            wanted: derivatives of the number by them, shape (P,).
        """
        told = np.einsum("prm,p->rm", self.slopes, covariance @ wanted)
        solved = np.linalg.solve(self._seen(covariance), told[..., None])[..., 0]
        return np.asarray(np.sum(told * solved, axis=1))

    def after(self, covariance: Array, row: int) -> Array:
        """Give the covariance of the law's parameters after a test, shape (P, P); before it is `covariance`."""
        told = covariance @ self.slopes[:, row]
        seen = self.slopes[:, row].T @ told + self.error[row]
        left = covariance - told @ np.linalg.solve(seen, told.T)
        return np.asarray((left + left.T) / 2)

    def _seen(self, covariance: Array) -> Array:
        """Give the covariance of what the tests will measure, shape (R, m, m)."""
        by_parameters = np.einsum("prm,pq,qrn->rmn", self.slopes, covariance, self.slopes, optimize=True)
        return np.asarray(by_parameters + self.error)


def reach_of(file: LawFile, limits: Limits | None, celsius: float) -> Limits:
    """Give where a law's clamp may be tested: within the limits, else around what it was tested at.

    Args:
        file: the law.
        limits: what the rig can do, where stated.
        celsius: the temperature for a law whose tests had none that is known.
    """
    A, f, T = file.range["A"], file.range["f"], file.range.get("T")
    tested = celsius_tested(T) if T else (celsius, celsius)
    return reach_around(
        (A.minimum, A.maximum), (f.minimum, f.maximum), tested, limits, warmed=T is not None, timed=file.data.is_timed
    )


def loop_tests(
    law: VariedLaw,
    limits: Limits,
    near: Mapping[str, float] | None,
    further: Mapping[str, float],
    noise_N: float | None,
) -> LoopTests:
    """Give the tests of a law's clamp within closed limits; none where the rig can drive none.

    Args:
        law: the law with what isn't known of it.
        limits: what the rig can do; its ranges are finite.
        near: A (mm), f (Hz) and T (K) of the motion that matters, which is looked at too as far as the rig reaches;
            None where it isn't known.
        further: other conditions that the law follows, in its units: as on the pipe.
        noise_N: rms noise of the force; None for the scatter that the law's file tells.
    """
    profile, file = PROFILES[SINE], law.file
    levels = {
        "A": np.geomspace(
            limits.amplitude[0], limits.amplitude[1] / profile.peak_displacement, PLANNED_LEVELS_OF_A_AND_F
        ),
        "f": np.geomspace(limits.frequency[0], limits.frequency[1], PLANNED_LEVELS_OF_A_AND_F),
        "T": np.linspace(*limits.temperature, PLANNED_LEVELS_OF_T),
    }
    for name, values in levels.items():
        interval = file.range.get(name)
        ends = (interval.minimum, interval.maximum) if interval else ()
        if interval and name == "T":
            ends = celsius_tested(interval)
        also = [near[name] - (CELSIUS if name == "T" else 0.0)] if near else []
        levels[name] = np.array([*values, *ends, *also])
    grid = drivable_grid(profile, levels, limits)
    slopes, error, off, peak = _foretold(law, grid, further, noise_N)
    kept = np.flatnonzero(peak <= limits.force)
    at = {name: values[kept] for name, values in grid.items()}
    return LoopTests(law, at, slopes[:, kept], error[kept], off[:, kept], further)


def _foretold(
    law: VariedLaw, grid: Mapping[str, Array], further: Mapping[str, float], noise_N: float | None
) -> tuple[Array, Array, Array, Array]:
    """Give slopes, error and what is off of `LoopTests`, and the largest force of each, N, shape (R,)."""
    own = law_of(law.file)
    equations = own.structure.equations_without_rig
    motion = sinusoids(grid["A"], grid["f"], grid["T"], about=law.file.about)
    others = {name: np.full_like(motion.slow["A"], value) for name, value in further.items()}
    motion = replace(motion, slow={**motion.slow, **others})
    force = force_of_equations(equations, own.vector(equations), (own.v_r, own.y_r), motion, derivatives=True)
    names = [*law.names, *SHARE_OF_PARAMETER]
    places = np.array([equations.names.index(name) for name in names], dtype=np.intp)
    every = harmonic_slopes(force, HARMONICS_FORETOLD, places)
    count = len(law.names)
    noise = test_noise(law.file, noise_N, force.force)
    error = sensor_noise(noise, RIG.rate, motion, every.shape[2]) / RUNS_OF_A_TEST
    runs = law.file.spread.runs if law.file.spread else None
    for share, direction in zip(SHARE_OF_PARAMETER.values(), every[count:], strict=True):
        scatter = getattr(runs, share) ** 2 / RUNS_OF_A_TEST if runs else 0.0
        error += scatter * direction[:, :, None] * direction[:, None, :]
    return every[:count], error, every[count:], np.asarray(np.abs(force.force).max(axis=1, initial=0.0))


def test_noise(file: LawFile, stated: float | None, forces: Array) -> Array:
    """Give the rms noise of the force in tests whose force the law foretells, N, shape (R,).

    As stated; else the share of the force that scatters in the law's own tests; else what the virtual rig has.
    """
    share = file.fit.noise_nrmse if file.fit else None
    if stated is None and share is not None:
        return np.asarray(share * np.sqrt(np.mean(forces**2, axis=1)))
    return np.full(len(forces), RIG.force_noise if stated is None else stated)


def noise_words(file: LawFile, stated: float | None) -> str:
    """Say what noise of the force is reckoned with."""
    share = file.fit.noise_nrmse if file.fit else None
    if stated is not None:
        return f"{stated:g} N rms, as stated"
    if share is not None:
        return f"{share:.2%} of the force, as in the tests of {file.name}"
    return f"{RIG.force_noise:g} N rms, as of the virtual rig"


def with_tests(file: LawFile, tests: Sequence[Mapping[str, float]]) -> LawFile:
    """Give a law's file whose range, and what it tells of its form near tests, holds further ones.

    What these will show is taken to be what the law's file foretells, known as well as each of its tests shows it.

    Args:
        file: the law.
        tests: conditions of each, by the names of the law's range or of its equations.
    """
    tests = [as_in_range(file, one) for one in tests]
    wider = {
        name: Interval(
            minimum=min([interval.minimum, *(one[name] for one in tests if name in one)]),
            maximum=max([interval.maximum, *(one[name] for one in tests if name in one)]),
            unit=interval.unit,
        )
        for name, interval in file.range.items()
    }
    spread = file.spread
    if spread is not None and spread.local is not None:
        local = spread.local
        at = {
            name: (*values, *(one.get(name, float(np.median(values))) for one in tests))
            for name, values in local.at.items()
        }
        shares = {share: _with_tests(local, getattr(local, share), tests) for share in SHARE_OF_PARAMETER.values()}
        spread = spread.model_copy(update={"local": LocalForm(at=at, **shares)})
    return file.model_copy(update={"range": wider, "spread": spread})


def _with_tests(local: LocalForm, share: KrigedShare, tests: Sequence[Mapping[str, float]]) -> KrigedShare:
    kriged, variance = Kriged.of(local, share), float(np.median(share.variances)) / RUNS_OF_A_TEST
    return share.model_copy(
        update={
            "shares": (*share.shares, *(kriged.at(one)[0] for one in tests)),
            "variances": (*share.variances, *[variance] * len(tests)),
        }
    )
