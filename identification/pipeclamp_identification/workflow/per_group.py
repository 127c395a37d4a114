"""A law for each group of runs: each specimen's, each valve's."""

from __future__ import annotations

from dataclasses import dataclass

from pipeclamp_identification.fitting.identify import Method
from pipeclamp_identification.workflow.tests import Identified, Tests
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import plain_stems
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.law.law import Structure

FEWEST_RUNS_OF_A_GROUP = 4
"""Fewer runs can't show how a law follows amplitude, frequency and temperature."""


@dataclass(frozen=True)
class GroupLaw:
    """The law of one group: its name, the name of its file without ending, and what was found."""

    group: str
    stem: str
    tests: Tests
    found: Identified


def identify_per(
    tests: Tests,
    column: str,
    structure: Structure,
    *,
    method: Method = "joint",
    progress: Progress = silent,
) -> tuple[GroupLaw, ...]:
    """Fit a law to each group of a column of texts by itself.

    Args:
        tests: all runs.
        column: the column of runs.csv.
        structure, method, progress: as for `Tests.identify`.

    Raises:
        UserError: there is no such column, a group has too few runs, or can't serve the law; it is named.
    """
    groups = tests.per(column)
    counts = {name: len(own.metrics().runs) for name, own in groups.items()}
    if few := [f"{name} ({count})" for name, count in counts.items() if count < FEWEST_RUNS_OF_A_GROUP]:
        raise UserError(
            f"column {column!r}: too few runs of {', '.join(few)}; expected at least {FEWEST_RUNS_OF_A_GROUP} of each: "
            "test more, or take their rows out of runs.csv"
        )
    laws = []
    for (name, own), stem in zip(groups.items(), plain_stems(list(groups)), strict=True):
        progress(f"{column} {name}")
        try:
            found = own.identify(structure, method=method, progress=progress)
        except UserError as error:
            raise UserError(f"{column} {name!r}: {error}") from error
        laws.append(GroupLaw(name, stem, own, found))
    return tuple(laws)
