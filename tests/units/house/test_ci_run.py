"""What .ci/run runs again with further packages is all that skips without them."""

import pytest
from project import ROOT

SCRIPT = ROOT / ".ci" / "run"


def test_importers_that_skip_without_a_package_run_again_with_it():
    if not SCRIPT.is_file():
        pytest.skip("a source archive has no .ci")
    script = SCRIPT.read_text(encoding="utf-8").partition("importers, and a Dask cluster")[2]
    files = {file: file.read_text(encoding="utf-8") for file in (ROOT / "tests" / "importers").glob("test_*.py")}
    skipping = [
        file.stem.removeprefix("test_")
        for file, text in files.items()
        if "isn't installed: pip install" in text or "from masters import" in text
    ]
    assert len(skipping) > 5
    assert [name for name in skipping if name not in script] == []
