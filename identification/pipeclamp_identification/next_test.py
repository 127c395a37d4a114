"""Which test next: the test whose outcome differs most between rivals, against scatter and against their own doubt."""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import logsumexp

from pipeclamp import symbols
from pipeclamp.errors import UsageError
from pipeclamp.realise.arrays import Array
from pipeclamp.response import Motion, Response, respond
from pipeclamp.symbols import CELSIUS
from pipeclamp_identification.diagnose import FORM, Diagnosis
from pipeclamp_identification.fit import HELD, WISHED, parameter_bounds
from pipeclamp_identification.observations import SAMPLES, Rows, data_scales, harmonics_of
from pipeclamp_identification.problem import Judged
from pipeclamp_identification.screen import effect_id

HARMONICS = 12
CYCLES = 5
REPEATS = 3
"""Runs of a proposed test: what scatters from run to run shows in repeats only."""
LEVELS = 6
TEMPERATURES = 4
SURELY = 8.0
"""Standard deviations from which on a test is sure to tell."""
NEARLY = 0.8
"""A test whose log chance of a mistake is this share of the best test's tells nearly as much."""
MOST_RIVALS = 4
"""Rivals that one test is sought for, best first."""
REACH_A = (0.5, 1.5)
"""Without stated limits: amplitudes from half the smallest to one and a half times the largest tested."""
REACH_F = (0.5, 2.0)
"""Without stated limits: frequencies from half the lowest to twice the highest tested."""
RIDING = 0.25
RIDING_ORDER = 7
SINE, RIDDEN = "sine", "small cycles on a large one"
PROFILES = {
    SINE: "a sine test",
    RIDDEN: f"small cycles on a large one ({RIDING:g} of its amplitude at {RIDING_ORDER} times its frequency)",
}


@dataclass(frozen=True)
class Limits:
    """What the rig can do: amplitude mm, frequency Hz, temperature degC, (lowest, highest) each."""

    amplitude: tuple[float, float]
    frequency: tuple[float, float]
    temperature: tuple[float, float]


def parse_limits(text: str) -> Limits:
    """Read limits such as `A=0.1..2,f=0.5..20,T=20..300`.

    Raises:
        UsageError: the text is not of this form.
    """
    found: dict[str, tuple[float, float]] = {}
    for entry in text.split(","):
        match = re.fullmatch(r"\s*([AfT])\s*=\s*([-+.\deE]+)\s*\.\.\s*([-+.\deE]+)\s*", entry)
        try:
            name, low, high = match.groups() if match else ("", "", "")
            found[name] = (float(low), float(high))
        except ValueError as error:
            raise UsageError(f"--limits: got {entry!r}; expected A=0.1..2,f=0.5..20,T=20..300") from error
    if set(found) != {"A", "f", "T"} or any(low > high for low, high in found.values()):
        raise UsageError(
            f"--limits: got {text!r}; expected all of A, f, T, lower end first: A=0.1..2,f=0.5..20,T=20..300"
        )
    if min(*found["A"], *found["f"]) <= 0:
        raise UsageError(f"--limits: got {text!r}; expected A and f above 0")
    return Limits(found["A"], found["f"], found["T"])


@dataclass(frozen=True)
class Proposal:
    """A test and what it would tell.

    Attributes:
        amplitude_mm, frequency_Hz, temperature_C: its conditions; no temperature where that of the tests isn't known.
        further: further conditions that matter to a rival: columns of runs.csv, as in a law's signals.
        profile: SINE or RIDDEN.
        separation: expected difference between the predictions of those two rivals that it separates least, in standard
            deviations of scatter and doubt.
        rivals: names, best first.
        motion: the motion, one row.
        forces: what each rival predicts, N, shape (rivals, n).
    """

    amplitude_mm: float
    frequency_Hz: float
    temperature_C: float | None
    further: Mapping[str, float]
    profile: str
    separation: float
    rivals: tuple[str, ...]
    motion: Motion
    forces: Array

    def words(self) -> str:
        """Say what to do."""
        further = "".join(f", {_further_words(name, value)}" for name, value in self.further.items())
        two = len(self.rivals) == 2
        who = " and ".join(self.rivals) if two else f"any two of {', '.join(self.rivals)}"
        return (
            f"run {PROFILES[self.profile]} at {self.amplitude_mm:.3g} mm, {self.frequency_Hz:.3g} Hz, "
            f"{temperature_words(self.temperature_C)}{further}, {REPEATS} times: {who} then differ by "
            f"{'' if two else 'at least '}{self.separation:.1f} standard deviations"
        )


