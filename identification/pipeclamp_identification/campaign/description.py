"""campaign.toml: the name of a campaign, what holds for every run, and the names of a test machine's columns."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import tomli_w
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, StrictBool, StrictInt, StrictStr, model_validator

from pipeclamp_identification.units.stated import QUANTITY_OF, Conversion, stated_conversion
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import beside, set_aside
from pipeclamp_models.base.shell import shell_line
from pipeclamp_models.base.toml_file import Number, TomlTable, read_table, unknown

FILE_NAME = "campaign.toml"
UNTIMED = (
    "time was not measured: a cycle counts for a second, so that speeds and frequencies mean nothing, and no effect of "
    "them is asked"
)
"""Said of a campaign that is marked so."""

RecordColumn = Literal["time_s", "displacement_mm", "force_N", "temperature_C"]

Sha256 = Annotated[StrictStr, Field(pattern=r"^[0-9a-f]{64}$")]
Samples = tuple[Annotated[StrictInt, Field(ge=1)], Annotated[StrictInt, Field(ge=1)]]
"""The first and the last, counted from 1; lines of the file where it is a text."""


def _not_zero(value: float) -> float:
    if value == 0.0:
        raise ValueError("expected a factor other than 0")
    return value


def _not_blank(text: str) -> str:
    if not text.strip():
        raise ValueError("expected a text that is not blank")
    return text


Text = Annotated[StrictStr, AfterValidator(_not_blank)]


class ColumnSource(BaseModel):
    """Where one of our record columns comes from in a test machine's export: ours = factor * theirs.

    A unit that the name states counts: "Load [kN]" needs no factor, and takes none that contradicts it.
    """

    model_config = ConfigDict(frozen=True, defer_build=True)

    name: Text = Field(alias="from")
    factor: Annotated[Number, AfterValidator(_not_zero)] | None = None

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            raise ValueError('expected for example { from = "Load [kN]", factor = 1000 }')
        for key in data:
            if key not in ("from", "factor"):
                raise ValueError(unknown(str(key), ["from", "factor"], "key"))
        return data

    def conversion(self, ours: RecordColumn) -> Conversion:
        """Give what turns the channel into one of our columns.

        Raises:
            ValueError: its name states another unit than its factor does, or one of something else.
        """
        return stated_conversion(QUANTITY_OF[ours], self.name, self.factor)


class ColumnSources(TomlTable):
    """The table [columns]; a column that isn't there has our own name."""

    time_s: ColumnSource | None = None
    displacement_mm: ColumnSource | None = None
    force_N: ColumnSource | None = None
    temperature_C: ColumnSource | None = None

    @model_validator(mode="after")
    def _units_agree(self) -> ColumnSources:
        whose: dict[str, str] = {}
        for ours, source in self.given().items():
            if (other := whose.setdefault(source.name.strip(), ours)) != ours:
                raise ValueError(f"channel {source.name!r} is taken for both {other} and {ours}; expected one of them")
            source.conversion(ours)
        return self

    def given(self) -> dict[RecordColumn, ColumnSource]:
        """Return the sources that the table states."""
        pairs: dict[RecordColumn, ColumnSource | None] = {
            "time_s": self.time_s,
            "displacement_mm": self.displacement_mm,
            "force_N": self.force_N,
            "temperature_C": self.temperature_C,
        }
        return {ours: source for ours, source in pairs.items() if source is not None}


class ImportedColumn(TomlTable):
    """A channel of a file that became one of our columns: ours = factor * theirs + offset, integrated over time."""

    channel: StrictStr = Field(description="name and unit, as the file has them")
    unit: StrictStr = Field(default="", description="that counted; empty where none is needed")
    factor: Number = 1.0
    offset: Number = 0.0
    integrated: int = Field(default=0, description="so many times, of a speed or an acceleration")
    stated: bool = Field(default=False, description="by the user, not by the file's names")


class ImportedFile(TomlTable):
    """A test machine's file."""

    file: StrictStr
    sha256: Sha256
    format: StrictStr
    read_as: StrictStr = Field(default="", description="encoding, delimiter, decimals, header of a text")
    columns: dict[StrictStr, ImportedColumn]


class ImportedRun(TomlTable):
    """A run, the samples that it was cut from, and what was done to them."""

    run: StrictStr
    file: StrictStr
    table: StrictStr = ""
    samples: Samples
    measured: tuple[StrictStr, ...] = Field(default=(), description="columns of runs.csv that nobody stated")
    done: tuple[StrictStr, ...] = ()


class ImportedCut(TomlTable):
    """Samples of a file that are in no run, and why."""

    file: StrictStr
    table: StrictStr = ""
    samples: Samples
    why: StrictStr


class LeftOutFile(TomlTable):
    """A file that couldn't be used, was left out as the user said, and why."""

    file: StrictStr
    sha256: Sha256 | None = Field(default=None, description="of its content; not there where it couldn't be read")
    why: StrictStr


class ImportedDelay(TomlTable):
    """A delay of the force behind the displacement that all runs share, as it was found; it is not taken off."""

    delay_ms: Number
    standard_error_ms: Number
    words: StrictStr


class Imported(TomlTable):
    """The table [imported] of campaign.toml."""

    software: StrictStr = ""
    delay: ImportedDelay | None = None
    files: tuple[ImportedFile, ...] = ()
    runs: tuple[ImportedRun, ...] = ()
    cut: tuple[ImportedCut, ...] = ()
    left_out: tuple[LeftOutFile, ...] = ()


class CampaignDescription(TomlTable):
    """campaign.toml as docs/reference/campaign.md describes it."""

    name: Text
    notes: StrictStr = ""
    time_measured: StrictBool = Field(
        default=True,
        description="false: a cycle counts for a second, speeds and frequencies mean nothing",
    )
    defaults: dict[str, Number | StrictStr] = Field(default_factory=dict)
    columns: ColumnSources = ColumnSources()
    imported: Imported | None = None


def read_description(folder: Path) -> CampaignDescription:
    """Read and check the campaign.toml of a campaign's folder.

    Args:
        folder: the campaign's folder.

    Returns:
        What it says.

    Raises:
        UserError: the folder or the file is not there, is no TOML, or has keys or values that a campaign doesn't have.
    """
    if not folder.is_dir():
        found = "is a file" if folder.exists() else "no such folder"
        if set_aside(folder).is_dir():
            raise UserError(
                f"{folder}: an import ended while it replaced this campaign; the next import puts it back as it was "
                f"before, or rename {set_aside(folder).name}, which stands beside it"
            )
        raise UserError(f"{folder}: {found}; expected a campaign's folder with {FILE_NAME} and runs.csv")
    if not (folder / FILE_NAME).exists() and any(folder.iterdir()):
        made = beside(folder, f"{folder.resolve().name}_campaign")
        raise UserError(
            f"{folder}: no {FILE_NAME} in it; expected a campaign's folder. Of a test machine's files this makes one:\n"
            f"  {shell_line('import', str(folder), '-o', str(made))}"
        )
    return read_table(folder / FILE_NAME, CampaignDescription, "the campaign's description with at least its name")


def description_text(name: str, notes: str, *, time_measured: bool = True) -> str:
    """Give the text of a campaign.toml with a name, notes, and the mark of tests without a time."""
    mark = {} if time_measured else {"time_measured": False}
    return tomli_w.dumps({"name": name, "notes": notes, **mark})
