"""Where our own masters unpack FMUs whose temporary folder has a path that pythonfmu can't stand."""

import tempfile

import pytest

from pipeclamp_models.base.errors import UserError
from pipeclamp_system.fmus import unpacking

ODD = ("Jörg", "a+b", "Program Files (x86)", "100%25")


@pytest.fixture(params=ODD)
def odd(request, tmp_path, monkeypatch):
    """Make a temporary folder with an odd name the usual one."""
    folder = tmp_path / request.param
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


def test_a_python_fmu_runs_from_elsewhere(odd, fmus, drive):
    folder = unpacking.unpacking_folder([fmus["memory"]])
    assert odd not in folder.parents
    folder.rmdir()
    drive("memory").step(1e-3, flange__s=1e-4)
    assert list(odd.iterdir()) == []


def test_without_another_folder_it_is_refused(odd, fmus, monkeypatch):
    monkeypatch.setattr(unpacking, "_others", tuple)
    with pytest.raises(UserError, match="TMPDIR to name another folder, or FMUs built with --kind native"):
        unpacking.unpacking_folder([fmus["memory"]])


def test_a_native_fmu_runs_there(odd, native_fmus, drive):
    folder = unpacking.unpacking_folder([native_fmus[2]])
    assert odd in folder.parents
    drive(native_fmus[2]).step(1e-3, flange__s=1e-4)


def test_spaces_are_plain(tmp_path, fmus, drive, monkeypatch):
    folder = tmp_path / "a space"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    assert folder in unpacking.unpacking_folder([fmus["memory"]]).parents
    drive("memory").step(1e-3, flange__s=1e-4)
