"""What an import found, told: which channel is what, every run, what was cut and why."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from functools import singledispatch

from pipeclamp.show.metrics import STORED_AND_LOST, stored_and_lost
from pipeclamp.show.table import Table
from pipeclamp.show.view import View
from pipeclamp_identification.campaign.description import ImportedColumn, ImportedFile
from pipeclamp_identification.importing.answer import ImportAnswer, ImportedCampaign, ImportedRunAnswer
from pipeclamp_identification.importing.channels.naming import EACH_CYCLE, SEGMENT
from pipeclamp_identification.importing.records.imported import ImportedRecords
from pipeclamp_identification.importing.results.imported import ImportedResults
from pipeclamp_identification.units.stated import Conversion
from pipeclamp_identification.workflow.next_command import after_import
from pipeclamp_models.base.said import counted, few_of
from pipeclamp_models.base.shell import quoted, shell_line

MOST_NAMED = 3
KNOWN_BY = {"run": "", "test": ", known by stiffness and loss, without a record"}
MOST_SHOWN = 60
"""Runs that a terminal shows; thousands would only scroll by."""


def columns_table(files: tuple[ImportedFile, ...]) -> Table:
    """Give which channel became which column, and by which factor; files that agree stand together."""
    alike: dict[tuple[tuple[str, ImportedColumn], ...], list[str]] = {}
    for file in files:
        alike.setdefault(tuple(file.columns.items()), []).append(file.file)
    rows = [
        (
            ours, column.channel, Conversion(column.factor, column.offset, column.integrated).words(),
            "stated" if column.stated else "by name and unit", few_of(names, MOST_NAMED),
        )
        for columns, names in alike.items()
        for ours, column in columns
    ]  # fmt: skip
    return Table(("column", "channel", "turned by", "known", "files"), rows)


@singledispatch
def imported_table(found: ImportedCampaign, answer: ImportAnswer, *, new_only: bool = False) -> Table:
    """Give every test of a campaign with what is known of it; or the first of the new ones alone.

    Args:
        found: of records: what was measured of each run, and what was done to it; of results: its stiffness and loss.
        answer: `found.answer()`.
        new_only: whether to give the new ones alone.
    """
    raise NotImplementedError(type(found))


@imported_table.register
def _(found: ImportedRecords, answer: ImportAnswer, *, new_only: bool = False) -> Table:
    runs = [run for run in answer.runs if run.new] if new_only else answer.runs
    shown = runs[:MOST_SHOWN] if new_only else runs
    lost = {one.run for one in answer.left_out}  # why stands beside the table
    rows = [
        (
            run.run, run.file, run.amplitude_mm, run.frequency_Hz, run.temperature_C,
            None if run.cycles is None else str(run.cycles),
            "; ".join([*run.done, *(["left out"] if run.run in lost else [])]) or "nothing",
        )
        for run in shown
    ]  # fmt: skip
    caption = f"the first {len(shown)} of {len(runs)} runs; the page holds all" if len(shown) < len(runs) else ""
    return Table(("run", "file", "A / mm", "f / Hz", "T / °C", "cycles", "done to it"), rows, caption)


@imported_table.register
def _(found: ImportedResults, answer: ImportAnswer, *, new_only: bool = False) -> Table:
    sources = {run.run: run.file for run in answer.runs}
    runs = [run for run in found.campaign.runs if run.name in found.new or not new_only]
    shown = runs[:MOST_SHOWN] if new_only else runs
    rows = [
        (
            run.name, sources.get(run.name), run.amplitude_mm, run.frequency_Hz, run.setup.temperature_C,
            *stored_and_lost(run),
        )
        for run in shown
    ]  # fmt: skip
    more = f"the first {len(shown)} of {len(runs)} tests; the page holds all" if len(shown) < len(runs) else ""
    return Table(("run", "file", "A / mm", "f / Hz", "T / °C", *STORED_AND_LOST), rows, more)


def cut_table(answer: ImportAnswer) -> Table:
    """Give what is in no run, and why."""
    rows = [
        (f"{one.file}, {one.table}" if one.table else one.file, f"{one.first} to {one.last}", one.why)
        for one in answer.cut
    ]
    return Table(("file", "samples", "cut because"), rows)


def left_out_table(answer: ImportAnswer) -> Table:
    """Give the files that couldn't be used, and why."""
    return Table(("file", "left out because"), [(one.file, one.why) for one in answer.left_out_files])


