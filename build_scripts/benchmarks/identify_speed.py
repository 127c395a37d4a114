"""What `pipeclamp identify` takes as a whole process on a 240-run campaign, against a plain script and a bare read.

Run: python build_scripts/benchmarks/identify_speed.py [REPEATS]

Three processes take turns, so that a machine that is busy at times is as busy for all of them; the median counts, and
ratios are those of each turn.

- `pipeclamp identify CAMPAIGN -o LAW.json`;
- plain_script.py, the same fit in pandas and SciPy (pip install pandas);
- polars reading all files, and nothing else.

Then `pipeclamp compare` on a campaign of ten runs, and `pipeclamp --help`. Linear algebra is held to one thread in all,
which is the plain script's gain: pipeclamp does so anyway. Modules are compiled before, as they are for any user.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path

import polars as pl

from pipeclamp_identification.campaign.rig.plan import TestPlan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import WrittenRun, write_campaign
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import law_of

HERE = Path(__file__).parent
PLAN = TestPlan(frequencies=(1.0, 2.0, 3.0, 4.0, 5.0), rate=2500.0)
TEN_RUNS = TestPlan(amplitudes=(0.2, 0.4, 0.6, 0.8, 1.0), frequencies=(1.0, 3.0), temperatures=(20.0,))
SPECIMENS = 3
REPEATS = 5
BARE_READ = "import pathlib, sys, polars; [polars.read_csv(file) for file in pathlib.Path(sys.argv[1]).iterdir()]"
SCRIPT, READ = "plain script", "polars reads"


@dataclass(frozen=True)
class Taken:
    """What a process took, in s."""

    cpu: float
    wall: float


def campaign_runs():
    """4 A x 5 f x 4 T x 3 specimens, 2500 Hz, 5 cycles each."""
    law = law_of(open_law("emwm2"))
    for specimen in range(SPECIMENS):
        for run in virtual_runs(law, replace(PLAN, seed=specimen)):
            row = {**run.row, "run": f"S{specimen}_{run.row['run']}", "specimen": f"S{specimen}"}
            yield WrittenRun(row, run.record)


def take(arguments) -> Taken:
    """Run Python as a whole process, children included; refuse one that fails."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    before, begin = os.times(), time.perf_counter()
    done = subprocess.run([sys.executable, *arguments], env=environment, capture_output=True, text=True, check=False)
    wall, after = time.perf_counter() - begin, os.times()
    if done.returncode:
        raise SystemExit(f"{' '.join(arguments)}: status {done.returncode}\n{done.stderr}")
    return Taken(
        after.children_user - before.children_user + after.children_system - before.children_system,
        wall,
    )


def in_turn(commands, repeats):
    """Run each command once unheeded, then all of them in turn; give what each took, by name."""
    for arguments in commands.values():
        take(arguments)
    taken = {name: [] for name in commands}
    for _ in range(repeats):
        for name, arguments in commands.items():
            taken[name].append(take(arguments))
    return taken


def median(numbers) -> float:
    """Give the median."""
    return statistics.median(numbers)


def tell(taken, against=()):
    """Print medians of what processes took, and the first one's CPU time against others'."""
    for name, times in taken.items():
        print(f"{name:18s} {median(one.cpu for one in times):6.2f} s of CPU {median(one.wall for one in times):6.2f} s")
    first, *_ = taken
    for other in against:
        ratio = median(one.cpu / two.cpu for one, two in zip(taken[first], taken[other], strict=True))
        print(f"{first} takes {ratio:.2f} times the CPU time of: {other}")


def main(repeats):
    """Make the campaigns, run everything and print it."""
    with tempfile.TemporaryDirectory() as temporary:
        folder, few, law = (Path(temporary) / name for name in ("campaign", "ten_runs", "law.json"))
        count = write_campaign(folder, campaign_runs(), name="speed", notes="")
        write_campaign(few, virtual_runs(law_of(open_law("emwm2")), TEN_RUNS), name="ten", notes="")
        rows = sum(pl.scan_csv(file).select(pl.len()).collect().item() for file in (folder / "runs").iterdir())
        print(f"{count} runs, {rows / 1e6:.2f} million rows; medians of {repeats}")
        script, pipeclamp = str(HERE / "plain_script.py"), ("-m", "pipeclamp")
        fits = {
            "identify": [*pipeclamp, "identify", str(folder), "-o", str(law)],
            SCRIPT: [script, str(folder)],
            READ: ["-c", BARE_READ, str(folder / "runs")],
        }
        tell(in_turn(fits, repeats), (SCRIPT, READ))
        tell(
            in_turn(
                {
                    "compare, ten runs": [*pipeclamp, "compare", "emwm2", str(few)],
                    "--help": [*pipeclamp, "--help"],
                },
                repeats,
            )
        )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else REPEATS)
