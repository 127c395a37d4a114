"""A diagnosis told: its verdict, the candidates, and what to run next."""

from __future__ import annotations

from pathlib import Path

from pipeclamp.show.table import Table
from pipeclamp.show.view import View
from pipeclamp_identification.diagnosis.answer import RungAnswer, diagnosis_answer
from pipeclamp_identification.diagnosis.diagnosed import RecordDiagnosed
from pipeclamp_identification.diagnosis.foretold import (
    BothErrors,
    explained_share,
    held_against,
    worse_between_levels,
)
from pipeclamp_identification.diagnosis.problem import Judged
from pipeclamp_identification.diagnosis.verdict import Diagnosis
from pipeclamp_identification.diagnosis.weighing.special_cases import simpler_words
from pipeclamp_identification.fitting.groups_answer import group_words
from pipeclamp_identification.fitting.heldout import left_out_at_once
from pipeclamp_identification.workflow.next_command import NEXT_TEST
from pipeclamp_identification.workflow.tests import Diagnosed

LEAST_HELP = 0.005
"""A candidate that takes less than half a percent of what is missing, which is shown as 0, does nothing."""
NO_GAIN = "fitted to all tests it takes no more than its parameters cost"


def against(candidate: Judged, diagnosis: Diagnosis) -> list[str]:
    """Say what speaks against a candidate: its parameters, the fit to all, left-out conditions, a simpler effect."""
    law = diagnosis.law
    errors = {left_out_at_once(diagnosis.loops): BothErrors(law.heldout_nrmse, candidate.heldout_nrmse)}
    errors |= held_against(candidate, law, diagnosis.loops)
    errors |= worse_between_levels(candidate, law, diagnosis.loops)
    worse = (
        f"on left-out {name} the estimated error rises from {error.law:.2%} to {error.candidate:.2%}"
        for name, error in errors.items()
        if error.rises
    )
    simpler = simpler_words(candidate, diagnosis.candidates, law, diagnosis.tolerance)
    idle = [NO_GAIN] if candidate.akaike >= law.akaike else []
    return [*candidate.objections, *candidate.reservations, *idle, *worse, *simpler]


def candidate_table(diagnosis: Diagnosis) -> Table:
    """Give the candidates, best first."""
    law = diagnosis.law
    judged = [*helpful(diagnosis), *([diagnosis.pair] if diagnosis.pair else [])]
    idle = [candidate.effects[0] for candidate in diagnosis.candidates if candidate not in judged]
    rows: list[tuple[str | float, ...]] = [
        (
            " + ".join(candidate.effects),
            100 * candidate.heldout_nrmse,
            *(100 * error for error in candidate.heldout_by.values()),
            100 * explained_share(candidate, law),
            "; ".join(against(candidate, diagnosis)) or "–",
        )
        for candidate in sorted(judged, key=lambda candidate: candidate.squares)
    ]
    further = (100 * error for error in law.heldout_by.values())
    rows.append(("law as it is", 100 * law.heldout_nrmse, *further, 0.0, "–"))
    header = (
        "with",
        f"error on left-out {left_out_at_once(diagnosis.loops)} / %",
        *(f"on left-out {name} / %" for name in law.heldout_by),
        "takes of missing / %",
        "speaks against it",
    )
    best_first = (
        "the law with each effect, best first by the squared error on left-out tests in units of the noise"
        if judged
        else "no effect of the catalogue helps the law"
    )
    caption = (
        f"{best_first}; the errors are estimates from one fit to all tests: --auto refits without the left-out ones, "
        "and gives other numbers"
    )
    return Table(header, rows, f"{caption}; no help: {', '.join(idle)}" if idle else caption)


def helpful(diagnosis: Diagnosis) -> list[Judged]:
    """Give the candidates that take any of what is missing."""
    return [one for one in diagnosis.candidates if explained_share(one, diagnosis.law) >= LEAST_HELP]


def before_physics(found: RecordDiagnosed) -> list[str]:
    """Say what goes before any physics: sensors that fail or drift, and groups of runs that differ."""
    groups = group_words(found.groups)
    return [*(f"Sensors: {words}." for words in found.sensors()), *(f"Groups: {words}." for words in groups)]


def diagnosis_view(
    found: RecordDiagnosed, ladder: tuple[RungAnswer, ...], next_command: str, drive: Path | None
) -> View:
    """Tell a diagnosis, the ladder before it, and the command to run next; sensors that fail, then its verdict."""
    return View(
        diagnosis_answer(found, ladder, next_command),
        [candidate_table(found.diagnosis)] if found.diagnosis.candidates else [],
        [*before_physics(found), *verdict_lines(found, next_command, drive)],
    )


def next_test_lines(found: Diagnosed, drive: Path | None) -> list[str]:
    """Say which test is next, or why none is proposed, and where its drive signal is."""
    if found.proposal is None:
        lines = [f"No next test: {found.no_test}"] if found.no_test else []
        return [*lines, *([f"{drive} isn't written: no test is proposed"] if drive else [])]
    where = f"{drive} holds its drive signal" if drive else "--drive DRIVE.csv writes its drive signal"
    then = [f"  once it is run, `pipeclamp import` makes {NEXT_TEST} of its records, to be joined"] if drive else []
    return [f"Next test: {found.proposal.words()}", f"  {where}: {found.proposal.drive_words()}", *then]


def verdict_lines(found: Diagnosed, next_command: str, drive: Path | None) -> list[str]:
    """Give the verdict, why, the test that would tell with the file of its drive signal, and what may be run next."""
    return [
        found.headline(),
        *(f"  {word}" for word in found.words()),
        *next_test_lines(found, drive),
        *([f"Next: {next_command}"] if next_command else []),
    ]
