"""runs.csv: one row per run, what was set, and where its record is or what its loop's metrics are."""

from __future__ import annotations

import csv
import difflib
import io
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from pathlib import Path, PurePosixPath, PureWindowsPath
from types import MappingProxyType

from pipeclamp_identification.campaign.description import FILE_NAME as DESCRIPTION
from pipeclamp_identification.campaign.description import CampaignDescription
from pipeclamp_models.base.errors import UserError, did_you_mean
from pipeclamp_models.base.files import read_text
from pipeclamp_models.base.units import CELSIUS

FILE_NAME = "runs.csv"
MOST_COLUMNS = 500
"""More conditions and labels than anybody has of a test."""
RECORD_ENDINGS = (".csv", ".csv.gz", ".parquet")
MEASURED_DIGITS = 3
"""Decimals of a mean temperature, degC."""


TEXT_COLUMNS = ("run", "file", "specimen", "motion", "mean_force")
MOTIONS = ("sine", "free")
"""What a run's displacement follows: a sine, which is usual, or anything that begins at rest."""
MEANS = MappingProxyType({"known": True, "unknown": False})
"""Whether a record's mean force counts: a piezoelectric cell has none, and one that was set to zero a wrong one."""
OF_SINES = ("amplitude_mm", "frequency_Hz")
"""Numbers that a free motion doesn't have."""
NUMBER_COLUMNS = MappingProxyType(
    {
        "amplitude_mm": "above 0 mm",
        "frequency_Hz": "above 0 Hz",
        "temperature_C": f"above {-CELSIUS} °C",
        "density_g_cm3": "above 0 g/cm³",
        "first_cycle": "0 or more cycles",
    }
)
"""Each number that a run states, with the bound that it must exceed (or may equal, for a count)."""
UNIT_WORDS = frozenset(
    (
        *("c", "k", "f", "deg", "degc", "degf", "celsius", "kelvin", "m", "mm", "um", "in", "hz", "khz", "rpm", "rad"),
        *("s", "g", "kg", "lb", "m3", "cm3", "mm3", "in3", "ft3"),
    )
)
"""Words of units in which the known quantities are given elsewhere."""
SPELLED, ABBREVIATED = 7, 4
"""Letters from which on a word may be one of ours, misspelled; and those of an abbreviation."""
METRIC_COLUMNS = MappingProxyType(
    {
        "dissipated_energy_J": "above 0 J",
        "max_elastic_energy_J": "above 0 J",
        "loss_factor": "above 0",
        "stiffness_N_mm": "above 0 N/mm",
        "storage_stiffness_N_mm": "above 0 N/mm",
        "loss_stiffness_N_mm": "above 0 N/mm",
    }
)
"""The metrics of a loop that stand for its record where there is none, with the bound that each must exceed."""


@dataclass(frozen=True)
class Printed:
    """A number as it was printed, with the standard deviation that rounding to its digits makes."""

    value: float
    rounding: float


@dataclass(frozen=True)
class Setup:
    """What was tested and under which conditions, the motion aside.

    Attributes:
        specimen: its label; None where it has none.
        temperature_C: of the specimen, as stated, or else as its record measured it; None where it isn't known.
        density_g_cm3: of its wire mesh; None where it isn't known.
        first_cycle: load cycles that it had seen before.
        conditions: further numbers, by column of runs.csv; nan where one isn't known.
        labels: further texts (operator, valve), by column of runs.csv; blank where there is none.
    """

    specimen: str | None = None
    temperature_C: float | None = None
    density_g_cm3: float | None = None
    first_cycle: float = 0.0
    conditions: Mapping[str, float] = field(default_factory=dict)
    labels: Mapping[str, str] = field(default_factory=dict)

    @property
    def kelvin(self) -> float:
        """Temperature in K, nan where it isn't known."""
        return math.nan if self.temperature_C is None else self.temperature_C + CELSIUS

    @property
    def density(self) -> float:
        """Density in g/cm³, nan where it isn't known."""
        return math.nan if self.density_g_cm3 is None else self.density_g_cm3

    def measured_at(self, temperature_C: float) -> Setup:
        """Give the same with a temperature that the record measured, degC, where none is stated; nan: none either."""
        if self.temperature_C is not None or math.isnan(temperature_C):
            return self
        return replace(self, temperature_C=round(temperature_C, MEASURED_DIGITS))

    @property
    def texts(self) -> dict[str, str]:
        """Texts that may group runs, by column of runs.csv, the specimen among them; blank where there is none."""
        return {"specimen": self.specimen or "", **self.labels}


