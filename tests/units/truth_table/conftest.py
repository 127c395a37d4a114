"""The truth table's modules, which are no package, can be imported."""

import pytest
from project import TRUTH_TABLE


@pytest.fixture(autouse=True, scope="module")
def table_on_path():
    """For a module's own fixtures, too, whichever of its tests runs first."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(TRUTH_TABLE)
        yield
