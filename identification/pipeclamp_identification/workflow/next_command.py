"""The command to run after each step of the work."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import PurePath
from typing import TYPE_CHECKING

from pipeclamp_identification.workflow.next_step import NextStep
from pipeclamp_identification.workflow.tests import Diagnosed
from pipeclamp_models.base.shell import shell_line

if TYPE_CHECKING:
    from pipeclamp_identification.discovery.proposal import TermProposal

NEXT_TEST = "next_test"
"""What the next test's drive signal and its campaign are called, where nobody has named them."""
PLANNED = "planned"
"""What the folder of a campaign that is planned is called, where nobody has named it."""


def next_command(
    found: Diagnosed, law: str, tests: str, declared: Mapping[str, str] | None = None, *, driven: bool = False
) -> str:
    """Give the shell line to run next.

    Args:
        found: the diagnosis.
        law, tests: as they are called: a file or a bundled law, a folder or a bundled campaign.
        declared: files of a user's own effects, by id.
        driven: whether the drive signal of the next test has been written, so that the test is what comes next.
    """
    if found.verdict == "missing":
        effects = ",".join((declared or {}).get(name, name) for name in found.together or found.effects)
        meant = ("--as", "part") if found.kind == "part" else ()
        return shell_line("add", law, effects, tests, "-o", _following(law), *meant)
    if found.verdict == "complete" and found.values:
        # what is complete is the law with other values than its file's
        return shell_line("refit", law, tests, "-o", _following(law))
    if found.verdict == "complete":
        return shell_line("build-fmu", law, "-o", f"{stem_of(law)}.fmu", "--track")
    if found.proposal:
        if driven:
            return shell_line("join", tests, NEXT_TEST, "-o", f"{PurePath(tests).name}_and_{NEXT_TEST}")
        return shell_line("diagnose", law, tests, "--drive", f"{NEXT_TEST}.csv")
    if found.calls_for_a_term:
        term = str(PurePath(law).with_name(f"{stem_of(law)}_term.toml"))
        return shell_line("discover", law, tests, "-o", term, "--auto", _following(law))
    return shell_line("compare", law, tests, "--report", "compare.html")


def after_import(tests: str) -> str:
    """Give the shell line to run after an import, or metrics: a law of its tests; arguments as for `next_command`."""
    return shell_line("identify", tests, "-o", "law.json")


def after_group_laws(laws: Sequence[str], tests: str) -> str:
    """Give the shell line to run after a law was fitted to each group: these side by side; as for `next_command`."""
    return shell_line("compare", *laws, tests, "--report", "compare.html")


def after_campaign_plan(folder: str) -> NextStep:
    """Give what comes after a campaign was planned in a folder: its records, and then a law of them."""
    return NextStep(after_import(folder), f"once its records are in {PurePath(folder) / 'runs'}")


def after_identification(law: str, tests: str) -> str:
    """Give the shell line to run after an identification: where the law fails; arguments as for `next_command`."""
    return shell_line("compare", law, tests, "--report", "compare.html")


def after_change(law: str, tests: str) -> str:
    """Give the shell line to run after an effect came or went: what is missing now; arguments as for `next_command`."""
    return shell_line("diagnose", law, tests)


def after_vain_addition(law: str, changed: str, effects: Sequence[str], tests: str) -> str:
    """Give the shell line to run after effects were added that don't help: on from the law before, past them.

    Args:
        law, tests: as for `next_command`.
        changed: the law with the effects; the same file where the law before is there no more.
        effects: what was added.
    """
    if PurePath(changed) == PurePath(law):
        return shell_line("remove", changed, effects[-1], tests, "-o", law)
    return shell_line("diagnose", law, tests, "--auto", _following(law))


def after_discovery(
    proposal: TermProposal,
    law: str,
    tests: str,
    effect: str,
    following: str | None,
    declared: Mapping[str, str] | None = None,
) -> str:
    """Give the shell line to run after a discovery.

    Args:
        proposal: what it came to.
        law, tests, declared: as for `next_command`.
        effect: the declaration's file.
        following: the file for the law with the term, where one is named.
    """
    if proposal.instead:
        return shell_line("add", law, proposal.instead, tests, "-o", following or _following(law), "--as", "part")
    if not proposal.proposed:
        found = proposal.search.diagnosed
        if found.verdict != "unknown":
            return next_command(found, law, tests, declared)
        return shell_line("compare", law, tests, "--report", "compare.html")
    if following:
        return after_change(following, tests)
    if proposal.spare:  # `add` would leave these in the law beside the term
        return shell_line("discover", law, tests, "-o", effect, "--auto", _following(law))
    return shell_line("add", law, effect, tests, "-o", _following(law))


def stem_of(law: str) -> str:
    """Give a law's file without its ending; a bundled law's name as it is."""
    return PurePath(law).stem if law.endswith(".json") else law


def _following(law: str) -> str:
    """Give the name of the file for a law's next version: clamp7_2.json after clamp7.json, clamp7_3.json after that."""
    stem, _, number = stem_of(law).rpartition("_")
    counted = bool(stem) and number.isascii() and number.isdigit()
    name = f"{stem}_{int(number) + 1}" if counted else f"{stem_of(law)}_2"
    return str(PurePath(law).with_name(f"{name}.json"))
