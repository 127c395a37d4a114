"""The command to run after each step of the work."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import PurePath

from pipeclamp_identification.comparison.compare import Comparison
from pipeclamp_identification.diagnosis.limits import limits_words
from pipeclamp_identification.workflow.along_free import along_free
from pipeclamp_identification.workflow.tests import Diagnosed, Held

NEXT_TEST = "next_test"
"""What the next test's drive signal and its campaign are called, where nobody has named them."""
PLANNED = "planned"
"""Likewise the folder of a campaign that is planned."""


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
    if found.verdict == "complete":
        return shell_line("build-fmu", law, "-o", f"{_stem(law)}.fmu", "--track")
    if found.proposal:
        if driven:
            return shell_line("join", tests, NEXT_TEST, "-o", f"{PurePath(tests).name}_and_{NEXT_TEST}")
        return shell_line("diagnose", law, tests, "--drive", f"{NEXT_TEST}.csv")
    if found.calls_for_a_term:
        term = str(PurePath(law).with_name(f"{_stem(law)}_term.toml"))
        return shell_line("discover", law, tests, "-o", term, "--auto", _following(law))
    return shell_line("compare", law, tests, "--report", "compare.html")


def after_import(tests: str) -> str:
    """Give the shell line to run after an import: a law of its tests; arguments as for `next_command`."""
    return shell_line("identify", tests, "-o", "law.json")


def after_identification(law: str, tests: str) -> str:
    """Give the shell line to run after an identification: where the law fails; arguments as for `next_command`."""
    return shell_line("compare", law, tests, "--report", "compare.html")


def after_change(law: str, tests: str) -> str:
    """Give the shell line to run after an effect came or went: what is missing now; arguments as for `next_command`."""
    return shell_line("diagnose", law, tests)


def after_comparison(law: str, tests: str, held: Held) -> str:
    """Give the shell line to run after a comparison: what is missing, if anything, or the tests that would tell.

    Args:
        law, tests: as for `next_command`.
        held: the law against the tests. A diagnosis asks for loops: free motions alone call for the clamp's FMU where
            scatter explains what the law errs along them, else for a campaign of sines that reaches as far as they do.
    """
    if not isinstance(held, Comparison) or held.runs:
        return shell_line("diagnose", law, tests, "--report", "diagnosis.html")
    found = along_free(held.free)
    if found.scatter_explains:
        return shell_line("build-fmu", law, "-o", f"{_stem(law)}.fmu", "--track")
    return shell_line("plan", "-o", PLANNED, "--law", law, "--limits", limits_words(found.reach))


def after_discovery(
    proposed: bool,
    found: Diagnosed,
    law: str,
    tests: str,
    effect: str,
    following: str | None,
    declared: Mapping[str, str] | None = None,
    *,
    instead: bool = False,
) -> str:
    """Give the shell line to run after a discovery.

    Args:
        proposed: whether a term was.
        found: the diagnosis that the search began with.
        law, tests, declared: as for `next_command`.
        effect: the declaration's file.
        following: the law with the term, where it was written.
        instead: whether effects of the law go for the term, which `add` would leave there.
    """
    if not proposed and found.verdict != "unknown":
        return next_command(found, law, tests, declared)
    if not proposed:
        return shell_line("compare", law, tests, "--report", "compare.html")
    if following:
        return shell_line("diagnose", following, tests)
    if instead:
        return shell_line("discover", law, tests, "-o", effect, "--auto", _following(law))
    return shell_line("add", law, effect, tests, "-o", _following(law))


def shell_line(*words: str) -> str:
    """Join the words of a pipeclamp command; double quotes are understood by the shells of Windows too."""
    return " ".join(["pipeclamp", *(f'"{word}"' if re.search(r"\s", word) else word for word in words)])


def _stem(law: str) -> str:
    return PurePath(law).stem if law.endswith(".json") else law


def _following(law: str) -> str:
    """Give the name of the file for a law's next version: clamp7_2.json after clamp7.json, clamp7_3.json after that."""
    stem, _, number = _stem(law).rpartition("_")
    counted = bool(stem) and number.isascii() and number.isdigit()
    name = f"{stem}_{int(number) + 1}" if counted else f"{_stem(law)}_2"
    return str(PurePath(law).with_name(f"{name}.json"))
