"""Laws with one effect of the catalogue hidden in them, in a size that is asked for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from pipeclamp_identification.campaign.rig.plan import TestPlan
from pipeclamp_identification.campaign.rig.truth import truth_of
from pipeclamp_identification.diagnosis.further_test.outlook import HARMONICS_FORETOLD
from pipeclamp_identification.fitting.observations import FEWEST_POINTS_PER_CYCLE
from pipeclamp_identification.signals.real_harmonics import mean_squares_of, real_harmonics_of
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.units import CELSIUS, grows_with_force
from pipeclamp_models.law.file import LawFile, law_of
from pipeclamp_models.law.law import Law, Structure
from pipeclamp_models.realise.force import force_of_law
from pipeclamp_models.realise.motion import sinusoids

LOOP_TEST_CONDITIONS = frozenset({"A", "f", "T"})
"""Conditions that loop tests of a plan vary."""
SIZES_SOUGHT = 1e-5, 20.0
"""Of its typical size, between which an effect is looked for."""


def bare_law(file: LawFile) -> Law:
    """Give the base law that a file's law stands on, without any effect."""
    law = law_of(file)
    structure = Structure(law.structure.base)
    values = {name: law.values[name] for name in structure.equations.names}
    return Law(structure, values, law.v_r, law.y_r)


def peak_forces(file: LawFile, grid: Mapping[str, Array]) -> Array:
    """Give about the largest force of a file's base law at each condition of a grid, N, shape (R,)."""
    motion = sinusoids(grid["A"], grid["f"], grid["T"], FEWEST_POINTS_PER_CYCLE, file.about)
    return 2 * np.sqrt(
        mean_squares_of(real_harmonics_of(force_of_law(bare_law(file), motion).force, HARMONICS_FORETOLD))
    )


def typical_law(file: LawFile, effect: str, grid: Mapping[str, Array]) -> Law:
    """Give a file's base law with an effect in its typical size for the loops of a grid.

    Args:
        file: the law.
        effect: its name.
        grid: A (mm), f (Hz), T (K), shape (R,) each.

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
        about=file.about,
    )
    law = truth_of(bare_file, (effect,), {}, sized).law
    if law.equations.slow_signals - LOOP_TEST_CONDITIONS:
        raise UserError(f"{effect} follows what no loop test varies")
    return law


def law_of_size(file: LawFile, effect: str, newtons: float, grid: Mapping[str, Array]) -> Law:
    """Give a file's base law with an effect of so many N rms over a grid's loops.

    Its forces and stiffnesses go the same share of the way from nought to their typical size, what else shapes it
    stays; where it has none of these, its parameters go so from where they do nothing.

    Args:
        file: the law.
        effect: its name.
        newtons: rms force.
        grid: A (mm), f (Hz), T (K), shape (R,) each.

    Raises:
        ValueError: no size of it has that force.
        UserError: as for `typical_law`.
    """
    law, bare = typical_law(file, effect, grid), bare_law(file)
    motion = sinusoids(grid["A"], grid["f"], grid["T"], FEWEST_POINTS_PER_CYCLE, file.about)
    without = real_harmonics_of(force_of_law(bare, motion).force, HARMONICS_FORETOLD)
    own = [one for one in law.equations.composed.parameters if one.name not in bare.values]
    forces = {one.name: float(one.neutral or 0.0) for one in own if grows_with_force(one.unit)}
    neutral = forces or {one.name: float(one.neutral) for one in own if one.neutral is not None}

    def at(share: float) -> Law:
        moved = {name: value + share * (law.values[name] - value) for name, value in neutral.items()}
        return replace(law, values={**law.values, **moved})

    def short(logarithm: float) -> float:
        beyond = (
            real_harmonics_of(force_of_law(at(float(np.exp(logarithm))), motion).force, HARMONICS_FORETOLD) - without
        )
        with np.errstate(divide="ignore"):  # a stop that is never reached gives no force: short of any
            return 0.5 * float(np.log(np.mean(mean_squares_of(beyond)) / newtons**2))

    return at(float(np.exp(brentq(short, *np.log(SIZES_SOUGHT), xtol=1e-3))))
