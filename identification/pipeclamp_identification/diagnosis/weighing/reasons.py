"""Why a verdict is what it is, in words, where no effect of the catalogue is the cause."""

from __future__ import annotations

from pipeclamp_identification.diagnosis.evidence import LackOfFit
from pipeclamp_identification.diagnosis.foretold import (
    ErrorBeyondScatter,
    explained_share,
    held_against,
    takes_part,
    worse_between_levels,
)
from pipeclamp_identification.diagnosis.named import joined_by_and
from pipeclamp_identification.diagnosis.problem import Judged, Problem
from pipeclamp_identification.diagnosis.thresholds import (
    HALF_TAKEN_SHARE,
    MATERIAL_NOISE_SHARE,
    MATERIAL_PART_SHARE,
    REAL_LACK_CHANCE,
)
from pipeclamp_identification.diagnosis.weighing.between_levels import LeftOutLevel, rests_on
from pipeclamp_models.base.digits import newtons

SHOWN_SCATTER = 5e-5
"""Scatter from run to run that is less is shown as none."""
NEXT_TO_NOTHING = 0.005
"""A share that is less would be shown as 0 %."""


def scatter_words(lack: LackOfFit, problem: Problem) -> str:
    """Say how much follows the conditions, and how much scatters from run to run."""
    scatter = _scatter_words(problem)
    if lack.share < MATERIAL_NOISE_SHARE or lack.p_value <= REAL_LACK_CHANCE:
        between = f", and {scatter} from run to run" if scatter else ""
        share = f"{lack.share:.1%} of the force noise"
        return f"what follows the conditions is {newtons(lack.rms)}, {share}; the rest is noise{between}"
    makes = f"noise and scatter of {scatter} from run to run make" if scatter else "noise makes"
    share = f"{lack.share:.2f} times the force noise"
    return f"what seems to follow the conditions is {newtons(lack.rms)}, {share}; {makes} as much by chance"


def _scatter_words(problem: Problem) -> str:
    """Say what scatters from run to run, and by how much; empty where next to nothing does."""
    noise = problem.noise
    named = (noise.scatter.stiffness, "stiffness"), (noise.scatter.damping, "damping")
    shown = [f"{share:.2%} of {name}" for share, name in named if share >= SHOWN_SCATTER]
    if noise.mean_shows:
        shown.append(f"{newtons(noise.scatter.mean_N)} of the mean force")
    if noise.zero_shows:
        shown.append(f"{noise.scatter.zero_mm:.2g} mm of the displacement's zero")
    return joined_by_and(shown)


def few_runs_words(lack: LackOfFit, problem: Problem, repeat: bool) -> str:
    """Say that more scatters than on rigs; where repeats have shown so already, that is all."""
    words = f"{scatter_words(lack, problem)}: more than rigs have"
    few = f"{words}, and these {problem.noise.runs} runs are too few to tell it from physics"
    return f"{few}; repeat some of them three times each" if repeat else words


def chance_words(lack: LackOfFit, problem: Problem, repeat: bool) -> str:
    """Say that scatter may have made what follows the conditions, but that it is too much to trust the law."""
    few = (
        f"{newtons(lack.rms)} ({lack.share:.2g} times the force noise) seem to follow the conditions; scatter from run "
        f"to run ({_scatter_words(problem)}) may make as much by chance, and these {problem.noise.runs} runs are "
        "too few to tell"
    )
    return f"{few}; repeat some of them three times each" if repeat else few


def form_words(lack: LackOfFit, elsewhere: ErrorBeyondScatter, best: Judged | None, law: Judged) -> str:
    """Say that what is left passes for form: the best effect that takes some of it, and the error elsewhere."""
    asked = "no effect of the catalogue takes any of it"
    if best is not None:
        asked = f"the best of the catalogue, {best.effects[0]}, takes {explained_share(best, law):.0%} of it"
    return (
        f"{newtons(lack.rms)} ({lack.share:.2g} times the force noise) still follow the conditions: {asked}, "
        "so it passes for the form of the effects that the law has; on left-out conditions the law errs by "
        f"{newtons(elsewhere.rms)} beyond scatter"
    )


