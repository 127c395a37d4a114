"""What a found term must pass before it is proposed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pipeclamp_fmu.build import clamp_model, require_passive
from pipeclamp_identification.diagnosis.problem import Judged, Problem
from pipeclamp_identification.diagnosis.thresholds import BEYOND_DOUBT_DRAWS_SHARE
from pipeclamp_identification.discovery.search import Screened
from pipeclamp_identification.fitting.observations import loop_observations
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_identification.signals.levels import SAME_SHARE, number_levels
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.file import LawFile
from pipeclamp_models.law.law import Law
from pipeclamp_models.realise.force import force_of_law

DRAWS = 2000
SEED = 20_261_123
COMES_BACK_SHARE = 0.8
"""A term that explains most in fewer draws of the conditions may be an accident of some."""
EDGES = 2
"""Of A and of f: the highest level that is left out to see how a term foretells beyond what it was fitted to."""


@dataclass(frozen=True)
class Guard:
    """One test of a term.

    Attributes:
        name: what is asked.
        passed: whether it passed.
        words: with which figures.
    """

    name: str
    passed: bool
    words: str


def beyond_chance(explained: float, by_chance: float) -> Guard:
    """Ask whether a term explains more than the best of the whole grammar would by chance."""
    words = f"it explains {explained:.0f} squares of what is left; the best of all terms, by chance, {by_chance:.0f}"
    return Guard("more than chance", bool(explained > by_chance), words)


def comes_back(screened: Screened, place: int) -> Guard:
    """Ask whether a term that acts alike wins again where the conditions are drawn again."""
    share = screened.comes_back(place)
    words = f"a term that acts alike is the best in {share:.0%} of draws of the conditions"
    return Guard("comes back", share >= COMES_BACK_SHARE, words)


def at_the_edges(screened: Screened, place: int, loops: Loops) -> Guard:
    """Ask whether a term foretells the largest amplitudes, and the highest frequencies, from all the others."""
    worse = []
    for name, values in (("amplitudes", loops.amplitude_mm), ("frequencies", loops.frequency_Hz)):
        levels = number_levels(values, relative=SAME_SHARE)
        if len(levels) < EDGES + 1:
            continue
        edge = np.zeros(len(values), dtype=np.bool_)
        edge[levels[-1].rows] = True
        if _gain_on(screened, place, edge) < 0:
            worse.append(name)
    words = (
        f"left out, the highest {' and '.join(worse)} are foretold worse" if worse else "the edges are foretold better"
    )
    return Guard("does no harm beyond", not worse, words)


def _gain_on(screened: Screened, place: int, own: npt.NDArray[np.bool_]) -> float:
    products, squares = (sums[:, place] for sums in screened.by_run)
    strength = products[~own].sum() / max(squares[~own].sum(), 1e-9)
    return float(2 * strength * products[own].sum() - strength**2 * squares[own].sum())


def confirmed(law: Law, found: Law, unseen: Loops, groups: npt.NDArray[np.intp]) -> Guard:
    """Ask whether conditions that the search never saw are foretold better with the term.

    Args:
        law: without the term, fitted to the others.
        found: with it, likewise.
        unseen: the tests that were kept back.
        groups: of each of them.
    """
    before, after = (squared_errors(one, unseen) for one in (law, found))
    gain = np.bincount(groups, weights=before - after).astype(np.float64)
    gain = gain[np.bincount(groups) > 0]
    force = float(np.sum(unseen.samples * unseen.force_rms_N**2))
    shares = [np.sqrt(float(squares.sum()) / force) for squares in (before, after)]
    words = f"on conditions that the search never saw the error goes from {shares[0]:.2%} to {shares[1]:.2%}"
    return Guard("confirmed", bool(gain.sum() > 0 and _wins(gain) > BEYOND_DOUBT_DRAWS_SHARE), words)


def squared_errors(law: Law, loops: Loops) -> Array:
    """Give the squared error of each run over its samples, scatter left aside, N2."""
    observations = loop_observations(loops)
    return np.asarray(observations.mean_squares(force_of_law(law, observations.motion)) * loops.samples)


def _wins(gain: Array) -> float:
    """Give the share of draws of groups in which there is a gain; of one or two groups, of all that there are."""
    if len(gain) < 3:
        return float(np.all(gain > 0))
    random = np.random.default_rng(SEED)
    drawn = random.multinomial(len(gain), np.full(len(gain), 1 / len(gain)), DRAWS)
    return float(np.mean(drawn @ gain > 0))


def not_in_the_catalogue(found: Judged, listed: Sequence[Judged], problem: Problem) -> Guard:
    """Ask whether a term does better than each effect of the catalogue, beyond doubt: effects win ties."""
    for effect in listed:
        gained = effect.score.squares - found.score.squares
        gain = np.bincount(problem.groups, weights=gained).astype(np.float64)
        if not (gain.sum() > 0 and _wins(gain) > BEYOND_DOUBT_DRAWS_SHARE):
            words = f"{effect.effects[0]} of the catalogue does as well; `add` it instead"
            return Guard("beyond the catalogue", False, words)
    return Guard("beyond the catalogue", True, "no effect of the catalogue does as well")


def passive(file: LawFile, before: LawFile) -> Guard:
    """Ask whether the law with the term can create energy on closed cycles, as `build-fmu` does.

    Args:
        file: the law with the term.
        before: the law without it; what it does already, the term isn't blamed for.
    """
    if (words := _creates_energy(file)) and not _creates_energy(before):
        return Guard("passive", False, words)
    return Guard("passive", True, "no closed cycle creates more energy than without it")


def _creates_energy(file: LawFile) -> str:
    """Say on which cycle a law creates energy; empty where none does."""
    try:
        require_passive(clamp_model(file), file)
    except UserError as error:
        return str(error)
    return ""