@dataclass(frozen=True)
class RunRow:
    """One row of runs.csv, [defaults] filled in.

    Attributes:
        row: its number in the file.
        run: the run's name.
        file: of its record, relative to the campaign's folder; blank where the metrics of its loop stand for that.
        amplitude_mm, frequency_Hz: as stated; None where not.
        setup: the conditions of the test.
        metrics: of its loop, by column, where there is no record.
        free: whether its motion is no sine.
        mean_known: whether the mean of its force counts; None where that isn't stated.
    """

    row: int
    run: str
    file: str
    amplitude_mm: float | None
    frequency_Hz: float | None
    setup: Setup
    metrics: Mapping[str, Printed]
    free: bool = False
    mean_known: bool | None = None


@dataclass(frozen=True)
class RunsTable:
    """runs.csv as a whole: its rows and the names of its further conditions."""

    rows: tuple[RunRow, ...]
    condition_columns: tuple[str, ...]

    @property
    def without_records(self) -> bool:
        """Whether it tells of loops by their metrics alone."""
        return not self.rows[0].file


def read_runs_table(folder: Path, description: CampaignDescription) -> RunsTable:
    """Read and check the runs.csv of a campaign's folder.

    A blank cell takes the value of [defaults]; without one it is not known. A further column is a test
    condition where all its cells are numbers, and a label, which may group runs, where none is.

    Args:
        folder: the campaign's folder.
        description: its campaign.toml.

    Returns:
        The rows, in the file's order.

    Raises:
        UserError: the file is missing, or a row or column of it is not as docs/reference/campaign.md says.
    """
    path = folder / FILE_NAME
    lines = _read_cells(path)
    header = _checked_header(path, lines[0][1])
    _refuse_near_misses(path, header, description)
    cells = [(row, _with_defaults(header, values, description)) for row, values in lines[1:]]
    if not cells:
        raise UserError(f"{path}: has no row under its header; expected one row per run")
    without_records = _without_records(path, cells)
    if without_records:
        _refuse_near_misses_of_metrics(path, header)
    condition_columns = _condition_columns(path, cells)
    rows = tuple(_run_row(path, row, named, condition_columns, without_records) for row, named in cells)
    _refuse_repeats(path, rows)
    return RunsTable(rows, condition_columns)


def _read_cells(path: Path) -> list[tuple[int, list[str]]]:
    text = read_text(path, "the campaign's table, one row per run")
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        lines = [(reader.line_num, [cell.strip() for cell in row]) for row in reader if any(map(str.strip, row))]
    except csv.Error as error:
        raise UserError(f"{path}, row {reader.line_num}: is no valid CSV: {error}") from error
    if not lines:
        raise UserError(f"{path}: is empty; expected a header row with at least: run,file")
    width = len(lines[0][1])
    for row, values in lines[1:]:
        if len(values) != width:
            raise UserError(
                f"{path}, row {row}: has {len(values)} cells; expected {width} as in the header; "
                "separate cells by commas and write decimals with a point"
            )
    return lines


def _checked_header(path: Path, header: list[str]) -> list[str]:
    if len(header) > MOST_COLUMNS:
        raise UserError(f"{path}, row 1: has {len(header)} columns; expected {MOST_COLUMNS} at most")
    for column in header:
        if not column:
            raise UserError(f"{path}, row 1: column {header.index(column) + 1} has no name; expected one")
        if header.count(column) > 1:
            raise UserError(f"{path}, row 1: column {column!r} stands there more than once; expected it once")
    return header


def _refuse_near_misses(path: Path, header: list[str], description: CampaignDescription) -> None:
    """Refuse a column that means one of ours in another unit or spelling: as a further condition it would go unused."""
    defaults = f"{path.with_name(DESCRIPTION)}, [defaults]"
    for where, columns in ((str(path), header), (defaults, description.defaults)):
        for column in columns:
            meant = meant_column(column)
            if meant is not None:
                raise UserError(f"{where}: column {column!r} is not known; expected {meant!r}; convert and rename it")


