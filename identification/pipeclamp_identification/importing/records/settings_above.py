"""Numbers above tables, or in files' properties, that look as if they were set: a torque of a bolt, a pressure."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pipeclamp_identification.importing.channels.naming import condition_name, is_measured
from pipeclamp_models.base.said import few_of

FEWEST_TABLES = 4
"""Of fewer tables numbers tell nothing by coming again."""

Row = Mapping[str, float | str | None]
"""Of runs.csv."""


@dataclass(frozen=True)
class StatedAbove:
    """What stands above a table: numbers as texts, by name and unit; and the rows of its runs."""

    numbers: Mapping[str, str]
    runs: tuple[Row, ...]


def settings_above_words(tables: Sequence[StatedAbove]) -> list[str]:
    """Say which numbers above all tables look as if they were set, and aren't used.

    What was set differs between tables and comes again; what was measured, or counts, hardly does. A number that goes
    with a column of runs.csv is known by it.

    Args:
        tables: those with runs.
    """
    if len(tables) < FEWEST_TABLES:
        return []
    words = []
    for heading in tables[0].numbers:
        runs_at: dict[str, list[Row]] = {}
        for table in tables:
            runs_at.setdefault(table.numbers.get(heading, ""), []).extend(table.runs)
        is_set = "" not in runs_at and 2 <= len(runs_at) <= len(tables) // 2
        if is_set and is_measured(heading) and not _is_known(list(runs_at.values())):
            column = condition_name(heading)
            words.append(
                f"{heading!r} stands above the tables, differs ({few_of([*runs_at])}) and isn't used: if it was set, "
                f"state it as a condition, in a column {column!r} of --conditions or of runs.csv, or by --pattern "
                f"where the files' names state it"
            )
    return words


def _is_known(groups: Sequence[Sequence[Row]]) -> bool:
    """Tell whether a column of runs.csv parts the runs into the same groups."""
    columns = {column for runs in groups for run in runs for column in run if column not in ("run", "file")}
    return any(_parts(column, groups) for column in columns)


def _parts(column: str, groups: Sequence[Sequence[Row]]) -> bool:
    """Tell whether the values of a column in one group lie apart from those in any other."""
    values = [[run.get(column) for run in runs] for runs in groups]
    numbers = [[one for one in own if isinstance(one, float | int)] for own in values]
    if all(len(own) == len(shown) for own, shown in zip(values, numbers, strict=True)):
        spans = sorted((min(own), max(own)) for own in numbers)
        return all(low[1] < high[0] for low, high in itertools.pairwise(spans))
    texts = [set(own) for own in values]
    return None not in set().union(*texts) and len(set().union(*texts)) == sum(map(len, texts))
