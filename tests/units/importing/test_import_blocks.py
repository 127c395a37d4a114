"""A text is read in blocks: what it holds doesn't depend on where they part it."""

from __future__ import annotations

import io

import numpy as np
import pytest
from exports import loop, text

from pipeclamp_identification.importing.formats import text as reader
from pipeclamp_identification.importing.texts.decoding import text_blocks


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_blocks_join_to_the_text(encoding, end):
    whole = "".join(f"{number};Prüfung µ {number}\n" for number in range(60))
    content = whole.replace("\n", end).encode(encoding)
    for size in (7, 64, 1000, 10_000):
        pieces = [piece for piece, _ in text_blocks(io.BytesIO(content), size, 10**6)]
        assert "\n".join(piece.removesuffix("\n") for piece in pieces) == whole.removesuffix("\n")


def over_midnight(seconds: float) -> str:
    return f"{int(23 + (3590 + seconds) // 3600) % 24:02d}:{int((3590 + seconds) // 60) % 60:02d}:" + (
        f"{(50 + seconds) % 60:06.3f}"
    )


@pytest.mark.parametrize("options", [{}, {"decimal": "."}, {"stamp": over_midnight, "names": "Zeit;Weg [mm];F [kN]"}])
def test_a_table_is_the_same_in_blocks_of_any_size(options, tmp_path, monkeypatch):
    path = tmp_path / "a.csv"
    content = text(loop(0.5, 1.0, cycles=20), **options)
    path.write_text(content + "\nend of block\n\n" + content.split("\n", 5)[5])
    (tables := []).extend(reader.read(path))
    assert len(tables) == 2
    monkeypatch.setattr(reader, "BLOCK", 3000)
    for one, other in zip(tables, reader.read(path), strict=True):
        assert (one.name, one.first_row, one.read_as) == (other.name, other.first_row, other.read_as)
        for mine, theirs in zip(one.channels, other.channels, strict=True):
            assert mine.heading == theirs.heading
            np.testing.assert_array_equal(mine.values, theirs.values)