def meant_column(column: str) -> str | None:
    """Give the known column that a name probably means in another unit or spelling; None for one that stands by itself.

    The quantity comes first in a name. What follows it must be a unit or a single word, as in "density_gcm3" or
    "temperature (K)": "temperature_oil_C" is a quantity of its own.
    """
    known = (*TEXT_COLUMNS, *NUMBER_COLUMNS)
    if column in known:
        return None
    quantity, *rest = re.findall(r"[^\W_]+", column.lower()) or [""]
    if len(rest) > 1 and not UNIT_WORDS.issuperset(rest):
        return None
    spelled = {re.sub("_", "", name).lower(): name for name in known}
    if (letters := re.sub(r"[\W_]", "", column.lower())) in spelled:
        return spelled[letters]
    # run and file are needed: where they go by another name, that is an error of its own; a motion may have a name,
    # and anything a mean
    apart = ("run", "file", "motion", "mean_force")
    stems = {name.lower().split("_")[0]: name for name in known if name not in apart}
    if quantity in stems:
        return stems[quantity]
    long = [stem for stem in stems if len(stem) >= SPELLED]
    begun = [stem for stem in long if len(quantity) >= ABBREVIATED and stem.startswith(quantity)]
    near = begun or difflib.get_close_matches(quantity, long, n=1, cutoff=0.85)
    return stems[near[0]] if near else None


def _without_records(path: Path, cells: list[tuple[int, dict[str, str]]]) -> bool:
    """Tell whether no row has a record and metrics stand in their place; a mix of both is refused."""
    with_record = [row for row, named in cells if named.get("file")]
    if len(with_record) == len(cells) or not any(column in cells[0][1] for column in METRIC_COLUMNS):
        return False
    if with_record:
        blank = next(row for row, named in cells if not named["file"])
        raise UserError(
            f"{path}, row {blank}, column 'file': is blank, but row {with_record[0]} has a record; expected records "
            "for all runs, or metrics for all and no record: split the campaign, or turn its records into metrics with "
            "pipeclamp metrics -o"
        )
    return True


def _refuse_near_misses_of_metrics(path: Path, header: list[str]) -> None:
    """Refuse a metric in another unit, which would go for a further condition."""
    for metric in METRIC_COLUMNS:
        quantity = re.sub(r"_(J|N_mm)$", "", metric)
        for column in header:
            if column.lower().startswith(quantity) and column not in METRIC_COLUMNS:
                raise UserError(f"{path}: column {column!r} is not known; expected {metric!r}; convert and rename it")


def _with_defaults(header: list[str], values: list[str], description: CampaignDescription) -> dict[str, str]:
    defaults = description.defaults
    named = dict.fromkeys(defaults, "") | dict(zip(header, values, strict=True))
    free = (named.get("motion") or defaults.get("motion")) == "free"
    usual = {column: value for column, value in defaults.items() if not (free and column in OF_SINES)}
    return {column: cell or str(usual.get(column, "")) for column, cell in named.items()}


def _number(cell: str) -> float | None:
    try:
        value = float(cell)
    except ValueError:
        return None
    return value if math.isfinite(value) and "_" not in cell else None


def _condition_columns(path: Path, cells: list[tuple[int, dict[str, str]]]) -> tuple[str, ...]:
    known = (*TEXT_COLUMNS, *NUMBER_COLUMNS, *METRIC_COLUMNS)
    further = [column for column in cells[0][1] if column not in known]
    conditions = []
    for column in further:
        filled = [(row, named[column]) for row, named in cells if named[column]]
        texts = [(row, cell) for row, cell in filled if _number(cell) is None]
        if texts and len(texts) < len(filled):
            row, cell = texts[0]
            raise UserError(
                f"{path}, row {row}, column {column!r}: got {cell!r}; expected a finite number as in other rows; "
                "leave the cell blank where it isn't known"
            )
        if filled and not texts:
            conditions.append(column)
    return tuple(conditions)


