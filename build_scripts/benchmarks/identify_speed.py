"""Time of `identify` and of `compare` on a 240-run campaign against reading its files with polars alone.

Run: python build_scripts/benchmarks/identify_speed.py
"""

import resource
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import polars as pl

from pipeclamp.bundled import open_law
from pipeclamp.parameter_file import law_of, law_text
from pipeclamp_identification.campaign import read_campaign
from pipeclamp_identification.campaign_writing import WrittenRun, write_campaign
from pipeclamp_identification.compare import compare, comparison_json
from pipeclamp_identification.identify import identify, law_file
from pipeclamp_identification.rig import TestPlan, virtual_runs

PLAN = TestPlan(frequencies=(1.0, 2.0, 3.0, 4.0, 5.0), rate=2500.0)
SPECIMENS = 3


def campaign_runs():
    """4 A x 5 f x 4 T x 3 specimens, 2500 Hz, 5 cycles each."""
    law = law_of(open_law("emwm2"))
    for specimen in range(SPECIMENS):
        for run in virtual_runs(law, replace(PLAN, seed=specimen)):
            row = {**run.row, "run": f"S{specimen}_{run.row['run']}", "specimen": f"S{specimen}"}
            yield WrittenRun(row, run.record)


def seconds(work) -> float:
    """Least of three runs."""
    times = []
    for _ in range(3):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return min(times)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "campaign"
        count = write_campaign(folder, campaign_runs(), name="speed", notes="")
        files = sorted((folder / "runs").iterdir())
        rows = sum(len(pl.read_csv(file)) for file in files)

        def whole() -> None:
            """Read, identify, and make the parameter file's text."""
            tests = read_campaign(folder)
            law_text(law_file(identify(tests), tests, name="speed", command="benchmark", date=None))

        def compared() -> None:
            """Read, hold the law against the campaign, and break the error down."""
            comparison_json(compare(open_law("emwm2"), read_campaign(folder)))

        reading = seconds(lambda: [pl.read_csv(file) for file in files])
        identifying, comparing = seconds(whole), seconds(compared)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20 if sys.platform == "linux" else float("nan")
    print(f"{count} runs, {rows / 1e6:.2f} million rows")
    print(
        f"polars reads them in {reading:.2f} s, identify takes {identifying:.2f} s: {identifying / reading:.1f} times"
    )
    print(f"compare takes {comparing:.2f} s: {comparing / identifying:.2f} times what identify takes")
    print(f"peak memory {peak:.2f} GiB")
