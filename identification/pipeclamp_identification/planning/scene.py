"""What is there before any test: the rig, the clamp that is expected, and what each effect would do in its tests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.diagnosis.further_test.outlook import HARMONICS_FORETOLD, sensor_noise
from pipeclamp_identification.diagnosis.run_scatter import Directions, RunScatter
from pipeclamp_identification.diagnosis.thresholds import MATERIAL_FORCE_SHARE, MATERIAL_NOISE_SHARE
from pipeclamp_identification.fitting.joint.fitted import Fit
from pipeclamp_identification.fitting.observations import harmonic_slopes
from pipeclamp_identification.planning.hidden import bare_law, law_of_size, typical_law
from pipeclamp_identification.planning.rivals import Trial
from pipeclamp_identification.planning.seen import lack_of, norms_of
from pipeclamp_identification.signals.real_harmonics import elastic_and_damping, mean_squares_of, real_harmonics_of
from pipeclamp_models.base.arrays import Array, IntArray
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.law.catalogue import listed
from pipeclamp_models.law.file import LawFile
from pipeclamp_models.law.law import Law
from pipeclamp_models.realise.force import force_of_equations, force_of_law
from pipeclamp_models.realise.motion import Motion, sinusoids

NO_FORCE_SHARE = 1e-9
"""Share of the law's force below which an effect does nothing: rounding."""
SAMPLES_PER_CYCLE = 128
"""Of the cycle at which laws are evaluated; half of them where the catalogue is tried."""
LEVELS_TRIED = {"A": 4, "f": 4, "T": 3}
"""Levels at which the catalogue is tried on an effect."""
DOUBLINGS = 6
"""How often an effect's size is doubled until the diagnosis tries it at all."""


@dataclass(frozen=True, eq=False)
class RivalEffect:
    """Another effect, refitted to what an effect does.

    Attributes:
        name: of it.
        gram: Gram matrices of one run at each condition over noise and scatter: its law's derivatives, and last what
            it leaves over, shape (R, K, K).
        outside: which derivatives are by parameters that ended at their bounds.
        more: parameters that it has more than the effect.
    """

    name: str
    gram: Array
    outside: IntArray
    more: int


@dataclass(frozen=True, eq=False)
class Hidden:
    """An effect of the catalogue in a clamp, in the smallest size that counts.

    Attributes:
        newtons: its rms force over the grid.
        tried_from: rms force from which on the diagnosis tries it at all, N; 0 where in smaller sizes too, inf: never.
        nearest: name of the effect that is most like it.
        rivals: those that may be taken for it.
    """

    newtons: float
    tried_from: float
    nearest: str
    rivals: tuple[RivalEffect, ...]


@dataclass(frozen=True, eq=False)
class Scene:
    """What is there before any test: the rig's noise, the clamp that is expected, the effects that it may have.

    Attributes:
        grid: conditions that may be tested, A (mm), f (Hz), T (K), shape (R,) each.
        effects: E names.
        hidden: what each of them does.
        force: rms force of the law over the grid, N.
        noise: rms of the force sensor, N.
        not_reckoned: effects that follow what no plan of loop tests varies, or change what the base law hasn't got.
        covariance: of the harmonics of one run, N2, shape (R, m, m).
        slopes: derivatives of the harmonics by the law's parameters, N, shape (P, R, m).
        does: harmonics that each effect adds in that size, N, shape (E, R, m).
    """

    grid: Mapping[str, Array]
    effects: tuple[str, ...]
    hidden: tuple[Hidden, ...]
    force: float
    noise: float
    not_reckoned: tuple[str, ...]
    covariance: Array
    slopes: Array
    does: Array

    @property
    def sizes(self) -> Array:
        """Rms force of each effect, N, shape (E,)."""
        return np.array([one.newtons for one in self.hidden])

    @property
    def least(self) -> float:
        """Rms force below which lack of fit isn't worth an effect, N."""
        return max(MATERIAL_NOISE_SHARE * self.noise, MATERIAL_FORCE_SHARE * self.force)


