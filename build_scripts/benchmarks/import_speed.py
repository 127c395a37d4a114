"""What `pipeclamp import` and `pipeclamp identify` take on a large campaign, against polars' bare read of its files.

Run: python build_scripts/benchmarks/import_speed.py [RUNS] [--rows N] [--one-file] [--folder FOLDER] [--only import]

Files as a test machine exports them: a header block, names, units, force in kN, six digits. Each run has a file of its
own, or (--one-file) all are in one, told apart by a column of segments. Every process is a whole one, and they come one
after the other: polars, import, polars, identify, polars. Times are wall times; memory is the largest sum of resident
memory over a process and those that it started, looked at ten times a second (pip install psutil).
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
import polars as pl
import psutil

AMPLITUDES = (0.2, 0.4, 0.6, 0.8, 1.0)
FREQUENCIES = (2.0, 5.0, 10.0, 20.0)
TEMPERATURES = (20, 40, 60, 80)
RATE = 1000.0
HEADER = "Test rig 3;multi-axial\nOperator;Lab 2\nSampling rate [Hz];1000\n\n"
NAMES = ("Time", "Segment", "Axial Displacement", "Axial Force")
UNITS = ("s", "", "mm", "kN")
SKIPPED = HEADER.count("\n") + 2
BARE_READ = (
    "import pathlib, sys, polars\n"
    "for file in sorted(pathlib.Path(sys.argv[1]).iterdir()):\n"
    f"    polars.read_csv(file, separator=';', skip_rows={SKIPPED}, has_header=False)"
)


@dataclass(frozen=True)
class Taken:
    """What a process took: wall time in s, CPU time in s, memory in GiB."""

    wall: float
    cpu: float
    memory: float


def settings(count):
    """Give amplitude in mm, frequency in Hz and temperature in degC of each run, in turn."""
    every = list(product(AMPLITUDES, FREQUENCIES, TEMPERATURES))
    return [every[number % len(every)] for number in range(count)]


def samples(number, amplitude, frequency, temperature, rows):
    """Give a run's samples: a spring that hardens, friction and damping, with the noise of sensors."""
    noise = np.random.default_rng(number)
    time = np.arange(rows) / RATE
    phase = 2 * np.pi * frequency * time + noise.uniform(0, 6)
    y, v = amplitude * np.sin(phase), amplitude * np.cos(phase)
    warm = 1 - 0.002 * (temperature - 20)
    force = 900 * warm * y + 250 * warm * y**3 + 120 * warm * v + 40 * np.tanh(20 * v)
    return {
        "time": time,
        "y": y + 2e-4 * noise.standard_normal(rows),
        "force": (force + 1.5 * noise.standard_normal(rows)) / 1e3,
    }


def write_exports(folder, count, rows, one_file):
    """Write the files; give the bytes in all of them."""
    folder.mkdir()
    names = [name for name in NAMES if one_file or name != "Segment"]
    head = HEADER + ";".join(names) + "\n" + ";".join(UNITS[NAMES.index(name)] for name in names) + "\n"
    for number, (amplitude, frequency, temperature) in enumerate(settings(count)):
        stem = "all" if one_file else f"A{amplitude}_f{frequency}_T{temperature}_{number:04d}"
        frame = pl.DataFrame(samples(number, amplitude, frequency, temperature, rows))
        if one_file:
            frame = frame.with_columns(pl.col("time") + number * rows / RATE)
            frame.insert_column(1, pl.Series("segment", np.full(rows, number + 1)))
        with (folder / f"{stem}.csv").open("ab") as stream:
            if stream.tell() == 0:
                stream.write(head.encode())
            frame.write_csv(stream, include_header=False, separator=";", float_precision=6)
    return sum(path.stat().st_size for path in folder.iterdir())


def take(arguments):
    """Run Python as a whole process and look at it; refuse one that fails."""
    before, begin = os.times(), time.perf_counter()
    with tempfile.TemporaryFile() as told:
        process = subprocess.Popen([sys.executable, *arguments], stdout=told, stderr=told)
        whole, memory = psutil.Process(process.pid), 0
        while process.poll() is None:
            memory = max(memory, _resident(whole))
            time.sleep(0.1)
        wall, after = time.perf_counter() - begin, os.times()
        if process.returncode:
            told.seek(0)
            raise SystemExit(f"{' '.join(arguments)}: status {process.returncode}\n{told.read().decode()}")
    cpu = after.children_user - before.children_user + after.children_system - before.children_system
    return Taken(wall, cpu, memory / 2**30)


def _resident(process):
    """Give the bytes of memory that a process and its children hold."""
    total = 0
    try:
        for one in (process, *process.children(recursive=True)):
            total += one.memory_info().rss
    except psutil.NoSuchProcess:
        pass
    return total


def tell(name, taken, read=None):
    """Print what a process took, against polars' reads before and after it."""
    against = f"{taken.wall / read:6.1f} times polars' read" if read else ""
    print(f"{name:10s} {taken.wall:7.1f} s {taken.cpu:7.1f} s of CPU {taken.memory:6.2f} GiB {against}", flush=True)


def main(stated):
    """Write the files, run everything and print it."""
    with tempfile.TemporaryDirectory(dir=stated.folder) as temporary:
        exports, campaign, law = (Path(temporary) / name for name in ("exports", "campaign", "law.json"))
        size = write_exports(exports, stated.runs, stated.rows, stated.one_file)
        print(f"{stated.runs} runs, {stated.runs * stated.rows / 1e6:.2f} million rows, {size / 1e9:.2f} GB of text")
        pattern = () if stated.one_file else ("--pattern", "A{amplitude_mm}_f{frequency_Hz}_T{temperature_C}_")
        commands = {"import": ["import", str(exports), "-o", str(campaign), *pattern]}
        if stated.only != "import":
            commands["identify"] = ["identify", str(campaign), "-o", str(law)]
        read = ["-c", BARE_READ, str(exports)]
        take(read)
        before = take(read)
        tell("polars", before)
        for name, arguments in commands.items():
            taken, after = take(["-m", "pipeclamp", *arguments]), take(read)
            tell("polars", after)
            tell(name, taken, (before.wall + after.wall) / 2)
            before = after
        written = sum(path.stat().st_size for path in campaign.rglob("*") if path.is_file())
        print(f"campaign: {written / 1e9:.2f} GB, its page {(campaign / 'import.html').stat().st_size / 1e6:.1f} MB")
        shutil.rmtree(exports)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("runs", type=int, nargs="?", default=200)
    parser.add_argument("--rows", type=int, default=25_000)
    parser.add_argument("--one-file", action="store_true")
    parser.add_argument("--folder", help="where to write; the system's temporary one by default")
    parser.add_argument("--only", choices=("import",))
    main(parser.parse_args())
