"""Which test next: the test whose outcome differs most between rivals, against scatter and against their own doubt."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeclamp.errors import UserError
from pipeclamp.realise.arrays import Array
from pipeclamp.response import Motion, Response, respond
from pipeclamp_identification.diagnose import Diagnosis
from pipeclamp_identification.observations import SAMPLES, harmonics_of
from pipeclamp_identification.problem import Judged
from pipeclamp_identification.screen import effect_id

CELSIUS = 273.15
HARMONICS = 12
CYCLES = 5
LEVELS = 6
REACH_A = (0.5, 1.5)
"""Without stated limits: amplitudes from half the smallest to one and a half times the largest tested."""
REACH_F = (0.5, 2.0)
"""Without stated limits: frequencies from half the lowest to twice the highest tested."""
RIDING = 0.25
RIDING_ORDER = 7


@dataclass(frozen=True)
class Limits:
    """What the rig can do: amplitude mm, frequency Hz, temperature degC, (lowest, highest) each."""

    amplitude: tuple[float, float]
    frequency: tuple[float, float]
    temperature: tuple[float, float]


def parse_limits(text: str) -> Limits:
    """Read limits such as `A=0.1..2,f=0.5..20,T=20..300`.

    Raises:
        UserError: the text is not of this form.
    """
    found: dict[str, tuple[float, float]] = {}
    for entry in text.split(","):
        match = re.fullmatch(r"\s*([AfT])\s*=\s*([-+.\deE]+)\s*\.\.\s*([-+.\deE]+)\s*", entry)
        try:
            name, low, high = match.groups() if match else ("", "", "")
            found[name] = (float(low), float(high))
        except ValueError as error:
            raise UserError(f"--limits: got {entry!r}; expected A=0.1..2,f=0.5..20,T=20..300") from error
    if set(found) != {"A", "f", "T"} or any(low > high for low, high in found.values()):
        raise UserError(
            f"--limits: got {text!r}; expected all of A, f, T, lower end first: A=0.1..2,f=0.5..20,T=20..300"
        )
    if min(*found["A"], *found["f"]) <= 0:
        raise UserError(f"--limits: got {text!r}; expected A and f above 0")
    return Limits(found["A"], found["f"], found["T"])


@dataclass(frozen=True)
class Proposal:
    """A test and what it would tell.

    Attributes:
        amplitude_mm, frequency_Hz, temperature_C: its conditions.
        profile: "sine", or "small cycles on a large one".
        separation: expected difference between the rivals' predictions in standard deviations of scatter and doubt.
        rivals: names of the two that it separates.
        motion: the motion, one row.
        forces: what each rival predicts, N, shape (2, n).
    """

    amplitude_mm: float
    frequency_Hz: float
    temperature_C: float
    profile: str
    separation: float
    rivals: tuple[str, str]
    motion: Motion
    forces: Array

    def words(self) -> str:
        """Say what to do."""
        return (
            f"run a {self.profile} test at {self.amplitude_mm:.3g} mm, {self.frequency_Hz:.3g} Hz, "
            f"{self.temperature_C:.3g} degC: {self.rivals[0]} and {self.rivals[1]} then differ by "
            f"{self.separation:.1f} standard deviations"
        )


def tested_limits(diagnosis: Diagnosis) -> Limits:
    """Give limits that the tests so far suggest, where the rig's own aren't stated."""
    loops = diagnosis.problem.loops
    return limits_around(loops.amplitude_mm, loops.frequency_Hz, loops.temperature_K - CELSIUS)


def limits_around(amplitude: Array, frequency: Array, temperature: Array) -> Limits:
    """Give limits around what was tested: mm, Hz and degC, nan where a temperature isn't known."""
    T = temperature[np.isfinite(temperature)]
    return Limits(
        (REACH_A[0] * float(amplitude.min()), REACH_A[1] * float(amplitude.max())),
        (REACH_F[0] * float(frequency.min()), REACH_F[1] * float(frequency.max())),
        (float(T.min()), float(T.max())) if len(T) else (20.0, 20.0),
    )


