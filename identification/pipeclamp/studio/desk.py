"""What lies on the desk: the campaigns that are open, the folder that everything is written to, the jobs."""

from __future__ import annotations

import re
import threading
from dataclasses import dataclass
from pathlib import Path

from pipeclamp.studio import uploads
from pipeclamp.studio.bench import Bench, read_bench
from pipeclamp.studio.jobs import Job, Jobs
from pipeclamp.studio.project import Project
from pipeclamp.studio.session import SessionStep
from pipeclamp.studio.work import JobTask
from pipeclamp_identification.campaign.bundled import bundled_campaigns
from pipeclamp_identification.workflow.on_metrics import MetricTests
from pipeclamp_models.base.errors import UserError

HOME = "pipeclamp_studio"
"""The studio's folder, where no campaign is named."""


@dataclass(frozen=True)
class OpenedMetrics:
    """A campaign of metrics without records that is open: its name in addresses, as a command takes it, its tests."""

    key: str
    campaign: str
    tests: MetricTests


@dataclass(frozen=True)
class Opened:
    """A campaign of records that is open.

    Attributes:
        key: its name in addresses.
        project: its laws.
        bench: its tests.
    """

    key: str
    project: Project
    bench: Bench


class Desk:
    """All that is open.

    Attributes:
        home: the folder that everything is written to.
        first: key of the campaign that the studio was started with; empty where none was named.
        jobs: of all campaigns.
    """

    def __init__(self, home: Path, campaign: str = "") -> None:
        """Open a campaign, where one is named.

        Raises:
            UserError: it can't be read, or the folder can't be made or holds the laws of another campaign.
        """
        self.home = home
        uploads.clear_abandoned(home)
        self.jobs = Jobs()
        self._opened: dict[str, Opened | OpenedMetrics] = {}
        self._lock = threading.Lock()
        self.first = ""
        if campaign:
            self.first = key_of(campaign)
            self._opened[self.first] = _opened(self.first, campaign, home)

    def choices(self) -> tuple[list[str], list[str]]:
        """Give the campaigns that can be opened: imported ones, and those that come with the program."""
        imported = sorted(
            path.parent.name for path in self.home.glob("*/campaign.toml") if not path.parent.is_symlink()
        )
        return imported, list(bundled_campaigns())

    def open_records(self, key: str) -> Opened:
        """Open a campaign of records as `open` does.

        Raises:
            UserError: it holds metrics without records.
        """
        found = self.open(key)
        if isinstance(found, OpenedMetrics):
            raise UserError(
                f"{key}: holds metrics without records; the studio shows them, and has no loops to fit laws to: the "
                "commands on its page do"
            )
        return found

    def open(self, key: str) -> Opened | OpenedMetrics:
        """Open a campaign of the studio's folder or a bundled one, or give it where it is open.

        Raises:
            UserError: there is none of that name, or it can't be read.
        """
        with self._lock:
            found = self._opened.get(key)
            if found is None:
                imported, bundled = self.choices()
                if key not in (*imported, *bundled):
                    raise UserError(
                        f"{key!r}: no campaign of this studio; expected one of {', '.join(imported + bundled)}"
                    )
                campaign = str(self.home / key) if key in imported else key
                found = self._opened[key] = _opened(key, campaign, self.home / f"{key}_laws")
            return found

    def forget(self, key: str) -> None:
        """Read a campaign anew when it is opened next: files have joined it."""
        with self._lock:
            if key != self.first:
                self._opened.pop(key, None)

    def start(self, opened: Opened, task: JobTask, law: str | None = None) -> Job:
        """Start a task; what it makes is noted in the campaign's session."""

        def noted(job: Job) -> None:
            made = law if job.result.get("law") else None
            opened.project.note(SessionStep(command=task.command, law=made, of=task.law))

        # a ladder keeps its best law on the way
        begun = SessionStep(command=task.command, law=law, of=task.law, stopped=task.kind == "climb")

        def over(job: Job | None) -> None:
            if law is None:
                return
            opened.project.release(law)
            if job and job.stopped and law in opened.project.laws():
                opened.project.note(begun)
                job.says, job.result = f"stopped; {law} holds what was added until then", {"law": law}
            elif not (job and job.result.get("law")):
                opened.project.forget(begun)

        if law is not None:
            opened.project.begin(begun)
        return self.jobs.start(opened.key, task, noted, over)


def key_of(campaign: str) -> str:
    """Give the name that a campaign has in addresses."""
    return re.sub(r"[^\w.-]", "_", Path(campaign).resolve().name, flags=re.ASCII) or "campaign"


def default_home(campaign: str) -> Path:
    """Give the folder that is written to, where none is named: beside where the command was called."""
    return Path(f"{Path(campaign).resolve().name}_studio" if campaign else HOME)


def _opened(key: str, campaign: str, folder: Path) -> Opened | OpenedMetrics:
    """Read a campaign; the folder is that of its laws.

    Raises:
        UserError: it can't be read, or the folder can't be made or holds the laws of another campaign.
    """
    tests = read_bench(campaign)
    if isinstance(tests, MetricTests):
        return OpenedMetrics(key, campaign, tests)
    return Opened(key, Project(campaign, folder), tests)
