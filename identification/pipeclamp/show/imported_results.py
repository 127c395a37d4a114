"""What an import of results found, told: which column is what, and each test's stiffness."""

from __future__ import annotations

from collections.abc import Sequence

from pipeclamp.show.imported import again_with_pattern
from pipeclamp.show.table import Table
from pipeclamp.show.view import View
from pipeclamp_identification.importing.results.rows import LOSS, STORAGE
from pipeclamp_identification.importing.results.whole import FoundResults
from pipeclamp_identification.workflow.next_command import after_import
from pipeclamp_models.base.said import counted

MOST_SHOWN = 60
"""Tests that a terminal shows."""
SHOWN = ("amplitude_mm", "frequency_Hz", "temperature_C", STORAGE, LOSS)


def results_view(found: FoundResults, called: Sequence[str] = ()) -> View:
    """Give the answer, tables and lines; `called` are the command's words, so that it can be said anew."""
    answer = found.answer()
    alike: dict[tuple[tuple[str, str], ...], list[str]] = {}
    for file, columns in found.columns.items():
        alike.setdefault(tuple(columns.items()), []).append(file)
    which = Table(
        ("quantity", "column", "files"),
        [
            (quantity, channel, counted(len(files), "file") if len(files) > 1 else files[0])
            for columns, files in alike.items()
            for quantity, channel in columns
        ],
    )
    shown = found.rows[:MOST_SHOWN]
    tests = Table(
        ("run", "A / mm", "f / Hz", "T / °C", "k' / N/mm", "k'' / N/mm"),
        [(row["run"], *(row.get(name) for name in SHOWN)) for row in shown],
        f"the first {len(shown)} of {len(found.rows)} tests" if len(shown) < len(found.rows) else "",
    )
    done = "" if found.written else " (nothing is written)"
    lines = [
        f"{found.folder}: {counted(len(found.rows), 'test')} of {counted(len(found.columns), 'file')}, known by "
        f"stiffness and loss, without a record{done}"
    ]
    if found.pattern and called:
        again = again_with_pattern(found, answer, called)
        lines.append(f"the files' names look as if they state settings; to take them: {again}")
    elif any(run.temperature_C is None for run in answer.runs):
        lines.append("no temperature is known of some tests: state it in runs.csv, or by --pattern when importing")
    if found.written:
        lines.append(f"Next: {after_import(str(found.folder))}")
    return View(answer, [which, tests], lines)
