"""Delimited text of any kind: the same ten runs in every dialect are the same campaign."""

from __future__ import annotations

import gzip

import numpy as np
import polars as pl
import pytest
from exports import assert_same_campaign, loop, ten_runs, text, write_texts

import pipeclamp as pc
from pipeclamp_identification.importing.reading import read_file


def clock(t: float) -> str:
    """Give a stamp that passes midnight after five seconds."""
    day, seconds = (1, 55 + t) if t < 5 else (2, t - 5)
    return f"{day:02d}.02.2024 {'23:59' if day == 1 else '00:00'}:{seconds:06.3f}".replace(".", ",").replace(
        ",02,", ".02."
    )


TABS = {"delimiter": "\t", "decimal": "."}
QUOTED = {"delimiter": ",", "decimal": ".", "quote": '"'}
BLANKS = {"delimiter": "   ", "decimal": ".", "newline": "\r"}
DIALECTS = {
    "german, decimal comma, Latin-1": {
        "names": "Zeit [s];Kolbenweg/µm;Last [kN]", "scales": (1, 1e3, 1e-3), "digits": (6, 3, 7),
        "encoding": "latin-1", "header": "Prüfung Nr. 12;Schelle\nDatum;01.02.2024\n\n",
    },
    "UTF-16 with its mark": {"encoding": "utf-16"},
    "UTF-16 without a mark": {"encoding": "utf-16-le"},
    "UTF-8 with its mark, tabs, foreign units": {
        **TABS, "encoding": "utf-8-sig", "names": "Time (ms)\tLVDT in\tLoad (lbf)",
        "scales": (1e3, 1 / 25.4, 1 / 4.4482216152605), "digits": (3, 8, 8),
    },
    "MTS": {
        **TABS, "header": "MTS793|MPT|ENU|1|2|.|/|:|1|0|0|A\n\nData Header:\tTime:\t12.5\tSec\n",
        "names": "Time\tAxial Displacement\tAxial Force", "units": "Sec\tmm\tkN",
    },
    "Instron, all in quotes": {
        **QUOTED, "names": '"Time","Extension","Load"', "units": '"(s)","(mm)","(kN)"', "header": '"Results Table 1"\n',
    },
    "blanks, no line end but CR": {
        **BLANKS, "names": "# time_s   displacement_mm   force_N", "header": "# made by a logger\n",
        "scales": (1, 1, 1), "digits": (6, 6, 4),
    },
    "stamps of the clock": {"stamp": clock, "names": "Zeitstempel [s];Weg [mm];Kraft [kN]"},
    "CRLF and a footer": {"newline": "\r\n", "footer": "\nEnd of file;;\n"},
}  # fmt: skip


@pytest.mark.parametrize("dialect", DIALECTS)
def test_every_dialect_gives_the_same_campaign(tmp_path, dialect):
    runs = ten_runs()
    folder = write_texts(tmp_path / "exports", runs, **DIALECTS[dialect])
    found = pc.import_files(folder, tmp_path / "campaign", pattern="T{temperature_C}")
    assert not found.notes
    campaign = assert_same_campaign(tmp_path / "campaign", runs)
    assert [run.temperature_C for run in campaign.runs] == [
        run.temperature for run in sorted(runs, key=lambda run: run.name + ".csv")
    ]


def test_text_is_unpacked(tmp_path):
    run = loop()
    path = tmp_path / "a.csv.gz"
    path.write_bytes(gzip.compress(text(run).encode()))
    (table,) = read_file(path).tables
    np.testing.assert_allclose(table.channels[1].values, run.y, atol=1e-6)


def test_blocks_of_numbers_become_tables(tmp_path):
    one, other = loop(0.3), loop(0.9)
    path = tmp_path / "a.csv"
    path.write_text(text(one) + "Block 2;;\nTime [s];Displacement [mm];Force [kN]\n" + text(other, names=""))
    tables = read_file(path).tables
    assert [table.length for table in tables] == [len(one.time), len(other.time)]
    assert tables[1].first_row == tables[0].first_row + len(one.time) + 2


def test_channels_of_one_name_are_told_apart_and_control_characters_taken_out(tmp_path):
    pl.DataFrame({"Load [N]\x1b[31m": [1.0, 2.0]}).write_parquet(tmp_path / "a.parquet")
    assert read_file(tmp_path / "a.parquet").tables[0].channels[0].name == "Load [N] [31m"
    path = tmp_path / "a.csv"
    path.write_text(text(loop(), names="Time [s];Load [N];Load [N]"))
    with pytest.raises(pc.UserError, match=r"2 channels may be the force: 'Load \[N\]', 'Load #2 \[N\]'"):
        pc.import_files(path, tmp_path / "c", rate=200)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"", "is empty"),
        (b"no table at all\nin two lines\n", "holds no table of numbers"),
        (b"a,b,c\n" + b"0,001,1,5,2,5\n" * 30, "3 names above 6 columns"),
        (
            text(loop()).encode() + text(loop(), names="Force [kN];Time [s];Displacement [mm]").encode(),
            "has other columns",
        ),
        (b"\x89PNG\r\n\x1a\n" + bytes(range(256)), "is of no known format"),
        (gzip.compress(text(loop()).encode())[:200], "is no whole delimited text file"),
    ],
)
def test_what_is_no_table_is_told(tmp_path, content, told):
    path = tmp_path / "a.csv"
    path.write_bytes(content)
    with pytest.raises(pc.UserError, match=told):
        read_file(path)
