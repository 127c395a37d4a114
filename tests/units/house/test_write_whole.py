"""Files on every system: replaced while somebody reads them, which Windows refuses, and names that it takes, too."""

import errno
import os
from pathlib import Path

import pytest

from pipeclamp_models.base import files
from pipeclamp_models.base.errors import UserError


@pytest.mark.parametrize(("refusals", "written"), [(2, "new"), (100, "old")])
def test_it_is_tried_again_for_a_while(tmp_path, monkeypatch, refusals, written):
    path, replace, waited = tmp_path / "law.json", Path.replace, []
    path.write_text("old", encoding="utf-8")

    def refused(temporary, target):
        if len(waited) < refusals:
            raise PermissionError(13, "Permission denied")
        return replace(temporary, target)

    monkeypatch.setattr(Path, "replace", refused)
    monkeypatch.setattr(files.time, "sleep", waited.append)
    if written == "new":
        files.write_whole(path, "new")
    else:
        with pytest.raises(UserError, match="can't be written"):
            files.write_whole(path, "new")
    assert path.read_text(encoding="utf-8") == written
    assert [each.name for each in tmp_path.iterdir()] == ["law.json"]


@pytest.mark.skipif(os.name == "nt", reason="links need rights there")
def test_what_a_link_leads_to_is_written(tmp_path):
    (tmp_path / "kept").mkdir()
    (tmp_path / "kept" / "law.json").write_text("old", encoding="utf-8")
    link, circle = tmp_path / "law.json", tmp_path / "circle.json"
    link.symlink_to(Path("kept", "law.json"))
    circle.symlink_to(circle)
    for path in (link, circle):
        files.write_whole(path, "new")
        assert path.read_text(encoding="utf-8") == "new"
    assert link.is_symlink()
    assert [each.name for each in (tmp_path / "kept").iterdir()] == ["law.json"]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes among files")
def test_no_file_takes_the_place_of_a_device_or_pipe(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", Path("/dev/stdout"), Path("/dev/null")):
        with pytest.raises(UserError, match="is a device or a pipe; expected the name of a file"):
            files.refuse_file(path)


def test_what_stands_beside_the_folder_that_one_is_in(tmp_path, monkeypatch):
    (tmp_path / "tests").mkdir()
    monkeypatch.chdir(tmp_path / "tests")
    for folder in (Path(), Path("../tests"), tmp_path / "tests"):
        assert files.set_aside(folder).resolve() == tmp_path / ".tests.before"


@pytest.mark.parametrize("refuse", [files.refuse_file, files.refuse_folder])
def test_what_cant_be_written_is_refused_before_the_work(tmp_path, monkeypatch, refuse):
    refuse(tmp_path / "law.json")
    assert list(tmp_path.iterdir()) == []

    def read_only(dir):
        raise OSError(30, "Read-only file system")

    monkeypatch.setattr(files.tempfile, "TemporaryFile", read_only)
    with pytest.raises(UserError, match=r"law\.json: can't write there \(Read-only file system\); expected an"):
        refuse(tmp_path / "law.json")


@pytest.mark.parametrize(
    ("names", "stems"),
    [
        (["S1", "S2"], ["S1", "S2"]),
        (["a/b", "a:b", "A b"], ["a_b", "a_b_", "A_b__"]),
        (["con", "LPT1", "x" * 90], ["con_", "LPT1_", "x" * 60]),
        (["Größe", "***"], ["Gr_e", "group"]),
    ],
)
def test_names_of_files_are_safe_on_every_system(names, stems):
    assert files.plain_stems(names) == stems


def test_a_full_disk_is_told_with_the_place_and_what_to_do(tmp_path):
    """It had been `[Errno 28] No space left on device`, without a word of where."""
    full = OSError(errno.ENOSPC, "No space left on device")
    told = r"camp: can't be written \(No space left on device\); expected room"
    with pytest.raises(UserError, match=told), files.staged_folder(tmp_path / "camp"):
        raise full
    assert not list(tmp_path.iterdir())
    with pytest.raises(OSError, match="Permission denied"), files.staged_folder(tmp_path / "camp"):
        raise PermissionError(errno.EACCES, "Permission denied")