def next_test(diagnosis: Diagnosis, limits: Limits | None = None) -> Proposal | None:
    """Give the test that separates the two closest rivals of an ambiguous diagnosis best; None where there are none.

    Each rival's prediction is that of its refitted law; what it doesn't know of its own parameters counts as scatter,
    so that a test isn't chosen for what either could be refitted to.
    """
    rivals = [_of(name, diagnosis) for name in diagnosis.effects[:2]]
    if diagnosis.verdict != "ambiguous" or len(rivals) < 2:
        return None
    reach = limits or tested_limits(diagnosis)
    grid = list(
        itertools.product(
            np.geomspace(*reach.amplitude, LEVELS), np.geomspace(*reach.frequency, LEVELS),
            np.unique(np.linspace(*reach.temperature, 4)),
        )
    )  # fmt: skip
    best: Proposal | None = None
    for profile in ("sine", "small cycles on a large one"):
        motion = _motions(np.array(grid), profile, diagnosis)
        responses = [_response(rival, motion) for rival in rivals]
        separation = _separation(rivals, responses, motion, diagnosis)
        row = int(np.argmax(separation))
        if best is None or separation[row] > best.separation:
            A, f, T = grid[row]
            one = motion.rows(np.array([row]))
            forces = np.stack([response.force[row] for response in responses])
            names = (diagnosis.effects[0], diagnosis.effects[1])
            best = Proposal(float(A), float(f), float(T), profile, float(separation[row]), names, one, forces)
    return best


def _of(name: str, diagnosis: Diagnosis) -> Judged:
    """Give the best candidate of an id."""
    return next(candidate for candidate in diagnosis.candidates if effect_id(candidate.effects[0]) == effect_id(name))


def _motions(grid: Array, profile: str, diagnosis: Diagnosis) -> Motion:
    """Give the motions of a grid of (A mm, f Hz, T degC), shape (R, 3); further conditions as in the middle run."""
    A, f, T = (grid[:, column, None] for column in range(3))
    theta = 2 * np.pi * np.arange(SAMPLES) / SAMPLES
    omega = 2 * np.pi * f
    y, v, a = np.zeros((3, len(grid), SAMPLES))
    tones = ((1, 1.0),) if profile == "sine" else ((1, 1.0), (RIDING_ORDER, RIDING))
    for order, share in tones:
        y += share * A * np.cos(order * theta)
        v -= share * A * order * omega * np.sin(order * theta)
        a -= share * A * (order * omega) ** 2 * np.cos(order * theta)
    slow = {"A": A, "f": f, "T": T + CELSIUS}
    tested = diagnosis.problem.observations.motion.slow
    further = {name: np.full_like(A, float(np.median(values))) for name, values in tested.items() if name not in slow}
    return Motion(y, v, a, {**slow, **further}, 1.0 / (f * SAMPLES))


def _response(rival: Judged, motion: Motion) -> Response:
    law, equations = rival.result.law, rival.result.equations
    return respond(equations, law.vector(equations), (law.v_r, law.y_r), motion, derivatives=True)


def _separation(rivals: Sequence[Judged], responses: Sequence[Response], motion: Motion, diagnosis: Diagnosis) -> Array:
    """Give the Mahalanobis distance between two rivals' predicted harmonics for each motion, shape (R,)."""
    predicted = [harmonics_of(response.force, HARMONICS) for response in responses]
    difference = predicted[0] - predicted[1]
    loops, noise = diagnosis.problem.loops, diagnosis.problem.noise
    # A mean of some cycles at the sampling of the tests so far.
    per_cycle = float(np.median(loops.samples * loops.frequency_Hz / np.maximum([len(c) for c in loops.cycles], 1)))
    white = float(np.median(loops.noise_rms_N)) ** 2 * 2 / CYCLES
    distances = np.empty(len(difference))
    for row in range(len(difference)):
        size = difference.shape[1]
        covariance = np.eye(size) * white / max(per_cycle / float(motion.slow["f"][row, 0]), 1.0)
        force = predicted[0][row]
        for part, scatter in ((slice(1, None, 2), noise.stiffness_scatter), (slice(2, None, 2), noise.damping_scatter)):
            direction = np.zeros(size)
            direction[part] = force[part]
            covariance += scatter**2 * np.outer(direction, direction)
        for rival, response in zip(rivals, responses, strict=True):
            assert response.jacobian is not None
            slopes = harmonics_of(response.jacobian[rival.result.places, row], HARMONICS)
            covariance += slopes.T @ rival.result.covariance @ slopes
        distances[row] = np.sqrt(difference[row] @ np.linalg.solve(covariance, difference[row]))
    return np.nan_to_num(distances)
