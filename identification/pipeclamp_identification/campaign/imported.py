"""Where a campaign's records come from, as `pipeclamp import` states it in campaign.toml."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, StrictInt, StrictStr

from pipeclamp_models.base.toml_file import Number, Table

Sha256 = Annotated[StrictStr, Field(pattern=r"^[0-9a-f]{64}$")]
Samples = tuple[Annotated[StrictInt, Field(ge=1)], Annotated[StrictInt, Field(ge=1)]]
"""The first and the last, counted from 1; lines of the file where it is a text."""


class ImportedColumn(Table):
    """A channel of a file that became one of our columns: ours = factor * theirs + offset."""

    channel: StrictStr = Field(description="name and unit, as the file has them")
    unit: StrictStr = Field(default="", description="that counted; empty where none is needed")
    factor: Number = 1.0
    offset: Number = 0.0
    stated: bool = Field(default=False, description="by the user, not by the file's names")


class ImportedFile(Table):
    """A test machine's file."""

    file: StrictStr
    sha256: Sha256
    format: StrictStr
    read_as: StrictStr = Field(default="", description="encoding, delimiter, decimals, header of a text")
    columns: dict[StrictStr, ImportedColumn]


class ImportedRun(Table):
    """A run, the samples that it was cut from, and what was done to them."""

    run: StrictStr
    file: StrictStr
    table: StrictStr = ""
    samples: Samples
    measured: tuple[StrictStr, ...] = Field(default=(), description="columns of runs.csv that nobody stated")
    done: tuple[StrictStr, ...] = ()


class ImportedCut(Table):
    """Samples of a file that are in no run, and why."""

    file: StrictStr
    table: StrictStr = ""
    samples: Samples
    why: StrictStr


class ImportedDelay(Table):
    """A delay of the force behind the displacement that all runs share, as it was found; it is not taken off."""

    delay_ms: Number
    standard_error_ms: Number
    words: StrictStr


class Imported(Table):
    """The table [imported] of campaign.toml."""

    software: StrictStr = ""
    delay: ImportedDelay | None = None
    files: tuple[ImportedFile, ...] = ()
    runs: tuple[ImportedRun, ...] = ()
    cut: tuple[ImportedCut, ...] = ()
