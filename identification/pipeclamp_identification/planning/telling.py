"""What tests on a grid would tell of each effect of the catalogue: at which size it is named, and what hides it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq
from scipy.special import ndtr, ndtri

from pipeclamp_identification.campaign.rig import TestPlan, truth_of
from pipeclamp_identification.diagnosis.outlook import HARMONICS, run_scatter, sensor_noise
from pipeclamp_identification.diagnosis.thresholds import (
    MATERIAL_FORCE_SHARE,
    MATERIAL_NOISE_SHARE,
    REAL_LACK_CHANCE,
    RIVAL_LIKELIHOOD,
)
from pipeclamp_identification.fitting.observations import harmonics_of
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.progress import Progress
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.catalogue import listed
from pipeclamp_models.law.file import LawFile, law_of
from pipeclamp_models.law.law import Law, Structure
from pipeclamp_models.realise.force import force_of_equations, force_of_law, known_jacobian
from pipeclamp_models.realise.motion import Motion, sinusoids

NAMED = 0.9
"""Of the effects of a size, that a plan is to name."""
SAME = 1e-9
"""Share of what an effect does that another one leaves, below which the two are one: rounding."""
FOLLOWED = frozenset({"A", "f", "T"})
"""Conditions that loop tests of a plan vary."""
LARGEST = 1e3
"""Typical sizes beyond which no effect is looked for."""


@dataclass(frozen=True, eq=False)
class Scene:
    """What is there before any test: the rig's noise, the clamp that is expected, the effects that it may have.

    Attributes:
        grid: conditions that may be tested, A (mm), f (Hz), T (K), shape (R,) each.
        effects: E names.
        sizes: rms force of each effect in its typical size over the grid, N, shape (E,).
        force: rms force of the law over the grid, N.
        peak: largest force of the law at each condition, N, shape (R,).
        noise: rms of the force sensor, N.
        not_reckoned: effects that follow what no plan of loop tests varies, or change what the base law hasn't got.
        law: which columns of the Gram matrices are the law's parameters.
        parameters: which are those of each effect.
        whitened: Gram matrices of one run at each condition, shape (R, K, K): over noise and scatter; the last E rows
            and columns are what the effects do.
        plain: the same in N2, mean squares of a run.
    """

    grid: Mapping[str, Array]
    effects: tuple[str, ...]
    sizes: Array
    force: float
    peak: Array
    noise: float
    not_reckoned: tuple[str, ...]
    law: npt.NDArray[np.intp]
    parameters: tuple[npt.NDArray[np.intp], ...]
    whitened: Array
    plain: Array


def bare_law(file: LawFile) -> Law:
    """Give the base law that a file's law stands on, without any effect."""
    law = law_of(file)
    structure = Structure(law.structure.base)
    values = {name: law.values[name] for name in structure.equations.names}
    return Law(structure, values, law.v_r, law.y_r)