def _run_row(
    path: Path, row: int, named: dict[str, str], condition_columns: tuple[str, ...], without_record: bool
) -> RunRow:
    for column in ("run",) if without_record else ("run", "file"):
        if column not in named:
            raise UserError(
                f"{path}, row 1: has no column {column!r}; expected at least the columns run,file, or, for loops "
                "without records, run,dissipated_energy_J,max_elastic_energy_J"
            )
        if not named[column]:
            raise UserError(f"{path}, row {row}, column {column!r}: is blank; expected a text")
    known = (*TEXT_COLUMNS, *NUMBER_COLUMNS, *METRIC_COLUMNS)
    numbers = {column: _checked_number(path, row, column, named.get(column, "")) for column in NUMBER_COLUMNS}
    free = _is_free(path, row, named, without_record)
    return RunRow(
        row=row,
        run=named["run"],
        file="" if without_record else _checked_file(path, row, named["file"]),
        amplitude_mm=numbers["amplitude_mm"],
        frequency_Hz=numbers["frequency_Hz"],
        setup=Setup(
            specimen=named.get("specimen") or None,
            temperature_C=numbers["temperature_C"],
            density_g_cm3=numbers["density_g_cm3"],
            first_cycle=numbers["first_cycle"] or 0.0,
            conditions={c: float(named[c]) if named[c] else math.nan for c in condition_columns},
            labels={c: cell for c, cell in named.items() if c not in known and c not in condition_columns},
        ),
        metrics=_metrics(path, row, named) if without_record else {},
        free=free,
        mean_known=MEANS.get(_word(path, row, named, "mean_force", tuple(MEANS), "where the runs tell")),
    )


def _word(path: Path, row: int, named: Mapping[str, str], column: str, words: Sequence[str], blank: str) -> str:
    """Give what a row says in a column, one of a few words, or nothing; `blank` says what that means."""
    cell = named.get(column, "")
    if cell and cell not in words:
        raise UserError(
            f"{path}, row {row}, column {column!r}: got {cell!r}; {did_you_mean(cell, words)}expected one of "
            f"{', '.join(words)}, or a blank cell {blank}"
        )
    return cell


def _is_free(path: Path, row: int, named: Mapping[str, str], without_record: bool) -> bool:
    """Tell whether a row's motion is free; one that then states a sine, or has no record, is refused."""
    if _word(path, row, named, "motion", MOTIONS, "for a sine") != "free":
        return False
    if without_record:
        raise UserError(
            f"{path}, row {row}, column 'motion': got 'free' without a record; expected one: metrics are of loops"
        )
    for column in OF_SINES:
        if named.get(column):
            raise UserError(
                f"{path}, row {row}, column {column!r}: got {named[column]!r} beside motion 'free', which has none; "
                "expected a blank cell, or motion 'sine'"
            )
    return True


def _metrics(path: Path, row: int, named: Mapping[str, str]) -> dict[str, Printed]:
    """Give the metrics that a row states; blank cells are left out."""
    metrics = {}
    for column, bound in METRIC_COLUMNS.items():
        if cell := named.get(column, ""):
            value = _number(cell)
            if value is None or value <= 0:
                raise UserError(
                    f"{path}, row {row}, column {column!r}: got {cell!r}; expected a finite number {bound}; "
                    "leave the cell blank where it isn't known"
                )
            exponent = Decimal(cell).as_tuple().exponent
            metrics[column] = Printed(value, 10.0 ** int(exponent) / math.sqrt(12))
    return metrics


def _checked_number(path: Path, row: int, column: str, cell: str) -> float | None:
    if not cell:
        return None
    value = _number(cell)
    lowest = -CELSIUS if column == "temperature_C" else 0.0
    if value is None or value < lowest or (value == lowest and column != "first_cycle"):
        raise UserError(
            f"{path}, row {row}, column {column!r}: got {cell!r}; expected a finite number {NUMBER_COLUMNS[column]}; "
            "leave the cell blank where it isn't known"
        )
    return value


def _checked_file(path: Path, row: int, cell: str) -> str:
    """Return the record's path in POSIX form, so that a table written on Windows serves elsewhere."""
    where = f"{path}, row {row}, column 'file': got {cell!r}"
    windows = PureWindowsPath(cell)
    posix = PurePosixPath(windows.as_posix())
    if windows.drive or windows.root or ".." in posix.parts:
        raise UserError(f"{where}; expected a path inside the campaign's folder, relative to it")
    if not posix.name.lower().endswith(RECORD_ENDINGS):
        raise UserError(f"{where}; expected a file name that ends in {', '.join(RECORD_ENDINGS)}")
    return posix.as_posix()


def _refuse_repeats(path: Path, rows: tuple[RunRow, ...]) -> None:
    for column in ("run", "file"):
        seen: dict[str, int] = {}
        for row in rows:
            if column == "file" and not row.file:
                continue
            cell = str(getattr(row, column))
            if cell in seen:
                raise UserError(
                    f"{path}, row {row.row}, column {column!r}: got {cell!r}, which row {seen[cell]} has already; "
                    "expected each run once, with a record of its own"
                )
            seen[cell] = row.row
