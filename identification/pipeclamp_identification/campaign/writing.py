"""Campaigns written in the layout of docs/reference/campaign.md: the virtual rig's, and several joined into one."""

from __future__ import annotations

import gzip
import hashlib
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from pipeclamp_identification.campaign.description import description_text
from pipeclamp_identification.campaign.free_motion import FreeRun
from pipeclamp_identification.campaign.reading import Campaign, Run
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.runs_table import MEANS
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import PLAIN_FILE_NAME, untaken, write_folder
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.base.tables import pl


@dataclass(frozen=True)
class WrittenRun:
    """One run as it is written: its row in runs.csv and its record."""

    row: Mapping[str, str | float | None]
    record: Record


Format = Literal["csv", "csv.gz", "parquet"]


def campaign_files(
    name: str,
    notes: str,
    runs: Iterator[WrittenRun],
    format: Format = "csv",
    progress: Progress = silent,
    *,
    time_measured: bool = True,
) -> Iterator[tuple[str, bytes]]:
    """Give the files of a campaign in the layout of docs/reference/campaign.md as (path inside the folder, content)."""
    rows = []
    taken: set[str] = set()
    for number, run in enumerate(runs, 1):
        run_name = str(run.row["run"])
        stem = untaken(run_name if PLAIN_FILE_NAME.fullmatch(run_name) else f"{number:04d}", taken)
        file = f"runs/{stem}.{format}"
        rows.append({"run": run_name, "file": file, **{k: value for k, value in run.row.items() if k != "run"}})
        samples = run.record.channels
        yield file, encoded(pl.DataFrame(samples), format)
        progress(run_name)
    yield "runs.csv", encoded(pl.DataFrame(rows, infer_schema_length=None), "csv")
    yield "campaign.toml", description_text(name, notes, time_measured=time_measured).encode()


def encoded(table: pl.DataFrame, format: Format) -> bytes:
    """Give the bytes of a table's file.

    Raises:
        UserError: no record is read in such a format.
    """
    if format not in get_args(Format):
        raise UserError(f"--format: got {format!r}; expected {', '.join(get_args(Format))}")
    stream = BytesIO()
    if format == "parquet":
        # zstd makes files a third smaller, and takes three times as long to write and twice to read
        table.write_parquet(stream, compression="lz4")
        return stream.getvalue()
    table.write_csv(stream, float_precision=None)
    content = stream.getvalue()
    return gzip.compress(content, mtime=0) if format == "csv.gz" else content


def write_campaign(
    folder: Path,
    runs: Iterator[WrittenRun],
    *,
    name: str,
    notes: str,
    format: Format = "csv",
    progress: Progress = silent,
    time_measured: bool = True,
) -> int:
    """Write a campaign into a new folder; it appears whole or not at all.

    Returns:
        the number of runs.

    Raises:
        UserError: the folder exists, or its parent can't be written.
    """
    files = campaign_files(name, notes, runs, format, progress, time_measured=time_measured)
    return sum(file.startswith("runs/") for file in write_folder(folder, files))


def _digest(record: Record) -> str:
    """Give the SHA-256 over a record's samples."""
    channels = record.channels.values()
    return hashlib.sha256(b"".join(np.ascontiguousarray(values).tobytes() for values in channels)).hexdigest()


def joined_runs(campaigns: Sequence[Campaign]) -> Iterator[WrittenRun]:
    """Give the runs of several campaigns of one clamp, one after the other; a name that is taken gets a number.

    Raises:
        UserError: a further condition isn't known in all of them, or a record is there twice.
    """
    columns = campaigns[0].condition_columns
    whose: dict[str, str] = {}
    taken: set[str] = set()
    free = any(campaign.free for campaign in campaigns)
    words = {known: word for word, known in MEANS.items()}
    means_known = all(run.mean_known for one in campaigns for runs in (one.runs, one.free) for run in runs)
    for campaign in campaigns:
        if campaign.time_measured is not campaigns[0].time_measured:
            without = next(one.name for one in campaigns if not one.time_measured)
            raise UserError(
                f"join: the time of {without} was not measured, that of others was, and a law of both would take "
                "cycles for seconds; expected only tests with a time, or only such without"
            )
        if set(campaign.condition_columns) != set(columns):
            raise UserError(
                f"join: {campaign.name} has the further columns {', '.join(campaign.condition_columns) or 'none'}, "
                f"{campaigns[0].name} has {', '.join(columns) or 'none'}; expected the same, filled in in runs.csv"
            )
        every: tuple[Run | FreeRun, ...] = (*campaign.runs, *campaign.free)
        for run in every:
            own = f"run {run.name!r} of {campaign.name}"
            if (other := whose.setdefault(_digest(run.record), own)) is not own:
                raise UserError(
                    f"join: {own} has the same record as {other}; one measurement counts once, or the law would seem "
                    "better known than it is: leave one out"
                )
            names = (run.name, *(f"{run.name}_{number}" for number in range(2, len(taken) + 3)))
            name = next(name for name in names if name not in taken)
            taken.add(name)
            row = {
                "run": name,
                **({"motion": "free" if isinstance(run, FreeRun) else "sine"} if free else {}),
                "amplitude_mm": None if isinstance(run, FreeRun) else run.amplitude_mm,
                "frequency_Hz": None if isinstance(run, FreeRun) else run.frequency_Hz,
                "temperature_C": run.setup.temperature_C,
                "specimen": run.setup.specimen,
                **run.setup.labels,
                "density_g_cm3": run.setup.density_g_cm3,
                **{column: None if math.isnan(value := run.setup.conditions[column]) else value for column in columns},
                "first_cycle": run.setup.first_cycle,
                **({} if means_known else {"mean_force": words[run.mean_known]}),
            }
            yield WrittenRun(row, run.record)
