"""What session.json holds: the campaign, and the commands that did what was done."""

from __future__ import annotations

from typing import Final, Literal

from pydantic import BaseModel, ConfigDict, Field

SCHEMA: Final = "pipeclamp-studio-1"


class Kept(BaseModel):
    """A part of the file: unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True, defer_build=True)


class SessionStep(Kept):
    """Something that was done.

    Attributes:
        command: the shell line that does the same.
        law: the law that it made, if any.
        of: the law that it began with, if any.
        stopped: whether it was stopped on the way, so that the law is what it had come to.
    """

    command: str
    law: str | None = None
    of: str | None = None
    stopped: bool = False

    def shell_lines(self) -> str:
        """Give it as lines for a shell; of what was stopped, with a remark before it."""
        remark = f"# stopped on the way: {self.law} holds what had been added until then\n" if self.stopped else ""
        return remark + self.command


class Session(Kept):
    """How the laws of a folder came about.

    Attributes:
        campaign: as a command takes it.
        steps: what was done, in order.
        begun: what makes a law and isn't done: what will have been done where the studio is killed.
    """

    schema_name: Literal["pipeclamp-studio-1"] = Field(default=SCHEMA, alias="schema")
    campaign: str
    steps: tuple[SessionStep, ...] = ()
    begun: tuple[SessionStep, ...] = ()