def foretold_words(lack: LackOfFit, elsewhere: ErrorBeyondScatter) -> str:
    """Say that what is left is too much to pass for form, by the error on left-out conditions."""
    return (
        f"{newtons(lack.rms)} ({lack.share:.2g} times the force noise) follow the conditions, and no effect of the "
        f"catalogue takes half of it; on left-out conditions the law errs by {newtons(elsewhere.rms)} beyond scatter "
        f"({elsewhere.share:.2g} times the force noise): more than passes for form"
    )


def between_words(worst: LeftOutLevel) -> str:
    """Say that a law fits a level only when it is fitted to it, and what would tell more."""
    return (
        f"the law fits the tests at {worst.condition} = {worst.level}, but fitted to the others alone it "
        f"foretells them {newtons(worst.rms)} ({worst.share:.2g} times the force noise) worse: it isn't to be trusted "
        f"between the levels tested; test at values of {worst.condition} in between"
    )


def curve_words(best: Judged, law: Judged, problem: Problem) -> tuple[str, ...]:
    """Say that an effect follows a condition by a curve that isn't to be trusted between the levels tested."""
    return tuple(
        f"between the levels of {name} that were tested its curve isn't to be trusted: left out, they are foretold "
        f"with an error of {errors.candidate:.2%}, without it {errors.law:.2%}; test at values of {name} in between"
        for name, errors in worse_between_levels(best, law, problem.loops).items()
    )


def hidden_words(lack: LackOfFit, problem: Problem) -> str:
    """Say that scatter may hide too much for what is left to pass for form."""
    size = f" ({scatter})" if (scatter := _scatter_words(problem)) else ""
    return (
        f"{newtons(lack.rms)} ({lack.share:.2g} times the force noise) follow the conditions, and no effect of the "
        f"catalogue takes half of it; scatter from run to run{size} may hide that it is up to {lack.most_share:.2g} "
        f"times the force noise, and these {problem.noise.runs} runs are too few to tell; repeat some of them "
        "three times each"
    )


def pair_words(pair: Judged | None, best: Judged, law: Judged, problem: Problem) -> tuple[str, ...]:
    """Say what two effects would take together, and why they aren't named; nothing where the best one takes as much."""
    if pair is None or (takes := explained_share(pair, law)) < MATERIAL_PART_SHARE:
        return ()
    names = " and ".join(pair.effects)
    if takes < HALF_TAKEN_SHARE:
        more = takes > explained_share(best, law)
        return (f"{names} together would take {takes:.0%} of it, but {_why_not(pair, law, problem)}",) if more else ()
    left = f"{newtons(pair.lack.rms)} ({pair.lack.share:.2g} times the force noise)"
    return (f"{names} together would take {takes:.0%} of it, but leave {left}: too much for them to be named",)


def immaterial_words(best: Judged, law: Judged, problem: Problem) -> str:
    """Say what the best effect takes, and why it can't be named."""
    takes = explained_share(best, law)
    if takes < NEXT_TO_NOTHING:
        return (
            "of the effects that nothing speaks against none takes as much as 1% of what is missing on left-out A and f"
        )
    takes_most = f"{best.effects[0]} takes most, {takes:.0%} of what is missing on left-out A and f"
    return f"{takes_most}, but {_why_not(best, law, problem)}"


def _why_not(best: Judged, law: Judged, problem: Problem) -> str:
    """Say why a law isn't named, or what is added in it."""
    takes = explained_share(best, law)
    worse = [
        f"on left-out {name} the error goes from {error.law:.2%} to {error.candidate:.2%}"
        for name, error in held_against(best, law, problem.loops).items()
        if error.rises
    ]
    if worse:
        why = "; ".join(worse)
    elif takes < MATERIAL_PART_SHARE:
        why = "that is too little"
    elif best.akaike >= law.akaike:
        why = (
            f"fitted to all tests the law leaves {newtons(best.lack.rms)} that follow the conditions with it, and "
            f"{newtons(law.lack.rms)} without it: it steadies what is foretold there, and explains nothing that is "
            "missing"
        )
    elif not takes_part(best, law, problem):
        why = "some conditions gain, others lose"
    elif level := rests_on(best, law, problem):
        at = f"{level.condition} = {level.label}"
        why = (
            f"most of that at {at}, and fitted to the other levels it takes none of it there: it isn't to be trusted "
            f"between the levels tested; test at values of {level.condition} in between"
        )
    else:
        little = f"where so little is missing ({law.lack.share:.2g} times the force noise)"
        why = f"{little} only what takes half of it is named"
    return why
