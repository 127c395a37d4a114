"""How often is the wrong parameter of a pipe and its clamps named rightly? Virtual shaker tests with something hidden.

python build_scripts/pipe_truth/run.py -o FOLDER [--only WORD] [--jobs 2]

The truth is integrated in time as one set of equations, the comparison stands on harmonic balance; sensors are noisy.
A test that is already in the folder is not measured again.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from dataclasses import replace
from pathlib import Path

import joblib
from designs import RECORD_TRIALS, TRIALS, Trial
from measuring_trials import DESIGNS_AND_LINES, MEASURING_TRIALS
from pipe_rig import describe, measure
from record_rig import measure_motions

from pipeclamp_identification.attribution.compared import compare_measured
from pipeclamp_identification.attribution.verdict import Attribution, attribute
from pipeclamp_identification.on_pipe.measurement import FILE_NAME


def measured(number: int, trial: Trial, own: Path, exact: Path) -> tuple[Path, Path]:
    """Make a trial's test where it isn't there yet; give the stated system and the measurement.

    Args:
        number: of the trial; the noise hangs on it.
        trial: what is hidden.
        own: folder of the test.
        exact: folder in which motions are kept that several tests share.
    """
    design = DESIGNS_AND_LINES[trial.design]
    stated = design.write(own, {}, {})
    test = own / "measured"
    if not (test / FILE_NAME).is_file():
        sensors = design.sensors
        if trial.gains:
            sensors = tuple(replace(sensor, gain=gain) for sensor, gain in zip(sensors, trial.gains, strict=True))
        sensors = tuple(replace(sensor, **trial.sensors.get(sensor.name, {})) for sensor in sensors)
        true = design.write(own / "true", trial.fields, trial.laws)
        files = ""
        if "sines" in trial.measured:
            files += measure(true, sensors, design.sines, test, trial.noise, number, trial.drive, exact)
        motions = tuple(motion for kind in trial.measured for motion in design.motions.get(kind, ()))
        files += measure_motions(true, sensors, motions, test, trial.noise, seed=number)
        describe(test, sensors, files)
    return stated, test


def outcome(trial: Trial, found: Attribution) -> str:
    """Judge an answer: a cause is right if it is the truth and no more, a part if it is one of what is hidden."""
    truth, ambiguous = set(trial.truth), found.verdict == "ambiguous"
    if found.verdict == "complete":
        return "right" if not truth else "missed"
    if found.verdict == "unknown":
        return "can't tell"
    sets = [{suspect.id for suspect in entry.suspects} for entry in found.named]
    if found.kind == "part":
        told = any(named <= truth for named in sets)
        return f"{'ambiguous' if ambiguous else 'part'} {'with' if told else 'without'} the truth"
    if ambiguous:
        return f"ambiguous {'with' if truth in sets else 'without'} the truth"
    return "right" if truth in sets else "confidently wrong"


def tried(number: int, trial: Trial, folder: Path) -> str:
    """Make and judge a trial; give its outcome."""
    system, test = measured(number, trial, folder / f"{number:02d}", folder / "exact")
    begin = time.process_time()
    comparison = compare_measured(system, test)
    found = attribute(comparison)
    took = time.process_time() - begin
    result = outcome(trial, found)
    names = ", ".join(entry.id for entry in found.named)
    print(
        f"{number:2d} {trial.design:10s} {'+'.join(trial.measured):12s} {trial.hidden:44s} {trial.noise:3.0%} "
        f"{comparison.nrmse:6.1%} {took:5.1f} s  {result:26s} "
        f"{found.verdict} {found.kind or '-'}: {names} (left {found.left:.2f})",
        flush=True,
    )
    return result


def main() -> None:
    """Run the trials and count."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--only", default="")
    parser.add_argument("--jobs", type=int, default=2)
    asked = parser.parse_args()
    chosen = [
        (number, trial)
        for number, trial in enumerate((*TRIALS, *RECORD_TRIALS, *MEASURING_TRIALS))
        if asked.only
        in f"{number:02d} {trial.design} {'+'.join(trial.measured)} {trial.hidden}, {trial.noise:.0%} noise"
    ]
    outcomes = joblib.Parallel(n_jobs=asked.jobs)(
        joblib.delayed(tried)(number, trial, asked.output) for number, trial in chosen
    )
    for result, count in Counter(outcomes).most_common():
        print(f"{count:3d} of {len(outcomes)} {result}")


if __name__ == "__main__":
    main()
