"""What a found term must pass before it is proposed."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_fmu.build import creates_energy, passivity
from pipeclamp_fmu.contents.clamp_of_law import clamp_model
from pipeclamp_identification.diagnosis.left_out import WithoutGroups
from pipeclamp_identification.diagnosis.named import WITH
from pipeclamp_identification.diagnosis.noise import WhitenedObservations, noise_model
from pipeclamp_identification.diagnosis.problem import Judged, Problem
from pipeclamp_identification.diagnosis.run_scatter import of_a_shift
from pipeclamp_identification.diagnosis.thresholds import BEYOND_DOUBT_DRAWS_SHARE, RIVAL_LIKELIHOOD, SAME_ERROR_SHARE
from pipeclamp_identification.discovery.conditions import FOLLOWED, LEVEL, STEEPNESS, followed_signal, shown
from pipeclamp_identification.discovery.grammar import Term
from pipeclamp_identification.discovery.telling import BEYOND_A, BEYOND_F
from pipeclamp_identification.fitting.observations import loop_observations
from pipeclamp_identification.fitting.resampling import draws, share_of_gains
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_identification.signals.levels import SAME_SHARE, number_levels
from pipeclamp_models.base.arrays import Array, BoolArray, IntArray
from pipeclamp_models.law.file import LawFile
from pipeclamp_models.law.law import Law
from pipeclamp_models.realise.force import force_of_equations, force_of_law

COMES_BACK_SHARE = 0.8
"""A term that does as well as the best in fewer draws of the conditions may be an accident of some."""
FEWEST_LEVELS_LEFT = 2
"""Of A and of f: levels that stay where the highest are left out to see how a term foretells beyond them."""


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
    by_it = f"{explained:.0f} squares" if explained > 0 else "nothing"
    words = f"it explains {by_it} of what is left; the best of all terms, by chance, {by_chance:.0f} squares"
    return Guard("more than chance", bool(explained > by_chance), words)


def comes_back(judged: Sequence[Judged], alike: BoolArray, groups: IntArray) -> Guard:
    """Ask whether a term, or one that acts alike, does as well as the best again where conditions are drawn again.

    What counts as well is what counted when the term was chosen (`RIVAL_LIKELIHOOD`).

    Args:
        judged: the law with each term that was refitted.
        alike: which of them are the term, or act as it does.
        groups: of each run, shape (R,).
    """
    share = float(np.mean(np.any(as_well_in_draws(judged, groups)[:, alike], axis=1)))
    words = f"a term that acts alike does as well as the best in {share:.0%} of draws of the conditions"
    return Guard("comes back", share >= COMES_BACK_SHARE, words)


def as_well_in_draws(judged: Sequence[Judged], groups: IntArray) -> BoolArray:
    """Tell which laws are as likely as the likeliest in each draw of the conditions, shape (draws, laws).

    Args:
        judged: the laws.
        groups: of each run, shape (R,).
    """
    by_run = np.array([np.sum(each.fitted.residual**2, axis=1) for each in judged])
    of_the_law = np.array([each.akaike for each in judged]) - by_run.sum(axis=1)
    by_group = np.array([np.bincount(groups, weights=each) for each in by_run])
    criterion = draws(by_group.shape[1]) @ by_group.T.astype(np.float64) + of_the_law
    return np.asarray(criterion <= criterion.min(axis=1, keepdims=True) + RIVAL_LIKELIHOOD)


def beyond_the_tests(law: Judged, found: Judged, problem: Problem) -> Guard:
    """Ask whether the law with a term foretells the largest amplitudes and the highest frequencies from the others.

    What lies above the largest amplitude over `BEYOND_A`, and above the highest frequency over `BEYOND_F`, is left out:
    the law is stretched as far as the term may be used beyond the tests, as far as their levels allow. What the tests
    that stay don't determine of either law speaks against neither: the shorter one, too, would know less without them.

    Args:
        law: without the term.
        found: with it, both fitted to the same tests.
        problem: the tests.
    """
    worse, asked, few = [], [], []
    for name, values, beyond in (
        ("amplitudes", problem.loops.amplitude_mm, BEYOND_A),
        ("frequencies", problem.loops.frequency_Hz, BEYOND_F),
    ):
        edge = highest(values, beyond)
        if not edge.any():
            continue
        asked.append(name)
        without, with_it = (_unlikelihood(each, problem, edge) for each in (law, found))
        if foretold_worse(without, with_it):
            worse.append(f"{name} (-2 log likelihood {without:.0f} -> {with_it:.0f})")
            if len(number_levels(values[~edge], relative=SAME_SHARE)) == FEWEST_LEVELS_LEFT:
                few.append(name)
    words = f"left out, the highest {' and '.join(worse or asked)} are foretold {'worse' if worse else 'no worse'}"
    if few:
        words += f" from the {FEWEST_LEVELS_LEFT} levels that stay; tests at more {' and '.join(few)} would tell more"
    return Guard("does no harm beyond", not worse, words if asked else "too few levels to leave the highest out")


def highest(values: Array, beyond: float) -> BoolArray:
    """Tell which runs lie above the highest level over a factor; two levels stay below, else none is told of.

    Args:
        values: amplitude or frequency of each run, shape (R,).
        beyond: the factor.
    """
    levels = number_levels(values, relative=SAME_SHARE)
    edge = np.zeros(len(values), dtype=np.bool_)
    most = float(np.max(values)) / beyond * (1 + SAME_SHARE)
    for level in levels[FEWEST_LEVELS_LEFT:]:
        edge[level.rows] = bool(level is levels[-1] or np.min(values[level.rows]) > most)
    return edge


def worse_between_levels_words(law: Judged, found: Judged, problem: Problem) -> str:
    """Say that temperatures, or levels of further columns, between others are foretold worse with a term; else nothing.

    What follows them may pass through all levels tested, and between them through what nothing shows. That is no
    reason to refuse it: where a step lies between two levels the others can't tell, and the step may be there.

    Args:
        law: without the term.
        found: with it, both fitted to the same tests.
        problem: the tests.
    """
    worse = []
    for name, groups in levels_between(problem.loops).items():
        without, with_it = (_squares_left_out(each, problem, groups) for each in (law, found))
        if foretold_worse(without, with_it):
            worse.append(name)
    if not worse:
        return ""
    names = " and ".join(worse)
    return f"left out, a {names} between others is foretold worse with it than without: test at more levels of {names}"


def changes_untested(term: Term, law: Law, problem: Problem) -> str:
    """Say that a term changes between two neighbouring levels tested, and at neither of them; else nothing.

    Its place, and how gradual it is, are then what was meant beforehand, and no error bar says so.

    Args:
        term: the term.
        law: the law with it, fitted.
        problem: the tests.
    """
    own = {one.name: one for one in term.effect.parameters}
    if not {LEVEL, STEEPNESS} <= own.keys():
        return ""
    signal, level = str(own[STEEPNESS].follows[0]), law.values[LEVEL]
    values = problem.observations.motion.slow[signal][:, 0]
    columns = {name: float(np.max(np.abs(values))) for name in term.declaration.conditions}  # one, or none
    name = signal if signal in FOLLOWED else next(iter(columns))
    followed = followed_signal(name, columns)
    tested = [float(np.mean(values[one.rows])) for one in number_levels(values, relative=SAME_SHARE)]
    below, above = [one for one in tested if one <= level], [one for one in tested if one > level]
    if not below or not above or min(level - below[-1], above[0] - level) < followed.width(law.values[STEEPNESS]):
        return ""
    return (
        f"between {shown(name, below[-1])} and {shown(name, above[0])} no test shows where it changes with the "
        f"{followed.name}: midway, and as gradually as the tests allow, is meant; test between them"
    )


def foretold_worse(without: float, with_it: float) -> bool:
    """Tell whether squares that are left out tell against a term: less likely, and by more than a fit's own change.

    Where the law is far from what is left out, with the term or without it, tens of thousands of squares differ by some
    however little the term does there.
    """
    return with_it > without + RIVAL_LIKELIHOOD and with_it > (1 + SAME_ERROR_SHARE) ** 2 * without


def levels_between(loops: Loops) -> dict[str, IntArray]:
    """Give the level of each run, of temperature and of further columns, shape (R,); -1 at the lowest and highest."""
    found = {}
    for name, values in {"temperature": loops.temperature_K, **loops.conditions}.items():
        levels = number_levels(values, relative=SAME_SHARE)[1:-1]
        groups = np.full(len(values), -1, dtype=np.intp)
        for number, level in enumerate(levels):
            groups[level.rows] = number
        if levels:
            found[name] = groups
    return found


def _squares_left_out(judged: Judged, problem: Problem, groups: IntArray) -> float:
    """Give the squares of groups of runs, in units of their noise, where a law isn't fitted to them; of -1 none."""
    return float(_without_groups(judged, problem).score(groups).squares.sum())