def temperature_words(temperature_C: float | None) -> str:
    """Say at which temperature a test is proposed."""
    return "the temperature of the tests so far" if temperature_C is None else f"{temperature_C:.3g} degC"


def _further_words(signal: str, value: float) -> str:
    if signal == str(symbols.N):
        return f"after {value:.0f} load cycles"
    if signal == str(symbols.rho):
        return f"density {value:.4g} g/cm3"
    return f"{signal.removeprefix(symbols.CONDITION)} {value:.4g}"


def reach(tested: Motion, stated: Limits | None) -> Limits:
    """Give the limits of the next test: the stated ones, else around what was tested.

    Where the temperature of the tests isn't known, it stays the assumed one: laws foretell nothing of another.
    """
    (A_low, A_high), (f_low, f_high), T = (_span(tested, name) for name in ("A", "f", "T"))
    tested_T = (T[0] - CELSIUS, T[1] - CELSIUS)
    if stated is not None:
        return replace(stated, temperature=tested_T) if "T" in tested.assumed else stated
    return Limits((REACH_A[0] * A_low, REACH_A[1] * A_high), (REACH_F[0] * f_low, REACH_F[1] * f_high), tested_T)


def _span(motion: Motion, signal: str) -> tuple[float, float]:
    """Give the lowest and highest value of a slow signal."""
    return float(np.min(motion.slow[signal])), float(np.max(motion.slow[signal]))


@dataclass(frozen=True)
class _Outlook:
    """What tests of one profile would tell: for R conditions.

    Attributes:
        profile: SINE or RIDDEN.
        motion: R motions.
        forces: of each rival, N, shape (rivals, R, n).
        mistaken: log of the chance of taking one rival for another, summed over pairs, shape (R,).
        apart: standard deviations between the two rivals that are separated least, shape (R,).
    """

    profile: str
    motion: Motion
    forces: Array
    mistaken: Array
    apart: Array


def next_test(diagnosis: Diagnosis, limits: Limits | None = None) -> Proposal | None:
    """Give the test that separates the rivals of an ambiguous diagnosis best; None where there are none.

    Of two rivals one is taken for true and the other refitted to what the first foretells. What the refit can make up
    for, what scatters, and what either effect's form may leave over don't count. Of all pairs, the Bhattacharyya bound
    sums the chance exp(-d^2/8) of taking one for the other. Of the tests that surely tell, or tell nearly as much as
    the best, the one nearest to what was tested is proposed: the farther away, the less holds what laws foretell.
    """
    if diagnosis.verdict != "ambiguous":
        return None
    names = diagnosis.effects[:MOST_RIVALS]
    rivals = [_foreseer(_of(name, diagnosis), diagnosis) for name in names]
    so_far = diagnosis.problem.observations.motion
    tested = {name: _span(so_far, name) for name in ("A", "f", "T")}
    grid = _grid(reach(so_far, limits), tested, _further_levels(rivals, diagnosis))
    outlooks = [_outlook(profile, grid, rivals, diagnosis) for profile in PROFILES]
    mistaken = np.stack([outlook.mistaken for outlook in outlooks])
    away = _away(grid, tested) + np.array([[RIDING if outlook.profile == RIDDEN else 0.0] for outlook in outlooks])
    enough = mistaken <= max(-(SURELY**2) / 8, NEARLY * float(mistaken.min()))
    best = np.lexsort((mistaken.ravel(), np.where(enough, away, np.inf).ravel()))[0]
    place, row = divmod(int(best), mistaken.shape[1])
    outlook = outlooks[place]
    A, f, T = (float(grid[name][row]) for name in ("A", "f", "T"))
    further = {name: float(values[row]) for name, values in grid.items() if name not in ("A", "f", "T")}
    motion = outlook.motion.rows(np.array([row]))
    return Proposal(
        A, f, None if "T" in so_far.assumed else T - CELSIUS, further, outlook.profile, float(outlook.apart[row]),
        names, motion, outlook.forces[:, row],
    )  # fmt: skip


