"""The truth table's modules, which are no package, can be imported."""

import pytest
from project import TRUTH_TABLE


@pytest.fixture(autouse=True)
def table_on_path(monkeypatch):
    monkeypatch.syspath_prepend(TRUTH_TABLE)