def _unlikelihood(judged: Judged, problem: Problem, own: BoolArray) -> float:
    """Give minus twice the log likelihood of runs that a law isn't fitted to."""
    return _without_groups(judged, problem).unlikelihood(own)


def _without_groups(judged: Judged, problem: Problem) -> WithoutGroups:
    """Prepare a judged law for leaving groups out."""
    result, law = judged.result, judged.result.law
    force = force_of_equations(
        result.equations, law.vector(result.equations), (law.v_r, law.y_r), problem.observations.motion,
        derivatives=True,
    )  # fmt: skip
    return WithoutGroups(replace(result, law_force=force), problem.observations, problem.coarse, judged.fitted)


def confirmed(law: Law, found: Law, unseen: Loops, problem: Problem) -> Guard:
    """Ask whether conditions that the search never saw are foretold better with the term.

    Runs are drawn, each a condition of its own: the groups of A and f that are kept back are often two, of which one
    that gains next to nothing would decide a quarter of the draws. Their errors are weighed as the fits weigh them, for
    the scatter of stiffness from run to run is large where the force is.

    What follows a condition gains in few of the runs, and draws without these say nothing of it. Where all runs
    together tell for the term by `RIVAL_LIKELIHOOD`, draws count against it that tell as clearly against it.

    Args:
        law: without the term, fitted to the others.
        found: with it, likewise.
        unseen: the tests that were kept back.
        problem: the others, with what scatters from run to run.
    """
    before, after = (squared_errors(one, unseen) for one in (law, found))
    force = float(np.sum(unseen.samples * unseen.force_rms_N**2))
    shares = [np.sqrt(float(squares.sum()) / force) for squares in (before, after)]
    gain = np.subtract(*(weighed_errors(one, unseen, problem) for one in (law, found)))
    better = share_of_gains(gain, -RIVAL_LIKELIHOOD if gain.sum() > RIVAL_LIKELIHOOD else 0.0)
    lower = bool(after.sum() < before.sum())
    falls = lower and bool(gain.sum() > 0)
    passed = falls and better > BEYOND_DOUBT_DRAWS_SHARE
    words = (
        f"on conditions that the search never saw the error, scatter left aside, goes from {shares[0]:.2%} to "
        f"{shares[1]:.2%}"
    )
    if falls and not passed:
        words += (
            f", but it falls in {better:.0%} of draws of them only, not in more than {BEYOND_DOUBT_DRAWS_SHARE:.1%}"
        )
    elif lower and not falls:
        words += ", but not where each run counts in units of what scatters there"
    return Guard("confirmed", passed, words)


