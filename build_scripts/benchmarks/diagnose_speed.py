"""Whole diagnosis of a campaign of 48 runs (6 cycles, 1000 Hz) against its identification, as commands.

`python build_scripts/benchmarks/diagnose_speed.py [CAMPAIGN]`; without a campaign the bundled one.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

TIMES = 3


def run(*arguments: str | Path) -> tuple[float, float]:
    """Give the least wall time of three, s, and peak memory, GiB (NaN where the system keeps it), of a command."""
    command = [sys.executable, "-m", "pipeclamp", *map(str, arguments)]
    times, peak = [], float("nan")
    for _ in range(TIMES):
        begin = time.perf_counter()
        if hasattr(os, "wait4"):
            process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
            status, usage = os.wait4(process.pid, 0)[1:]
            process.returncode = os.waitstatus_to_exitcode(status)
            peak = usage.ru_maxrss / (2**20 if sys.platform == "linux" else 2**30)
        else:
            process = subprocess.run(command, stdout=subprocess.DEVNULL, check=False)
        times.append(time.perf_counter() - begin)
        if process.returncode:
            sys.exit(f"{' '.join(command)} ended with status {process.returncode}")
    return min(times), peak


if __name__ == "__main__":
    bundled = Path(__file__).parents[2] / "identification/pipeclamp_identification/data/campaigns/clamp_a"
    campaign = Path(sys.argv[1]) if len(sys.argv) > 1 else bundled
    with tempfile.TemporaryDirectory() as folder:
        law = Path(folder) / "law.json"
        identifying, _ = run("identify", campaign, "-o", law)
        diagnosing, peak = run("diagnose", law, campaign)
    print(f"identify {identifying:.2f} s, diagnose {diagnosing:.2f} s: {diagnosing / identifying:.1f} times")
    print(f"peak memory of the diagnosis {peak:.2f} GiB")
