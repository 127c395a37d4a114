"""The shell lines that do what is done in the browser, and the tasks that do it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pipeclamp.studio.project import (
    DIAGNOSIS,
    DISCOVERY,
    DISCOVERY_SHOWN,
    DRIVE,
    ON_PIPE,
    RESPONSE,
    RESPONSE_SHOWN,
    TERM,
    Project,
)
from pipeclamp.studio.work import JobTask
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.shell import quoted, shell_line
from pipeclamp_models.law.file import NamedKind

BASES = {
    "power": "k₁, k₃, c, α as powers of A, f and T (Eq. 17 of Jiang et al. 2020): begin here",
    "memory": "the same with one elastic-slip element (Eq. 14 there)",
    "series": "a series in y and v (Eq. 10 there)",
}


def identify_line(project: Project, law: str, base: str) -> str:
    """Give the line that fits a base law."""
    beside = () if base == "power" else ("--base", base)
    return shell_line("identify", project.campaign, "-o", project.shown(f"{law}.json"), *beside)


def identify_task(project: Project, base: str) -> tuple[JobTask, str]:
    """Give the task that fits a base law, and the law's name."""
    law = project.reserve()
    command = identify_line(project, law, base)
    given = {
        "campaign": project.campaign, "law": project.shown(f"{law}.json"), "base": base, "command": _last_parts(command)
    }  # fmt: skip
    return JobTask("identify", f"Fit the base law {base}", command, given), law


def effects_said(effect: str) -> str:
    """Give an effect as it is said; several, which `add` takes with commas between them, with words."""
    return " and ".join(effect.split(","))


def add_line(project: Project, of: str, effect: str, kind: NamedKind | None, law: str) -> str:
    """Give the line that adds an effect, or several with commas between them, which the diagnosis means so."""
    meant = ("--as", kind) if kind == "part" else ()
    given = project.shown(f"{of}.json"), effect, project.campaign, "-o", project.shown(f"{law}.json")
    return shell_line("add", *given, *meant)


def add_task(project: Project, of: str, effect: str, kind: NamedKind | None) -> tuple[JobTask, str]:
    """Give the task that adds an effect to a law, and the name of the law with it."""
    path, law = str(project.path_of(of)), project.reserve()
    command = add_line(project, of, effect, kind, law)
    given = {
        "campaign": project.campaign, "of": path, "effect": effect, "kind": kind,
        "law": project.shown(f"{law}.json"), "command": _last_parts(command),
    }  # fmt: skip
    return JobTask("add", f"Add {effects_said(effect)} and fit everything again", command, given, of), law


def refit_line(project: Project, of: str, law: str) -> str:
    """Give the line that fits a law with its effects to all tests anew."""
    return shell_line("refit", project.shown(f"{of}.json"), project.campaign, "-o", project.shown(f"{law}.json"))


def refit_task(project: Project, of: str) -> tuple[JobTask, str]:
    """Give the task that fits a law to all tests anew, and the name of the law that comes of it."""
    path, law = str(project.path_of(of)), project.reserve()
    command = refit_line(project, of, law)
    given = {
        "campaign": project.campaign, "of": path, "law": project.shown(f"{law}.json"), "command": _last_parts(command)
    }  # fmt: skip
    return JobTask("refit", f"Fit {of} anew to all tests", command, given, of), law


def diagnose_line(project: Project, law: str, limits: str = "") -> str:
    """Give the line that diagnoses a law; `limits` say what the rig can do."""
    return shell_line("diagnose", project.shown(f"{law}.json"), project.campaign, *_kept(project, law, limits))


def _kept(project: Project, law: str, limits: str) -> list[str]:
    """Give the options by which a diagnosis is kept beside a law."""
    answer, drive = project.shown(f"{law}{DIAGNOSIS}"), project.shown(f"{law}{DRIVE}")
    return ["--json", answer, "--drive", drive, *(("--limits", limits) if limits else ())]


def diagnose_task(project: Project, law: str, limits: str) -> JobTask:
    """Give the task that diagnoses a law.

    Raises:
        UserError: there is no such law.
    """
    given = {"campaign": project.campaign, "law": str(project.path_of(law)), "limits": limits}
    return JobTask("diagnose", f"Find what {law} lacks", diagnose_line(project, law, limits), given, law)


def climb_line(project: Project, of: str, law: str, limits: str = "") -> str:
    """Give the line that adds what a law lacks, again and again."""
    climbed = project.shown(f"{of}.json"), project.campaign, "--auto", project.shown(f"{law}.json")
    return shell_line("diagnose", *climbed, *_kept(project, law, limits))


def climb_task(project: Project, of: str, limits: str) -> tuple[JobTask, str]:
    """Give the task that adds what a law lacks, again and again, and the name of the law that comes of it.

    Raises:
        UserError: there is no such law.
    """
    path, law = str(project.path_of(of)), project.reserve()
    command = climb_line(project, of, law, limits)
    given = {
        "campaign": project.campaign, "of": path, "law": project.shown(f"{law}.json"), "limits": limits,
        "command": _last_parts(command),
    }  # fmt: skip
    return JobTask("climb", f"Add what {of} lacks, until nothing helps", command, given, of), law