def surely_worse(plain: Law, refined: Law, unseen: Loops, problem: Problem) -> bool:
    """Tell whether conditions that the search never saw are foretold worse with a refined term, beyond doubt.

    They needn't be foretold better: the term is confirmed by them already, and few of them may tell one form of it from
    another. Arguments as for `confirmed`.
    """
    loss = np.subtract(*(weighed_errors(one, unseen, problem) for one in (refined, plain)))
    return share_of_gains(loss) > BEYOND_DOUBT_DRAWS_SHARE


def squared_errors(law: Law, loops: Loops) -> Array:
    """Give the squared error of each run over its samples, scatter left aside, N2."""
    observations = loop_observations(loops)
    return np.asarray(observations.mean_squares(force_of_law(law, observations.motion)) * loops.samples)


def weighed_errors(law: Law, loops: Loops, problem: Problem) -> Array:
    """Give the squared error of each run in units of its noise, of scatter from run to run, and of what laws miss."""
    plain = loop_observations(loops)
    shifted = of_a_shift(law, plain.motion, plain.transformed)
    noise = replace(noise_model(loops, shifted), scatter=problem.noise.scatter)
    observations = WhitenedObservations(plain, noise.whitener(problem.discrepancy))
    residual = observations.against_noise(force_of_law(law, observations.motion))
    return np.asarray(np.sum(residual**2, axis=1))


