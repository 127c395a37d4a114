"""What session.json holds: the campaign, and the commands that did what was done."""

from __future__ import annotations

from typing import Final, Literal

from pydantic import BaseModel, ConfigDict, Field

SCHEMA: Final = "pipeclamp-studio-1"


class Kept(BaseModel):
    """A part of the file: unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True, defer_build=True)


class Step(Kept):
    """Something that was done.

    Attributes:
        command: the shell line that does the same.
        law: the law that it made, if any.
        of: the law that it began with, if any.
    """

    command: str
    law: str | None = None
    of: str | None = None


class Session(Kept):
    """How the laws of a folder came about."""

    schema_name: Literal["pipeclamp-studio-1"] = Field(default=SCHEMA, alias="schema")
    campaign: str
    steps: tuple[Step, ...] = ()