def _outlook(profile: str, grid: Mapping[str, Array], rivals: Sequence[_Foreseer], diagnosis: Diagnosis) -> _Outlook:
    """Tell what tests of a profile at a grid of conditions would tell."""
    motion = _motions(grid, profile, diagnosis)
    without = harmonics_of(_response(diagnosis.law, motion).force, HARMONICS)
    responses = [_response(rival.judged, motion) for rival in rivals]
    noise, form = _noise(motion, without, diagnosis), _form(responses, without)
    pairs = list(itertools.combinations(range(len(rivals)), 2))
    known = np.stack([_distance(rivals, responses, pair, noise + form) for pair in pairs])
    apart = np.stack([_distance(rivals, responses, pair, noise) for pair in pairs])
    forces = np.stack([response.force for response in responses])
    return _Outlook(profile, motion, forces, logsumexp(-(known**2) / 8, axis=0), apart.min(axis=0))


def _of(name: str, diagnosis: Diagnosis) -> Judged:
    """Give the best candidate of an id."""
    return next(candidate for candidate in diagnosis.candidates if effect_id(candidate.effects[0]) == effect_id(name))


@dataclass(frozen=True)
class _Foreseer:
    """A rival with what it doesn't know.

    Attributes:
        judged: the rival.
        places: of parameters that are in doubt, those that the tests so far hold open included.
        covariance: of them.
    """

    judged: Judged
    places: Rows
    covariance: Array


def _foreseer(judged: Judged, diagnosis: Diagnosis) -> _Foreseer:
    """Give a rival with its doubt.

    A parameter that was held, as what it follows didn't vary, is fitted once a test varies it: until then all that is
    known of it is its bounds, as an even spread between them.
    """
    result, observations = judged.result, diagnosis.problem.observations
    equations = result.equations
    lower, upper = parameter_bounds(equations, data_scales(observations))
    held = {name for name, reason in result.frozen.items() if reason not in (HELD, WISHED)}
    opened = [
        place
        for place, name in enumerate(equations.names)
        if name in held and np.isfinite(upper[place] - lower[place]) and equations.parameters[place].follows
    ]
    places = np.array([*result.places, *opened], dtype=np.intp)
    law = result.law
    response = respond(equations, law.vector(equations), (law.v_r, law.y_r), observations.motion, derivatives=True)
    slopes = np.nan_to_num(observations.residual_slopes(response, places).reshape(len(places), -1))
    information = slopes @ slopes.T
    evenly = np.arange(len(result.places), len(places))
    information[evenly, evenly] += 12.0 / (upper - lower)[opened] ** 2
    scale = np.sqrt(np.maximum(np.diag(information), 1e-300))
    covariance = np.linalg.pinv(information / np.outer(scale, scale), rcond=1e-12, hermitian=True)
    return _Foreseer(judged, places, covariance / np.outer(scale, scale))


def _further_levels(rivals: Sequence[_Foreseer], diagnosis: Diagnosis) -> dict[str, Array]:
    """Give the levels of each further condition that a rival follows: as tested; of load cycles those yet to come."""
    tested = diagnosis.problem.observations.motion.slow
    followed = {str(signal) for rival in rivals for signal in rival.judged.result.equations.slow_signals}
    levels = {}
    for name in sorted(followed - {"A", "f", "T"}):
        values = tested[name]
        seen = np.quantile(values, [0.0, 0.5, 1.0])
        levels[name] = np.unique(seen[2] * np.array([1.0, 2.0, 4.0]) if name == str(symbols.N) else seen)
    return levels


def _grid(limits: Limits, tested: Mapping[str, tuple[float, float]], further: Mapping[str, Array]) -> dict[str, Array]:
    """Give every combination of conditions, each a column of shape (R,); T in K."""
    T = (limits.temperature[0] + CELSIUS, limits.temperature[1] + CELSIUS)
    spread = {
        "A": np.geomspace(*limits.amplitude, LEVELS), "f": np.geomspace(*limits.frequency, LEVELS),
        "T": np.linspace(*T, TEMPERATURES),
    }  # fmt: skip
    # What was tested is also a place to test, as far as the rig reaches.
    levels = {
        name: np.unique(np.concatenate([values, np.clip(tested[name], values[0], values[-1])]))
        for name, values in spread.items()
    }
    every = {**levels, **further}
    return dict(zip(every, np.array(list(itertools.product(*every.values()))).T, strict=True))


