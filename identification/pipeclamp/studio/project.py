"""A campaign's laws on disk: what the studio knows is in files that the commands read, each written whole."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from pydantic import ValidationError

from pipeclamp.studio.session import Session, SessionStep
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import read_text, write_whole
from pipeclamp_models.base.toml_file import explained
from pipeclamp_models.law.file import LawFile, read_law

SESSION = "session.json"
LAW_NAME = re.compile(r"law[1-9]\d{0,3}")
FILE_NAME = re.compile(r"law[1-9]\d{0,3}(\.[a-z_]+)?\.(json|csv|fmu|html|toml)")
"""What may be downloaded: files of this folder that the studio wrote."""
DIAGNOSIS, SHOWN, DRIVE = ".diagnosis.json", ".told.json", ".next_test.csv"
"""Ends of the names of what a diagnosis of a law is kept in: its answer, what is shown of it, the next test's drive."""
TERM, DISCOVERY, DISCOVERY_SHOWN = ".term.toml", ".discovery.json", ".discovery_told.json"
"""Of what a search for a term is kept in: the declaration, the answer, what is shown of it."""
ON_PIPE, RESPONSE, RESPONSE_SHOWN = ".system.toml", ".response.csv", ".response.json"
"""Of a pipe with the law's clamp, of its response, and of what is shown of that."""


class Project:
    """A campaign, the folder of its laws, and how each law came about.

    Attributes:
        campaign: as a command takes it: a folder, or a bundled name.
        folder: where laws and what is made of them are written.
    """

    def __init__(self, campaign: str, folder: Path) -> None:
        """Open the folder, which is made where it isn't there.

        Raises:
            UserError: it can't be made or read, or holds the laws of another campaign.
        """
        self.campaign = campaign
        self.folder = folder
        self._lock = threading.Lock()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            for left in folder.glob(".*.part"):
                left.unlink(missing_ok=True)
        except OSError as error:
            raise UserError(f"{folder}: can't be made ({error.strerror}); expected a folder for laws") from error
        self._session = self._read()
        self._reserved: set[str] = set()
        for step in self._session.begun:  # the studio was killed
            if step.law in self._written():
                self.note(step)
            else:
                self.forget(step)

    def _read(self) -> Session:
        path = self.folder / SESSION
        if not path.exists():
            return Session(campaign=self.campaign)
        try:
            session = Session.model_validate_json(read_text(path, "a session that the studio wrote"))
        except ValidationError as error:
            raise UserError(f"{path}: {explained(error)}; expected a session that the studio wrote") from error
        if Path(session.campaign).name != Path(self.campaign).name:
            raise UserError(
                f"{self.folder}: holds laws of {session.campaign!r}; expected those of {self.campaign!r}, or another "
                "folder by -o"
            )
        return session.model_copy(update={"campaign": self.campaign})

    def laws(self) -> list[str]:
        """Give the names of the laws, in the order in which they were made; without those that are being made.

        A ladder keeps its best law so far under its name: that is another one after each rung.
        """
        return [name for name in self._written() if name not in self._reserved]

    def _written(self) -> list[str]:
        names = [path.stem for path in self.folder.glob("law*.json") if LAW_NAME.fullmatch(path.stem)]
        return sorted(names, key=lambda name: int(name[3:]))

    def path_of(self, name: str) -> Path:
        """Give the file of a law.

        Raises:
            UserError: there is no such law in the folder, or it is being made.
        """
        if name in self._reserved:
            raise UserError(f"{name}: is being made; it can be opened when that is done")
        return self._inside(f"{name}.json") if LAW_NAME.fullmatch(name) else self._missing(name)

    def file_of(self, name: str) -> Path:
        """Give a file of the folder that may be downloaded.

        Raises:
            UserError: it is none that the studio wrote, or leads out of the folder.
        """
        return self._inside(name) if FILE_NAME.fullmatch(name) else self._missing(name)

    def _inside(self, name: str) -> Path:
        path = self.folder / name
        if path.is_symlink() or not path.is_file() or path.resolve().parent != self.folder.resolve():
            self._missing(name)
        return path

    def _missing(self, name: str) -> Path:
        raise UserError(f"{name}: no such file of this studio; expected one of {', '.join(self.laws()) or 'its laws'}")

    def law(self, name: str) -> LawFile:
        """Read a law.

        Raises:
            UserError: there is none of that name, or it isn't a law.
        """
        return read_law(self.path_of(name))

    @property
    def upcoming(self) -> str:
        """The name that the next law will have, where nobody else makes one before."""
        return f"law{max((int(name[3:]) for name in (*self._written(), *self._reserved)), default=0) + 1}"

    def reserve(self) -> str:
        """Give the name of the next law; nobody else is given it until it is released."""
        with self._lock:
            name = self.upcoming
            self._reserved.add(name)
            return name

    def release(self, name: str) -> None:
        """Take back a name that was reserved: the law is there, or won't be made."""
        with self._lock:
            self._reserved.discard(name)

    def shown(self, name: str) -> str:
        """Give a file of the folder as a command line names it."""
        return str(self.folder / name)

    def note(self, step: SessionStep) -> None:
        """Remember what was done."""
        self._change(lambda session: {"steps": (*session.steps, step), "begun": _without(session, step)})

    def begin(self, step: SessionStep) -> None:
        """Remember what is being done, as it will have been done where the studio is killed."""
        self._change(lambda session: {"begun": (*session.begun, step)})

    def forget(self, step: SessionStep) -> None:
        """Forget what was begun: it made no law."""
        self._change(lambda session: {"begun": _without(session, step)})

    def _change(self, changed: Callable[[Session], Mapping[str, tuple[SessionStep, ...]]]) -> None:
        with self._lock:
            session = self._read()
            self._session = session.model_copy(update=changed(session))
            write_whole(self.folder / SESSION, self._session.model_dump_json(indent=1, by_alias=True) + "\n")

    @property
    def steps(self) -> Sequence[SessionStep]:
        """What was done, in order."""
        return self._session.steps

    def parent(self, name: str) -> str | None:
        """Give the law that a law was made from; None of a first one.

        Where the session doesn't tell, as of laws that commands wrote, it is the one with most of its first effects.
        """
        known, laws = {step.law: step.of for step in self.steps if step.law}, self.laws()
        if name in known:
            return known[name] if known[name] in laws else None
        file = self.law(name)
        before = [other for other in laws[: laws.index(name)] if _precedes(self.law(other), file)]
        return max(reversed(before), key=lambda other: len(self.law(other).effects), default=None)


def _without(session: Session, step: SessionStep) -> tuple[SessionStep, ...]:
    """Give what was begun, without what makes this step's law."""
    return tuple(one for one in session.begun if one.law != step.law)


def _precedes(one: LawFile, other: LawFile) -> bool:
    """Tell whether a law has the first effects of another, but not all, on the same base."""
    count = len(one.effects)
    return count < len(other.effects) and (one.base, one.effects) == (other.base, other.effects[:count])