def import_lines(found: ImportedCampaign, answer: ImportAnswer, called: Sequence[str] = ()) -> list[str]:
    """Say what was written, and what to know of it; `called` are the command's words, so that it can be said anew."""
    done = "" if found.written else " (nothing is written)"
    if not answer.new_files:
        head = (
            f"{found.folder}: nothing to do, {counted(len(answer.known_files), 'file')} named and there already; "
            "options count for new files alone; to import these anew with others, name another folder by -o"
        )
    else:
        files = counted(len(answer.new_files), "file")
        new = counted(sum(run.new for run in answer.runs), found.thing)
        unusable = {one.run for one in answer.left_out} & {run.run for run in answer.runs if run.new}
        lost = f", {len(unusable)} of which can't be used" if unusable else ""
        head = f"{found.folder}: {new} of {files}{lost}{KNOWN_BY[found.thing]}{_known(answer)}{done}"
    lines = [head]
    if answer.left_out_files:
        count = len(answer.left_out_files)
        lines.append(f"{counted(count, 'file')} left out, for {'it' if count == 1 else 'they'} can't be used")
    if answer.cut and found.thing == "run":  # of rows of results, notes say it
        why = Counter(one.why for one in answer.cut)
        parts = "1 part is" if len(answer.cut) == 1 else f"{len(answer.cut)} parts are"
        lines.append(f"{parts} in no run: " + ", ".join(f"{n} x {w}" for w, n in list(why.items())[:4]))
    if found.thing == "run":
        lines += _no_sine_words(answer)
    if called and _names_are_needed(answer):
        lines.append("the files' names look as if they state settings, the temperature too: the line below takes them")
    elif _names_tell_more(answer) and called:
        again = again_with_pattern(found, answer, called)
        lines.append(f"the files' names look as if they state settings; to take them: {again}")
    elif _names_tell_more(answer):
        again = ", into another folder" if found.written else ""
        lines.append(
            f"the files' names look as if they state settings; to take them, import again{again}, with the pattern "
            f"{quoted(answer.pattern, always=True)}"
        )
    if unknown := _without_temperature(answer):
        some = _counted_of(len(unknown), len(answer.runs), found.thing)
        lines.append(
            f"no temperature is known of {some}: state it in runs.csv, or by --pattern or --conditions when importing"
        )
    return lines


def _no_sine_words(answer: ImportAnswer) -> list[str]:
    """Say where no run is a sine, of all files or of some, and what may make sines of them."""
    of_file: dict[str, list[ImportedRunAnswer]] = {}
    for run in answer.runs:
        of_file.setdefault(run.file, []).append(run)
    without = {file: own for file, own in of_file.items() if all(run.amplitude_mm is None for run in own)}
    parted = [file for file, own in without.items() if len(own) > 1 and EACH_CYCLE not in _segments(answer, file)]
    cycles = (
        "of a program whose amplitude grows from cycle to cycle, or that was parted where it turns, --columns "
        f"segment={EACH_CYCLE} makes each cycle a run"
    )
    if without and len(without) == len(of_file):
        whole = any(EACH_CYCLE not in _segments(answer, file) for file in without)
        says = ["no run is a sine, which alone a law is fitted to", *([cycles] if whole else [])]
        return ["; ".join([*says, "`pipeclamp compare` holds a law against free motions"])]
    return [f"no run of {few_of(parted, MOST_NAMED)} is a sine; {cycles}"] if parted else []


def _segments(answer: ImportAnswer, file: str) -> str:
    """Give the channel that parts a file into runs; empty where none does, or the file was there already."""
    return answer.columns.get(file, {}).get(SEGMENT, "")


def following_import(found: ImportedCampaign, answer: ImportAnswer, called: Sequence[str] = ()) -> str:
    """Give the shell line to run after an import, empty where there is none; `called` as for `import_lines`."""
    if _names_are_needed(answer):
        return again_with_pattern(found, answer, called) if called else ""
    is_there = found.written or not answer.new_files
    return after_import(str(found.folder)) if is_there and found.serves else ""


def _names_are_needed(answer: ImportAnswer) -> bool:
    """Tell whether the files' names state temperatures that nothing else does."""
    return "{temperature" in answer.pattern and bool(_without_temperature(answer))


def _names_tell_more(answer: ImportAnswer) -> bool:
    """Tell whether the files' names state something: more than temperatures, where those of all runs are known."""
    fields = re.findall(r"\{(\w+)\}", answer.pattern)
    told = () if _without_temperature(answer) else ("temperature",)
    return any(not field.startswith(told) for field in fields)


def _without_temperature(answer: ImportAnswer) -> list[str]:
    """Give the runs of no known temperature; of those that are left out it doesn't matter."""
    lost = {one.run for one in answer.left_out}
    return [run.run for run in answer.runs if run.temperature_C is None and run.run not in lost]


def again_with_pattern(found: ImportedCampaign, answer: ImportAnswer, called: Sequence[str]) -> str:
    """Give the command once more, with the pattern; what has been written stays, so it goes into another folder."""
    words = [word for word in called if word != "--dry-run"]
    if found.written:
        follows = [False, *(word in ("-o", "--output") for word in words)]
        own = [word.startswith(("-o", "--output=")) or word == "--output" for word in words]
        kept = [word for word, after, mine in zip(words, follows, own, strict=False) if not (after or mine)]
        words = [*kept, "-o", f"{found.folder}_2"]
    return shell_line(*words, "--pattern", answer.pattern)


def _counted_of(some: int, count: int, what: str) -> str:
    return counted(count, what) if some == count else f"{some} of {count} {what}s"


def _known(answer: ImportAnswer) -> str:
    count = len(answer.known_files)
    return f", {count} more files were there already" if count else ""


def import_view(found: ImportedCampaign, called: Sequence[str] = ()) -> View:
    """Give an import's answer, tables and lines; `called` as for `import_lines`."""
    answer = found.answer()
    tables = [columns_table(found.files), imported_table(found, answer, new_only=True)] if found.files else []
    following = following_import(found, answer, called)
    return View(answer, tables, [*import_lines(found, answer, called), *([f"Next: {following}"] if following else [])])
