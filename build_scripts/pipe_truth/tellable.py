"""How far apart are what is hidden in a shaker test and its nearest rival? The likelihood ratio without noise.

python build_scripts/pipe_truth/tellable.py -o FOLDER [--only WORD]

What no method can tell: each suspect is refitted to exact motions, in units of the noise that the test's sensors have.
The squares it leaves, rooted, are the standard deviations that part it from the truth. With the noise known exactly and
the truth's values too, twice the log of the likelihood ratio has that square as its mean, and twice its root as its
standard deviation: so a test's chance that the nearest rival is ruled out follows.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from math import sqrt
from pathlib import Path

import numpy as np
from designs import RECORD_TRIALS, TRIALS, Trial
from measuring_trials import MEASURING_TRIALS
from run import measured
from scipy.stats import norm

from pipeclamp_identification.attribution.compared import compare_measured
from pipeclamp_identification.attribution.pairs import promised_pairs, refitted_pairs
from pipeclamp_identification.attribution.refit import Refit, as_stated, refit, searched
from pipeclamp_identification.attribution.suspects import suspects_of
from pipeclamp_identification.attribution.task import RefitTask
from pipeclamp_identification.attribution.verdict import RULED_OUT_SQUARES, stated_task
from pipeclamp_identification.on_pipe.series import series_of

REACH = 60.0
"""Squares by which pairs may promise less than the best one and still are refitted."""


@dataclass(frozen=True)
class Apart:
    """Squares over the noise's that the model as stated and the nearest rival leave without noise, and its name."""

    stated: float
    rival: float
    name: str

    @property
    def chance(self) -> float:
        """That the nearest rival is ruled out."""
        return float(norm.cdf((self.rival - RULED_OUT_SQUARES) / (2 * sqrt(self.rival)))) if self.rival > 0 else 0.0


def apart(number: int, trial: Trial, folder: Path) -> Apart:
    """Measure a trial without noise, and refit all suspects to it, pairs where two things are hidden."""
    stated, test = measured(number, replace(trial, noise=0.0), folder / f"exact_{number:02d}", folder / "exact")
    compared = compare_measured(stated, test)
    task = with_noise(stated_task(compared), trial.noise)
    refits = refit(task, searched(task, suspects_of(compared.model, compared.description)))
    if len(trial.truth) > 1:
        refits.sort(key=lambda one: one.squared)
        refits = refitted_pairs(task, promised_pairs(task, refits), REACH)
    rivals = [one for one in refits if {suspect.id for suspect in one.suspects} != set(trial.truth)]
    nearest = min(rivals, key=lambda one: one.squared)
    return Apart(as_stated(task).squared, nearest.squared, _name(nearest))


def with_noise(task: RefitTask, noise: float) -> RefitTask:
    """Give a task with the noise that `pipe_rig.measure` adds."""
    assert task.sines is not None
    steady = task.sines.measurement.steady
    size = np.abs(steady.response)
    deviation = noise * size
    for series in series_of(steady):
        deviation[series.rows] += 0.1 * noise * size[series.rows].max(axis=0)
    return replace(task, sines=replace(task.sines, noise=deviation))


def _name(one: Refit) -> str:
    return " + ".join(suspect.id for suspect in one.suspects)


def main() -> None:
    """Print how far apart each trial's rivals are."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--only", default="line")
    asked = parser.parse_args()
    for number, trial in enumerate((*TRIALS, *RECORD_TRIALS, *MEASURING_TRIALS)):
        words = f"{number:02d} {trial.design} {trial.hidden}, {trial.noise:.0%} noise"
        if asked.only in words and trial.truth and trial.measured == ("sines",):
            found = apart(number, trial, asked.output)
            print(
                f"{words:72s} from what is stated {sqrt(found.stated):8.1f} sigma, from {found.name} "
                f"{sqrt(found.rival):.1f} sigma: ruled out in {found.chance:.0%}",
                flush=True,
            )


if __name__ == "__main__":
    main()