def _away(grid: Mapping[str, Array], tested: Mapping[str, tuple[float, float]]) -> Array:
    """Give how far outside of what was tested conditions lie, shape (R,): octaves of A and f, hundreds of kelvin."""
    away = np.zeros(len(grid["A"]))
    for name, (low, high) in tested.items():
        values = grid[name]
        outside = np.clip(values, low, high)
        away += np.abs(values - outside) / 100 if name == "T" else np.abs(np.log2(values / outside))
    return away


def _motions(grid: Mapping[str, Array], profile: str, diagnosis: Diagnosis) -> Motion:
    """Give the motions of a grid of conditions; those that it doesn't name as in the middle run."""
    column = {name: values[:, None] for name, values in grid.items()}
    A, f = column["A"], column["f"]
    theta = 2 * np.pi * np.arange(SAMPLES) / SAMPLES
    omega = 2 * np.pi * f
    y, v, a = np.zeros((3, len(A), SAMPLES))
    tones = ((1, 1.0),) if profile == SINE else ((1, 1.0), (RIDING_ORDER, RIDING))
    for order, share in tones:
        y += share * A * np.cos(order * theta)
        v -= share * A * order * omega * np.sin(order * theta)
        a -= share * A * (order * omega) ** 2 * np.cos(order * theta)
    tested = diagnosis.problem.observations.motion.slow
    middle = {name: np.full_like(A, float(np.median(values))) for name, values in tested.items()}
    return Motion(y, v, a, {**middle, **column}, 1.0 / (f * SAMPLES))


def _response(judged: Judged, motion: Motion) -> Response:
    law, equations = judged.result.law, judged.result.equations
    return respond(equations, law.vector(equations), (law.v_r, law.y_r), motion, derivatives=True)


def _noise(motion: Motion, force: Array, diagnosis: Diagnosis) -> Array:
    """Give the covariance of the mean harmonics of repeated runs: noise and scatter between runs, shape (R, m, m).

    Args:
        motion: R motions.
        force: its harmonics by the law as it is, N, shape (R, m).
        diagnosis: how much noise and scatter there is, at the sampling of the tests so far.
    """
    loops, noise = diagnosis.problem.loops, diagnosis.problem.noise
    rate = float(np.median(loops.samples * loops.frequency_Hz / np.maximum([len(c) for c in loops.cycles], 1)))
    white = float(np.median(loops.noise_rms_N)) ** 2 * 2 / CYCLES
    samples = np.maximum(rate / motion.slow["f"], 1.0)
    covariance = np.eye(force.shape[1]) * (white / samples)[:, :, None]
    for part, scatter in ((slice(1, None, 2), noise.stiffness_scatter), (slice(2, None, 2), noise.damping_scatter)):
        direction = np.zeros_like(force)
        direction[:, part] = scatter * force[:, part]
        covariance = covariance + direction[:, :, None] * direction[:, None, :]
    return covariance / REPEATS


def _form(responses: Sequence[Response], without: Array) -> Array:
    """Give the covariance of harmonics that effects of another form than the catalogue's may leave over, (R, m, m).

    Args:
        responses: of the rivals on R motions.
        without: harmonics of the law without any of them, N, shape (R, m).
    """
    beyond = [np.sum((harmonics_of(each.force, HARMONICS) - without) ** 2, axis=1) for each in responses]
    return np.asarray(np.eye(without.shape[1]) * (FORM**2 * np.max(beyond, axis=0))[:, None, None])


def _distance(
    rivals: Sequence[_Foreseer], responses: Sequence[Response], pair: tuple[int, int], granted: Array
) -> Array:
    """Give the Mahalanobis distance of what two rivals foretell when the other is refitted to either, shape (R,).

    Args:
        rivals: all of them.
        responses: of each on R motions.
        pair: the two.
        granted: covariance of harmonics that tells nothing, N2, shape (R, m, m).
    """
    foretold = [harmonics_of(responses[place].force, HARMONICS) for place in pair]
    difference = foretold[0] - foretold[1]
    squares = np.full(len(difference), np.inf)
    for place in pair:
        jacobian = responses[place].jacobian
        assert jacobian is not None
        slopes = harmonics_of(jacobian[rivals[place].places], HARMONICS)
        covariance = granted + np.einsum("prm,pq,qrn->rmn", slopes, rivals[place].covariance, slopes, optimize=True)
        solved = np.linalg.solve(covariance, difference[..., None])[..., 0]
        squares = np.minimum(squares, np.sum(difference * solved, axis=1))
    return np.asarray(np.sqrt(np.maximum(np.nan_to_num(squares), 0.0)))