def scene(
    file: LawFile,
    grid: Mapping[str, Array],
    noise_N: float,
    rate: float,
    scatter: float,
    progress: Progress = silent,
) -> Scene:
    """Give what tests on a grid would tell.

    Args:
        file: a law like the one that the clamp is expected to have; its base counts, and its sizes.
        grid: A (mm), f (Hz), T (K), shape (R,) each.
        noise_N: rms noise of the force.
        rate: samples per second.
        scatter: rms share by which stiffness and damping differ from run to run.
        progress: told what is being done.
    """
    bare, motion = bare_law(file), sinusoids(grid["A"], grid["f"], grid["T"], SAMPLES_PER_CYCLE, file.about)
    force, slopes = _foretold(bare, motion)
    between_runs = RunScatter(stiffness=scatter, damping=scatter).covariance(
        Directions(*elastic_and_damping(force), np.zeros_like(force))
    )
    covariance = sensor_noise(noise_N, rate, motion, force.shape[1]) + between_runs
    empty = Scene(
        grid, (), (), _rms(force), noise_N, (), covariance, slopes,
        np.zeros((0, *force.shape)),
    )  # fmt: skip
    few = _few(grid)
    coarse = sinusoids(grid["A"][few], grid["f"][few], grid["T"][few], SAMPLES_PER_CYCLE // 2, file.about)
    trial = Trial(bare, coarse, covariance[few], HARMONICS_FORETOLD)
    found, does, left = dict[str, Hidden](), list[Array](), list[str]()
    for effect in listed():
        if effect.part == "base":
            continue
        if effect.is_of_time and not file.data.is_timed:
            left.append(effect.id)
            continue
        progress(effect.id)
        try:
            typical = _beyond(typical_law(file, effect.id, grid), motion, force)
        except UserError:
            left.append(effect.id)
            continue
        if float(np.abs(typical).max()) <= NO_FORCE_SHARE * float(np.abs(force).max()):  # it does nothing there
            left.append(effect.id)
            continue
        found[effect.id], added = _hidden(file, effect.id, typical, empty, trial, motion, force)
        does.append(added)
    return Scene(
        grid, tuple(found), tuple(found.values()), empty.force, noise_N, tuple(left), covariance, slopes,
        np.stack(does),
    )  # fmt: skip


def _hidden(
    file: LawFile, effect: str, typical: Array, view: Scene, trial: Trial, motion: Motion, force: Array
) -> tuple[Hidden, Array]:
    """Give an effect in the smallest size that counts, and the harmonics that it adds, N, shape (R, m).

    Args:
        file: the law without it.
        effect: its name.
        typical: harmonics that it adds in its typical size.
        view: the scene without effects.
        trial: tests on which the catalogue is tried.
        motion: of the grid.
        force: harmonics of the bare law, N, shape (R, m).
    """
    size = _rms(typical)
    once = lack_of(view.grid, np.ones(len(force)), view.covariance, view.slopes, typical[None])
    follows = float(np.sqrt(once.excess[0]))
    newtons = size * view.least / follows if follows > 0 else np.inf
    untried = Hidden(size, np.inf, "", ()), typical
    for doubling in range(DOUBLINGS + 1):
        if newtons > view.force:
            return untried
        try:
            law = law_of_size(file, effect, newtons, view.grid)
        except ValueError:  # no size of it has that force
            return untried
        tried = trial.of(effect, law)
        if tried.found:
            added = _beyond(law, motion, force)
            own = len(law.equations.names)
            rivals = tuple(_rival(name, fit, own, force + added, motion, view) for name, fit in tried.others)
            return Hidden(newtons, newtons if doubling else 0.0, tried.nearest, rivals), added
        newtons *= 2
    return untried


def _rival(name: str, fit: Fit, own: int, seen: Array, motion: Motion, view: Scene) -> RivalEffect:
    """Give what another effect, refitted, leaves over of harmonics that are seen, N, shape (R, m)."""
    force, slopes = _foretold(fit.law, motion)
    slopes = slopes[fit.places]
    columns = np.concatenate([slopes / norms_of(slopes)[:, None, None], (seen - force)[None]])
    white = np.linalg.solve(np.linalg.cholesky(view.covariance), np.moveaxis(columns, 0, -1))
    added = {one.name for one in fit.law.structure.effect(name).parameters}
    outside = [place for place, each in enumerate(fit.fitted) if each in added & fit.at_bound.keys()]
    return RivalEffect(
        name, np.einsum("rmk,rml->rkl", white, white), np.array(outside, dtype=np.intp),
        len(fit.law.equations.names) - own,
    )  # fmt: skip


def _few(grid: Mapping[str, Array]) -> IntArray:
    """Give the conditions of a grid at some of its levels."""
    chosen = np.ones(len(grid["A"]), dtype=bool)
    for name, count in LEVELS_TRIED.items():
        levels = np.unique(grid[name])
        some = levels[np.unique(np.round(np.linspace(0, len(levels) - 1, count)).astype(int))]
        chosen &= np.isin(grid[name], some)
    return np.flatnonzero(chosen)


def _foretold(law: Law, motion: Motion) -> tuple[Array, Array]:
    """Give the harmonics of a law's force, N, (R, m), and their derivatives by its parameters, (P, R, m)."""
    equations = law.equations
    force = force_of_equations(equations, law.vector(equations), (law.v_r, law.y_r), motion, derivatives=True)
    slopes = harmonic_slopes(force, HARMONICS_FORETOLD, np.arange(len(equations.names)))
    return real_harmonics_of(force.force, HARMONICS_FORETOLD), np.nan_to_num(slopes)


def _beyond(law: Law, motion: Motion, force: Array) -> Array:
    """Give the harmonics that a law has beyond others, N, shape (R, m)."""
    return real_harmonics_of(force_of_law(law, motion).force, HARMONICS_FORETOLD) - force


def _rms(harmonics: Array) -> float:
    return float(np.sqrt(np.mean(mean_squares_of(harmonics))))