def surely_better(found: Judged, other: Judged, problem: Problem) -> bool:
    """Tell whether a law foretells left-out groups better than another, beyond doubt."""
    gain = np.bincount(problem.groups, weights=other.score.squares - found.score.squares).astype(np.float64)
    return bool(gain.sum() > 0 and share_of_gains(gain) > BEYOND_DOUBT_DRAWS_SHARE)


def not_in_the_catalogue(
    found: Judged,
    listed: Sequence[Judged],
    problem: Problem,
    *,
    named: Collection[str] = (),
    own: bool = False,
    longer: Sequence[Judged] = (),
    by_chance: float = 0.0,
) -> Guard:
    """Ask whether a term does better than each effect of the catalogue, beyond doubt: effects win ties.

    But for those that no diagnosis names, with which a user would be left with nothing: where physics speaks against
    them, or the fit to all tests tells for the term, as it tells between terms that foretell as well, and by more than
    the best of so many would gain by chance. And for those that need what the term stands in the place of beside them
    and that the diagnosis doesn't name: of laws that do as well the shorter one stands.

    Args:
        found: the law with the term.
        listed: the law with effects, instead.
        problem: the tests.
        named: effects that the law's diagnosis names, which alone are worth adding.
        own: whether the first of `listed` is the law itself, with the effects in whose place the term stands.
        longer: that law with effects beside all that it has.
        by_chance: squares that the best of all terms explains by chance.
    """
    for effect in longer:
        tie = set(effect.effects) <= set(named) and not surely_better(found, effect, problem)
        if tie or surely_better(effect, found, problem):
            words = f"{WITH.join(effect.effects)} of the catalogue, beside all effects of the law, does "
            words += "as well; `add` it instead" if tie else "better"
            return Guard("beyond the catalogue", False, words)
    nameless = ""
    for place, effect in enumerate(listed):
        if surely_better(found, effect, problem):
            continue
        words = f"{WITH.join(effect.effects)} of the catalogue does as well"
        if own and place == 0:
            words = f"the law does as well with {' and '.join(effect.effects)}, which it has"
        elif set(effect.effects) <= set(named):
            words += "; `add` it instead"
        else:
            tie = not surely_better(effect, found, problem)
            likelier = tie and found.akaike + max(RIVAL_LIKELIHOOD, by_chance) <= effect.akaike
            if effect.objections:
                words += f", though {effect.objections[0]}, for which no diagnosis names it"
            elif likelier:
                words += " on left-out conditions, but all together tell for the term, and no diagnosis names it"
            else:
                words += ", which the diagnosis doesn't name either: these tests don't tell"
            if tie and (effect.objections or likelier):
                nameless = nameless or f": {words}"
                continue
        return Guard("beyond the catalogue", False, words)
    return Guard("beyond the catalogue", True, f"no effect that may be named does as well{nameless}")


def passive(file: LawFile, before: LawFile) -> Guard:
    """Ask whether the law with the term can create energy, within its range and a little beyond, as `build-fmu` does.

    Args:
        file: the law with the term.
        before: the law without it; what it does already, the term isn't blamed for.
    """
    wide = _widened(file)
    if (words := creates_energy(wide)) and not creates_energy(_widened(before)):
        return Guard("passive", False, words)
    if words:
        return Guard("passive", True, "the law could create energy without it, too: `build-fmu` takes neither")
    proof = passivity(clamp_model(wide), wide).words()
    return Guard("passive", True, f"up to {BEYOND_A:g} A and {BEYOND_F:g} f it {proof}")


def _widened(file: LawFile) -> LawFile:
    """Give a law whose range reaches as far beyond the tests as a term may be used."""
    ends = {name: file.range[name].maximum * beyond for name, beyond in (("A", BEYOND_A), ("f", BEYOND_F))}
    wider = {name: file.range[name].model_copy(update={"maximum": end}) for name, end in ends.items()}
    return file.model_copy(update={"range": {**file.range, **wider}})