def scene(
    file: LawFile,
    grid: Mapping[str, Array],
    noise_N: float,
    rate: float,
    scatter: float,
    progress: Progress | None = None,
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
    tell = progress or (lambda what: None)
    bare = bare_law(file)
    names = bare.structure.equations.names
    motion = sinusoids(grid["A"], grid["f"], grid["T"])
    force, slopes = _foretold(bare, motion)
    columns, parameters, does = [slopes], list[npt.NDArray[np.intp]](), list[Array]()
    effects, left = list[str](), list[str]()
    for effect in listed():
        if effect.part == "base":
            continue
        tell(effect.id)
        try:
            law = _typical(file, effect.id, grid)
        except UserError:
            left.append(effect.id)
            continue
        with_it, by_parameters = _foretold(law, motion)
        if float(np.abs(with_it - force).max()) <= SAME * float(np.abs(force).max()):  # it does nothing there
            left.append(effect.id)
            continue
        own = [place for place, name in enumerate(law.equations.names) if name not in names]
        begun = sum(len(one) for one in columns)
        columns.append(by_parameters[own])
        parameters.append(np.arange(begun, begun + len(own)))
        does.append(with_it - force)
        effects.append(effect.id)
    stacked = np.concatenate([*columns, np.stack(does)])
    scales = np.sqrt(np.maximum(np.mean(stacked**2, axis=(1, 2), keepdims=True), 1e-300))
    scales[-len(does) :] = 1.0
    stacked = stacked / scales
    weights = _mean_square_weights(force.shape[1])
    plain = stacked * np.sqrt(weights)
    covariance = sensor_noise(noise_N, rate, motion, force.shape[1]) + run_scatter(force, scatter, scatter)
    roots = np.linalg.cholesky(covariance)
    white = np.linalg.solve(roots, np.moveaxis(stacked, 0, -1))
    return Scene(
        grid, tuple(effects), np.sqrt(np.mean(np.sum(np.stack(does) ** 2 * weights, axis=2), axis=1)),
        float(np.sqrt(np.mean(np.sum(force**2 * weights, axis=1)))),
        2 * np.sqrt(np.sum(force**2 * weights, axis=1)), noise_N, tuple(left), np.arange(len(names)),
        tuple(parameters), np.einsum("rmk,rml->rkl", white, white), np.einsum("krm,lrm->rkl", plain, plain),
    )  # fmt: skip


def _typical(file: LawFile, effect: str, grid: Mapping[str, Array]) -> Law:
    """Give a file's base law with an effect in its typical size for the loops of a grid.

    Raises:
        UserError: it follows what loop tests don't vary, or scales what the base hasn't got.
    """
    bare = bare_law(file)
    of_base = {name: file.coefficients[name] for name in bare.structure.equations.names}
    bare_file = file.model_copy(update={"effects": (), "declared": (), "coefficients": of_base, "covariance": None})
    sized = TestPlan(
        amplitudes=tuple(np.unique(grid["A"]).tolist()),
        frequencies=tuple(np.unique(grid["f"]).tolist()),
        temperatures=tuple((np.unique(grid["T"]) - CELSIUS).tolist()),
        rate=max(TestPlan().rate, 20 * float(grid["f"].max())),
    )
    law = truth_of(bare_file, (effect,), {}, sized).law
    if law.equations.slow_signals - FOLLOWED:
        raise UserError(f"{effect} follows what no loop test varies")
    return law


def true_law(file: LawFile, scene: Scene, effect: str, newtons: float) -> Law:
    """Give a file's base law with an effect of so many N rms over a scene's loops.

    Its parameters with a neutral value, and its forces and stiffnesses, go the same share of the way from there, or
    from nought, to their typical size.

    Raises:
        ValueError: no size of it has that force.
    """
    law, bare = _typical(file, effect, scene.grid), bare_law(file)
    motion = sinusoids(scene.grid["A"], scene.grid["f"], scene.grid["T"])
    without = _foretold(bare, motion)[0]
    neutral = {
        one.name: float(one.neutral or 0.0)
        for one in law.equations.composed.parameters
        if one.name not in bare.values and (one.neutral is not None or one.unit.startswith("N"))
    }

    def at(share: float) -> Law:
        moved = {name: value + share * (law.values[name] - value) for name, value in neutral.items()}
        return replace(law, values={**law.values, **moved})

    def short(logarithm: float) -> float:
        beyond = harmonics_of(force_of_law(at(float(np.exp(logarithm))), motion).force, HARMONICS) - without
        square = float(np.mean(np.sum(beyond**2 * _mean_square_weights(without.shape[1]), axis=1)))
        return 0.5 * float(np.log(square / newtons**2))

    return at(float(np.exp(brentq(short, np.log(1e-5), np.log(20.0), xtol=1e-3))))


def _foretold(law: Law, motion: Motion) -> tuple[Array, Array]:
    """Give the harmonics of a law's force, N, (R, m), and their derivatives by its parameters, (P, R, m)."""
    equations = law.equations
    force = force_of_equations(equations, law.vector(equations), (law.v_r, law.y_r), motion, derivatives=True)
    every = np.arange(len(equations.names))
    slopes = known_jacobian(force).through(lambda courses: harmonics_of(courses, HARMONICS), every)
    return harmonics_of(force.force, HARMONICS), np.nan_to_num(slopes)


def _mean_square_weights(count: int) -> Array:
    """Give the weights by which squares of harmonics add up to a mean square over the cycle, shape (m,)."""
    return np.array([1.0, *[0.5] * (count - 1)])


@dataclass(frozen=True, eq=False)
class Power:
    """What a plan names.

    Attributes:
        scene: the effects.
        apart: standard deviations by which each effect, in its typical size, is seen, shape (E,).
        from_nearest: standard deviations by which it differs from that other effect which takes its place best.
        nearest: which one that is, shape (E,).
        unimitated: rms force of it that the base law can't imitate, N, shape (E,).
    """

    scene: Scene
    apart: Array
    from_nearest: Array
    nearest: npt.NDArray[np.intp]
    unimitated: Array

    def chance(self, newtons: float) -> Array:
        """Give the chance that each effect is named, whose rms force over the grid is so many N, shape (E,)."""
        return self._chance(newtons / self.scene.sizes)

    def _chance(self, size: Array) -> Array:
        seen = ndtr(size * self.apart - ndtri(1 - REAL_LACK_CHANCE))
        away = np.maximum(size * self.from_nearest, 1e-300)
        # twice the difference of two log likelihoods is normal with mean away^2 and deviation 2 away
        told = ndtr((away**2 - RIVAL_LIKELIHOOD) / (2 * away))
        least = max(MATERIAL_NOISE_SHARE * self.scene.noise, MATERIAL_FORCE_SHARE * self.scene.force)
        return np.asarray(np.where(size * self.unimitated >= least, seen * told, 0.0))

    @cached_property
    def sizes(self) -> Array:
        """Give the rms force, N, from which on each effect is named with a chance of `NAMED`; inf: in no size."""
        found = np.full(len(self.scene.effects), np.inf)
        for place, typical in enumerate(self.scene.sizes):
            ends = 1e-6, LARGEST

            def short(logarithm: float, place: int = place) -> float:
                return float(self._chance(np.full(len(found), np.exp(logarithm)))[place]) - NAMED

            if short(np.log(ends[1])) > 0 > short(np.log(ends[0])):
                found[place] = typical * np.exp(brentq(short, np.log(ends[0]), np.log(ends[1]), xtol=1e-4))
        return found

    @cached_property
    def told(self) -> npt.NDArray[np.bool_]:
        """Tell which effects can be named at all: in a size that is no larger than the law's own force, shape (E,)."""
        return np.asarray(self.sizes <= self.scene.force)

    @cached_property
    def from_newtons(self) -> float:
        """Give the rms force, N, above which `NAMED` of the effects that can be told are named; inf: none can."""
        if not self.told.any():
            return np.inf

        def short(logarithm: float) -> float:
            return float(np.mean(self.chance(np.exp(logarithm))[self.told])) - NAMED

        low, high = np.log(1e-9 * self.scene.force), np.log(10 * self.scene.force)
        return float(np.exp(brentq(short, low, high, xtol=1e-4))) if short(high) > 0 else np.inf


def power(scene: Scene, runs: Array) -> Power:
    """Give what a plan names.

    Each effect is taken for true in turn. What the base law, or the base law with another effect, can make up for by a
    refit doesn't count.

    Args:
        scene: what tests would tell.
        runs: how many there are at each condition, shape (R,).
    """
    count, effects = len(scene.whitened[0]), len(scene.effects)
    does = np.arange(count - effects, count)
    gram, plain = (np.tensordot(runs, one, axes=1) for one in (scene.whitened, scene.plain))
    gram, plain = _without(gram, scene.law), _without(plain, scene.law)
    seen = np.diag(gram)[does]
    counts = np.array([len(own) for own in scene.parameters])
    away, nearest = np.full(effects, np.inf), np.zeros(effects, dtype=np.intp)
    for place, own in enumerate(scene.parameters):
        block = np.concatenate([own, does])
        inside = np.diag(_without(gram[np.ix_(block, block)], np.arange(len(own), dtype=np.intp)))[len(own) :].copy()
        inside[place] = np.inf
        # of two that do the same the one of fewer parameters is named
        inside[(inside <= SAME * seen) & (counts < len(own))] = np.inf
        nearest = np.where(inside < away, place, nearest)
        away = np.minimum(away, inside)
    away = np.where(away > SAME * seen, away, 0.0)
    unimitated = np.sqrt(np.maximum(np.diag(plain)[does], 0.0) / max(float(np.sum(runs)), 1.0))
    return Power(scene, np.sqrt(np.maximum(seen, 0.0)), np.sqrt(np.maximum(away, 0.0)), nearest, unimitated)


def _without(gram: Array, taken: npt.NDArray[np.intp]) -> Array:
    """Give the Gram matrix of what is left of its columns once some of them are fitted."""
    across = gram[:, taken]
    scale = np.sqrt(np.maximum(np.diag(gram)[taken], 1e-300))
    own = gram[np.ix_(taken, taken)] / np.outer(scale, scale)
    across = across / scale
    return np.asarray(gram - across @ np.linalg.pinv(own, rcond=1e-12, hermitian=True) @ across.T)
