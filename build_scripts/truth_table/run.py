"""Make the truth table: `python build_scripts/truth_table/run.py [--share N] [--seed S] [--cases WORD] -o FOLDER`.

With --narrow instead: narrow test plans, in which effects imitate each other, and what the proposed tests tell.
With --metrics instead: campaigns of which dW and W alone are kept.
With --devices instead: devices of other laws than the catalogue's.
With --discover instead: laws that no catalogue has, nothing, and effects of the catalogue, put to `discover`.

Every case is a virtual campaign of a truth that this folder integrates by itself, put to the package as a user would.
Finished cases are kept in FOLDER/cases-<seed>.jsonl; a run that was ended goes on from there.
With --devices --write FOLDER [--cases WORD]: write the campaign and the held-out tests of cases, each into a folder.
With --journals FOLDER/cases-1.jsonl FOLDER/cases-2.jsonl: the table of what runs have finished, several draws together.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "POLARS_MAX_THREADS"):
    os.environ.setdefault(threads, "1")  # the cases are what runs in parallel

from beyond.cases import beyond_cases  # noqa: E402
from beyond.judge import judged_beyond  # noqa: E402
from beyond.table import beyond_markdown, beyond_sound, beyond_targets  # noqa: E402
from cases import all_cases, chosen  # noqa: E402
from devices.cases import device_cases, write_device  # noqa: E402
from devices.judge import judged_device  # noqa: E402
from devices.table import device_markdown, device_targets, devices_sound  # noqa: E402
from judge import judged  # noqa: E402
from metric_cases import metric_cases  # noqa: E402
from metric_judge import judged_metrics  # noqa: E402
from metric_table import metric_bounds, metric_markdown, metrics_sound  # noqa: E402
from narrow import narrow_cases  # noqa: E402
from narrow_table import narrow_markdown  # noqa: E402
from table import Row, markdown, reached, sound  # noqa: E402


@dataclass(frozen=True)
class Experiment:
    """What is asked of the package.

    Attributes:
        journal, table: names of the files of finished cases and of the table.
        cases: gives all cases.
        judged: runs one, with a seed; gives a dataclass with its name and how it is counted.
        markdown: gives the table, with the command that made it.
        targets: gives the bounds with what was reached.
        sound: tells whether a share is as it should be.
        write: writes a case's campaigns into a folder, where that is provided for.
    """

    journal: str
    table: str
    cases: Callable[[], list[Any]]
    judged: Callable[[Any, int], Any]
    markdown: Callable[[Sequence[Row], str], str]
    targets: Callable[[Sequence[Row]], list[dict[str, Any]]]
    sound: Callable[[Sequence[Row]], bool]
    write: Callable[[Any, int, Path], Any] | None = None


EXPERIMENTS = {
    "": Experiment("cases", "truth_table", all_cases, judged, markdown, reached, sound),
    "narrow": Experiment("narrow", "narrow_table", narrow_cases, judged, narrow_markdown, lambda _: [], sound),
    "metrics": Experiment(
        "metrics", "metrics_table", metric_cases, judged_metrics, metric_markdown, metric_bounds, metrics_sound
    ),
    "devices": Experiment(
        "devices",
        "devices_table",
        device_cases,
        judged_device,
        device_markdown,
        device_targets,
        devices_sound,
        write_device,
    ),
    "discover": Experiment(
        "discover", "discover_table", beyond_cases, judged_beyond, beyond_markdown, beyond_targets, beyond_sound
    ),
}
"""By the option that chooses it."""


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--share", type=float, default=1.0, help="share of the cases, spread evenly (1: all)")
    parser.add_argument("--seed", type=int, default=0, help="seed of everything that is drawn")
    parser.add_argument("--cases", nargs="*", default=[], help="only cases whose name contains one of these")
    asked = parser.add_mutually_exclusive_group()
    for name, words in (
        ("narrow", "narrow test plans, and their next tests"), ("metrics", "dW and W alone"),
        ("devices", "devices of other laws"), ("discover", "terms that no catalogue has"),
    ):  # fmt: skip
        asked.add_argument(f"--{name}", dest="asked", action="store_const", const=name, default="", help=words)
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--verbose", action="store_true", help="print every diagnosis with its evidence")
    parser.add_argument("-o", "--output", type=Path, default=None, help="folder for the table; else print only")
    parser.add_argument("--check", action="store_true", help="end with status 1 when something was named wrongly")
    parser.add_argument("--journals", nargs="+", type=Path, default=[], help="only print the table of these journals")
    parser.add_argument("--write", type=Path, default=None, help="with --devices: write the tests into this folder")
    given = parser.parse_args()
    experiment = EXPERIMENTS[given.asked]
    if given.journals:
        rows = [row for journal in given.journals for row in finished(journal)]
        made = " ".join(["python build_scripts/truth_table/run.py --journals", *(path.name for path in given.journals)])
        print(experiment.markdown(rows, made))
        return
    known = experiment.cases()
    cases = chosen(known, given.share, given.seed)
    if given.cases:
        cases = [case for case in cases if any(word in case.name for word in given.cases)]
    if not cases:
        sys.exit(f"--cases {' '.join(given.cases)}: no case has such a name; names look like {known[0].name}")
    if given.write:
        write_all(experiment, cases, given.seed, given.write)
        return
    journal = given.output / f"{experiment.journal}-{given.seed}.jsonl" if given.output else None
    rows = run(cases, experiment.judged, given.seed, given.jobs, journal, given.verbose)
    command = f"python build_scripts/truth_table/run.py --share {given.share:g} --seed {given.seed}"
    command += f" --{given.asked}" if given.asked else ""
    command += f" --cases {' '.join(given.cases)}" if given.cases else ""
    text = experiment.markdown(rows, command)
    if given.output:
        (given.output / f"{experiment.table}.md").write_text(text, encoding="utf-8")
        content = {"command": command, "targets": experiment.targets(rows), "cases": rows}
        (given.output / f"{experiment.table}.json").write_text(json.dumps(content, indent=1), encoding="utf-8")
    print(text)
    if given.check and not experiment.sound(rows):
        sys.exit("truth table: something was named wrongly, alarmed, failed, or too little was found")


def write_all(experiment: Experiment, cases: list[Any], seed: int, folder: Path) -> None:
    """Write the tests of cases, each into a folder of its own."""
    if experiment.write is None:
        sys.exit("--write: only the cases of --devices can be written; expected --devices beside it")
    for case in cases:
        place = folder / case.name.replace("/", "-")
        if place.exists():
            sys.exit(f"--write: {place} exists; expected a new folder, so that nothing is overwritten")
        experiment.write(case, seed, place)
        print(place)


def finished(journal: Path) -> list[Row]:
    """Give the rows of a journal; of a run that was killed it may hold half a line at its end."""
    text = journal.read_text(encoding="utf-8")
    return [json.loads(line) for line in text[: text.rfind("\n") + 1].splitlines()]


def run(
    cases: list[Any],
    judge: Callable[[Any, int], Any],
    seed: int,
    jobs: int,
    journal: Path | None,
    verbose: bool,
) -> list[Row]:
    """Run the cases that the journal doesn't hold yet; give all rows in the cases' order."""
    done: dict[str, Row] = {}
    if journal:
        journal.parent.mkdir(parents=True, exist_ok=True)
        if journal.exists():
            done = {row["name"]: row for row in finished(journal)}
            journal.write_text("".join(f"{json.dumps(row)}\n" for row in done.values()), encoding="utf-8")
    left = [case for case in cases if case.name not in done]
    random.Random(seed).shuffle(left)  # so that what is done at any time stands for the whole
    begin = time.perf_counter()
    with ProcessPoolExecutor(max_workers=jobs) as pool:
        waiting = {pool.submit(judge, case, seed): case for case in left}
        for number, future in enumerate(as_completed(waiting), 1):
            row: Row = json.loads(json.dumps(asdict(future.result())))
            done[row["name"]] = row
            if journal:
                with journal.open("a", encoding="utf-8") as stream:
                    stream.write(json.dumps(row) + "\n")
            rest = (time.perf_counter() - begin) / number * (len(left) - number)
            print(f"{number}/{len(left)} {row['name']}: {row['counted']} ({rest / 60:.0f} min left)", flush=True)
            if verbose:
                print(json.dumps(row, indent=1), flush=True)
    return [done[case.name] for case in cases]


if __name__ == "__main__":
    main()