def discover_line(project: Project, of: str, law: str) -> str:
    """Give the line that searches a term which no catalogue has."""
    return shell_line(
        "discover", project.shown(f"{of}.json"), project.campaign, "-o", project.shown(f"{of}{TERM}"),
        "--auto", project.shown(f"{law}.json"), "--json", project.shown(f"{of}{DISCOVERY}"),
    )  # fmt: skip


def discover_task(project: Project, of: str) -> tuple[JobTask, str]:
    """Give the task that searches a term for a law, and the name of the law with it, if one is found."""
    path, law = str(project.path_of(of)), project.reserve()
    command = discover_line(project, of, law)
    given = {
        "campaign": project.campaign, "of": path, "law": project.shown(f"{law}.json"),
        "term": project.shown(f"{of}{TERM}"), "answer": project.shown(f"{of}{DISCOVERY}"),
        "shown": project.shown(f"{of}{DISCOVERY_SHOWN}"), "command": _last_parts(command),
    }  # fmt: skip
    return JobTask("discover", f"Search a term that {of} lacks", command, given, of), law


def build_line(project: Project, law: str) -> str:
    """Give the line that builds a law's FMU."""
    return shell_line("build-fmu", project.shown(f"{law}.json"), "-o", project.shown(f"{law}.fmu"), "--track")


def build_task(project: Project, law: str) -> JobTask:
    """Give the task that builds a law's FMU."""
    given = {"law": str(project.path_of(law)), "fmu": project.shown(f"{law}.fmu")}
    return JobTask("build", f"Build the FMU of {law}", build_line(project, law), given, law)


def report_line(project: Project, law: str) -> str:
    """Give the line that writes a law's page."""
    law_file, page = project.shown(f"{law}.json"), project.shown(f"{law}.html")
    return shell_line("compare", law_file, project.campaign, "--report", page)


def report_task(project: Project, law: str) -> JobTask:
    """Give the task that writes a law's page."""
    given = {
        "campaign": project.campaign, "law": str(project.path_of(law)), "page": project.shown(f"{law}.html"),
    }  # fmt: skip
    return JobTask("report", f"Write the page of {law}", report_line(project, law), given, law)


def response_line(project: Project, law: str) -> str:
    """Give the line that finds the response of a pipe with a law's clamp."""
    return shell_line("response", project.shown(f"{law}{ON_PIPE}"), "-o", project.shown(f"{law}{RESPONSE}"))


def response_task(project: Project, law: str, temperatures_C: Sequence[float]) -> JobTask:
    """Give the task that finds the response of a pipe with a law's clamp at temperatures; none where none is known."""
    given = {
        "law": str(project.path_of(law)), "system": project.shown(f"{law}{ON_PIPE}"),
        "output": project.shown(f"{law}{RESPONSE}"), "shown": project.shown(f"{law}{RESPONSE_SHOWN}"),
        "temperatures_C": list(temperatures_C),
    }  # fmt: skip
    return JobTask("respond", f"The pipe with the clamp of {law}", response_line(project, law), given, law)


def import_task(files: Path, folder: Path, stated: Mapping[str, str], *, skip_unusable: bool, dry_run: bool) -> JobTask:
    """Give the task that makes a campaign of uploaded files, or says what it would be.

    Raises:
        UserError: the samples per second are no number.
    """
    options = {name: text for name, text in stated.items() if text}
    flags = [*(("--skip-unusable",) if skip_unusable else ()), *(("--dry-run",) if dry_run else ())]
    words = [word for name, text in options.items() for word in (f"--{name}", text)]
    command = shell_line("import", str(files), "-o", str(folder), *words, *flags)
    given: dict[str, Any] = {
        "files": [str(files)], "folder": str(folder), "skip_unusable": skip_unusable, **options,
    }  # fmt: skip
    if "rate" in options:
        given["rate"] = _rate(options["rate"])
    kind, title = ("look", "Look into the files") if dry_run else ("import", f"Make the campaign {folder.name}")
    return JobTask(kind, title, command, given)


def _rate(text: str) -> float | str:
    if text.strip().casefold() == "none":
        return "none"
    try:
        return float(text)
    except ValueError as error:
        expected = "expected a number, such as 1000, or none where time was not measured"
        raise UserError(f"samples per second: got {text!r}; {expected}") from error


def _last_parts(command: str) -> str:
    """Give a line with paths by their last part, as law files keep it."""
    words = ("".join(found) for found in re.findall(r"\"([^\"]*)\"|'([^']*)'|(\S+)", command))
    return " ".join(quoted(re.split(r"[/\\]", word)[-1] or word) for word in words)
