"""Campaigns that change while files are imported into them: by another import, or in an editor."""

from __future__ import annotations

import pytest
from exports import loop, text

import pipeclamp as pc
from pipeclamp_models.base.errors import UserError


@pytest.mark.parametrize("there_before", [False, True])
def test_an_import_takes_nothing_of_another_that_ran_meanwhile(tmp_path, there_before):
    """The later one had put its own campaign in place: the runs of the other were gone, and both had said `done`."""
    for number, amplitude in enumerate((0.3, 0.5, 0.8)):
        (tmp_path / f"{number}.csv").write_text(text(loop(amplitude)))
    campaign = tmp_path / "c"
    if there_before:
        pc.import_files(tmp_path / "0.csv", campaign)

    def meanwhile(words: str) -> None:
        if words == "its page":
            pc.import_files(tmp_path / "1.csv", campaign)

    with pytest.raises(UserError, match="changed while this import ran"):
        pc.import_files(tmp_path / "2.csv", campaign, progress=meanwhile)
    assert len(pc.read_campaign(campaign)) == 1 + there_before
    pc.import_files(tmp_path / "2.csv", campaign)
    assert len(pc.read_campaign(campaign)) == 2 + there_before


def test_a_row_that_is_edited_while_an_import_asks_stays(tmp_path):
    (tmp_path / "0.csv").write_text(text(loop()))
    (tmp_path / "1.csv").write_text(text(loop(0.8)))
    campaign = tmp_path / "c"
    pc.import_files(tmp_path / "0.csv", campaign)
    table = campaign / "runs.csv"

    def meanwhile(words: str) -> None:
        if words == "its page":
            header, row = table.read_text().splitlines()
            table.write_text(f"{header},temperature_C\n{row},21.5\n")

    with pytest.raises(UserError, match="in an editor; nothing was written"):
        pc.import_files(tmp_path / "1.csv", campaign, progress=meanwhile)
    assert table.read_text().splitlines()[1].endswith("21.5")
